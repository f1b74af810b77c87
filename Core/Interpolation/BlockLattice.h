// The lattice of places, their children and vertices that block values are found on, as indices and bit masks.
//
// In and around an inner node lie 4 x 4 x 4 places of its children's size: along each axis place 0 is the upper child
// of the lower neighbour, 1 and 2 are the children of the node itself, 3 is the lower child of the upper neighbour.
// Vertices 0 to 4 lie half a place apart. An even one, 2 p, is between the places p and p + 1, an odd one, 2 p - 1, in
// the middle of place p; either is between the children v + 1 and v + 2 of places, of which there are 8 x 8 x 8.
#pragma once

#include "Geometry/Octant.h"

#include <array>
#include <bit>
#include <cstdint>
#include <utility>

namespace treeamr::block
{

/// Of places, vertices and children along an edge, and of all.
inline constexpr int placesPerEdge = 4;
inline constexpr int verticesPerEdge = 5;
inline constexpr int placeCount = placesPerEdge * placesPerEdge * placesPerEdge;
inline constexpr int vertexCount = verticesPerEdge * verticesPerEdge * verticesPerEdge;
inline constexpr int childCount = 8 * placeCount;

/// By axis, of vertices.
inline constexpr std::array<int, 3> vertexStride{ 1, verticesPerEdge, verticesPerEdge* verticesPerEdge };

/// By axis the places that are not the last along it, and the two in the middle.
inline constexpr std::array<std::uint64_t, 3> lowerPlaces{ 0x7777777777777777, 0x0fff0fff0fff0fff,
  0x0000ffffffffffff };
inline constexpr std::array<std::uint64_t, 3> innerPlaces{ 0x6666666666666666, 0x0ff00ff00ff00ff0,
  0x0000ffffffff0000 };

/// For each mask of axes, of the vertices that lie between places along these alone: the bit of the place p that is
/// the first around each.
using VertexMask = std::array<std::uint64_t, 8>;

inline void add(VertexMask& mask, const VertexMask& more) noexcept
{
  for (int axes = 0; axes < 8; ++axes)
  {
    mask[axes] |= more[axes];
  }
}

inline VertexMask without(VertexMask mask, const VertexMask& others) noexcept
{
  for (int axes = 0; axes < 8; ++axes)
  {
    mask[axes] &= ~others[axes];
  }
  return mask;
}

inline VertexMask both(VertexMask a, const VertexMask& b) noexcept
{
  for (int axes = 0; axes < 8; ++axes)
  {
    a[axes] &= b[axes];
  }
  return a;
}

inline bool isEmpty(const VertexMask& mask) noexcept
{
  std::uint64_t any = 0;
  for (const std::uint64_t vertices : mask)
  {
    any |= vertices;
  }
  return any == 0;
}

constexpr int placeIndex(int x, int y, int z)
{
  return x + placesPerEdge * (y + placesPerEdge * z);
}

/// Among the children of all places.
constexpr int childIndex(int x, int y, int z)
{
  return x + 2 * placesPerEdge * (y + 2 * placesPerEdge * z);
}

constexpr int vertexIndex(int x, int y, int z)
{
  return x + verticesPerEdge * (y + verticesPerEdge * z);
}

/// First child of a place.
constexpr int firstChild(int place)
{
  return childIndex(2 * (place & 3), 2 * (place >> 2 & 3), 2 * (place >> 4));
}

/// Corner `part` of those along the axes of a mask, as a step among a level's children.
constexpr int stepAlong(unsigned axes, int part)
{
  int step = 0;
  for (int a = 0; a < 3; ++a)
  {
    if (axes >> a & 1)
    {
      step += (part & 1) << 3 * a;
      part >>= 1;
    }
  }
  return step;
}

/// Vertex 1 along the axes that are not in a mask, 0 along the others.
constexpr int middleVertex(unsigned axes)
{
  return vertexIndex(axes & 1 ? 0 : 1, axes & 2 ? 0 : 1, axes & 4 ? 0 : 1);
}

/// The first of the eight children of places around a vertex, by its axes and first place.
constexpr int childBefore(unsigned axes, int place)
{
  return firstChild(place) + stepAlong(axes, 7);
}

struct Tables
{
  std::array<std::uint8_t, placeCount> childrenOfPlace{}; // masks of those that touch any vertex
  std::array<std::uint8_t, placeCount> halfVertex{};      // half the index of the even vertex 2 p
  std::array<VertexMask, 8> ofChild{};                    // a child's own vertices
};

constexpr Tables makeTables()
{
  Tables t{};
  for (int place = 0; place < placeCount; ++place)
  {
    const std::array<int, 3> at{ place & 3, place >> 2 & 3, place >> 4 };
    t.halfVertex[place] = static_cast<std::uint8_t>(vertexIndex(at[0], at[1], at[2]));
    for (int o = 0; o < 8; ++o)
    {
      bool touches = true;
      for (int a = 0; a < 3; ++a)
      {
        touches = touches && (o >> a & 1 ? at[a] != 3 : at[a] != 0);
      }
      t.childrenOfPlace[place] |= static_cast<std::uint8_t>(touches << o);
      for (unsigned axes = 0; axes < 8; ++axes)
      {
        bool own = true;
        for (int a = 0; a < 3; ++a)
        {
          const int upper = o >> a & 1;
          own = own && (at[a] == upper + 1 || (at[a] == upper && (axes >> a & 1)));
        }
        t.ofChild[o][axes] |= static_cast<std::uint64_t>(own) << place;
      }
    }
  }
  return t;
}

inline constexpr Tables tables = makeTables();

/// The index of a vertex, from its axes and first place.
inline int vertexOf(unsigned axes, int place) noexcept
{
  return 2 * tables.halfVertex[place] - middleVertex(axes);
}

/// Calls f<axes>() for all.
template <class F>
void forAxes(const F& f) noexcept
{
  [&]<unsigned... Axes>(std::integer_sequence<unsigned, Axes...>)
  {
    (f.template operator()<Axes>(), ...);
  }
  (std::make_integer_sequence<unsigned, 8>());
}

/// Calls f(place) for those in a mask.
template <class F>
void forEachPlace(std::uint64_t places, const F& f) noexcept
{
  for (; places != 0; places &= places - 1)
  {
    f(std::countr_zero(places));
  }
}

inline VertexMask verticesTouching(std::uint64_t places) noexcept
{
  // Along an axis three vertices lie between places, and two in the middle of the inner ones.
  VertexMask mask;
  mask[0] = places;
  for (int a = 0; a < 3; ++a)
  {
    for (int axes = 0; axes < 1 << a; ++axes)
    {
      mask[axes | 1 << a] = (mask[axes] | mask[axes] >> (1 << 2 * a)) & lowerPlaces[a];
      mask[axes] &= innerPlaces[a];
    }
  }
  return mask;
}

/// Of a node's children.
inline VertexMask verticesOf(unsigned children) noexcept
{
  const std::uint64_t places = (children & 3) | (children & 12) << 2 |
    static_cast<std::uint64_t>((children & 48) | (children & 192) << 2) << 12;
  return verticesTouching(places << placeIndex(1, 1, 1));
}

/// The places and those that share a vertex of the block with one.
inline std::uint64_t withNeighbours(std::uint64_t places) noexcept
{
  places |= (places & lowerPlaces[0]) << 1 | (places >> 1 & lowerPlaces[0]);
  places |= (places & lowerPlaces[1]) << 4 | (places >> 4 & lowerPlaces[1]);
  return places | places << 16 | places >> 16;
}

/// A child's place 0 as a place of its parent's level: its neighbourhood's first entry.
constexpr int firstEntry(int octant)
{
  return placeIndex(sideOf(octant, 0), sideOf(octant, 1), sideOf(octant, 2));
}

/// The places of the neighbourhood that begins at place 0: three along each axis.
inline constexpr std::uint64_t neighbourhoodPlaces = 0x077707770777;

/// The 3 x 3 x 3 places that are the neighbourhood of a child.
inline std::uint64_t entriesOf(std::uint64_t places, int octant) noexcept
{
  return places >> firstEntry(octant) & neighbourhoodPlaces;
}

/// The places of a node's level that the entries of its neighbourhood cover.
inline std::uint64_t placesOf(std::uint64_t entries) noexcept
{
  // Axis by axis, of three entries the first two are covered by the first two places, the last two by the last.
  const std::uint64_t x = (entries & 0x033303330333) | (entries & 0x066606660666) << 1;
  const std::uint64_t xy = (x & 0x00ff00ff00ff) | (x & 0x0ff00ff00ff0) << 4;
  return (xy & 0x0000ffffffff) | (xy & 0xffffffff0000) << 16;
}

/// First of the children of a level's places that are the places of a child's level.
constexpr int firstPlace(int octant)
{
  return childIndex(1 + 2 * sideOf(octant, 0), 1 + 2 * sideOf(octant, 1), 1 + 2 * sideOf(octant, 2));
}

/// From masks of a level's children those of a child's places.
inline std::uint64_t placesOf(const std::array<std::uint64_t, 8>& children, int octant) noexcept
{
  const int first = firstPlace(octant);
  std::uint64_t places = 0;
  for (int z = 0; z < 4; ++z)
  {
    // Four rows of four bits in eight are packed into sixteen bits.
    std::uint64_t rows = children[(first >> 6) + z] >> (first & 63) & 0x0f0f0f0f;
    rows = (rows | rows >> 4) & 0x00ff00ff;
    places |= ((rows | rows >> 8) & 0xffff) << 16 * z;
  }
  return places;
}

/// Adds a mask of a place's children to those of a level.
inline void addChildren(std::array<std::uint64_t, 8>& masks, int place, unsigned children) noexcept
{
  const int first = firstChild(place);
  const auto rows = [&](std::uint64_t four) { return ((four & 3) | (four & 12) << 6) << (first & 63); };
  masks[first >> 6] |= rows(children & 15);
  masks[(first >> 6) + 1] |= rows(children >> 4);
}

/// Of the places around a vertex, in their order, from a mask that starts at the first of them.
template <unsigned Axes>
unsigned aroundVertex(std::uint64_t places) noexcept
{
  if constexpr (Axes == 0)
  {
    return places & 1;
  }
  else
  {
    // The highest axis joins two halves that lie 1, 4 or 16 places apart.
    constexpr int axis = std::bit_width(Axes) - 1;
    constexpr unsigned rest = Axes & ~(1u << axis);
    return aroundVertex<rest>(places) |
      aroundVertex<rest>(places >> (1 << 2 * axis)) << (1 << std::popcount(rest));
  }
}

} // namespace treeamr::block

// One piece of the field, an octant or dual cell: a box with eight corner values, trilinear between them, and its contour lines on
// its faces.
#pragma once

#include "Geometry/Trilinear.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace treeamr
{

/// Corners: bit a of the number is the side along axis a. Edges: 4 * axis + the sides along the two next axes
/// (cyclic), the nearer one first. Faces: 2 * axis + side.
struct OctantTables
{
  struct Edge
  {
    std::uint8_t axis;
    std::uint8_t low; // corners
    std::uint8_t high;
    std::uint8_t faces; // mask of the two
  };
  struct Face
  {
    // Both counter-clockwise seen from outside: edge i goes from corner i to corner i + 1.
    std::array<std::uint8_t, 4> corner;
    std::array<std::uint8_t, 4> edge;
  };
  std::array<Edge, 12> edge{};
  std::array<Face, 6> face{};
};

constexpr OctantTables makeOctantTables()
{
  OctantTables t{};
  const auto edgeOf = [](int p, int q) {
    const int axis = (p ^ q) == 1 ? 0 : (p ^ q) == 2 ? 1 : 2;
    return 4 * axis + (p >> (axis + 1) % 3 & 1) + 2 * (p >> (axis + 2) % 3 & 1);
  };
  for (int e = 0; e < 12; ++e)
  {
    const int axis = e >> 2;
    const int b = (axis + 1) % 3;
    const int c = (axis + 2) % 3;
    const int low = (e & 1) << b | (e >> 1 & 1) << c;
    t.edge[e] = { static_cast<std::uint8_t>(axis), static_cast<std::uint8_t>(low),
      static_cast<std::uint8_t>(low | 1 << axis),
      static_cast<std::uint8_t>(1 << (2 * b + (e & 1)) | 1 << (2 * c + (e >> 1 & 1))) };
  }
  for (int f = 0; f < 6; ++f)
  {
    const int axis = f >> 1;
    const int b = 1 << (f & 1 ? (axis + 1) % 3 : (axis + 2) % 3);
    const int c = 1 << (f & 1 ? (axis + 2) % 3 : (axis + 1) % 3);
    const int base = (f & 1) << axis;
    const std::array<int, 4> corners{ base, base | b, base | b | c, base | c };
    for (int i = 0; i < 4; ++i)
    {
      t.face[f].corner[i] = static_cast<std::uint8_t>(corners[i]);
      t.face[f].edge[i] = static_cast<std::uint8_t>(edgeOf(corners[i], corners[(i + 1) % 4]));
    }
  }
  return t;
}

inline constexpr OctantTables octantTables = makeOctantTables();

/// Corner values minus the isovalue; from 0 up is inside.
using PieceValues = Corners;

inline unsigned insideCorners(const PieceValues& values) noexcept
{
  unsigned mask = 0;
  for (int c = 0; c < 8; ++c)
  {
    mask |= static_cast<unsigned>(values[c] >= 0.) << c;
  }
  return mask;
}

/// A contour line on a face, from the edge where the corners counter-clockwise around the face, seen from
/// outside, come in to the one where they go out again. So the lines of all faces form loops around which the
/// surface's normal, by the right-hand rule, points outside.
struct FaceSegments
{
  int count = 0;
  std::array<std::uint8_t, 2> from{}; // edges
  std::array<std::uint8_t, 2> to{};
};

/// Where the corners alternate, the bilinear function's saddle decides which are joined (Nielson and Hamann
/// 1991). The neighbour that shares the four values decides likewise.
inline FaceSegments faceSegments(int face, unsigned inside, const PieceValues& values) noexcept
{
  const OctantTables::Face& f = octantTables.face[face];
  std::array<bool, 4> in;
  for (int i = 0; i < 4; ++i)
  {
    in[i] = inside >> f.corner[i] & 1;
  }
  FaceSegments segments;
  const auto add = [&](int from, int to) {
    segments.from[segments.count] = f.edge[from];
    segments.to[segments.count++] = f.edge[to];
  };
  if (in[0] == in[2] && in[1] == in[3] && in[0] != in[1])
  {
    const int first = in[0] ? 0 : 1; // corners inside: this and the opposite one
    const auto product = [&](int i) { return values[f.corner[i]] * values[f.corner[i + 2]]; };
    const bool joined = product(first) >= product(1 - first);
    for (int i = first; i < 4; i += 2)
    {
      add((i + 3) % 4, joined ? (i + 2) % 4 : i);
    }
    return segments;
  }
  int from = -1;
  int to = -1;
  for (int i = 0; i < 4; ++i)
  {
    if (in[i] != in[(i + 1) % 4])
    {
      (in[i] ? to : from) = i;
    }
  }
  if (from >= 0)
  {
    add(from, to);
  }
  return segments;
}

/// Of an edge where it crosses, from the lower end, 0 to 1.
inline double crossing(const PieceValues& values, int edge) noexcept
{
  constexpr double margin = 0x1p-24;
  const double low = values[octantTables.edge[edge].low];
  const double high = values[octantTables.edge[edge].high];
  const double t = low / (low - high);
  return t < margin ? margin : t > 1. - margin ? 1. - margin : t;
}

/// The point of a short loop around the piece from which diagonals divide it into triangles, the one with the
/// shortest. faces: masks of those that a point lies on; no diagonal may lie on a face, where the neighbour
/// could have the same. -1: there is none, the loop needs a centre.
inline int fanApex(const std::array<double, 3>* loop, const std::uint8_t* faces, int count) noexcept
{
  constexpr int shortLoop = 6; // longer ones are round rather than flat
  int best = -1;
  double shortest = 0.;
  for (int apex = 0; count <= shortLoop && apex < count; ++apex)
  {
    double sum = 0.;
    bool allowed = true;
    for (int i = 2; i + 1 < count; ++i)
    {
      const int other = (apex + i) % count;
      allowed = allowed && (faces[apex] & faces[other]) == 0;
      for (int a = 0; a < 3; ++a)
      {
        const double d = loop[apex][a] - loop[other][a];
        sum += d * d;
      }
    }
    if (allowed && (best < 0 || sum < shortest))
    {
      best = apex;
      shortest = sum;
    }
  }
  return best;
}

/// A point of the trilinear surface near the middle of a loop on the octant's boundary, inside the loop's
/// box: by Newton's method along the gradient, with shorter steps towards the walls.
inline std::array<double, 3> loopCentre(
  const PieceValues& values, const std::array<double, 3>* loop, int count) noexcept
{
  std::array<double, 3> p{};
  std::array<double, 3> low = loop[0];
  std::array<double, 3> high = loop[0];
  for (int i = 0; i < count; ++i)
  {
    for (int a = 0; a < 3; ++a)
    {
      p[a] += loop[i][a] / count;
      low[a] = loop[i][a] < low[a] ? loop[i][a] : low[a];
      high[a] = loop[i][a] > high[a] ? loop[i][a] : high[a];
    }
  }
  for (int step = 0; step < 4; ++step)
  {
    const double value = trilinear(values, p);
    const std::array<double, 3> g = trilinearGradient(values, p);
    const double square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    if (!(square > 0.))
    {
      return p;
    }
    std::array<double, 3> d;
    double share = 1.;
    for (int a = 0; a < 3; ++a)
    {
      d[a] = -value * (g[a] / square);
      const double room = 0.9 * ((d[a] < 0. ? low[a] : high[a]) - p[a]);
      share = std::abs(d[a]) * share > std::abs(room) ? room / d[a] : share;
    }
    for (int a = 0; a < 3; ++a)
    {
      p[a] += share * d[a];
    }
  }
  return p;
}

} // namespace treeamr

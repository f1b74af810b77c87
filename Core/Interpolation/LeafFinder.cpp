#include "Interpolation/LeafFinder.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeamr
{

LeafFinder::LeafFinder(const Octree& octree) noexcept
  : octree_(octree)
  , finestDepth_(octree.grid().paddingDepth() + octree.leafLevels())
  , perRoot_(std::ldexp(1., octree.leafLevels()))
{
}

bool LeafFinder::find(const Vec3& pWorld, Leaf& leaf) noexcept
{
  if (octree_.root().isNone())
  {
    return false;
  }
  // Whole numbers and the rest, apart: together they have more digits than a double at deep levels.
  std::array<Coord, 3> plane; // of the finest lattice, at the point or below it
  Vec3 beyond;                // it, in finest cells
  unsigned onPlane = 0;
  for (int a = 0; a < 3; ++a)
  {
    const double root = octree_.grid().latticeCoordinate(a, pWorld[a]);
    if (!(root >= 0.))
    {
      return false;
    }
    const double finest = root * perRoot_;
    plane[a] = static_cast<Coord>(finest);
    beyond[a] = finest - static_cast<double>(plane[a]);
    onPlane |= static_cast<unsigned>(beyond[a] == 0.) << a;
  }
  // More than one try only where a point lies on a plane, as its first leaf may be missing.
  for (unsigned lower = 0; lower < 8; ++lower)
  {
    if ((lower & ~onPlane) != 0)
    {
      continue;
    }
    std::array<Coord, 3> finest;
    for (int a = 0; a < 3; ++a)
    {
      const Coord last = (Coord(1) << finestDepth_) - 1;
      finest[a] = std::clamp<Coord>(plane[a] - (lower >> a & 1), 0, last);
    }
    if (descendTo(finest, leaf))
    {
      const int above = finestDepth_ - leaf.depth;
      const double cells = static_cast<double>(Coord(1) << above);
      for (int a = 0; a < 3; ++a)
      {
        leaf.place[a] = (static_cast<double>(plane[a] - (leaf.index[a] << above)) + beyond[a]) / cells;
      }
      return true;
    }
  }
  return false;
}

/// finest: index of a cell of the finest depth, which may be part of the leaf.
bool LeafFinder::descendTo(const std::array<Coord, 3>& finest, Leaf& leaf) noexcept
{
  if (octree_.root().isLeaf())
  {
    leaf.depth = 0;
    leaf.index = {};
    return true;
  }
  std::uint64_t differing = 0;
  for (int a = 0; a < 3; ++a)
  {
    differing |= static_cast<std::uint64_t>(finest[a] >> (finestDepth_ - path_.depth) ^ index_[a]);
  }
  const int up = static_cast<int>(std::bit_width(differing));
  path_.depth -= up;
  for (Coord& i : index_)
  {
    i >>= up;
  }
  for (;;)
  {
    const int octant = octantAbove(finest, finestDepth_ - path_.depth - 1);
    const Octree::Children children = octree_.children(path_.node[path_.depth]);
    if (!(children.inner() >> octant & 1))
    {
      leaf.depth = path_.depth + 1;
      leaf.index = indexOfChild(index_, octant);
      return children.leaf >> octant & 1;
    }
    index_ = indexOfChild(index_, octant);
    path_.descend(octant, children.innerIndex(octant));
  }
}

} // namespace treeamr

// The corners of a node's children by their places, 0 to 2 along each axis in widths of a child, and the cells of the
// children's size around them, which are -1 to 2 along each axis.
#pragma once

#include "Octree/TreePath.h"

#include <array>
#include <bit>

namespace treeamr
{

/// Of a node's 27 corners, x + 3 y + 9 z.
inline constexpr std::array<int, 3> familyStride{ 1, 3, 9 };

using CornerPlace = std::array<int, 3>;

constexpr CornerPlace placeOfCorner(int vertex) noexcept
{
  return { vertex % 3, vertex / 3 % 3, vertex / 9 };
}

/// The cell at a side of a corner, which has the corner 7 - side there.
constexpr std::array<int, 3> cellBeside(const CornerPlace& at, int side) noexcept
{
  return { at[0] - 1 + sideOf(side, 0), at[1] - 1 + sideOf(side, 1), at[2] - 1 + sideOf(side, 2) };
}

/// The entry of the neighbourhood that a cell is in, and as which child.
struct ChildPlace
{
  int entry = 0;
  int octant = 0;

  explicit constexpr ChildPlace(const std::array<int, 3>& cell) noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      entry += familyStride[a] * ((cell[a] + 2) >> 1);
      octant |= (cell[a] & 1) << a;
    }
  }
};

/// Whether a leaf larger than the children of the path's node at a depth touches the corner.
inline bool touchesCoarser(const TreePath& path, int depth, const CornerPlace& at) noexcept
{
  bool touches = false;
  for (int side = 0; side < 8; ++side)
  {
    touches = touches || path.around(depth)[ChildPlace(cellBeside(at, side)).entry].isLeaf();
  }
  return touches;
}

/// Calls f(vertex) for those from `low` on that lie at both sides along each of some axes, a mask, and returns their number.
template <class F>
int forSides(int low, unsigned axes, const F& f)
{
  for (unsigned sides = axes; sides != 0; sides = (sides - 1) & axes)
  {
    f(low + cornerOffset(static_cast<int>(sides), familyStride));
  }
  f(low);
  return 1 << std::popcount(axes);
}

/// The same for the corners of the next coarser level that a corner lies halfway between.
template <class F>
int forCoarserCorners(const TreePath& path, int depth, const CornerPlace& at, const F& f)
{
  const int octant = octantAbove(path.index(depth), 0);
  int low = 0;
  unsigned halfway = 0; // mask of axes
  for (int a = 0; a < 3; ++a)
  {
    const int twice = at[a] + 2 * sideOf(octant, a);
    low += familyStride[a] * (twice >> 1);
    halfway |= static_cast<unsigned>(twice & 1) << a;
  }
  return forSides(low, halfway, f);
}

} // namespace treeamr

// A box on the lattice of a level: what one of many processes draws.
#pragma once

#include "Octree/RootGrid.h"

#include <algorithm>
#include <array>

namespace treeamr
{

/// The cells of a level from begin up to, but without, end along each axis.
struct LatticeBox
{
  int level = 0;                // whose lattice it is, 0: that of the roots
  std::array<Coord, 3> begin{}; // x, y, z
  std::array<Coord, 3> end{};   // x, y, z

  bool operator==(const LatticeBox&) const = default;

  /// Whether it has no cell.
  bool isEmpty() const noexcept { return begin[0] >= end[0] || begin[1] >= end[1] || begin[2] >= end[2]; }
  /// Whether they have a volume in common.
  bool meets(const CellId& cell) const noexcept
  {
    return allAxes(
      cell, [](Coord first, Coord last, Coord from, Coord to) { return first < to && last > from; });
  }
  /// The same, or it touches one of the lower faces.
  bool reaches(const CellId& cell) const noexcept
  {
    return allAxes(
      cell, [](Coord first, Coord last, Coord from, Coord to) { return first < to && last >= from; });
  }
  /// Whether all of the cell is inside.
  bool contains(const CellId& cell) const noexcept
  {
    return allAxes(
      cell, [](Coord first, Coord last, Coord from, Coord to) { return first >= from && last <= to; });
  }
  /// Whether the cell's lower corner is inside: so of boxes that fill the domain one owns it.
  bool owns(const CellId& cell) const noexcept
  {
    return allAxes(
      cell, [](Coord first, Coord /*last*/, Coord from, Coord to) { return first >= from && first < to; });
  }
  /// In the world.
  Bounds bounds(const RootGrid& grid) const noexcept
  {
    Bounds bounds;
    for (int a = 0; a < 3; ++a)
    {
      bounds.min[a] = grid.worldPlane(a, begin[a], level);
      bounds.max[a] = grid.worldPlane(a, end[a], level);
    }
    return bounds;
  }

private:
  /// test(first, last, begin, end) of the cell's planes and the box's, on the finer of the two lattices.
  template <class Test>
  bool allAxes(const CellId& cell, const Test& test) const noexcept
  {
    const int down = std::max(0, level - cell.level);
    const int up = std::max(0, cell.level - level);
    for (int a = 0; a < 3; ++a)
    {
      if (begin[a] >= end[a] ||
        !test(cell.index[a] << down, (cell.index[a] + 1) << down, begin[a] << up, end[a] << up))
      {
        return false;
      }
    }
    return true;
  }
};

} // namespace treeamr

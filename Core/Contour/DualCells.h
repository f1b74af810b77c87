// Where a block's octants join to dual cells.
//
// Around a vertex where eight leaves of one size meet, GTI is trilinear between their centres: its eight
// octants are one dual cell (the paper's section 6.2.1) with an eighth of the work and of the triangles. What
// neighbours it in the same leaves are octants of half its size or other dual cells.
#pragma once

#include "Field/Field.h"
#include "Octree/TreePath.h"

#include <array>

namespace treeamr
{

/// Vertices count in widths of the block's children from its lower corner. Dual cells are made of the
/// children of blocks that have eight drawn leaves: single ones beside cells of other sizes would save
/// nothing. Nor are they where roots of unequal sizes meet, as the field has a kink there.
class DualCells
{
public:
  /// Of the block at the path's end and those around.
  void find(const TreePath& path, const Field& field);
  /// vertex: from -1 to 3.
  bool has(const std::array<int, 3>& vertex) const noexcept
  {
    return has_[vertex[1] + 1 + 5 * (vertex[2] + 1)] >> (vertex[0] + 1) & 1;
  }
  /// Of the leaves around a vertex from 0 to 2 that has a dual cell, x fastest.
  std::array<float, 8> values(const std::array<int, 3>& vertex) const noexcept;

private:
  void gatherBlocks(const TreePath& path, const Field& field);
  void mark(const RootGrid& grid, const TreePath& path) noexcept;

  std::uint32_t plain_;              // the block and those around, a bit each: have eight drawn leaves
  std::array<float, 64> leafValues_; // of those in plain blocks, from -1 to 2
  std::array<std::uint8_t, 25> has_; // a bit per vertex, in rows along x
};

/// Up to eight blocks have octants of a dual cell, and some see no crossing in theirs: the one that has the
/// first octant with a crossing is sure to see it. The octants' vertices are means along one axis after the
/// other, bit for bit as in BlockEvaluator.
bool ownsDualCell(
  const std::array<int, 3>& vertex, const std::array<float, 8>& values, double isovalue) noexcept;

} // namespace treeamr

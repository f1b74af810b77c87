// The vertex values of all children of one inner node at once: what VertexValues.h gives leaf by leaf.
//
// The children's vertices form a lattice of 5 x 5 x 5 points, which eight leaves share: 125 values instead of
// 8 x 27, found from the 4 x 4 x 4 cells of the children's size in and around the node.
#pragma once

#include "Interpolation/VertexValues.h"

#include <array>

namespace treeamr
{

struct BlockValues
{
  /// Order x + 5 y + 25 z with x, y, z in 0 to 4 half widths of a child from the node's lower corner.
  /// Vertices that no drawn child has hold the lower end of the range.
  std::array<float, 125> values;
  Range range; // hull of the drawn children's vertex values
};

/// GTI at the vertices of the leaves among the children of an inner node, the same values bit for bit as
/// vertexValues() gives for each. A node without leaf children is drawn from its children's means and its
/// surroundings' (level of detail). The path must end at the inner node; it is back there afterwards.
class BlockEvaluator
{
public:
  explicit BlockEvaluator(const Field& field) noexcept
    : field_(field)
    , octree_(field.octree())
  {
  }
  void compute(TreePath& path, BlockValues& block) noexcept;
  /// The hull alone. Needs a leaf among the children.
  Range hull(TreePath& path) noexcept;

private:
  void gatherSlots(const TreePath& path) noexcept;
  void uniformValues() noexcept;
  void correctValues(const TreePath& path) noexcept;
  double onLattice(int vertex) const noexcept;
  double hanging(const TreePath& path, int vertex) noexcept;
  void leafByLeaf(TreePath& path) noexcept;
  void evaluate(TreePath& path) noexcept;
  Range rangeOfDrawn() const noexcept;

  const Field& field_;
  const Octree& octree_;
  VertexMemo memo_;

  // Of the node at hand: the 4 x 4 x 4 places of the children's size, x + 4 y + 16 z, as masks and values.
  std::uint64_t refined_; // inner nodes
  std::uint64_t coarse_;  // parts of coarser leaves
  std::uint64_t missing_;
  bool deepJump_; // some coarse leaf is larger than the node
  unsigned drawn_; // children whose vertices are wanted
  std::array<double, 64> slot_;
  std::array<std::uint64_t, 64> inner_; // index of the refined ones
  std::array<double, 125> values_;
};

} // namespace treeamr

// The immutable sparse octree: topology only, shared by every field that lives on it.
//
// Following the paper's section 4, but smaller: no records for leaves, 6 bytes for an inner node.
//
// The root lattice is embedded by padding to a power of two: a node's depth counts from the padded root, its
// level from its root tree (depth = RootGrid::paddingDepth() + level). Nothing is stored for the padding.
#pragma once

#include "Identity.h"
#include "Octree/ChildTable.h"
#include "Octree/RootGrid.h"

#include <cassert>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Which nodes there are, and which of them are leaves. Made by buildOctree(); never changes.
class Octree
{
public:
  static constexpr int maxDepth = 61; // of a leaf
  /// Of the inner nodes' children.
  using Table = ChildTable<std::uint16_t, 12>;

  /// Where it lies in the world.
  const RootGrid& grid() const noexcept { return grid_; }
  /// Tells octrees apart.
  const Identity& identity() const noexcept { return identity_; }
  ///@{
  /// Nodes of each kind.
  std::uint64_t leafCount() const noexcept { return leafCount_; }
  std::uint64_t innerCount() const noexcept { return table_.size(); }
  ///@}
  /// Deepest leaf's level; 0 when every root is a leaf.
  int leafLevels() const noexcept { return leafLevels_; }
  /// Inner nodes are in breadth-first order: those of a depth, from firstInner(depth) up to
  /// firstInner(depth + 1), 0 <= depth < innerDepths().
  int innerDepths() const noexcept { return static_cast<int>(firstInner_.size()) - 1; }
  /// The first inner node of a depth.
  std::uint64_t firstInner(int depth) const noexcept { return firstInner_[depth]; }
  /// None for an octree without cells.
  NodeRef root() const noexcept { return root_; }

  /// Which octants of an inner node there are, and the first ones' indices.
  using Children = treeamr::Children;
  /// Of an inner node, by its index.
  Children children(std::uint64_t inner) const noexcept { return table_.children(inner); }
  /// Announces that the children of an inner node will be asked for.
  void prefetchChildren(std::uint64_t inner) const noexcept { table_.prefetch(inner); }
  /// Octant o is at x = o & 1, y = o >> 1 & 1, z = o >> 2.
  NodeRef child(NodeRef parent, int octant) const noexcept
  {
    assert(parent.isInner());
    return children(parent.index()).node(octant, parent.depth() + 1);
  }

  /// Leaves that another process owns: they take part in the reconstruction and are not drawn.
  bool hasGhosts() const noexcept { return !ghosts_.empty(); }
  /// Whether a leaf, by its index, is one of these.
  bool isGhost(std::uint64_t leaf) const noexcept
  {
    return hasGhosts() && (ghosts_[leaf >> 6] >> (leaf & 63) & 1);
  }
  /// Whether an inner node's subtree has any.
  bool hasGhostsBelow(std::uint64_t inner) const noexcept
  {
    return hasGhosts() && (ghostsBelow_[inner >> 6] >> (inner & 63) & 1);
  }

  /// Allocated bytes.
  std::size_t byteSize() const noexcept;

private:
  explicit Octree(RootGrid grid)
    : grid_(std::move(grid))
  {
  }
  friend class OctreeAssembler;

  Identity identity_;
  RootGrid grid_;
  Table table_;
  std::vector<std::uint64_t> firstInner_{ 0 }; // by depth, and the end
  std::vector<std::uint64_t> ghosts_;          // a bit per leaf; empty: none is a ghost
  std::vector<std::uint64_t> ghostsBelow_;     // a bit per inner node; empty: none
  std::uint64_t leafCount_ = 0;
  int leafLevels_ = 0;
  NodeRef root_{};
};

} // namespace treeamr

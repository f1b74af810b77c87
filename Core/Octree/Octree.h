// The immutable sparse octree: topology only, shared by every field that lives on it.
//
// Following the paper's section 4, but smaller: no records for leaves, 6 bytes for an inner node.
//
// The root lattice is embedded by padding to a power of two: a node's depth counts from the padded root, its
// level from its root tree (depth = RootGrid::paddingDepth() + level). Nothing is stored for the padding.
#pragma once

#include "Octree/ChildTable.h"
#include "Octree/RootGrid.h"

#include <cassert>
#include <cstdint>
#include <vector>

namespace treeamr
{

enum class NodeKind : std::uint8_t
{
  None,
  Leaf,
  Inner
};

/// A node by kind, depth and index among the leaves or inner nodes of the octree.
class NodeRef
{
public:
  NodeRef() noexcept = default;
  constexpr NodeRef(NodeKind kind, int depth, std::uint64_t index) noexcept
    : bits_(static_cast<std::uint64_t>(kind) << 62 | static_cast<std::uint64_t>(depth) << 56 | index)
  {
  }
  constexpr NodeKind kind() const noexcept { return static_cast<NodeKind>(bits_ >> 62); }
  constexpr bool isNone() const noexcept { return kind() == NodeKind::None; }
  constexpr bool isLeaf() const noexcept { return kind() == NodeKind::Leaf; }
  constexpr bool isInner() const noexcept { return kind() == NodeKind::Inner; }
  constexpr int depth() const noexcept { return static_cast<int>(bits_ >> 56 & 63); }
  constexpr std::uint64_t index() const noexcept { return bits_ & ((std::uint64_t(1) << 56) - 1); }
  constexpr bool operator==(const NodeRef&) const noexcept = default;

private:
  std::uint64_t bits_; // uninitialised by default, none when value-initialised: paths hold thousands of these
};
static_assert(sizeof(NodeRef) == 8);

class Octree
{
public:
  static constexpr int maxDepth = 61;
  using Table = ChildTable<std::uint16_t, 12>;

  const RootGrid& grid() const noexcept { return grid_; }
  std::uint64_t leafCount() const noexcept { return leafCount_; }
  std::uint64_t innerCount() const noexcept { return table_.size(); }
  /// Deepest leaf's level; 0 when every root is a leaf.
  int leafLevels() const noexcept { return leafLevels_; }
  /// Inner nodes are in breadth-first order: those of a depth, from firstInner(depth) up to
  /// firstInner(depth + 1), 0 <= depth < innerDepths().
  int innerDepths() const noexcept { return static_cast<int>(firstInner_.size()) - 1; }
  std::uint64_t firstInner(int depth) const noexcept { return firstInner_[depth]; }
  /// None for an octree without cells.
  NodeRef root() const noexcept { return root_; }

  /// Octant o is at x = o & 1, y = o >> 1 & 1, z = o >> 2.
  NodeRef child(NodeRef parent, int octant) const noexcept
  {
    assert(parent.isInner());
    const std::uint64_t n = parent.index();
    const ChildMasks masks = table_.masks(n);
    if (masks.isLeaf(octant))
    {
      return { NodeKind::Leaf, parent.depth() + 1, table_.leafChild(n, octant) };
    }
    if (masks.isInner(octant))
    {
      return { NodeKind::Inner, parent.depth() + 1, table_.innerChild(n, octant) };
    }
    return {};
  }
  Table::Children children(std::uint64_t inner) const noexcept { return table_.children(inner); }

  /// Leaves that another process owns: they take part in the reconstruction and are not drawn.
  bool hasGhosts() const noexcept { return !ghosts_.empty(); }
  bool isGhost(std::uint64_t leaf) const noexcept
  {
    return hasGhosts() && (ghosts_[leaf >> 6] >> (leaf & 63) & 1);
  }

  /// Allocated bytes.
  std::size_t byteSize() const noexcept;

private:
  explicit Octree(RootGrid grid)
    : grid_(std::move(grid))
  {
  }
  friend class OctreeAssembler;

  RootGrid grid_;
  Table table_;
  std::vector<std::uint64_t> firstInner_{ 0 }; // by depth, and the end
  std::vector<std::uint64_t> ghosts_;          // a bit per leaf; empty: none is a ghost
  std::uint64_t leafCount_ = 0;
  int leafLevels_ = 0;
  NodeRef root_{};
};

} // namespace treeamr

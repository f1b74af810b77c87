// The immutable sparse octree: topology only, shared by every field that lives on it.
//
// Following the paper's section 4, but smaller: no records for leaves. An inner node is 6 bytes (which of its
// children exist, which of them are leaves, and where its first child of either kind is), because in
// breadth-first order both offsets are running sums: a 64-bit base per block of 4096 nodes and a 16-bit
// difference per node reach more than 2^32 cells.
//
// The root lattice is embedded by padding to a power of two: a node's depth counts from the padded root, its
// level from its root tree (depth = RootGrid::paddingDepth() + level). Nothing is stored for the padding.
#pragma once

#include "Octree/RootGrid.h"

#include <array>
#include <bit>
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
  /// Of a mask of octants; std::popcount is a library call on the x86-64 baseline. Four copies of the mask, of
  /// which a nibble's step picks each bit once.
  static constexpr unsigned bitCount(unsigned mask) noexcept
  {
    return ((mask * 0x08040201u >> 3) & 0x11111111u) * 0x11111111u >> 28;
  }

public:
  static constexpr int maxDepth = 61;

  const RootGrid& grid() const noexcept { return grid_; }
  std::uint64_t leafCount() const noexcept { return leafCount_; }
  std::uint64_t innerCount() const noexcept { return nodes_.size(); }
  /// Deepest leaf's level; 0 when every root is a leaf.
  int leafLevels() const noexcept { return leafLevels_; }
  /// None for an octree without cells.
  NodeRef root() const noexcept { return root_; }

  /// An inner node's children: of either kind, they follow each other in the order of their octants.
  struct Children
  {
    unsigned exists; // masks of octants
    unsigned leaf;   // subset of exists
    std::uint64_t firstInner;
    std::uint64_t firstLeaf;

    unsigned inner() const noexcept { return exists & ~leaf; }
    bool allLeaves() const noexcept { return leaf == 0xff; }
    /// Of a child that exists and is of this kind.
    std::uint64_t innerIndex(int octant) const noexcept
    {
      return firstInner + bitCount(inner() & ((1u << octant) - 1));
    }
    std::uint64_t leafIndex(int octant) const noexcept
    {
      return firstLeaf + bitCount(leaf & ((1u << octant) - 1));
    }
    NodeRef node(int octant, int depth) const noexcept
    {
      const unsigned bit = 1u << octant;
      if (!(exists & bit))
      {
        return {};
      }
      return leaf & bit ? NodeRef(NodeKind::Leaf, depth, leafIndex(octant))
                        : NodeRef(NodeKind::Inner, depth, innerIndex(octant));
    }
  };
  Children children(std::uint64_t inner) const noexcept
  {
    const InnerNode& node = nodes_[inner];
    const Base& base = bases_[inner >> blockBits];
    return { node.exists, node.leaf, base.inner + node.innerDelta, base.leaf + node.leafDelta };
  }
  /// Octant o is at x = o & 1, y = o >> 1 & 1, z = o >> 2.
  NodeRef child(NodeRef parent, int octant) const noexcept
  {
    assert(parent.isInner());
    return children(parent.index()).node(octant, parent.depth() + 1);
  }

  /// Leaves that another process owns: they take part in the reconstruction and are not drawn.
  bool hasGhosts() const noexcept { return !ghost_.empty(); }
  bool isGhost(std::uint64_t leaf) const noexcept { return hasGhosts() && ghost_[leaf]; }

  /// Allocated bytes.
  std::size_t byteSize() const noexcept;

private:
  struct InnerNode
  {
    std::uint8_t exists;
    std::uint8_t leaf; // subset of exists
    std::uint16_t innerDelta;
    std::uint16_t leafDelta;
  };
  static_assert(sizeof(InnerNode) == 6);
  struct Base
  {
    std::uint64_t inner; // first inner child of the block's first node
    std::uint64_t leaf;  // first leaf child of the block's first node
  };
  static constexpr int blockBits = 12;
  static_assert((8u << blockBits) <= 65536u, "differences within a block fit 16 bits");

  explicit Octree(RootGrid grid)
    : grid_(std::move(grid))
  {
  }
  friend class OctreeAssembler;

  RootGrid grid_;
  std::vector<InnerNode> nodes_;
  std::vector<Base> bases_;
  std::vector<bool> ghost_;
  std::uint64_t leafCount_ = 0;
  int leafLevels_ = 0;
  NodeRef root_{};
};

} // namespace treeamr

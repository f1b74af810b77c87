// Where the children of every inner node are: two masks and two offsets per node.
//
// In breadth-first order the first child of either kind is a running sum over the nodes before. A node stores
// the difference to the first node of its block, a block 64-bit sums: so 16-bit differences reach more than
// 2^32 cells.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <limits>
#include <vector>

namespace treeamr
{

/// Number of bits set. std::popcount is a library call on the x86-64 baseline.
inline int bitCount(std::uint8_t mask) noexcept
{
  static constexpr std::array<std::uint8_t, 256> table = [] {
    std::array<std::uint8_t, 256> counts{};
    for (unsigned i = 0; i < counts.size(); ++i)
    {
      counts[i] = static_cast<std::uint8_t>(std::popcount(i));
    }
    return counts;
  }();
  return table[mask];
}

/// Which children a node has: masks of octants.
struct ChildMasks
{
  std::uint8_t exists = 0;
  std::uint8_t leaf = 0; // subset of exists

  bool isLeaf(int octant) const noexcept { return leaf >> octant & 1; }
  bool isInner(int octant) const noexcept { return (exists & ~leaf) >> octant & 1; }
  void add(int octant, bool asLeaf) noexcept
  {
    exists |= static_cast<std::uint8_t>(1u << octant);
    leaf |= static_cast<std::uint8_t>(unsigned(asLeaf) << octant);
  }
};

/// Delta: an unsigned integer that holds the differences within a block of 2^BlockBits nodes.
template <class Delta, int BlockBits>
class ChildTable
{
public:
  static constexpr std::uint64_t blockSize = std::uint64_t(1) << BlockBits;
  static_assert(8 * (blockSize - 1) <= std::numeric_limits<Delta>::max(), "differences fit");

  /// The children of one node are neighbours among the leaves and among the inner nodes, by octant.
  struct Children
  {
    ChildMasks masks;
    std::uint64_t firstInner;
    std::uint64_t firstLeaf;

    int leafCount() const noexcept { return bitCount(masks.leaf); }
    int innerCount() const noexcept { return bitCount(masks.exists) - bitCount(masks.leaf); }
  };

  std::uint64_t size() const noexcept { return nodes_.size(); }
  ChildMasks masks(std::uint64_t node) const noexcept { return nodes_[node].masks; }
  Children children(std::uint64_t node) const noexcept
  {
    const Node& n = nodes_[node];
    const Base& base = bases_[node >> BlockBits];
    return { n.masks, base.inner + n.innerDelta, base.leaf + n.leafDelta };
  }
  /// Index among the leaves of a child that is one.
  std::uint64_t leafChild(std::uint64_t node, int octant) const noexcept
  {
    const Node& n = nodes_[node];
    assert(n.masks.isLeaf(octant));
    return bases_[node >> BlockBits].leaf + n.leafDelta + bitCount(n.masks.leaf & below(octant));
  }
  /// Index among the inner nodes of a child that is one.
  std::uint64_t innerChild(std::uint64_t node, int octant) const noexcept
  {
    const Node& n = nodes_[node];
    assert(n.masks.isInner(octant));
    return bases_[node >> BlockBits].inner + n.innerDelta +
      bitCount(n.masks.exists & ~n.masks.leaf & below(octant));
  }

  /// Allocated bytes.
  std::size_t byteSize() const noexcept
  {
    return nodes_.capacity() * sizeof(Node) + bases_.capacity() * sizeof(Base);
  }

  // Writing: allocate(), then start() each node and addChild() its children in any order (several threads may
  // write different nodes), then finishBlock() each block; nothing may be read before.
  void allocate(std::uint64_t size)
  {
    nodes_.assign(size, Node{});
    bases_.assign((size + blockSize - 1) >> BlockBits, Base{});
  }
  void start(std::uint64_t node, std::uint64_t firstInner, std::uint64_t firstLeaf) noexcept
  {
    // The block's base may not be known yet: for now the sums' low bits.
    nodes_[node].innerDelta = static_cast<Delta>(firstInner);
    nodes_[node].leafDelta = static_cast<Delta>(firstLeaf);
    if ((node & (blockSize - 1)) == 0)
    {
      bases_[node >> BlockBits] = { firstInner, firstLeaf };
    }
  }
  void addChild(std::uint64_t node, int octant, bool asLeaf) noexcept
  {
    nodes_[node].masks.add(octant, asLeaf);
  }
  void addChildren(std::uint64_t node, ChildMasks masks) noexcept
  {
    nodes_[node].masks.exists |= masks.exists;
    nodes_[node].masks.leaf |= masks.leaf;
  }
  std::uint64_t blockCount() const noexcept { return bases_.size(); }
  void finishBlock(std::uint64_t block) noexcept
  {
    const Base base = bases_[block];
    const std::uint64_t end = std::min(nodes_.size(), (block + 1) << BlockBits);
    for (std::uint64_t n = block << BlockBits; n < end; ++n)
    {
      nodes_[n].innerDelta = static_cast<Delta>(nodes_[n].innerDelta - static_cast<Delta>(base.inner));
      nodes_[n].leafDelta = static_cast<Delta>(nodes_[n].leafDelta - static_cast<Delta>(base.leaf));
    }
  }

private:
  struct Node
  {
    ChildMasks masks;
    Delta innerDelta; // first child of either kind, from that of the block's first node
    Delta leafDelta;
  };
  static_assert(sizeof(Node) == 2 + 2 * sizeof(Delta));
  struct Base
  {
    std::uint64_t inner; // first child of either kind of the block's first node
    std::uint64_t leaf;
  };
  static std::uint8_t below(int octant) noexcept { return static_cast<std::uint8_t>((1u << octant) - 1); }

  std::vector<Node> nodes_;
  std::vector<Base> bases_;
};

} // namespace treeamr

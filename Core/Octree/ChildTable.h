// Where the children of every inner node are: two masks and two offsets per node.
//
// In breadth-first order the first child of either kind is a running sum over the nodes before. A node stores
// the difference to the first node of its block, a block 64-bit sums: so 16-bit differences reach more than
// 2^32 cells.
#pragma once

#include "LargeArray.h"
#include "Octree/NodeRef.h"
#include "Prefetch.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace treeamr
{

/// Of a mask of octants; std::popcount is a library call on the x86-64 baseline. Four copies of the mask, of
/// which a nibble's step picks each bit once.
constexpr unsigned bitCount(unsigned mask) noexcept
{
  return ((mask * 0x08040201u >> 3) & 0x11111111u) * 0x11111111u >> 28;
}

/// An inner node's children: of either kind, they follow each other in the order of their octants.
struct Children
{
  unsigned exists; // masks of octants
  unsigned leaf;   // subset of exists
  std::uint64_t firstInner;
  std::uint64_t firstLeaf;

  unsigned inner() const noexcept { return exists & ~leaf; }
  bool allLeaves() const noexcept { return leaf == 0xff; }
  unsigned innerCount() const noexcept { return bitCount(inner()); }
  unsigned leafCount() const noexcept { return bitCount(leaf); }
  /// Of a child that exists and is of this kind.
  std::uint64_t innerIndex(int octant) const noexcept
  {
    return firstInner + bitCount(inner() & ((1u << octant) - 1));
  }
  std::uint64_t leafIndex(int octant) const noexcept
  {
    return firstLeaf + bitCount(leaf & ((1u << octant) - 1));
  }
  /// Octant o is at x = o & 1, y = o >> 1 & 1, z = o >> 2. depth: the child's.
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

  std::uint64_t size() const noexcept { return nodes_.size(); }
  Children children(std::uint64_t node) const noexcept
  {
    const Node& n = nodes_[node];
    const Base& base = bases_[node >> BlockBits];
    return { n.masks.exists, n.masks.leaf, base.inner + n.innerDelta, base.leaf + n.leafDelta };
  }
  void prefetch(std::uint64_t node) const noexcept { treeamr::prefetch(nodes_.data() + node); }

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

  LargeVector<Node> nodes_;
  LargeVector<Base> bases_;
};

} // namespace treeamr

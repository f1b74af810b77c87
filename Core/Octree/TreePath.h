// A place in the octree: the nodes from the root down to one node, each with the 27 nodes of its level
// around it. A child's 27 come from its parent's by index arithmetic alone, so a descent finds every
// neighbour, of any level, without a single look-up from the root.
#pragma once

#include "Octree/Octree.h"

#include <array>

namespace treeamr
{

/// The 3 x 3 x 3 nodes around a node, itself in the middle; entry (dx + 1) + 3 (dy + 1) + 9 (dz + 1). Each is
/// a node of the same depth, a coarser leaf that covers the place, or none.
using Neighbourhood = std::array<NodeRef, 27>;

class TreePath
{
public:
  /// At the root of the octree.
  explicit TreePath(const Octree& octree) noexcept
    : octree_(&octree)
  {
    reset();
  }
  void reset() noexcept
  {
    depth_ = 0;
    around_[0].fill(NodeRef{});
    around_[0][13] = octree_->root();
    index_[0] = {};
  }

  const Octree& octree() const noexcept { return *octree_; }
  int depth() const noexcept { return depth_; }
  NodeRef node() const noexcept { return around_[depth_][13]; }
  /// Index on the lattice of the node's depth.
  const std::array<Coord, 3>& index() const noexcept { return index_[depth_]; }
  /// The same for an ancestor (or the node itself) at a depth.
  const Neighbourhood& around(int depth) const noexcept { return around_[depth]; }
  const std::array<Coord, 3>& index(int depth) const noexcept { return index_[depth]; }

  /// Goes to a child of the current node, which must be inner.
  void descend(int octant) noexcept
  {
    const Neighbourhood& from = around_[depth_];
    Neighbourhood& to = around_[depth_ + 1];
    index_[depth_ + 1] = indexOfChild(index_[depth_], octant);
    for (const FromParent& part : fromParents[octant])
    {
      const NodeRef parent = from[part.entry];
      if (!parent.isInner())
      {
        for (int i = 0; i < part.count; ++i)
        {
          to[part.to[i]] = parent;
        }
        continue;
      }
      const Octree::Children children = octree_->children(parent.index());
      if (children.allLeaves())
      {
        for (int i = 0; i < part.count; ++i)
        {
          to[part.to[i]] = NodeRef(NodeKind::Leaf, depth_ + 1, children.firstLeaf + part.octant[i]);
        }
        continue;
      }
      for (int i = 0; i < part.count; ++i)
      {
        to[part.to[i]] = children.node(part.octant[i], depth_ + 1);
      }
    }
    ++depth_;
  }
  void ascend() noexcept { --depth_; }

private:
  /// One of the eight parents whose children are around a child, and which.
  struct FromParent
  {
    std::uint8_t entry; // in the parent's neighbourhood
    std::uint8_t count;
    std::array<std::uint8_t, 8> octant;
    std::array<std::uint8_t, 8> to; // entries in the child's
  };
  /// By the child's octant. Along an axis, the child-sized places -1, 0, 1 around the child lie at bit - 1, bit,
  /// bit + 1 in the parent's half widths: parent entry (p + 2) >> 1 of 0, 1, 2 and child p & 1 of it.
  static constexpr std::array<std::array<FromParent, 8>, 8> fromParents = [] {
    std::array<std::array<FromParent, 8>, 8> table{};
    for (int octant = 0; octant < 8; ++octant)
    {
      for (int e = 0; e < 27; ++e)
      {
        const std::array<int, 3> place{ sideOf(octant, 0) + e % 3 - 1, sideOf(octant, 1) + e / 3 % 3 - 1,
          sideOf(octant, 2) + e / 9 - 1 };
        int entry = 0;
        int child = 0;
        int part = 0;
        for (int a = 2; a >= 0; --a)
        {
          entry = 3 * entry + ((place[a] + 2) >> 1);
          child = 2 * child + (place[a] & 1);
          part = 2 * part + (place[a] == 0 || place[a] == 1);
        }
        FromParent& from = table[octant][part];
        from.entry = static_cast<std::uint8_t>(entry);
        from.octant[from.count] = static_cast<std::uint8_t>(child);
        from.to[from.count++] = static_cast<std::uint8_t>(e);
      }
    }
    return table;
  }();

  const Octree* octree_;
  int depth_;
  std::array<Neighbourhood, Octree::maxDepth + 1> around_;
  std::array<std::array<Coord, 3>, Octree::maxDepth + 1> index_;
};

} // namespace treeamr

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
    std::array<int, 3> bit;
    for (int a = 0; a < 3; ++a)
    {
      bit[a] = octant >> a & 1;
      index_[depth_ + 1][a] = 2 * index_[depth_][a] + bit[a];
    }
    // Along an axis, the child-sized places -1, 0, 1 around the child lie at bit - 1, bit, bit + 1 in the
    // parent's half widths: parent entry (p + 2) >> 1 of 0, 1, 2 and child p & 1 of it.
    for (int k = 0, e = 0; k < 3; ++k)
    {
      const int z = bit[2] + k - 1;
      for (int j = 0; j < 3; ++j)
      {
        const int y = bit[1] + j - 1;
        const int row = 9 * ((z + 2) >> 1) + 3 * ((y + 2) >> 1);
        const int rowOctant = (y & 1) << 1 | (z & 1) << 2;
        for (int i = 0; i < 3; ++i, ++e)
        {
          const int x = bit[0] + i - 1;
          const NodeRef parent = from[row + ((x + 2) >> 1)];
          to[e] = parent.isInner() ? octree_->child(parent, rowOctant | (x & 1)) : parent;
        }
      }
    }
    ++depth_;
  }
  void ascend() noexcept { --depth_; }

private:
  const Octree* octree_;
  int depth_;
  std::array<Neighbourhood, Octree::maxDepth + 1> around_;
  std::array<std::array<Coord, 3>, Octree::maxDepth + 1> index_;
};

} // namespace treeamr

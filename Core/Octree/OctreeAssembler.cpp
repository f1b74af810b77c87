#include "Octree/OctreeAssembler.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

namespace treeamr
{

OctreeAssembler::OctreeAssembler(RootGrid grid, std::vector<NodeCounts> counts, bool mayHaveGhosts)
  : octree_(std::make_shared<Octree>(Octree(std::move(grid))))
  , first_(std::move(counts))
  , late_(first_.size())
{
  NodeCounts total;
  for (const NodeCounts& c : first_)
  {
    for (int depth = 0; depth <= Octree::maxDepth; ++depth)
    {
      total.inner[depth] += c.inner[depth];
      total.leaf[depth] += c.leaf[depth];
    }
  }
  Octree& tree = *octree_;
  std::uint64_t inner = 0;
  NodeCounts next;
  for (int depth = 0; depth <= Octree::maxDepth; ++depth)
  {
    next.inner[depth] = inner;
    next.leaf[depth] = tree.leafCount_;
    inner += total.inner[depth];
    tree.leafCount_ += total.leaf[depth];
    if (total.inner[depth] > 0)
    {
      tree.firstInner_.push_back(inner);
    }
    if (total.leaf[depth] > 0)
    {
      tree.leafLevels_ = depth - tree.grid_.paddingDepth();
    }
  }
  if (tree.leafCount_ > 0)
  {
    tree.root_ = { inner > 0 ? NodeKind::Inner : NodeKind::Leaf, 0, 0 };
  }
  for (NodeCounts& c : first_)
  {
    for (int depth = 0; depth <= Octree::maxDepth; ++depth)
    {
      next.inner[depth] += std::exchange(c.inner[depth], next.inner[depth]);
      next.leaf[depth] += std::exchange(c.leaf[depth], next.leaf[depth]);
    }
  }
  tree.firstInner_.shrink_to_fit();
  tree.table_.allocate(inner);
  if (mayHaveGhosts)
  {
    tree.ghosts_.assign((tree.leafCount_ + 63) / 64, 0);
  }
}

OctreeAssembler::Writer::Writer(OctreeAssembler& assembler, std::size_t stretch) noexcept
  : table_(assembler.octree_->table_)
  , ghosts_(assembler.octree_->ghosts_)
  , late_(assembler.late_[stretch])
  , next_(assembler.first_[stretch])
{
  parent_.fill(startedBefore);
}

void OctreeAssembler::Writer::markGhost(std::uint64_t leaf) noexcept
{
  std::atomic_ref(ghosts_[leaf >> 6]).fetch_or(std::uint64_t(1) << (leaf & 63), std::memory_order_relaxed);
}

std::shared_ptr<const Octree> OctreeAssembler::finish()
{
  Octree& tree = *octree_;
  for (std::size_t s = 0; s < first_.size(); ++s)
  {
    for (int depth = 1; depth <= Octree::maxDepth; ++depth)
    {
      const ChildMasks m = late_[s][depth];
      if (m.exists != 0)
      {
        tree.table_.addChildren(first_[s].inner[depth - 1] - 1, m);
      }
    }
  }
  tbb::parallel_for(
    std::uint64_t(0), tree.table_.blockCount(), [&](std::uint64_t block) { tree.table_.finishBlock(block); });
  if (std::all_of(tree.ghosts_.begin(), tree.ghosts_.end(), [](std::uint64_t bits) { return bits == 0; }))
  {
    std::vector<std::uint64_t>().swap(tree.ghosts_);
  }
  else
  {
    this->findGhostsBelow();
  }
  return octree_;
}

void OctreeAssembler::findGhostsBelow()
{
  Octree& tree = *octree_;
  tree.ghostsBelow_.assign((tree.innerCount() + 63) / 64, 0);
  // The last word of a depth is the first of the next.
  const auto wordOf = [&](std::uint64_t node) { return std::atomic_ref(tree.ghostsBelow_[node >> 6]); };
  for (int depth = tree.innerDepths() - 1; depth >= 0; --depth)
  {
    tbb::parallel_for(tree.firstInner(depth), tree.firstInner(depth + 1), [&](std::uint64_t node) {
      const Octree::Children children = tree.children(node);
      bool found = false;
      for (int i = 0; i < static_cast<int>(children.leafCount()); ++i)
      {
        found = found || tree.isGhost(children.firstLeaf + i);
      }
      for (int i = 0; i < static_cast<int>(children.innerCount()); ++i)
      {
        const std::uint64_t child = children.firstInner + i;
        found = found || (wordOf(child).load(std::memory_order_relaxed) >> (child & 63) & 1);
      }
      if (found)
      {
        wordOf(node).fetch_or(std::uint64_t(1) << (node & 63), std::memory_order_relaxed);
      }
    });
  }
}

} // namespace treeamr

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
  return octree_;
}

} // namespace treeamr

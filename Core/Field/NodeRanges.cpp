// Ranges of the reconstructed field per inner node. Unlike the paper's ranges of cell values they hold for sure:
// an octant's vertices also use the cells around it. Beside cells of other sizes they may be wider than the
// field: its exact hull takes twice as long and leaves out two more nodes in a hundred.
#include "Interpolation/BlockValues.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

namespace treeamr
{

namespace
{

class RangeBuilder
{
public:
  RangeBuilder(const Field& field, LargeVector<Range>& ranges)
    : field_(field)
    , ranges_(ranges)
    , serialDepth_(field.octree().grid().paddingDepth() + field.octree().leafLevels() - 3)
    , evaluators_([&field] { return BlockEvaluator(field); })
  {
  }

  Range visit(BlockPath& path) { return visit(path, evaluators_.local()); }

private:
  Range visit(BlockPath& path, BlockEvaluator& evaluator)
  {
    const std::uint64_t node = path.node[path.depth];
    const Octree::Children children = field_.octree().children(node);
    std::array<Range, 8> parts;
    // Subtrees of up to 512 leaves are one task's work.
    if (path.depth >= serialDepth_)
    {
      for (int o = 0; o < 8; ++o)
      {
        if (children.inner() >> o & 1)
        {
          path.descend(o, children.innerIndex(o));
          parts[o] = visit(path, evaluator);
          path.ascend();
        }
      }
    }
    else
    {
      tbb::parallel_for(0, 8, [&](int o) {
        if (children.inner() >> o & 1)
        {
          BlockPath own(path);
          own.descend(o, children.innerIndex(o));
          parts[o] = visit(own);
        }
      });
    }
    bool first = children.leaf == 0;
    Range all = first ? Range{} : evaluator.bounds(path);
    for (int o = 0; o < 8; ++o)
    {
      if (children.inner() >> o & 1)
      {
        all = first ? parts[o] : Range{ std::min(all.min, parts[o].min), std::max(all.max, parts[o].max) };
        first = false;
      }
    }
    ranges_[node] = all;
    return all;
  }

  const Field& field_;
  LargeVector<Range>& ranges_;
  int serialDepth_;
  // Whose kept values name their nodes: a thread that waits in one subtree may work in another.
  tbb::enumerable_thread_specific<BlockEvaluator> evaluators_;
};

} // namespace

void Field::computeNodeRanges()
{
  LargeVector<Range> exact(octree_->innerCount());
  if (octree_->root().isInner())
  {
    BlockPath path;
    RangeBuilder(*this, exact).visit(path);
  }
  encodeNodeRanges(std::move(exact));
}

} // namespace treeamr

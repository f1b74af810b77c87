#include "Field/NodeRanges.h"

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

NodeRanges::NodeRanges(const Field& field)
{
  LargeVector<Range> exact(field.octree().innerCount());
  if (field.octree().root().isInner())
  {
    BlockPath path;
    RangeBuilder(field, exact).visit(path);
  }
  encode(field, std::move(exact));
}

void NodeRanges::encode(const Field& field, LargeVector<Range> exact)
{
  const Octree& octree = field.octree();
  codes_.resize(octree.innerCount());
  if (octree.innerCount() == 0)
  {
    return;
  }
  // Down the depths: a node's exact range makes way for its decoded one once it is encoded.
  const auto encodeNode = [&](std::uint64_t node, Range parent) {
    codes_[node] = RangeCode(exact[node], parent);
    exact[node] = codes_[node].decode(parent);
  };
  encodeNode(0, field.range());
  for (int depth = 0; depth < octree.innerDepths(); ++depth)
  {
    tbb::parallel_for(
      tbb::blocked_range<std::uint64_t>(octree.firstInner(depth), octree.firstInner(depth + 1), 4096),
      [&](const auto& nodes) {
        for (std::uint64_t n = nodes.begin(); n < nodes.end(); ++n)
        {
          const Children children = octree.children(n);
          for (std::uint64_t c = children.firstInner; c < children.firstInner + children.innerCount(); ++c)
          {
            encodeNode(c, exact[n]);
          }
        }
      });
  }
}

} // namespace treeamr

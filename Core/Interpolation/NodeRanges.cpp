// Ranges of the reconstructed field per inner node: the hull of the vertex values of the leaves below.
// Exact, unlike the paper's ranges of cell values: an octant's vertices also use the cells around it.
#include "Interpolation/VertexValues.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

namespace treeamr
{

namespace
{

class RangeBuilder
{
public:
  RangeBuilder(const Field& field, std::vector<Range>& ranges)
    : field_(field)
    , ranges_(ranges)
    , serialDepth_(field.octree().grid().paddingDepth() + field.octree().leafLevels() - 3)
  {
  }

  Range visit(TreePath& path, VertexMemo& memo) const
  {
    const NodeRef node = path.node();
    if (node.isLeaf())
    {
      return hull(vertexValues<VertexRule::GTI>(path, field_, memo));
    }
    std::array<Range, 8> parts;
    const auto visitChild = [&](TreePath& at, VertexMemo& known, int octant) {
      at.descend(octant);
      parts[octant] = visit(at, known);
      at.ascend();
    };
    // Subtrees of up to 512 leaves are one task's work; a path is too large to copy for less.
    if (path.depth() >= serialDepth_)
    {
      for (int o = 0; o < 8; ++o)
      {
        if (!path.octree().child(node, o).isNone())
        {
          visitChild(path, memo, o);
        }
      }
    }
    else
    {
      tbb::parallel_for(0, 8, [&](int o) {
        if (!path.octree().child(node, o).isNone())
        {
          TreePath own(path);
          VertexMemo known;
          visitChild(own, known, o);
        }
      });
    }
    bool first = true;
    Range all{};
    for (int o = 0; o < 8; ++o)
    {
      if (!path.octree().child(node, o).isNone())
      {
        all = first ? parts[o] : Range{ std::min(all.min, parts[o].min), std::max(all.max, parts[o].max) };
        first = false;
      }
    }
    ranges_[node.index()] = all;
    return all;
  }

private:
  const Field& field_;
  std::vector<Range>& ranges_;
  int serialDepth_;
};

} // namespace

void Field::computeNodeRanges()
{
  std::vector<Range> exact(octree_->innerCount());
  if (octree_->root().isInner())
  {
    TreePath path(*octree_);
    VertexMemo memo;
    RangeBuilder(*this, exact).visit(path, memo);
  }
  encodeNodeRanges(std::move(exact));
}

} // namespace treeamr

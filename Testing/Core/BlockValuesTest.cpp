// The values of eight leaves at once, against those of each leaf alone.
#include "Interpolation/BlockValues.h"
#include "Interpolation/VertexValues.h"
#include "Octree/OctreeBuilder.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace treeamr;
using namespace treeamr::test;

TEST(BlockValues, EqualThoseOfEachLeafBitForBit)
{
  int compared = 0;
  int deepJumps = 0;
  for (const RandomTree& options : propertyTrees())
  {
    auto built =
      buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options));
    const Field field(built.octree, built.values);
    BlockEvaluator evaluator(field);
    TreePath root(field.octree());
    forEachNode(root, [&](const TreePath& here) {
      if (!here.node().isInner())
      {
        return;
      }
      TreePath at(here);
      if (at.octree().children(at.node().index()).leaf == 0)
      {
        return;
      }
      BlockPath path;
      for (int depth = 1; depth <= at.depth(); ++depth)
      {
        const auto& index = at.index(depth);
        path.descend(static_cast<int>((index[0] & 1) | (index[1] & 1) << 1 | (index[2] & 1) << 2),
          at.around(depth)[13].index());
      }
      BlockValues block;
      evaluator.compute(path, BlockCells::Leaves, block);
      Range all{ 1e30f, -1e30f };
      const NodeRef node = at.node();
      for (int o = 0; o < 8; ++o)
      {
        if (!at.octree().child(node, o).isLeaf())
        {
          continue;
        }
        at.descend(o);
        const VertexValues expected = vertexValues<VertexRule::GTI>(at, field);
        for (const NodeRef neighbour : at.around(at.depth()))
        {
          deepJumps += neighbour.isLeaf() && neighbour.depth() < at.depth() - 1;
        }
        at.ascend();
        const int corner = 2 * (o & 1) + 10 * (o >> 1 & 1) + 50 * (o >> 2);
        for (int v = 0; v < 27; ++v)
        {
          ASSERT_EQ(block.values[corner + v % 3 + 5 * (v / 3 % 3) + 25 * (v / 9)], expected[v])
            << "seed " << options.seed << ", vertex " << v << " of child " << o;
          ++compared;
        }
        const Range leaf = hull(expected);
        all = { std::min(all.min, leaf.min), std::max(all.max, leaf.max) };
      }
      if (all.min <= all.max)
      {
        EXPECT_EQ(block.range.min, all.min);
        EXPECT_EQ(block.range.max, all.max);
        const Range bounds = evaluator.bounds(path);
        EXPECT_LE(bounds.min, all.min);
        EXPECT_GE(bounds.max, all.max);
      }
    });
  }
  EXPECT_GT(compared, 100000);
  EXPECT_GT(deepJumps, 100);
}

// The values of eight leaves at once, against those of each leaf alone.
#include "Interpolation/BlockValues.h"
#include "Interpolation/VertexValues.h"
#include "Octree/OctreeBuilder.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

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
      const BlockPath path(at);
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

TEST(BlockValues, GiveAVertexOneValueBitForBit)
{
  std::mt19937 random(11);
  int shared = 0;
  for (const RandomTree& options : propertyTrees())
  {
    auto cells = makeRandomTree(options);
    for (LeafCell& c : cells)
    {
      c.value = std::ldexp(c.value, static_cast<int>(random() % 121) - 60);
    }
    auto built = buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
    const Field field(built.octree, built.values);
    BlockEvaluator evaluator(field);
    std::map<std::array<Coord, 3>, float> known; // by place on the finest octant lattice
    TreePath root(field.octree());
    forEachNode(root, [&](const TreePath& at) {
      if (!at.node().isInner() || at.octree().children(at.node().index()).leaf == 0)
      {
        return;
      }
      const BlockPath path(at);
      BlockValues block;
      evaluator.compute(path, BlockCells::Leaves, block);
      const int up = field.octree().grid().paddingDepth() + field.octree().leafLevels() - at.depth();
      for (int o = 0; o < 8; ++o)
      {
        for (int v = 0; v < 27 && at.octree().child(at.node(), o).isLeaf(); ++v)
        {
          const std::array<int, 3> place{ 2 * (o & 1) + v % 3, 2 * (o >> 1 & 1) + v / 3 % 3,
            2 * (o >> 2) + v / 9 };
          std::array<Coord, 3> key;
          for (int a = 0; a < 3; ++a)
          {
            key[a] = (4 * at.index()[a] + place[a]) << up;
          }
          const float value = block.values[place[0] + 5 * place[1] + 25 * place[2]];
          const auto [entry, isNew] = known.try_emplace(key, value);
          EXPECT_EQ(entry->second, value) << "seed " << options.seed;
          shared += !isNew;
        }
      }
    });
  }
  EXPECT_GT(shared, 100000);
}

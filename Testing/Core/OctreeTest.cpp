#include "Error.h"
#include "Field/Field.h"
#include "Octree/OctreeBuilder.h"
#include "Octree/TreePath.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

RootGrid unitRoots(const std::array<int, 3>& roots)
{
  return RootGrid::uniform(roots, { 0., 0., 0. }, { 1., 1., 1. });
}

using Key = std::array<Coord, 4>;
Key keyOf(const CellId& c)
{
  return { c.level, c.index[0], c.index[1], c.index[2] };
}

std::map<Key, float> table(const std::vector<LeafCell>& cells)
{
  std::map<Key, float> t;
  for (const LeafCell& c : cells)
  {
    t[keyOf(c.cell)] = c.value;
  }
  return t;
}

} // namespace

TEST(Octree, HoldsExactlyTheCellsItWasBuiltFrom)
{
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const auto built = buildOctree(unitRoots(options.roots), cells);
    ASSERT_EQ(built.octree->leafCount(), cells.size());
    auto expected = table(cells);
    TreePath path(*built.octree);
    forEachNode(path, [&](const TreePath& p) {
      if (p.node().isLeaf())
      {
        const CellId id{ p.index(), p.depth() - built.octree->grid().paddingDepth() };
        const auto found = expected.find(keyOf(id));
        ASSERT_NE(found, expected.end());
        EXPECT_EQ(found->second, built.values[p.node().index()]);
        expected.erase(found);
      }
    });
    EXPECT_TRUE(expected.empty());
  }
}

TEST(Octree, CarriedNeighbourhoodsEqualLookUps)
{
  for (const RandomTree& options : propertyTrees())
  {
    const auto built = buildOctree(unitRoots(options.roots), makeRandomTree(options));
    std::map<Key, NodeRef> nodes; // by depth
    TreePath path(*built.octree);
    forEachNode(path, [&](const TreePath& p) { nodes[keyOf({ p.index(), p.depth() })] = p.node(); });
    forEachNode(path, [&](const TreePath& p) {
      for (int n = 0; n < 27; ++n)
      {
        // The deepest node at or above the neighbour's place: that place's node, a coarser leaf, or an inner
        // node without a child there, which means none.
        NodeRef expected{};
        for (int depth = p.depth(); depth >= 0; --depth)
        {
          const int up = p.depth() - depth;
          const auto found = nodes.find({ depth, (p.index()[0] + n % 3 - 1) >> up,
            (p.index()[1] + n / 3 % 3 - 1) >> up, (p.index()[2] + n / 9 - 1) >> up });
          if (found != nodes.end())
          {
            expected = up == 0 || found->second.isLeaf() ? found->second : NodeRef{};
            break;
          }
        }
        ASSERT_EQ(p.around(p.depth())[n], expected);
      }
    });
  }
}

TEST(Octree, MeansAreVolumeWeightedOverTheLeavesBelow)
{
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const auto built = buildOctree(unitRoots(options.roots), cells);
    const Field field(built.octree, built.values);
    std::map<Key, std::pair<double, double>> sums;
    for (const LeafCell& c : cells)
    {
      for (int level = c.cell.level; level >= 0; --level)
      {
        const int up = c.cell.level - level;
        auto& s = sums[{ level, c.cell.index[0] >> up, c.cell.index[1] >> up, c.cell.index[2] >> up }];
        s.first += std::ldexp(c.value, -3 * c.cell.level);
        s.second += std::ldexp(1., -3 * c.cell.level);
      }
    }
    TreePath path(*built.octree);
    forEachNode(path, [&](const TreePath& p) {
      const int level = p.depth() - built.octree->grid().paddingDepth();
      if (level >= 0)
      {
        const auto& s = sums.at(keyOf({ p.index(), level }));
        EXPECT_NEAR(field.value(p.node()), s.first / s.second, 3e-7);
      }
    });
  }
}

TEST(Octree, ReachesDepthNineteenAndManyRoots)
{
  // Refined towards the last corner of a 1 x 1 x 10,000 column of roots.
  const std::array<int, 3> roots{ 1, 1, 10000 };
  std::vector<LeafCell> cells;
  for (Coord k = 0; k < 9999; ++k)
  {
    cells.push_back({ { { 0, 0, k }, 0 }, static_cast<float>(k) });
  }
  std::array<Coord, 3> parent{ 0, 0, 9999 };
  constexpr int deepest = 40;
  for (int level = 1; level <= deepest; ++level)
  {
    for (int o = 0; o < 8; ++o)
    {
      if (o != 7 || level == deepest)
      {
        cells.push_back(
          { { { 2 * parent[0] + (o & 1), 2 * parent[1] + (o >> 1 & 1), 2 * parent[2] + (o >> 2) }, level },
            1.f });
      }
    }
    parent = { 2 * parent[0] + 1, 2 * parent[1] + 1, 2 * parent[2] + 1 };
  }
  const auto built = buildOctree(unitRoots(roots), cells);
  EXPECT_EQ(built.octree->leafCount(), cells.size());
  EXPECT_EQ(built.octree->leafLevels(), deepest);
  auto expected = table(cells);
  TreePath path(*built.octree);
  forEachNode(path, [&](const TreePath& p) {
    if (p.node().isLeaf())
    {
      const CellId id{ p.index(), p.depth() - built.octree->grid().paddingDepth() };
      EXPECT_EQ(expected.erase(keyOf(id)), 1u);
    }
  });
  EXPECT_TRUE(expected.empty());
}

TEST(Octree, OneCellAndNone)
{
  const auto one = buildOctree(unitRoots({ 1, 1, 1 }), std::vector<LeafCell>{ { {}, 3.f } });
  EXPECT_TRUE(one.octree->root().isLeaf());
  EXPECT_EQ(Field(one.octree, one.values).value(one.octree->root()), 3.f);
  const auto none = buildOctree(unitRoots({ 2, 1, 1 }), std::vector<LeafCell>{});
  EXPECT_TRUE(none.octree->root().isNone());
  EXPECT_EQ(Field(none.octree, none.values).range().max, 0.f);
}

TEST(Octree, OffsetsCrossBlocksOfNodes)
{
  // 8^5 leaves have 4,681 inner nodes: more than one block of 4,096.
  std::vector<LeafCell> cells;
  for (Coord k = 0; k < 32; ++k)
  {
    for (Coord j = 0; j < 32; ++j)
    {
      for (Coord i = 0; i < 32; ++i)
      {
        cells.push_back({ { { i, j, k }, 5 }, static_cast<float>(i + 32 * j + 1024 * k) });
      }
    }
  }
  const auto built = buildOctree(unitRoots({ 1, 1, 1 }), cells);
  EXPECT_EQ(built.octree->innerCount(), 4681u);
  TreePath path(*built.octree);
  forEachNode(path, [&](const TreePath& p) {
    if (p.node().isLeaf())
    {
      const auto& i = p.index();
      EXPECT_EQ(built.values[p.node().index()], static_cast<float>(i[0] + 32 * i[1] + 1024 * i[2]));
    }
  });
  EXPECT_LT(built.octree->byteSize(), cells.size());
}

TEST(Octree, RejectsBadCells)
{
  const auto build = [](std::vector<LeafCell> cells) {
    return buildOctree(unitRoots({ 2, 1, 1 }), std::move(cells));
  };
  EXPECT_THROW(build({ { { { 2, 0, 0 }, 0 }, 0.f } }), Error);
  EXPECT_THROW(build({ { { { 0, -1, 0 }, 0 }, 0.f } }), Error);
  EXPECT_THROW(build({ { { { 0, 0, 0 }, -1 }, 0.f } }), Error);
  EXPECT_THROW(build({ { { { 0, 0, 0 }, 60 }, 0.f } }), Error);
  EXPECT_THROW(build({ { { { 1, 0, 0 }, 0 }, 0.f }, { { { 1, 0, 0 }, 0 }, 0.f } }), Error);
  EXPECT_THROW(build({ { { { 5, 1, 3 }, 2 }, 0.f }, { { { 1, 0, 0 }, 0 }, 0.f } }), Error);
  EXPECT_NO_THROW(build({ { { { 5, 1, 3 }, 2 }, 0.f }, { { { 0, 0, 0 }, 0 }, 0.f } }));
  const auto good = build({ { { { 0, 0, 0 }, 0 }, 0.f } });
  EXPECT_THROW(Field(good.octree, {}), Error);
  EXPECT_THROW(Field(good.octree, { std::numeric_limits<float>::quiet_NaN() }), Error);
}

TEST(RootGrid, MapsNonUniformAxesBothWays)
{
  const RootGrid grid({ std::vector<double>{ 0., 1., 3., 3.5 }, { -1e9, -1e9 + 1. }, { 1e-12, 2e-12 } });
  EXPECT_EQ(grid.paddingDepth(), 2);
  EXPECT_EQ(grid.worldPlane(0, 5, 1), 3.25);
  EXPECT_EQ(grid.worldPlane(0, 3, 1), 2.);
  EXPECT_EQ(grid.worldPlane(0, 6, 1), 3.5);
  EXPECT_EQ(grid.worldPlane(0, 12, 2), grid.worldPlane(0, 3, 0));
  EXPECT_EQ(grid.nodePlane(0, 1, 1), 3.);  // two roots wide
  EXPECT_EQ(grid.nodePlane(0, 2, 1), 3.5); // clamped to the domain
  EXPECT_EQ(grid.latticeCoordinate(0, 2.), 1.5);
  EXPECT_EQ(grid.latticeCoordinate(0, 3.5), 3.);
  EXPECT_TRUE(std::isnan(grid.latticeCoordinate(0, 3.6)));
  EXPECT_TRUE(std::isnan(grid.latticeCoordinate(0, std::nan(""))));
  EXPECT_EQ(grid.latticeCoordinate(1, -1e9 + 0.25), 0.25);
  EXPECT_NEAR(grid.latticeCoordinate(2, 1.5e-12), 0.5, 1e-15);
}

TEST(RootGrid, RejectsBadPlanes)
{
  using Axis = std::vector<double>;
  const Axis good{ 0., 1. };
  EXPECT_THROW(RootGrid({ Axis{ 0. }, good, good }), Error);
  EXPECT_THROW(RootGrid({ good, Axis{ 0., 0. }, good }), Error);
  EXPECT_THROW(RootGrid({ good, good, Axis{ 1., 0. } }), Error);
  EXPECT_THROW(RootGrid({ good, good, Axis{ 0., std::numeric_limits<double>::infinity() } }), Error);
  EXPECT_THROW(RootGrid({ good, good, Axis{ -1e308, 1e308 } }), Error);
}

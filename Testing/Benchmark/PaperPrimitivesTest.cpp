// The three extractions give one surface: octant by octant that of each leaf alone.
#include "Benchmark/PaperPrimitives.h"
#include "Error.h"
#include "Interpolation/VertexValues.h"
#include "Support/ListSource.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>

using namespace treeamr;
using namespace treeamr::bench;
using namespace treeamr::test;

namespace
{

using Corners = std::array<float, 8>;
using Place = std::array<Coord, 4>; // level of the lattice of half cells, then the index on it

int corner3(int c)
{
  return (c & 1) + 3 * (c >> 1 & 1) + 9 * (c >> 2);
}

Corners octantOf(const std::array<float, 27>& vertices, int octant)
{
  Corners corners;
  for (int c = 0; c < 8; ++c)
  {
    corners[c] = vertices[corner3(octant) + corner3(c)];
  }
  return corners;
}

bool isActive(const Corners& corners, float isovalue)
{
  const auto [low, high] = std::minmax_element(corners.begin(), corners.end());
  return *low <= isovalue && isovalue <= *high;
}

Place placeOf(const Primitive& primitive, int octant = 0)
{
  Place place{ primitive.level };
  for (int a = 0; a < 3; ++a)
  {
    place[1 + a] = static_cast<Coord>(primitive.index[a]) + (octant >> a & 1);
  }
  return place;
}

/// What the definition says, leaf by leaf.
struct Expected
{
  std::map<Place, Corners> activeOctants;
  std::map<Place, float> drawn; // by the middle of the cell
  std::uint64_t activeCells = 0;

  Expected(const Field& field, float isovalue)
  {
    const Octree& octree = field.octree();
    TreePath root(octree);
    forEachNode(root, [&](const TreePath& path) {
      if (!path.node().isLeaf() || octree.isGhost(path.node().index()))
      {
        return;
      }
      Place place{ path.depth() - octree.grid().paddingDepth() + 1 };
      for (int a = 0; a < 3; ++a)
      {
        place[1 + a] = 2 * path.index()[a] + 1;
      }
      drawn[place] = field.value(path.node());
      const VertexValues vertices = vertexValues<VertexRule::GTI>(path, field);
      bool any = false;
      for (int o = 0; o < 8; ++o)
      {
        const Corners corners = octantOf(vertices, o);
        if (isActive(corners, isovalue))
        {
          activeOctants[{ place[0], place[1] - 1 + (o & 1), place[2] - 1 + (o >> 1 & 1),
            place[3] - 1 + (o >> 2) }] = corners;
          any = true;
        }
      }
      activeCells += any;
    });
  }

  /// The cells around the middle of a dual cell, given by its lower corner; false unless all are drawn and of
  /// one level.
  bool cellsAround(Place lower, Corners& values) const
  {
    for (int c = 0; c < 8; ++c)
    {
      const Place middle{ lower[0], lower[1] + 2 * (c & 1), lower[2] + 2 * (c >> 1 & 1),
        lower[3] + 2 * (c >> 2) };
      const auto found = drawn.find(middle);
      if (found == drawn.end())
      {
        return false;
      }
      values[c] = found->second;
    }
    return true;
  }
};

struct Counts
{
  std::size_t octants = 0;
  std::size_t dualCells = 0;
  std::size_t acrossNodes = 0; // dual cells that no node holds alone
};

void expectCover(
  const Primitives& found, const Expected& expected, bool dualCells, float isovalue, Counts& counts)
{
  ASSERT_EQ(found.primitives.size(), found.values.size());
  std::set<Place> covered;
  for (std::size_t i = 0; i < found.primitives.size(); ++i)
  {
    const Primitive& primitive = found.primitives[i];
    Corners around;
    if (primitive.kind == Primitive::Kind::Octant)
    {
      const Place place = placeOf(primitive);
      ASSERT_TRUE(covered.insert(place).second);
      const auto octant = expected.activeOctants.find(place);
      ASSERT_NE(octant, expected.activeOctants.end());
      ASSERT_EQ(found.values[i], octant->second);
      Place dualCell = place;
      for (int a = 1; a < 4; ++a)
      {
        dualCell[a] -= 1 - place[a] % 2;
      }
      ASSERT_FALSE(dualCells && expected.cellsAround(dualCell, around));
      ++counts.octants;
      continue;
    }
    ASSERT_TRUE(dualCells);
    ASSERT_TRUE(expected.cellsAround(placeOf(primitive), around));
    ASSERT_EQ(found.values[i], around);
    const std::array<float, 27> vertices = dualCellVertices(around);
    int active = 0;
    for (int o = 0; o < 8; ++o)
    {
      const Place place = placeOf(primitive, o);
      ASSERT_TRUE(covered.insert(place).second);
      const auto octant = expected.activeOctants.find(place);
      ASSERT_EQ(octant != expected.activeOctants.end(), isActive(octantOf(vertices, o), isovalue));
      if (octant != expected.activeOctants.end())
      {
        ASSERT_EQ(octantOf(vertices, o), octant->second);
        ++active;
      }
    }
    ASSERT_GT(active, 0);
    ++counts.dualCells;
    counts.acrossNodes +=
      std::any_of(primitive.index.begin(), primitive.index.end(), [](std::uint32_t x) { return x % 4 != 1; });
  }
  for (const auto& [place, corners] : expected.activeOctants)
  {
    ASSERT_TRUE(covered.count(place));
  }
}

/// All three extractions of a field of random cells; those with values below ghostsBelow are ghosts.
void expectSame(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells, float ghostsBelow,
  const std::vector<float>& isovalues, Counts& counts)
{
  ListSource source(roots, cells);
  source.ghostsBelow = ghostsBelow;
  auto built = buildOctree(RootGrid::uniform(roots, { 0., 0., 0. }, { 1., 1., 1. }), source);
  Field field(built.octree, std::move(built.values));
  for (const float isovalue : isovalues)
  {
    const Expected expected(field, isovalue);
    EXPECT_EQ(countActiveCells(field, isovalue), expected.activeCells);
    for (const Extraction extraction : { Extraction::Naive, Extraction::DualCells, Extraction::Filtered })
    {
      SCOPED_TRACE(testing::Message() << "extraction " << static_cast<int>(extraction) << " at " << isovalue);
      expectCover(extractPrimitives(field, isovalue, extraction), expected, extraction != Extraction::Naive,
        isovalue, counts);
      if (testing::Test::HasFatalFailure())
      {
        return;
      }
    }
  }
}

constexpr float noGhosts = -std::numeric_limits<float>::infinity();

} // namespace

TEST(PaperPrimitives, CoverTheSameOctantsOnRandomTrees)
{
  Counts counts;
  for (const RandomTree& options : propertyTrees())
  {
    SCOPED_TRACE(testing::Message() << "seed " << options.seed);
    const std::vector<LeafCell> cells = makeRandomTree(options);
    expectSame(options.roots, cells, noGhosts, { 0.f, 0.7f, 0.99f, 2.f }, counts);
    expectSame(options.roots, cells, -0.8f, { 0.3f }, counts);
  }
  EXPECT_GT(counts.octants, 10000u);
  EXPECT_GT(counts.dualCells, 100u);
}

TEST(PaperPrimitives, CoverSmoothSurfacesWhoseNodesAreFiltered)
{
  Counts counts;
  const auto distance = [](const std::array<double, 3>& p) {
    return std::hypot(p[0] - 0.45, p[1] - 0.52, p[2] - 0.4);
  };
  for (const double missing : { 0., 0.02 })
  {
    for (const int levels : { 0, 1, 3 })
    {
      for (const std::array<int, 3>& roots : { std::array{ 1, 1, 1 }, std::array{ 2, 1, 3 } })
      {
        std::vector<LeafCell> cells = makeRandomTree({ 7, roots, levels, 1., missing, false });
        setValues(cells, distance);
        expectSame(roots, cells, noGhosts, { 0.05f, 0.2f, 0.25f, 0.3f, cells[0].value }, counts);
        expectSame(roots, cells, 0.15f, { 0.2f }, counts);
      }
    }
  }
  EXPECT_GT(counts.dualCells, 1000u);
  EXPECT_GT(counts.acrossNodes, counts.dualCells / 2);
}

TEST(PaperPrimitives, AreRefusedWhereIndicesDoNotFit)
{
  const auto chain = [](int levels) {
    std::vector<LeafCell> cells;
    for (int level = 1; level <= levels; ++level)
    {
      for (int o = level == levels ? 0 : 1; o < 8; ++o)
      {
        cells.push_back({ { { o & 1, o >> 1 & 1, o >> 2 }, level }, static_cast<float>(o) });
      }
    }
    return cells;
  };
  Counts counts;
  expectSame({ 1, 1, 1 }, chain(31), noGhosts, { 0.5f }, counts);
  auto built = buildOctree(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), chain(32));
  Field field(built.octree, std::move(built.values));
  EXPECT_THROW(extractPrimitives(field, 0.5f, Extraction::Naive), Error);
}

// Boxes of a domain, and what has to be held around one: the field inside is then that of all cells, bit for bit.
#include "Contour/Contour.h"
#include "Partition/BoxCuts.h"
#include "Partition/BoxTree.h"
#include "Support/FieldVertices.h"
#include "Support/Fields.h"
#include "Support/HeldCells.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Of parts, whose points are one where they have the same bits.
struct MergedContour
{
  using Point = std::array<double, 3>;

  std::map<Point, Point> gradients;          // by point
  std::map<std::array<Point, 2>, int> edges; // by their ends: how often they run upwards less downwards
  std::size_t triangles = 0;

  void add(const ContourMesh& part)
  {
    for (std::size_t p = 0; p < part.points.size(); ++p)
    {
      const auto [known, isNew] = gradients.emplace(part.points[p], part.gradients[p]);
      EXPECT_TRUE(isNew || known->second == part.gradients[p]);
    }
    for (const auto& triangle : part.triangles)
    {
      for (int i = 0; i < 3; ++i)
      {
        const Point& from = part.points[triangle[i]];
        const Point& to = part.points[triangle[(i + 1) % 3]];
        edges[{ std::min(from, to), std::max(from, to) }] += from < to ? 1 : -1;
      }
    }
    triangles += part.triangles.size();
  }
  /// The edges without a triangle on their other side.
  std::map<std::array<Point, 2>, int> rim() const
  {
    auto open = edges;
    std::erase_if(open, [](const auto& edge) { return edge.second == 0; });
    return open;
  }
};

LatticeBox randomBox(const std::array<int, 3>& roots, std::mt19937& random)
{
  LatticeBox box;
  box.level = static_cast<int>(random() % 3);
  for (int a = 0; a < 3; ++a)
  {
    const Coord size = Coord(roots[a]) << box.level;
    box.begin[a] = static_cast<Coord>(random() % size);
    box.end[a] = box.begin[a] + 1 + static_cast<Coord>(random() % (size - box.begin[a]));
  }
  return box;
}

} // namespace

TEST(FieldSupport, ValuesAndGradientsInABoxAreThoseOfAllCells)
{
  VertexDifferences differences;
  int mostRounds = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const RootGrid grid = unitRoots(options.roots);
    const auto all = makeField(grid, cells);
    std::mt19937 random(options.seed);
    for (int b = 0; b < 8; ++b)
    {
      const LatticeBox box = randomBox(options.roots, random);
      const Support support = supportOf(grid, cells, box);
      mostRounds = std::max(mostRounds, support.rounds);
      if (support.cells.empty())
      {
        continue;
      }
      const auto part = makeField(grid, support.cells);
      differences.compare(*all, *part, box);
    }
  }
  EXPECT_EQ(differences.missing, 0u);
  EXPECT_EQ(differences.values, 0u) << "of " << differences.compared;
  EXPECT_EQ(differences.gradients, 0u) << "of " << differences.compared;
  EXPECT_GT(differences.compared, 1000000u);
  EXPECT_LE(mostRounds, 8);
}

TEST(FieldSupport, ContoursOfBoxesAreTheWholeContour)
{
  std::size_t triangles = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const RootGrid grid = unitRoots(options.roots);
    CellHistogram histogram(options.roots, 2);
    for (const LeafCell& leaf : cells)
    {
      histogram.add(leaf.cell);
    }
    MergedContour parts;
    for (const LatticeBox& box : cutBoxes(histogram, 5))
    {
      const Support support = supportOf(grid, cells, box);
      if (!support.cells.empty())
      {
        parts.add(contour(*makeField(grid, support.cells), 0.1, { .gradients = true, .box = box }));
      }
    }
    const auto [x, y, z] = options.roots;
    MergedContour whole;
    whole.add(
      contour(*makeField(grid, cells), 0.1, { .gradients = true, .box = LatticeBox{ 0, {}, { x, y, z } } }));
    EXPECT_TRUE(parts.gradients == whole.gradients);
    EXPECT_TRUE(parts.rim() == whole.rim());
    EXPECT_EQ(parts.triangles, whole.triangles);
    triangles += parts.triangles;
  }
  EXPECT_GT(triangles, 500000u);
}

TEST(FieldSupport, OfEqualCellsTwoLayersAreNeeded)
{
  // Gradients take values a width away, and these those of the cells around.
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 16 * 16 * 16; ++i)
  {
    cells.push_back({ { { i % 16, i / 16 % 16, i / 256 }, 4 }, static_cast<float>(i) });
  }
  const LatticeBox box{ 2, { 0, 0, 0 }, { 2, 4, 4 } };
  const Support support = supportOf(unitRoots({ 1, 1, 1 }), cells, box);
  EXPECT_EQ(support.cells.size(), 16u * 16 * (8 + 2));
}

TEST(FieldSupport, FarFromTheBoxNothingIsNeeded)
{
  // Coarse leaves in and beside it, and fine cells behind those.
  const LatticeBox box{ 1, { 0, 0, 0 }, { 1, 2, 2 } };
  std::vector<LeafCell> cells;
  for (int o = 0; o < 8; ++o)
  {
    cells.push_back({ { indexOfChild({ 0, 0, 0 }, o), 1 }, 1.f });
  }
  for (int root = 1; root < 3; ++root)
  {
    for (Coord i = 0; i < 32 * 32 * 32; ++i)
    {
      cells.push_back({ { { 32 * root + i % 32, i / 32 % 32, i / 1024 }, 5 }, 2.f });
    }
  }
  const Support support = supportOf(unitRoots({ 3, 1, 1 }), cells, box);
  // Gradients of the coarse leaves, of which half are in the box, take values one of their widths beyond, and these those of
  // the cells around.
  EXPECT_EQ(support.cells.size(), 8u + 32 * 32 * (16 + 1));
}

TEST(FieldSupport, EmptyBoxesAndOctreesNeedNothing)
{
  const RootGrid grid = unitRoots({ 1, 1, 1 });
  const std::vector<LeafCell> cells{ { { { 0, 0, 0 }, 0 }, 1.f } };
  const LatticeBox none{ 1, { 1, 0, 0 }, { 1, 2, 2 } };
  EXPECT_TRUE(none.isEmpty());
  EXPECT_TRUE(supportOf(grid, cells, none).cells.empty());
  EXPECT_TRUE(supportOf(grid, {}, { 1, { 0, 0, 0 }, { 1, 2, 2 } }).cells.empty());
  EXPECT_EQ(supportOf(grid, cells, { 1, { 0, 0, 0 }, { 1, 2, 2 } }).cells.size(), 1u);
}

TEST(CellSet, KeepsTheOuterOfNestedCells)
{
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round)
  {
    std::vector<CellId> cells;
    const auto randomCell = [&] {
      CellId cell;
      cell.level = static_cast<int>(random() % 4);
      for (Coord& index : cell.index)
      {
        index = static_cast<Coord>(random() % (Coord(3) << cell.level));
      }
      return cell;
    };
    const auto isInside = [](const CellId& a, const CellId& b) {
      bool inside = a.level >= b.level;
      for (int i = 0; inside && i < 3; ++i)
      {
        inside = a.index[i] >> (a.level - b.level) == b.index[i];
      }
      return inside;
    };
    for (int i = 0; i < 12; ++i)
    {
      cells.push_back(randomCell());
    }
    const CellSet set(2, cells);
    for (int i = 0; i < 100; ++i)
    {
      const CellId asked = randomCell();
      const bool covered =
        std::ranges::any_of(cells, [&](const CellId& cell) { return isInside(asked, cell); });
      EXPECT_EQ(set.covers(asked), covered);
      EXPECT_EQ(set.meets(asked),
        covered || std::ranges::any_of(cells, [&](const CellId& cell) { return isInside(cell, asked); }));
    }
    for (std::size_t i = 0; i < set.size(); ++i)
    {
      for (std::size_t j = 0; j < set.size(); ++j)
      {
        EXPECT_TRUE(i == j || !isInside(set[i], set[j]));
      }
    }
  }
}

TEST(BoxCuts, FillTheDomainWithAboutAsManyCellsEach)
{
  for (const int parts : { 1, 2, 3, 5, 8, 13 })
  {
    const std::array<int, 3> roots{ 3, 2, 1 };
    const auto cells = makeRandomTree({ .seed = 5, .roots = roots, .levels = 7, .refine = 0.9 });
    CellHistogram histogram(roots, CellHistogram::levelFor(roots, parts, 7));
    for (const LeafCell& leaf : cells)
    {
      histogram.add(leaf.cell);
    }
    EXPECT_NEAR(std::accumulate(histogram.counts().begin(), histogram.counts().end(), 0.),
      static_cast<double>(cells.size()), 1e-6 * static_cast<double>(cells.size()));
    const std::vector<LatticeBox> boxes = cutBoxes(histogram, parts);
    ASSERT_EQ(boxes.size(), static_cast<std::size_t>(parts));
    std::vector<std::size_t> owned(boxes.size(), 0);
    for (const LeafCell& leaf : cells)
    {
      int owners = 0;
      for (std::size_t b = 0; b < boxes.size(); ++b)
      {
        const bool owns = boxes[b].owns(leaf.cell);
        owners += owns;
        owned[b] += owns;
        EXPECT_LE(owns, boxes[b].meets(leaf.cell));
      }
      EXPECT_EQ(owners, 1);
    }
    const double most = static_cast<double>(*std::ranges::max_element(owned));
    EXPECT_LT(most, 1.25 * static_cast<double>(cells.size()) / parts) << parts;
  }
}

TEST(BoxTree, FindsTheBoxOfEachPlace)
{
  for (const int parts : { 1, 2, 3, 7, 40 })
  {
    const std::array<int, 3> roots{ 3, 2, 1 };
    CellHistogram histogram(roots, 2);
    for (const LeafCell& leaf : makeRandomTree({ .seed = 3, .roots = roots, .levels = 5, .refine = 0.8 }))
    {
      histogram.add(leaf.cell);
    }
    std::vector<LatticeBox> boxes = cutBoxes(histogram, parts);
    boxes.insert(boxes.begin() + 1, { 2, { 1, 1, 1 }, { 1, 1, 1 } }); // an empty one
    const BoxTree tree(boxes);
    for (Coord z = -1; z <= 4; ++z)
    {
      for (Coord y = -1; y <= 8; ++y)
      {
        for (Coord x = -1; x <= 12; ++x)
        {
          const auto around = std::ranges::find_if(boxes, [&](const LatticeBox& box) {
            return box.owns({ { x, y, z }, 2 });
          });
          EXPECT_EQ(tree.find({ x, y, z }), around == boxes.end() ? -1 : around - boxes.begin());
        }
      }
    }
  }
}

TEST(BoxCuts, EqualCellsAreCutIntoCubes)
{
  CellHistogram histogram({ 1, 1, 1 }, 5);
  histogram.add({ { 0, 0, 0 }, 0 });
  for (const LatticeBox& box : cutBoxes(histogram, 64))
  {
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_EQ(box.end[a] - box.begin[a], 8);
    }
  }
}

TEST(BoxCuts, LatticesOfManyRootsAreCutBetweenSome)
{
  const std::array<int, 3> roots{ 2000000, 3000, 1000 };
  const int level = CellHistogram::levelFor(roots, 7, 0);
  EXPECT_LT(level, 0);
  CellHistogram histogram(roots, level);
  EXPECT_LT(histogram.counts().size(), 1u << 19);
  for (int i = 0; i < 1000; ++i)
  {
    histogram.add({ { 2000 * i, 2999, 999 }, 0 });
  }
  const std::vector<LatticeBox> boxes = cutBoxes(histogram, 7);
  for (int i = 0; i < 1000; ++i)
  {
    EXPECT_EQ(std::ranges::count_if(boxes,
                [&](const LatticeBox& box) {
                  return box.owns({ { 8000 * i, 11999, 3999 }, 2 });
                }),
      1);
  }
  EXPECT_TRUE(std::ranges::all_of(boxes, [&](const LatticeBox& box) { return box.end[0] <= roots[0]; }));
}

TEST(BoxCuts, MoreBoxesThanPlacesLeaveSomeEmpty)
{
  CellHistogram histogram({ 1, 1, 1 }, 0);
  histogram.add({ { 0, 0, 0 }, 0 });
  const std::vector<LatticeBox> boxes = cutBoxes(histogram, 5);
  ASSERT_EQ(boxes.size(), 5u);
  EXPECT_EQ(std::ranges::count_if(boxes, [](const LatticeBox& box) { return !box.isEmpty(); }), 1);
}

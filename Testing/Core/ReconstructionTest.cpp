// Properties of the reconstruction on random trees, and its equality with the brute-force evaluation.
#include "Interpolation/Sampler.h"
#include "Interpolation/VertexValues.h"
#include "Octree/OctreeBuilder.h"
#include "Support/BruteForceGTI.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Point = std::array<double, 3>;

struct Case
{
  explicit Case(const RandomTree& options, std::vector<LeafCell> from)
    : cells(std::move(from))
    , brute(options.roots, cells)
  {
    auto built = buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
    auto f = std::make_shared<Field>(built.octree, built.values);
    field = f;
  }
  std::vector<LeafCell> cells;
  BruteForceGTI brute;
  std::shared_ptr<const Field> field;
};

Case makeCase(const RandomTree& options)
{
  return Case(options, makeRandomTree(options));
}

/// A random point: anywhere, or on a face, edge, corner or centre plane of a random cell.
class Points
{
public:
  Points(const Case& c, std::uint32_t seed)
    : case_(c)
    , random_(seed)
  {
  }
  Point next()
  {
    std::uniform_real_distribution<double> unit(0., 1.);
    const CellId& cell = case_.cells[random_() % case_.cells.size()].cell;
    Point p;
    for (int a = 0; a < 3; ++a)
    {
      const unsigned kind = random_() % 6;
      const double local = kind < 3 ? 0.5 * kind : unit(random_);
      p[a] = std::ldexp(static_cast<double>(cell.index[a]) + local, -cell.level);
    }
    return p;
  }

private:
  const Case& case_;
  std::mt19937 random_;
};

} // namespace

TEST(Reconstruction, EqualsTheBruteForceEvaluation)
{
  // 36 trees x 10,000 points; values span [-1, 1], so 2e-6 of the range is 4e-6. On shared planes the two may
  // look from different cells: there the test also covers continuity.
  double worst = 0.;
  for (const RandomTree& options : propertyTrees())
  {
    const Case c = makeCase(options);
    const auto sampler = Sampler::create(InterpolationMethod::GTI, c.field);
    Points points(c, options.seed);
    for (int i = 0; i < 10000; ++i)
    {
      const Point p = points.next();
      const auto expected = c.brute.value(p);
      FieldSample sample;
      const bool inside = sampler->sample(p, sample);
      // A point on the upper plane of a cell beside a gap is in that closed cell, not in the brute force's.
      ASSERT_TRUE(inside || !expected) << "tree " << options.seed;
      if (expected)
      {
        worst = std::max(worst, std::abs(sample.value - *expected));
      }
    }
  }
  RecordProperty("worst", std::to_string(worst));
  std::printf("largest difference %.3g of the range\n", worst / 2.);
  EXPECT_LE(worst / 2., 2e-6);
}

TEST(Reconstruction, IsContinuousAcrossEveryKindOfBoundary)
{
  // The field at a point of a cell's surface, seen from inside each leaf whose closed box holds the point.
  double worst = 0.;
  std::size_t compared = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const Case c = makeCase(options);
    TreePath root(c.field->octree());
    std::map<std::array<Coord, 3>, float> seen; // vertex in half widths of the finest level
    const int finest = c.field->octree().leafLevels() + c.field->octree().grid().paddingDepth();
    forEachNode(root, [&](const TreePath& path) {
      if (!path.node().isLeaf())
      {
        return;
      }
      const VertexValues values = vertexValues<VertexRule::GTI>(path, *c.field);
      for (int v = 0; v < 27; ++v)
      {
        const std::array<int, 3> at{ v % 3, v / 3 % 3, v / 9 };
        std::array<Coord, 3> key;
        for (int a = 0; a < 3; ++a)
        {
          key[a] = (2 * path.index()[a] + at[a]) << (finest - path.depth());
        }
        const auto [entry, isNew] = seen.try_emplace(key, values[v]);
        worst = std::max<double>(worst, std::abs(entry->second - values[v]));
        compared += !isNew;
      }
    });
    // Off the vertices: a coarse leaf's face against the fine leaves on its other side.
    Points points(c, options.seed + 100);
    for (int i = 0; i < 2000; ++i)
    {
      const Point p = points.next();
      std::optional<double> first;
      for (const LeafCell& leaf : c.cells)
      {
        bool holds = true;
        for (int a = 0; a < 3; ++a)
        {
          const double local = std::ldexp(p[a], leaf.cell.level) - static_cast<double>(leaf.cell.index[a]);
          holds = holds && local >= 0. && local <= 1.;
        }
        if (holds)
        {
          const double value = c.brute.valueInside(leaf.cell, p);
          worst = std::max(worst, std::abs(first.value_or(value) - value));
          compared += first.has_value();
          first = value;
        }
      }
    }
  }
  std::printf("largest difference %.3g of the range over %zu comparisons\n", worst / 2., compared);
  EXPECT_GT(compared, 100000u);
  EXPECT_LE(worst / 2., 2e-6);
}

TEST(Reconstruction, ReproducesTrilinearPolynomials)
{
  double worst = 0.;
  std::size_t checked = 0;
  for (const RandomTree& options : propertyTrees())
  {
    std::mt19937 random(options.seed);
    std::uniform_real_distribution<double> unit(-1., 1.);
    std::array<double, 8> k;
    for (double& x : k)
    {
      x = unit(random);
    }
    const auto f = [&](const Point& p) {
      return k[0] + k[1] * p[0] + k[2] * p[1] + k[3] * p[2] + k[4] * p[0] * p[1] + k[5] * p[1] * p[2] +
        k[6] * p[0] * p[2] + k[7] * p[0] * p[1] * p[2];
    };
    auto cells = makeRandomTree(options);
    setValues(cells, f);
    const Case c(options, cells);
    const double range = c.field->range().max - c.field->range().min;
    const auto sampler = Sampler::create(InterpolationMethod::GTI, c.field);
    Points points(c, options.seed);
    for (int i = 0; i < 3000; ++i)
    {
      const Point p = points.next();
      const CellId* leaf = c.brute.leafAt(p);
      bool gap = false;
      if (leaf)
      {
        c.brute.valueInside(*leaf, p, &gap);
      }
      if (leaf && !gap)
      {
        FieldSample sample;
        ASSERT_TRUE(sampler->sample(p, sample));
        worst = std::max(worst, std::abs(sample.value - f(p)) / range);
        // The gradient is exact too, up to the rounding of float values over a cell's width.
        const Point gradient{ k[1] + k[4] * p[1] + k[6] * p[2] + k[7] * p[1] * p[2],
          k[2] + k[4] * p[0] + k[5] * p[2] + k[7] * p[0] * p[2],
          k[3] + k[5] * p[1] + k[6] * p[0] + k[7] * p[0] * p[1] };
        for (int a = 0; a < 3; ++a)
        {
          EXPECT_NEAR(sample.gradient[a], gradient[a], 4e-6 * std::ldexp(range + 1., leaf->level));
        }
        ++checked;
      }
    }
  }
  std::printf("largest error %.3g of the range over %zu points\n", worst, checked);
  EXPECT_GT(checked, 5000u);
  EXPECT_LE(worst, 1e-5);
}

namespace
{

/// Grows the range by the values of all leaves below a node.
void addLeaves(const Field& field, NodeRef node, Range& range)
{
  if (node.isLeaf())
  {
    const float value = field.value(node);
    range = { std::min(range.min, value), std::max(range.max, value) };
  }
  for (int o = 0; node.isInner() && o < 8; ++o)
  {
    addLeaves(field, field.octree().child(node, o), range);
  }
}

/// Grows the ranges of the path's nodes.
void addToAncestors(const TreePath& path, Range more, std::vector<Range>& ranges)
{
  for (int depth = 0; depth < path.depth(); ++depth)
  {
    Range& r = ranges[path.around(depth)[13].index()];
    r = { std::min(r.min, more.min), std::max(r.max, more.max) };
  }
}

} // namespace

TEST(Reconstruction, StaysWithinTheNodesRanges)
{
  // Every vertex value lies in the stored range of each ancestor, which is wider than what the leaves' values
  // there and around allow by less than a 255th of its parent's at either end.
  for (const RandomTree& options : propertyTrees())
  {
    const Case c = makeCase(options);
    std::vector<Range> hulls(c.field->octree().innerCount(), Range{ INFINITY, -INFINITY });
    std::vector<Range> allowed = hulls;
    TreePath root(c.field->octree());
    forEachNode(root, [&](const TreePath& path) {
      if (path.node().isLeaf())
      {
        const Range r = hull(vertexValues<VertexRule::GTI>(path, *c.field));
        addToAncestors(path, r, hulls);
        Range around{ INFINITY, -INFINITY };
        // A tree without inner nodes has no ranges.
        for (int e = 0; path.depth() > 0 && e < 27; ++e)
        {
          addLeaves(*c.field, path.around(path.depth() - 1)[e], around);
        }
        addToAncestors(path, around, allowed);
        EXPECT_GE(r.min, c.field->range().min);
        EXPECT_LE(r.max, c.field->range().max);
      }
    });
    std::vector<Range> decoded(hulls.size());
    forEachNode(root, [&](const TreePath& path) {
      if (path.node().isInner())
      {
        const Range parent =
          path.depth() == 0 ? c.field->range() : decoded[path.around(path.depth() - 1)[13].index()];
        const Range exact = hulls[path.node().index()];
        const Range stored = c.field->nodeRanges().of(path.node().index(), parent);
        decoded[path.node().index()] = stored;
        const double step = (static_cast<double>(parent.max) - parent.min) / 255. + 1e-7; // float spacing
        EXPECT_LE(stored.min, exact.min);
        EXPECT_GE(stored.max, exact.max);
        const Range widest = allowed[path.node().index()];
        EXPECT_LE(widest.min - stored.min, step);
        EXPECT_LE(stored.max - widest.max, step);
      }
    });
  }
}

TEST(Reconstruction, IsOfSecondOrderInside)
{
  // f smooth; every leaf of an adaptive tree refined once and once more: the largest error inside falls
  // fourfold.
  const auto f = [](const Point& p) {
    return std::sin(3. * p[0] + 1.) * std::cos(2. * p[1]) * std::exp(p[2]);
  };
  const RandomTree options{ 7, { 2, 2, 2 }, 3, 0.6, 0., true };
  auto cells = makeRandomTree(options);
  std::array<double, 4> error{};
  for (double& e : error)
  {
    setValues(cells, f);
    const Case c(options, cells);
    const auto sampler = Sampler::create(InterpolationMethod::GTI, c.field);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> inside(0.6, 1.4);
    for (int i = 0; i < 4000; ++i)
    {
      const Point p{ inside(random), inside(random), inside(random) };
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(p, sample));
      e = std::max(e, std::abs(sample.value - f(p)));
    }
    std::vector<LeafCell> finer;
    for (const LeafCell& cell : cells)
    {
      for (int o = 0; o < 8; ++o)
      {
        const auto& i = cell.cell.index;
        finer.push_back(
          { { { 2 * i[0] + (o & 1), 2 * i[1] + (o >> 1 & 1), 2 * i[2] + (o >> 2) }, cell.cell.level + 1 },
            0.f });
      }
    }
    cells = std::move(finer);
  }
  std::printf("errors %.3g %.3g %.3g %.3g\n", error[0], error[1], error[2], error[3]);
  EXPECT_GT(error[2] / error[3], 3.5);
  EXPECT_LT(error[2] / error[3], 4.5);
}

TEST(Reconstruction, IsTheSameWithValuesKeptAlongAWalk)
{
  for (const RandomTree& options : propertyTrees())
  {
    const Case c = makeCase(options);
    VertexMemo gti;
    VertexMemo octant;
    TreePath root(c.field->octree());
    forEachNode(root, [&](const TreePath& path) {
      if (path.node().isLeaf())
      {
        EXPECT_EQ(
          vertexValues<VertexRule::GTI>(path, *c.field, gti), vertexValues<VertexRule::GTI>(path, *c.field));
        EXPECT_EQ(vertexValues<VertexRule::Octant>(path, *c.field, octant),
          vertexValues<VertexRule::Octant>(path, *c.field));
      }
    });
  }
}

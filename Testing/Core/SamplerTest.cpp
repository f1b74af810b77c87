#include "Interpolation/Sampler.h"
#include "Octree/OctreeBuilder.h"
#include "Support/BruteForceGTI.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Point = std::array<double, 3>;

std::shared_ptr<const Field> makeField(RootGrid grid, const std::vector<LeafCell>& cells)
{
  auto built = buildOctree(std::move(grid), cells);
  return std::make_shared<const Field>(built.octree, built.values);
}

std::shared_ptr<const Field> makeField(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells)
{
  return makeField(RootGrid::uniform(roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
}

double sampleAt(const Sampler& sampler, const Point& p)
{
  FieldSample s;
  EXPECT_TRUE(sampler.sample(p, s)) << p[0] << ' ' << p[1] << ' ' << p[2];
  return s.value;
}

/// The trilinear interpolant of the level's dual grid at a point in units of roots.
double dual(const BruteForceGTI& brute, int level, const Point& p, bool& refined)
{
  std::array<Coord, 3> base;
  Point f;
  for (int a = 0; a < 3; ++a)
  {
    const double at = std::ldexp(p[a], level) - 0.5;
    base[a] = static_cast<Coord>(std::floor(at));
    f[a] = at - std::floor(at);
  }
  double sum = 0.;
  double total = 0.;
  refined = false;
  for (int c = 0; c < 8; ++c)
  {
    std::array<Coord, 3> index;
    double weight = 1.;
    for (int a = 0; a < 3; ++a)
    {
      index[a] = base[a] + (c >> a & 1);
      weight *= c >> a & 1 ? f[a] : 1. - f[a];
    }
    const auto value = brute.cellValue(level, index);
    refined = refined || brute.isRefined(level, index);
    sum += value ? weight * *value : 0.;
    total += value ? weight : 0.;
  }
  return sum / total;
}

} // namespace

TEST(Sampler, AllMethodsEqualTheirDefinitions)
{
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const BruteForceGTI brute(options.roots, cells);
    const BruteForceGTI octant(options.roots, cells, true);
    const auto field = makeField(options.roots, cells);
    const auto make = [&](InterpolationMethod m) { return Sampler::create(m, field); };
    const auto nearestSampler = make(InterpolationMethod::Nearest);
    const auto currentSampler = make(InterpolationMethod::Current);
    const auto finestSampler = make(InterpolationMethod::Finest);
    const auto octantSampler = make(InterpolationMethod::Octant);
    std::mt19937 random(options.seed);
    std::uniform_real_distribution<double> unit(0., 1.);
    int inside = 0;
    for (int i = 0; i < 2000; ++i)
    {
      const Point p{ options.roots[0] * unit(random), options.roots[1] * unit(random),
        options.roots[2] * unit(random) };
      const CellId* leaf = brute.leafAt(p);
      FieldSample s;
      ASSERT_EQ(nearestSampler->sample(p, s), leaf != nullptr);
      if (!leaf)
      {
        continue;
      }
      ++inside;
      EXPECT_EQ(s.value, *brute.cellValue(leaf->level, leaf->index));
      bool refined;
      EXPECT_NEAR(sampleAt(*currentSampler, p), dual(brute, leaf->level, p, refined), 1e-6);
      int level = leaf->level;
      double expected = dual(brute, level, p, refined);
      while (refined)
      {
        expected = dual(brute, ++level, p, refined);
      }
      EXPECT_NEAR(sampleAt(*finestSampler, p), expected, 1e-6);
      EXPECT_NEAR(sampleAt(*octantSampler, p), *octant.value(p), 1e-6);
    }
    EXPECT_GT(inside, 300);
  }
}

TEST(Sampler, GradientsAreDerivatives)
{
  const RandomTree options{ 3, { 2, 1, 1 }, 4, 0.6, 0.1, false };
  const auto field = makeField(
    RootGrid({ std::vector<double>{ 0., 1., 4. }, { 0., 0.5 }, { 0., 2. } }), makeRandomTree(options));
  for (const auto method : { InterpolationMethod::Nearest, InterpolationMethod::Current,
         InterpolationMethod::Finest, InterpolationMethod::Octant, InterpolationMethod::GTI })
  {
    const auto sampler = Sampler::create(method, field);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(0., 1.);
    int checked = 0;
    for (int i = 0; i < 2000; ++i)
    {
      const Point p{ 4. * unit(random), 0.5 * unit(random), 2. * unit(random) };
      FieldSample at;
      if (!sampler->sample(p, at))
      {
        continue;
      }
      for (int a = 0; a < 3; ++a)
      {
        constexpr double h = 1e-6;
        Point low = p;
        Point high = p;
        low[a] -= h;
        high[a] += h;
        FieldSample l;
        FieldSample u;
        FieldSample twice;
        Point far = p;
        far[a] += 2. * h;
        if (sampler->sample(low, l) && sampler->sample(high, u) && sampler->sample(far, twice) &&
          std::abs(u.value - at.value - (at.value - l.value)) < 1e-7 &&
          std::abs(twice.value - u.value - (u.value - at.value)) < 1e-7) // all in one octant
        {
          EXPECT_NEAR((u.value - l.value) / (2. * h), at.gradient[a], 1e-4 * (1. + std::abs(at.gradient[a])));
          ++checked;
        }
      }
    }
    EXPECT_GT(checked, 1000);
  }
}

TEST(Sampler, StaysAccurateDeepAndFarFromTheOrigin)
{
  // Refined 30 levels towards an interior point; the grid lies 1e6 widths of its smallest cell from the
  // origin.
  constexpr int depth = 30;
  const double width = std::ldexp(1., -depth);
  const Point origin{ 1e6 * width, -1e6 * width, 1e6 * width };
  std::vector<LeafCell> cells;
  std::array<Coord, 3> parent{ 0, 0, 0 };
  for (int level = 1; level <= depth; ++level)
  {
    const int keep = level == 1 ? 0 : 7; // towards the point (1/2, 1/2, 1/2) from below
    for (int o = 0; o < 8; ++o)
    {
      if (o != keep || level == depth)
      {
        cells.push_back(
          { { { 2 * parent[0] + (o & 1), 2 * parent[1] + (o >> 1 & 1), 2 * parent[2] + (o >> 2) }, level },
            0.f });
      }
    }
    parent = { 2 * parent[0] + (keep & 1), 2 * parent[1] + (keep & 1), 2 * parent[2] + (keep & 1) };
  }
  const auto f = [&](const Point& p) { return (p[0] - 0.5) / width + 2. * (p[1] - 0.5) / width; };
  setValues(cells, f);
  for (LeafCell& c : cells)
  {
    // Far cells would dwarf the near ones; linear near the point is what the test needs.
    c.value = std::abs(c.value) < 64.f ? c.value : 0.f;
  }
  const auto sampler = Sampler::create(
    InterpolationMethod::GTI, makeField(RootGrid::uniform({ 1, 1, 1 }, origin, { 1., 1., 1. }), cells));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1., 0.);
  for (int i = 0; i < 1000; ++i)
  {
    const Point local{ unit(random) * width, unit(random) * width, unit(random) * width };
    const Point p{ origin[0] + 0.5 + local[0], origin[1] + 0.5 + local[1], origin[2] + 0.5 + local[2] };
    // Rounding of p itself: 2^-53 of 0.5 is 1e-7 widths.
    const Point rounded{ p[0] - origin[0], p[1] - origin[1], p[2] - origin[2] };
    FieldSample s;
    ASSERT_TRUE(sampler->sample(p, s));
    if (local[0] < -0.5 * width && local[1] < -0.5 * width && local[2] < -0.5 * width)
    {
      // The lower octant of the last cell: equal cells around, a linear field.
      EXPECT_NEAR(s.value, f(rounded), 2e-6);
    }
  }
}

TEST(Sampler, CellsAreClosedAndTheRestIsOutside)
{
  // Two of eight cells; a point on a plane belongs to whichever cell exists.
  const auto field =
    makeField({ 1, 1, 1 }, std::vector<LeafCell>{ { { { 0, 0, 0 }, 1 }, 1.f }, { { { 1, 1, 1 }, 1 }, 2.f } });
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const auto method : { InterpolationMethod::Nearest, InterpolationMethod::Current,
         InterpolationMethod::Finest, InterpolationMethod::Octant, InterpolationMethod::GTI })
  {
    const auto sampler = Sampler::create(method, field);
    FieldSample s;
    EXPECT_TRUE(sampler->sample({ 0.5, 0.25, 0.25 }, s));
    EXPECT_EQ(s.value, 1.);
    EXPECT_TRUE(sampler->sample({ 0.5, 0.5, 0.75 }, s));
    EXPECT_EQ(s.value, 2.);
    EXPECT_TRUE(sampler->sample({ 0., 0., 0. }, s));
    EXPECT_TRUE(sampler->sample({ 1., 1., 1. }, s));
    for (const Point& p : { Point{ 0.75, 0.25, 0.25 }, { -0.1, 0.2, 0.2 }, { 1.1, 0.9, 0.9 },
           { inf, 0.5, 0.5 }, { NAN, 0.2, 0.2 } })
    {
      EXPECT_FALSE(sampler->sample(p, s));
    }
  }
  const auto none =
    Sampler::create(InterpolationMethod::GTI, makeField({ 1, 1, 1 }, std::vector<LeafCell>{}));
  FieldSample s;
  EXPECT_FALSE(none->sample({ 0.5, 0.5, 0.5 }, s));
}

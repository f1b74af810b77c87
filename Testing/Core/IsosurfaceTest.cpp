#include "Surface/Isosurface.h"
#include "Contour/Contour.h"
#include "Support/BruteForceGTI.h"
#include "Support/Cameras.h"
#include "Support/ExactRay.h"
#include "Support/Fields.h"
#include "Support/ListSource.h"
#include "Support/RandomTrees.h"
#include "Support/Targets.h"
#include "Surface/CellDepth.h"
#include "Surface/CubicRoot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

bool firstRoot(const Cubic& cubic, double tolerance, double& root)
{
  return visitRoots(cubic, tolerance, [&](double s) {
    root = s;
    return true;
  });
}

/// Rays from outside the roots' box towards a point inside.
Ray towards(const Vec3& target, const std::array<int, 3>& roots, std::mt19937& random)
{
  std::normal_distribution<double> normal;
  const Vec3 away = unit({ normal(random), normal(random), normal(random) });
  const double distance = 1. + roots[0] + roots[1] + roots[2];
  const Vec3 from{ target[0] + distance * away[0], target[1] + distance * away[1],
    target[2] + distance * away[2] };
  return { from, unit(target - from) };
}

Vec3 inside(const std::array<int, 3>& roots, std::mt19937& random)
{
  std::uniform_real_distribution<double> uniform(0., 1.);
  return { roots[0] * uniform(random), roots[1] * uniform(random), roots[2] * uniform(random) };
}

Vec3 widened(const std::array<float, 3>& v)
{
  return { v[0], v[1], v[2] };
}

bool touchesBoundary(const CellId& cell, const std::array<int, 3>& roots)
{
  bool touches = false;
  for (int a = 0; a < 3; ++a)
  {
    touches = touches || cell.index[a] == 0 || cell.index[a] + 1 == Coord(roots[a]) << cell.level;
  }
  return touches;
}

} // namespace

TEST(CubicRoot, IsTheFirstOneOfKnownRoots)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unitInterval(-0.5, 1.5);
  int hits = 0;
  for (int i = 0; i < 200000; ++i)
  {
    std::array<double, 3> r{ unitInterval(random), unitInterval(random), unitInterval(random) };
    const double scale = std::pow(10., 20. * unitInterval(random));
    const Cubic c{ -scale * r[0] * r[1] * r[2], scale * (r[0] * r[1] + r[1] * r[2] + r[0] * r[2]),
      -scale * (r[0] + r[1] + r[2]), scale };
    std::sort(r.begin(), r.end());
    const auto first = std::find_if(r.begin(), r.end(), [](double x) { return x >= 0.; });
    const bool expected = first != r.end() && *first <= 1.;
    // Roots closer together than rounding of the coefficients allows to tell are not a test of the finder.
    if (std::min(r[1] - r[0], r[2] - r[1]) < 1e-5 || (first != r.end() && std::abs(*first - 1.) < 1e-9))
    {
      continue;
    }
    double root;
    ASSERT_EQ(firstRoot(c, 0., root), expected) << r[0] << ' ' << r[1] << ' ' << r[2];
    if (expected)
    {
      EXPECT_NEAR(root, *first, 1e-9);
      ++hits;
    }
  }
  EXPECT_GT(hits, 50000);
}

TEST(CubicRoot, SurvivesDegenerateCubics)
{
  double root;
  EXPECT_TRUE(firstRoot({ 0., 0., 0., 0. }, 0., root));
  EXPECT_EQ(root, 0.);
  EXPECT_FALSE(firstRoot({ 1., 0., 0., 0. }, 0., root));
  EXPECT_TRUE(firstRoot({ -0.25, 1., 0., 0. }, 0., root));
  EXPECT_EQ(root, 0.25);
  EXPECT_TRUE(firstRoot({ -1., 0., 1., 0. }, 0., root)); // at the far end
  EXPECT_EQ(root, 1.);
  EXPECT_TRUE(firstRoot({ 0., 1., 1., 1. }, 0., root)); // at the near end
  EXPECT_EQ(root, 0.);
  EXPECT_TRUE(firstRoot({ 0.25, -1., 1., 0. }, 0., root)); // double root at 1/2, exactly representable
  EXPECT_NEAR(root, 0.5, 1e-7);
  EXPECT_TRUE(firstRoot({ -1e-300, 1e-300, 1e-300, 1e-300 }, 0., root));
  EXPECT_GT(root, 0.5);
}

TEST(Isosurface, OfALinearFieldIsAPlane)
{
  // Away from the domain's edge every cell reproduces the plane; the surface stays inside.
  const RandomTree options{ 21, { 2, 2, 2 }, 5, 0.55, 0., false };
  auto cells = makeRandomTree(options);
  const Vec3 normal{ 0.2, 1., 0.1 };
  setValues(cells, [&](const auto& p) { return dot(normal, p); });
  const RootGrid grid({ std::vector<double>{ 1e3, 1e3 + 1., 1e3 + 2. }, { 0., 1., 2. }, { 0., 1., 2. } });
  const auto field = makeField(grid, cells);
  const float isovalue = 1.31f;
  const Isosurface surface(field, { isovalue });
  EXPECT_GT(surface.octantCount(), 100u);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> inside(0.75, 1.25);
  for (int i = 0; i < 20000; ++i)
  {
    const Vec3 target{ 1e3 + inside(random), (isovalue - 0.2 * 1. - 0.1 * 1.) + 0.1 * (inside(random) - 1.),
      inside(random) };
    const Vec3 from{ 1e3 + 1. + 2. * (inside(random) - 1.), 8., 1. + 2. * (inside(random) - 1.) };
    const Ray ray{ from, unit(target - from) };
    SurfaceHit hit;
    ASSERT_TRUE(surface.intersect(ray, 0., 100., hit));
    const double expected = (isovalue - dot(normal, from - Vec3{ 1e3, 0., 0. })) / dot(normal, ray.direction);
    EXPECT_NEAR(hit.t, expected, 2e-6);
    const Vec3 n = unit(hit.gradient);
    EXPECT_NEAR(dot(n, unit(normal)), 1., 1e-5);
    EXPECT_NEAR(dot(widened(hit.normal), unit(normal)), 1., 1e-5);
    EXPECT_FALSE(surface.intersect(ray, 0., expected - 1e-5, hit));
  }
}

TEST(Isosurface, OfXyzLiesOnTheAnalyticSurface)
{
  // The paper's Synthetic data (Figure 10): GTI reproduces f = xyz away from the domain's edge.
  std::vector<LeafCell> cells;
  for (int i = 0; i < 64; ++i)
  {
    const std::array<Coord, 3> root{ i & 3, i >> 2 & 3, i >> 4 };
    for (int o = 0; o < 8 && root[0] >= 2; ++o)
    {
      cells.push_back(
        { { { 2 * root[0] + (o & 1), 2 * root[1] + (o >> 1 & 1), 2 * root[2] + (o >> 2) }, 1 }, 0.f });
    }
    if (root[0] < 2)
    {
      cells.push_back({ { root, 0 }, 0.f });
    }
  }
  ASSERT_EQ(cells.size(), 288u);
  setValues(cells, [](const auto& p) { return p[0] * p[1] * p[2]; });
  const auto field = makeField(RootGrid::uniform({ 4, 4, 4 }, { 0., 0., 0. }, { 1., 1., 1. }), cells);
  const Isosurface surface(field, { 6.5 });
  const Camera camera(
    multiply(perspective(40., 1., 30.), lookAt({ 9., 8., 7. }, { 2., 2., 2. })), identityMatrix, 300, 300);
  HitImage hits;
  surface.render(camera, SurfaceLayers::Nearest, hits);
  int interior = 0;
  for (int i = 0; i < 300 * 300; ++i)
  {
    if (hits.first[i] == hits.first[i + 1])
    {
      continue;
    }
    const SurfaceHit& hit = hits.hits[hits.first[i]];
    const Vec3 p = pointAt(camera.ray(i % 300, i / 300), hit.t);
    if (p[0] > 0.5 && p[1] > 0.5 && p[2] > 0.5 && p[0] < 3.75 && p[1] < 3.5 && p[2] < 3.5)
    {
      ++interior;
      // Distance from the surface to first order: residual over the gradient's length.
      const Vec3 g{ p[1] * p[2], p[0] * p[2], p[0] * p[1] };
      EXPECT_NEAR((p[0] * p[1] * p[2] - 6.5) / std::sqrt(dot(g, g)), 0., 1e-5);
      EXPECT_NEAR(dot(unit(g), unit(hit.gradient)), 1., 1e-5);
      EXPECT_NEAR(dot(unit(g), widened(hit.normal)), 1., 1e-5);
    }
  }
  EXPECT_GT(interior, 5000);
}

TEST(Isosurface, OfAConstantIsNothing)
{
  // As contours are: all is inside, at the isovalue, too.
  const Ray ray{ { -1., 0.4, 0.3 }, unit({ 1., 0.02, 0.01 }) };
  const RandomTree options{ 12, { 2, 2, 2 }, 4, 0.6, 0.1, false };
  for (const double value : { 0., 0.5, 0.1, -1e30, 1e-40 })
  {
    std::vector<LeafCell> cells = makeRandomTree(options);
    setValues(cells, [=](const auto&) { return value; });
    for (const auto& field : { makeField(unitRoots({ 1, 1, 1 }), { { {}, static_cast<float>(value) } }),
           makeField(unitRoots(options.roots), cells) })
    {
      const double isovalue = static_cast<float>(value);
      const Isosurface surface(field, { isovalue });
      std::vector<SurfaceHit> hits;
      surface.intersectAll(ray, 0., 9., hits);
      EXPECT_TRUE(hits.empty()) << value;
      EXPECT_EQ(surface.octantCount(), 0u) << value;
      EXPECT_TRUE(contour(*field, isovalue).triangles.empty()) << value;
    }
  }
}

TEST(Isosurface, OfAPlateauIsWhereItBegins)
{
  // Along x a slope up to the isovalue, which is kept from x = 2 on. GTI has it from the centre of the first such cell.
  const RandomTree options{ 41, { 4, 2, 2 }, 2, 1., 0., false };
  std::vector<LeafCell> cells = makeRandomTree(options);
  setValues(cells, [](const auto& p) { return std::min(p[0], 2.125); });
  const auto field = makeField(unitRoots(options.roots), cells);
  const double isovalue = 2.125;
  const Isosurface surface(field, { isovalue });
  const ContourMesh mesh = contour(*field, isovalue);
  ASSERT_FALSE(mesh.points.empty());
  for (const auto& point : mesh.points)
  {
    ASSERT_NEAR(point[0], isovalue, 1e-6);
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.2, 1.8);
  std::uniform_real_distribution<double> slant(-0.05, 0.05);
  for (int i = 0; i < 1000; ++i)
  {
    for (const double from : { -1., 5. })
    {
      const Ray ray{ { from, place(random), place(random) },
        unit({ from < 0. ? 1. : -1., slant(random), slant(random) }) };
      std::vector<SurfaceHit> hits;
      surface.intersectAll(ray, 0., 9., hits);
      ASSERT_EQ(hits.size(), 1u);
      ASSERT_NEAR(pointAt(ray, hits[0].t)[0], isovalue, 1e-12);
    }
  }
}

// As of contours: inside is what is at the isovalue or above, of doubles that floats do not have, too.
TEST(Isosurface, OfTheLeastValueIsNothing)
{
  const RandomTree options{ 41, { 4, 2, 2 }, 3, 0.6, 0., false };
  const Ray ray{ { -1., 0.4, 0.3 }, unit({ 1., 0.02, 0.01 }) };
  const auto surfaces = [&](double low, double high, double isovalue) {
    std::vector<LeafCell> cells = makeRandomTree(options);
    setValues(cells, [=](const auto& p) { return p[0] < 2. ? low : high; });
    const auto field = makeField(unitRoots(options.roots), cells);
    std::vector<SurfaceHit> hits;
    Isosurface(field, { isovalue }).intersectAll(ray, 0., 9., hits);
    EXPECT_EQ(hits.empty(), contour(*field, isovalue).triangles.empty()) << low << " " << high << " " << isovalue;
    return hits.size();
  };
  for (const auto& [low, high] :
    { std::pair(0.25, 0.5), { 0.3, 0.7 }, { 0.1, 0.6 }, { 0., 1. }, { -1., 0. }, { 1e-30, 3e-30 } })
  {
    EXPECT_EQ(surfaces(low, high, low), 0u) << low;
    EXPECT_EQ(surfaces(low, high, high), 1u) << high;
    EXPECT_EQ(surfaces(low, high, 0.5 * (low + high)), 1u) << low << " " << high;
  }
}

TEST(Isosurface, HitsAreThoseOfExtendedPrecision)
{
  struct Values
  {
    double scale;
    double offset;
  };
  int rays = 0;
  for (const Values& values :
    { Values{ 1., 0. }, { 1e30, 0. }, { 1e-30, 0. }, { 1., 1e6 }, { 1e-20, -1e-14 } })
  {
    for (const RandomTree& options :
      { RandomTree{ 11, { 2, 1, 1 }, 4, 0.6, 0., false }, RandomTree{ 12, { 1, 1, 1 }, 5, 0.5, 0., false },
        RandomTree{ 13, { 1, 1, 2 }, 4, 0.6, 0.2, false } })
    {
      std::vector<LeafCell> cells = makeRandomTree(options);
      for (LeafCell& c : cells)
      {
        c.value = static_cast<float>(values.offset + values.scale * c.value);
      }
      const double isovalue = values.offset + 0.13 * values.scale;
      const Isosurface surface(makeField(unitRoots(options.roots), cells), { isovalue });
      ExactRay exact(options.roots, cells);
      std::mt19937 random(options.seed);
      const double width = std::ldexp(1., -options.levels);
      std::vector<SurfaceHit> all;
      for (int i = 0; i < 2000; ++i, ++rays)
      {
        const Ray ray = towards(inside(options.roots, random), options.roots, random);
        const std::vector<double> expected = exact.crossings(ray, 0., 20., isovalue);
        SurfaceHit hit;
        ASSERT_EQ(surface.intersect(ray, 0., 20., hit), !expected.empty());
        ASSERT_EQ(surface.occluded(ray, 0., 20.), !expected.empty());
        surface.intersectAll(ray, 0., 20., all);
        ASSERT_EQ(all.size(), expected.size());
        for (std::size_t k = 0; k < all.size(); ++k)
        {
          ASSERT_NEAR(all[k].t, expected[k], 1e-5 * width)
            << values.offset << " " << values.scale << " " << options.seed << " " << i << " " << k << " of "
            << all.size();
        }
        if (!expected.empty())
        {
          ASSERT_EQ(hit.t, all[0].t);
          const double before = hit.t - 1e-3 * width;
          ASSERT_EQ(surface.occluded(ray, 0., before), surface.intersect(ray, 0., before, hit));
        }
      }
    }
  }
  EXPECT_EQ(rays, 30000);
}

TEST(Isosurface, NoAimedRaySlipsThrough)
{
  // The surface encloses the cells below the isovalue: all that touch the boundary are above it. Rays from outside
  // end in the centre of a cell below, and pass corners, edges and faces of octants, or run along them.
  std::uint64_t rays = 0;
  for (const RandomTree& options : propertyTrees())
  {
    if (options.missing > 0.)
    {
      continue;
    }
    std::vector<LeafCell> cells = makeRandomTree(options);
    std::vector<CellId> below;
    int levels = 0;
    for (LeafCell& c : cells)
    {
      c.value = touchesBoundary(c.cell, options.roots) ? 1.f : c.value;
      levels = std::max(levels, c.cell.level);
      if (c.value < 0.f)
      {
        below.push_back(c.cell);
      }
    }
    if (below.empty())
    {
      continue;
    }
    const Isosurface surface(makeField(unitRoots(options.roots), cells), { 0. });
    std::mt19937 random(options.seed);
    const double reach = 2. + options.roots[0] + options.roots[1] + options.roots[2];
    for (int i = 0; i < 64000; ++i)
    {
      const Vec3 end = centre(below[random() % below.size()]);
      const CellId& seam = cells[random() % cells.size()].cell;
      Vec3 through = centre(seam);
      const double half = std::ldexp(0.5, -seam.level);
      for (int a = 0; a < 3; ++a)
      {
        // On the octants' planes, in between, or at the height of the end.
        std::uniform_real_distribution<double> uniform(-1., 1.);
        const unsigned kind = random() % 5;
        through[a] += kind < 3 ? half * (static_cast<int>(kind) - 1)
          : kind == 3          ? half * uniform(random)
                               : 0.;
        through[a] = kind == 4 ? end[a] : through[a];
      }
      if (through == end)
      {
        continue;
      }
      const Ray ray = rayThrough(through, end, reach);
      SurfaceHit hit;
      ASSERT_TRUE(surface.intersect(ray, 0., reach, hit)) << "seed " << options.seed << ", ray " << i;
      ASSERT_TRUE(surface.occluded(ray, 0., reach));
      ++rays;
    }
  }
  EXPECT_GT(rays, 1000000u);
}

TEST(Isosurface, SeveralIsovaluesAreTheirSurfacesTogether)
{
  const RandomTree options{ 5, { 1, 2, 1 }, 4, 0.6, 0.1, false };
  const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
  const Isosurface both(field, { 0.3, -0.2, 0.3 });
  ASSERT_EQ(both.isovalues(), (std::vector<double>{ -0.2, 0.3 }));
  const Isosurface low(field, { -0.2 });
  const Isosurface high(field, { 0.3 }, 0); // keeps no values
  EXPECT_EQ(high.statistics().keptBytes, 0u);
  std::mt19937 random(5);
  int hits = 0;
  for (int i = 0; i < 20000; ++i)
  {
    const Ray ray = towards(inside(options.roots, random), options.roots, random);
    std::vector<SurfaceHit> all;
    std::vector<SurfaceHit> expected;
    std::vector<SurfaceHit> ofHigh;
    both.intersectAll(ray, 0., 20., all);
    low.intersectAll(ray, 0., 20., expected);
    high.intersectAll(ray, 0., 20., ofHigh);
    for (SurfaceHit& hit : ofHigh)
    {
      hit.surface = 1;
      expected.push_back(hit);
    }
    std::stable_sort(
      expected.begin(), expected.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
    ASSERT_EQ(all.size(), expected.size());
    for (std::size_t k = 0; k < all.size(); ++k)
    {
      EXPECT_EQ(all[k].t, expected[k].t);
      EXPECT_EQ(all[k].surface, expected[k].surface);
      EXPECT_EQ(all[k].gradient, expected[k].gradient);
    }
    hits += static_cast<int>(all.size());
  }
  EXPECT_GT(hits, 20000);
}

TEST(Isosurface, HitsDoNotDependOnTheUnitOfT)
{
  const RandomTree options{ 5, { 1, 2, 1 }, 4, 0.6, 0., false };
  const Isosurface surface(makeField(unitRoots(options.roots), makeRandomTree(options)), { 0.1 });
  std::mt19937 random(5);
  std::size_t hits = 0;
  for (int i = 0; i < 5000; ++i)
  {
    const Ray ray = towards(inside(options.roots, random), options.roots, random);
    std::vector<SurfaceHit> expected;
    surface.intersectAll(ray, 0., 20., expected);
    hits += expected.size();
    for (const int exponent : { -40, 40 }) // powers of two: the same roundings
    {
      Ray scaled = ray;
      for (double& d : scaled.direction)
      {
        d = std::ldexp(d, exponent);
      }
      std::vector<SurfaceHit> all;
      surface.intersectAll(scaled, 0., std::ldexp(20., -exponent), all);
      ASSERT_EQ(all.size(), expected.size());
      for (std::size_t k = 0; k < all.size(); ++k)
      {
        ASSERT_EQ(std::ldexp(all[k].t, exponent), expected[k].t);
      }
    }
  }
  EXPECT_GT(hits, 5000u);
}

TEST(Isosurface, HitsDoNotDependOnTheBudget)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1.f, 1.f);
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 32 * 32 * 32; ++i)
  {
    cells.push_back({ { { i & 31, i >> 5 & 31, i >> 10 }, 5 }, uniform(random) });
  }
  const auto field = makeField(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 4., 4., 4. }), cells);
  const Isosurface all(field, { 0. });
  constexpr std::size_t budget = 300 << 10;
  Isosurface few(field, { 0. }, budget);
  for (int view = 0; view < 4; ++view)
  {
    const double angle = 1.5 * view;
    const Camera camera(
      multiply(perspective(40., 1., 30.),
        lookAt({ 2. + 9. * std::cos(angle), 4., 2. + 9. * std::sin(angle) }, { 2., 2., 2. })),
      identityMatrix, 100, 100);
    HitImage expected;
    HitImage hits;
    all.render(camera, SurfaceLayers::Nearest, expected);
    few.startFrame();
    few.render(camera, SurfaceLayers::Nearest, hits);
    EXPECT_LE(few.statistics().keptBytes, budget);
    ASSERT_EQ(hits.first, expected.first);
    ASSERT_GT(hits.hits.size(), 1000u);
    for (std::size_t i = 0; i < hits.hits.size(); ++i)
    {
      ASSERT_EQ(hits.hits[i].t, expected.hits[i].t);
      ASSERT_EQ(hits.hits[i].gradient, expected.hits[i].gradient);
      ASSERT_EQ(hits.hits[i].normal, expected.hits[i].normal);
    }
    // Numbers of records that there is no room for.
    EXPECT_LE(few.statistics().gradientBytes, budget / 2 + 4 * few.statistics().blocks + 1024);
  }
  ASSERT_GT(all.statistics().keptBytes, 3 * budget);
  ASSERT_GT(all.statistics().gradientBytes, 3 * budget);
}

TEST(Isosurface, GradientsHaveTheMemoryThatValuesLeave)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1.f, 1.f);
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 32 * 32 * 32; ++i)
  {
    cells.push_back({ { { i & 31, i >> 5 & 31, i >> 10 }, 5 }, uniform(random) });
  }
  const auto field = makeField(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 4., 4., 4. }), cells);
  const std::size_t values = Isosurface(field, { 0. }).statistics().blocks << 10;
  const std::size_t budget = 2 * values;
  const Isosurface surface(field, { 0. }, budget);
  const Camera camera(
    multiply(perspective(40., 1., 30.), lookAt({ 11., 4., 2. }, { 2., 2., 2. })), identityMatrix, 100, 100);
  HitImage hits;
  surface.render(camera, SurfaceLayers::All, hits);
  ASSERT_GT(hits.hits.size(), 50000u);
  const IsosurfaceStatistics statistics = surface.statistics();
  EXPECT_GT(statistics.gradientBytes, budget / 2 + values / 4);
  EXPECT_LE(
    statistics.keptBytes + statistics.gradientBytes, budget + budget / 2 + 4 * statistics.blocks + 1024);
}

TEST(Isosurface, HasNoNormalsUnasked)
{
  const RandomTree options{ 12, { 2, 1, 1 }, 5, 0.6, 0.1, false };
  const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
  const Camera camera(
    multiply(perspective(50., 1., 20.), lookAt({ 4., 2., 3. }, { 1., 0.5, 0.5 })), identityMatrix, 100, 100);
  for (const SurfaceLayers layers : { SurfaceLayers::Nearest, SurfaceLayers::All })
  {
    const Isosurface surface(field, { 0.1 });
    HitImage flat;
    HitImage smooth;
    surface.render(camera, layers, flat, std::numeric_limits<std::size_t>::max(), SurfaceNormals::None);
    EXPECT_EQ(surface.statistics().gradientBytes, 0u);
    surface.render(camera, layers, smooth);
    EXPECT_GT(surface.statistics().gradientBytes, 0u);
    ASSERT_EQ(flat.hits.size(), smooth.hits.size());
    ASSERT_GT(flat.hits.size(), 500u);
    for (std::size_t i = 0; i < flat.hits.size(); ++i)
    {
      ASSERT_EQ(flat.hits[i].gradient, smooth.hits[i].gradient);
      ASSERT_EQ(flat.hits[i].normal, (std::array<float, 3>{}));
      ASSERT_NEAR(dot(widened(smooth.hits[i].normal), widened(smooth.hits[i].normal)), 1., 1e-6);
    }
  }
}

// A new isovalue costs a search and a hierarchy; values come with rays, which narrow the hierarchy later.
TEST(Isosurface, IsLookedAtWhereRaysComeAndHitsDoNotDependOnIt)
{
  const RandomTree options{ 12, { 2, 1, 1 }, 5, 0.6, 0.1, false };
  const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
  const Isosurface surface(field, { 0.1 });
  const Isosurface known(field, { 0.1 });
  const std::uint64_t octants = known.octantCount();
  EXPECT_GT(octants, 1000u);
  const std::size_t before = surface.statistics().keptBytes;
  const double built = surface.statistics().hierarchySeconds;
  const Camera camera(
    multiply(perspective(50., 1., 20.), lookAt({ 4., 2., 3. }, { 1., 0.5, 0.5 })), identityMatrix, 100, 100);
  for (const SurfaceLayers layers : { SurfaceLayers::Nearest, SurfaceLayers::All })
  {
    HitImage first;
    HitImage second;
    surface.startFrame();
    surface.render(camera, layers, first);
    surface.startFrame();
    surface.render(camera, layers, second);
    ASSERT_EQ(first.first, second.first);
    ASSERT_GT(first.hits.size(), 500u);
    for (std::size_t i = 0; i < first.hits.size(); ++i)
    {
      ASSERT_EQ(first.hits[i].t, second.hits[i].t);
      ASSERT_EQ(first.hits[i].block, second.hits[i].block);
      ASSERT_EQ(first.hits[i].gradient, second.hits[i].gradient);
    }
  }
  EXPECT_GT(surface.statistics().keptBytes, before + (std::size_t(100) << 10));
  EXPECT_GT(surface.statistics().hierarchySeconds, built); // was built again
  EXPECT_EQ(surface.octantCount(), octants);
}

TEST(Isosurface, FramesAreThoseOfSingleRays)
{
  const RandomTree options{ 12, { 2, 1, 1 }, 4, 0.6, 0.1, false };
  const Isosurface surface(makeField(unitRoots(options.roots), makeRandomTree(options)), { -0.2, 0.1 });
  const Vec3 middle{ 1., 0.5, 0.5 };
  struct View
  {
    const char* name;
    Matrix4 clipFromData;
  };
  const Matrix4 aside = lookAt({ 4., 2., 3. }, middle); // the domain is 2.6 to 5.6 away
  for (const auto& [name, clipFromData] :
    { View{ "whole", multiply(perspective(50., 1., 20.), aside) },
      View{ "near plane cuts", multiply(perspective(50., 4., 20.), aside) },
      View{ "far plane cuts", multiply(perspective(50., 1., 4.), aside) },
      View{ "between planes", multiply(perspective(50., 3.8, 4.2), aside) },
      View{ "beyond the window", multiply(perspective(12., 1., 20.), aside) },
      View{ "from inside", multiply(perspective(70., 0.01, 20.), lookAt({ 0.9, 0.4, 0.3 }, { 2., 1., 1. })) },
      View{ "turned away", multiply(perspective(50., 1., 20.), lookAt({ 4., 2., 3. }, { 8., 4., 6. })) },
      View{ "parallel", multiply(parallel(1.2, 1., 20.), aside) },
      View{ "parallel, cut", multiply(parallel(1.2, 3.8, 4.2), aside) } })
  {
    SCOPED_TRACE(name);
    const Camera camera(clipFromData, identityMatrix, 75, 61); // no multiple of a tile
    HitImage nearest;
    HitImage all;
    surface.render(camera, SurfaceLayers::Nearest, nearest);
    surface.render(camera, SurfaceLayers::All, all);
    std::size_t hits = 0;
    for (int pixel = 0; pixel < 75 * 61; ++pixel)
    {
      const Ray ray = camera.ray(pixel % 75, pixel / 75);
      std::vector<SurfaceHit> expected;
      surface.intersectAll(ray, camera.tFromDepth(ray, 0.), camera.tFromDepth(ray, 1.), expected);
      hits += expected.size();
      ASSERT_EQ(all.first[pixel + 1] - all.first[pixel], expected.size()) << pixel;
      for (std::size_t k = 0; k < expected.size(); ++k)
      {
        const SurfaceHit& hit = all.hits[all.first[pixel] + k];
        ASSERT_EQ(hit.t, expected[k].t);
        ASSERT_EQ(hit.surface, expected[k].surface);
        ASSERT_EQ(hit.gradient, expected[k].gradient);
        ASSERT_EQ(hit.normal, expected[k].normal);
      }
      ASSERT_EQ(nearest.first[pixel + 1] - nearest.first[pixel], expected.empty() ? 0u : 1u) << pixel;
      if (!expected.empty())
      {
        ASSERT_EQ(nearest.hits[nearest.first[pixel]].t, expected[0].t);
      }
    }
    EXPECT_EQ(hits != 0, name != std::string("turned away"));
  }
}

// Those of an uncut frame that lie in the drawn parts of their rays.
TEST(Isosurface, FramesOfACutAreTheHitsThatItLeaves)
{
  const RandomTree options{ 12, { 2, 1, 1 }, 4, 0.6, 0.1, false };
  const Isosurface surface(makeField(unitRoots(options.roots), makeRandomTree(options)), { -0.2, 0.1 });
  const Camera camera(
    multiply(perspective(50., 1., 20.), lookAt({ 4., 2., 3. }, { 1., 0.5, 0.5 })), identityMatrix, 75, 61);
  RayStops planes;
  planes.cut.halfSpaces = { { { 1., 0.3, -0.2 }, 0.8 }, { { 0., -1., 0.5 }, -0.4 } };
  RayStops regions; // two parts of many rays, and more
  regions.cut.cropping = CroppingRegions{ { 0.5, 1.5, 0.3, 0.6, 0.2, 0.8 }, 0x5aa5a5u };
  RayStops depths;
  std::vector<float> end(75 * 61);
  for (std::size_t i = 0; i < end.size(); ++i)
  {
    end[i] = 0.75f + 0.01f * static_cast<float>(i % 20);
  }
  depths.endDepth = end.data();
  HitImage whole;
  surface.render(camera, SurfaceLayers::All, whole);
  for (const RayStops& stops : { planes, regions, depths })
  {
    HitImage nearest;
    HitImage all;
    surface.render({ camera, stops }, SurfaceLayers::Nearest, nearest);
    surface.render({ camera, stops }, SurfaceLayers::All, all);
    std::size_t left = 0;
    std::size_t several = 0;
    for (int pixel = 0; pixel < 75 * 61; ++pixel)
    {
      const RayParts parts = stops.parts(camera, camera.ray(pixel % 75, pixel / 75), pixel % 75, pixel / 75);
      several += parts.count > 1;
      std::vector<double> expected;
      for (std::size_t i = whole.first[pixel]; i < whole.first[pixel + 1]; ++i)
      {
        for (int k = 0; k < parts.count; ++k)
        {
          if (whole.hits[i].t >= parts.begin[k] && whole.hits[i].t < parts.end[k])
          {
            expected.push_back(whole.hits[i].t);
          }
        }
      }
      left += expected.size();
      ASSERT_EQ(all.first[pixel + 1] - all.first[pixel], expected.size()) << pixel;
      for (std::size_t k = 0; k < expected.size(); ++k)
      {
        // The octant that a part begins in is crossed from there.
        ASSERT_NEAR(all.hits[all.first[pixel] + k].t, expected[k], 1e-13);
      }
      ASSERT_EQ(nearest.first[pixel + 1] - nearest.first[pixel], expected.empty() ? 0u : 1u) << pixel;
      if (!expected.empty())
      {
        ASSERT_NEAR(nearest.hits[nearest.first[pixel]].t, expected[0], 1e-13);
      }
    }
    EXPECT_GT(left, whole.hits.size() / 10);
    EXPECT_LT(left, whole.hits.size() * 9 / 10);
    EXPECT_EQ(several > 100, stops.cut.cropping.has_value());
  }
}

// Frames cross blocks by the vectorised kernel, single rays by the scalar walk.
TEST(Isosurface, FramesAreTheSameOnEveryInstructionSet)
{
  const RandomTree options{ 12, { 2, 1, 1 }, 4, 0.6, 0.1, false };
  const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
  const Isosurface surface(field, { -0.4, -0.2, -0.1, 0., 0.1, 0.3 }); // more than the kernel takes at once
  for (const Matrix4& projection : { perspective(50., 1., 20.), parallel(1.2, 1., 20.) })
  {
    // Along an axis: in parallel projection rays run along planes of the grid.
    const Camera camera(
      multiply(projection, lookAt({ 6., 0.5, 0.5 }, { 1., 0.5, 0.5 })), identityMatrix, 64, 48);
    forEachTarget([&](const char* target) {
      SCOPED_TRACE(target);
      HitImage all;
      HitImage nearest;
      HitImage few;
      constexpr std::size_t most = 3;
      surface.render(camera, SurfaceLayers::All, all);
      surface.render(camera, SurfaceLayers::Nearest, nearest);
      surface.render(camera, SurfaceLayers::All, few, most);
      std::size_t cut = 0;
      for (int pixel = 0; pixel < 64 * 48; ++pixel)
      {
        const Ray ray = camera.ray(pixel % 64, pixel / 64);
        std::vector<SurfaceHit> expected;
        surface.intersectAll(ray, camera.tFromDepth(ray, 0.), camera.tFromDepth(ray, 1.), expected);
        const auto expectSame = [&](const HitImage& image, std::size_t count) {
          ASSERT_EQ(image.first[pixel + 1] - image.first[pixel], count) << pixel;
          for (std::size_t k = 0; k < count; ++k)
          {
            const SurfaceHit& hit = image.hits[image.first[pixel] + k];
            ASSERT_EQ(hit.t, expected[k].t) << pixel;
            ASSERT_EQ(hit.surface, expected[k].surface);
            ASSERT_EQ(hit.gradient, expected[k].gradient);
            ASSERT_EQ(hit.normal, expected[k].normal);
          }
        };
        expectSame(all, expected.size());
        expectSame(few, std::min(most, expected.size()));
        expectSame(nearest, std::min<std::size_t>(1, expected.size()));
        cut += expected.size() > most ? 1 : 0;
      }
      EXPECT_GT(cut, 100u);
    });
  }
}

TEST(Isosurface, KnowsTheCellsOfItsHits)
{
  const RandomTree options{ 6, { 2, 1, 1 }, 4, 0.6, 0.1, false };
  const std::vector<LeafCell> cells = makeRandomTree(options);
  const auto field = makeField(unitRoots(options.roots), cells);
  const BruteForceGTI truth(options.roots, cells);
  const Isosurface surface(field, { 0.1 });
  std::mt19937 random(6);
  int hits = 0;
  for (int i = 0; i < 5000; ++i)
  {
    const Ray ray = towards(inside(options.roots, random), options.roots, random);
    SurfaceHit hit;
    if (surface.intersect(ray, 0., 20., hit))
    {
      const CellId* leaf = truth.leafAt(pointAt(ray, hit.t));
      ASSERT_TRUE(leaf);
      EXPECT_EQ(surface.cell(hit).level, leaf->level);
      EXPECT_EQ(surface.cell(hit).index, leaf->index);
      EXPECT_EQ(surface.leafWidth(hit), std::ldexp(1., -leaf->level));
      ++hits;
    }
  }
  EXPECT_GT(hits, 2000);
}

// Where all cells are at least that deep, the surface without deeper ones is that of a uniform grid of their means.
TEST(Isosurface, WithoutDeepCellsIsThatOfTheirMeans)
{
  constexpr int depth = 3;
  constexpr int width = 1 << depth;
  std::mt19937 random(31);
  std::uniform_int_distribution<int> value(-64, 64); // means of 64 are exact
  std::bernoulli_distribution refined(0.4);
  std::vector<LeafCell> cells;
  std::vector<LeafCell> means;
  for (Coord i = 0; i < width * width * width; ++i)
  {
    const std::array<Coord, 3> index{ i % width, i / width % width, i / (width * width) };
    const int deeper = refined(random) ? (refined(random) ? 2 : 1) : 0;
    double sum = 0.;
    for (Coord c = 0; c < Coord(1) << (3 * deeper); ++c)
    {
      LeafCell cell{ { {}, depth + deeper }, static_cast<float>(value(random)) };
      for (int a = 0; a < 3; ++a)
      {
        cell.cell.index[a] = (index[a] << deeper) + (c >> (a * deeper) & ((1u << deeper) - 1));
      }
      sum += cell.value;
      cells.push_back(cell);
    }
    means.push_back({ { index, depth }, static_cast<float>(std::ldexp(sum, -3 * deeper)) });
  }
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  const Isosurface coarse(field, { -3.3, 5.1 }, Isosurface::defaultKeptBytes, depth);
  const Isosurface expected(makeField(unitRoots({ 1, 1, 1 }), std::move(means)), { -3.3, 5.1 });
  EXPECT_EQ(coarse.octantCount(), expected.octantCount());
  int found = 0;
  for (int i = 0; i < 2000; ++i)
  {
    const Ray ray = towards(inside({ 1, 1, 1 }, random), { 1, 1, 1 }, random);
    std::vector<SurfaceHit> hits;
    std::vector<SurfaceHit> others;
    coarse.intersectAll(ray, 0., 100., hits);
    expected.intersectAll(ray, 0., 100., others);
    ASSERT_EQ(hits.size(), others.size());
    for (std::size_t h = 0; h < hits.size(); ++h, ++found)
    {
      ASSERT_NEAR(hits[h].t, others[h].t, 1e-12);
      ASSERT_EQ(hits[h].surface, others[h].surface);
    }
  }
  EXPECT_GT(found, 5000);
  const Isosurface all(field, { -3.3, 5.1 });
  EXPECT_GT(all.octantCount(), 2 * coarse.octantCount());
  // Ghosts are not drawn as parts of means: nodes that have some are drawn cell by cell.
  ListSource source({ 1, 1, 1 }, cells);
  source.ghostsBelow = -63.5f;
  auto built = buildOctree(unitRoots({ 1, 1, 1 }), source);
  ASSERT_TRUE(built.octree->hasGhosts());
  const auto withGhosts = std::make_shared<Field>(built.octree, built.values);
  const Isosurface partly(withGhosts, { -3.3, 5.1 }, Isosurface::defaultKeptBytes, depth);
  const Isosurface entirely(withGhosts, { -3.3, 5.1 });
  EXPECT_GT(partly.octantCount(), coarse.octantCount());
  EXPECT_LT(partly.octantCount(), entirely.octantCount());
  EXPECT_LT(entirely.octantCount(), all.octantCount());
  EXPECT_EQ(Isosurface(field, { -3.3, 5.1 }, Isosurface::defaultKeptBytes, depth + 2).octantCount(),
    all.octantCount());
}

// A cell of depth d is 2^-d wide, a pixel at the nearest point of the domain 2 tan(fovy / 2) / height times as far.
TEST(Isosurface, FindsTheDepthOfCellsThatAreSoManyPixelsWide)
{
  const auto field = makeField(unitRoots({ 1, 1, 1 }), makeRandomTree({ 5, { 1, 1, 1 }, 9, 0.3 }));
  const Octree& octree = field->octree();
  const int leaves = octree.leafLevels() - 1;
  ASSERT_GE(leaves, 6);
  const Matrix4 view = lookAt({ 0.5, 0.5, 5. }, { 0.5, 0.5, 0. }, { 0., 1., 0. });
  const double pixel = 4. * 2. * std::tan(0.5 * 40. * std::numbers::pi / 180.) / 100.; // 0.029
  const Camera camera(multiply(perspective(40., 0.1, 20.), view), identityMatrix, 100, 100);
  for (const double pixels : { 0.3, 1., 2., 8. })
  {
    const int depth = cellDepthFor(octree, camera, pixels);
    EXPECT_LE(std::ldexp(1., -depth), pixels * pixel);
    EXPECT_GT(std::ldexp(2., -depth), pixels * pixel);
  }
  EXPECT_EQ(cellDepthFor(octree, camera, 1e6), 0);
  EXPECT_EQ(cellDepthFor(octree, camera, 1e-6), leaves);
  EXPECT_EQ(cellDepthFor(octree, camera, 0.), leaves);
  // Half as large in the world, at the same place of the picture: an actor's scale.
  Matrix4 half = identityMatrix;
  half[0] = half[5] = half[10] = 0.5;
  EXPECT_EQ(cellDepthFor(octree,
              Camera(multiply(multiply(perspective(40., 0.1, 20.),
                                lookAt({ 0.25, 0.25, 2.5 }, { 0.25, 0.25, 0. }, { 0., 1., 0. })),
                       half),
                half, 100, 100),
              2.),
    cellDepthFor(octree, camera, 2.));
  // From inside nothing is small.
  const Camera within(multiply(perspective(40., 0.1, 20.), lookAt({ 0.5, 0.5, 0.5 }, { 0.1, 0.2, 0.3 })),
    identityMatrix, 100, 100);
  EXPECT_EQ(cellDepthFor(octree, within, 2.), leaves);
}

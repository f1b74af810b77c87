// The normals that isosurfaces are shaded by: against the brute-force vertex gradients, across level boundaries, and
// their order of convergence.
#include "Support/BruteForceGTI.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/LevelCrossings.h"
#include "Support/RandomTrees.h"
#include "Support/RefinedTrees.h"
#include "Surface/Isosurface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

TEST(SurfaceNormals, AreThoseBetweenVertexGradients)
{
  double worst = 0.;
  int checked = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const RootGrid grid = unitRoots(options.roots);
    const BruteForceGTI brute(options.roots, cells);
    const auto field = makeField(grid, cells);
    const Isosurface surface(field, { 0.1 });
    std::mt19937 random(options.seed);
    std::uniform_real_distribution<double> unit(0., 1.);
    for (int i = 0; i < 5; ++i)
    {
      const Vec3 target{ options.roots[0] * unit(random), options.roots[1] * unit(random),
        options.roots[2] * unit(random) };
      const Vec3 from{ 9. * unit(random), -7., 5. };
      const Ray ray{ from, normalized(target - from) };
      std::vector<SurfaceHit> hits;
      surface.intersectAll(ray, 0., 100., hits);
      for (const SurfaceHit& hit : hits)
      {
        const CellId leaf = surface.cell(hit);
        const int up = field->octree().leafLevels() - leaf.level;
        Vec3 expected{};
        for (int corner = 0; corner < 8; ++corner)
        {
          BruteForceGTI::Vertex v;
          double weight = 1.;
          for (int a = 0; a < 3; ++a)
          {
            const Coord low = 2 * leaf.index[a] + (hit.octant >> 2 * a & 1);
            const double part = std::clamp(
              std::ldexp(pointAt(ray, hit.t)[a], leaf.level + 1) - static_cast<double>(low), 0., 1.);
            v[a] = (low + sideOf(corner, a)) << up;
            weight *= sideOf(corner, a) != 0 ? part : 1. - part;
          }
          const std::array<double, 3> gradient = brute.gradient(v, grid);
          for (int a = 0; a < 3; ++a)
          {
            expected[a] += weight * gradient[a];
          }
        }
        worst = std::max(worst, degreesBetween(normalOf(hit), expected));
        ++checked;
      }
    }
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_GT(checked, 250);
}

TEST(SurfaceNormals, DoNotJumpWhereLevelsMeet)
{
  constexpr std::array<int, 3> roots{ BaseTree::roots, BaseTree::roots, BaseTree::roots };
  const std::vector<AnalyticSurface> surfaces = makeAnalyticSurfaces();
  std::array<int, LevelCrossings::mostLevels + 1> crossings{}; // by the difference of levels
  double worst = 0.;
  double worstOfPieces = 0.;
  for (const std::uint32_t seed : { 7u, 8u, 9u })
  {
    BaseTree tree{ "", makeRandomTree({ seed, roots, 5, 0.25, 0., false }), 5 };
    const bool isRough = seed == 9; // random values: steep, and crossed everywhere
    const auto field = isRough ? makeField(unitRoots(roots), tree.cells)
                               : std::shared_ptr<const Field>(makeField(tree, 0, surfaces[seed - 7].field));
    const Isosurface surface(field, { isRough ? 0. : surfaces[seed - 7].isovalue });
    LevelCrossings across(*field, surface);
    std::array<SurfaceHit, 4> hits;
    for (int i = 0; i < 170000; ++i)
    {
      const int levels = 1 + i % LevelCrossings::mostLevels;
      if (across.has(levels) && across.cross(levels, hits))
      {
        worst = std::max(worst, jumpOf(hits, normalOf));
        worstOfPieces =
          std::max(worstOfPieces, jumpOf(hits, [](const SurfaceHit& hit) { return hit.gradient; }));
        ++crossings[levels];
      }
    }
  }
  std::printf(
    "crossings by difference of levels: %d %d %d %d, largest jump %.2g degrees, of the pieces %.0f\n",
    crossings[1], crossings[2], crossings[3], crossings[4], worst, worstOfPieces);
  EXPECT_LE(worst, 0.05);
  EXPECT_GT(worstOfPieces, 90.);
  EXPECT_GT(crossings[1] + crossings[2] + crossings[3] + crossings[4], 100000);
  EXPECT_GT(*std::min_element(crossings.begin() + 1, crossings.end()), 8000);
}

TEST(SurfaceNormals, ConvergeToThoseOfTheSurface)
{
  constexpr std::array<int, 3> roots{ BaseTree::roots, BaseTree::roots, BaseTree::roots };
  const BaseTree tree{ "", makeRandomTree({ 11, roots, 3, 0.12, 0., false }), 3 };
  for (const AnalyticSurface& analytic : makeAnalyticSurfaces())
  {
    constexpr int steps = 3;
    constexpr int coarsest = 2;
    constexpr int count = 8000;
    std::array<double, steps> mean{};
    std::array<double, steps> largest{};
    for (int step = 0; step < steps; ++step)
    {
      const Isosurface surface(makeField(tree, coarsest + step, analytic.field), { analytic.isovalue });
      std::mt19937 random(4);
      std::normal_distribution<double> normal;
      for (int hits = 0; hits < count;)
      {
        const Vec3 away = normalized({ normal(random), normal(random), normal(random) });
        Ray ray;
        for (int a = 0; a < 3; ++a)
        {
          ray.origin[a] = 0.5 + away[a];
          ray.direction[a] = 0.17 * normal(random) - away[a];
        }
        SurfaceHit hit;
        if (surface.intersect(ray, 0., 5., hit))
        {
          const double angle = degreesBetween(normalOf(hit), gradientOf(analytic.field, pointAt(ray, hit.t)));
          mean[step] += angle / count;
          largest[step] = std::max(largest[step], angle);
          ++hits;
        }
      }
      std::printf("%s, refined %d times: mean %.3f, largest %.2f degrees\n", analytic.name, coarsest + step,
        mean[step], largest[step]);
    }
    const double ofMean = std::log2(mean[0] / mean[steps - 1]) / (steps - 1);
    const double ofLargest = std::log2(largest[0] / largest[steps - 1]) / (steps - 1);
    std::printf("orders %.2f, %.2f\n", ofMean, ofLargest);
    EXPECT_GT(ofMean, 1.8);
    EXPECT_GT(ofLargest, 1.);
  }
}

// Fields that are given at the corners of leaves, against functions that are known everywhere in double precision: stored,
// at points, along rays, as surfaces and in volumes.
#include "Field/CornerValues.h"
#include "Interpolation/BlockValues.h"
#include "Interpolation/Sampler.h"
#include "Support/Cameras.h"
#include "Support/CornerFunction.h"
#include "Support/ExactRay.h"
#include "Support/Fields.h"
#include "Support/OneFrame.h"
#include "Support/ProceduralTree.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeViews.h"
#include "Surface/Isosurface.h"
#include "Volume/ErrorEstimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

Vec3 pointIn(const CellId& leaf, std::mt19937& random)
{
  std::uniform_real_distribution<double> uniform(0.001, 0.999);
  Vec3 p;
  for (int a = 0; a < 3; ++a)
  {
    p[a] = std::ldexp(static_cast<double>(leaf.index[a]) + uniform(random), -leaf.level);
  }
  return p;
}

/// Rays from outside the roots' box towards a point inside.
Ray randomRay(const std::array<int, 3>& roots, std::mt19937& random)
{
  std::uniform_real_distribution<double> uniform(0., 1.);
  std::normal_distribution<double> normal;
  const Vec3 target{ roots[0] * uniform(random), roots[1] * uniform(random), roots[2] * uniform(random) };
  const Vec3 away = unit({ normal(random), normal(random), normal(random) });
  const double distance = 1. + roots[0] + roots[1] + roots[2];
  return { { target[0] + distance * away[0], target[1] + distance * away[1], target[2] + distance * away[2] },
    { -away[0], -away[1], -away[2] } };
}

ExactRay exactRay(const CornerCase& c)
{
  return ExactRay(
    c.options.roots, c.cells, [&c](const BruteForceGTI::Vertex& v) { return c.function.vertex(v); });
}

} // namespace

TEST(CornerValues, AreThoseOfEachLeaf)
{
  int largestJump = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const CornerCase c(options);
    const Field& field = *c.field;
    ASSERT_TRUE(field.corners());
    EXPECT_EQ(field.cornerJump(), 0.);
    const std::vector<CellId> leaves = leavesOf(field.octree());
    BlockEvaluator evaluator(field);
    Range hull{ 2.f, -2.f };
    TreePath root(field.octree());
    forEachNode(root, [&](const TreePath& path) {
      if (!path.node().isInner())
      {
        return;
      }
      const Octree::Children children = field.octree().children(path.node().index());
      if (children.leaf == 0)
      {
        return;
      }
      BlockValues block;
      evaluator.compute(BlockPath(path), BlockCells::Leaves, block);
      for (int o = 0; o < 8; ++o)
      {
        if (!(children.leaf >> o & 1))
        {
          continue;
        }
        const std::uint64_t leaf = children.leafIndex(o);
        const std::array<double, 8> corners = c.function.corners(leaves[leaf]);
        double sum = 0.;
        const int first = block::vertexIndex(2 * sideOf(o, 0), 2 * sideOf(o, 1), 2 * sideOf(o, 2));
        for (int corner = 0; corner < 8; ++corner)
        {
          const float expected = static_cast<float>(corners[corner]);
          const float found = block.values[first + 2 * cornerOffset(corner, block::vertexStride)];
          const int jump = c.function.jumpAt(leaves[leaf], corner);
          largestJump = std::max(largestJump, jump);
          ASSERT_NEAR(found, corners[corner], jump == 0 ? std::abs(expected - corners[corner]) : 0x1p-23);
          sum += expected;
          hull = { std::min(hull.min, expected), std::max(hull.max, expected) };
        }
        ASSERT_EQ(field.leafValues()[leaf], static_cast<float>(sum / 8.));
      }
    });
    if (field.octree().root().isInner())
    {
      EXPECT_EQ(field.range().min, hull.min);
      EXPECT_EQ(field.range().max, hull.max);
    }
  }
  EXPECT_GE(largestJump, 4);
}

TEST(CornerValues, AreInterpolatedAtPoints)
{
  int points = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const CornerCase c(options);
    const auto sampler = Sampler::create(InterpolationMethod::GTI, c.field);
    std::mt19937 random(options.seed);
    constexpr double range = 2.;
    for (int i = 0; i < 4000; ++i, ++points)
    {
      const CellId& leaf = c.cells[random() % c.cells.size()].cell;
      const Vec3 p = pointIn(leaf, random);
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(p, sample));
      ASSERT_NEAR(sample.value, c.function.value(leaf, p), 1e-6 * range);
      const double h = std::ldexp(1e-4, -leaf.level);
      for (int a = 0; a < 3; ++a)
      {
        Vec3 low = p;
        Vec3 high = p;
        low[a] -= h;
        high[a] += h;
        const double slope = (c.function.value(leaf, high) - c.function.value(leaf, low)) / (2. * h);
        ASSERT_NEAR(sample.gradient[a], slope, std::ldexp(1e-6 * range, leaf.level));
      }
    }
    FieldSample outside;
    EXPECT_FALSE(sampler->sample({ -0.1, 0.5, 0.5 }, outside));
  }
  EXPECT_GT(points, 100000);
}

TEST(CornerValues, LieInTheRangesOfNodes)
{
  for (const RandomTree& options : propertyTrees())
  {
    const CornerCase c(options);
    const Field& field = *c.field;
    const std::vector<CellId> leaves = leavesOf(field.octree());
    TreePath root(field.octree());
    std::vector<Range> ranges{ field.range() }; // of the nodes above
    forEachNode(root, [&](const TreePath& path) {
      ranges.resize(path.depth() + 1);
      if (path.node().isInner())
      {
        ranges.push_back(field.nodeRanges().of(path.node().index(), ranges.back()));
        return;
      }
      for (const double v : c.function.corners(leaves[path.node().index()]))
      {
        ASSERT_GE(static_cast<float>(v), ranges.back().min);
        ASSERT_LE(static_cast<float>(v), ranges.back().max);
      }
    });
  }
}

TEST(CornerValues, SurfacesAreThoseOfExtendedPrecision)
{
  int rays = 0;
  std::size_t crossings = 0;
  for (const RandomTree& options :
    { RandomTree{ 11, { 2, 1, 1 }, 4, 0.6, 0., false }, RandomTree{ 12, { 1, 1, 1 }, 5, 0.5, 0., false },
      RandomTree{ 13, { 1, 1, 2 }, 4, 0.6, 0.2, false }, RandomTree{ 14, { 1, 1, 1 }, 0, 0., 0., false } })
  {
    const CornerCase c(options);
    const double isovalue = 0.13;
    const Isosurface surface(c.field, { isovalue });
    ExactRay exact = exactRay(c);
    std::mt19937 random(options.seed);
    int differing = 0;
    std::vector<SurfaceHit> all;
    for (int i = 0; i < 2000; ++i, ++rays)
    {
      const Ray ray = randomRay(options.roots, random);
      const std::vector<double> expected = exact.crossings(ray, 0., 20., isovalue);
      surface.intersectAll(ray, 0., 20., all);
      SurfaceHit hit;
      EXPECT_EQ(surface.intersect(ray, 0., 20., hit), !all.empty());
      if (all.size() != expected.size())
      {
        ++differing; // a ray that all but touches the surface
        continue;
      }
      crossings += all.size();
      for (std::size_t k = 0; k < all.size(); ++k)
      {
        // Where the ray hardly crosses, the float of a value makes more of a difference.
        const Vec3 gradient = all[k].gradient;
        const double along = std::abs(dot(gradient, ray.direction));
        ASSERT_NEAR(all[k].t, expected[k], 1e-6 / along + 1e-9) << options.seed << " " << i << " " << k;
      }
    }
    EXPECT_LT(differing, 5) << options.seed;
  }
  EXPECT_GT(crossings, 5000u);
}

TEST(CornerValues, NoAimedRaySlipsThroughTheirSurfaces)
{
  std::uint64_t rays = 0;
  for (const RandomTree& options : propertyTrees())
  {
    if (options.missing > 0.)
    {
      continue;
    }
    // Above the isovalue at the boundary and next to it.
    const auto cells = makeRandomTree(options);
    std::mt19937 random(options.seed);
    std::uniform_real_distribution<double> uniform(-1., 1.);
    const CornerFunction function(cells, [&](const Vec3& p) {
      bool isOnBoundary = false;
      for (int a = 0; a < 3; ++a)
      {
        isOnBoundary = isOnBoundary || p[a] == 0. || p[a] == options.roots[a];
      }
      return isOnBoundary ? 1. : uniform(random);
    });
    const auto field = function.field(unitRoots(options.roots));
    std::vector<Vec3> below;
    for (const LeafCell& c : cells)
    {
      if (function.value(c.cell, centre(c.cell)) < -1e-3)
      {
        below.push_back(centre(c.cell));
      }
    }
    if (below.empty())
    {
      continue;
    }
    const Isosurface surface(field, { 0. });
    const double reach = 2. + options.roots[0] + options.roots[1] + options.roots[2];
    for (int i = 0; i < 20000; ++i)
    {
      const Vec3 end = below[random() % below.size()];
      const CellId& seam = cells[random() % cells.size()].cell;
      Vec3 through = centre(seam);
      for (int a = 0; a < 3; ++a)
      {
        const double half = std::ldexp(0.5, -seam.level);
        const unsigned kind = random() % 5;
        through[a] =
          kind == 4 ? end[a] : through[a] + half * (kind < 3 ? static_cast<int>(kind) - 1 : uniform(random));
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
  EXPECT_GT(rays, 300000u);
}

TEST(CornerValues, SurfacesPassHangingCornersBetweenTheirRoundedValues)
{
  // A hanging corner is rounded to float, and the larger leaf beside it interpolates in double: a ray through it, on which
  // the function falls all the way, meets the isovalue between the two on neither side.
  std::vector<LeafCell> cells{ { {}, 0.f } };
  for (int o = 0; o < 8; ++o)
  {
    cells.push_back({ { indexOfChild({ 1, 0, 0 }, o), 1 }, 0.f });
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  int rays = 0;
  for (int i = 0; i < 100; ++i)
  {
    const std::array<double, 4> face{ uniform(random), uniform(random), uniform(random), uniform(random) };
    const double whole = (face[0] + face[1] + face[2] + face[3]) / 4.;
    const auto rounded = static_cast<double>(static_cast<float>(whole));
    if (rounded == whole)
    {
      continue;
    }
    ++rays;
    const double slope = rounded < whole ? -1. : 1.;
    const CornerFunction function(cells, [&](const Vec3& p) {
      return slope * (p[0] - 1.) +
        std::lerp(std::lerp(face[0], face[1], p[1]), std::lerp(face[2], face[3], p[1]), p[2]);
    });
    const double isovalue = 0.5 * (whole + rounded);
    const Isosurface surface(function.field(unitRoots({ 2, 1, 1 })), { isovalue });
    for (const double direction : { 1., -1. })
    {
      const Ray ray{ { 1. - 3. * direction, 0.5, 0.5 }, { direction, 0., 0. } };
      SurfaceHit hit;
      ASSERT_TRUE(surface.intersect(ray, 0., 9., hit)) << i;
      EXPECT_NEAR(hit.t, 3., 1e-6);
      std::vector<SurfaceHit> all;
      surface.intersectAll(ray, 0., 9., all);
      EXPECT_EQ(all.size(), 1u);
    }
  }
  EXPECT_GT(rays, 30);
}

TEST(CornerValues, VolumesAreThoseOfExtendedPrecision)
{
  constexpr int width = 40;
  constexpr int height = 36;
  for (const RandomTree& options : { RandomTree{ 12, { 2, 2, 2 }, 5, 0.6, 0., false },
         RandomTree{ 12, { 2, 2, 2 }, 5, 0.6, 0.15, false }, RandomTree{ 3, { 1, 1, 1 }, 0, 0., 0., false } })
  {
    const CornerCase c(options);
    ExactRay exact = exactRay(c);
    for (const View& view : views())
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      for (const bool doubles : { false, true })
      {
        VolumeSettings settings;
        settings.samplesPerCell = 32.;
        settings.doubles = doubles;
        Image image(width, height);
        renderVolume(*c.field, smooth(), camera, {}, settings, image);
        float brightest = 0.f;
        double largest = 0.;
        for (int i = 0; i < width * height; i += 7)
        {
          const Ray ray = camera.ray(i % width, i / width);
          const double per = 1. / std::sqrt(dot(ray.direction, ray.direction));
          const Ray perUnit{ ray.origin,
            { per * ray.direction[0], per * ray.direction[1], per * ray.direction[2] } };
          const double begin = camera.tFromDepth(ray, 0.) / per;
          const double end = camera.tFromDepth(ray, 1.) / per;
          const std::array<double, 4> expected = exact.light(perUnit, begin, end, smooth(), 16);
          for (int k = 0; k < 4; ++k)
          {
            largest = std::max(largest, std::abs(image.rgba[4 * i + k] - expected[k]));
            brightest = std::max(brightest, image.rgba[4 * i + k]);
          }
        }
        EXPECT_LT(largest, 1e-3) << view.name << ", seed " << options.seed << (doubles ? ", doubles" : "");
        EXPECT_GT(brightest, 0.05f) << view.name << ", seed " << options.seed;
      }
    }
  }
}

TEST(CornerValues, DraftsAreThoseOfMeans)
{
  const CornerCase c({ 12, { 2, 2, 2 }, 5, 0.6, 0., true });
  const Field means(c.field->sharedOctree(), c.field->leafValues());
  VolumeSettings settings;
  settings.levelOfDetailPixels = 1e4; // no leaf is drawn
  const Camera camera(views()[0].clip, identityMatrix, 40, 40);
  Image image(40, 40);
  Image expected(40, 40);
  renderVolume(*c.field, smooth(), camera, {}, settings, image);
  renderVolume(means, smooth(), camera, {}, settings, expected);
  EXPECT_EQ(image.rgba, expected.rgba);
  settings.levelOfDetailPixels = 0.;
  renderVolume(*c.field, smooth(), camera, {}, settings, image);
  EXPECT_NE(image.rgba, expected.rgba);
}

TEST(CornerValues, ThatDisagreeAreNotKept)
{
  for (const RandomTree& options : propertyTrees())
  {
    const CornerCase c(options);
    const std::shared_ptr<const Octree> octree = c.field->sharedOctree();
    const std::vector<CellId> leaves = leavesOf(*octree);
    if (leaves.size() < 2)
    {
      continue;
    }
    // One leaf of two that share a face is off by a little.
    std::mt19937 random(options.seed);
    for (int i = 0; i < 20; ++i)
    {
      const std::uint64_t off = random() % leaves.size();
      const auto corners = [&](std::uint64_t leaf) {
        std::array<float, 8> values;
        const std::array<double, 8> exact = c.function.corners(leaves[leaf]);
        std::transform(exact.begin(), exact.end(), values.begin(),
          [&](double v) { return static_cast<float>(v + (leaf == off ? 1e-4 : 0.)); });
        return values;
      };
      const Field field = Field::ofCorners(octree, corners);
      // Whether another leaf has a corner of it.
      bool isShared = false;
      for (std::uint64_t other = 0; other < leaves.size(); ++other)
      {
        int touching = 0; // axes
        int overlapping = 0;
        int corner = 0;
        const int up = std::max(leaves[off].level, leaves[other].level);
        for (int a = 0; a < 3; ++a)
        {
          const Coord low = leaves[off].index[a] << (up - leaves[off].level);
          const Coord high = (leaves[off].index[a] + 1) << (up - leaves[off].level);
          const Coord otherLow = leaves[other].index[a] << (up - leaves[other].level);
          const Coord otherHigh = (leaves[other].index[a] + 1) << (up - leaves[other].level);
          touching += low == otherHigh || high == otherLow;
          overlapping += low < otherHigh && otherLow < high;
          corner += low == otherLow || low == otherHigh || high == otherLow || high == otherHigh;
        }
        isShared = isShared || (touching == 1 && overlapping == 2 && corner == 3);
      }
      if (isShared)
      {
        EXPECT_FALSE(field.corners()) << options.seed << " leaf " << off;
        EXPECT_NEAR(field.cornerJump(), 1e-4, 1e-6);
        ASSERT_EQ(field.leafValues().size(), leaves.size());
        const Field means(octree, field.leafValues());
        BlockEvaluator evaluator(field);
        BlockEvaluator ofMeans(means);
        BlockValues block;
        BlockValues expected;
        if (octree->children(0).leaf != 0)
        {
          evaluator.compute(BlockPath(), BlockCells::Leaves, block);
          ofMeans.compute(BlockPath(), BlockCells::Leaves, expected);
          EXPECT_EQ(block.values, expected.values);
        }
      }
    }
  }
}

TEST(CornerValues, ThatDisagreeFromTreeToTreeAreNotKept)
{
  for (const auto& [below, above] : { std::pair(3, 3), std::pair(4, 4), std::pair(3, 4), std::pair(5, 3) })
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      std::array<int, 3> roots{ 1, 1, 1 };
      roots[axis] = 2;
      std::vector<LeafCell> cells;
      for (int root = 0; root < 2; ++root)
      {
        const int level = root == 0 ? below : above;
        for (Coord i = 0; i < Coord(1) << 3 * level; ++i)
        {
          const Coord mask = (Coord(1) << level) - 1;
          LeafCell cell{ { { i & mask, i >> level & mask, i >> 2 * level }, level }, 0.f };
          cell.cell.index[axis] += root << level;
          cells.push_back(cell);
        }
      }
      const auto octree = buildOctree(unitRoots(roots), cells).octree;
      const std::vector<CellId> leaves = leavesOf(*octree);
      for (const float jump : { 0.f, 1e-3f })
      {
        const Field field = Field::ofCorners(octree, [&](std::uint64_t leaf) {
          std::array<float, 8> corners;
          for (int c = 0; c < 8; ++c)
          {
            corners[c] = leaves[leaf].index[axis] >> leaves[leaf].level ? jump : 0.f;
            for (int a = 0; a < 3; ++a)
            {
              corners[c] += static_cast<float>(
                std::ldexp(static_cast<double>(leaves[leaf].index[a] + sideOf(c, a)), -leaves[leaf].level));
            }
          }
          return corners;
        });
        EXPECT_EQ(field.corners() != nullptr, jump == 0.f) << below << " " << above << " " << axis;
        EXPECT_NEAR(field.cornerJump(), jump, 1e-6);
      }
    }
  }
}

TEST(CornerValues, ThatHangAreThoseOfCoarserLeaves)
{
  for (const RandomTree& options : propertyTrees())
  {
    const CornerCase c(options);
    const std::vector<CellId> leaves = leavesOf(c.field->octree());
    std::mt19937 random(options.seed);
    std::uniform_real_distribution<float> uniform(0.01f, 0.5f);
    double changed = 0.;
    std::map<std::array<double, 3>, float> changes; // by place: leaves that share a corner agree
    std::vector<std::array<float, 8>> corners;
    for (const CellId& leaf : leaves)
    {
      const std::array<double, 8> exact = c.function.corners(leaf);
      std::array<float, 8>& given = corners.emplace_back();
      for (int corner = 0; corner < 8; ++corner)
      {
        given[corner] = static_cast<float>(exact[corner]);
        if (c.function.jumpAt(leaf, corner) > 0)
        {
          std::array<double, 3> place;
          for (int a = 0; a < 3; ++a)
          {
            place[a] = std::ldexp(static_cast<double>(leaf.index[a] + sideOf(corner, a)), -leaf.level);
          }
          const float change = changes.emplace(place, uniform(random)).first->second;
          given[corner] += change;
          changed = std::max<double>(changed, change);
        }
      }
    }
    const auto field = std::make_shared<const Field>(
      Field::ofCorners(c.field->sharedOctree(), [&](std::uint64_t leaf) { return corners[leaf]; }));
    ASSERT_TRUE(field->corners());
    EXPECT_NEAR(field->corners()->hangingChange(), changed, 1e-6);
    EXPECT_EQ(c.field->corners()->hangingChange(), 0.);
    const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
    for (int i = 0; i < 1000; ++i)
    {
      const CellId& leaf = c.cells[random() % c.cells.size()].cell;
      const Vec3 p = pointIn(leaf, random);
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(p, sample));
      ASSERT_NEAR(sample.value, c.function.value(leaf, p), 2e-6);
    }
  }
}

TEST(CornerValues, HangAcrossManyLevels)
{
  // Two roots, one a leaf, the other refined towards a point of their common face.
  std::vector<LeafCell> cells{ { {}, 0.f } };
  constexpr int deepest = 19;
  const Vec3 target{ 1., 0.3, 0.7 };
  CellId around{ { 1, 0, 0 }, 0 };
  for (int level = 1; level <= deepest; ++level)
  {
    CellId next;
    for (int o = 0; o < 8; ++o)
    {
      const CellId child{ indexOfChild(around.index, o), level };
      bool holds = sideOf(o, 0) == 0;
      for (int a = 1; a < 3; ++a)
      {
        holds = holds && static_cast<Coord>(std::ldexp(target[a], level)) == child.index[a];
      }
      if (holds && level < deepest)
      {
        next = child;
      }
      else
      {
        cells.push_back({ child, 0.f });
      }
    }
    around = next;
  }
  const CornerFunction function(
    cells, [](const Vec3& p) { return p[0] + std::sin(3. * p[1]) * std::cos(2. * p[2]); });
  const auto field = function.field(unitRoots({ 2, 1, 1 }));
  ASSERT_TRUE(field->corners());
  const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
  std::mt19937 random(1);
  for (const LeafCell& c : cells)
  {
    const Vec3 p = pointIn(c.cell, random);
    FieldSample sample;
    ASSERT_TRUE(sampler->sample(p, sample));
    EXPECT_NEAR(sample.value, function.value(c.cell, p), 2e-6);
  }
}

TEST(CornerValues, OfRoundedDigitsAreKept)
{
  const CornerCase c({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  const std::vector<CellId> leaves = leavesOf(c.field->octree());
  std::mt19937 random(3);
  const Field field = Field::ofCorners(c.field->sharedOctree(), [&](std::uint64_t leaf) {
    std::array<float, 8> values;
    const std::array<double, 8> exact = c.function.corners(leaves[leaf]);
    // Six digits, as text has them.
    std::transform(exact.begin(), exact.end(), values.begin(),
      [](double v) { return static_cast<float>(std::round(v * 1e6) / 1e6); });
    return values;
  });
  EXPECT_TRUE(field.corners());
}

TEST(CornerValues, ThatAreNotFiniteAreNamed)
{
  const CornerCase c({ 12, { 1, 1, 1 }, 2, 0.6, 0., false });
  try
  {
    const Field field = Field::ofCorners(c.field->sharedOctree(), [](std::uint64_t leaf) {
      std::array<float, 8> values{};
      values[5] = leaf == 7 ? std::numeric_limits<float>::quiet_NaN() : 0.f;
      return values;
    });
    FAIL();
  }
  catch (const Error& error)
  {
    EXPECT_STREQ(error.what(), "field: a value at a corner of leaf 7 is not finite");
  }
}

TEST(CornerValues, OfNoCellsAreNone)
{
  const auto octree = buildOctree(unitRoots({ 1, 1, 1 }), std::vector<LeafCell>{}).octree;
  const Field field = Field::ofCorners(octree, [](std::uint64_t) { return std::array<float, 8>{}; });
  EXPECT_EQ(field.leafValues().size(), 0u);
  EXPECT_EQ(field.range().max, 0.f);
}

TEST(CornerValues, OfASingleCellAreItsFieldEverywhere)
{
  const CornerCase c({ 3, { 1, 1, 1 }, 0, 0., 0., false });
  ASSERT_EQ(c.field->octree().leafCount(), 1u);
  const auto sampler = Sampler::create(InterpolationMethod::GTI, c.field);
  FieldSample sample;
  ASSERT_TRUE(sampler->sample({ 0.2, 0.7, 0.4 }, sample));
  EXPECT_NEAR(sample.value, c.function.value({}, { 0.2, 0.7, 0.4 }), 1e-6);
}

TEST(CornerValues, OffsetsKeepTheirDigits)
{
  const RandomTree options{ 12, { 2, 2, 2 }, 4, 0.6, 0., false };
  const auto cells = makeRandomTree(options);
  const CornerFunction function(
    cells, [](const Vec3& p) { return 101325. + 1e-3 * std::sin(5. * p[0]) * std::cos(4. * p[1] + p[2]); });
  const auto field = function.field(unitRoots(options.roots), 101325.);
  ASSERT_TRUE(field->corners());
  const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i)
  {
    const CellId& leaf = cells[random() % cells.size()].cell;
    const Vec3 p = pointIn(leaf, random);
    FieldSample sample;
    ASSERT_TRUE(sampler->sample(p, sample));
    EXPECT_NEAR(sample.value, function.value(leaf, p), 1e-9);
  }
}

TEST(CornerValues, ErrorsOfFramesAreEstimated)
{
  const CornerCase c({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  const Camera camera(views()[0].clip, identityMatrix, 160, 160);
  Volume volume(c.field, smooth());
  VolumeSettings settings;
  settings.samplesPerCell = 1.;
  Image image(160, 160);
  Image converged(160, 160);
  volume.render(camera, settings, image);
  VolumeSettings most = settings;
  most.samplesPerCell = 128.;
  volume.render(camera, most, converged);
  double squares = 0.;
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
  {
    squares += i % 4 == 3 ? 0. : std::pow(image.rgba[i] - converged.rgba[i], 2);
  }
  const double error = std::sqrt(squares / (0.75 * static_cast<double>(image.rgba.size())));
  const double estimated = ErrorEstimator(volume, camera, settings, image).error();
  EXPECT_GT(error, 1e-5);
  EXPECT_NEAR(estimated, error, 0.3 * error);
}

TEST(CornerValues, TakeNoMoreThanTwentyBytesACell)
{
  const auto measure = [](const char* name, const std::shared_ptr<const Octree>& octree) {
    const Field field = Field::ofCorners(octree, [](std::uint64_t) { return std::array<float, 8>{}; });
    field.nodeRanges();
    const auto cells = static_cast<double>(octree->leafCount());
    const double bytes = static_cast<double>(field.byteSize()) / cells;
    std::printf("%s, %.0f cells: %.1f bytes a cell with means and ranges, %.1f of them of corners, and %.1f "
                "of the octree\n",
      name, cells, bytes, static_cast<double>(field.corners()->byteSize()) / cells,
      static_cast<double>(octree->byteSize()) / cells);
    EXPECT_LE(bytes, 20.) << name;
  };
  measure("sheet", buildOctree(unitRoots({ 1, 1, 1 }), ProceduralTree(8, 2.55)).octree);
  measure("thin sheet", buildOctree(unitRoots({ 1, 1, 1 }), ProceduralTree(9, 0.5)).octree);
  measure("uniform", buildOctree(unitRoots({ 1, 1, 1 }), ProceduralTree(6, 1e9)).octree);
  for (const RandomTree& options : propertyTrees())
  {
    if (options.missing == 0.)
    {
      const CornerCase c(options);
      if (c.cells.size() > 500)
      {
        measure("random", c.field->sharedOctree());
      }
    }
  }
}

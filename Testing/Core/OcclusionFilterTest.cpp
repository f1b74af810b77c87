// The filter of ambient occlusion on planes whose hits are known: who shares rays with whom.
#include "Surface/OcclusionFilter.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/RandomTrees.h"
#include "Surface/SecondaryRays.h"
#include "Surface/SurfaceFrame.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Not a multiple of a tile.
constexpr int pixels = 37;

/// Looks down the z axis from 40 above, at z = 0 with 1 unit for a pixel, onto data that begin at `offset`.
Camera makeCamera(bool isParallel, double offset = 0., int size = pixels)
{
  const Matrix4 moved{ 1., 0., 0., -offset, 0., 1., 0., -offset, 0., 0., 1., -offset, 0., 0., 0., 1. };
  const double height = 40.;
  const Matrix4 projection = isParallel
    ? parallel(0.5 * size, 1., 100.)
    : perspective(2. * std::atan(0.5 * size / height) * 180. / std::numbers::pi, 1., 100.);
  const Matrix4 view = lookAt({ 0., 0., height }, { 0., 0., 0. }, { 0., 1., 0. });
  return Camera(multiply(multiply(projection, view), moved), moved, size, size);
}

/// The part of the plane normal . p = offset where `exists`.
struct Plane
{
  Vec3 normal;
  double offset;
  std::uint32_t surface = 0;
  std::function<bool(const Vec3&)> exists = [](const Vec3&) { return true; };
};

/// Hits and, for each, its plane and pixel.
struct Scene
{
  HitImage image;
  std::vector<std::size_t> planes;
  std::vector<int> pixelOf;

  Scene(const Camera& camera, const std::vector<Plane>& all)
  {
    image.first.push_back(0);
    for (int pixel = 0; pixel < camera.width() * camera.height(); ++pixel)
    {
      const Ray ray = camera.ray(pixel % camera.width(), pixel / camera.width());
      std::vector<std::pair<double, std::size_t>> found;
      for (std::size_t p = 0; p < all.size(); ++p)
      {
        const double t = (all[p].offset - treeamr::dot(all[p].normal, ray.origin)) /
          treeamr::dot(all[p].normal, ray.direction);
        if (all[p].exists(pointAt(ray, t)))
        {
          found.emplace_back(t, p);
        }
      }
      std::sort(found.begin(), found.end());
      for (const auto& [t, p] : found)
      {
        image.hits.push_back({ t, all[p].normal, {}, all[p].surface, 0, 0 });
        planes.push_back(p);
        pixelOf.push_back(pixel);
      }
      image.first.push_back(image.hits.size());
    }
  }
};

/// 6 to 9 of 16 rays, by the pixel's place in the pattern of 4 x 4.
std::vector<std::uint16_t> patternOf(const Scene& scene)
{
  std::vector<std::uint16_t> open;
  for (const int pixel : scene.pixelOf)
  {
    open.push_back(static_cast<std::uint16_t>(6 + (pixel % pixels + 4 * (pixel / pixels)) % 16 / 4));
  }
  return open;
}
constexpr float meanOfPattern = 7.5f / 16.f;

/// Each hit of plane p is open if p is odd and closed else: expects that all stay so.
void expectApart(const Camera& camera, const std::vector<Plane>& planes)
{
  const Scene scene(camera, planes);
  for (const int samples : { 1, 2, 16, 64 })
  {
    std::vector<std::uint16_t> open;
    for (const std::size_t p : scene.planes)
    {
      open.push_back(static_cast<std::uint16_t>(p % 2 * samples));
    }
    ASSERT_NE(std::adjacent_find(open.begin(), open.end(), std::not_equal_to()), open.end());
    const std::vector<float> filtered = filterAmbientOcclusion(camera, scene.image, open, samples);
    for (std::size_t i = 0; i < filtered.size(); ++i)
    {
      ASSERT_EQ(filtered[i], static_cast<float>(scene.planes[i] % 2)) << samples << " samples, hit " << i;
    }
  }
}

} // namespace

TEST(OcclusionFilter, GivesAllPixelsOfThePatternTheSameWeight)
{
  const Vec3 normal = unit({ 0.3, -0.2, 0.9 });
  for (const bool isParallel : { true, false })
  {
    for (const double offset : { 0., 0x1p22 })
    {
      const Camera camera = makeCamera(isParallel, offset);
      const Scene scene(camera, { { normal, offset * (normal[0] + normal[1] + normal[2]) } });
      const std::vector<float> filtered = filterAmbientOcclusion(camera, scene.image, patternOf(scene), 16);
      for (const float part : filtered)
      {
        ASSERT_NEAR(part, meanOfPattern, 1e-6) << "offset " << offset;
      }
    }
  }
}

TEST(OcclusionFilter, LeavesWhatIsTheSameEverywhere)
{
  const Camera camera = makeCamera(false);
  Scene scene(camera, { { { 0., 0., 1. }, 0. }, { unit({ 0.2, 0.1, 1. }), 0.5 } });
  std::mt19937 random(1);
  std::normal_distribution<double> rough(0., 0.3);
  for (SurfaceHit& hit : scene.image.hits)
  {
    hit.gradient = { rough(random), rough(random), 1. };
  }
  for (const int samples : { 1, 2, 3, 16, 41, 65535 })
  {
    for (const int rays : { 0, samples / 3, samples })
    {
      const std::vector<std::uint16_t> open(scene.image.hits.size(), static_cast<std::uint16_t>(rays));
      for (const float part : filterAmbientOcclusion(camera, scene.image, open, samples))
      {
        ASSERT_EQ(part, static_cast<float>(rays) / static_cast<float>(samples));
      }
    }
  }
}

TEST(OcclusionFilter, KeepsCreasesStepsAndSurfacesApart)
{
  const auto left = [](const Vec3& p) { return p[0] < 0.2; };
  const auto right = [](const Vec3& p) { return p[0] >= 0.2; };
  const double s = std::sqrt(0.5);
  for (const bool isParallel : { true, false })
  {
    const Camera camera = makeCamera(isParallel);
    // A ridge and a valley.
    for (const double side : { -1., 1. })
    {
      expectApart(camera,
        { { { -s * side, 0., s }, -0.2 * s * side, 0, left },
          { { s * side, 0., s }, 0.2 * s * side, 0, right } });
    }
    // Two sheets, one beside and before the other; part of the rays miss the upper one.
    const Vec3 normal = unit({ 0.1, 0.2, 1. });
    expectApart(camera, { { normal, 0., 0, left }, { normal, 8., 0, right } });
    expectApart(camera,
      { { normal, 0. }, { normal, 8., 0, [](const Vec3& p) { return std::sin(2.1 * p[0] + p[1]) < 0.5; } } });
    // One plane of two surfaces.
    expectApart(camera, { { normal, 0., 0, left }, { normal, 0., 1, right } });
  }
}

TEST(OcclusionFilter, SharesWithinALayerBehindAnother)
{
  const Vec3 normal = unit({ 0.1, 0.2, 1. });
  const Camera camera = makeCamera(false);
  const Scene scene(camera,
    { { normal, 0. }, { normal, 8., 0, [](const Vec3& p) { return std::sin(2.1 * p[0] + p[1]) < 0.5; } },
      { normal, 16., 0, [](const Vec3& p) { return std::sin(p[0] - 1.7 * p[1]) < 0.3; } } });
  const std::vector<float> filtered = filterAmbientOcclusion(camera, scene.image, patternOf(scene), 16);
  for (std::size_t i = 0; i < filtered.size(); ++i)
  {
    if (scene.planes[i] == 0)
    {
      ASSERT_NEAR(filtered[i], meanOfPattern, 1e-6);
    }
  }
}

TEST(OcclusionFilter, ConvergesToTheRaysOfEachHit)
{
  const Camera camera = makeCamera(false);
  const Scene scene(camera, { { { 0., 0., 1. }, 0. } });
  for (const int samples : { 64, 1024, 65535 })
  {
    // All or nothing, as no even rays of a plane would be.
    std::vector<std::uint16_t> open;
    for (const int pixel : scene.pixelOf)
    {
      open.push_back(static_cast<std::uint16_t>(pixel % 2 * samples));
    }
    const std::vector<float> filtered = filterAmbientOcclusion(camera, scene.image, open, samples);
    for (std::size_t i = 0; i < filtered.size(); ++i)
    {
      ASSERT_NEAR(filtered[i], scene.pixelOf[i] % 2, 2.0001 * std::pow(samples, -0.75));
      ASSERT_NE(filtered[i], scene.pixelOf[i] % 2);
    }
  }
}

TEST(OcclusionFilter, LeavesHitsWithoutAPlaceAlone)
{
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Camera camera = makeCamera(false);
  const Scene whole(camera, { { { 0., 0., 1. }, 0. } });
  const std::vector<std::uint16_t> open = patternOf(whole);
  for (const double t : { nan, infinity, 1e300 })
  {
    Scene scene = whole;
    for (std::size_t i = 0; i < open.size(); i += 7)
    {
      scene.image.hits[i].t = t;
    }
    const std::vector<float> filtered = filterAmbientOcclusion(camera, scene.image, open, 16);
    for (std::size_t i = 0; i < open.size(); ++i)
    {
      if (i % 7 == 0)
      {
        ASSERT_EQ(filtered[i], open[i] / 16.f);
      }
      else
      {
        ASSERT_NEAR(filtered[i], meanOfPattern, 1.5f / 16.f);
      }
    }
  }
  // Without a normal a hit has that towards the camera.
  for (const Vec3& gradient : { Vec3{}, Vec3{ nan, nan, nan }, Vec3{ infinity, 0., 0. } })
  {
    Scene scene = whole;
    for (std::size_t i = 0; i < open.size(); i += 7)
    {
      scene.image.hits[i].gradient = gradient;
    }
    for (const float part : filterAmbientOcclusion(camera, scene.image, open, 16))
    {
      ASSERT_NEAR(part, meanOfPattern, 1.5f / 16.f);
    }
  }
}

TEST(OcclusionFilter, TakesImagesOfOnePixelAndOfNone)
{
  const Camera one = makeCamera(false, 0., 1);
  const Scene scene(one, { { { 0., 0., 1. }, 0. } });
  EXPECT_EQ(filterAmbientOcclusion(one, scene.image, { 5 }, 16), std::vector<float>{ 5.f / 16.f });
  const Camera camera = makeCamera(false);
  EXPECT_TRUE(filterAmbientOcclusion(camera, Scene(camera, {}).image, {}, 16).empty());
}

TEST(OcclusionFilter, GivesTheSameWithAnyNumberOfThreads)
{
  const Camera camera = makeCamera(false);
  const Scene scene(camera, { { { 0.1, 0.2, 1. }, 0. }, { { 0.2, 0.1, 1. }, 0.5 } });
  const std::vector<std::uint16_t> open = patternOf(scene);
  const std::vector<float> filtered = filterAmbientOcclusion(camera, scene.image, open, 4);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(filterAmbientOcclusion(camera, scene.image, open, 4), filtered);
}

// A floor before a wall: of cosine-distributed rays, even over the floor's disc, those in the segment beyond
// distance / radius meet the wall.
TEST(OcclusionFilter, SeesAWallOverAFloor)
{
  constexpr double level = 3.2;
  constexpr Coord roots = 12;
  constexpr int size = 64;
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < roots * roots * roots; ++i)
  {
    cells.push_back({ { { i % roots, i / roots % roots, i / (roots * roots) }, 0 }, 0.f });
  }
  setValues(cells, [](const auto& p) { return std::min(p[0], p[2]) - level; });
  auto built = buildOctree(RootGrid::uniform({ roots, roots, roots }, { 0., 0., 0. }, { 1., 1., 1. }), cells);
  auto field = std::make_shared<Field>(built.octree, built.values);
  const Isosurface surface(field, { 0. });
  const Camera camera(multiply(perspective(20., 0.1, 30.), lookAt({ 8., 6., 11. }, { 5.9, 6., level })),
    identityMatrix, size, size);
  HitImage hits;
  surface.render(camera, SurfaceLayers::Nearest, hits);
  constexpr double radius = 4.;
  for (const int samples : { 16, 64 })
  {
    std::vector<std::uint16_t> open(hits.hits.size());
    traceAmbientOcclusion(surface, camera, hits, radius, 0, samples, open);
    const std::vector<float> filtered = filterAmbientOcclusion(camera, hits, open, samples);
    double before = 0.; // squares of errors
    double after = 0.;
    double most = 0.;
    int counted = 0;
    for (int pixel = 0; pixel < size * size; ++pixel)
    {
      const std::size_t i = hits.first[pixel];
      if (i == hits.first[pixel + 1])
      {
        continue;
      }
      const Vec3 p = pointAt(camera.ray(pixel % size, pixel / size), hits.hits[i].t);
      // Near the edge the reconstruction is round.
      if (p[2] > level + 1e-6 || p[0] < level + 1.6)
      {
        continue;
      }
      const double q = std::min(1., (p[0] - level) / radius);
      const double exact = 1. - (std::acos(q) - q * std::sqrt(1. - q * q)) / std::numbers::pi;
      before += std::pow(static_cast<double>(open[i]) / samples - exact, 2);
      after += std::pow(filtered[i] - exact, 2);
      most = std::max(most, std::abs(filtered[i] - exact));
      ++counted;
    }
    EXPECT_GT(counted, 1000);
    EXPECT_LT(std::sqrt(after), std::sqrt(before) / 5.) << samples << " rays";
    EXPECT_LT(most, samples == 16 ? 0.025 : 0.008) << samples << " rays";
  }
}

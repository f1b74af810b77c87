// Parts of rays against the points on them, one by one.
#include "Geometry/RayStops.h"
#include "Error.h"
#include "Support/Cameras.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

bool isDrawn(const DataCut& cut, const Vec3& p)
{
  for (const HalfSpace& half : cut.halfSpaces)
  {
    if (dot(half.normal, p) < half.offset)
    {
      return false;
    }
  }
  if (!cut.cropping)
  {
    return true;
  }
  const std::array<double, 6>& planes = cut.cropping->planes;
  int region = 0;
  for (int a = 2; a >= 0; --a)
  {
    region = 3 * region + (p[a] < planes[2 * a] ? 0 : p[a] > planes[2 * a + 1] ? 2 : 1);
  }
  return cut.cropping->shown & 1u << region;
}

bool contains(const RayParts& parts, double t)
{
  for (int i = 0; i < parts.count; ++i)
  {
    if (t >= parts.begin[i] && t < parts.end[i])
    {
      return true;
    }
  }
  return false;
}

/// A few of half spaces and cropping, each there or not.
DataCut randomCut(std::mt19937& random)
{
  std::uniform_real_distribution<double> uniform(-1., 1.);
  DataCut cut;
  for (auto i = random() % 4; i > 0; --i)
  {
    cut.halfSpaces.push_back(
      { { uniform(random), uniform(random), uniform(random) }, -0.5 * uniform(random) });
  }
  if (random() % 4 != 0)
  {
    cut.cropping.emplace();
    for (int a = 0; a < 3; ++a)
    {
      cut.cropping->planes[2 * a] = -std::abs(uniform(random));
      cut.cropping->planes[2 * a + 1] = std::abs(uniform(random));
      if (random() % 8 == 0)
      {
        std::swap(cut.cropping->planes[2 * a], cut.cropping->planes[2 * a + 1]);
      }
    }
    cut.cropping->shown = random() & 0x7ffffff;
  }
  return cut;
}

} // namespace

TEST(RayStops, PartsAreWhereThePointsAreDrawn)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1., 1.);
  int seen = 0;
  int mostParts = 0;
  for (int i = 0; i < 4000; ++i)
  {
    const DataCut cut = randomCut(random);
    Ray ray{ { 2. * uniform(random), 2. * uniform(random), 2. * uniform(random) },
      { uniform(random), uniform(random), uniform(random) } };
    if (i % 5 == 0)
    {
      ray.direction[random() % 3] = 0.; // parallel to planes
    }
    const double begin = uniform(random);
    const double end =
      i % 7 == 0 ? std::numeric_limits<double>::infinity() : begin + 4. * std::abs(uniform(random));
    const RayParts parts = cut.parts(ray.origin, ray.direction, begin, end);
    mostParts = std::max(mostParts, parts.count);
    for (int k = 0; k < parts.count; ++k)
    {
      EXPECT_LT(parts.begin[k], parts.end[k]);
      EXPECT_GE(parts.begin[k], begin);
      EXPECT_LE(parts.end[k], end);
      EXPECT_TRUE(k == 0 || parts.end[k - 1] < parts.begin[k]);
    }
    for (int j = 0; j < 100; ++j)
    {
      const double t = 4. * uniform(random);
      Vec3 p;
      for (int a = 0; a < 3; ++a)
      {
        p[a] = ray.origin[a] + t * ray.direction[a];
      }
      const bool drawn = t >= begin && t < end && isDrawn(cut, p);
      ASSERT_EQ(contains(parts, t), drawn) << "stops " << i << ", t " << t;
      seen += drawn;
    }
  }
  EXPECT_GT(seen, 20000);
  EXPECT_GE(mostParts, 3);
}

TEST(RayStops, ALatticeOfRegionsMakesTheMostParts)
{
  DataCut cut;
  cut.cropping = CroppingRegions{ { 1., 4., 2., 5., 3., 6. }, 0 };
  // Along the diagonal one plane after the other: every other region from the first on.
  for (const double p : { 0.5, 2.5, 4.5, 6.5 })
  {
    const int region = (p > 1.) + (p > 4.) + 3 * ((p > 2.) + (p > 5.)) + 9 * ((p > 3.) + (p > 6.));
    cut.cropping->shown |= 1u << region;
  }
  const RayParts parts = cut.parts({ 0., 0., 0. }, { 1., 1., 1. }, 0., 7.);
  ASSERT_EQ(parts.count, RayParts::most);
  const std::array<double, 8> expected{ 0., 1., 2., 3., 4., 5., 6., 7. };
  for (int k = 0; k < parts.count; ++k)
  {
    EXPECT_DOUBLE_EQ(parts.begin[k], expected[2 * k]);
    EXPECT_DOUBLE_EQ(parts.end[k], expected[2 * k + 1]);
  }
}

TEST(RayStops, ABoxAndDepthsNarrowARay)
{
  const Camera camera(
    multiply(perspective(40., 0.5, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 8, 6);
  RayStops stops;
  const Ray ray = camera.ray(4, 3);
  RayParts parts = stops.parts(camera, ray, 4, 3);
  ASSERT_EQ(parts.count, 1);
  EXPECT_NEAR(camera.depthFromT(ray, parts.begin[0]), 0., 1e-12);
  EXPECT_NEAR(camera.depthFromT(ray, parts.end[0]), 1., 1e-12);

  std::vector<float> begin(48, 0.f);
  std::vector<float> end(48, 1.f);
  end[3 * 8 + 4] = static_cast<float>(camera.depthFromT(ray, 4.));
  stops.beginDepth = begin.data();
  stops.endDepth = end.data();
  stops.cut.addBox({ { 0., 0., 0. }, { 2., 2., 2. } });
  EXPECT_FALSE(stops.isEmpty());
  parts = stops.parts(camera, ray, 4, 3);
  ASSERT_EQ(parts.count, 1);
  EXPECT_NEAR(parts.end[0], 4., 1e-4);
  // On the box' surface.
  double outside = 0.;
  for (int a = 0; a < 3; ++a)
  {
    outside = std::max(outside, std::abs(ray.origin[a] + parts.begin[0] * ray.direction[a] - 1.));
  }
  EXPECT_NEAR(outside, 1., 1e-12);
  begin[3 * 8 + 4] = 1.f;
  EXPECT_EQ(stops.parts(camera, ray, 4, 3).count, 0);
}

TEST(RayStops, OnePlaneWithoutNormalHasAllOrNothing)
{
  DataCut cut;
  cut.halfSpaces.push_back({ {}, 0. });
  EXPECT_EQ(cut.parts({}, { 1., 0., 0. }, 0., 1.).count, 1);
  cut.halfSpaces.push_back({ {}, 1. });
  EXPECT_EQ(cut.parts({}, { 1., 0., 0. }, 0., 1.).count, 0);
}

TEST(RayStops, RejectsWhatIsNoStop)
{
  const Camera camera(
    multiply(perspective(40., 0.5, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 2, 2);
  RayStops plane;
  plane.cut.halfSpaces.push_back({ { 0., NAN, 0. }, 0. });
  EXPECT_THROW(plane.check(camera, "test"), Error);
  RayStops regions;
  regions.cut.cropping = CroppingRegions{ { 0., 1., 0., NAN, 0., 1. }, 1 };
  EXPECT_THROW(regions.check(camera, "test"), Error);
  const std::array<TranslucentHit, 1> hit{ { { 1., {} } } };
  std::vector<std::size_t> first(5, 0);
  RayStops surfaces;
  surfaces.hits = TranslucentHits{ first, {} };
  surfaces.check(camera, "test");
  surfaces.hits = TranslucentHits{ first, hit };
  EXPECT_THROW(surfaces.check(camera, "test"), Error);
  first.pop_back();
  surfaces.hits = TranslucentHits{ first, {} };
  EXPECT_THROW(surfaces.check(camera, "test"), Error);
}

// Ambient occlusion and shadows between parallel planes, where both are known.
#include "Surface/SecondaryRays.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/RandomTrees.h"
#include "Surface/SurfaceFrame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int pixels = 24;

/// value(p) of the points p of [0, 8]^3 on cells of levels 0 and 1; the domain begins at `offset`.
template <class Value>
std::shared_ptr<const Field> makeField(double offset, const Value& value)
{
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 512; ++i)
  {
    const std::array<Coord, 3> root{ i & 7, i >> 3 & 7, i >> 6 };
    if ((root[0] ^ root[1] ^ root[2]) & 2)
    {
      cells.push_back({ { root, 0 }, 0.f });
      continue;
    }
    for (int o = 0; o < 8; ++o)
    {
      cells.push_back(
        { { { 2 * root[0] + (o & 1), 2 * root[1] + (o >> 1 & 1), 2 * root[2] + (o >> 2) }, 1 }, 0.f });
    }
  }
  setValues(cells, value);
  auto built = buildOctree(RootGrid::uniform({ 8, 8, 8 }, { offset, offset, offset }, { 1., 1., 1. }), cells);
  auto field = std::make_shared<Field>(built.octree, built.values);
  return field;
}

/// The planes z = low and z = high.
class ParallelPlanes : public ::testing::Test
{
protected:
  static constexpr double low = 3.2;
  static constexpr double high = 4.6;

  /// Looks from `eye` to `at` in data coordinates.
  void look(const Vec3& eye, const Vec3& at, const Matrix4& worldFromData = identityMatrix)
  {
    camera_.emplace(multiply(perspective(30., 0.1, 30.), lookAt(eye, at)), worldFromData, pixels, pixels);
    surface_.render(*camera_, SurfaceLayers::Nearest, hits_);
    ASSERT_EQ(hits_.hits.size(), static_cast<std::size_t>(pixels) * pixels);
  }

  std::vector<std::uint16_t> occlusion(double radius, int first, int end) const
  {
    std::vector<std::uint16_t> open(hits_.hits.size());
    traceAmbientOcclusion(surface_, *camera_, hits_, radius, first, end, open);
    return open;
  }

  /// How many hits are lit, for each light.
  std::vector<int> lit(const std::vector<Light>& lights) const
  {
    std::vector<std::uint8_t> lit;
    traceShadows(surface_, *camera_, hits_, lights, lit);
    std::vector<int> counts(lights.size());
    for (std::size_t i = 0; i < lit.size(); ++i)
    {
      counts[i % lights.size()] += lit[i];
    }
    return counts;
  }

  Isosurface surface_{ makeField(0., [](const auto& p) { return p[2]; }), { low, high } };
  std::optional<Camera> camera_;
  HitImage hits_;
};

/// The plastic number's points are off by less than two of a few hundred in each interval.
constexpr int miscounted = 2;

Light bulb(const Vec3& position)
{
  Light light;
  light.positional = true;
  light.position = position;
  return light;
}

Light sun(const Vec3& direction)
{
  Light light;
  light.direction = direction;
  return light;
}

} // namespace

TEST_F(ParallelPlanes, OccludeByTheCosineToTheOtherPlane)
{
  // Of cosine-distributed rays the part c^2 has a cosine below c; those meet the other plane beyond gap / c.
  const Vec3 between{ 4., 4.2, 4.5 };
  const double gap = high - low;
  for (const double radius : { 0.9 * gap, 1.1 * gap, 1.5 * gap })
  {
    look(between, { 4., 3.9, low });
    const double open = std::min(1., gap / radius * (gap / radius));
    for (const std::uint16_t rays : occlusion(radius, 0, 256))
    {
      ASSERT_NEAR(rays, 256 * open, miscounted) << "radius " << radius;
    }
  }
  // From above, and from below.
  for (const double z : { 7.5, 0.5 })
  {
    look({ 4., 4.2, z }, { 4., 3.9, low });
    for (const std::uint16_t rays : occlusion(3., 0, 64))
    {
      ASSERT_EQ(rays, 64);
    }
  }
}

TEST_F(ParallelPlanes, OccludeWithinARadiusOfTheWorld)
{
  // Twice as high in the world and mirrored, turned about z.
  const Matrix4 worldFromData{ 0., -1., 0., 5., -1., 0., 0., 2., 0., 0., -2., 1., 0., 0., 0., 1. };
  look({ 4., 4.2, 4.5 }, { 4., 3.9, low }, worldFromData);
  const double gap = 2. * (high - low);
  for (const std::uint16_t rays : occlusion(1.1 * gap, 0, 256))
  {
    ASSERT_NEAR(rays, 256 / 1.21, miscounted);
  }
}

TEST_F(ParallelPlanes, RaysInPortionsAreTheSameRays)
{
  look({ 4., 4.2, 4.5 }, { 4., 3.9, low });
  std::vector<std::uint16_t> open = occlusion(2., 0, 5);
  traceAmbientOcclusion(surface_, *camera_, hits_, 2., 5, 32, open);
  EXPECT_EQ(open, occlusion(2., 0, 32));
  // Neighbours have other rays, or their errors would be seen as bands.
  EXPECT_NE(std::adjacent_find(open.begin(), open.end(), std::not_equal_to()), open.end());
}

TEST_F(ParallelPlanes, RaysOfNeighboursCompleteEachOther)
{
  look({ 4., 4.2, 4.5 }, { 4., 3.9, low });
  const double gap = high - low;
  for (const double radius : { 1.1 * gap, 1.5 * gap, 2. * gap })
  {
    const std::vector<std::uint16_t> open = occlusion(radius, 0, 16);
    for (int y = 0; y + 4 <= pixels; ++y)
    {
      for (int x = 0; x + 4 <= pixels; ++x)
      {
        int together = 0;
        for (int i = 0; i < 16; ++i)
        {
          together += open[pixels * (y + i / 4) + x + i % 4];
        }
        ASSERT_NEAR(together, 256 * gap / radius * (gap / radius), miscounted) << "radius " << radius;
      }
    }
  }
}

TEST_F(ParallelPlanes, WhatIsCutAwayNeitherOccludesNorCastsShadows)
{
  look({ 4., 4.2, 4.5 }, { 4., 3.9, low });
  DataCut below;
  below.halfSpaces = { { { 0., 0., -1. }, -4. } }; // what is up to z = 4
  DataCut hole;
  hole.cropping = CroppingRegions{ { -1., 9., -1., 9., 4., 5. }, 0x7fc01ffu }; // all but the middle layer
  for (const DataCut& cut : { below, hole })
  {
    std::vector<std::uint16_t> open(hits_.hits.size());
    traceAmbientOcclusion(surface_, *camera_, hits_, 3., 0, 16, open, cut);
    EXPECT_EQ(open, std::vector<std::uint16_t>(open.size(), 16));
    std::vector<std::uint8_t> lit;
    traceShadows(surface_, *camera_, hits_, { sun({ 0., 0., -1. }), bulb({ 4., 4., 7. }) }, lit, cut);
    EXPECT_EQ(lit, std::vector<std::uint8_t>(2 * hits_.hits.size(), 1));
  }
}

TEST_F(ParallelPlanes, CastShadowsOnEachOther)
{
  look({ 4., 4.2, 4.5 }, { 4., 3.9, low });
  Light exempt = bulb({ 4., 4., 7. });
  exempt.castsShadows = false;
  const double down = 1. / std::sqrt(2.);
  const std::vector<Light> lights{ bulb({ 4., 4., 7. }), bulb({ 4., 4., high - 0.01 }), bulb({ 4., 4., 1. }),
    exempt, sun({ 0., 0., -1. }), sun({ down, 0., -down }), sun({ 0., 0., 1. }) };
  constexpr int all = pixels * pixels;
  // Nothing is traced for lights behind the surface.
  EXPECT_EQ(lit(lights), (std::vector<int>{ 0, all, all, all, 0, 0, all }));
  look({ 4., 4.2, 7.5 }, { 4., 3.9, low });
  EXPECT_EQ(lit(lights), std::vector<int>(7, all));
}

TEST(SecondaryRays, DoNotMeetTheSurfaceThatTheyStartOn)
{
  // A slanted plane across cells of two sizes, where hits are rounded to 2^-30 of a cell.
  const double offset = 0x1p22;
  const Isosurface surface(
    makeField(offset, [](const auto& p) { return 0.3 * p[0] + 0.5 * p[1] + 0.8 * p[2] - 6.4; }), { 0. });
  const Matrix4 moved{ 1., 0., 0., -offset, 0., 1., 0., -offset, 0., 0., 1., -offset, 0., 0., 0., 1. };
  for (const double side : { -1., 1. })
  {
    const Vec3 eye{ 4. + 1.2 * side, 4. + 2. * side, 4. + 3.2 * side };
    const Camera camera(multiply(multiply(perspective(50., 0.1, 30.), lookAt(eye, { 4., 4., 4. })), moved),
      moved, pixels, pixels);
    HitImage hits;
    surface.render(camera, SurfaceLayers::All, hits);
    std::vector<std::uint16_t> open(hits.hits.size());
    traceAmbientOcclusion(surface, camera, hits, 1., 0, 64, open);
    int inside = 0;
    for (std::size_t pixel = 0; pixel + 1 < hits.first.size(); ++pixel)
    {
      for (std::size_t i = hits.first[pixel]; i < hits.first[pixel + 1]; ++i)
      {
        const Ray ray = camera.ray(static_cast<int>(pixel) % pixels, static_cast<int>(pixel) / pixels);
        const Vec3 p = pointAt(ray, hits.hits[i].t) - Vec3{ offset, offset, offset };
        // At the domain's edge the reconstruction bends.
        if (std::min({ p[0], p[1], p[2] }) > 1.6 && std::max({ p[0], p[1], p[2] }) < 6.4)
        {
          ++inside;
          ASSERT_EQ(open[i], 64);
        }
      }
    }
    EXPECT_GT(inside, 100);
  }
}

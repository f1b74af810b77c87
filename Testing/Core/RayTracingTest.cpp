#include "Error.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Surface/Shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Length of a ray (unit direction, from its origin) inside the box, by clipping against six planes.
double chord(const Ray& ray, const Vec3& low, const Vec3& high)
{
  double t0 = 0.;
  double t1 = 1e30;
  for (int a = 0; a < 3; ++a)
  {
    const double p = (low[a] - ray.origin[a]) / ray.direction[a];
    const double q = (high[a] - ray.origin[a]) / ray.direction[a];
    t0 = std::max(t0, std::min(p, q));
    t1 = std::min(t1, std::max(p, q));
  }
  return std::max(0., t1 - t0);
}

TransferFunction constant(float extinction)
{
  return TransferFunction(-1., 1., std::vector<TransferFunction::Entry>(2, { 0.5f, 0.25f, 1.f, extinction }));
}

/// A plane z = at of one colour and opacity.
struct ColoredPlane
{
  double z;
  std::array<float, 4> rgba;
};

/// Where the camera's rays meet the planes, between near and far.
PixelHits meet(const Camera& camera, const std::vector<ColoredPlane>& planes)
{
  PixelHits hits;
  for (int y = 0; y < camera.height(); ++y)
  {
    for (int x = 0; x < camera.width(); ++x)
    {
      const Ray ray = camera.ray(x, y);
      std::vector<std::pair<double, std::array<float, 4>>> ofRay;
      for (const ColoredPlane& plane : planes)
      {
        const double t = (plane.z - ray.origin[2]) / ray.direction[2];
        if (t >= camera.tFromDepth(ray, 0.) && t <= camera.tFromDepth(ray, 1.))
        {
          ofRay.emplace_back(t, plane.rgba);
        }
      }
      std::sort(ofRay.begin(), ofRay.end());
      for (const auto& [t, rgba] : ofRay)
      {
        hits.add(t, rgba);
      }
      hits.endPixel();
    }
  }
  return hits;
}

/// Visible in part of the range only, with a smooth rise.
TransferFunction partial()
{
  std::vector<TransferFunction::Entry> entries;
  for (int i = 0; i <= 1000; ++i)
  {
    const auto u = static_cast<float>(i) / 1000.f;
    entries.push_back({ u, 1.f - u, 0.5f, u < 0.6f ? 0.f : 20.f * (u - 0.6f) });
  }
  return TransferFunction(-1., 1., entries);
}

} // namespace

TEST(Camera, RoundTripsPixelsAndDepths)
{
  const Matrix4 model{ 2, 0.3, 0, 5, 0, 1, 0.1, -3, 0.2, 0, 3, 1, 0, 0, 0, 1 };
  for (const Matrix4& projection : { perspective(40., 0.1, 50.), parallel(2., 0.1, 50.) })
  {
    const Matrix4 clip = multiply(projection, multiply(lookAt({ 9., 2., 7. }, { 5., -3., 1. }), model));
    const Camera camera(clip, model, 31, 17);
    for (int i = 0; i < 31 * 17; ++i)
    {
      const int x = i % 31;
      const int y = i / 31;
      const Ray ray = camera.ray(x, y);
      for (const double depth : { 0., 0.3, 0.9, 1. })
      {
        const double t = camera.tFromDepth(ray, depth);
        EXPECT_NEAR(camera.depthFromT(ray, t), depth, 1e-12);
        // The point projects to the pixel's centre, and t is a length in world coordinates.
        double h[4];
        double w[3];
        for (int r = 0; r < 4; ++r)
        {
          h[r] = clip[4 * r + 3];
          for (int a = 0; a < 3; ++a)
          {
            h[r] += clip[4 * r + a] * (ray.origin[a] + t * ray.direction[a]);
          }
        }
        EXPECT_NEAR((h[0] / h[3] + 1.) / 2. * 31, x + 0.5, 1e-9);
        EXPECT_NEAR((h[1] / h[3] + 1.) / 2. * 17, y + 0.5, 1e-9);
        double squared = 0.;
        for (int r = 0; r < 3; ++r)
        {
          w[r] = dot({ model[4 * r], model[4 * r + 1], model[4 * r + 2] }, ray.direction);
          squared += w[r] * w[r];
        }
        EXPECT_NEAR(squared, 1., 1e-12);
      }
      EXPECT_LT(camera.tFromDepth(ray, 0.2), camera.tFromDepth(ray, 0.4));
    }
  }
  Matrix4 singular = identityMatrix;
  singular[5] = 0.;
  EXPECT_THROW(Camera(singular, identityMatrix, 4, 4), Error);
  EXPECT_THROW(Camera(identityMatrix, identityMatrix, 0, 4), Error);
}

TEST(TransferFunction, KnowsWhereItIsVisible)
{
  const TransferFunction f = partial();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> value(-1.5f, 1.5f);
  for (int i = 0; i < 20000; ++i)
  {
    float a = value(random);
    float b = value(random);
    if (a > b)
    {
      std::swap(a, b);
    }
    bool visible = false;
    for (int s = 0; s <= 50; ++s)
    {
      visible = visible || f.at(a + (b - a) * static_cast<float>(s) / 50.f).extinction > 0.f;
    }
    // Never left out although visible; never kept when more than a table entry away.
    EXPECT_TRUE(f.isVisible({ a, b }) || !visible);
    EXPECT_TRUE(!f.isVisible({ a, b }) || b > 0.2f - 0.004f);
  }
  using Entry = TransferFunction::Entry;
  EXPECT_THROW(TransferFunction(0., 1., { Entry{} }), Error);
  EXPECT_THROW(TransferFunction(1., 0., { Entry{}, Entry{} }), Error);
  EXPECT_THROW(TransferFunction(0., 1., { Entry{}, Entry{ 0, 0, 0, -1.f } }), Error);
  EXPECT_EQ(TransferFunction::extinctionFromOpacity(0., 1.), 0.f);
  EXPECT_NEAR(1. - std::exp(-TransferFunction::extinctionFromOpacity(0.3, 2.) * 2.), 0.3, 1e-7);
  EXPECT_EQ(std::exp(-TransferFunction::extinctionFromOpacity(1., 1.) * 1e-6f), 0.f);
}

TEST(Volume, HomogeneousCubeIsExact)
{
  const RandomTree options{ 2, { 1, 1, 1 }, 5, 0.6, 0., false };
  auto cells = makeRandomTree(options);
  setValues(cells, [](const auto&) { return 0.25; });
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  // Outside, inside, and parallel.
  const Matrix4 cameras[]{ multiply(perspective(50., 0.1, 9.), lookAt({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 })),
    multiply(perspective(80., 1e-4, 9.), lookAt({ 0.4, 0.45, 0.6 }, { 0.9, 0.2, 0.1 })),
    multiply(parallel(0.9, 0.1, 9.), lookAt({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 })) };
  for (const Matrix4& clip : cameras)
  {
    const Camera camera(clip, identityMatrix, 64, 48);
    Image image(64, 48);
    const auto statistics = renderVolume(*field, constant(1.5f), camera, {}, {}, image);
    EXPECT_GT(statistics.samples, 1000u);
    for (int y = 0; y < 48; ++y)
    {
      for (int x = 0; x < 64; ++x)
      {
        Ray ray = camera.ray(x, y);
        const double near = camera.tFromDepth(ray, 0.);
        for (int a = 0; a < 3; ++a)
        {
          ray.origin[a] += near * ray.direction[a];
        }
        const double alpha = 1. - std::exp(-1.5 * chord(ray, { 0., 0., 0. }, { 1., 1., 1. }));
        const float* p = image.rgba.data() + 4 * (64 * y + x);
        EXPECT_NEAR(p[3], alpha, 5e-6);
        EXPECT_NEAR(p[0], 0.5 * alpha, 5e-6);
        EXPECT_NEAR(p[2], alpha, 5e-6);
      }
    }
  }
}

TEST(Volume, SkippingNeverChangesABit)
{
  std::uint64_t samplesSaved = 0;
  for (const RandomTree& options : propertyTrees())
  {
    auto cells = makeRandomTree(options);
    if (options.seed % 2 == 0)
    {
      setValues(cells, [](const auto& p) { return std::sin(3. * p[0] + p[1]) * std::cos(2. * p[2]); });
    }
    const auto field = makeField(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
    const Vec3 middle{ 0.5 * options.roots[0], 0.5 * options.roots[1], 0.5 * options.roots[2] };
    const Camera camera(
      multiply(perspective(40., 0.1, 99.), lookAt({ 5., 4., 6. }, middle)), identityMatrix, 61, 53);
    Image with(61, 53);
    Image without(61, 53);
    VolumeSettings settings;
    const auto skipped = renderVolume(*field, partial(), camera, {}, settings, with);
    settings.skipEmpty = false;
    const auto all = renderVolume(*field, partial(), camera, {}, settings, without);
    EXPECT_EQ(with.rgba, without.rgba);
    samplesSaved += all.samples - skipped.samples;
  }
  EXPECT_GT(samplesSaved, 10000u);
}

TEST(Volume, PartsOfARayComposeToTheWhole)
{
  const RandomTree options{ 12, { 2, 2, 2 }, 4, 0.6, 0., false };
  const auto field =
    makeField(RootGrid::uniform({ 2, 2, 2 }, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options));
  const Camera camera(
    multiply(perspective(40., 1., 9.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 40, 40);
  VolumeSettings settings;
  settings.samplesPerCell = 256.; // cutting a ray moves its samples
  const std::vector<float> cut(1600, 0.85f);
  Image whole(40, 40);
  Image front(40, 40);
  Image back(40, 40);
  renderVolume(*field, partial(), camera, {}, settings, whole);
  renderVolume(*field, partial(), camera, RayStops::depths(nullptr, cut.data()), settings, front);
  renderVolume(*field, partial(), camera, RayStops::depths(cut.data(), nullptr), settings, back);
  float largest = 0.f;
  for (std::size_t i = 0; i < whole.rgba.size(); ++i)
  {
    const float through = 1.f - front.rgba[i | 3];
    EXPECT_NEAR(front.rgba[i] + through * back.rgba[i], whole.rgba[i], 2e-3);
    largest = std::max(largest, std::min(front.rgba[i], back.rgba[i]));
  }
  EXPECT_GT(largest, 0.2f);
}

TEST(Volume, PlanesInAHomogeneousCubeAreExact)
{
  auto cells = makeRandomTree({ 2, { 1, 1, 1 }, 5, 0.6, 0., false });
  setValues(cells, [](const auto&) { return 0.25; });
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  // The last one is outside of the cube: seen as well.
  const std::vector<ColoredPlane> planes{ { 0.3, { 1.f, 0.f, 0.5f, 0.3f } },
    { 0.625, { 0.2f, 0.7f, 0.1f, 0.6f } }, { 0.63, { 0.f, 0.f, 1.f, 0.f } },
    { 1.2, { 0.3f, 0.3f, 0.9f, 0.5f } } };
  constexpr std::array<double, 3> medium{ 0.5, 0.25, 1. };
  const Matrix4 cameras[]{ multiply(perspective(50., 0.1, 9.), lookAt({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 })),
    multiply(perspective(80., 1e-4, 9.), lookAt({ 0.4, 0.45, 0.6 }, { 0.9, 0.2, 0.1 })),
    multiply(perspective(0.3, 900., 1100.), lookAt({ 600., 500., 620. }, { 0.5, 0.5, 0.5 })),
    multiply(parallel(0.9, 0.1, 9.), lookAt({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 })) };
  for (const Matrix4& clip : cameras)
  {
    const Camera camera(clip, identityMatrix, 64, 48);
    const PixelHits hits = meet(camera, planes);
    ASSERT_GT(hits.hits.size(), 1000u);
    Image image(64, 48);
    renderVolume(*field, constant(1.5f), camera, hits.stops(), {}, image);
    for (int i = 0; i < 64 * 48; ++i)
    {
      Ray ray = camera.ray(i % 64, i / 64);
      std::array<double, 4> expected{};
      const auto add = [&](const auto& color, double alpha) {
        const double weight = (1. - expected[3]) * alpha;
        for (int c = 0; c < 3; ++c)
        {
          expected[c] += weight * color[c];
        }
        expected[3] += weight;
      };
      // The chord behind a point of the ray, less that behind the next, lies between them.
      const auto behind = [&](double t) {
        Ray rest = ray;
        for (int a = 0; a < 3; ++a)
        {
          rest.origin[a] += t * ray.direction[a];
        }
        return chord(rest, { 0., 0., 0. }, { 1., 1., 1. });
      };
      double remaining = behind(camera.tFromDepth(ray, 0.));
      for (std::size_t h = hits.first[i]; h < hits.first[i + 1]; ++h)
      {
        const double rest = behind(hits.hits[h].t);
        add(medium, -std::expm1(-1.5 * (remaining - rest)));
        add(hits.hits[h].rgba, hits.hits[h].rgba[3]);
        remaining = rest;
      }
      add(medium, -std::expm1(-1.5 * remaining));
      for (int c = 0; c < 4; ++c)
      {
        ASSERT_NEAR(image.rgba[4 * i + c], expected[c], 5e-6) << "pixel " << i << ", channel " << c;
      }
    }
  }
}

TEST(Volume, PartsOfARayHaveEachSurfaceOnce)
{
  const RandomTree options{ 12, { 2, 2, 2 }, 4, 0.6, 0., false };
  const auto field =
    makeField(RootGrid::uniform({ 2, 2, 2 }, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options));
  const Camera camera(
    multiply(perspective(40., 1., 9.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 40, 40);
  PixelHits hits = meet(camera,
    { { 0.4, { 1.f, 0.f, 0.f, 0.3f } }, { 1.1, { 0.f, 1.f, 0.f, 0.4f } }, { 1.7, { 0.f, 0.f, 1.f, 0.5f } } });
  // Every other ray is cut at its first hit, as near as a depth comes to it.
  std::vector<float> cut(1600, 0.85f);
  for (int i = 0; i < 1600; i += 2)
  {
    if (hits.first[i] < hits.first[i + 1])
    {
      cut[i] = static_cast<float>(camera.depthFromT(camera.ray(i % 40, i / 40), hits.hits[hits.first[i]].t));
    }
  }
  VolumeSettings settings;
  settings.samplesPerCell = 256.; // cutting a ray moves its samples
  Image whole(40, 40);
  Image front(40, 40);
  Image back(40, 40);
  renderVolume(*field, partial(), camera, hits.stops(), settings, whole);
  renderVolume(*field, partial(), camera, hits.stops(nullptr, cut.data()), settings, front);
  renderVolume(*field, partial(), camera, hits.stops(cut.data()), settings, back);
  float largest = 0.f;
  for (std::size_t i = 0; i < whole.rgba.size(); ++i)
  {
    const float through = 1.f - front.rgba[i | 3];
    EXPECT_NEAR(front.rgba[i] + through * back.rgba[i], whole.rgba[i], 2e-3) << i;
    largest = std::max(largest, std::min(front.rgba[i], back.rgba[i]));
  }
  EXPECT_GT(largest, 0.2f);
}

/// The unit cube behind half spaces and cropping regions, by the chords of the regions' boxes.
TEST(Volume, CutsOfAHomogeneousCubeAreExact)
{
  auto cells = makeRandomTree({ 2, { 1, 1, 1 }, 5, 0.6, 0., false });
  setValues(cells, [](const auto&) { return 0.25; });
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  const Matrix4 cameras[]{ multiply(perspective(50., 0.1, 9.), lookAt({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 })),
    multiply(perspective(80., 1e-4, 9.), lookAt({ 0.4, 0.45, 0.6 }, { 0.9, 0.2, 0.1 })),
    multiply(perspective(0.3, 900., 1100.), lookAt({ 600., 500., 620. }, { 0.5, 0.5, 0.5 })),
    multiply(parallel(0.9, 0.1, 9.), lookAt({ 2.1, 1.7, 1.3 }, { 0.5, 0.5, 0.5 })) };
  const std::array<std::array<double, 4>, 3> edges{ { { 0., 0.25, 0.71, 1. }, { 0., 0.33, 0.6, 1. },
    { 0., 0.125, 0.5, 1. } } };
  for (const Matrix4& clip : cameras)
  {
    const Camera camera(clip, identityMatrix, 64, 48);
    for (const std::uint32_t shown : { 0x0002000u, 0x7ffdfffu, 0x2ebfeba & 0x7ffffffu, 0x5145145u })
    {
      RayStops stops;
      stops.cut.cropping =
        CroppingRegions{ { edges[0][1], edges[0][2], edges[1][1], edges[1][2], edges[2][1], edges[2][2] },
          shown };
      Image image(64, 48);
      renderVolume(*field, constant(1.5f), camera, stops, {}, image);
      for (int i = 0; i < 64 * 48; ++i)
      {
        Ray ray = camera.ray(i % 64, i / 64);
        const double near = camera.tFromDepth(ray, 0.);
        for (int a = 0; a < 3; ++a)
        {
          ray.origin[a] += near * ray.direction[a];
        }
        double length = 0.;
        for (int region = 0; region < 27; ++region)
        {
          const std::array<int, 3> at{ region % 3, region / 3 % 3, region / 9 };
          length += shown >> region & 1 ? chord(ray, { edges[0][at[0]], edges[1][at[1]], edges[2][at[2]] },
                                            { edges[0][at[0] + 1], edges[1][at[1] + 1], edges[2][at[2] + 1] })
                                        : 0.;
        }
        ASSERT_NEAR(image.rgba[4 * i + 3], -std::expm1(-1.5 * length), 5e-6) << shown << ", pixel " << i;
      }
    }
    // A wedge: the cube's chord less that beyond each plane, which meet in no point of it.
    RayStops wedge;
    wedge.cut.halfSpaces = { { { 2., 0.3, 0. }, 0.9 }, { { 0., -1., -0.2 }, -0.7 } };
    Image image(64, 48);
    renderVolume(*field, constant(1.5f), camera, wedge, {}, image);
    for (int i = 0; i < 64 * 48; ++i)
    {
      const Ray ray = camera.ray(i % 64, i / 64);
      double t0 = camera.tFromDepth(ray, 0.);
      double t1 = camera.tFromDepth(ray, 1.);
      const auto narrow = [&](const Vec3& normal, double offset) {
        const double t = (offset - dot(normal, ray.origin)) / dot(normal, ray.direction);
        (dot(normal, ray.direction) > 0. ? t0 : t1) =
          dot(normal, ray.direction) > 0. ? std::max(t0, t) : std::min(t1, t);
      };
      narrow({ 2., 0.3, 0. }, 0.9);
      narrow({ 0., -1., -0.2 }, -0.7);
      for (int a = 0; a < 3; ++a)
      {
        Vec3 axis{};
        axis[a] = 1.;
        narrow(axis, 0.);
        axis[a] = -1.;
        narrow(axis, -1.);
      }
      ASSERT_NEAR(image.rgba[4 * i + 3], -std::expm1(-1.5 * std::max(0., t1 - t0)), 5e-6) << "pixel " << i;
    }
  }
}

/// Planes through an adaptive field, beside depths that each ray's own places on them are turned into here.
TEST(Volume, PlanesAreStopsSetByHand)
{
  const RandomTree options{ 12, { 2, 2, 2 }, 5, 0.6, 0., false };
  const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
  const std::vector<HalfSpace> planes{ { { 2., 0.3, 0.7 }, 2.1 }, { { -0.4, -1., -0.2 }, -2.3 } };
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  constexpr int size = 64;
  for (const Matrix4& projection : { perspective(40., 2., 9.), parallel(1.6, 2., 9.) })
  {
    const Camera camera(
      multiply(projection, lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, size, size);
    std::vector<float> begin(size * size);
    std::vector<float> end(size * size);
    for (int i = 0; i < size * size; ++i)
    {
      const Ray ray = camera.ray(i % size, i / size);
      double t0 = camera.tFromDepth(ray, 0.);
      double t1 = camera.tFromDepth(ray, 1.);
      for (const HalfSpace& plane : planes)
      {
        const double along = dot(plane.normal, ray.direction);
        const double t = (plane.offset - dot(plane.normal, ray.origin)) / along;
        t0 = along > 0. ? std::max(t0, t) : t0;
        t1 = along > 0. ? t1 : std::min(t1, t);
      }
      begin[i] = static_cast<float>(camera.depthFromT(ray, t0));
      end[i] = static_cast<float>(camera.depthFromT(ray, std::max(t0, t1)));
    }
    RayStops cut;
    cut.cut.halfSpaces = planes;
    Image byPlanes(size, size);
    Image byHand(size, size);
    Image whole(size, size);
    renderVolume(*field, partial(), camera, cut, settings, byPlanes);
    renderVolume(*field, partial(), camera, RayStops::depths(begin.data(), end.data()), settings, byHand);
    renderVolume(*field, partial(), camera, {}, settings, whole);
    float drawn = 0.f;
    float cutAway = 0.f;
    for (std::size_t i = 0; i < byHand.rgba.size(); ++i)
    {
      ASSERT_NEAR(byPlanes.rgba[i], byHand.rgba[i], 1e-4) << "pixel " << i / 4;
      drawn = std::max(drawn, byHand.rgba[i]);
      cutAway = std::max(cutAway, std::abs(whole.rgba[i] - byHand.rgba[i]));
    }
    EXPECT_GT(drawn, 0.2f);
    EXPECT_GT(cutAway, 0.2f);
  }
}

TEST(Volume, WhatIsCutAwayTakesNothing)
{
  const auto field = makeField(RootGrid::uniform({ 2, 2, 2 }, { 0., 0., 0. }, { 1., 1., 1. }),
    makeRandomTree({ 1, { 2, 2, 2 }, 5, 1., 0., false }));
  const Camera camera(
    multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 64, 64);
  Image image(64, 64);
  const auto render = [&](const RayStops& stops) {
    return renderVolume(*field, constant(0.01f), camera, stops, {}, image);
  };
  const VolumeStatistics all = render({});
  RayStops nothing;
  nothing.cut.halfSpaces.push_back({ { 1., 0., 0. }, 2.5 });
  const VolumeStatistics none = render(nothing);
  constexpr std::uint64_t tiles = 16; // each of which looks at the root
  EXPECT_LE(none.nodes, tiles);
  EXPECT_EQ(none.blocks + none.kept + none.intervals + none.samples, 0u);
  EXPECT_EQ(image.rgba, LargeVector<float>(image.rgba.size(), 0.f));

  // The two halves of the domain; its middle and what is around that: nodes are entered for one of the two alone, but
  // for those on the way to both. The planes do not quite touch nodes' faces, where rounding may take either side.
  RayStops lower;
  lower.cut.halfSpaces.push_back({ { -1., 0., 0. }, -0.999 });
  RayStops upper;
  upper.cut.halfSpaces.push_back({ { 1., 0., 0. }, 1.001 });
  RayStops middle;
  middle.cut.cropping = CroppingRegions{ { 0.501, 1.499, 0.501, 1.499, 0.501, 1.499 }, 0x0002000u };
  RayStops around;
  around.cut.cropping = CroppingRegions{ { 0.499, 1.501, 0.499, 1.501, 0.499, 1.501 }, 0x7ffdfffu };
  for (const auto& [a, b] : { std::pair(lower, upper), std::pair(middle, around) })
  {
    const VolumeStatistics partA = render(a);
    const VolumeStatistics partB = render(b);
    EXPECT_GT(std::min(partA.intervals, partB.intervals), all.intervals / 10);
    EXPECT_LE(partA.nodes + partB.nodes, all.nodes + 9 * tiles);
    // Groups of rays that the border goes through are taken on both of its sides.
    EXPECT_LT(
      static_cast<double>(partA.intervals + partB.intervals), 1.05 * static_cast<double>(all.intervals));
  }
}

TEST(Volume, ConvergesWithTheStep)
{
  const RandomTree options{ 12, { 2, 2, 2 }, 4, 0.6, 0., false };
  const auto field =
    makeField(RootGrid::uniform({ 2, 2, 2 }, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options));
  const Camera camera(
    multiply(perspective(40., 1., 9.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 40, 40);
  const auto render = [&](double samplesPerCell) {
    Image image(40, 40);
    renderVolume(*field, partial(), camera, {}, { samplesPerCell, true }, image);
    return image.rgba;
  };
  const auto reference = render(512.);
  const auto rmse = [&](double samplesPerCell) {
    const auto image = render(samplesPerCell);
    double sum = 0.;
    for (std::size_t i = 0; i < image.size(); ++i)
    {
      sum += std::pow(image[i] - reference[i], 2);
    }
    return std::sqrt(sum / static_cast<double>(image.size()));
  };
  const double error2 = rmse(2.);
  const double error4 = rmse(4.);
  const double error8 = rmse(8.);
  EXPECT_GT(error2 / error4, 2.5);
  EXPECT_GT(error4 / error8, 2.5);
  EXPECT_LT(error8, 2e-3);
}

TEST(Volume, RejectsBadSettings)
{
  const auto field = makeField(unitRoots({ 1, 1, 1 }), { { {}, 0.5f } });
  const Camera camera(
    multiply(perspective(40., 1., 9.), lookAt({ 4., 3., 3.5 }, { 0., 0., 0. })), identityMatrix, 8, 8);
  Image wrong(8, 9);
  Image right(8, 8);
  EXPECT_THROW(renderVolume(*field, constant(1.f), camera, {}, {}, wrong), Error);
  EXPECT_THROW(renderVolume(*field, constant(1.f), camera, {}, { 0., true }, right), Error);
  EXPECT_THROW(renderVolume(*field, constant(1.f), camera, {}, { NAN, true }, right), Error);
  EXPECT_THROW(renderVolume(*field, constant(1.f), camera, {}, { 1e30, true }, right), Error);
  auto built = buildOctree(unitRoots({ 1, 1, 1 }), std::vector<LeafCell>{});
  Field empty(built.octree, built.values);
  renderVolume(empty, constant(1.f), camera, {}, {}, right);
  EXPECT_EQ(right.rgba, LargeVector<float>(256, 0.f));

  PixelHits tooManyHits;
  tooManyHits.first.assign(8 * 8 + 1, 0);
  tooManyHits.add(1., { 1.f, 1.f, 1.f, 0.5f });
  EXPECT_THROW(renderVolume(*field, constant(1.f), camera, tooManyHits.stops(), {}, right), Error);
  RayStops noPlane;
  noPlane.cut.halfSpaces.push_back({ { NAN, 0., 0. }, 0. });
  EXPECT_THROW(renderVolume(*field, constant(1.f), camera, noPlane, {}, right), Error);
}

TEST(Shading, FollowsTheTermsOfVtk)
{
  Material m;
  m.ambient = { 0.1f, 0.f, 0.f };
  m.diffuse = { 0.5f, 0.5f, 0.f };
  m.specular = { 0.f, 0.f, 1.f };
  m.specularPower = 2.f;
  const Vec3 z{ 0., 0., 1. };
  const Vec3 slanted = unit({ 0., 1., 1. });
  Light head;
  head.direction = { 0., 0., -1. };
  // cos 45 degrees for the diffuse term; the mirrored ray leaves at 90 degrees from the eye: no highlight.
  auto c = shade(m, { head }, {}, slanted, z);
  EXPECT_NEAR(c[0], 0.1 + 0.5 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(c[1], 0.5 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(c[2], 0., 1e-6);
  Light spot;
  spot.positional = true;
  spot.position = { 0., 0., 2. };
  spot.direction = { 0., 0., -1. };
  spot.attenuation = { 0., 0., 1. };
  spot.coneAngle = 30.;
  c = shade(m, { spot }, { 0., 0., 0. }, z, z);
  EXPECT_NEAR(c[1], 0.5 / 4., 1e-6);
  EXPECT_NEAR(c[2], 1. / 4., 1e-6);
  EXPECT_EQ(shade(m, { spot }, { 0., 2., 0. }, z, z)[1], 0.f); // outside the cone
  // Something that takes three quarters of it stands before the spot, nothing before the other light.
  const std::array<std::uint8_t, 2> lit{ 0, 1 };
  const auto head1 = shade(m, { head }, {}, z, z);
  const auto both = shade(m, { spot, head }, {}, z, z, lit.data(), 0.75f);
  EXPECT_NEAR(both[1], 0.25 * c[1] + head1[1], 1e-6);
  EXPECT_NEAR(shade(m, { spot, head }, {}, z, z, lit.data())[1], head1[1], 1e-6);
}

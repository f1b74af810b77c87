// Volumes of categories: each ray against the boxes of all leaves, composited exactly.
#include "Error.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/ExactCells.h"
#include "Support/Fields.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Volume/ErrorEstimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 29;
constexpr int height = 23;

/// Numbers of categories in place of the values.
std::vector<LeafCell> categorise(std::vector<LeafCell> cells, int count, std::uint32_t seed = 3)
{
  std::mt19937 random(seed);
  for (LeafCell& cell : cells)
  {
    cell.value = static_cast<float>(random() % static_cast<unsigned>(count));
  }
  return cells;
}

/// Entries unlike their neighbours, each fourth transparent.
std::vector<TransferFunction::Entry> entries(int count, float extinction)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  std::vector<TransferFunction::Entry> result;
  for (int i = 0; i < count; ++i)
  {
    result.push_back(
      { uniform(random), uniform(random), uniform(random), i % 4 == 3 ? 0.f : extinction * uniform(random) });
  }
  return result;
}

/// Of a domain of 2 x 2 x 2.
std::vector<Camera> cameras()
{
  const Vec3 middle{ 1.01, 1.02, 0.97 };
  const auto camera = [](const Matrix4& clip) { return Camera(clip, identityMatrix, width, height); };
  return { camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle))),
    camera(multiply(perspective(90., 1e-3, 20.), lookAt({ 1.1, 0.8, 1.3 }, { 0., 0.1, 0.2 }))),
    camera(multiply(perspective(0.3, 900., 1100.), lookAt({ 600., 500., 620. }, middle))),
    camera(multiply(parallel(1.9, 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle))) };
}

/// Largest difference of a channel of any kernel, infinite where instruction sets differ; least of the brightest opacities.
struct Comparison
{
  double error = 0.;
  float opacity = 0.f;
};

Comparison compare(const RootGrid& grid, const std::vector<LeafCell>& cells,
  const std::vector<TransferFunction::Entry>& entries, const Camera& camera)
{
  const auto field = makeField(grid, cells);
  const TransferFunction transferFunction = TransferFunction::ofCategories(entries);
  Comparison result;
  std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
  forEachKernel({}, [&](const std::string& /*kernel*/, const VolumeSettings& settings) {
    Image image(camera.width(), camera.height());
    renderVolume(*field, transferFunction, camera, {}, settings, image);
    Image& first = firsts[settings.doubles];
    first = first.width == 0 ? image : first;
    result.error = first.rgba == image.rgba ? result.error : INFINITY;
  });
  Image reference(camera.width(), camera.height());
  renderVolumeReference(*field, transferFunction, camera, {}, {}, reference);
  for (int i = 0; i < camera.width() * camera.height(); ++i)
  {
    const auto expected = lightOf(partsOfRay(grid, cells, camera, i % camera.width(), i / camera.width()),
      [&](float value) { return entries[static_cast<std::size_t>(value)]; });
    for (std::size_t c = 0; c < 4; ++c)
    {
      const std::size_t at = 4 * static_cast<std::size_t>(i) + c;
      for (const Image* image : { &firsts[0], &firsts[1], &reference })
      {
        const double error = std::abs(image->rgba[at] - expected[c]);
        result.error = error <= result.error ? result.error : error; // NaN counts
      }
    }
    result.opacity = std::max(result.opacity, firsts[0].rgba[4 * static_cast<std::size_t>(i) + 3]);
  }
  return result;
}

/// Two roots along each axis; the first is refined towards the middle.
std::vector<LeafCell> cornerTree(int depth)
{
  std::vector<LeafCell> cells;
  for (int o = 1; o < 8; ++o)
  {
    cells.push_back({ { { o & 1, o >> 1 & 1, o >> 2 }, 0 }, 0.f });
  }
  for (int level = 1; level <= depth; ++level)
  {
    const Coord last = (Coord(1) << level) - 1;
    for (int o = 0; o < (level == depth ? 8 : 7); ++o)
    {
      cells.push_back(
        { { { last - 1 + (o & 1), last - 1 + (o >> 1 & 1), last - 1 + (o >> 2) }, level }, 0.f });
    }
  }
  return cells;
}

/// Roundings of the rays' places, at these extinctions.
constexpr double rounding = 2e-5;

} // namespace

TEST(Categories, EveryRayIsThatThroughTheLeavesBoxes)
{
  for (const RandomTree& options : { RandomTree{ 12, { 2, 2, 2 }, 4, 0.6, 0., false },
         RandomTree{ 13, { 2, 2, 2 }, 5, 0.4, 0.2, false }, RandomTree{ 14, { 2, 2, 2 }, 3, 0.7, 0., true } })
  {
    for (const int count : { 1, 2, 7, 1000 })
    {
      const auto cells = categorise(makeRandomTree(options), count);
      for (const Camera& camera : cameras())
      {
        const Comparison found = compare(unitRoots(options.roots), cells, entries(count, 2.f), camera);
        EXPECT_LT(found.error, rounding) << options.seed << ", " << count;
        EXPECT_GT(found.opacity, 0.4f);
      }
    }
  }
}

// A mean of two would have the colour of a third.
TEST(Categories, OpaqueLeavesHaveTheirOwnColours)
{
  const auto cells = categorise(makeRandomTree({ 12, { 2, 2, 2 }, 4, 0.6, 0., false }), 5);
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  std::vector<TransferFunction::Entry> opaque = entries(5, 1.f);
  for (TransferFunction::Entry& entry : opaque)
  {
    entry.extinction = TransferFunction::opaqueExtinction;
  }
  for (const Camera& camera : cameras())
  {
    forEachKernel({}, [&](const std::string& kernel, const VolumeSettings& settings) {
      Image image(width, height);
      renderVolume(*field, TransferFunction::ofCategories(opaque), camera, {}, settings, image);
      for (std::size_t i = 0; i < image.rgba.size(); i += 4)
      {
        EXPECT_TRUE(image.rgba[i + 3] == 0.f ||
          std::any_of(opaque.begin(), opaque.end(),
            [&](const auto& e) {
              return image.rgba[i] == e.r && image.rgba[i + 1] == e.g && image.rgba[i + 2] == e.b &&
                image.rgba[i + 3] == 1.f;
            }))
          << kernel << ", pixel " << i / 4;
      }
    });
  }
}

TEST(Categories, OneCell)
{
  const std::vector<LeafCell> cells{ { { { 0, 0, 0 }, 0 }, 2.f } };
  const Camera camera(multiply(perspective(40., 0.1, 20.), lookAt({ 2., 1.5, 1.7 }, { 0.51, 0.49, 0.52 })),
    identityMatrix, width, height);
  const Comparison found = compare(unitRoots({ 1, 1, 1 }), cells, entries(4, 3.f), camera);
  EXPECT_LT(found.error, rounding);
  EXPECT_GT(found.opacity, 0.1f);
}

TEST(Categories, NineteenLevelsApart)
{
  constexpr int depth = 19;
  const auto cells = categorise(cornerTree(depth), 6);
  const double cell = std::ldexp(1., -depth);
  const Vec3 middle{ 1. - 0.5 * cell, 1. - 0.5 * cell, 1. - 0.5 * cell };
  const auto away = [&](double distance) {
    const Vec3 back = unit({ 0.8, 0.5, 0.4 });
    return Vec3{ middle[0] - distance * back[0], middle[1] - distance * back[1],
      middle[2] - distance * back[2] };
  };
  for (const Camera& camera : cameras())
  {
    EXPECT_LT(compare(unitRoots({ 2, 2, 2 }), cells, entries(6, 2.f), camera).error, rounding);
  }
  // The deepest cells fill the picture: near by, and through a narrow angle, which single precision cannot tell.
  for (const Matrix4& clip :
    { multiply(perspective(40., 0.01 * cell, 8. * cell), lookAt(away(2. * cell), middle)),
      multiply(perspective(std::atan(0.2 * cell) * 360. / std::numbers::pi, 3., 3. + 8. * cell),
        lookAt(away(3. + 2. * cell), middle)) })
  {
    const Camera camera(clip, identityMatrix, width, height);
    const Comparison found =
      compare(unitRoots({ 2, 2, 2 }), cells, entries(6, static_cast<float>(1. / cell)), camera);
    EXPECT_LT(found.error, 1e-3);
    EXPECT_GT(found.opacity, 0.4f);
  }
}

TEST(Categories, SettingsOfTheReconstructionChangeNoBit)
{
  const auto cells = categorise(makeRandomTree({ 13, { 2, 2, 2 }, 5, 0.5, 0.1, false }), 9);
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const TransferFunction transferFunction = TransferFunction::ofCategories(entries(9, 3.f));
  for (const Camera& camera : cameras())
  {
    Volume volume(field, transferFunction);
    Image image(width, height);
    const VolumeStatistics skipped = volume.render(camera, {}, image);
    VolumeSettings all;
    all.skipEmpty = false;
    VolumeSettings detail;
    detail.levelOfDetailPixels = 50.;
    VolumeSettings samples;
    samples.samplesPerCell = 64.;
    for (const VolumeSettings& settings : { all, detail, samples })
    {
      Image again(width, height);
      const VolumeStatistics statistics = volume.render(camera, settings, again);
      EXPECT_EQ(again.rgba, image.rgba);
      EXPECT_GE(statistics.samples, skipped.samples);
      EXPECT_EQ(statistics.blocks + statistics.kept, 0u);
    }
    EXPECT_EQ(volume.keptBytes(), 0u);
    // Nothing is sampled, so nothing is missed.
    ErrorEstimator estimator(volume, camera, {}, image);
    EXPECT_EQ(estimator.error(), 0.);
    EXPECT_EQ(estimator.findSamplesPerCell(1e-3, ErrorTarget::least, ErrorTarget::most), ErrorTarget::least);
  }
}

TEST(Categories, SurfacesCutTheLeaves)
{
  const auto cells = categorise(makeRandomTree({ 12, { 2, 2, 2 }, 4, 0.6, 0., false }), 5);
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const TransferFunction transferFunction = TransferFunction::ofCategories(entries(5, 2.f));
  for (const Camera& camera : cameras())
  {
    PixelHits hits;
    for (int i = 0; i < width * height; ++i)
    {
      const Ray ray = camera.ray(i % width, i / width);
      double toMiddle = 0.;
      for (int a = 0; a < 3; ++a)
      {
        toMiddle += (1. - ray.origin[a]) * ray.direction[a];
      }
      for (const double beyond : { -0.3, 0.1 })
      {
        hits.add(toMiddle + beyond, { 0.2f, 0.5f, 1.f, 0.3f });
      }
      hits.endPixel();
    }
    const RayStops surfaces = hits.stops();
    Image expected(width, height);
    renderVolumeReference(*field, transferFunction, camera, surfaces, {}, expected);
    forEachKernel({}, [&](const std::string& kernel, const VolumeSettings& settings) {
      Image image(width, height);
      renderVolume(*field, transferFunction, camera, surfaces, settings, image);
      for (std::size_t i = 0; i < image.rgba.size(); ++i)
      {
        ASSERT_NEAR(image.rgba[i], expected.rgba[i], rounding) << kernel;
      }
    });
  }
}

TEST(Categories, AsManyAsFloatsCount)
{
  std::vector<TransferFunction::Entry> many(TransferFunction::mostCategories, { 0.f, 0.f, 0.f, 0.f });
  many[many.size() - 2] = { 1.f, 0.f, 0.f, 1.f };
  const TransferFunction transferFunction = TransferFunction::ofCategories(many);
  const auto last = static_cast<float>(many.size() - 1);
  EXPECT_EQ(transferFunction.at(last - 1.f).r, 1.f);
  EXPECT_EQ(transferFunction.at(last).r, 0.f);
  EXPECT_TRUE(transferFunction.isVisible({ last - 1.f, last - 1.f }));
  EXPECT_FALSE(transferFunction.isVisible({ 0.f, last - 2.f }));
  EXPECT_FALSE(transferFunction.isVisible({ last, last }));
  many.push_back({});
  EXPECT_THROW(TransferFunction::ofCategories(many), Error);
  EXPECT_THROW(TransferFunction::ofCategories({}), Error);
}

TEST(Categories, ValuesThatAreNoCategoryAreAnError)
{
  const Camera camera = cameras().front();
  Image image(width, height);
  for (const float value : { -1.f, 4.f })
  {
    const auto field = makeField(unitRoots({ 1, 1, 1 }), { { { { 0, 0, 0 }, 0 }, value } });
    EXPECT_THROW(
      renderVolume(*field, TransferFunction::ofCategories(entries(4, 1.f)), camera, {}, {}, image), Error);
  }
}

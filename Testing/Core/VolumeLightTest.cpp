// Light and gradient opacity of volumes, on every instruction set and in both precisions: against the scalar reference,
// and against what is exact where gradients are.
#include "Error.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/CornerFunction.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Support/VolumeViews.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;
/// What pictures may differ by in a channel: at many samples everywhere, at the default ones in the mean.
constexpr float tolerance = 2e-3f;

/// Two roots along each axis, and a field in [-1, 1].
std::shared_ptr<const Field> fieldOf(
  const RandomTree& options, const std::function<double(const std::array<double, 3>&)>& f)
{
  std::vector<LeafCell> cells = makeRandomTree(options);
  setValues(cells, f);
  return makeField(unitRoots(options.roots), cells);
}

/// Balanced, cells follow the waves; unbalanced some are as wide as a quarter of one.
std::shared_ptr<const Field> waves(bool balanced = true, double missing = 0.)
{
  return fieldOf({ 31, { 2, 2, 2 }, 5, 0.7, missing, balanced },
    [](const auto& p) { return std::sin(2. * p[0] + p[1]) * std::cos(1.5 * p[2]); });
}

/// Of no bends that samples could miss.
TransferFunction colors()
{
  return TransferFunction(-1., 1., { { 0.9f, 0.2f, 0.1f, 0.f }, { 0.2f, 0.5f, 0.9f, 2.f } });
}

struct LitView
{
  const char* name;
  Matrix4 clipFromView;
  Matrix4 viewFromData;
};

std::vector<LitView> litViews()
{
  const Vec3 middle{ 1., 1., 1. };
  return { { "perspective", perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle) },
    { "inside", perspective(90., 1e-3, 20.), lookAt({ 1.1, 0.8, 1.3 }, { 0., 0.1, 0.2 }) },
    { "narrow", perspective(0.3, 900., 1100.), lookAt({ 600., 500., 620. }, middle) },
    { "parallel", parallel(1.9, 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle) } };
}

Light directional(const Vec3& direction, const std::array<float, 3>& color)
{
  Light light;
  light.direction = normalized(direction);
  light.color = light.specularColor = color;
  return light;
}

Light positional(const Vec3& position)
{
  Light light;
  light.positional = true;
  light.position = position;
  return light;
}

Light spot()
{
  Light light = positional({ 1., 1.5, -1. });
  light.direction = normalized({ -0.3, -0.4, -1. });
  light.coneAngle = 25.;
  light.exponent = 3.;
  light.attenuation = { 0.3, 0.1, 0.05 };
  light.color = { 1.f, 0.6f, 0.9f };
  light.specularColor = { 0.4f, 1.f, 1.f };
  return light;
}

std::vector<std::pair<const char*, VolumeShading>> shadings()
{
  VolumeShading base;
  base.ambient = 0.2f;
  base.diffuse = 0.6f;
  base.specular = 0.4f;
  VolumeShading headlight = base;
  headlight.lights = { positional({}) };
  VolumeShading scene = base;
  scene.ambientLight = { 0.05f, 0.f, 0.1f };
  scene.lights = { directional({ 0.4, -1., -0.5 }, { 0.9f, 0.8f, 0.7f }),
    directional({ -1., -0.2, 0.3 }, { 0.2f, 0.1f, 0.4f }) };
  scene.specularPower = 25.f;
  VolumeShading oneSided = scene;
  oneSided.twoSided = false;
  oneSided.specularPower = 12.5f;
  VolumeShading spots = base;
  spots.lights = { spot(), positional({ -2., 1., 0.5 }) };
  VolumeShading dark = base;
  return { { "headlight", headlight }, { "scene lights", scene }, { "one side", oneSided },
    { "positional lights", spots }, { "no light", dark } };
}

GradientOpacity steepParts()
{
  return { 4., { 0.f, 0.1f, 0.8f, 1.f, 0.6f } };
}

/// Pictures of every kernel are those of the reference, and have the same bits on all instruction sets.
void expectReference(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, const VolumeSettings& settings, const std::string& what)
{
  VolumeSettings many = settings;
  many.samplesPerCell = 64.;
  Image expected(width, height);
  renderVolumeReference(field, transferFunction, camera, stops, many, expected);
  VolumeSettings plain = settings;
  plain.shading.reset();
  plain.gradientOpacity.reset();
  Image unlit(width, height);
  renderVolume(field, transferFunction, camera, stops, plain, unlit);
  EXPECT_GT(largestDifference(unlit, expected), 0.05f) << what;
  std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
  inFloatsAndDoubles(many, [&](const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(field, transferFunction, camera, stops, ofKernel, image);
    EXPECT_LT(largestDifference(image, expected), tolerance) << what;
  });
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(field, transferFunction, camera, stops, ofKernel, image);
    EXPECT_LT(meanDifference(image, expected), tolerance) << what << " on " << kernel;
    Image& first = firsts[ofKernel.doubles];
    first = first.width == 0 ? image : first;
    EXPECT_EQ(image.rgba, first.rgba) << what << " on " << kernel;
  });
}

} // namespace

TEST(VolumeLight, EveryKindEqualsTheReferenceOnEveryTarget)
{
  const auto field = waves();
  for (const LitView& view : litViews())
  {
    const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
    for (auto& [name, shading] : shadings())
    {
      VolumeSettings settings;
      settings.shading = shading;
      settings.shading->lightsFromData = view.viewFromData;
      expectReference(*field, colors(), camera, {}, settings, std::string(view.name) + ", " + name);
    }
  }
}

// As in VTK: what is not mirrored towards the eye at all has no highlight.
TEST(VolumeLight, NoPowerIsTheLimitOfSmallOnes)
{
  const auto field = waves();
  for (const LitView& view : litViews())
  {
    const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
    VolumeSettings settings;
    settings.shading = shadings()[0].second;
    settings.shading->lightsFromData = view.viewFromData;
    settings.shading->specularPower = 1e-5f;
    Image limit(width, height);
    renderVolume(*field, colors(), camera, {}, settings, limit);
    settings.shading->specularPower = 0.f;
    Image none(width, height);
    renderVolume(*field, colors(), camera, {}, settings, none);
    EXPECT_LT(largestDifference(none, limit), 1e-3f) << view.name;
  }
}

TEST(VolumeLight, GradientOpacityEqualsTheReferenceOnEveryTarget)
{
  const auto field = waves();
  for (const LitView& view : litViews())
  {
    const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
    VolumeSettings settings;
    settings.gradientOpacity = steepParts();
    expectReference(*field, colors(), camera, {}, settings, view.name);
    settings.shading = shadings()[1].second;
    settings.shading->lightsFromData = view.viewFromData;
    expectReference(*field, colors(), camera, {}, settings, std::string(view.name) + ", lit");
  }
}

// Gradients of any length from some on have one opacity: where all of a leaf are that long, nothing is read of them.
TEST(VolumeLight, LongGradientsNeverChangeABit)
{
  const auto field = waves();
  const LitView view = litViews()[0];
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  for (const auto& entries : { std::vector{ 0.f, 0.7f, 0.7f, 0.7f, 0.7f }, { 0.2f, 0.9f, 0.3f }, { 0.f, 0.f, 1.f } })
  {
    VolumeSettings settings;
    settings.gradientOpacity = GradientOpacity{ 1.5, entries };
    VolumeSettings reading = settings;
    reading.skipEmpty = false;
    std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      reading.doubles = ofKernel.doubles;
      Image skipped(width, height);
      Image read(width, height);
      renderVolume(*field, colors(), camera, {}, ofKernel, skipped);
      renderVolume(*field, colors(), camera, {}, reading, read);
      EXPECT_EQ(skipped.rgba, read.rgba) << kernel << ", " << entries.size();
      Image& first = firsts[ofKernel.doubles];
      first = first.width == 0 ? read : first;
      EXPECT_EQ(read.rgba, first.rgba) << kernel << ", " << entries.size();
    });
  }
}

TEST(VolumeLight, IntegralsAreLitToo)
{
  const auto field = waves();
  const LitView view = litViews()[0];
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  // Jumps and peaks, which points miss.
  const TransferFunction peaks = TransferFunction::ofNodes({ { -0.5, {}, {} },
    { 0.2, { 0.1f, 0.9f, 0.3f, 0.f }, { 0.9f, 0.3f, 0.1f, 3.f } },
    { 0.4, { 0.9f, 0.3f, 0.1f, 3.f }, { 0.1f, 0.3f, 0.9f, 0.2f } }, { 0.9, { 0.2f, 0.9f, 0.2f, 4.f }, {} } });
  VolumeSettings settings;
  settings.shading = shadings()[1].second;
  settings.shading->lightsFromData = view.viewFromData;
  settings.gradientOpacity = steepParts();
  // Of 64 samples a cell the reference itself errs at the jumps.
  VolumeSettings many = settings;
  many.samplesPerCell = 1024.;
  Image expected(width, height);
  renderVolumeReference(*field, peaks, camera, {}, many, expected);
  settings.samplesPerCell = 32.;
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(*field, peaks, camera, {}, ofKernel, image);
    EXPECT_LT(largestDifference(image, expected), tolerance) << kernel;
  });
}

TEST(VolumeLight, CutsHitsAndMissingCellsEqualTheReferenceOnEveryTarget)
{
  const auto field = waves(false, 0.1);
  for (const LitView& view : litViews())
  {
    const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
    PixelHits hits;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0.f, 1.f);
    for (int y = 0; y < height; ++y)
    {
      for (int x = 0; x < width; ++x)
      {
        const Ray ray = camera.ray(x, y);
        const double middle = (1. - ray.origin[0]) * ray.direction[0] +
          (1. - ray.origin[1]) * ray.direction[1] + (1. - ray.origin[2]) * ray.direction[2];
        hits.add(middle + uniform(random) - 0.5, { uniform(random), uniform(random), 0.5f, 0.4f });
        hits.endPixel();
      }
    }
    RayStops stops = hits.stops(nullptr, nullptr);
    stops.cut.halfSpaces = { { { 1., 0.5, 0.2 }, 0.9 } };
    stops.cut.cropping = CroppingRegions{ { 0.3, 1.4, 0.5, 1.6, 0.2, 1.7 }, 0x5ca3c96 };
    VolumeSettings settings;
    settings.shading = shadings()[1].second;
    settings.shading->lightsFromData = view.viewFromData;
    settings.gradientOpacity = steepParts();
    expectReference(*field, colors(), camera, stops, settings, view.name);
  }
}

namespace
{

constexpr Vec3 slope{ 0.2, -0.1, 0.3 };

double linear(const std::array<double, 3>& p)
{
  return slope[0] * (p[0] - 1.) + slope[1] * (p[1] - 1.) + slope[2] * (p[2] - 1.);
}

/// Lit by one light from either side or from one, of a field with the slope.
void expectOneNormal(const Field& field, const LitView& view, const char* what)
{
  const TransferFunction inside = TransferFunction::ofNodes(
    { { -0.35, {}, { 1.f, 0.5f, 0.25f, 3.f } }, { 0.35, { 1.f, 0.5f, 0.25f, 3.f }, {} } });
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  // Of the inside alone: where the domain ends, the field of cells is flat.
  RayStops stops;
  stops.cut.addBox({ { 0.5, 0.5, 0.5 }, { 1.5, 1.5, 1.5 } });
  VolumeSettings settings;
  VolumeShading& shading = settings.shading.emplace();
  shading.ambient = 0.1f;
  shading.diffuse = 0.5f;
  shading.specular = 0.f;
  shading.lights = { directional({ 0.3, 0.2, 1. }, { 1.f, 1.f, 1.f }) };
  // Turned, mirrored and stretched against the data.
  shading.lightsFromData = { 0., -2., 0., 0.3, 1., 0., 0., -1., 0., 0., -0.5, 2., 0., 0., 0., 1. };
  const Vec3 normal = normalized({ -slope[1] / 2., slope[0], -slope[2] / 0.5 });
  const double cosine = dot(normal, shading.lights[0].direction);
  for (const bool twoSided : { true, false })
  {
    shading.twoSided = twoSided;
    const auto lit = static_cast<float>(0.1 + 0.5 * (twoSided ? std::abs(cosine) : std::max(cosine, 0.)));
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      Image image(width, height);
      renderVolume(field, inside, camera, stops, ofKernel, image);
      int drawn = 0;
      for (std::size_t i = 0; i < image.rgba.size(); i += 4)
      {
        const float opacity = image.rgba[i + 3];
        drawn += opacity > 0.1f;
        ASSERT_NEAR(image.rgba[i], lit * opacity, 1e-3f) << what << ", " << view.name << " on " << kernel;
        ASSERT_NEAR(image.rgba[i + 2], 0.25f * lit * opacity, 1e-3f)
          << what << ", " << view.name << " on " << kernel;
      }
      EXPECT_GT(drawn, 20) << what << ", " << view.name;
    });
  }
}

} // namespace

TEST(VolumeLight, LinearFieldsHaveOneNormalWhateverTheLevels)
{
  const RandomTree options{ 8, { 2, 2, 2 }, 5, 0.6, 0., false };
  const auto ofCells = fieldOf(options, linear);
  const auto ofCorners = CornerFunction(makeRandomTree(options), linear).field(unitRoots(options.roots));
  const RandomTree single{ 1, { 1, 1, 1 }, 0, 0., 0., false };
  const auto ofOneLeaf = CornerFunction(makeRandomTree(single), linear).field(unitRoots(single.roots));
  for (const LitView& view : litViews())
  {
    expectOneNormal(*ofCells, view, "cells");
    expectOneNormal(*ofCorners, view, "corners");
    if (std::string(view.name) != "inside")
    {
      expectOneNormal(*ofOneLeaf, view, "one leaf");
    }
  }
}

TEST(VolumeLight, GradientOpacityOfLinearFieldsScalesExtinction)
{
  const auto field = fieldOf({ 8, { 2, 2, 2 }, 5, 0.6, 0., false },
    [&](const auto& p) { return 0.4 * (p[0] - 1.) + 0.3 * (p[1] - 1.); }); // of length 0.5
  const LitView view = litViews()[0];
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  RayStops stops;
  stops.cut.addBox({ { 0.5, 0.5, 0.5 }, { 1.5, 1.5, 1.5 } });
  const auto of = [](float extinction) {
    return TransferFunction(-1., 1., { { 1.f, 0.f, 0.f, extinction }, { 0.f, 1.f, 0.f, extinction } });
  };
  for (const auto& [longest, part] : { std::pair(1., 0.6f), std::pair(0.25, 0.9f) })
  {
    VolumeSettings settings;
    Image expected(width, height);
    renderVolume(*field, of(2.f * part), camera, stops, settings, expected);
    settings.gradientOpacity = GradientOpacity{ longest, { 0.3f, 0.9f } };
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      Image image(width, height);
      renderVolume(*field, of(2.f), camera, stops, ofKernel, image);
      EXPECT_LT(largestDifference(image, expected), 1e-3f) << longest << " on " << kernel;
    });
  }
}

TEST(VolumeLight, FlatFieldsHaveTheAmbientTermAlone)
{
  for (const int levels : { 0, 3 })
  {
    const auto field = fieldOf(
      { 3, { levels == 0 ? 1 : 2, levels == 0 ? 1 : 2, levels == 0 ? 1 : 2 }, levels, 0.6, 0., false },
      [](const auto& /*p*/) { return 0.25; });
    const LitView view = litViews()[0];
    const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
    VolumeSettings settings;
    settings.shading = shadings()[0].second;
    settings.shading->lightsFromData = view.viewFromData;
    const TransferFunction flat(0., 1., { { 0.5f, 1.f, 0.f, 1.f }, { 0.5f, 1.f, 0.f, 1.f } });
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      Image image(width, height);
      renderVolume(*field, flat, camera, {}, ofKernel, image);
      float most = 0.f;
      for (std::size_t i = 0; i < image.rgba.size(); i += 4)
      {
        most = std::max(most, image.rgba[i + 3]);
        ASSERT_NEAR(image.rgba[i], 0.2f * 0.5f * image.rgba[i + 3], 1e-5f) << kernel;
        ASSERT_NEAR(image.rgba[i + 1], 0.2f * image.rgba[i + 3], 1e-5f) << kernel;
      }
      EXPECT_GT(most, 0.5f) << kernel;
    });
  }
}

TEST(VolumeLight, HugeAndTinyFieldsAreLitAlike)
{
  const RandomTree options{ 31, { 2, 2, 2 }, 4, 0.7, 0., false };
  const auto wave = [](const auto& p) { return std::sin(3. * p[0] + p[1]) * std::cos(2. * p[2]); };
  const LitView view = litViews()[0];
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  Image expected(width, height);
  for (const double size : { 1., 1e-30, 1e37 })
  {
    const auto field = fieldOf(options, [&](const auto& p) { return size * wave(p); });
    const TransferFunction ofSize(-size, size, { { 0.9f, 0.2f, 0.1f, 0.f }, { 0.2f, 0.5f, 0.9f, 2.f } });
    VolumeSettings settings;
    settings.shading = shadings()[3].second;
    settings.shading->lightsFromData = view.viewFromData;
    settings.gradientOpacity = steepParts();
    settings.gradientOpacity->longest *= size;
    Image image(width, height);
    renderVolume(*field, ofSize, camera, {}, settings, size == 1. ? expected : image);
    if (size != 1.)
    {
      EXPECT_LT(largestDifference(image, expected), tolerance) << size;
    }
  }
}

TEST(VolumeLight, MemoryAndLevelsOfDetail)
{
  const auto field = waves();
  const LitView view = litViews()[0];
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  VolumeSettings settings;
  settings.shading = shadings()[0].second;
  settings.shading->lightsFromData = view.viewFromData;
  Image kept(width, height);
  Image again(width, height);
  Image unkept(width, height);
  Volume volume = volumeOf(*field, colors());
  const VolumeStatistics first = volume.render(camera, settings, kept);
  const VolumeStatistics second = volume.render(camera, settings, again);
  EXPECT_GT(first.gradients, 0u);
  EXPECT_EQ(second.gradients, 0u);
  EXPECT_EQ(second.blocks, 0u);
  renderVolume(*field, colors(), camera, {}, settings, unkept);
  volumeOf(*field, colors(), 0).render(camera, settings, unkept);
  EXPECT_EQ(kept.rgba, again.rgba);
  EXPECT_EQ(kept.rgba, unkept.rgba);
  // Plain frames keep no gradients, and have their own bits.
  VolumeSettings plain;
  Image before(width, height);
  Image after(width, height);
  const std::size_t litBytes = volume.keptBytes();
  renderVolume(*field, colors(), camera, {}, plain, before);
  const VolumeStatistics unlit = volume.render(camera, plain, after);
  EXPECT_EQ(unlit.gradients + unlit.keptGradients, 0u);
  EXPECT_LT(volume.keptBytes(), litBytes);
  EXPECT_EQ(before.rgba, after.rgba);
  // Where the values of a frame are kept its gradients are, too.
  Volume small = volumeOf(*field, colors(), volume.keptBytes());
  small.render(camera, settings, again);
  const VolumeStatistics inLittle = small.render(camera, settings, again);
  EXPECT_EQ(inLittle.gradients + inLittle.blocks, 0u);
  EXPECT_EQ(kept.rgba, again.rgba);
  // Drafts are drawn from means, with gradients of theirs.
  settings.levelOfDetailPixels = 20.;
  Image coarse(width, height);
  const VolumeStatistics draft = volume.render(camera, settings, coarse);
  EXPECT_LT(draft.samples, second.samples);
  float mean = 0.f;
  for (std::size_t i = 0; i < coarse.rgba.size(); ++i)
  {
    mean += std::abs(coarse.rgba[i] - kept.rgba[i]) / static_cast<float>(coarse.rgba.size());
  }
  EXPECT_LT(mean, 0.02f);
  EXPECT_GT(mean, 0.f);
}

TEST(VolumeLight, RefusesWhatIsNoLight)
{
  const auto field = waves();
  const LitView view = litViews()[0];
  const Camera camera(multiply(view.clipFromView, view.viewFromData), identityMatrix, width, height);
  Image image(width, height);
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refused = [&](const std::function<void(VolumeSettings&)>& spoil) {
    VolumeSettings settings;
    settings.shading = shadings()[1].second;
    settings.gradientOpacity = steepParts();
    spoil(settings);
    EXPECT_THROW(renderVolume(*field, colors(), camera, {}, settings, image), Error);
  };
  refused([](VolumeSettings& s) { s.shading->diffuse = nan; });
  refused([](VolumeSettings& s) { s.shading->specularPower = -1.f; });
  refused([](VolumeSettings& s) { s.shading->lights[0].position[1] = nan; });
  refused([](VolumeSettings& s) { s.shading->lightsFromData[5] = nan; });
  refused([](VolumeSettings& s) { s.gradientOpacity->longest = 0.; });
  refused([](VolumeSettings& s) { s.gradientOpacity->entries = { 1.f }; });
  refused([](VolumeSettings& s) { s.gradientOpacity->entries[1] = 1.5f; });
}

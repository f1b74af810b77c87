// Volumes coloured by another field than the one that makes them opaque, on every instruction set and in both precisions:
// against the scalar reference, and against a field that is both.
#include "Error.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Volume/Volume.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;
constexpr float tolerance = 2e-3f;
using Entry = TransferFunction::Entry;

/// Of one octree.
struct Fields
{
  std::shared_ptr<const Field> opacity; // -1 to 1
  std::shared_ptr<const Field> color;   // about 1800 to 4300
};

Fields fieldsOf(const RandomTree& tree)
{
  std::vector<LeafCell> cells = makeRandomTree(tree);
  setValues(cells, [](const auto& p) { return std::sin(2. * p[0] + p[1]) * std::cos(1.5 * p[2]); });
  const auto opacity = makeField(unitRoots(tree.roots), cells);
  setValues(cells, [](const auto& p) { return 1e3 * (p[1] + 0.3 * std::sin(5. * p[2])) + 2e3; });
  const auto color = makeField(unitRoots(tree.roots), cells);
  return { opacity,
    std::make_shared<Field>(opacity->sharedOctree(), LargeVector<float>(color->leafValues())) };
}

TransferFunction haze()
{
  return TransferFunction(-1., 1., { { 0.f, 0.f, 0.f, 0.f }, { 1.f, 1.f, 1.f, 2.f } });
}

/// Whose extinctions do not count.
TransferFunction colors()
{
  return TransferFunction(
    1800., 4300., { { 0.9f, 0.1f, 0.2f, 0.f }, { 0.2f, 0.8f, 0.1f, 5.f }, { 0.1f, 0.3f, 1.f, 0.f } });
}

Camera camera(double distance = 1.)
{
  return Camera(multiply(perspective(40., 0.01, 20.),
                  lookAt({ 1. + 3. * distance, 1. + 2. * distance, 1. + 2.5 * distance }, { 1., 1., 1. })),
    identityMatrix, width, height);
}

Image expectedPicture(const Fields& fields, const TransferFunction& opacity, const TransferFunction& color,
  const Camera& view, VolumeSettings settings, double samplesPerCell)
{
  settings.samplesPerCell = samplesPerCell;
  Image expected(width, height);
  const ReferenceColors by{ *fields.color, color };
  renderVolumeReference(*fields.opacity, opacity, view, {}, settings, expected, &by);
  return expected;
}

Image picture(const Fields& fields, const TransferFunction& opacity, const TransferFunction& color,
  const Camera& view, const VolumeSettings& settings)
{
  Volume volume(fields.opacity, opacity);
  volume.setColors(fields.color, color);
  Image image(width, height);
  volume.render(view, settings, image);
  return image;
}

Image withoutColors(const Fields& fields, const TransferFunction& opacity, const VolumeSettings& settings)
{
  Image image(width, height);
  Volume(fields.opacity, opacity).render(camera(), settings, image);
  return image;
}

VolumeSettings shaded()
{
  VolumeSettings settings;
  Light light;
  light.positional = true;
  settings.shading =
    VolumeShading{ .lights = { light }, .lightsFromData = lookAt({ 4., 3., 3.5 }, { 1., 1., 1. }) };
  return settings;
}

} // namespace

TEST(VolumeColors, EqualTheReferenceOnEveryTarget)
{
  VolumeSettings gradients;
  gradients.gradientOpacity = GradientOpacity{ 4., { 0.f, 0.1f, 0.8f, 1.f, 0.6f } };
  const RandomTree balanced{ 31, { 2, 2, 2 }, 5, 0.7, 0., true };
  const RandomTree irregular{ 7, { 2, 2, 2 }, 4, 0.6, 0.1, false };
  for (const auto& [tree, distance] :
    { std::pair(balanced, 1.), std::pair(balanced, 0.1), std::pair(irregular, 1.) })
  {
    const Fields fields = fieldsOf(tree);
    const Camera view = camera(distance);
    for (const VolumeSettings& settings : { VolumeSettings(), gradients, shaded() })
    {
      const Image expected = expectedPicture(fields, haze(), colors(), view, settings, 64.);
      EXPECT_GT(largestDifference(withoutColors(fields, haze(), settings), expected), 0.05f);
      VolumeSettings many = settings;
      many.samplesPerCell = 64.;
      inFloatsAndDoubles(many, [&](const VolumeSettings& ofKernel) {
        EXPECT_LT(largestDifference(picture(fields, haze(), colors(), view, ofKernel), expected), tolerance);
      });
      std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
      forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
        const Image image = picture(fields, haze(), colors(), view, ofKernel);
        EXPECT_LT(meanDifference(image, expected), tolerance) << kernel;
        Image& first = firsts[ofKernel.doubles];
        first = first.width == 0 ? image : first;
        EXPECT_EQ(image.rgba, first.rgba) << kernel;
      });
    }
  }
}

TEST(VolumeColors, OfTheFieldItselfAreItsOwn)
{
  const Fields fields = fieldsOf({ 31, { 2, 2, 2 }, 5, 0.7, 0., true });
  const TransferFunction both(-1., 1., { { 0.9f, 0.2f, 0.1f, 0.f }, { 0.2f, 0.5f, 0.9f, 2.f } });
  VolumeSettings settings;
  settings.samplesPerCell = 16.;
  const Image image = picture({ fields.opacity, fields.opacity }, haze(), both, camera(), settings);
  EXPECT_LT(largestDifference(image, withoutColors(fields, both, settings)), 1e-3f);
}

TEST(VolumeColors, FollowLogarithmsAndJumpsOfBothFunctions)
{
  const Fields fields = fieldsOf({ 31, { 2, 2, 2 }, 4, 0.7, 0., true });
  // Bends far closer than entries of a table, and jumps.
  std::vector<TransferFunction::Node> nodes;
  for (int i = 0; i <= 60; ++i)
  {
    const float part = static_cast<float>(i) / 60.f;
    const Entry entry{ part, 1.f - part, 0.5f + 0.5f * std::sin(20.f * part), 0.f };
    nodes.push_back({ 1800. + 1e-3 * std::pow(10., 0.1 * i), entry, entry });
  }
  const TransferFunction logarithmic = TransferFunction::ofNodes(std::move(nodes));
  const Entry lit{ 1.f, 1.f, 1.f, 3.f };
  const TransferFunction peaks =
    TransferFunction::ofNodes({ { 0.2, {}, lit }, { 0.21, lit, {} }, { 0.6, {}, { 1.f, 1.f, 1.f, 20.f } } });
  const Image expected = expectedPicture(fields, peaks, logarithmic, camera(), {}, 1024.);
  VolumeSettings settings;
  settings.samplesPerCell = 32.;
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    const Image image = picture(fields, peaks, logarithmic, camera(), ofKernel);
    EXPECT_LT(largestDifference(image, expected), 0.01f) << kernel;
    EXPECT_LT(meanDifference(image, expected), 1e-3) << kernel;
  });
}

TEST(VolumeColors, OneLeafHasOneColor)
{
  const auto opacity = makeField(unitRoots({ 1, 1, 1 }), { { { { 0, 0, 0 }, 0 }, 1.f } });
  const Fields fields{ opacity,
    std::make_shared<Field>(opacity->sharedOctree(), LargeVector<float>{ 4300.f }) };
  const Image image = picture(fields, haze(), colors(), camera(), {});
  const float* middle = image.rgba.data() + 4 * (height / 2 * width + width / 2);
  ASSERT_GT(middle[3], 0.5f);
  EXPECT_NEAR(middle[0], 0.1f * middle[3], 1e-5f);
  EXPECT_NEAR(middle[1], 0.3f * middle[3], 1e-5f);
  EXPECT_NEAR(middle[2], middle[3], 1e-5f);
}

TEST(VolumeColors, MemoryIsForFramesThatUseThem)
{
  const Fields fields = fieldsOf({ 31, { 2, 2, 2 }, 5, 0.7, 0., true });
  Volume volume(fields.opacity, haze());
  Image before(width, height);
  Image image(width, height);
  volume.render(camera(), {}, before);
  const std::size_t plainBytes = volume.keptBytes();
  volume.setColors(fields.color, colors());
  const VolumeStatistics first = volume.render(camera(), {}, image);
  EXPECT_GT(first.colors, 0u);
  EXPECT_EQ(first.gradients + first.keptGradients, 0u);
  EXPECT_GT(volume.keptBytes(), 3 * plainBytes / 2);
  // A new colour map changes no values.
  volume.setColors(
    fields.color, TransferFunction(0., 1e4, { { 1.f, 0.f, 0.f, 0.f }, { 0.f, 0.f, 1.f, 0.f } }));
  const VolumeStatistics second = volume.render(camera(), {}, image);
  EXPECT_EQ(second.colors + second.blocks, 0u);
  EXPECT_EQ(second.keptColors, first.colors + first.keptColors);
  // Blends of values have no use for them.
  VolumeSettings maximum;
  maximum.blend = VolumeBlend::Maximum;
  const VolumeStatistics blended = volume.render(camera(), maximum, image);
  EXPECT_EQ(blended.colors + blended.keptColors, 0u);
  volume.setColors(nullptr, colors());
  EXPECT_EQ(volume.render(camera(), {}, image).keptColors, 0u);
  EXPECT_EQ(image.rgba, before.rgba);
  EXPECT_LT(volume.keptBytes(), 3 * plainBytes / 2); // chunks are of threads
}

TEST(VolumeColors, LevelsOfDetailAreColored)
{
  const Fields fields = fieldsOf({ 31, { 2, 2, 2 }, 5, 0.7, 0., true });
  const Image expected = picture(fields, haze(), colors(), camera(), {});
  VolumeSettings coarse;
  coarse.levelOfDetailPixels = 20.;
  const double difference = meanDifference(picture(fields, haze(), colors(), camera(), coarse), expected);
  EXPECT_GT(difference, 0.);
  EXPECT_LT(difference, 0.03);
}

TEST(VolumeColors, OtherOctreesAndCategoriesAreErrors)
{
  const Fields fields = fieldsOf({ 31, { 2, 2, 2 }, 4, 0.7, 0., true });
  const Fields others = fieldsOf({ 31, { 2, 2, 2 }, 4, 0.7, 0., true });
  Volume volume(fields.opacity, haze());
  EXPECT_THROW(volume.setColors(others.color, colors()), Error);
  EXPECT_THROW(
    volume.setColors(fields.color, TransferFunction::ofCategories({ { 1.f, 0.f, 0.f, 1.f } })), Error);
  EXPECT_FALSE(volume.hasColors());
  volume.setColors(fields.color, colors());
  EXPECT_TRUE(volume.hasColors());
  EXPECT_THROW(volume.setTransferFunction(
                 TransferFunction::ofCategories(std::vector<Entry>(5000, { 1.f, 0.f, 0.f, 1.f }))),
    Error);
}

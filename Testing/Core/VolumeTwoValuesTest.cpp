// Volumes by transfer functions of two values, on every instruction set and in both precisions: against the scalar
// reference.
#include "Error.h"
#include "Field/TransferFunction2D.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Support/VolumeViews.h"
#include "Volume/Volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;
/// What pictures may differ by in a channel: at many samples everywhere, at the default ones in the mean.
constexpr float tolerance = 2e-3f;
using Entry = TransferFunction2D::Entry;
using FieldPtr = std::shared_ptr<const Field>;

/// One in [-1, 1], whose gradients are up to 2.3 long, and one in [1000, 5000] of the same octree.
std::pair<FieldPtr, FieldPtr> fields()
{
  const RandomTree tree{ 31, { 2, 2, 2 }, 5, 0.7, 0.05, true };
  std::vector<LeafCell> cells = makeRandomTree(tree);
  setValues(cells, [](const auto& p) { return std::sin(2. * p[0] + p[1]) * std::cos(1.5 * p[2]); });
  const FieldPtr first = makeField(unitRoots(tree.roots), cells);
  setValues(cells, [](const auto& p) { return 1e3 * (p[1] + 0.3 * std::sin(2. * p[2])) + 2e3; });
  const FieldPtr second = makeField(unitRoots(tree.roots), cells);
  return { first,
    std::make_shared<const Field>(first->sharedOctree(), LargeVector<float>(second->leafValues())) };
}

/// A hill in the middle of the second axis, nothing in the lower half of the first one and beside the hill.
TransferFunction2D hill(double min, double max)
{
  const TransferFunction2D::Axis first{ -1., 1., 41 };
  const TransferFunction2D::Axis second{ min, max, 33 };
  std::vector<Entry> entries;
  for (std::size_t row = 0; row < second.size; ++row)
  {
    for (std::size_t column = 0; column < first.size; ++column)
    {
      const double u = static_cast<double>(column) / 40.;
      const double v = static_cast<double>(row) / 32.;
      const double height = std::max(0., u - 0.5) * std::max(0., std::sin(4. * v - 0.5));
      entries.push_back({ static_cast<float>(u), static_cast<float>(v), static_cast<float>(1. - u * v),
        static_cast<float>(6. * height) });
    }
  }
  return TransferFunction2D(first, second, std::move(entries));
}
TransferFunction2D hillOfGradients()
{
  return hill(0.1, 2.1);
}
TransferFunction2D hillOfTwo()
{
  return hill(1500., 4500.);
}

VolumeSettings lit()
{
  VolumeSettings settings;
  settings.shading.emplace();
  Light light;
  light.direction = { 0.36, -0.48, -0.8 };
  settings.shading->lights = { light };
  return settings;
}

/// Every kernel's pictures are the reference's, and have the same bits on all instruction sets.
void expectReference(const FieldPtr& field, const FieldPtr& second, const TransferFunction2D& table,
  const Camera& camera, const VolumeSettings& settings, const std::string& what)
{
  Volume volume(field, smooth());
  volume.setTable(second, table);
  VolumeSettings many = settings;
  many.samplesPerCell = 64.;
  Image expected(width, height);
  const ReferenceTable reference{ table, second.get() };
  renderVolumeReference(*field, table.mostOverFirst(), camera, {}, many, expected, nullptr, &reference);
  EXPECT_GT(*std::max_element(expected.rgba.begin(), expected.rgba.end()), 0.2f) << what;
  inFloatsAndDoubles(many, [&](const VolumeSettings& ofKernel) {
    Image image(width, height);
    volume.render(camera, ofKernel, image);
    EXPECT_LT(largestDifference(image, expected), tolerance) << what;
  });
  std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    volume.render(camera, ofKernel, image);
    EXPECT_LT(meanDifference(image, expected), tolerance) << what << " on " << kernel;
    Image& first = firsts[ofKernel.doubles];
    first = first.width == 0 ? image : first;
    EXPECT_EQ(image.rgba, first.rgba) << what << " on " << kernel;
  });
}

/// With all that may be lit or not, and show cells or what is in between.
void expectReferences(const FieldPtr& field, const FieldPtr& second, const TransferFunction2D& table)
{
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    for (VolumeSettings settings : { VolumeSettings{}, lit() })
    {
      const std::string what = view.name + std::string(settings.shading ? ", lit" : "");
      settings.gradientOpacity = GradientOpacity{ 1., { 0.f, 0.5f } }; // is none of a table's
      expectReference(field, second, table, camera, settings, what);
      settings.nearest = true;
      expectReference(field, second, table, camera, settings, what + ", nearest");
    }
  }
}

} // namespace

TEST(VolumeTwoValues, TablesAreBilinearAndConstantBeyond)
{
  const TransferFunction2D table({ 0., 2., 3 }, { -1., 1., 2 },
    { { 0.f, 0.f, 0.f, 0.f }, { 1.f, 0.f, 0.f, 2.f }, { 0.f, 0.f, 0.f, 0.f }, //
      { 0.f, 1.f, 0.f, 4.f }, { 0.f, 0.f, 1.f, 8.f }, { 0.f, 0.f, 0.f, 0.f } });
  EXPECT_EQ(table.at(1., -1.), (Entry{ 1.f, 0.f, 0.f, 2.f }));
  EXPECT_EQ(table.at(0.5, 0.), (Entry{ 0.25f, 0.25f, 0.25f, 3.5f }));
  EXPECT_EQ(table.at(-3., 7.), (Entry{ 0.f, 1.f, 0.f, 4.f }));
  EXPECT_EQ(table.mostOverFirst().at(1.f).extinction, 8.f);
  EXPECT_EQ(table.mostOverFirst().at(2.f).extinction, 0.f);
  EXPECT_EQ(table.mostOverSecond().at(-1.f).extinction, 2.f);
  EXPECT_EQ(table.withExtinctionsTimes(3.).at(1., 1.).extinction, 24.f);
  // An axis without width has its first entry.
  EXPECT_EQ(TransferFunction2D({ 1., 1., 2 }, { 0., 1., 2 }, { {}, {}, { 0.f, 0.f, 0.f, 1.f }, {} })
              .at(1., 0.5)
              .extinction,
    0.5f);
}

TEST(VolumeTwoValues, ByGradientsEqualsTheReferenceOnEveryTarget)
{
  expectReferences(fields().first, nullptr, hillOfGradients());
}

TEST(VolumeTwoValues, OfTwoFieldsEqualsTheReferenceOnEveryTarget)
{
  const auto [first, second] = fields();
  expectReferences(first, second, hillOfTwo());
}

TEST(VolumeTwoValues, SlicesEqualTheReferenceOnEveryTarget)
{
  const auto [first, second] = fields();
  VolumeSettings settings;
  settings.blend = VolumeBlend::Slice;
  settings.slice = { { 1., 2., -0.5 }, 2.2 };
  settings.unitDistance = 0.7;
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  expectReference(first, nullptr, hillOfGradients(), camera, settings, "by gradients");
  expectReference(first, second, hillOfTwo(), camera, settings, "of two fields");
}

// A table that is the same for all second values is a transfer function.
TEST(VolumeTwoValues, WithoutTheSecondIsATransferFunction)
{
  const auto [first, second] = fields();
  std::vector<Entry> entries;
  for (int row = 0; row < 2; ++row)
  {
    entries.push_back({ 0.9f, 0.2f, 0.1f, 0.f });
    entries.push_back({ 0.2f, 0.5f, 0.9f, 2.f });
  }
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  Volume volume(first, TransferFunction(-1., 1., { entries[0], entries[1] }));
  Image expected(width, height);
  volume.render(camera, settings, expected);
  for (const FieldPtr& other : { FieldPtr(), second })
  {
    volume.setTable(other, TransferFunction2D({ -1., 1., 2 }, { 0., 4000., 2 }, entries));
    Image image(width, height);
    volume.render(camera, settings, image);
    EXPECT_LT(largestDifference(image, expected), 1e-3f);
  }
  // Which comes back, to the bit.
  volume.setTransferFunction(TransferFunction(-1., 1., { entries[0], entries[1] }));
  EXPECT_FALSE(volume.hasColors());
  Image image(width, height);
  volume.render(camera, settings, image);
  EXPECT_EQ(image.rgba, expected.rgba);
}

TEST(VolumeTwoValues, SkippingChangesNoBit)
{
  const auto [first, second] = fields();
  for (const FieldPtr& other : { FieldPtr(), second })
  {
    Volume volume(first, smooth());
    volume.setTable(other, other ? hillOfTwo() : hillOfGradients());
    forEachKernel({}, [&](const std::string& kernel, VolumeSettings settings) {
      Image with(width, height);
      Image without(width, height);
      const Camera camera(views()[0].clip, identityMatrix, width, height);
      const VolumeStatistics skipped = volume.render(camera, settings, with);
      settings.skipEmpty = false;
      const VolumeStatistics visited = volume.render(camera, settings, without);
      EXPECT_EQ(with.rgba, without.rgba) << kernel;
      EXPECT_LT(skipped.samples, 0.7 * visited.samples) << kernel;
    });
  }
}

// What one value shows nothing of is left out by it alone.
TEST(VolumeTwoValues, SkippingIsByBothValues)
{
  const auto [first, second] = fields();
  const auto samplesOf = [&](const FieldPtr& other, double min, double max) {
    std::vector<Entry> entries(4); // transparent, and above them opaque
    entries.resize(6, { 1.f, 1.f, 1.f, 1.f });
    Volume volume(first, smooth());
    volume.setTable(other, TransferFunction2D({ -1., 1., 2 }, { min, max, 3 }, entries));
    Image image(width, height);
    return volume.render(Camera(views()[0].clip, identityMatrix, width, height), {}, image).samples;
  };
  EXPECT_LT(samplesOf(nullptr, 1.4, 3.4), 0.8 * samplesOf(nullptr, -9., -7.));
  EXPECT_LT(samplesOf(second, 2000., 5000.), 0.6 * samplesOf(second, -9., -7.));
}

TEST(VolumeTwoValues, RefuseWhatDoesNotFit)
{
  const std::vector<Entry> four(4);
  EXPECT_THROW(TransferFunction2D({ 0., 1., 2 }, { 0., 1., 3 }, four), Error);
  EXPECT_THROW(TransferFunction2D({ 0., 1., 4 }, { 0., 1., 1 }, four), Error);
  EXPECT_THROW(TransferFunction2D({ 1., 0., 2 }, { 0., 1., 2 }, four), Error);
  EXPECT_THROW(
    TransferFunction2D({ 0., 1., 2 }, { 0., std::numeric_limits<double>::quiet_NaN(), 2 }, four), Error);
  for (const float bad : { -1.f, std::numeric_limits<float>::quiet_NaN() })
  {
    std::vector<Entry> entries = four;
    entries[2].extinction = bad;
    EXPECT_THROW(TransferFunction2D({ 0., 1., 2 }, { 0., 1., 2 }, entries), Error);
  }
  const auto [first, second] = fields();
  Volume volume(first, smooth());
  EXPECT_THROW(volume.setTable(fields().second, hillOfTwo()), Error); // of an octree like it
  EXPECT_FALSE(volume.hasColors());
  EXPECT_EQ(volume.transferFunction().entries(), smooth().entries());
}

// Maximum, minimum, average and sum of values along rays, on every instruction set and in both precisions, against the
// scalar reference.
#include "Error.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
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
#include <limits>
#include <string>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;
constexpr float tolerance = 2e-3f;

std::vector<LeafCell> waves(const RandomTree& options, double size = 1., double offset = 0.)
{
  std::vector<LeafCell> cells = makeRandomTree(options);
  setValues(
    cells, [&](const auto& p) { return offset + size * std::sin(3. * p[0] + p[1]) * std::cos(2. * p[2]); });
  return cells;
}

std::shared_ptr<const Field> waveField(double missing = 0.)
{
  const RandomTree options{ 31, { 2, 2, 2 }, 5, 0.7, missing, false };
  return makeField(unitRoots(options.roots), waves(options));
}

TransferFunction colors()
{
  return TransferFunction(-1., 1., { { 0.9f, 0.2f, 0.1f, 0.1f }, { 0.3f, 0.7f, 0.9f, 2.f } });
}

struct Blend
{
  const char* name;
  VolumeSettings settings;
};

std::vector<Blend> blends()
{
  std::vector<Blend> all;
  const auto add = [&](const char* name, VolumeBlend blend) {
    all.push_back({ name, {} });
    all.back().settings.blend = blend;
    all.back().settings.unitDistance = 1.3;
  };
  add("maximum", VolumeBlend::Maximum);
  add("minimum", VolumeBlend::Minimum);
  add("average", VolumeBlend::Average);
  add("average of a range", VolumeBlend::Average);
  all.back().settings.averageRange = { -0.4f, 0.5f };
  add("sum", VolumeBlend::Additive);
  all.back().settings.unitDistance = 3.;
  return all;
}

/// At many samples all but everywhere, extremes at any; at the default ones in the mean.
void expectAlike(const Field& field, const Camera& camera, const RayStops& stops,
  const VolumeSettings& settings, const Image& expected, const std::string& what)
{
  const bool isExtreme = settings.blend == VolumeBlend::Maximum || settings.blend == VolumeBlend::Minimum;
  inFloatsAndDoubles(settings, [&](VolumeSettings ofKernel) {
    Image image(width, height);
    renderVolume(field, colors(), camera, stops, ofKernel, image);
    EXPECT_LT(meanDifference(image, expected), tolerance) << what;
    ofKernel.samplesPerCell = isExtreme ? ofKernel.samplesPerCell : 64.;
    renderVolume(field, colors(), camera, stops, ofKernel, image);
    // Rays along edges aside. Of a part of the values the reference's own samples count or not.
    EXPECT_LT(
      partThatDiffers(image, expected, tolerance), std::isfinite(settings.averageRange.min) ? 0.006 : 0.003)
      << what;
  });
}

} // namespace

TEST(VolumeBlends, EqualTheReferenceOnEveryTarget)
{
  const auto field = waveField();
  for (const Blend& blend : blends())
  {
    for (const View& view : views())
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      VolumeSettings many = blend.settings;
      many.samplesPerCell = 64.;
      Image expected(width, height);
      renderVolumeReference(*field, colors(), camera, {}, many, expected);
      float most = 0.f;
      for (const float c : expected.rgba)
      {
        most = std::max(most, c);
      }
      EXPECT_GT(most, 0.2f) << blend.name << ", " << view.name;
      expectAlike(*field, camera, {}, blend.settings, expected, std::string(blend.name) + ", " + view.name);
      std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
      forEachKernel(blend.settings, [&](const std::string& kernel, const VolumeSettings& settings) {
        Image image(width, height);
        renderVolume(*field, colors(), camera, {}, settings, image);
        Image& first = firsts[settings.doubles];
        first = first.width == 0 ? image : first;
        EXPECT_EQ(image.rgba, first.rgba) << blend.name << ", " << view.name << " on " << kernel;
      });
    }
  }
}

TEST(VolumeBlends, CutsDepthsAndMissingCellsEqualTheReference)
{
  const auto field = waveField(0.1);
  std::vector<float> end(width * height, 1.f);
  for (std::size_t i = 0; i < end.size(); i += 3)
  {
    end[i] = i % 2 == 0 ? 0.f : 0.98f;
  }
  for (const Blend& blend : blends())
  {
    for (const View& view : views())
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      RayStops stops = RayStops::depths(nullptr, end.data());
      stops.cut.halfSpaces = { { { 1., 0.5, 0.2 }, 0.9 } };
      stops.cut.cropping = CroppingRegions{ { 0.3, 1.4, 0.5, 1.6, 0.2, 1.7 }, 0x5ca3c96 };
      VolumeSettings many = blend.settings;
      many.samplesPerCell = 64.;
      Image expected(width, height);
      Image uncut(width, height);
      renderVolumeReference(*field, colors(), camera, stops, many, expected);
      renderVolumeReference(*field, colors(), camera, {}, many, uncut);
      EXPECT_GT(largestDifference(expected, uncut), 0.05f) << blend.name << ", " << view.name;
      expectAlike(
        *field, camera, stops, blend.settings, expected, std::string(blend.name) + ", " + view.name);
    }
  }
}

TEST(VolumeBlends, SkippingNeverChangesABitOnAnyTarget)
{
  const auto field = waveField();
  // Half of the values are transparent, which sums can leave out.
  const TransferFunction half = TransferFunction::ofNodes(
    { { 0., {}, { 0.f, 1.f, 0.f, 0.f } }, { 1., { 1.f, 0.f, 0.f, 2.f }, { 1.f, 0.f, 0.f, 2.f } } });
  for (const Blend& blend : blends())
  {
    for (const View& view : views())
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      const bool skips =
        blend.settings.blend != VolumeBlend::Average || std::isfinite(blend.settings.averageRange.min);
      forEachKernel(blend.settings, [&](const std::string& kernel, VolumeSettings settings) {
        Image with(width, height);
        Image without(width, height);
        const auto skipped = renderVolume(*field, half, camera, {}, settings, with);
        settings.skipEmpty = false;
        const auto all = renderVolume(*field, half, camera, {}, settings, without);
        EXPECT_EQ(with.rgba, without.rgba) << blend.name << ", " << view.name << " on " << kernel;
        if (skips)
        {
          EXPECT_LT(skipped.samples, all.samples) << blend.name;
        }
      });
    }
  }
}

TEST(VolumeBlends, MaximaSkipWhatIsBelowWhatRaysHave)
{
  const auto field = waveField();
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  VolumeSettings settings;
  settings.blend = VolumeBlend::Maximum;
  Image image(width, height);
  const auto skipped = renderVolume(*field, colors(), camera, {}, settings, image);
  settings.skipEmpty = false;
  const auto all = renderVolume(*field, colors(), camera, {}, settings, image);
  EXPECT_LT(3 * skipped.samples, 2 * all.samples);
  EXPECT_LT(4 * skipped.intervals, 3 * all.intervals);
}

TEST(VolumeBlends, ExtremesAreExactWhereTheFieldTurns)
{
  // At one sample a cell as at many: places are solved for.
  const auto field = waveField();
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  for (const VolumeBlend blend : { VolumeBlend::Maximum, VolumeBlend::Minimum })
  {
    VolumeSettings settings;
    settings.blend = blend;
    settings.samplesPerCell = 0.25;
    Image image(width, height);
    Image expected(width, height);
    renderVolume(*field, colors(), camera, {}, settings, image);
    renderVolumeReference(*field, colors(), camera, {}, settings, expected);
    EXPECT_LT(largestDifference(image, expected), 1e-4f);
  }
}

TEST(VolumeBlends, OfConstantsAndSingleCells)
{
  for (const int levels : { 0, 2 })
  {
    const RandomTree options{ 3, { 1, 1, 1 }, levels, 0.6, 0., false };
    std::vector<LeafCell> cells = makeRandomTree(options);
    setValues(cells, [](const auto& /*p*/) { return 0.25; });
    const auto field = makeField(unitRoots(options.roots), cells);
    const TransferFunction function(0., 1., { { 1.f, 0.f, 0.f, 1.f }, { 0.f, 1.f, 0.f, 1.f } });
    const Camera camera(views()[0].clip, identityMatrix, width, height);
    for (const Blend& blend : blends())
    {
      forEachKernel(blend.settings, [&](const std::string& kernel, const VolumeSettings& settings) {
        Image image(width, height);
        renderVolume(*field, function, camera, {}, settings, image);
        float most = 0.f;
        for (std::size_t i = 3; i < image.rgba.size(); i += 4)
        {
          most = std::max(most, image.rgba[i]);
        }
        const bool isExtreme =
          settings.blend == VolumeBlend::Maximum || settings.blend == VolumeBlend::Minimum;
        const bool counts = std::isinf(settings.averageRange.min) || settings.averageRange.max >= 0.25f;
        const double opacity = isExtreme ? -std::expm1(-settings.unitDistance) : counts ? 1. : 0.;
        EXPECT_NEAR(most, opacity, 1e-6) << blend.name << " on " << kernel;
      });
    }
  }
}

TEST(VolumeBlends, HugeAndTinyFieldsAreAlike)
{
  const RandomTree options{ 31, { 2, 2, 2 }, 4, 0.7, 0., false };
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  for (const Blend& blend : blends())
  {
    if (std::isfinite(blend.settings.averageRange.min))
    {
      continue;
    }
    Image expected(width, height);
    for (const double size : { 1., 1e-30, 1e38 })
    {
      const auto field = makeField(unitRoots(options.roots), waves(options, size));
      const TransferFunction function(-size, size, { { 0.9f, 0.2f, 0.1f, 0.1f }, { 0.3f, 0.7f, 0.9f, 2.f } });
      Image image(width, height);
      renderVolume(*field, function, camera, {}, blend.settings, size == 1. ? expected : image);
      if (size != 1.)
      {
        EXPECT_LT(largestDifference(image, expected), 1e-3f) << blend.name << ", " << size;
      }
    }
  }
}

TEST(VolumeBlends, RefuseSurfacesAndRangesThatAreNone)
{
  const auto field = waveField();
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  PixelHits hits;
  for (int i = 0; i < width * height; ++i)
  {
    hits.endPixel();
  }
  Image image(width, height);
  VolumeSettings settings;
  EXPECT_NO_THROW(renderVolume(*field, colors(), camera, hits.stops(nullptr, nullptr), settings, image));
  settings.blend = VolumeBlend::Maximum;
  EXPECT_THROW(renderVolume(*field, colors(), camera, hits.stops(nullptr, nullptr), settings, image), Error);
  settings.blend = VolumeBlend::Average;
  settings.unitDistance = 0.;
  EXPECT_THROW(renderVolume(*field, colors(), camera, {}, settings, image), Error);
  settings.unitDistance = 1.;
  settings.averageRange.min = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(renderVolume(*field, colors(), camera, {}, settings, image), Error);
}

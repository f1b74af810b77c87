// Transfer functions of every kind on fields of every kind: more samples are never worse, and the picture is right.
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeCases.h"
#include "Support/VolumeReference.h"

#include "Error.h"
#include "Volume/Volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Entry = TransferFunction::Entry;

constexpr int width = 30;
constexpr int height = 25;

Entry entry(float color, float extinction)
{
  return { color, 1.f - color, 0.5f, extinction };
}

} // namespace

TEST(VolumeFunctions, MoreSamplesAreNeverWorse)
{
  const Camera camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })),
    identityMatrix, width, height);
  // Rays end where less light is left: what they do not see is no matter of samples.
  constexpr double ofEnds = opaqueTransmittance / 16.;
  for (const auto& [fieldName, field] : volumeFields())
  {
    for (const auto& [functionName, function] : volumeFunctions())
    {
      Image converged(width, height);
      renderVolumeConverged(*field, function, camera, {}, converged);
      Volume volume(field, function);
      double before = std::numeric_limits<double>::infinity();
      for (const double samples : { 1., 2., 4., 16., 64. })
      {
        Image image(width, height);
        VolumeSettings settings;
        settings.samplesPerCell = samples;
        volume.render(camera, settings, image);
        const double error = rmse(image, converged);
        const std::string what = fieldName + ", " + functionName + ", " + std::to_string(samples);
        EXPECT_LE(error, 1.1 * before + ofEnds) << what;
        EXPECT_LE(error, samples < 2. ? 1. : samples < 64. ? 4e-3 : 1e-3) << what;
        before = error;
      }
    }
  }
}

TEST(VolumeFunctions, MoreSamplesAreNeverWorseForPeaksOfFewFloats)
{
  const Camera camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })),
    identityMatrix, width, height);
  constexpr double least = opaqueTransmittance / 16.;
  for (const double halfWidth : { 1e-5, 1e-7 })
  {
    constexpr double middle = 0.37;
    const Entry nothing = entry(0.3f, 0.f);
    const Entry peak = entry(0.3f, static_cast<float>(0.3 / halfWidth));
    const TransferFunction function =
      TransferFunction::ofNodes({ { 0., nothing, nothing }, { middle - halfWidth, nothing, nothing },
        { middle, peak, peak }, { middle + halfWidth, nothing, nothing }, { 1., nothing, nothing } });
    for (const auto& [fieldName, field] : volumeFields())
    {
      Image converged(width, height);
      renderVolumeConverged(*field, function, camera, {}, converged);
      Volume volume(field, function);
      double before = std::numeric_limits<double>::infinity();
      for (const double samples : { 2., 4., 16., 64. })
      {
        Image image(width, height);
        volume.render(camera, { .samplesPerCell = samples }, image);
        const double error = rmse(image, converged);
        EXPECT_LE(error, 1.1 * before + least) << fieldName << ", " << halfWidth << ", " << samples;
        before = error;
      }
    }
  }
}

TEST(VolumeFunctions, WhatIsOutsideTheTableCountsOutside)
{
  // The field jumps from 0 to 1000 over a cell; there is something in 0 to 1 only: a thousandth of that cell.
  constexpr int level = 3;
  std::vector<LeafCell> cells;
  constexpr Coord count = Coord(1) << level;
  for (Coord i = 0; i < count * count * count; ++i)
  {
    cells.push_back({ { { i % count, i / count % count, i / (count * count) }, level },
      i % count < count / 2 ? 0.f : 1000.f });
  }
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  const Matrix4 view{ 0, 0, 1, -0.5, 0, 1, 0, -0.5, -1, 0, 0, -3, 0, 0, 0, 1 }; // along x
  const Camera camera(multiply(parallel(0.3, 0.1, 9.), view), identityMatrix, 3, 3);
  constexpr float extinction = 20.f;
  const Entry inside{ 1.f, 1.f, 1.f, extinction };
  const Entry nothing{ 1.f, 1.f, 1.f, 0.f };
  Volume volume(field, TransferFunction::ofNodes({ { 0.25, nothing, inside }, { 1., inside, nothing } }));
  Image image(3, 3);
  for (const double samples : { 1., 2., 64. })
  {
    VolumeSettings settings;
    settings.samplesPerCell = samples;
    volume.render(camera, settings, image);
    EXPECT_NEAR(image.rgba[4 * 4 + 3], -std::expm1(-extinction * 0.75e-3 / count), 1e-6) << samples;
  }
}

TEST(VolumeFunctions, RaysEndWithTheLightAskedFor)
{
  constexpr float extinction = 9.f;
  const Matrix4 view{ 0, 0, 1, -0.5, 0, 1, 0, -0.5, -1, 0, 0, -3, 0, 0, 0, 1 }; // along x
  const Camera camera(multiply(parallel(0.3, 0.1, 9.), view), identityMatrix, 3, 3);
  const auto field = makeField(unitRoots({ 1, 1, 1 }), makeRandomTree({ 7, { 1, 1, 1 }, 5, 0.9, 0., true }));
  const Entry even = entry(0.5f, extinction);
  const TransferFunction function = TransferFunction::ofNodes({ { -1., even, even }, { 1., even, even } });
  for (const double samples : { 2., 64. })
  {
    Volume volume(field, function);
    const auto transmittance = [&](float least) {
      Image image(3, 3);
      volume.render(camera, { .samplesPerCell = samples, .leastTransmittance = least }, image);
      return 1. - image.rgba[4 * 4 + 3];
    };
    EXPECT_NEAR(transmittance(0x1p-16f), std::exp(-extinction), 2e-7) << samples;
    EXPECT_GT(transmittance(0.1f), 0.01) << samples;
    EXPECT_LT(transmittance(0.1f), 0.1) << samples;
    EXPECT_THROW(transmittance(0.f), Error);
    EXPECT_THROW(transmittance(1.f), Error);
  }
}

TEST(VolumeFunctions, NodesAreChecked)
{
  const Entry e = entry(0.5f, 1.f);
  EXPECT_THROW(TransferFunction::ofNodes({}), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { 1., e, e }, { 1., e, e } }), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { 0., e, e }, { std::nan(""), e, e } }), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { -1e308, e, e }, { 1e308, e, e } }), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { 0., e, entry(0.5f, -1.f) } }), Error);
}

TEST(VolumeFunctions, NodesHoldFromTheirValueOn)
{
  const TransferFunction function = TransferFunction::ofNodes(
    { { 1., entry(0.f, 1.f), entry(0.5f, 0.f) }, { 2., entry(0.5f, 0.f), entry(1.f, 4.f) } });
  EXPECT_EQ(function.at(std::nextafter(1.f, 0.f)), entry(0.f, 1.f));
  EXPECT_EQ(function.at(1.f), entry(0.5f, 0.f));
  EXPECT_EQ(function.at(std::nextafter(2.f, 0.f)).extinction, 0.f);
  EXPECT_EQ(function.at(2.f), entry(1.f, 4.f));
  EXPECT_EQ(function.at(-1e30f), entry(0.f, 1.f));
  EXPECT_TRUE(function.isVisible({ 0.f, 0.5f }));
  EXPECT_FALSE(function.isVisible({ 1.f, std::nextafter(2.f, 0.f) }));
  EXPECT_TRUE(function.isVisible({ 1.5f, 2.f }));
}

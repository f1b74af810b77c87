// Stiff transfer functions: what is thinner than a step, steeper than a ramp, all but transparent or opaque at once.
// Each case records what it measured.
#include "Support/Cameras.h"
#include "Support/ExactRay.h"
#include "Support/Fields.h"
#include "Support/Kernels.h"
#include "Support/Measured.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Entry = TransferFunction::Entry;

constexpr int width = 9;
constexpr int height = 7;

/// The field is z in [0, 2], linear but for the outermost half cells, in cells of 2^-level.
std::shared_ptr<const Field> slope(int level)
{
  std::vector<LeafCell> cells;
  const Coord count = Coord(2) << level;
  for (Coord i = 0; i < count * count * count; ++i)
  {
    const Coord z = i / (count * count);
    cells.push_back({ { { i % count, i / count % count, z }, level },
      static_cast<float>(std::ldexp(static_cast<double>(z) + 0.5, -level)) });
  }
  return makeField(unitRoots({ 2, 2, 2 }), cells);
}

/// All rays run against z, down from 2 to 0.
Camera downwards()
{
  const Matrix4 view{ 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1, -5, 0, 0, 0, 1 };
  return Camera(multiply(parallel(0.6, 0.1, 20.), view), identityMatrix, width, height);
}

/// Calls f(image) with the picture of each kernel, and of the reference.
void forEachRenderer(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const std::function<void(const Image&)>& f)
{
  Image image(camera.width(), camera.height());
  forEachKernel({}, [&](const std::string& /*kernel*/, const VolumeSettings& settings) {
    renderVolume(field, transferFunction, camera, {}, settings, image);
    f(image);
  });
  renderVolumeReference(field, transferFunction, camera, {}, {}, image);
  f(image);
}

/// The largest relative error of opacity and colours over all renderers; `depth` is the optical depth along a ray,
/// and the colour is everywhere that of the table's first entry. Rays end when opaqueTransmittance is left.
double relativeError(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const std::function<double(const Ray&)>& depth)
{
  const Entry& entry = transferFunction.entries().front();
  double largest = 0.;
  forEachRenderer(field, transferFunction, camera, [&](const Image& image) {
    for (int i = 0; i < width * height; ++i)
    {
      const double alpha = -std::expm1(-depth(camera.ray(i % width, i / width)));
      const std::array<double, 4> expected{ alpha * entry.r, alpha * entry.g, alpha * entry.b, alpha };
      for (int c = 0; c < 4; ++c)
      {
        const double rest = alpha > 1. - opaqueTransmittance ? expected[c] * opaqueTransmittance : 0.;
        const double error = std::max(std::abs(image.rgba[4 * i + c] - expected[c]) - rest, 0.) / expected[c];
        largest = error <= largest ? largest : error; // NaN counts
      }
    }
  });
  return largest;
}

TransferFunction uniform(double extinction)
{
  return TransferFunction(
    -1., 1., std::vector<Entry>(2, { 0.5f, 0.25f, 1.f, static_cast<float>(extinction) }));
}

const float* middlePixel(const Image& image)
{
  return image.rgba.data() + 4 * (width * (height / 2) + width / 2);
}

double depthOf(const float* pixel)
{
  return -std::log1p(-pixel[3]);
}

} // namespace

TEST(StiffCases, ExtinctionFrom1em12To1e12PerCell)
{
  constexpr int level = 4;
  auto cells = makeRandomTree({ 2, { 1, 1, 1 }, level, 0.6, 0., false });
  setValues(cells, [](const auto&) { return 0.25; });
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  // All rays cross the faces z = 0 and z = 1.
  const Camera cameras[]{ Camera(
                            multiply(parallel(0.4, 0.1, 9.), lookAt({ 0.5, 0.5, 5. }, { 0.5, 0.5, 0.5 })),
                            identityMatrix, width, height),
    Camera(multiply(perspective(10., 0.1, 9.), lookAt({ 0.6, 0.55, 5. }, { 0.5, 0.5, 0.5 })), identityMatrix,
      width, height) };
  double largest = 0.;
  for (int exponent = -12; exponent <= 12; ++exponent)
  {
    const TransferFunction transferFunction = uniform(std::ldexp(std::pow(10., exponent), level));
    const double extinction = transferFunction.entries().front().extinction;
    for (const Camera& camera : cameras)
    {
      largest = std::max(largest, relativeError(*field, transferFunction, camera, [&](const Ray& ray) {
        return extinction / std::abs(ray.direction[2]);
      }));
    }
  }
  expectAtMost(largest, 4e-6, "of the opacity");
}

TEST(StiffCases, TenThousandThinCellsAddUp)
{
  // Of 1e-9 each: a transmittance in single precision would not see one of them.
  constexpr int count = 10000;
  std::vector<LeafCell> cells;
  for (int i = 0; i < count; ++i)
  {
    cells.push_back({ { { 0, 0, i }, 0 }, 0.f });
  }
  const auto field = makeField(unitRoots({ 1, 1, count }), cells);
  const Camera camera(multiply(parallel(0.3, 1., 2. * count), lookAt({ 0.5, 0.5, -100. }, { 0.5, 0.5, 0. })),
    identityMatrix, width, height);
  const TransferFunction transferFunction = uniform(1e-9);
  const double depth = count * static_cast<double>(transferFunction.entries().front().extinction);
  expectAtMost(relativeError(*field, transferFunction, camera, [&](const Ray&) { return depth; }), 1e-4,
    "of the opacity");
}

TEST(StiffCases, AnOpacityOfOneHidesWhatIsBehind)
{
  // The field rises against the rays: they meet the opaque upper half first.
  const auto field = slope(3);
  std::vector<Entry> entries(4096, { 0.f, 1.f, 0.f, 1.f });
  std::fill(entries.begin() + 2048, entries.end(),
    Entry{ 1.f, 0.f, 0.5f, TransferFunction::extinctionFromOpacity(1., 1.) });
  double largest = 0.;
  forEachRenderer(*field, TransferFunction(0., 2., entries), downwards(), [&](const Image& image) {
    for (int i = 0; i < width * height; ++i)
    {
      const float* p = image.rgba.data() + 4 * i;
      largest = std::max<double>(
        { largest, std::abs(p[0] - 1.f), std::abs(p[1]), std::abs(p[2] - 0.5f), std::abs(p[3] - 1.f) });
    }
  });
  expectAtMost(largest, 0., "of a channel");
}

namespace
{

constexpr int tableSize = 4096;
constexpr double spikeDepth = 0.7;

/// The largest error of a spike's optical depth, wherever it falls between samples. It rises and falls over `half`
/// entries.
double spikeError(const Field& field, int half, int firstPlace, int endPlace)
{
  double largest = 0.;
  for (int at = firstPlace; at < endPlace; at += 7)
  {
    std::vector<Entry> entries(tableSize, { 1.f, 0.5f, 0.25f, 0.f });
    for (int i = 1 - half; i < half; ++i)
    {
      const double part = static_cast<double>(half - std::abs(i)) / (half * half);
      entries[at + i].extinction = static_cast<float>(spikeDepth * part * (tableSize - 1) / 2.);
    }
    inFloatsAndDoubles({}, [&](const VolumeSettings& settings) {
      Image image(width, height);
      renderVolume(field, TransferFunction(0., 2., entries), downwards(), {}, settings, image);
      const float* p = middlePixel(image);
      largest = std::max(largest, std::abs(depthOf(p) - spikeDepth));
      EXPECT_NEAR(p[1], 0.5 * p[3], 1e-6);
      EXPECT_NEAR(p[2], 0.25 * p[3], 1e-6);
    });
  }
  return largest;
}

/// Half a step, in entries.
int entriesInHalfAStep(int level)
{
  return tableSize / 8 >> level;
}

} // namespace

TEST(StiffCases, ASpikeInAStepKeepsItsDepthDownToOneEntry)
{
  double largest = 0.;
  for (const int level : { 1, 3, 5 })
  {
    const auto field = slope(level);
    for (int half = entriesInHalfAStep(level) / 2; half >= 1; half /= 2)
    {
      largest = std::max(largest, spikeError(*field, half, 1200, 1200 + 4 * entriesInHalfAStep(level)));
    }
  }
  expectAtMost(largest / spikeDepth, 0.01, "of the spike's optical depth");
}

TEST(StiffCases, ASpikeInAStepKeepsItsDepthInEveryZoom)
{
  // The field does not change across the picture: it is one pixel of the whole one, until doubles are the same.
  const auto field = slope(3);
  std::vector<Entry> entries(tableSize, { 1.f, 0.5f, 0.25f, 0.f });
  entries[1234].extinction = static_cast<float>(spikeDepth * (tableSize - 1) / 2.);
  double largest = 0.;
  for (double zoom = 1.; zoom <= 1e12; zoom *= 1e3)
  {
    const Matrix4 view{ 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1, -5, 0, 0, 0, 1 };
    const Camera camera(multiply(parallel(0.6 / zoom, 0.1, 20.), view), identityMatrix, width, height);
    Image image(width, height);
    renderVolume(*field, TransferFunction(0., 2., entries), camera, {}, {}, image);
    largest = std::max(largest, std::abs(depthOf(middlePixel(image)) - spikeDepth));
  }
  expectAtMost(largest / spikeDepth, 0.01, "of the spike's optical depth");
}

TEST(StiffCases, WiderSpikesErrByNoMoreThanPointSamplesMay)
{
  double largest = 0.;
  for (const int level : { 1, 3, 5 })
  {
    const auto field = slope(level);
    for (int half = entriesInHalfAStep(level); half <= 512; half *= 2)
    {
      largest = std::max(largest, spikeError(*field, half, 1200, 1200 + 4 * entriesInHalfAStep(level)));
    }
  }
  expectAtMost(largest, 0.2, "of optical depth");
}

TEST(StiffCases, AStepFallsBetweenItsEntries)
{
  // Transparent below, dense above: the optical depth tells where the step is seen.
  constexpr int size = 4096;
  constexpr double extinction = 20.;
  const auto field = slope(3);
  double largest = 0.;
  for (int at = 3700; at < 3950; ++at)
  {
    std::vector<Entry> entries(size, { 1.f, 1.f, 1.f, 0.f });
    for (int i = at; i < size; ++i)
    {
      entries[i].extinction = static_cast<float>(extinction);
    }
    inFloatsAndDoubles({}, [&](const VolumeSettings& settings) {
      Image image(width, height);
      renderVolume(*field, TransferFunction(0., 2., entries), downwards(), {}, settings, image);
      const double entriesAbove = depthOf(middlePixel(image)) / extinction * (size - 1) / 2.;
      largest = std::max(largest, std::abs(entriesAbove - (size - at - 0.5)));
    });
  }
  expectAtMost(largest, 2., "of 4096 entries");
}

TEST(StiffCases, TwoEntriesAreALine)
{
  const auto cells = makeRandomTree({ 12, { 2, 2, 2 }, 4, 0.6, 0., false });
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const TransferFunction line(-1., 1., { { 1.f, 0.f, 0.5f, 0.f }, { 0.f, 1.f, 0.5f, 2.f } });
  const Camera camera = downwards();
  ExactRay exact({ 2, 2, 2 }, cells);
  VolumeSettings settings;
  settings.samplesPerCell = 16.;
  double largest = 0.;
  inFloatsAndDoubles(settings, [&](const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(*field, line, camera, {}, ofKernel, image);
    for (int i = 0; i < width * height; ++i)
    {
      const auto expected = exact.light(camera.ray(i % width, i / width), 0., 20., line);
      for (int c = 0; c < 4; ++c)
      {
        largest = std::max(largest, std::abs(image.rgba[4 * i + c] - expected[c]));
      }
    }
  });
  expectAtMost(largest, 5e-4, "of a channel");
}

TEST(StiffCases, AnOpaqueEntryLeavesTheLastItsOwn)
{
  // At the end of an interval nothing is left of its beginning.
  std::vector<LeafCell> cells{ { {}, 1.f } };
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  double largest = 0.;
  for (const std::size_t size : { 3, 100, 4096, 5000 })
  {
    std::vector<Entry> entries(size, { 0.5f, 0.25f, 1.f, 0.75f });
    entries[size - 2].extinction = static_cast<float>(TransferFunction::opaqueExtinction);
    const Camera camera(multiply(parallel(0.4, 0.1, 9.), lookAt({ 0.5, 0.5, 5. }, { 0.5, 0.5, 0.5 })),
      identityMatrix, width, height);
    largest = std::max(largest,
      relativeError(*field, TransferFunction(0., 1., entries), camera, [](const Ray&) { return 0.75; }));
  }
  expectAtMost(largest, 4e-6, "of the opacity");
}

TEST(StiffCases, AnIntervalOfNoWidthHasTheFirstColour)
{
  // Two entries at one value.
  const auto field = slope(3);
  const TransferFunction transferFunction(1., 1., { { 0.5f, 0.25f, 1.f, 0.75f }, { 0.f, 1.f, 0.f, 100.f } });
  expectAtMost(relativeError(*field, transferFunction, downwards(), [](const Ray&) { return 2. * 0.75; }),
    4e-6, "of the opacity");
}

TEST(StiffCases, SpikesAndOpaqueWallsFromCellToCell)
{
  // Values without order, a table of spikes of 1e-6 to 1e6 per cell: every cell is another wall.
  const auto cells = makeRandomTree({ 12, { 2, 2, 2 }, 3, 0.6, 0.1, false });
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  std::vector<Entry> entries(4096, { 0.f, 0.f, 0.f, 0.f });
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    const auto u = static_cast<float>(i) / 4095.f;
    const double exponent = 6. * std::sin(0.02 * static_cast<double>(i));
    entries[i] = { u, 1.f - u, 0.5f, static_cast<float>(8. * std::pow(10., exponent)) };
  }
  const TransferFunction transferFunction(-1., 1., entries);
  const Camera camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })),
    identityMatrix, width, height);
  ExactRay exact({ 2, 2, 2 }, cells);
  VolumeSettings settings;
  settings.samplesPerCell = 256.;
  double largest = 0.;
  inFloatsAndDoubles(settings, [&](const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(*field, transferFunction, camera, {}, ofKernel, image);
    for (int i = 0; i < width * height; ++i)
    {
      const Ray ray = camera.ray(i % width, i / width);
      const auto expected = exact.light(ray, 0., 20., transferFunction, 4096);
      for (int c = 0; c < 4; ++c)
      {
        largest = std::max(largest, std::abs(image.rgba[4 * i + c] - expected[c]));
      }
    }
  });
  expectAtMost(largest, 1. / 255., "of a channel");
}

// Transfer functions of every kind on fields of every kind: more samples are never worse, and the picture is right.
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"

#include "Error.h"
#include "Volume/Volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Entry = TransferFunction::Entry;
using Node = TransferFunction::Node;
using Point = std::array<double, 3>;

template <class T>
using Named = std::vector<std::pair<std::string, T>>;

constexpr int width = 30;
constexpr int height = 25;

template <class Value>
std::shared_ptr<const Field> makeField(const Value& value)
{
  auto cells = makeRandomTree({ 12, { 2, 2, 2 }, 4, 0.6, 0., false });
  setValues(cells, value);
  return test::makeField(unitRoots({ 2, 2, 2 }), cells);
}

/// A fractal's: steep everywhere, and 1 in a plateau.
double escape(const Point& p)
{
  std::complex<double> z = 0.;
  const std::complex<double> c(1.5 * p[0] - 2.1, 1.3 * (p[1] - 1.));
  for (int n = 0; n < 24; ++n)
  {
    z = z * z + c + 0.3 * (p[2] - 1.);
    if (std::norm(z) > 16.)
    {
      return std::clamp((n + 2. - std::log2(std::log2(std::norm(z)))) / 24., 0., 1.);
    }
  }
  return 1.;
}

Named<std::shared_ptr<const Field>> fields()
{
  return { { "line", makeField([](const Point& p) { return (p[0] + 0.3 * p[1] + 0.2 * p[2]) / 3.; }) },
    { "shock", makeField([](const Point& p) { return p[0] + 0.31 * p[1] > 1.2 ? 1000. : 0.3 * p[2]; }) },
    { "Gaussian", makeField([](const Point& p) {
       return std::exp(-4. * (std::pow(p[0] - 1., 2) + std::pow(p[1] - 1., 2) + std::pow(p[2] - 1., 2)));
     }) },
    { "fractal", makeField(escape) },
    { "sheet", makeField([](const Point& p) {
       const double s = p[1] - 1. - 0.16 * std::sin(4.5 * p[0] + 2. * std::sin(2.5 * p[2]));
       return 0.6 * std::exp(-s * s / 0.02) * (0.6 + 0.4 * std::sin(10. * p[0]) * std::sin(8. * p[2]));
     }) } };
}

Entry entry(double color, double extinction)
{
  return { static_cast<float>(color), static_cast<float>(1. - color), 0.5f, static_cast<float>(extinction) };
}

TransferFunction lines(const std::vector<std::pair<double, double>>& extinctions)
{
  std::vector<Node> nodes;
  for (const auto& [value, extinction] : extinctions)
  {
    nodes.push_back({ value, entry(value, extinction), entry(value, extinction) });
  }
  return TransferFunction::ofNodes(nodes);
}

/// Of one optical depth per unit of value, so wide on each side.
TransferFunction spikes(int count, double halfWidth)
{
  std::vector<std::pair<double, double>> points{ { 0., 0. } };
  for (int i = 0; i < count; ++i)
  {
    const double at = (i + 0.37) / count;
    points.insert(points.end(), { { at - halfWidth, 0. }, { at, 0.3 / halfWidth }, { at + halfWidth, 0. } });
  }
  points.emplace_back(1., 0.);
  return lines(points);
}

/// ParaView's default: opacity over a tenth of a unit is the value, so all of it at the largest.
TransferFunction toOpacityOne()
{
  constexpr double unit = 0.1;
  std::vector<Node> nodes;
  for (int i = 0; i < 60; ++i)
  {
    const double passes = std::pow(0.75, i);
    const Entry e = entry(1. - passes, -std::log(passes) / unit);
    nodes.push_back({ 1. - passes, e, e });
  }
  nodes.push_back({ 1., entry(1., 19. / unit), entry(1., TransferFunction::opaqueExtinction) });
  return TransferFunction::ofNodes(nodes);
}

TransferFunction logarithmic()
{
  std::vector<Node> nodes;
  for (int i = 0; i <= 120; ++i)
  {
    const Entry e = entry(i / 120., 5. * i / 120.);
    nodes.push_back({ std::pow(10., -6. + i / 20.), e, e });
  }
  return TransferFunction::ofNodes(nodes);
}

TransferFunction noise()
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  std::vector<Node> nodes;
  for (int i = 0; i < 1000; ++i)
  {
    const Entry e{ uniform(random), uniform(random), uniform(random), 6.f * uniform(random) };
    nodes.push_back({ i / 999., e, e });
  }
  return TransferFunction::ofNodes(nodes);
}

Named<TransferFunction> functions()
{
  constexpr double opaque = TransferFunction::opaqueExtinction;
  return { { "to opacity 1", toOpacityOne() }, { "ramp", lines({ { 0., 0. }, { 1., 20. } }) },
    { "logarithmic", logarithmic() },
    { "step", TransferFunction::ofNodes({ { 0.5, entry(0.2, 0.), entry(0.8, 8.) } }) },
    { "opaque", TransferFunction::ofNodes({ { 0.5, entry(0.2, 0.), entry(0.8, opaque) } }) },
    { "opaque, its colour changes",
      TransferFunction::ofNodes(
        { { 0.4, entry(0.4, 0.), entry(0., opaque) }, { 0.9, entry(1., opaque), entry(1., opaque) } }) },
    { "spike 1e-2", spikes(1, 1e-2) }, { "spike 1e-4", spikes(1, 1e-4) }, { "spike 1e-6", spikes(1, 1e-6) },
    { "thirty spikes", spikes(30, 1e-4) }, { "noise", noise() },
    { "faint", lines({ { 0., 0. }, { 1., 0.01 } }) } };
}

double rmse(const Image& a, const Image& b)
{
  double sum = 0.;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    sum += std::pow(static_cast<double>(a.rgba[i]) - b.rgba[i], 2);
  }
  return std::sqrt(sum / static_cast<double>(a.rgba.size()));
}

} // namespace

TEST(VolumeFunctions, MoreSamplesAreNeverWorse)
{
  const Camera camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })),
    identityMatrix, width, height);
  // Rays end where less light is left: what they do not see is no matter of samples.
  constexpr double ofEnds = 0.25 * opaqueTransmittance;
  for (const auto& [fieldName, field] : fields())
  {
    for (const auto& [functionName, function] : functions())
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
  const auto field = test::makeField(unitRoots({ 1, 1, 1 }), cells);
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

TEST(VolumeFunctions, NodesAreChecked)
{
  const Entry e = entry(0.5, 1.);
  EXPECT_THROW(TransferFunction::ofNodes({}), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { 1., e, e }, { 1., e, e } }), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { 0., e, e }, { std::nan(""), e, e } }), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { -1e308, e, e }, { 1e308, e, e } }), Error);
  EXPECT_THROW(TransferFunction::ofNodes({ { 0., e, entry(0.5, -1.) } }), Error);
}

TEST(VolumeFunctions, NodesHoldFromTheirValueOn)
{
  const TransferFunction function = TransferFunction::ofNodes(
    { { 1., entry(0., 1.), entry(0.5, 0.) }, { 2., entry(0.5, 0.), entry(1., 4.) } });
  EXPECT_EQ(function.at(std::nextafter(1.f, 0.f)), entry(0., 1.));
  EXPECT_EQ(function.at(1.f), entry(0.5, 0.));
  EXPECT_EQ(function.at(std::nextafter(2.f, 0.f)).extinction, 0.f);
  EXPECT_EQ(function.at(2.f), entry(1., 4.));
  EXPECT_EQ(function.at(-1e30f), entry(0., 1.));
  EXPECT_TRUE(function.isVisible({ 0.f, 0.5f }));
  EXPECT_FALSE(function.isVisible({ 1.f, std::nextafter(2.f, 0.f) }));
  EXPECT_TRUE(function.isVisible({ 1.5f, 2.f }));
}

#include "DigitsError.h"

#include "Contour/Contour.h"
#include "Interpolation/Sampler.h"
#include "Support/Cameras.h"
#include "Support/OneFrame.h"
#include "Support/RefinedTrees.h"
#include "Surface/Isosurface.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace treeamr::report
{

using test::BaseTree;
using test::makeBaseTrees;
using test::makeField;

namespace
{

/// first + range * u() of a point, in doubles or whole numbers.
struct Case
{
  const char* name;
  long double first;
  long double range;
  bool isWhole;

  long double at(double u) const
  {
    const long double value = first + range * u;
    return isWhole ? std::round(value) : static_cast<long double>(static_cast<double>(value));
  }
};

const Case cases[]{
  { "101325 +- 0.001", 101324.999L, 0.002L, false },
  { "1e6 + 1e-3 z", 1e6L, 1e-3L, false },
  { "1.7e9 + 100 z", 1.7e9L, 100.L, false },
  { "int64 near 2^52", 0x1p52L, 0x1p22L, true },
  { "int64 beyond 2^53", -0x1p62L, 0x1p33L, true },
};

double u(const Vec3& p)
{
  return (p[0] + 2. * p[1] + 4. * p[2]) / 7.;
}

/// Where no missing cell takes part.
constexpr double margin = 1. / BaseTree::roots;

bool isInner(const Vec3& p)
{
  return std::all_of(p.begin(), p.end(), [](double x) { return x > margin && x < 1. - margin; });
}

std::shared_ptr<const Field> fieldOf(const Case& c, const BaseTree& tree, double offset)
{
  const auto relative =
    makeField(tree, 1, [&](const Vec3& p) { return static_cast<double>(c.at(u(p)) - offset); });
  return std::make_shared<const Field>(
    relative->sharedOctree(), LargeVector<float>(relative->leafValues()), offset);
}

Camera camera()
{
  return Camera(
    test::multiply(test::perspective(40., 0.1, 10.), test::lookAt({ 1.5, 1.2, 2.2 }, { 0.5, 0.5, 0.5 })),
    test::identityMatrix, 120, 100);
}

double probeError(const Case& c, const std::shared_ptr<const Field>& field)
{
  const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> inside(margin, 1. - margin);
  double largest = 0.;
  for (int i = 0; i < 5000; ++i)
  {
    const Vec3 p{ inside(random), inside(random), inside(random) };
    FieldSample sample;
    sampler->sampleRelative(p, sample);
    const long double error = sample.value + (field->offset() - c.first) - c.range * u(p);
    largest = std::max(largest, static_cast<double>(std::abs(error / c.range)));
  }
  return largest;
}

double contourError(const Field& field, double isovalue, double uThere)
{
  double largest = -1.;
  for (const Vec3& p : contour(field, isovalue).points)
  {
    largest = isInner(p) ? std::max(largest, std::abs(u(p) - uThere)) : largest;
  }
  return largest < 0. ? 1. : largest;
}

double isosurfaceError(const std::shared_ptr<const Field>& field, double isovalue, double uThere)
{
  const Camera view = camera();
  HitImage image;
  Isosurface(field, { isovalue }).render(view, SurfaceLayers::All, image);
  double largest = -1.;
  for (int pixel = 0; pixel < view.width() * view.height(); ++pixel)
  {
    const Ray ray = view.ray(pixel % view.width(), pixel / view.width());
    for (std::size_t h = image.first[pixel]; h < image.first[pixel + 1]; ++h)
    {
      const Vec3 p = pointAt(ray, image.hits[h].t);
      largest = isInner(p) ? std::max(largest, std::abs(u(p) - uThere)) : largest;
    }
  }
  return largest < 0. ? 1. : largest;
}

/// Of fields that hold first + constant.
Image volume(const Case& c, const Field& field, long double constant)
{
  std::vector<TransferFunction::Entry> entries;
  constexpr int last = 1 << 18; // fine enough to read the nearest one
  for (int i = 0; i <= last; ++i)
  {
    const float part = static_cast<float>(i) / last;
    entries.push_back({ part, 1.f - part, 0.5f, 3.f * part });
  }
  const auto least = static_cast<double>(c.first + constant - field.offset());
  const TransferFunction colors(least, least + static_cast<double>(c.range), std::move(entries));
  const Camera view = camera();
  Image image(view.width(), view.height());
  constexpr std::size_t exactly = 0; // kept values are rounded to parts of a block's range
  test::volumeOf(field, colors, exactly).render(view, {}, image);
  return image;
}

double largestDifference(const Image& a, const Image& b)
{
  double largest = 0.;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    largest = std::max<double>(largest, std::abs(a.rgba[i] - b.rgba[i]));
  }
  return largest;
}

} // namespace

void measureDigits(bench::Report& report)
{
  const BaseTree tree = makeBaseTrees().back();
  for (const Case& c : cases)
  {
    const auto less =
      makeField(tree, 1, [&](const Vec3& p) { return static_cast<double>(c.at(u(p)) - c.first); });
    const Image expected = volume(c, *less, -c.first);
    const double needed = offsetFor(static_cast<double>(c.at(0.)), static_cast<double>(c.at(1.)));
    for (const auto& [stored, offset] : { std::pair("floats", 0.), std::pair("offset", needed) })
    {
      const auto field = fieldOf(c, tree, offset);
      const auto isovalue = static_cast<double>(c.at(0.57));
      const auto uThere = static_cast<double>((isovalue - c.first) / c.range);
      report.add({ c.name,
        { { "probe_error", probeError(c, field), "1e-6 probe", 3, 1e6 },
          { "contour_error", contourError(*field, isovalue, uThere), "contour", 3, 1e6 },
          { "isosurface_error", isosurfaceError(field, isovalue, uThere), "isosurface", 3, 1e6 },
          { "volume_error", largestDifference(volume(c, *field, 0.L), expected), "volume", 3, 1e6 } },
        { { "values", c.name }, { "stored", stored } } });
    }
  }
}

} // namespace treeamr::report

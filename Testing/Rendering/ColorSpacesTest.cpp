// Colour functions of every space against VTK's own evaluation: as curves, and as the kernel's table shows them. No
// window.
#include "ColorCurve.h"
#include "TransferFunctionConversion.h"
#include "Volume/Kernel/IntegralTable.h"

#include "vtkColorTransferFunction.h"
#include "vtkNew.h"
#include "vtkPiecewiseFunction.h"
#include "vtkVolumeProperty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

using namespace treeamr;

namespace
{

struct Space
{
  const char* name;
  ColorCurve::Space space;
  int ofVtk;
  bool wraps = false;
};

const std::array<Space, 5> spaces{ { { "RGB", ColorCurve::Space::Rgb, VTK_CTF_RGB },
  { "HSV", ColorCurve::Space::Hsv, VTK_CTF_HSV },
  { "wrapped HSV", ColorCurve::Space::WrappedHsv, VTK_CTF_HSV, true },
  { "Lab", ColorCurve::Space::Lab, VTK_CTF_LAB },
  { "Diverging", ColorCurve::Space::Diverging, VTK_CTF_DIVERGING } } };

void setSpace(vtkColorTransferFunction* function, const Space& space)
{
  function->SetColorSpace(space.ofVtk);
  function->SetHSVWrap(space.wraps);
}

class Random
{
public:
  double operator()() { return unit_(engine_); }
  /// Any colours, with many of those where spaces have rules of their own: gray, black, white, pure, nearly gray.
  std::array<double, 3> color(int kind)
  {
    Random& random = *this;
    std::array<double, 3> rgb{ random(), random(), random() };
    switch (kind % 8)
    {
      case 1:
        rgb.fill(rgb[0]);
        break;
      case 2:
        rgb.fill(0.);
        break;
      case 3:
        rgb.fill(1.);
        break;
      case 4:
        std::transform(rgb.begin(), rgb.end(), rgb.begin(), [](double x) { return std::round(x); });
        break;
      case 5:
        rgb = { rgb[0], rgb[0] + 0.04 * (rgb[1] - 0.5), rgb[0] + 0.04 * (rgb[2] - 0.5) };
        std::transform(rgb.begin(), rgb.end(), rgb.begin(), [](double x) { return std::clamp(x, 0., 1.); });
        break;
      default:
        break;
    }
    return rgb;
  }

private:
  std::mt19937 engine_{ 5 };
  std::uniform_real_distribution<double> unit_{ 0., 1. };
};

/// Compares the curve between two nodes with VTK's function of them.
double worstOfCurve(
  const Space& space, bool isLogarithmic, const ColorNode& a, const ColorNode& b, Random& random)
{
  vtkNew<vtkColorTransferFunction> function;
  setSpace(function, space);
  function->SetScale(isLogarithmic ? VTK_CTF_LOG10 : VTK_CTF_LINEAR);
  for (const ColorNode& node : { a, b })
  {
    function->AddRGBPoint(node[0], node[1], node[2], node[3], node[4], node[5]);
  }
  const ColorCurve curve({ space.space, isLogarithmic, a, b });
  std::array<double, ColorCurve::most> values;
  std::generate(values.begin(), values.end(), [&] { return a[0] + (1. - random()) * (b[0] - a[0]); });
  values.front() = a[0] * (1. + 1e-12); // VTK has the nodes' own colours at nodes
  values.back() = b[0] * (1. - 1e-12);
  ColorCurve::Colors colors;
  curve.at(values.data(), values.size(), colors);
  double worst = 0.;
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    double rgb[3];
    function->GetTable(values[i], values[i], 1, rgb);
    for (int c = 0; c < 3; ++c)
    {
      const double difference = std::abs(rgb[c] - colors.channel[c][i]);
      worst = difference <= worst ? worst : difference; // NaN counts
    }
  }
  return worst;
}

} // namespace

TEST(ColorSpaces, CurvesAreVtks)
{
  Random random;
  for (const Space& space : spaces)
  {
    for (const bool isLogarithmic : { false, true })
    {
      double worst = 0.;
      for (int i = 0; i < 1000; ++i)
      {
        const auto first = random.color(i);
        const auto last = random.color(i / 8);
        const double midpoint = i % 3 == 0 ? 0.5 : random();
        const double sharpness = i % 5 < 2 ? 0. : i % 5 == 2 ? 1. : random();
        const ColorNode a{ 0.1, first[0], first[1], first[2], midpoint, sharpness };
        const ColorNode b{ isLogarithmic ? 3e4 : 3., last[0], last[1], last[2], 0.5, 0. };
        worst = std::max(worst, worstOfCurve(space, isLogarithmic, a, b, random));
      }
      EXPECT_LT(worst, 1e-5) << space.name << ", " << isLogarithmic;
    }
  }
}

namespace
{

/// What lines of a table show at a place.
TransferFunction::Entry shown(const IntegralTable& table, double value)
{
  const auto place = static_cast<float>(table.placeOf(value)); // as kernels have it
  const std::size_t r = table.rowOf(place);
  const IntegralTable::Row& row = table.rows()[r];
  std::array<double, 4> terms;
  for (int c = 0; c < 4; ++c)
  {
    terms[c] = row.own[c] + row.slope[c] * (place - table.places()[r]);
  }
  return { static_cast<float>(terms[0] / terms[3]), static_cast<float>(terms[1] / terms[3]),
    static_cast<float>(terms[2] / terms[3]), static_cast<float>(terms[3] * table.unscale()) };
}

/// Random colours and opacities at points equally spaced over [0, range].
struct Points
{
  Points(const Space& space, bool isLogarithmic, int count, double range)
  {
    Random random;
    setSpace(color, space);
    color->SetScale(isLogarithmic ? VTK_CTF_LOG10 : VTK_CTF_LINEAR);
    const double first = isLogarithmic ? range / 100. : 0.;
    for (int i = 0; i < count; ++i)
    {
      const double value = first + (range - first) * i / (count - 1);
      color->AddRGBPoint(value, random(), random(), random());
      opacity->AddPoint(value, random());
    }
    property->SetColor(color);
    property->SetScalarOpacity(opacity);
    data = { static_cast<float>(first), static_cast<float>(range) };
  }

  vtkNew<vtkVolumeProperty> property;
  vtkNew<vtkColorTransferFunction> color;
  vtkNew<vtkPiecewiseFunction> opacity;
  Range data;
};

/// Red, green, blue, and the opacity over the unit distance.
using Rgba = std::array<double, 4>;

Rgba byVtk(const Points& points, double value)
{
  Rgba rgba;
  points.color->GetTable(value, value, 1, rgba.data());
  rgba[3] = points.opacity->GetValue(value);
  return rgba;
}

/// Of the channel that differs most.
double difference(const Rgba& expected, const TransferFunction::Entry& entry)
{
  return std::max(
    { std::abs(entry.r - expected[0]), std::abs(entry.g - expected[1]), std::abs(entry.b - expected[2]),
      std::abs(-std::expm1(-static_cast<double>(entry.extinction)) - expected[3]) });
}

} // namespace

TEST(ColorSpaces, TablesOfAThousandRandomPointsAreSmallAndRight)
{
  constexpr double asked = 1. / 512.;
  for (const Space& space : spaces)
  {
    for (const bool isLogarithmic : { false, true })
    {
      const Points points(space, isLogarithmic, 1000, 255.);
      const TransferFunction function = convertTransferFunction(points.property, points.data);
      const IntegralTable table(function, 1., 1e8, 1. / 128.);
      const std::string name = std::string(space.name) + ", " + std::to_string(isLogarithmic);
      EXPECT_LE(table.bytes(), std::size_t(1) << 20) << name << ": " << table.rows().size() << " rows";
      Random random;
      double worst = 0.;
      double worstShown = 0.;
      for (int i = 0; i < 4000; ++i)
      {
        const float value =
          points.data.min + static_cast<float>(random()) * (points.data.max - points.data.min);
        const Rgba expected = byVtk(points, value);
        worst = std::max(worst, difference(expected, function.at(value)));
        worstShown = std::max(worstShown, difference(expected, shown(table, value)));
      }
      EXPECT_LE(worst, asked) << name;
      EXPECT_LE(worstShown, asked) << name;
    }
  }
}

// The slopes of the lowest rows are no floats.
TEST(ColorSpaces, TablesHoldSixtyDecades)
{
  vtkNew<vtkColorTransferFunction> color;
  color->SetScale(VTK_CTF_LOG10);
  color->AddRGBPoint(1e-30, 0., 0.2, 1.);
  color->AddRGBPoint(1e-16, 1., 0.1, 0.);
  color->AddRGBPoint(1e4, 0., 1., 0.3);
  color->AddRGBPoint(1e30, 1., 1., 0.);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(1e-30, 0.2);
  opacity->AddPoint(3e-30, 0.8);
  opacity->AddPoint(1e30, 0.5);
  vtkNew<vtkVolumeProperty> property;
  property->SetColor(color);
  property->SetScalarOpacity(opacity);
  const TransferFunction function = convertTransferFunction(property, { 1e-30f, 1e30f });
  for (const double unit : { 1., 1e6 })
  {
    const IntegralTable table(function, unit, 1e8, 1. / 128.);
    for (int i = 0; i <= 6000; ++i)
    {
      const auto value = static_cast<float>(std::pow(10., -30. + 0.01 * i));
      const TransferFunction::Entry entry = shown(table, value);
      double rgb[3];
      color->GetColor(value, rgb);
      ASSERT_NEAR(entry.r, rgb[0], 1. / 512.) << value;
      ASSERT_NEAR(entry.g, rgb[1], 1. / 512.) << value;
      ASSERT_NEAR(entry.b, rgb[2], 1. / 512.) << value;
      ASSERT_NEAR(-std::expm1(-entry.extinction / unit), opacity->GetValue(value), 1. / 512.) << value;
    }
  }
}

// The table made of a vtkVolumeProperty against VTK's functions themselves. No window.
#include "SceneConversion.h"
#include "TransferFunctionConversion.h"

#include "Error.h"

#include "vtkColorTransferFunction.h"
#include "vtkNew.h"
#include "vtkPiecewiseFunction.h"
#include "vtkVolumeProperty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

using namespace treeamr;

namespace
{

/// A property with three opacity nodes and two colour nodes.
class TransferFunctionTest : public ::testing::Test
{
protected:
  TransferFunctionTest()
  {
    opacity->AddPoint(1., 0.1);
    opacity->AddPoint(2., 0.9);
    opacity->AddPoint(4., 0.3);
    color->AddRGBPoint(0., 1., 0., 0.2);
    color->AddRGBPoint(3., 0., 0.8, 1.);
    property->SetScalarOpacity(opacity);
    property->SetColor(color);
    property->SetScalarOpacityUnitDistance(0.5);
  }

  void expectEntry(const TransferFunction& table, double value, double tolerance)
  {
    const TransferFunction::Entry entry = table.at(static_cast<float>(value));
    double rgb[3];
    if (property->GetColorChannels(0) == 1)
    {
      rgb[0] = rgb[1] = rgb[2] = property->GetGrayTransferFunction(0)->GetValue(value);
    }
    else
    {
      property->GetRGBTransferFunction(0)->GetColor(value, rgb);
    }
    EXPECT_NEAR(entry.r, rgb[0], tolerance) << value;
    EXPECT_NEAR(entry.g, rgb[1], tolerance) << value;
    EXPECT_NEAR(entry.b, rgb[2], tolerance) << value;
    const double alpha = property->GetScalarOpacity(0)->GetValue(value);
    EXPECT_NEAR(
      entry.extinction, -std::log1p(-alpha) / property->GetScalarOpacityUnitDistance(0), 10. * tolerance)
      << value;
  }

  void expectEverywhere(Range data, double tolerance)
  {
    const TransferFunction table = convertTransferFunction(property, data);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> values(data.min, data.max);
    for (int i = 0; i < 500; ++i)
    {
      expectEntry(table, values(random), tolerance);
    }
    expectEntry(table, data.min, tolerance);
    expectEntry(table, data.max, tolerance);
  }

  vtkNew<vtkVolumeProperty> property;
  vtkNew<vtkPiecewiseFunction> opacity;
  vtkNew<vtkColorTransferFunction> color;
};

/// A table of 4096 entries over ranges of about 4, slopes of about 1.
constexpr double resolution = 1e-3;

} // namespace

TEST_F(TransferFunctionTest, dataWithinTheFunctions)
{
  expectEverywhere({ 0.5f, 3.5f }, resolution);
}

TEST_F(TransferFunctionTest, dataBeyondTheFunctions)
{
  expectEverywhere({ -20.f, 50.f }, resolution);
}

TEST_F(TransferFunctionTest, gray)
{
  vtkNew<vtkPiecewiseFunction> gray;
  gray->AddPoint(0., 0.2);
  gray->AddPoint(3., 0.7);
  property->SetColor(gray);
  ASSERT_EQ(property->GetColorChannels(0), 1);
  expectEverywhere({ -1.f, 5.f }, resolution);
}

TEST_F(TransferFunctionTest, defaultFunctions)
{
  vtkNew<vtkVolumeProperty> untouched;
  const TransferFunction table = convertTransferFunction(untouched, { 0.f, 1.f });
  EXPECT_GT(table.at(0.5f).extinction, 1.f);
}

// Entries are spent where the data are: a small part of wide functions.
TEST_F(TransferFunctionTest, smallDataRange)
{
  opacity->AddPoint(1e6, 0.5);
  color->AddRGBPoint(1e6, 0.5, 0.5, 0.5);
  expectEverywhere({ 1.9f, 2.1f }, resolution);
}

// And functions at a small part of wide data.
TEST_F(TransferFunctionTest, largeDataRange)
{
  const TransferFunction table = convertTransferFunction(property, { -1e6f, 1e6f });
  for (const double value : { -5., 0.3, 1.2, 2., 2.6, 3.9, 17. })
  {
    expectEntry(table, value, resolution);
  }
}

// Functions that end with a jump have it where it is in values less an offset, too.
TEST_F(TransferFunctionTest, dataLessAnOffset)
{
  vtkNew<vtkVolumeProperty> shifted;
  vtkNew<vtkPiecewiseFunction> opacityThere;
  vtkNew<vtkColorTransferFunction> colorThere;
  constexpr double offset = 0x1p40;
  for (vtkNew<vtkVolumeProperty>* p : { &property, &shifted })
  {
    const bool there = p == &shifted;
    vtkPiecewiseFunction* o = there ? opacityThere.Get() : opacity.Get();
    vtkColorTransferFunction* c = there ? colorThere.Get() : color.Get();
    o->RemoveAllPoints();
    c->RemoveAllPoints();
    o->ClampingOff();
    c->ClampingOff();
    const double base = there ? offset : 0.;
    o->AddPoint(base + 1., 0.3);
    o->AddPoint(base + 3., 0.9);
    c->AddRGBPoint(base + 1., 0.2, 0.4, 0.6);
    c->AddRGBPoint(base + 3., 0.9, 0.1, 0.3);
    (*p)->SetColor(c);
    (*p)->SetScalarOpacity(o);
    (*p)->SetScalarOpacityUnitDistance(1.);
  }
  for (const Range data : { Range{ 0.f, 4.f }, Range{ 1.f, 3.f }, Range{ 1.5f, 2.f }, Range{ 7.f, 9.f } })
  {
    const TransferFunction expected = convertTransferFunction(property, data);
    const TransferFunction table = convertTransferFunction(shifted, data, offset);
    for (double value = 0.; value <= 4.; value += 1. / 256.)
    {
      const TransferFunction::Entry entry = table.at(static_cast<float>(value));
      const TransferFunction::Entry wanted = expected.at(static_cast<float>(value));
      EXPECT_NEAR(entry.extinction, wanted.extinction, 3e-3) << value; // a 4096th of the steepest slope
      EXPECT_NEAR(entry.r, wanted.r, 1e-3) << value;
    }
  }
}

TEST_F(TransferFunctionTest, valuesOfOneKind)
{
  expectEverywhere({ 2.5f, 2.5f }, 1e-6);
  expectEverywhere({ 70.f, 70.f }, 1e-6);
  expectEverywhere({ -3.f, -3.f }, 1e-6);
}

TEST_F(TransferFunctionTest, dataApartFromTheFunctions)
{
  expectEverywhere({ 5.f, 9.f }, 1e-6);
  expectEverywhere({ 4.f, 9.f }, 1e-6);
  expectEverywhere({ -9.f, -2.f }, 1e-6);
}

TEST_F(TransferFunctionTest, nothingOutsideWithoutClamping)
{
  opacity->ClampingOff();
  color->RemoveAllPoints();
  color->AddRGBPoint(2., 1., 1., 1.);
  for (const Range data : { Range{ -10.f, 10.f }, Range{ 0.f, 4.5f }, Range{ 1.f, 4.f } })
  {
    const TransferFunction table = convertTransferFunction(property, data);
    if (data.min < 1.f)
    {
      EXPECT_EQ(table.at(0.98f).extinction, 0.f);
      EXPECT_FALSE(table.isVisible({ -10.f, 0.98f }));
    }
    if (data.max > 4.f)
    {
      EXPECT_EQ(table.at(4.02f).extinction, 0.f);
    }
    expectEntry(table, 1.01, resolution);
    expectEntry(table, 3.99, resolution);
    // On the last nodes themselves VTK has nothing at one of the two: on the first one up to 9.2, then on the last.
    expectEntry(table, 1., resolution);
    expectEntry(table, 4., resolution);
  }
  EXPECT_EQ(convertTransferFunction(property, { 5.f, 9.f }).at(6.f).extinction, 0.f);
  EXPECT_EQ(convertTransferFunction(property, { 4.f, 9.f }).at(6.f).extinction, 0.f);
  EXPECT_EQ(convertTransferFunction(property, { -5.f, 0.f }).at(-1.f).extinction, 0.f);
}

TEST_F(TransferFunctionTest, colorsForValuesOutOfRange)
{
  opacity->RemoveAllPoints();
  opacity->AddPoint(2., 0.5);
  color->SetUseBelowRangeColor(true);
  color->SetBelowRangeColor(0., 1., 0.);
  color->SetUseAboveRangeColor(true);
  color->SetAboveRangeColor(1., 1., 0.);
  const TransferFunction table = convertTransferFunction(property, { -10.f, 10.f });
  for (const double value : { -9., -0.02, 0.02, 1.7, 2.98, 3.02, 9. })
  {
    expectEntry(table, value, resolution);
  }
}

TEST_F(TransferFunctionTest, logarithmicColors)
{
  color->RemoveAllPoints();
  color->AddRGBPoint(0.1, 1., 0., 0.2);
  color->AddRGBPoint(3., 0., 0.8, 1.);
  color->SetScaleToLog10();
  expectEverywhere({ 0.5f, 3.5f }, resolution);
}

TEST_F(TransferFunctionTest, fewNodes)
{
  opacity->RemoveAllPoints();
  color->RemoveAllPoints();
  EXPECT_EQ(convertTransferFunction(property, { 0.f, 1.f }).at(0.5f).extinction, 0.f);
  opacity->AddPoint(0.5, 0.7);
  color->AddRGBPoint(0.5, 0.1, 0.2, 0.3);
  expectEverywhere({ 0.f, 1.f }, 1e-6);
}

TEST_F(TransferFunctionTest, opaque)
{
  opacity->AddPoint(2., 1.);
  opacity->AddPoint(2.1, 1.);
  const TransferFunction table = convertTransferFunction(property, { 0.f, 5.f });
  EXPECT_GT(table.at(2.05f).extinction, 1e3f);
  EXPECT_TRUE(std::isfinite(table.at(2.05f).extinction));
}

TEST_F(TransferFunctionTest, unitDistance)
{
  for (const double distance : { 0., -1., static_cast<double>(INFINITY), static_cast<double>(NAN) })
  {
    property->SetScalarOpacityUnitDistance(distance);
    EXPECT_THROW(convertTransferFunction(property, { 0.f, 1.f }), Error) << distance;
  }
}

namespace
{

/// The largest difference of a channel, of the opacity over the unit distance too, from VTK's own evaluation at
/// floats of [low, high], of which half are spread over its decades, and around all nodes.
double worstChannel(vtkVolumeProperty* property, float low, float high, int count = 4000)
{
  const TransferFunction table = convertTransferFunction(property, { low, high });
  vtkColorTransferFunction* const color = property->GetRGBTransferFunction(0);
  vtkPiecewiseFunction* const opacity = property->GetScalarOpacity(0);
  std::vector<float> values{ low, high };
  std::mt19937 random(7);
  std::uniform_real_distribution<double> parts(0., 1.);
  for (int i = 0; i < count; ++i)
  {
    const double part = parts(random);
    values.push_back(
      static_cast<float>(i % 2 == 0 || low <= 0.f ? low + part * (static_cast<double>(high) - low)
                                                  : low * std::pow(static_cast<double>(high) / low, part)));
  }
  const auto around = [&](double node) {
    const auto nearest = static_cast<float>(node);
    for (const float value :
      { std::nextafter(nearest, -INFINITY), nearest, std::nextafter(nearest, INFINITY) })
    {
      if (value >= low && value <= high)
      {
        values.push_back(value);
      }
    }
  };
  double node[6];
  for (int i = 0; i < color->GetSize(); ++i)
  {
    color->GetNodeValue(i, node);
    around(node[0]);
  }
  for (int i = 0; i < opacity->GetSize(); ++i)
  {
    opacity->GetNodeValue(i, node);
    around(node[0]);
  }
  double worst = 0.;
  for (const float value : values)
  {
    const TransferFunction::Entry entry = table.at(value);
    double rgb[3];
    color->GetTable(value, value, 1, rgb);
    const double alpha = -std::expm1(-entry.extinction * property->GetScalarOpacityUnitDistance(0));
    const double differences[]{ entry.r - rgb[0], entry.g - rgb[1], entry.b - rgb[2],
      alpha - opacity->GetValue(value) };
    for (const double difference : differences)
    {
      worst = std::abs(difference) <= worst ? worst : std::abs(difference); // NaN counts
    }
  }
  return worst;
}

constexpr double asked = 1. / 512.;

} // namespace

TEST_F(TransferFunctionTest, everyColorSpaceAndCurve)
{
  using Set = void (vtkColorTransferFunction::*)();
  const std::pair<const char*, Set> spaces[]{ { "RGB", &vtkColorTransferFunction::SetColorSpaceToRGB },
    { "HSV", &vtkColorTransferFunction::SetColorSpaceToHSV },
    { "Lab", &vtkColorTransferFunction::SetColorSpaceToLab },
    { "Diverging", &vtkColorTransferFunction::SetColorSpaceToDiverging },
    { "Step", &vtkColorTransferFunction::SetColorSpaceToStep } };
  for (const bool logarithmic : { false, true })
  {
    color->SetScale(logarithmic ? VTK_CTF_LOG10 : VTK_CTF_LINEAR);
    opacity->SetUseLogScale(logarithmic);
    for (const auto& [name, set] : spaces)
    {
      (color->*set)();
      for (const auto& [midpoint, sharpness] : { std::pair{ 0.5, 0. }, std::pair{ 0.2, 0. },
             std::pair{ 0.5, 0.4 }, std::pair{ 0.9, 0.95 }, std::pair{ 0.1, 1. } })
      {
        color->RemoveAllPoints();
        color->AddRGBPoint(0.1, 0.2, 0.3, 0.8, midpoint, sharpness);
        color->AddRGBPoint(1., 0.9, 0.85, 0.8, midpoint, sharpness);
        color->AddRGBPoint(3., 0.7, 0., 0.15, midpoint, sharpness);
        opacity->RemoveAllPoints();
        opacity->AddPoint(0.2, 0., midpoint, sharpness);
        opacity->AddPoint(2., 1., midpoint, sharpness);
        opacity->AddPoint(3.5, 0.3, midpoint, sharpness);
        EXPECT_LE(worstChannel(property, 0.05f, 4.f), asked)
          << name << ", " << logarithmic << ", midpoint " << midpoint << ", sharpness " << sharpness;
      }
    }
  }
}

// Values without a logarithm lie below the first node.
TEST_F(TransferFunctionTest, logarithmsOfValuesFromBelowZero)
{
  color->SetScaleToLog10();
  opacity->SetUseLogScale(true);
  for (const bool belowRange : { false, true })
  {
    color->RemoveAllPoints();
    color->AddRGBPoint(1e-3, 0.1, 0.2, 0.9);
    color->AddRGBPoint(10., 0.9, 0.3, 0.1);
    color->SetUseBelowRangeColor(belowRange);
    color->SetBelowRangeColor(0.3, 0.6, 0.4);
    opacity->RemoveAllPoints();
    opacity->AddPoint(1e-3, 0.2);
    opacity->AddPoint(10., 0.7);
    const TransferFunction table = convertTransferFunction(property, { -5.f, 10.f });
    for (const float value : { -5.f, -1e-3f, 0.f, 1e-30f, 9e-4f })
    {
      const TransferFunction::Entry entry = table.at(value);
      EXPECT_NEAR(entry.r, belowRange ? 0.3 : 0.1, 1e-6) << value;
      EXPECT_NEAR(entry.b, belowRange ? 0.4 : 0.9, 1e-6) << value;
      EXPECT_NEAR(-std::expm1(-entry.extinction * 0.5), 0.2, 1e-6) << value;
    }
    for (const double value : { 2e-3, 0.1, 3. })
    {
      double rgb[3];
      color->GetColor(value, rgb);
      EXPECT_NEAR(table.at(static_cast<float>(value)).r, rgb[0], asked) << value;
    }
  }
}

TEST_F(TransferFunctionTest, sixtyDecades)
{
  color->SetScaleToLog10();
  color->RemoveAllPoints();
  color->AddRGBPoint(1e-30, 0., 0., 1.);
  color->AddRGBPoint(1., 0.9, 0.9, 0.9);
  color->AddRGBPoint(1e30, 1., 0., 0.);
  opacity->SetUseLogScale(true);
  opacity->RemoveAllPoints();
  opacity->AddPoint(1e-30, 0.);
  opacity->AddPoint(1e-12, 0.);
  opacity->AddPoint(1.01e-12, 0.9);
  opacity->AddPoint(1.02e-12, 0.);
  opacity->AddPoint(1e30, 0.5);
  EXPECT_LE(worstChannel(property, 1e-30f, 1e30f, 20000), asked);
  EXPECT_LE(worstChannel(property, 1e-14f, 1e-10f, 20000), asked);
}

TEST_F(TransferFunctionTest, jumps)
{
  color->SetAllowDuplicateScalars(true);
  color->RemoveAllPoints();
  color->AddRGBPoint(0., 0., 0., 1.);
  color->AddRGBPoint(1., 0., 1., 1.);
  color->AddRGBPoint(1., 1., 0., 0.);
  color->AddRGBPoint(2., 1., 1., 0.);
  opacity->SetAllowDuplicateScalars(true);
  opacity->RemoveAllPoints();
  opacity->AddPoint(0., 0.);
  opacity->AddPoint(0.5, 0.);
  opacity->AddPoint(0.5, 1.);
  opacity->AddPoint(1.5, 1.);
  opacity->AddPoint(1.5, 0.2);
  EXPECT_LE(worstChannel(property, -1.f, 3.f), asked);
  color->SetUseBelowRangeColor(true);
  color->SetBelowRangeColor(0., 1., 0.);
  color->SetUseAboveRangeColor(true);
  color->SetAboveRangeColor(1., 1., 0.);
  EXPECT_LE(worstChannel(property, -1.f, 3.f), asked);
  color->ClampingOff();
  opacity->ClampingOff();
  EXPECT_LE(worstChannel(property, -1.f, 3.f), asked);
}

TEST_F(TransferFunctionTest, thousandsOfNodes)
{
  color->RemoveAllPoints();
  opacity->RemoveAllPoints();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> parts(0., 1.);
  constexpr int count = 3000;
  for (int i = 0; i < count; ++i)
  {
    color->AddRGBPoint(i, parts(random), parts(random), parts(random));
    opacity->AddPoint(i + 0.3, parts(random));
  }
  EXPECT_LE(worstChannel(property, 0.f, static_cast<float>(count)), asked);
}

// VTK keeps opacities beyond 0 and 1 as they are; what they come to bends there.
TEST_F(TransferFunctionTest, opacitiesBeyondBothEnds)
{
  for (const bool rises : { true, false })
  {
    opacity->RemoveAllPoints();
    opacity->AddPoint(0., rises ? -0.5 : 1.5);
    opacity->AddPoint(2., rises ? 1.5 : -0.5);
    const TransferFunction table = convertTransferFunction(property, { 0.f, 2.f });
    for (const float value : { 0.f, 0.2f, 0.49f, 0.55f, 0.7f, 1.f, 1.3f, 1.45f, 1.6f, 2.f })
    {
      const double alpha = std::clamp(opacity->GetValue(value), 0., 1.);
      EXPECT_NEAR(-std::expm1(-table.at(value).extinction * 0.5), alpha, asked) << value;
    }
    EXPECT_FALSE(table.isVisible(rises ? Range{ 0.f, 0.49f } : Range{ 1.51f, 2.f }));
  }
}

TEST_F(TransferFunctionTest, narrowPeaks)
{
  for (const double width : { 1e-2, 1e-4, 1e-6 })
  {
    opacity->RemoveAllPoints();
    opacity->AddPoint(0., 0.);
    opacity->AddPoint(0.37 - width, 0.);
    opacity->AddPoint(0.37, 0.8);
    opacity->AddPoint(0.37 + width, 0.);
    EXPECT_LE(worstChannel(property, 0.f, 1.f), asked) << width;
    EXPECT_LE(
      worstChannel(property, static_cast<float>(0.37 - 2. * width), static_cast<float>(0.37 + 2. * width)),
      asked)
      << width;
  }
}

// An opacity of 1 that a ramp only touches has no width, however steep the ramp: of the optical depth there is as much as
// the ramp is wide.
TEST_F(TransferFunctionTest, rampsThatTouchFullOpacity)
{
  property->SetScalarOpacityUnitDistance(1.);
  for (const double width : { 1e-1, 1e-3, 1e-4, 1e-5 })
  {
    opacity->RemoveAllPoints();
    opacity->AddPoint(0.5, 0.);
    opacity->AddPoint(0.5 + 0.5 * width, 1.);
    opacity->AddPoint(0.5 + width, 0.);
    const TransferFunction table = convertTransferFunction(property, { 0.f, 1.f });
    double depth = 0.; // the integral of -log(1 - opacity), which is the width
    for (std::size_t i = 0; i + 1 < table.nodes().size(); ++i)
    {
      const TransferFunction::Node& a = table.nodes()[i];
      const TransferFunction::Node& b = table.nodes()[i + 1];
      depth += 0.5 * (static_cast<double>(a.above.extinction) + b.below.extinction) * (b.value - a.value);
    }
    EXPECT_NEAR(depth / width, 1., 0.02) << width; // lines between nodes lie above the curve
  }
}

TEST_F(TransferFunctionTest, lab2000IsAskedForOneTable)
{
  color->SetColorSpaceToLabCIEDE2000();
  color->RemoveAllPoints();
  color->AddRGBPoint(0., 0.1, 0.2, 0.9);
  color->AddRGBPoint(1., 0.9, 0.3, 0.1);
  constexpr int size = 50;
  std::array<double, 3 * size> expected;
  color->GetTable(0., 1., size, expected.data());
  const TransferFunction table = convertTransferFunction(property, { 0.f, 1.f });
  for (int i = 1; i + 1 < size; ++i)
  {
    const TransferFunction::Entry entry = table.at(static_cast<float>(i) / (size - 1));
    EXPECT_NEAR(entry.r, expected[3 * i], asked) << i;
    EXPECT_NEAR(entry.g, expected[3 * i + 1], asked) << i;
    EXPECT_NEAR(entry.b, expected[3 * i + 2], asked) << i;
  }
}

TEST_F(TransferFunctionTest, surfaceMaterials)
{
  property->SetScalarOpacityUnitDistance(0.); // of no effect on surfaces
  property->SetAmbient(0.2);
  property->SetDiffuse(0.5);
  property->SetSpecular(0.3);
  property->SetSpecularPower(7.);
  const std::vector<double> isovalues{ -1., 1.5, 2., 9. };
  for (const bool gray : { false, true })
  {
    if (gray)
    {
      vtkNew<vtkPiecewiseFunction> ramp;
      ramp->AddPoint(0., 0.1);
      ramp->AddPoint(4., 0.9);
      property->SetColor(ramp);
    }
    for (const bool shaded : { false, true })
    {
      property->SetShade(shaded);
      for (const double scale : { 0., 0.5, 1., 3. })
      {
        const std::vector<SurfaceMaterial> surfaces =
          convertSurfaceMaterials(property, isovalues, scale, shaded, { Light() });
        ASSERT_EQ(surfaces.size(), isovalues.size());
        for (std::size_t i = 0; i < surfaces.size(); ++i)
        {
          double rgb[3];
          color->GetColor(isovalues[i], rgb);
          const Material& m = surfaces[i].material;
          for (int c = 0; c < 3; ++c)
          {
            const double expected =
              gray ? property->GetGrayTransferFunction(0)->GetValue(isovalues[i]) : rgb[c];
            EXPECT_FLOAT_EQ(m.ambient[c], static_cast<float>((shaded ? 0.2 : 1.) * expected));
            EXPECT_FLOAT_EQ(m.diffuse[c], static_cast<float>((shaded ? 0.5 : 0.) * expected));
            EXPECT_FLOAT_EQ(m.specular[c], shaded ? 0.3f : 0.f);
          }
          EXPECT_EQ(m.specularPower, shaded ? 7.f : 1.f);
          EXPECT_FLOAT_EQ(
            surfaces[i].opacity, static_cast<float>(std::min(1., scale * opacity->GetValue(isovalues[i]))));
        }
      }
    }
  }
}

// Transfer functions of two values by vtkTreeAMRVolumeMapper: against VTK's own volume mapper on a uniform grid.
#include "RenderingScene.h"
#include "VolumePair.h"

#include "vtkFloatArray.h"
#include "vtkGPUVolumeRayCastMapper.h"
#include "vtkImageData.h"
#include "vtkPlane.h"
#include "vtkPointData.h"
#include "vtkVersionMacros.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <cmath>
#include <string>

using namespace treeamr::test;

namespace
{

/// Of 255, in the mean over drawn pixels.
constexpr double tolerance = 2.;
/// VTK's opacities are over this, ours over the unit distance.
constexpr double sampleDistance = 0.005;
/// VTK makes textures of fewer pixels anew, by a filter of its own.
constexpr int texturePixels = 1024;

/// A hill that is steep for some gradients, and no product of two functions.
vtkSmartPointer<vtkImageData> hill(int columns = texturePixels, int rows = texturePixels)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(columns, rows, 1);
  image->AllocateScalars(VTK_FLOAT, 4);
  auto* pixels = static_cast<float*>(image->GetScalarPointer());
  for (int row = 0; row < rows; ++row)
  {
    for (int column = 0; column < columns; ++column)
    {
      const float u = (static_cast<float>(column) + 0.5f) / static_cast<float>(columns);
      const float v = (static_cast<float>(row) + 0.5f) / static_cast<float>(rows);
      const float height = std::max(0.f, std::sin(6.f * u + 3.f * v) * std::min(1.f, 6.f * v));
      *pixels++ = u;
      *pixels++ = std::abs(std::sin(9.f * v));
      *pixels++ = 1.f - u;
      *pixels++ = 0.03f * height;
    }
  }
  return image;
}

class VolumeTransfer2DTest : public RenderingTest
{
protected:
  VolumeTransfer2DTest()
  {
    pair.showOurs();
    oneValue = pair.scene.render();
    pair.property()->SetScalarOpacityUnitDistance(sampleDistance);
    pair.property()->SetTransferFunction2D(image);
    pair.property()->SetTransferFunctionMode(vtkVolumeProperty::TF_2D);
  }
  /// Of the second axis in both mappers.
  void useArray(const char* name)
  {
    pair.difference([name](vtkVolumeMapper* mapper) {
      if (auto* ours = vtkTreeAMRVolumeMapper::SafeDownCast(mapper))
      {
        ours->SetTransfer2DYAxisArray(name);
      }
      if (auto* theirs = vtkGPUVolumeRayCastMapper::SafeDownCast(mapper))
      {
        theirs->SetTransfer2DYAxisArray(name);
      }
    });
  }
  auto render()
  {
    pair.showOurs();
    return pair.scene.render();
  }

  vtkSmartPointer<vtkImageData> image = hill();
  VolumePair pair;
  decltype(pair.scene.render()) oneValue;
};

} // namespace

TEST_F(VolumeTransfer2DTest, gradientsAsVTK)
{
  MessageCounter messages(pair.mapper());
  EXPECT_LT(pair.difference(), tolerance);
  EXPECT_NE(render(), oneValue);
  pair.property()->SetInterpolationTypeToNearest();
  EXPECT_LT(pair.difference(), tolerance) << "nearest";
  EXPECT_TRUE(messages.warnings.empty());
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(VolumeTransfer2DTest, arraysAsVTK)
{
  MessageCounter messages(pair.mapper());
  const auto byGradient = render();
  useArray("other");
  EXPECT_LT(pair.difference(), tolerance);
  EXPECT_NE(render(), byGradient);
  pair.property()->SetInterpolationTypeToNearest();
  EXPECT_LT(pair.difference(), tolerance) << "nearest";
  pair.property()->SetInterpolationTypeToLinear();
  useArray(nullptr);
  EXPECT_EQ(render(), byGradient);
  EXPECT_TRUE(messages.warnings.empty());
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(VolumeTransfer2DTest, lightAndSlicesAsVTK)
{
  vtkVolumeProperty* property = pair.property();
  property->SetAmbient(0.2);
  property->SetDiffuse(0.7);
  property->SetSpecular(vtkHasPhongsHighlights ? 0.3 : 0.);
  property->SetSpecularPower(12.);
  for (const char* array : { static_cast<const char*>(nullptr), "other" })
  {
    useArray(array);
    const auto unlit = render();
    property->ShadeOn();
    EXPECT_LT(pair.difference(), tolerance) << "lit";
    EXPECT_NE(render(), unlit);
    property->ShadeOff();
  }
  vtkNew<vtkPlane> plane;
  plane->SetNormal(0.2, 0.5, 0.9);
  property->SetSliceFunction(plane);
  const auto slice = [](vtkVolumeMapper* mapper) { mapper->SetBlendModeToSlice(); };
  EXPECT_LT(pair.difference(slice), tolerance) << "array";
}

// As VTK's textures: a quarter of the range across a cell, pixels in between, and what lies beyond the last one.
TEST_F(VolumeTransfer2DTest, rangesAreTheDatas)
{
  vtkTreeAMRVolumeMapper* mapper = pair.mapper();
  const auto picture = render();
  double range[2];
  mapper->GetHyperTreeGrid()->GetCellData()->GetArray("wave")->GetFiniteRange(range);
  const double longest = 0.25 * (range[1] - range[0]) / (2. / 64.);
  const auto differenceOf = [&](double low, double high, double least, double most) {
    mapper->SetTransfer2DRange(low, high, least, most);
    const auto other = render();
    double largest = 0.;
    for (std::size_t i = 0; i < other.size(); ++i)
    {
      largest = std::max(largest, std::abs(static_cast<double>(other[i][0]) - picture[i][0]));
    }
    return largest;
  };
  EXPECT_LT(differenceOf(range[0], range[1], 0., longest), 1e-5);
  EXPECT_LT(differenceOf(0., -1., 0., longest), 1e-5);
  EXPECT_GT(differenceOf(range[0], range[1], 0., 0.5 * longest), 0.02);
  EXPECT_GT(differenceOf(range[0], range[0] + 0.5 * (range[1] - range[0]), 0., -1.), 0.02);
  EXPECT_EQ(differenceOf(0., -1., 0., -1.), 0.);
}

// Of few pixels opacities, rather than extinctions, are linear in between.
TEST_F(VolumeTransfer2DTest, fewPixelsAreBilinear)
{
  const auto few = hill(6, 5);
  const auto many = vtkSmartPointer<vtkImageData>::New();
  many->SetDimensions(texturePixels, texturePixels, 1);
  many->AllocateScalars(VTK_FLOAT, 4);
  auto* pixels = static_cast<float*>(many->GetScalarPointer());
  const auto place = [](int pixel, int size) {
    return std::clamp((pixel + 0.5) / texturePixels * size - 0.5, 0., size - 1.);
  };
  vtkDataArray* from = few->GetPointData()->GetScalars();
  for (int row = 0; row < texturePixels; ++row)
  {
    for (int column = 0; column < texturePixels; ++column)
    {
      const double x = place(column, 6);
      const double y = place(row, 5);
      const int left = std::min(static_cast<int>(x), 4);
      const int low = std::min(static_cast<int>(y), 3);
      for (int c = 0; c < 4; ++c)
      {
        const auto at = [&](int i, int j) { return from->GetComponent(6 * (low + j) + left + i, c); };
        *pixels++ = static_cast<float>(std::lerp(
          std::lerp(at(0, 0), at(1, 0), x - left), std::lerp(at(0, 1), at(1, 1), x - left), y - low));
      }
    }
  }
  pair.property()->SetTransferFunction2D(many);
  EXPECT_LT(pair.difference(), tolerance);
  const auto expected = render();
  pair.property()->SetTransferFunction2D(few);
  const auto picture = render();
  for (std::size_t i = 0; i < picture.size(); ++i)
  {
    EXPECT_NEAR(picture[i][0], expected[i][0], 4e-3);
  }
}

TEST_F(VolumeTransfer2DTest, newFunctionsAreDrawnAndOldOnesComeBack)
{
  const auto first = render();
  auto* pixels = vtkFloatArray::SafeDownCast(image->GetPointData()->GetScalars());
  for (vtkIdType i = 0; i < pixels->GetNumberOfTuples(); ++i)
  {
    pixels->SetComponent(i, 0, 0.);
  }
  image->Modified();
  const auto second = render();
  EXPECT_NE(second, first);
  pair.property()->SetTransferFunctionMode(vtkVolumeProperty::TF_1D);
  pair.property()->SetScalarOpacityUnitDistance(0.2);
  EXPECT_EQ(render(), oneValue);
  pair.property()->SetTransferFunctionMode(vtkVolumeProperty::TF_2D);
  pair.property()->SetScalarOpacityUnitDistance(sampleDistance);
  EXPECT_EQ(render(), second);
  const MessageCounter messages(pair.mapper());
  pair.mapper()->SetBlendModeToMaximumIntensity();
  render();
  EXPECT_EQ(messages.warnings.size(), 1u);
  pair.mapper()->SetBlendModeToComposite();
  EXPECT_EQ(render(), second);
  // A volume that copies the mapper's settings is the same.
  pair.mapper()->SetTransfer2DYAxisArray("other");
  pair.mapper()->SetTransfer2DYAxisComponent(3);
  pair.mapper()->SetTransfer2DRange(0.1, 0.9, 0., 0.5);
  vtkNew<vtkTreeAMRVolumeMapper> copy;
  copy->ShallowCopy(pair.mapper());
  EXPECT_STREQ(copy->GetTransfer2DYAxisArray(), "other");
  EXPECT_EQ(copy->GetTransfer2DYAxisComponent(), 3);
  EXPECT_EQ(copy->GetTransfer2DRange()[3], 0.5);
}

// By component, and one beyond the last is the magnitude.
TEST_F(VolumeTransfer2DTest, componentsOfTheSecondArray)
{
  pair.mapper()->SetTransfer2DYAxisArray("other");
  const auto other = render();
  pair.usePairs(); // of "other" and "wave"
  pair.property()->IndependentComponentsOn();
  pair.mapper()->SelectScalarArray("wave");
  pair.mapper()->SetTransfer2DYAxisArray("pair");
  EXPECT_EQ(render(), other);
  pair.mapper()->SetTransfer2DYAxisComponent(1);
  EXPECT_NE(render(), other);
  pair.mapper()->SetTransfer2DYAxisComponent(-1);
  const auto magnitude = render();
  EXPECT_NE(magnitude, other);
  pair.mapper()->SetTransfer2DYAxisComponent(2);
  EXPECT_EQ(render(), magnitude);
}

TEST_F(VolumeTransfer2DTest, whatCannotBeDrawnIsSaid)
{
  MessageCounter messages(pair.mapper());
  vtkVolumeProperty* property = pair.property();
  property->SetScalarOpacityUnitDistance(0.2);
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0) // VTK 9.1 dereferences it
  property->SetTransferFunction2D(nullptr);
  EXPECT_EQ(render(), oneValue);
  render();
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("TransferFunctionMode TF_2D: without effect"), std::string::npos);
#endif
  property->SetTransferFunction2D(image);
  const auto two = render();
  EXPECT_NE(two, oneValue);
  pair.mapper()->SetOpacityArrayName("wave");
  EXPECT_NE(render(), two);
  pair.mapper()->SetOpacityArrayName("");
  EXPECT_EQ(render(), two);
  EXPECT_TRUE(messages.errors.empty());
  pair.mapper()->SetTransfer2DYAxisArray("missing");
  render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("'missing'"), std::string::npos) << messages.errors[0];
  pair.mapper()->SetTransfer2DYAxisArray("");
  messages.errors.clear();
  pair.mapper()->SetTransfer2DRange(0., 1., 0., std::nan(""));
  render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("fourth number of the Transfer2DRange is not"), std::string::npos)
    << messages.errors[0];
  pair.mapper()->SetTransfer2DRange(0., -1., 0., -1.);
  messages.errors.clear();
  vtkNew<vtkFloatArray> grey;
  grey->SetNumberOfTuples(vtkIdType(texturePixels) * texturePixels);
  grey->Fill(0.5);
  image->GetPointData()->SetScalars(grey);
  render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("1024 x 1024 x 1 pixels of 1 components"), std::string::npos)
    << messages.errors[0];
}

// One picture for each convention of VTK's volume mappers, on adaptive data, named after VTK's test of it. Each is compared
// with a baseline in Testing/Data/Baseline, and so is the scene without any one of the settings that make the convention,
// which has to be another picture.
#include "ConventionStage.h"

#include "vtkContourValues.h"
#include "vtkLightKit.h"
#include "vtkPNGReader.h"
#include "vtkPNGWriter.h"
#include "vtkPlane.h"
#include "vtkPointData.h"
#include "vtkTransform.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVersionMacros.h"
#include "vtkWindowToImageFilter.h"

#include <cstdlib>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

using namespace treeamr::test;

namespace
{

using Setting = std::function<void(ConventionStage&)>;

struct Convention
{
  std::string name;
  /// What there has to be for the settings to have an effect.
  Setting prepare;
  /// Each is seen.
  std::vector<Setting> settings;
};
using Conventions = std::vector<Convention>;

std::ostream& operator<<(std::ostream& os, const Convention& convention)
{
  return os << convention.name;
}

void prepareNothing(ConventionStage& /*stage*/) {}

Setting blend(int mode)
{
  return [mode](ConventionStage& stage) { stage.mapper()->SetBlendMode(mode); };
}

Setting select(const char* array)
{
  return [array](ConventionStage& stage) { stage.mapper()->SelectScalarArray(array); };
}

Setting opacityOf(int component)
{
  return [component](ConventionStage& stage) {
    stage.property()->SetScalarOpacityUnitDistance(component, 0.5 * ConventionStage::unitDistance);
  };
}

void shade(ConventionStage& stage)
{
  vtkVolumeProperty* property = stage.property();
  property->ShadeOn();
  property->SetAmbient(0.2);
  property->SetDiffuse(0.7);
  property->SetSpecular(0.4);
  property->SetSpecularPower(10.);
}

void fadeEvenParts(ConventionStage& stage)
{
  vtkNew<vtkPiecewiseFunction> function;
  function->AddPoint(0., 0.);
  function->AddPoint(0.04, 0.);
  function->AddPoint(0.09, 1.);
  stage.property()->SetGradientOpacity(function);
}

Setting useTable(int stripes)
{
  return [stripes](ConventionStage& stage) {
    stage.property()->SetTransferFunction2D(ConventionStage::makeTable(stripes));
    stage.property()->SetTransferFunctionMode(vtkVolumeProperty::TF_2D);
  };
}

Conventions blendModes()
{
  return {
    { "TestGPURayCastAdditive", prepareNothing, { blend(vtkVolumeMapper::ADDITIVE_BLEND) } },
    { "TestGPURayCastAverageIP", prepareNothing,
      { blend(vtkVolumeMapper::AVERAGE_INTENSITY_BLEND),
        [](ConventionStage& stage) { stage.mapper()->SetAverageIPScalarRange(0.5, 0.9); } } },
    { "TestGPURayCastDataTypesMIP", prepareNothing, { blend(vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND) } },
    { "TestGPURayCastDataTypesMinIP", select("waves"), { blend(vtkVolumeMapper::MINIMUM_INTENSITY_BLEND) } },
    { "TestGPURayCastNearestDataTypesMIP", select("waves"),
      { blend(vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND),
        [](ConventionStage& stage) { stage.property()->SetInterpolationTypeToNearest(); } } },
    { "TestGPURayCastIsosurface", shade,
      { blend(vtkVolumeMapper::ISOSURFACE_BLEND),
        [](ConventionStage& stage) {
          stage.property()->GetIsoSurfaceValues()->SetValue(0, 0.35);
          stage.property()->GetIsoSurfaceValues()->SetValue(1, 0.75);
        } } },
    { "IsosurfaceInVolume",
      [](ConventionStage& stage) { stage.property()->GetIsoSurfaceValues()->SetValue(0, 0.6); },
      { [](ConventionStage& stage) { stage.mapper()->ShowIsosurfacesOn(); },
        [](ConventionStage& stage) { stage.mapper()->ShadeIsosurfacesOn(); },
        [](ConventionStage& stage) { stage.mapper()->SetIsosurfaceOpacityScale(1.7); } } },
    { "TestGPURayCastSlicePlane",
      [](ConventionStage& stage) {
        vtkNew<vtkPlane> plane;
        stage.property()->SetSliceFunction(plane);
        stage.property()->GetScalarOpacity()->AddPoint(0., 0.4);
      },
      { blend(vtkVolumeMapper::SLICE_BLEND),
        [](ConventionStage& stage) {
          auto* plane = vtkPlane::SafeDownCast(stage.property()->GetSliceFunction());
          plane->SetOrigin(0., -0.2, 0.1);
          plane->SetNormal(0.3, 0.8, 0.5);
        } } },
  };
}

Conventions light()
{
  return {
    { "TestGPURayCastGradientOpacity", prepareNothing, { fadeEvenParts } },
    { "TestGPURayCastGradientOpacityLight", prepareNothing, { fadeEvenParts, shade } },
    { "TestGPURayCastPositionalLights", shade,
      { [](ConventionStage& stage) {
         stage.addLight({ 1.5, 1.5, 2. }, { 1., 0.9, 0.6 });
       },
        [](ConventionStage& stage) {
          stage.addLight({ -2., 0.5, 1. }, { 0.3, 0.5, 1. })->PositionalOn();
        },
        [](ConventionStage& stage) {
          for (vtkLight* light : stage.lights)
          {
            light->PositionalOn();
            light->SetConeAngle(20.);
            light->SetAttenuationValues(0.3, 0.2, 0.05);
          }
        } } },
    { "TestGPURayCastVolumeLightKit", prepareNothing,
      { shade,
        [](ConventionStage& stage) {
          stage.scene.renderer->RemoveAllLights();
          vtkNew<vtkLightKit> kit;
          kit->SetKeyLightWarmth(1.);
          kit->SetFillLightWarmth(0.);
          kit->AddLightsToRenderer(stage.scene.renderer);
        },
        [](ConventionStage& stage) { stage.scene.renderer->TwoSidedLightingOff(); } } },
    { "TestGPURayCastMapperShadows",
      [](ConventionStage& stage) {
        shade(stage);
        stage.addLight({ 2., 3., 1. }, { 1., 1., 1. });
      },
      { [](ConventionStage& stage) { stage.mapper()->SetVolumetricScatteringBlending(2.f); },
        [](ConventionStage& stage) { stage.mapper()->SetGlobalIlluminationReach(1.f); } } },
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0) // before, volumes' properties have none
    { "ScatteringAnisotropy",
      [](ConventionStage& stage) {
        shade(stage);
        stage.addLight({ -2., -2., -3. }, { 1., 1., 1. });
        stage.mapper()->SetVolumetricScatteringBlending(2.f);
        stage.mapper()->SetGlobalIlluminationReach(0.5f);
      },
      { [](ConventionStage& stage) { stage.property()->SetScatteringAnisotropy(0.7f); } } },
#endif
  };
}

void useIndependentComponents(ConventionStage& stage)
{
  stage.mapper()->SetVectorMode(vtkTreeAMRVolumeMapper::DISABLED);
}

void useDependentComponents(ConventionStage& stage)
{
  stage.property()->IndependentComponentsOff();
}

Setting functionsOfComponent(int component, const Color& color)
{
  return [component, color](ConventionStage& stage) {
    vtkNew<vtkColorTransferFunction> colors;
    colors->AddRGBPoint(0., 0.2, 0.2, 0.2);
    colors->AddRGBPoint(1., color[0], color[1], color[2]);
    vtkNew<vtkPiecewiseFunction> opacities;
    opacities->AddPoint(0.6, 0.);
    opacities->AddPoint(1., 0.5);
    stage.property()->SetColor(component, colors);
    stage.property()->SetScalarOpacity(component, opacities);
    stage.property()->SetScalarOpacityUnitDistance(component, ConventionStage::unitDistance);
  };
}

Conventions components()
{
  const auto weigh = [](ConventionStage& stage) { stage.property()->SetComponentWeight(0, 0.2); };
  return {
    { "TestGPURayCastCellData", prepareNothing, { select("waves") } },
    { "TestGPURayCastIndependentVectorMode", select("triple"),
      { [](ConventionStage& stage) { stage.mapper()->SetVectorMode(vtkTreeAMRVolumeMapper::COMPONENT); },
        [](ConventionStage& stage) { stage.mapper()->SetVectorComponent(1); } } },
    { "TestGPURayCastTwoComponentsDependent", select("pair"), { useDependentComponents, opacityOf(1) } },
    { "TestGPURayCastTwoComponentsDependentGradient",
      [](ConventionStage& stage) {
        stage.mapper()->SelectScalarArray("pair");
        opacityOf(1)(stage);
      },
      { useDependentComponents, fadeEvenParts } },
    { "TestGPURayCastFourComponentsDependentGradient", select("rgba"),
      { useDependentComponents, opacityOf(3), fadeEvenParts } },
    { "TestGPURayCastDependentComponentsLightParameters",
      [](ConventionStage& stage) {
        stage.mapper()->SelectScalarArray("pair");
        useDependentComponents(stage);
        opacityOf(1)(stage);
      },
      { shade } },
    { "TestGPURayCastTwoComponentsIndependent", select("pair"),
      { useIndependentComponents, functionsOfComponent(1, { 0.2, 1., 0.2 }) } },
    { "TestGPURayCastThreeComponentsIndependent", select("triple"),
      { useIndependentComponents, functionsOfComponent(1, { 0.2, 1., 0.2 }),
        functionsOfComponent(2, { 1., 0.2, 1. }), weigh } },
    { "TestGPURayCastIndependentComponentsLightParameters",
      [](ConventionStage& stage) {
        stage.mapper()->SelectScalarArray("triple");
        useIndependentComponents(stage);
        functionsOfComponent(1, { 0.2, 1., 0.2 })(stage);
        functionsOfComponent(2, { 1., 0.2, 1. })(stage);
      },
      { shade, [](ConventionStage& stage) { stage.property()->SetAmbient(1, 0.7); },
        [](ConventionStage& stage) { stage.property()->SetDiffuse(0, 0.); } } },
    { "SeparateOpacityArray", prepareNothing,
      { [](ConventionStage& stage) { stage.mapper()->SetOpacityArrayName("waves"); } } },
  };
}

Conventions functions()
{
  return {
    { "TestGPURayCastTransfer2D", prepareNothing, { useTable(1) } },
    { "TestGPURayCastTransfer2DYScalars", prepareNothing,
      { useTable(1), [](ConventionStage& stage) { stage.mapper()->SetTransfer2DYAxisArray("waves"); },
        [](ConventionStage& stage) { stage.mapper()->SetTransfer2DRange(0.2, 0.8, 0.1, 0.9); } } },
    { "TestGPURayCastLargeColorTransferFunction", prepareNothing, { [](ConventionStage& stage) {
       constexpr int bands = 24;
       for (int i = 0; i < 100 * bands; ++i)
       {
         const bool isDark = i / 100 % 2 == 0;
         const double value = i / (100. * bands);
         stage.property()->GetRGBTransferFunction()->AddRGBPoint(value, isDark ? 0.1 : 1., value, 0.3);
       }
     } } },
    { "ColorSpaces",
      [](ConventionStage& stage) {
        vtkColorTransferFunction* colors = stage.property()->GetRGBTransferFunction();
        colors->RemoveAllPoints();
        colors->AddRGBPoint(0.2, 0., 0.9, 0.2);
        colors->AddRGBPoint(0.9, 0.9, 0.1, 0.4, 0.3, 0.);
      },
      { [](ConventionStage& stage) { stage.property()->GetRGBTransferFunction()->SetColorSpaceToHSV(); },
        [](ConventionStage& stage) { stage.property()->GetScalarOpacity()->UseLogScaleOn(); } } },
    { "IndexedLookup", [](ConventionStage& stage) { stage.mapper()->SelectScalarArray("class"); },
      { [](ConventionStage& stage) {
        vtkColorTransferFunction* colors = stage.property()->GetRGBTransferFunction();
        for (const double category : { 0., 1., 2. })
        {
          colors->SetAnnotation(category, std::to_string(static_cast<int>(category)));
        }
        colors->IndexedLookupOn();
      } } },
    { "ScalarOpacityUnitDistance", prepareNothing,
      { [](ConventionStage& stage) { stage.property()->SetScalarOpacityUnitDistance(0.08); } } },
    { "TestFinalColorWindowLevel", prepareNothing,
      { [](ConventionStage& stage) { stage.mapper()->SetFinalColorWindow(0.5); },
        [](ConventionStage& stage) { stage.mapper()->SetFinalColorLevel(0.3); } } },
  };
}

Setting clip(const Point& origin, const Point& normal)
{
  return [=](ConventionStage& stage) {
    vtkNew<vtkPlane> plane;
    plane->SetOrigin(origin[0], origin[1], origin[2]);
    plane->SetNormal(normal[0], normal[1], normal[2]);
    stage.mapper()->AddClippingPlane(plane);
  };
}

void turn(ConventionStage& stage)
{
  vtkNew<vtkTransform> transform;
  transform->RotateWXYZ(70., 0.3, 1., 0.5);
  transform->Scale(1.2, 0.6, 1.);
  stage.volume->SetUserTransform(transform);
}

Conventions cuts()
{
  return {
    { "TestGPURayCastClipping", prepareNothing,
      { clip({ 0.1, 0., 0.2 }, { -0.5, 0., -1. }), clip({ 0., -0.2, 0. }, { 0., 1., 0. }) } },
    { "TestGPURayCastShadedClipping", prepareNothing, { shade, clip({ 0.1, 0., 0.2 }, { -0.5, 0., -1. }) } },
    { "TestGPURayCastClippingUserTransform", prepareNothing,
      { turn, clip({ 0., 0., 0.1 }, { 0., -0.2, -1. }) } },
    { "TestGPURayCastCropping", prepareNothing,
      { [](ConventionStage& stage) { stage.mapper()->CroppingOn(); },
        [](ConventionStage& stage) {
          stage.mapper()->SetCroppingRegionPlanes(-0.3, 0.4, -0.2, 0.4, -0.2, 0.35);
        },
        [](ConventionStage& stage) { stage.mapper()->SetCroppingRegionFlagsToInvertedFence(); } } },
    { "TestGPURayCastCameraInside", prepareNothing, { [](ConventionStage& stage) {
       vtkCamera* camera = stage.scene.renderer->GetActiveCamera();
       camera->SetPosition(-0.9, 0.3, 0.9);
       camera->SetViewAngle(70.);
       stage.scene.renderer->ResetCameraClippingRange();
     } } },
    { "TestGPURayCastPerspectiveParallel", prepareNothing,
      { [](ConventionStage& stage) { stage.scene.renderer->GetActiveCamera()->ParallelProjectionOn(); } } },
  };
}

Conventions samples()
{
  return {
    { "TestGPURayCastImageSampleXY",
      [](ConventionStage& stage) {
        shade(stage);
        stage.mapper()->SetBlendModeToIsoSurface();
        stage.property()->GetIsoSurfaceValues()->SetValue(0, 0.6);
      },
      { [](ConventionStage& stage) { stage.mapper()->SetImageSampleDistance(6.); },
        [](ConventionStage& stage) { stage.mapper()->AutoAdjustSampleDistancesOff(); } } },
    { "TestGPURayCastMapperSampleDistance", useTable(9),
      { [](ConventionStage& stage) { stage.mapper()->SetSampleDistance(20.); } } },
  };
}

Conventions others()
{
  const auto peel = [](ConventionStage& stage) {
    stage.scene.renderer->UseDepthPeelingOn();
    stage.scene.renderer->UseDepthPeelingForVolumesOn();
  };
  const auto addRectangle = [](double opacity) {
    return [opacity](ConventionStage& stage) {
      stage.scene.addRectangle(
        { 0.2, 0.1, 0.2 }, { 0.7, 0., -0.4 }, { 0., 0.7, 0.1 }, { 0.3, 0.7, 0.4 }, opacity);
    };
  };
  const auto addOther = [](const Point& place) {
    return [place](ConventionStage& stage) {
      vtkVolume* other = stage.addVolume();
      stage.colorGreen(other);
      other->SetPosition(place[0], place[1], place[2]);
      other->SetScale(0.8);
    };
  };
  return {
    { "TestGPURayCastVolumePolyData", prepareNothing, { addRectangle(1.) } },
    { "TestGPURayCastDepthPeelingTransparentPolyData", prepareNothing, { addRectangle(0.5), peel } },
    { "TestGPURayCastMultiVolumeOverlapping", prepareNothing,
      { addOther({ -0.3, 0.1, 0.3 }), addOther({ 0.6, -0.5, 0.2 }) } },
  };
}

Conventions all()
{
  Conventions result;
  for (Conventions (*some)() : { blendModes, light, components, functions, cuts, samples, others })
  {
    const Conventions part = some();
    result.insert(result.end(), part.begin(), part.end());
  }
  return result;
}

/// RGB, rows from below.
using Pixels = std::vector<unsigned char>;

Pixels pixelsOf(vtkImageData* image)
{
  vtkDataArray* array = image->GetPointData()->GetScalars();
  if (!array || array->GetNumberOfComponents() != 3)
  {
    return {};
  }
  auto* bytes = vtkUnsignedCharArray::SafeDownCast(array)->GetPointer(0);
  return { bytes, bytes + array->GetNumberOfValues() };
}

/// Where a channel is off by more than any instruction set or release of VTK makes of a picture.
double shareOfOtherPixels(const Pixels& a, const Pixels& b)
{
  constexpr int roundings = 6; // of 255
  if (a.size() != b.size())
  {
    return 1.;
  }
  int others = 0;
  for (std::size_t i = 0; i < a.size(); i += 3)
  {
    others += std::abs(a[i] - b[i]) > roundings || std::abs(a[i + 1] - b[i + 1]) > roundings ||
      std::abs(a[i + 2] - b[i + 2]) > roundings;
  }
  return 3. * others / static_cast<double>(a.size());
}

constexpr double mostOfTheSame = 0.002;
constexpr double leastOfAnother = 0.02;

class ConventionImageTest
  : public RenderingTest
  , public ::testing::WithParamInterface<Convention>
{
protected:
  /// leftOut: of the settings. What is then said is not this test's.
  static vtkSmartPointer<vtkImageData> draw(const Convention& convention, std::size_t leftOut)
  {
    ConventionStage stage;
    const bool isWhole = leftOut >= convention.settings.size();
    const MessageCounter messages(stage.mapper());
    convention.prepare(stage);
    for (std::size_t i = 0; i < convention.settings.size(); ++i)
    {
      if (i != leftOut)
      {
        convention.settings[i](stage);
      }
    }
    vtkNew<vtkWindowToImageFilter> capture;
    capture->SetInput(stage.scene.window);
    capture->ReadFrontBufferOff();
    capture->Update();
    EXPECT_TRUE(messages.errors.empty());
    EXPECT_TRUE(!isWhole || messages.warnings.empty()) << messages.warnings.front();
    return capture->GetOutput();
  }
};

} // namespace

TEST_P(ConventionImageTest, everySettingIsInTheBaseline)
{
  const Convention& convention = GetParam();
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName((std::string(TREEAMR_BASELINE_DIR) + "/" + convention.name + ".png").c_str());
  Pixels baseline; // empty: no file
  if (reader->CanReadFile(reader->GetFileName()))
  {
    reader->Update();
    baseline = pixelsOf(reader->GetOutput());
  }
  const std::size_t count = convention.settings.size();
  const auto whole = draw(convention, count);
  const double other = shareOfOtherPixels(pixelsOf(whole), baseline);
  EXPECT_LE(other, mostOfTheSame) << reader->GetFileName();
  if (other > mostOfTheSame)
  {
    vtkNew<vtkPNGWriter> writer;
    writer->SetFileName((std::string(TREEAMR_TEST_OUTPUT_DIR) + "/" + convention.name + ".png").c_str());
    writer->SetInputData(whole);
    writer->SetCompressionLevel(9);
    writer->Write();
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    EXPECT_GE(shareOfOtherPixels(pixelsOf(draw(convention, i)), baseline), leastOfAnother)
      << "without setting " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(
  Volumes, ConventionImageTest, ::testing::ValuesIn(all()), [](const auto& test) { return test.param.name; });

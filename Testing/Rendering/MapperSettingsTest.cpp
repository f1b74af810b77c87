// Settings of the mappers as VTK's classes have them: copied, followed, and said to be without effect where they are.
#include "NewerSettings.h"
#include "PlaneSurface.h"

#include "vtkActorCollection.h"
#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkHardwareSelector.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPlane.h"
#include "vtkSelection.h"
#include "vtkShaderProperty.h"
#include "vtkTexture.h"

#include <functional>
#include <sstream>

using namespace treeamr::test;

namespace
{

/// What PrintSelf() says, but for what no two objects have in common.
std::string settingsOf(vtkObject* object)
{
  std::stringstream text;
  object->Print(text);
  std::string settings;
  for (std::string line; std::getline(text, line);)
  {
    bool isOwn = false;
    for (const char* own : { "0x", "Modified Time", "Reference Count", "Progress", "TimeToDraw",
           "Time To Draw", "Executive", "BuildTime", "Build Time" })
    {
      isOwn = isOwn || line.find(own) != std::string::npos;
    }
    settings += isOwn ? "" : line + "\n";
  }
  return settings;
}

/// A volume and an isosurface beside it.
class MapperSettingsTest : public PlaneSurfaceTest
{
protected:
  MapperSettingsTest()
    : grid_(planeGrid())
    , volume_(scene_.addVolume(grid_, "x", { 1., 0.8, 0.6 }, 2.))
    , surface_(scene_.addIsosurface(grid_, "plane", 0.))
    , volumeMapper_(Scene::mapperOf(volume_))
    , surfaceMapper_(Scene::mapperOf(surface_))
  {
    surface_->SetPosition(2.5, 0., 0.);
    scene_.setCamera();
  }

  Scene scene_;
  vtkSmartPointer<vtkHyperTreeGrid> grid_;
  vtkVolume* volume_;
  vtkActor* surface_;
  vtkTreeAMRVolumeMapper* volumeMapper_;
  vtkTreeAMRIsosurfaceMapper* surfaceMapper_;
};

} // namespace

TEST_F(MapperSettingsTest, shallowCopies)
{
  vtkNew<vtkPlane> plane;
  volumeMapper_->SelectScalarArray("y");
  volumeMapper_->SetVectorMode(vtkTreeAMRVolumeMapper::COMPONENT);
  volumeMapper_->SetVectorComponent(2);
  volumeMapper_->SetTransfer2DYAxisArray("x");
  volumeMapper_->SetTransfer2DYAxisComponent(1);
  volumeMapper_->SetTransfer2DRange(1., 2., 3., 4.);
  volumeMapper_->SetSamplesPerCell(5.);
  volumeMapper_->SetSampleDistance(0.3);
  volumeMapper_->LockSampleDistanceToInputSpacingOn();
  volumeMapper_->UseJitteringOn();
  volumeMapper_->SetFinalColorWindow(0.9);
  volumeMapper_->SetFinalColorLevel(0.4);
  volumeMapper_->ReportProgressOff();
  volumeMapper_->SetVertexCacheSize(77);
  volumeMapper_->SkipEmptySpaceOff();
  volumeMapper_->AutoAdjustSampleDistancesOff();
  volumeMapper_->SetImageSampleDistance(2.);
  volumeMapper_->SetMinimumImageSampleDistance(3.);
  volumeMapper_->SetMaximumImageSampleDistance(4.);
  volumeMapper_->SetInteractiveRenderTime(0.5);
  volumeMapper_->SetLevelOfDetail(6.);
  volumeMapper_->EstimateErrorOn();
  volumeMapper_->SetTargetError(0.01);
  volumeMapper_->ShowIsosurfacesOn();
  volumeMapper_->SetIsosurfaceOpacityScale(0.7);
  volumeMapper_->SetAmbientOcclusionSamples(7);
  volumeMapper_->SetAmbientOcclusionRadius(0.3);
  volumeMapper_->ShadowsOn();
  volumeMapper_->SetBlendModeToIsoSurface();
  volumeMapper_->CroppingOn();
  volumeMapper_->SetCroppingRegionPlanes(1., 2., 3., 4., 5., 6.);
  volumeMapper_->SetCroppingRegionFlags(VTK_CROP_CROSS);
  treeamr::computeNormalFromOpacity(*volumeMapper_, true);
  volumeMapper_->AddClippingPlane(plane);
  vtkNew<vtkTreeAMRVolumeMapper> volumeCopy;
  volumeCopy->ShallowCopy(volumeMapper_);
  EXPECT_EQ(settingsOf(volumeCopy), settingsOf(volumeMapper_));
  EXPECT_EQ(volumeCopy->GetHyperTreeGrid(), grid_);
  volumeMapper_->SelectScalarArray(1);
  volumeCopy->ShallowCopy(volumeMapper_);
  EXPECT_EQ(settingsOf(volumeCopy), settingsOf(volumeMapper_));

  surfaceMapper_->SetValue(0, 0.1);
  surfaceMapper_->SetValue(1, 0.2);
  surfaceMapper_->SetIsosurfaceComponent(0);
  surfaceMapper_->SetCompositeIndex(9);
  surfaceMapper_->SetAmbientOcclusionSamples(7);
  surfaceMapper_->SetAmbientOcclusionRadius(0.3);
  surfaceMapper_->ShadowsOn();
  surfaceMapper_->AutoAdjustSampleDistancesOff();
  surfaceMapper_->SetImageSampleDistance(2.);
  surfaceMapper_->SetMinimumImageSampleDistance(3.);
  surfaceMapper_->SetMaximumImageSampleDistance(4.);
  surfaceMapper_->SetInteractiveRenderTime(0.5);
  surfaceMapper_->SetLevelOfDetail(0.25);
  surfaceMapper_->SetColorModeToDirectScalars();
  vtkNew<vtkTreeAMRIsosurfaceMapper> surfaceCopy;
  surfaceCopy->ShallowCopy(surfaceMapper_);
  EXPECT_EQ(settingsOf(surfaceCopy), settingsOf(surfaceMapper_));
  EXPECT_EQ(surfaceCopy->GetHyperTreeGrid(), grid_);
  // The contoured array, too: the same picture.
  surfaceMapper_->SetColorModeToDefault();
  surfaceMapper_->SetImageSampleDistance(1.);
  volume_->VisibilityOff();
  const auto expected = scene_.render();
  surfaceCopy->ShallowCopy(surfaceMapper_);
  surface_->SetMapper(surfaceCopy);
  EXPECT_EQ(scene_.render(), expected);

  vtkNew<vtkTreeAMRVolumeMapper> empty;
  volumeCopy->ShallowCopy(empty);
  EXPECT_EQ(volumeCopy->GetHyperTreeGrid(), nullptr);
}

// As vtkPolyDataMapper follows its input: the grid alone is marked.
TEST_F(MapperSettingsTest, valuesChangedInPlace)
{
  const auto before = scene_.render();
  for (const char* name : { "x", "plane" })
  {
    vtkDataArray* array = grid_->GetCellData()->GetArray(name);
    for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
    {
      array->SetTuple1(i, array->GetTuple1(i) + 0.3);
    }
  }
  EXPECT_EQ(scene_.render(), before);
  grid_->Modified();
  const auto after = scene_.render();
  EXPECT_NE(after, before);
  Scene fresh;
  vtkNew<vtkHyperTreeGrid> copy;
  copy->DeepCopy(grid_);
  fresh.addVolume(copy, "x", { 1., 0.8, 0.6 }, 2.);
  fresh.addIsosurface(copy, "plane", 0.)->SetPosition(2.5, 0., 0.);
  fresh.setCamera();
  EXPECT_EQ(fresh.render(), after);
}

TEST_F(MapperSettingsTest, volumeSettingsWithoutEffect)
{
  MessageCounter messages(volumeMapper_);
  vtkVolumeProperty* property = volume_->GetProperty();
  vtkNew<vtkPiecewiseFunction> function;
  function->AddPoint(0., 0.);
  function->AddPoint(1., 1.);
  vtkNew<vtkColorTransferFunction> colors;
  const auto expected = scene_.render();
  property->GetGradientOpacity(); // makes one, 1 everywhere
  EXPECT_EQ(scene_.render(), expected);
  EXPECT_TRUE(messages.warnings.empty());
  std::vector<std::pair<std::string, std::function<void()>>> settings{
    { "UseJittering", [&] { volumeMapper_->UseJitteringOn(); } },
    { "TransferFunctionMode TF_2D: without effect, needed are a TransferFunction2D",
      [&] { property->SetTransferFunctionMode(vtkVolumeProperty::TF_2D); } },
    { "IndependentComponents off: without effect, needed is an array of 2 components",
      [&] { property->IndependentComponentsOff(); } },
    { "SetColor(1, ...): without effect, needed are VectorMode DISABLED",
      [&] { property->SetColor(1, colors); } },
    { "ComponentWeight: without effect, needed are VectorMode DISABLED",
      [&] { property->SetComponentWeight(0, 0.5); } },
    { "LabelScalarOpacity", [&] { property->SetLabelScalarOpacity(1, function); } },
    { "UseClippedVoxelIntensity", [&] { property->UseClippedVoxelIntensityOn(); } },
    { "VolumetricScatteringBlending: without effect, needed is Shade",
      [&] { volumeMapper_->SetVolumetricScatteringBlending(1.f); } },
    { "ShaderProperty",
      [&] { volume_->GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Color", true, "//", true); } },
  };
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)
  settings.emplace_back("ComputeNormalFromOpacity", [&] { volumeMapper_->ComputeNormalFromOpacityOn(); });
  settings.emplace_back("ScatteringAnisotropy", [&] { property->SetScatteringAnisotropy(0.5f); });
#endif
  for (const auto& [name, set] : settings)
  {
    messages.warnings.clear();
    set();
    EXPECT_EQ(scene_.render(), expected) << name;
    scene_.render();
    ASSERT_EQ(messages.warnings.size(), 1u) << name;
    EXPECT_NE(messages.warnings[0].find(name), std::string::npos) << messages.warnings[0];
  }
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(MapperSettingsTest, isosurfacesAreOfTheContinuousFieldInNearestVolumes)
{
  MessageCounter messages(volumeMapper_);
  volumeMapper_->SetBlendModeToIsoSurface();
  vtkVolumeProperty* property = volume_->GetProperty();
  property->GetIsoSurfaceValues()->SetValue(0, 0.2);
  const auto expected = scene_.render();
  EXPECT_TRUE(messages.warnings.empty());
  property->SetInterpolationTypeToNearest();
  EXPECT_EQ(scene_.render(), expected);
  scene_.render();
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("InterpolationType Nearest"), std::string::npos)
    << messages.warnings[0];
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(MapperSettingsTest, planesBetweenWhichNothingIsAreSaid)
{
  MessageCounter messages(volumeMapper_);
  volumeMapper_->CroppingOn();
  volumeMapper_->SetCroppingRegionPlanes(0., 1., 0., 1., 0., 1.);
  const auto shown = scene_.render();
  volumeMapper_->SetCroppingRegionFlags(0);
  const auto nothing = scene_.render();
  ASSERT_NE(nothing, shown);
  volumeMapper_->SetCroppingRegionFlagsToSubVolume();
  EXPECT_TRUE(messages.warnings.empty());
  for (const double upper : { 0., -1. })
  {
    messages.warnings.clear();
    volumeMapper_->SetCroppingRegionPlanes(0., 1., 0., 1., 0., 1.);
    scene_.render();
    volumeMapper_->SetCroppingRegionPlanes(0., 1., 0., upper, 0., 1.);
    EXPECT_EQ(scene_.render(), nothing) << upper;
    scene_.render();
    ASSERT_EQ(messages.warnings.size(), 1u) << upper;
    EXPECT_NE(messages.warnings[0].find("CroppingRegionPlanes"), std::string::npos) << messages.warnings[0];
  }
  EXPECT_TRUE(messages.errors.empty());
}

// A selection is made for whatever else there is, and passes through volumes without a word.
TEST_F(MapperSettingsTest, selectionsPassThroughVolumes)
{
  MessageCounter messages(volumeMapper_);
  scene_.render();
  vtkNew<vtkHardwareSelector> selector;
  selector->SetRenderer(scene_.renderer);
  const auto select = [&](vtkActor* alone) {
    surface_->SetVisibility(alone != nullptr);
    const int* size = scene_.renderer->GetSize();
    selector->SetArea(0, 0, size[0] - 1, size[1] - 1);
    return vtkSmartPointer<vtkSelection>::Take(selector->Select())->GetNumberOfNodes();
  };
  EXPECT_EQ(select(nullptr), 0u);
  EXPECT_EQ(select(surface_), 1u);
  EXPECT_TRUE(messages.errors.empty());
  EXPECT_TRUE(messages.warnings.empty());
}

TEST_F(MapperSettingsTest, lightAndBlendModesHaveAnEffectWithoutAWord)
{
  MessageCounter messages(volumeMapper_);
  vtkVolumeProperty* property = volume_->GetProperty();
  vtkNew<vtkPiecewiseFunction> function;
  function->AddPoint(0., 0.1);
  function->AddPoint(0.1, 0.5);
  vtkNew<vtkPiecewiseFunction> opacities;
  opacities->AddPoint(-1., 0.1);
  opacities->AddPoint(1., 0.8);
  property->SetScalarOpacity(opacities);
  auto last = scene_.render();
  const auto expectOther = [&](const char* name) {
    const auto picture = scene_.render();
    EXPECT_TRUE(picture != last) << name;
    last = picture;
  };
  property->ShadeOn();
  expectOther("Shade");
  property->SetDiffuse(0.3);
  expectOther("Diffuse");
  property->SetGradientOpacity(function);
  expectOther("GradientOpacity");
  for (const int mode : { vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND, vtkVolumeMapper::MINIMUM_INTENSITY_BLEND,
         vtkVolumeMapper::AVERAGE_INTENSITY_BLEND, vtkVolumeMapper::ADDITIVE_BLEND })
  {
    volumeMapper_->SetBlendMode(mode);
    expectOther("BlendMode");
  }
  property->DisableGradientOpacityOn();
  volumeMapper_->SetBlendModeToComposite();
  expectOther("DisableGradientOpacity");
  property->SetInterpolationTypeToNearest();
  expectOther("InterpolationType");
  vtkNew<vtkPlane> plane;
  plane->SetNormal(0.2, 0.5, 0.9);
  property->SetSliceFunction(plane);
  volumeMapper_->SetBlendModeToSlice();
  expectOther("slice BlendMode");
  plane->SetOrigin(0.2, 0.3, 0.2);
  expectOther("SliceFunction");
  volumeMapper_->SetBlendMode(vtkVolumeMapper::ADDITIVE_BLEND);
  last = scene_.render();
  // What such pictures cannot hold, or categories not have, is said.
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("GradientOpacity with the maximum"), std::string::npos);
  volumeMapper_->ShowIsosurfacesOn();
  EXPECT_TRUE(scene_.render() == last);
  ASSERT_EQ(messages.warnings.size(), 2u);
  EXPECT_NE(messages.warnings[1].find("ShowIsosurfaces"), std::string::npos);
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(MapperSettingsTest, surfaceSettingsWithoutEffect)
{
  MessageCounter messages(surfaceMapper_);
  vtkProperty* property = surface_->GetProperty();
  vtkNew<vtkProperty> backface;
  vtkNew<vtkTexture> texture;
  texture->UseSRGBColorSpaceOn(); // or VTK refuses it
  const auto expected = scene_.render();
  EXPECT_TRUE(messages.warnings.empty());
  const std::vector<std::pair<std::string, std::function<void()>>> settings{
    { "Wireframe", [&] { property->SetRepresentationToWireframe(); } },
    { "Points", [&] { property->SetRepresentationToPoints(); } },
    { "EdgeVisibility", [&] { property->EdgeVisibilityOn(); } },
    { "VertexVisibility", [&] { property->VertexVisibilityOn(); } },
    { "PBR", [&] { property->SetInterpolationToPBR(); } },
    { "BackfaceCulling", [&] { property->BackfaceCullingOn(); } },
    { "FrontfaceCulling", [&] { property->FrontfaceCullingOn(); } },
    { "BackfaceProperty", [&] { surface_->SetBackfaceProperty(backface); } },
    { "Texture", [&] { property->SetTexture("albedoTex", texture); } },
    { "RelativeCoincidentTopology",
      [&] { surfaceMapper_->SetRelativeCoincidentTopologyPolygonOffsetParameters(1., 1.); } },
    { "ShaderProperty",
      [&] {
        surface_->GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Color", true, "//", true);
      } },
  };
  for (const auto& [name, set] : settings)
  {
    messages.warnings.clear();
    set();
    EXPECT_EQ(scene_.render(), expected) << name;
    scene_.render();
    ASSERT_EQ(messages.warnings.size(), 1u) << name;
    EXPECT_NE(messages.warnings[0].find(name), std::string::npos) << messages.warnings[0];
  }
}

// What was asked and what is allowed, each time; the nearest is taken.
TEST_F(MapperSettingsTest, valuesOutOfRangeAreTold)
{
  const auto told = [](vtkObject* mapper, const auto& set) {
    const MessageCounter messages(mapper);
    set();
    return messages.warnings.empty() ? std::string() : messages.warnings.front();
  };
  const auto expectTold = [&](vtkObject* mapper, const auto& set, const char* part) {
    const std::string message = told(mapper, set);
    EXPECT_NE(message.find(part), std::string::npos) << message << ", should say " << part;
  };
  vtkTreeAMRVolumeMapper* const volume = volumeMapper_;
  expectTold(
    volume, [&] { volume->SetSamplesPerCell(1e6); }, "SamplesPerCell 1e+06, allowed are 0.01 to 1024");
  EXPECT_EQ(volume->GetSamplesPerCell(), 1024.);
  expectTold(
    volume, [&] { volume->SetSamplesPerCell(-1.); }, "SamplesPerCell -1, allowed are 0.01 to 1024");
  EXPECT_EQ(volume->GetSamplesPerCell(), 0.01);
  expectTold(
    volume, [&] { volume->SetVertexCacheSize(-5); }, "VertexCacheSize -5, allowed are 0 to");
  EXPECT_EQ(volume->GetVertexCacheSize(), 0);
  expectTold(
    volume, [&] { volume->SetImageSampleDistance(0.); }, "ImageSampleDistance 0, allowed are 1 to 100");
  EXPECT_EQ(volume->GetImageSampleDistance(), 1.);
  expectTold(
    volume, [&] { volume->SetTargetError(-1.); }, "TargetError -1, allowed are 0 to");
  EXPECT_EQ(volume->GetTargetError(), 0.);
  vtkTreeAMRIsosurfaceMapper* const surface = surfaceMapper_;
  expectTold(
    surface, [&] { surface->SetMaximumImageSampleDistance(1000.); },
    "MaximumImageSampleDistance 1000, allowed are 1 to 100");
  EXPECT_EQ(surface->GetMaximumImageSampleDistance(), 100.);
  expectTold(
    surface, [&] { surface->SetAmbientOcclusionSamples(-1); },
    "AmbientOcclusionSamples -1, allowed are 0 to 65535");
  EXPECT_EQ(surface->GetAmbientOcclusionSamples(), 0);

  EXPECT_EQ(told(volume, [&] { volume->SetSamplesPerCell(1024.); }), "");
  const vtkMTimeType time = volume->GetMTime();
  EXPECT_EQ(told(volume, [&] { volume->SetSamplesPerCell(1024.); }), "");
  EXPECT_EQ(volume->GetMTime(), time);
}

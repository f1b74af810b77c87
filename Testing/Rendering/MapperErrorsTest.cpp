// What a mapper cannot draw: one message, an untouched image, no crash, and the next good input is drawn.
#include "CornerArrays.h"
#include "RenderingScene.h"

#include "vtkBitArray.h"
#include "vtkCamera.h"
#include "vtkCellData.h"
#include "vtkContourValues.h"
#include "vtkDoubleArray.h"
#include "vtkMath.h"
#include "vtkPlane.h"
#include "vtkSphere.h"

#include <cmath>
#include <functional>
#include <limits>

using namespace treeamr::test;

namespace
{

vtkSmartPointer<vtkHyperTreeGrid> emptyGrid()
{
  GridOptions options;
  options.trees = false;
  return makeGrid(options, { { "x", [](const Point&) { return 0.; } } });
}

vtkSmartPointer<vtkHyperTreeGrid> gridWithoutValues()
{
  return makeGrid({}, { { "x", [](const Point&) { return std::numeric_limits<double>::quiet_NaN(); } } });
}

/// Scenes with one prop of ours in front of a polygon.
class MapperErrorsTest : public RenderingTest
{
protected:
  MapperErrorsTest()
  {
    scene_.addRectangle({ 0., 0., -2. }, { 1., 0., 0. }, { 0., 1., 0. }, { 0.2, 0.5, 0.8 });
    scene_.setCamera();
    // The same with and without our prop's bounds.
    scene_.renderer->GetActiveCamera()->SetClippingRange(0.1, 30.);
    withoutProp_ = scene_.render();
    grid_ = makeTestGrid();
    volume_ = scene_.addVolume(grid_, "x", { 1., 1., 1. }, 0.5);
    volumeMapper_ = Scene::mapperOf(volume_);
    volume_->VisibilityOff();
    surface_ = scene_.addIsosurface(grid_, "x", 0.3);
    surfaceMapper_ = Scene::mapperOf(surface_);
    surface_->VisibilityOff();
  }

  /// Spoils something, and expects one message with all of `parts` and an unchanged image; repairs it, and
  /// expects the prop.
  void expectError(vtkProp* prop, vtkObject* mapper, const std::vector<std::string>& parts,
    const std::function<void()>& spoil, const std::function<void()>& repair)
  {
    prop->VisibilityOn();
    MessageCounter messages(mapper);
    spoil();
    EXPECT_EQ(scene_.render(), withoutProp_);
    ASSERT_EQ(messages.errors.size(), 1u);
    for (const std::string& part : parts)
    {
      EXPECT_NE(messages.errors[0].find(part), std::string::npos)
        << "'" << part << "' is not in: " << messages.errors[0];
    }
    EXPECT_EQ(scene_.render(), withoutProp_);
    EXPECT_EQ(messages.errors.size(), 1u) << "repeated at the second frame";
    repair();
    EXPECT_NE(scene_.render(), withoutProp_);
    EXPECT_EQ(messages.errors.size(), 1u);
    spoil();
    EXPECT_EQ(scene_.render(), withoutProp_);
    EXPECT_EQ(messages.errors.size(), 2u) << "the same again is news after a success";
    EXPECT_TRUE(messages.warnings.empty());
    prop->VisibilityOff();
  }
  void expectVolumeError(const std::vector<std::string>& parts, const std::function<void()>& spoil,
    const std::function<void()>& repair)
  {
    expectError(volume_, volumeMapper_, parts, spoil, repair);
  }
  void expectSurfaceError(const std::vector<std::string>& parts, const std::function<void()>& spoil,
    const std::function<void()>& repair)
  {
    expectError(surface_, surfaceMapper_, parts, spoil, repair);
  }
  /// Expects one message of two calls of render().
  static void expectDirectError(vtkObject* mapper, const std::vector<std::string>& parts,
    const std::function<void()>& spoil, const std::function<void()>& render)
  {
    MessageCounter messages(mapper);
    spoil();
    render();
    render();
    ASSERT_EQ(messages.errors.size(), 1u);
    for (const std::string& part : parts)
    {
      EXPECT_NE(messages.errors[0].find(part), std::string::npos) << messages.errors[0];
    }
  }
  void expectBadInput(const std::vector<std::string>& parts, vtkHyperTreeGrid* bad)
  {
    expectVolumeError(
      parts, [&] { volumeMapper_->SetInputData(bad); }, [&] { volumeMapper_->SetInputData(grid_.Get()); });
    expectSurfaceError(
      parts, [&] { surfaceMapper_->SetInputData(bad); }, [&] { surfaceMapper_->SetInputData(grid_.Get()); });
  }

  Scene scene_;
  std::vector<std::array<float, 4>> withoutProp_;
  vtkSmartPointer<vtkHyperTreeGrid> grid_;
  vtkVolume* volume_;
  vtkTreeAMRVolumeMapper* volumeMapper_;
  vtkActor* surface_;
  vtkTreeAMRIsosurfaceMapper* surfaceMapper_;
};

} // namespace

TEST_F(MapperErrorsTest, emptyGrid)
{
  expectVolumeError(
    { "no tree" }, [&] { volumeMapper_->SetInputData(emptyGrid()); },
    [&] { volumeMapper_->SetInputData(grid_.Get()); });
  // Without bounds an actor is not asked to draw.
  expectDirectError(
    surfaceMapper_, { "no tree" }, [&] { surfaceMapper_->SetInputData(emptyGrid()); },
    [&] { surfaceMapper_->Render(scene_.renderer, surface_); });
}

// As VTK's filters leave what keeps no cell.
TEST_F(MapperErrorsTest, masksOfAllCellsLeaveNothingToDrawOrSay)
{
  vtkNew<vtkBitArray> mask;
  mask->SetNumberOfValues(grid_->GetNumberOfElements(vtkDataObject::CELL));
  for (vtkIdType i = 0; i < mask->GetNumberOfValues(); ++i)
  {
    mask->SetValue(i, 1);
  }
  vtkNew<vtkHyperTreeGrid> masked;
  masked->ShallowCopy(grid_);
  masked->SetMask(mask);
  const MessageCounter ofVolume(volumeMapper_);
  const MessageCounter ofSurface(surfaceMapper_);
  volume_->VisibilityOn();
  surface_->VisibilityOn();
  const auto both = scene_.render();
  EXPECT_NE(both, withoutProp_);
  volumeMapper_->SetInputData(masked);
  surfaceMapper_->SetInputData(masked);
  EXPECT_EQ(scene_.render(), withoutProp_);
  volumeMapper_->SetInputData(grid_.Get());
  surfaceMapper_->SetInputData(grid_.Get());
  EXPECT_EQ(scene_.render(), both);
  EXPECT_TRUE(ofVolume.errors.empty());
  EXPECT_TRUE(ofSurface.errors.empty());
}

TEST_F(MapperErrorsTest, noInput)
{
  // Nor a volume without input.
  expectDirectError(
    volumeMapper_, { "no input" }, [&] { volumeMapper_->SetInputConnection(nullptr); },
    [&] { volumeMapper_->Render(scene_.renderer, volume_); });
  expectDirectError(
    surfaceMapper_, { "no input" }, [&] { surfaceMapper_->SetInputConnection(nullptr); },
    [&] { surfaceMapper_->Render(scene_.renderer, surface_); });
}

TEST_F(MapperErrorsTest, noWindow)
{
  vtkNew<vtkRenderer> renderer;
  const std::string needed = "no window, needed is a vtkOpenGLRenderWindow";
  expectDirectError(
    volumeMapper_, { needed }, [] {}, [&] { volumeMapper_->Render(renderer, volume_); });
  expectDirectError(
    surfaceMapper_, { needed }, [] {}, [&] { surfaceMapper_->Render(renderer, surface_); });
}

TEST_F(MapperErrorsTest, allValuesNotANumber)
{
  expectBadInput({ "'x'", "finite" }, gridWithoutValues());
}

TEST_F(MapperErrorsTest, branchFactorThree)
{
  GridOptions options;
  options.branchFactor = 3;
  expectBadInput(
    { "branch factor", "3" }, makeGrid(options, { { "x", [](const Point& p) { return p[0]; } } }));
}

TEST_F(MapperErrorsTest, missingArray)
{
  const std::vector<std::string> parts{ "'nothing'" };
  expectVolumeError(
    parts, [&] { volumeMapper_->SelectScalarArray("nothing"); },
    [&] { volumeMapper_->SelectScalarArray("x"); });
  const auto contour = [&](const char* name) {
    surfaceMapper_->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, name);
  };
  expectSurfaceError(
    parts, [&] { contour("nothing"); }, [&] { contour("x"); });
}

TEST_F(MapperErrorsTest, missingArrayNumber)
{
  expectVolumeError(
    { "number 17", "'one', 'x', 'y', 'z'" }, [&] { volumeMapper_->SelectScalarArray(17); },
    [&] { volumeMapper_->SelectScalarArray(1); });
}

TEST_F(MapperErrorsTest, missingComponent)
{
  volumeMapper_->SetVectorMode(vtkTreeAMRVolumeMapper::COMPONENT);
  expectVolumeError(
    { "component 3" }, [&] { volumeMapper_->SetVectorComponent(3); },
    [&] { volumeMapper_->SetVectorComponent(0); });
  expectSurfaceError(
    { "component 3" }, [&] { surfaceMapper_->SetIsosurfaceComponent(3); },
    [&] { surfaceMapper_->SetIsosurfaceComponent(-1); });
}

TEST_F(MapperErrorsTest, pointData)
{
  expectVolumeError(
    { "point" }, [&] { volumeMapper_->SetScalarModeToUsePointFieldData(); },
    [&] { volumeMapper_->SetScalarModeToUseCellFieldData(); });
}

TEST_F(MapperErrorsTest, blendModes)
{
  for (const int mode : { -1, 7 })
  {
    expectVolumeError(
      { "blend mode " + std::to_string(mode), "0 (composite)", "5 (isosurface)", "6 (slice)" },
      [&] { volumeMapper_->SetBlendMode(mode); }, [&] { volumeMapper_->SetBlendModeToComposite(); });
  }
}

TEST_F(MapperErrorsTest, sliceFunctions)
{
  volumeMapper_->SetBlendModeToSlice();
  vtkVolumeProperty* property = volume_->GetProperty();
  vtkNew<vtkPlane> plane;
  property->SetSliceFunction(plane);
  vtkNew<vtkSphere> sphere;
  expectVolumeError(
    { "no slice function", "vtkPlane" }, [&] { property->SetSliceFunction(nullptr); },
    [&] { property->SetSliceFunction(plane); });
  expectVolumeError(
    { "vtkSphere", "vtkPlane" }, [&] { property->SetSliceFunction(sphere); },
    [&] { property->SetSliceFunction(plane); });
  expectVolumeError(
    { "slice function", "Origin (0, nan, 0)", "Normal (0, 0, 1)", "finite" },
    [&] {
      property->SetSliceFunction(plane);
      plane->SetOrigin(0., vtkMath::Nan(), 0.);
    },
    [&] { plane->SetOrigin(0., 0., 0.); });
  plane->SetOrigin(0., 0., 0.);
  expectVolumeError(
    { "slice function", "Normal (0, 0, 0)" }, [&] { plane->SetNormal(0., 0., 0.); },
    [&] { plane->SetNormal(0., 0., 1.); });
}

TEST_F(MapperErrorsTest, samplesPerCell)
{
  // NaN never equals itself: every set is a change.
  bool isSet = false;
  expectVolumeError(
    { "samples per cell" },
    [&] {
      if (!isSet)
      {
        isSet = true;
        volumeMapper_->SetSamplesPerCell(std::numeric_limits<double>::quiet_NaN());
      }
    },
    [&] {
      isSet = false;
      volumeMapper_->SetSamplesPerCell(2.);
    });
  // As setters of VTK take what is out of range, and it is said.
  MessageCounter messages(volumeMapper_);
  for (const double samples : { 0., -1., 1e300 })
  {
    volumeMapper_->SetSamplesPerCell(samples);
    EXPECT_EQ(volumeMapper_->GetSamplesPerCell(), samples > 0. ? 1024. : 0.01);
  }
  EXPECT_EQ(messages.warnings.size(), 3u);
}

TEST_F(MapperErrorsTest, settingsThatAreNoNumbers)
{
  using Setter = void (vtkTreeAMRVolumeMapper::*)(double);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  volumeMapper_->AutoAdjustSampleDistancesOff();
  for (const auto& [name, set] : { std::pair<const char*, Setter>("the image sample distance",
                                     &vtkTreeAMRVolumeMapper::SetImageSampleDistance),
         std::pair<const char*, Setter>(
           "the minimum image sample distance", &vtkTreeAMRVolumeMapper::SetMinimumImageSampleDistance),
         std::pair<const char*, Setter>(
           "the maximum image sample distance", &vtkTreeAMRVolumeMapper::SetMaximumImageSampleDistance),
         std::pair<const char*, Setter>(
           "the interactive render time", &vtkTreeAMRVolumeMapper::SetInteractiveRenderTime),
         std::pair<const char*, Setter>("the level of detail", &vtkTreeAMRVolumeMapper::SetLevelOfDetail),
         std::pair<const char*, Setter>("the target error", &vtkTreeAMRVolumeMapper::SetTargetError),
         std::pair<const char*, Setter>(
           "the isosurface opacity scale", &vtkTreeAMRVolumeMapper::SetIsosurfaceOpacityScale),
         std::pair<const char*, Setter>(
           "the ambient occlusion radius", &vtkTreeAMRVolumeMapper::SetAmbientOcclusionRadius) })
  {
    expectVolumeError(
      { name, "not a number" }, [&] { (volumeMapper_->*set)(nan); }, [&] { (volumeMapper_->*set)(1.); });
    (volumeMapper_->*set)(1.);
  }
}

TEST_F(MapperErrorsTest, unitDistance)
{
  expectVolumeError(
    { "unit distance" }, [&] { volume_->GetProperty()->SetScalarOpacityUnitDistance(0.); },
    [&] { volume_->GetProperty()->SetScalarOpacityUnitDistance(1.); });
}

TEST_F(MapperErrorsTest, isovalueOfAVolumeNotFinite)
{
  volumeMapper_->ShowIsosurfacesOn();
  vtkContourValues* values = volume_->GetProperty()->GetIsoSurfaceValues();
  for (const double value : { HUGE_VAL, std::numeric_limits<double>::quiet_NaN() })
  {
    values->SetNumberOfContours(0);
    // NaN never equals itself: every set is a change.
    expectVolumeError(
      { "isovalue" },
      [&] {
        if (values->GetNumberOfContours() == 0)
        {
          values->SetValue(0, value);
        }
      },
      [&] { values->SetNumberOfContours(0); });
  }
}

TEST_F(MapperErrorsTest, isovalueNotFinite)
{
  expectSurfaceError(
    { "isovalue" }, [&] { surfaceMapper_->SetValue(0, std::numeric_limits<double>::infinity()); },
    [&] { surfaceMapper_->SetValue(0, 0.3); });
}

TEST_F(MapperErrorsTest, singularMatrix)
{
  expectVolumeError(
    { "vtkVolume", "singular", "scale (1, 0, 1)", "axis y becomes (0, 0, 0)" },
    [&] { volume_->SetScale(1., 0., 1.); }, [&] { volume_->SetScale(1.); });
  expectSurfaceError(
    { "Actor", "singular", "scale (1, 0, 1)", "axis y becomes (0, 0, 0)" },
    [&] { surface_->SetScale(1., 0., 1.); }, [&] { surface_->SetScale(1.); });
}

TEST_F(MapperErrorsTest, camerasWithoutAView)
{
  volume_->VisibilityOn();
  vtkCamera* camera = scene_.renderer->GetActiveCamera();
  expectDirectError(
    volumeMapper_, { "camera", "position (0, 0, 5)", "view up (0, 0, 1)", "singular" },
    [&] {
      camera->SetPosition(0., 0., 5.);
      camera->SetFocalPoint(0., 0., 0.);
      camera->SetViewUp(0., 0., 1.);
    },
    [&] { scene_.render(); });
  camera->SetViewUp(0., 1., 0.);
  MessageCounter messages(volumeMapper_);
  scene_.render();
  EXPECT_TRUE(messages.errors.empty());
}

TEST_F(MapperErrorsTest, missingColorArrayWarnsAndLeavesTheSolidColor)
{
  surface_->VisibilityOn();
  const auto solid = scene_.render();
  MessageCounter messages(surfaceMapper_);
  surfaceMapper_->ScalarVisibilityOn();
  surfaceMapper_->SetScalarModeToUseCellFieldData();
  surfaceMapper_->SelectColorArray("nothing");
  EXPECT_EQ(scene_.render(), solid);
  EXPECT_EQ(scene_.render(), solid);
  EXPECT_TRUE(messages.errors.empty());
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("'nothing'"), std::string::npos);
}

// Whatever else changes: a message is news when it has gone away meanwhile.
TEST_F(MapperErrorsTest, unrelatedChangesRepeatNoMessage)
{
  MessageCounter volumeMessages(volumeMapper_);
  MessageCounter surfaceMessages(surfaceMapper_);
  volume_->VisibilityOn();
  surface_->VisibilityOn();
  volumeMapper_->SelectScalarArray("nothing");
  surfaceMapper_->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "nothing");
  const std::vector<std::function<void()>> changes{
    [] {},
    [&] { volumeMapper_->SetSamplesPerCell(3.); },
    [&] { volume_->GetProperty()->SetScalarOpacityUnitDistance(0.7); },
    [&] { surfaceMapper_->SetAmbientOcclusionRadius(0.3); },
    [&] { grid_->Modified(); },
  };
  for (const auto& change : changes)
  {
    change();
    scene_.render();
    EXPECT_EQ(volumeMessages.errors.size(), 1u);
    EXPECT_EQ(surfaceMessages.errors.size(), 1u);
  }
}

TEST_F(MapperErrorsTest, rangesThatDoublesDoNotTellApartWarn)
{
  const auto offsetGrid = [](double offset) {
    return makeGrid({}, { { "x", [=](const Point& p) { return offset + p[0]; } } });
  };
  MessageCounter volumeMessages(volumeMapper_);
  MessageCounter surfaceMessages(surfaceMapper_);
  volume_->VisibilityOn();
  surface_->VisibilityOn();
  surfaceMapper_->ScalarVisibilityOn();
  surfaceMapper_->SetScalarModeToUseCellFieldData();
  surfaceMapper_->SelectColorArray("x");
  std::size_t said = 0;
  for (const double offset : { 1e15, 2e15, 1e9, 4e15 })
  {
    const auto grid = offsetGrid(offset);
    volumeMapper_->SetInputData(grid);
    surfaceMapper_->SetInputData(grid);
    surfaceMapper_->SetValue(0, offset + 0.3);
    said += offset == 1e15 || offset == 4e15 ? 1 : 0; // of the same array once until it goes away
    for (int frame = 0; frame < 3; ++frame)
    {
      volumeMapper_->SetSamplesPerCell(2. + frame);
      scene_.render();
      ASSERT_EQ(volumeMessages.warnings.size(), said) << offset;
      ASSERT_EQ(surfaceMessages.warnings.size(), said) << offset;
    }
  }
  for (const MessageCounter* messages : { &volumeMessages, &surfaceMessages })
  {
    EXPECT_TRUE(messages->errors.empty());
    EXPECT_NE(messages->warnings[0].find("'x' differ by 1 at most"), std::string::npos)
      << messages->warnings[0];
  }
}

TEST_F(MapperErrorsTest, cornersThatDisagreeAreSaidOnce)
{
  MessageCounter volumeMessages(volumeMapper_);
  MessageCounter surfaceMessages(surfaceMapper_);
  volume_->VisibilityOn();
  surface_->VisibilityOn();
  volumeMapper_->SelectScalarArray("corners");
  surfaceMapper_->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "corners");
  surfaceMapper_->SetValue(0, 3.5);
  for (const bool disagree : { false, true })
  {
    const auto grid = makeGrid({}, { { "x", [](const Point&) { return 0.; } } });
    vtkNew<vtkDoubleArray> corners;
    corners->SetName("corners");
    treeamr::markAsCorners(*corners);
    corners->SetNumberOfTuples(8); // roots in the order of corners
    for (int i = 0; i < 64; ++i)
    {
      const int root = i / 8;
      const int corner = i % 8;
      const double x = (root & 1) + (corner & 1);
      corners->SetValue(i, disagree ? root : 3. * x);
    }
    grid->GetCellData()->AddArray(corners);
    volumeMapper_->SetInputData(grid);
    surfaceMapper_->SetInputData(grid);
    for (int frame = 0; frame < 3; ++frame)
    {
      volumeMapper_->SetSamplesPerCell(2. + frame);
      scene_.render();
      ASSERT_EQ(volumeMessages.warnings.size(), disagree ? 1u : 0u);
      ASSERT_EQ(surfaceMessages.warnings.size(), disagree ? 1u : 0u);
    }
  }
  for (const MessageCounter* messages : { &volumeMessages, &surfaceMessages })
  {
    EXPECT_TRUE(messages->errors.empty());
    EXPECT_NE(messages->warnings[0].find("'corners' at corners that cells share differ by up to 7"),
      std::string::npos)
      << messages->warnings[0];
  }
}

TEST_F(MapperErrorsTest, clippingPlanesAreFinite)
{
  vtkNew<vtkPlane> plane;
  plane->SetOrigin(std::nan(""), 0., 0.);
  MessageCounter messages(volumeMapper_);
  volume_->VisibilityOn();
  volumeMapper_->AddClippingPlane(plane);
  scene_.render();
  scene_.render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("clipping plane"), std::string::npos) << messages.errors[0];
  volumeMapper_->RemoveAllClippingPlanes();
  volumeMapper_->CroppingOn();
  volumeMapper_->SetCroppingRegionPlanes(0., std::nan(""), 0., 1., 0., 1.);
  scene_.render();
  ASSERT_EQ(messages.errors.size(), 2u);
  EXPECT_NE(messages.errors[1].find("cropping plane 1"), std::string::npos) << messages.errors[1];
}

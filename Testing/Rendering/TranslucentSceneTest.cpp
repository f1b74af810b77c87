// Where nothing is translucent but this module's surfaces and one volume they are drawn as one picture: against the
// layers computed along each pixel's line of sight, and against depth peeling where something else forces it.
#include "CompositingScene.h"

#include "vtkAssembly.h"
#include "vtkCameraPass.h"
#include "vtkContourValues.h"
#include "vtkOpaquePass.h"
#include "vtkPiecewiseFunction.h"
#include "vtkRenderPassCollection.h"
#include "vtkSequencePass.h"
#include "vtkTranslucentPass.h"
#include "vtkTreeAMRIsosurfaceActor.h"

#include <functional>

using namespace treeamr::test;

namespace
{

/// Two surfaces that cross each other and hide each other in turn, with or without a volume around them.
class TranslucentSceneTest : public SurfaceCompositingTest
{
protected:
  struct Things
  {
    vtkActor* flat;    // z = level
    vtkActor* upright; // x = across
    vtkVolume* volume = nullptr;
    std::vector<Rectangle> rectangles;
  };
  static constexpr double across = -0.3;
  static constexpr double flatOpacity = 0.6;
  static constexpr double uprightOpacity = 0.45;

  static Things fill(Scene& scene, bool withVolume)
  {
    Things things;
    things.flat = addSurface(scene, makeTestGrid(), green, flatOpacity);
    things.upright = scene.addIsosurface(makeTestGrid(), "x", across);
    vtkProperty* property = things.upright->GetProperty();
    property->LightingOff();
    property->SetColor(blue[0], blue[1], blue[2]);
    property->SetOpacity(uprightOpacity);
    if (withVolume)
    {
      things.volume = addBox(scene);
    }
    things.rectangles = { facingRectangle(-0.6, 0.9, red) };
    addRectangles(scene, things.rectangles);
    things.rectangles.push_back(surface(green, flatOpacity));
    things.rectangles.push_back(upright());
    scene.setCamera();
    return things;
  }
  static Rectangle upright()
  {
    return { { across, 0., 0. }, { 0., 1., 0. }, { 0., 0., 1. }, blue, uprightOpacity };
  }

  enum class Sorting
  {
    None,
    Polygons,
    PolygonsAndVolumes
  };
  static constexpr std::array<Sorting, 3> all{ Sorting::None, Sorting::Polygons,
    Sorting::PolygonsAndVolumes };
  /// With fewer peels than there are layers.
  static void sort(Scene& scene, Sorting sorting)
  {
    peel(scene, 1);
    scene.renderer->SetUseDepthPeeling(sorting != Sorting::None);
    scene.renderer->SetUseDepthPeelingForVolumes(sorting == Sorting::PolygonsAndVolumes);
  }
  /// Peeling keeps the colours of a volume in 8 bits.
  static constexpr double tolerance = 2. * eightBits;
  static constexpr Order mostlyEdges{ false, 0.6 };
};

TEST_F(TranslucentSceneTest, surfacesInAVolume)
{
  for (const Sorting sorting : all)
  {
    Scene scene;
    const Things things = fill(scene, true);
    sort(scene, sorting);
    expectLayers(scene, things.volume, things.rectangles, tolerance, mostlyEdges);
  }
}

TEST_F(TranslucentSceneTest, surfacesInAVolumeInFloatingPoint)
{
  Scene scene;
  scene.useFloatTarget();
  const Things things = fill(scene, true);
  expectLayers(scene, things.volume, things.rectangles, floatTolerance, mostlyEdges);
}

/// How many pixels differ by more than peeling rounds, and how many do at all.
std::array<int, 2> differences(
  const std::vector<std::array<float, 4>>& a, const std::vector<std::array<float, 4>>& b, double tolerance)
{
  std::array<int, 2> count{};
  for (std::size_t i = 0; i < a.size(); ++i)
  {
    float most = 0.f;
    for (int c = 0; c < 3; ++c)
    {
      most = std::max(most, std::abs(a[i][c] - b[i][c]));
    }
    count[0] += most > tolerance;
    count[1] += most > 0.f;
  }
  return count;
}

/// Draws with volumes, which plain actors cannot.
vtkActor* replaceByOwnActor(Scene& scene, vtkActor* actor)
{
  vtkNew<vtkTreeAMRIsosurfaceActor> own;
  own->ShallowCopy(actor);
  scene.renderer->RemoveActor(actor);
  scene.renderer->AddActor(own);
  return own;
}

TEST_F(TranslucentSceneTest, surfacesOfSeveralActors)
{
  for (const Sorting sorting : all)
  {
    Scene scene(30, 22);
    Things things = fill(scene, false);
    sort(scene, sorting);
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
    things.upright = replaceByOwnActor(scene, things.upright);
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
    things.flat = replaceByOwnActor(scene, things.flat);
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
    things.upright->SetPosition(30., 40., 60.); // culled, and it would draw
    expectLayers(
      scene, nullptr, { things.rectangles[0], surface(green, flatOpacity) }, tolerance, mostlyEdges);
    things.flat->GetProperty()->SetOpacity(1.);
    expectLayers(scene, nullptr, { things.rectangles[0], surface(green) }, tolerance, mostlyEdges);
  }
}

// Colours are found for so many layers at a time that those of a pixel fall apart.
TEST_F(TranslucentSceneTest, manyLayersOfOneActor)
{
  Scene scene;
  const std::array<double, 5> places{ -0.7, -0.35, 0., 0.35, 0.7 };
  vtkActor* actor = scene.addIsosurface(makeTestGrid(), "x", 0.);
  auto* mapper = vtkTreeAMRIsosurfaceMapper::SafeDownCast(actor->GetMapper());
  mapper->SetNumberOfContours(static_cast<int>(places.size()));
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetColor(blue[0], blue[1], blue[2]);
  actor->GetProperty()->SetOpacity(0.3);
  std::vector<Rectangle> rectangles;
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    mapper->SetValue(static_cast<int>(i), places[i]);
    rectangles.push_back({ { places[i], 0., 0. }, { 0., 1., 0. }, { 0., 0., 1. }, blue, 0.3 });
  }
  scene.setCamera();
  expectLayers(scene, nullptr, rectangles, tolerance, mostlyEdges);
}

// Among other translucent polygons they are sorted by VTK.
TEST_F(TranslucentSceneTest, ownActorsAmongOthers)
{
  Scene scene;
  Things things = fill(scene, false);
  replaceByOwnActor(scene, things.flat);
  replaceByOwnActor(scene, things.upright);
  things.rectangles.push_back(facingRectangle(0.5, 0.6, white, 0.4));
  scene.addRectangle(things.rectangles.back().center, things.rectangles.back().halfU,
    things.rectangles.back().halfV, white, 0.4);
  peel(scene, 8);
  expectLayers(scene, nullptr, things.rectangles, 2. * tolerance, { false, 0.7 });
}

// Behind all that is opaque nothing is peeled, which would keep colours in 8 bits.
TEST_F(TranslucentSceneTest, ownActorsThatComeLastAreNotPeeled)
{
  Scene scene(30, 22);
  scene.useFloatTarget();
  Things things = fill(scene, false);
  sort(scene, Sorting::PolygonsAndVolumes);
  things.upright = replaceByOwnActor(scene, things.upright);
  things.flat = replaceByOwnActor(scene, things.flat);
  expectLayers(scene, nullptr, things.rectangles, floatTolerance, mostlyEdges);
  EXPECT_TRUE(things.flat->HasTranslucentPolygonalGeometry());
  const auto alone = scene.render();
  // What comes later is before or behind them all the same.
  const Rectangle last = facingRectangle(0.4, 0.3, blue);
  vtkActor* later = scene.addRectangle(last.center, last.halfU, last.halfV, last.color, last.opacity);
  things.rectangles.push_back(last);
  expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
  later->VisibilityOff();
  EXPECT_EQ(scene.render(), alone);
}

TEST_F(TranslucentSceneTest, ownActorsInFloatingPointAndAsDrafts)
{
  Scene scene;
  scene.useFloatTarget();
  Things things = fill(scene, false);
  things.flat = replaceByOwnActor(scene, things.flat);
  things.upright = replaceByOwnActor(scene, things.upright);
  expectLayers(scene, nullptr, things.rectangles, floatTolerance, mostlyEdges);
  const auto full = scene.render();
  for (vtkActor* actor : { things.flat, things.upright })
  {
    Scene::mapperOf(actor)->AutoAdjustSampleDistancesOff();
    Scene::mapperOf(actor)->SetImageSampleDistance(2.);
  }
  // Bilinear: away from the edges of what is of one colour nothing changes.
  EXPECT_LT(differences(full, scene.render(), 1e-4)[0], 0.5 * static_cast<double>(full.size()));
  EXPECT_EQ(Scene::mapperOf(things.flat)->GetLastImageSampleDistance(), 2.);
}

// Rays of the volume, which is not where its data are, and those of the surfaces have different lengths.
TEST_F(TranslucentSceneTest, volumeOfAnotherMatrix)
{
  for (const Sorting sorting : all)
  {
    Scene scene;
    const Things things = fill(scene, true);
    things.volume->SetScale(0.5, 1.2, 0.8);
    things.volume->SetPosition(0.1, 0.2, -0.1);
    // Extinction is per length in data: without any there is nothing to compute but the surfaces.
    things.volume->GetProperty()->GetScalarOpacity()->RemoveAllPoints();
    things.volume->GetProperty()->GetScalarOpacity()->AddPoint(0., 0.);
    sort(scene, sorting);
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
  }
}

// Whatever VTK does not ask to draw cannot draw what else there is.
TEST_F(TranslucentSceneTest, volumeThatIsNotDrawn)
{
  Scene scene(30, 22);
  Things things = fill(scene, true);
  for (const Sorting sorting : all)
  {
    sort(scene, sorting);
    expectLayers(scene, things.volume, things.rectangles, tolerance, mostlyEdges);
    things.volume->VisibilityOff();
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
    things.volume->VisibilityOn();
    things.volume->SetPosition(30., 40., 60.); // behind the camera: culled
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
    things.volume->SetPosition(0., 0., 0.);
  }
}

TEST_F(TranslucentSceneTest, actorsThatComeAndGo)
{
  Scene scene(30, 22);
  Things things = fill(scene, true);
  const Rectangle wall = things.rectangles[0];
  const vtkSmartPointer<vtkActor> flat = things.flat;
  for (const Sorting sorting : all)
  {
    for (vtkVolume* volume : { things.volume, static_cast<vtkVolume*>(nullptr) })
    {
      things.volume->SetVisibility(volume != nullptr);
      sort(scene, sorting);
      expectLayers(scene, volume, things.rectangles, tolerance, mostlyEdges);
      flat->VisibilityOff();
      expectLayers(scene, volume, { wall, upright() }, tolerance, mostlyEdges);
      flat->VisibilityOn();
      things.upright->SetPosition(30., 40., 60.); // culled
      expectLayers(scene, volume, { wall, surface(green, flatOpacity) }, tolerance, mostlyEdges);
      scene.renderer->RemoveActor(flat);
      expectLayers(scene, volume, { wall }, tolerance, mostlyEdges);
      scene.renderer->AddActor(flat);
      things.upright->SetPosition(0., 0., 0.);
    }
  }
}

TEST_F(TranslucentSceneTest, whatFailsLeavesTheRest)
{
  for (const Sorting sorting : all)
  {
    Scene scene(30, 22);
    Things things = fill(scene, true);
    sort(scene, sorting);
    vtkTreeAMRVolumeMapper* volumeMapper = Scene::mapperOf(things.volume);
    vtkTreeAMRIsosurfaceMapper* surfaceMapper = Scene::mapperOf(things.flat);
    MessageCounter ofVolume(volumeMapper);
    MessageCounter ofSurface(surfaceMapper);
    const Rectangle wall = things.rectangles[0];
    volumeMapper->SetScalarModeToUseCellFieldData();
    volumeMapper->SelectScalarArray("nothing");
    expectLayers(scene, nullptr, things.rectangles, tolerance, mostlyEdges);
    surfaceMapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "none");
    for (int frame = 0; frame < 2; ++frame)
    {
      expectLayers(scene, nullptr, { wall, upright() }, tolerance, mostlyEdges);
    }
    volumeMapper->SelectScalarArray("one");
    expectLayers(scene, things.volume, { wall, upright() }, tolerance, mostlyEdges);
    EXPECT_EQ(ofVolume.errors.size(), 1u);
    EXPECT_EQ(ofSurface.errors.size(), 1u);
  }
}

// Passes of the user's need not draw volumes at all.
TEST_F(TranslucentSceneTest, passesWithoutVolumes)
{
  Scene scene;
  const Things things = fill(scene, true);
  things.flat->VisibilityOff();
  vtkNew<vtkRenderPassCollection> passes;
  passes->AddItem(vtkNew<vtkOpaquePass>());
  passes->AddItem(vtkNew<vtkTranslucentPass>());
  vtkNew<vtkSequencePass> sequence;
  sequence->SetPasses(passes);
  vtkNew<vtkCameraPass> camera;
  camera->SetDelegatePass(sequence);
  scene.renderer->SetPass(camera);
  expectLayers(scene, nullptr, { things.rectangles[0], upright() }, tolerance, mostlyEdges);
}

// Something else that is translucent, too small to be seen, makes VTK sort all of it.
TEST_F(TranslucentSceneTest, sameAsPeeled)
{
  const std::vector<std::pair<const char*, std::function<void(Scene&, Things&)>>> settings{
    { "as it is", [](Scene&, Things&) {} },
    { "parallel", [](Scene& scene, Things&) { scene.setCamera(true); } },
    { "left eye",
      [](Scene& scene, Things&) {
        scene.window->SetStereoTypeToLeft();
        scene.window->StereoRenderOn();
      } },
    { "moved",
      [](Scene&, Things& things) {
        things.flat->SetPosition(0.1, 0., 0.2);
        things.flat->SetScale(0.8, 1., 1.3);
        things.volume->SetScale(1.1, 0.9, 1.);
        things.volume->RotateY(20.);
      } },
    { "lit",
      [](Scene&, Things& things) {
        things.flat->GetProperty()->LightingOn();
        Scene::mapperOf(things.flat)->SetShadows(true);
        Scene::mapperOf(things.flat)->SetAmbientOcclusionSamples(4);
        things.flat->GetProperty()->SetSpecular(0.4);
      } },
    { "surfaces in the volume",
      [](Scene&, Things& things) {
        Scene::mapperOf(things.volume)->SetShowIsosurfaces(true);
        things.volume->GetProperty()->GetIsoSurfaceValues()->SetValue(0, 0.35);
        Scene::mapperOf(things.volume)->SetScalarModeToUseCellFieldData();
        Scene::mapperOf(things.volume)->SelectScalarArray("y");
      } },
  };
  for (const auto& [name, set] : settings)
  {
    std::vector<std::array<float, 4>> pictures[2];
    for (const bool forced : { false, true })
    {
      Scene scene;
      Things things = fill(scene, true);
      peel(scene, 8);
      set(scene, things);
      if (forced)
      {
        scene.addRectangle({ 0., 0., 0. }, { 1e-6, 0., 0. }, { 0., 1e-6, 0. }, red, 0.5);
      }
      pictures[forced] = scene.render();
    }
    const std::array<int, 2> different = differences(pictures[0], pictures[1], 3. / 255.);
    EXPECT_EQ(different[0], 0) << name;
    EXPECT_GT(different[1], 0) << name << ": was it sorted by VTK?";
  }
}

TEST_F(TranslucentSceneTest, surfaceInAnAssemblyIsSortedByVTK)
{
  std::vector<std::array<float, 4>> pictures[2];
  for (const bool assembled : { false, true })
  {
    Scene scene;
    Things things = fill(scene, true);
    peel(scene, 8);
    vtkNew<vtkAssembly> assembly;
    if (assembled)
    {
      assembly->AddPart(things.flat);
      scene.renderer->RemoveActor(things.flat);
      scene.renderer->AddActor(assembly);
    }
    pictures[assembled] = scene.render();
  }
  EXPECT_EQ(differences(pictures[0], pictures[1], 3. / 255.)[0], 0);
}

// In the other renderer they are among translucent polygons.
TEST_F(TranslucentSceneTest, inTwoRenderers)
{
  Scene alone;
  Things things = fill(alone, true);
  peel(alone, 8);
  const auto expected = alone.render();
  vtkNew<vtkRenderer> other;
  other->SetUseDepthPeeling(true);
  other->SetUseDepthPeelingForVolumes(true);
  other->SetActiveCamera(alone.renderer->GetActiveCamera());
  other->AddActor(things.flat);
  other->AddVolume(things.volume);
  alone.renderer->SetViewport(0., 0., 1., 1.);
  other->SetViewport(0.9, 0.9, 1., 1.);
  other->SetLayer(1);
  alone.window->SetNumberOfLayers(2);
  alone.window->AddRenderer(other);
  for (int frame = 0; frame < 2; ++frame)
  {
    const auto picture = alone.render();
    int different = 0;
    for (int y = 0; y < alone.height() * 9 / 10 - 1; ++y)
    {
      for (int x = 0; x < alone.width(); ++x)
      {
        const std::size_t i = static_cast<std::size_t>(y) * alone.width() + x;
        different += picture[i] != expected[i];
      }
    }
    EXPECT_EQ(different, 0);
  }
}

// Of drafts with different distances between rays there is one picture.
TEST_F(TranslucentSceneTest, oneDistanceOfRaysForAll)
{
  Scene scene;
  Things things = fill(scene, true);
  sort(scene, Sorting::PolygonsAndVolumes);
  const auto distances = [&](double ofSurface, double ofVolume, bool interactive) {
    for (vtkActor* actor : { things.flat, things.upright })
    {
      Scene::mapperOf(actor)->AutoAdjustSampleDistancesOff();
      Scene::mapperOf(actor)->SetImageSampleDistance(ofSurface);
    }
    Scene::mapperOf(things.volume)->AutoAdjustSampleDistancesOff();
    Scene::mapperOf(things.volume)->SetImageSampleDistance(ofVolume);
    scene.window->SetDesiredUpdateRate(interactive ? 5. : 0.002);
    scene.render();
    EXPECT_EQ(Scene::mapperOf(things.flat)->GetLastImageSampleDistance(),
      Scene::statistic(things.volume, "ImageSampleDistance"));
    return Scene::mapperOf(things.upright)->GetLastImageSampleDistance();
  };
  EXPECT_EQ(distances(2., 3., false), 2.);
  EXPECT_EQ(distances(3., 2., false), 2.);
  EXPECT_EQ(distances(2., 3., true), 3.);
  EXPECT_EQ(distances(3., 2., true), 3.);
  things.volume->VisibilityOff();
  scene.render();
  EXPECT_EQ(Scene::mapperOf(things.flat)->GetLastImageSampleDistance(), 3.);
}

} // namespace

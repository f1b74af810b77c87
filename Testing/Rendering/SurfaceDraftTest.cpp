// Isosurfaces traced with fewer rays than pixels: their depths, when they are drawn, and layers that become one.
#include "PlaneSurface.h"

#include "vtkAbstractArray.h"
#include "vtkHardwareSelector.h"
#include "vtkSelection.h"
#include "vtkSelectionNode.h"

using namespace treeamr::test;

namespace
{

/// Seconds: more than any frame takes, and less.
constexpr double plenty = 1e6;
constexpr double nothing = 1e-9;
constexpr double interactive = 15.;
constexpr double still = 0.002;

using SurfaceDraftTest = PlaneSurfaceTest;

} // namespace

// Polygons meet a draft where they meet the surface.
TEST_F(SurfaceDraftTest, hasTheDepthsOfThePlane)
{
  for (const bool isParallel : { false, true })
  {
    Scene scene(200, 150);
    vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
    Scene::mapperOf(actor)->AutoAdjustSampleDistancesOff();
    scene.setCamera(isParallel);
    for (const double distance : { 1., 2., 4.5 })
    {
      Scene::mapperOf(actor)->SetImageSampleDistance(distance);
      expectPlaneDepths(
        scene, actor, reach - 0.02 * distance); // where a pixel's own ray meets the plane, too
      EXPECT_EQ(Scene::mapperOf(actor)->GetLastImageSampleDistance(), distance);
    }
  }
}

TEST_F(SurfaceDraftTest, isDrawnOnlyWhileSomethingMoves)
{
  for (const auto& [opacity, peeling] :
    { std::pair{ 1., false }, std::pair{ 0.4, false }, std::pair{ 0.4, true } })
  {
    Scene scene;
    vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
    scene.renderer->SetUseDepthPeeling(peeling); // several passes of a frame are one frame
    actor->GetProperty()->SetOpacity(opacity);
    vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
    mapper->SetInteractiveRenderTime(nothing);
    scene.setCamera();
    scene.window->SetDesiredUpdateRate(still);
    const auto full = scene.render();
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 1.);
    scene.window->SetDesiredUpdateRate(interactive);
    EXPECT_EQ(scene.render(), full) << "a still camera loses nothing";
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 1.);

    mapper->SetValue(0, 0.1);
    scene.render();
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 10.) << "another surface";
    mapper->SetValue(0, 0.);
    scene.window->SetDesiredUpdateRate(still);
    scene.render();
    scene.window->SetDesiredUpdateRate(interactive);

    vtkCamera* camera = scene.renderer->GetActiveCamera();
    camera->Azimuth(1.);
    const auto draft = scene.render();
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 10.);
    EXPECT_EQ(scene.render(), draft) << "nothing has moved";
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 10.);
    mapper->SetInteractiveRenderTime(plenty);
    camera->Azimuth(1.);
    scene.render();
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 1.) << "there is time";
    mapper->SetInteractiveRenderTime(nothing);
    camera->Azimuth(-2.);
    scene.render();
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 10.);
    scene.window->SetDesiredUpdateRate(still);
    EXPECT_EQ(scene.render().size(), full.size());
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 1.);

    mapper->AutoAdjustSampleDistancesOff();
    scene.window->SetDesiredUpdateRate(interactive);
    camera->Azimuth(1.);
    scene.render();
    EXPECT_EQ(mapper->GetLastImageSampleDistance(), 1.);
  }
}

TEST_F(SurfaceDraftTest, isNeverSelectedFrom)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera();
  const auto selected = [&] {
    vtkNew<vtkHardwareSelector> selector;
    selector->SetRenderer(scene.renderer);
    selector->SetArea(0, 0, scene.width() - 1, scene.height() - 1);
    selector->SetFieldAssociation(vtkDataObject::FIELD_ASSOCIATION_CELLS);
    auto selection = vtkSmartPointer<vtkSelection>::Take(selector->Select());
    return selection->GetNumberOfNodes() == 0
      ? vtkIdType(0)
      : selection->GetNode(0)->GetSelectionList()->GetNumberOfTuples();
  };
  scene.render();
  const vtkIdType cells = selected();
  EXPECT_GT(cells, 20);
  Scene::mapperOf(actor)->AutoAdjustSampleDistancesOff();
  Scene::mapperOf(actor)->SetImageSampleDistance(10.);
  scene.render();
  EXPECT_EQ(Scene::mapperOf(actor)->GetLastImageSampleDistance(), 10.);
  EXPECT_EQ(selected(), cells);
}

// Alone among what is peeled, layers become one before the peels: as many as there are, to where something is opaque.
TEST_F(SurfaceDraftTest, layersAloneInDepthPeelingAreAllThere)
{
  constexpr double opacity = 0.3;
  Color color{ 0.8, 0.6, 0.4 };
  for (const bool withOpaque : { false, true })
  {
    Scene scene;
    vtkActor* actor = scene.addIsosurface(planeGrid(), "x", 0.);
    vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
    mapper->SetNumberOfContours(7);
    for (int i = 0; i < 7; ++i)
    {
      mapper->SetValue(i, -0.6 + 0.2 * i);
    }
    vtkProperty* property = actor->GetProperty();
    property->SetColor(color.data());
    property->SetAmbient(1.);
    property->SetDiffuse(0.);
    property->SetSpecular(0.);
    property->SetOpacity(opacity);
    scene.renderer->SetUseDepthPeeling(true);
    scene.renderer->SetMaximumNumberOfPeels(1);
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    camera->SetPosition(6., 0., 0.);
    camera->SetFocalPoint(0., 0., 0.);
    camera->SetViewUp(0., 0., 1.);
    scene.renderer->ResetCameraClippingRange();
    int layers = 7;
    Color behind{};
    scene.renderer->GetBackground(behind.data());
    if (withOpaque)
    {
      behind = { 1., 1., 1. };
      layers = 4; // 0 to 0.6
      vtkActor* wall = scene.addRectangle({ -0.1, 0., 0. }, { 0., 3., 0. }, { 0., 0., 3. }, behind);
      wall->GetProperty()->SetLighting(false);
    }
    const auto pixels = scene.render();
    const auto& pixel =
      pixels[static_cast<std::size_t>(scene.height() / 2) * scene.width() + scene.width() / 2];
    const double passes = std::pow(1. - opacity, layers);
    for (int c = 0; c < 3; ++c)
    {
      EXPECT_NEAR(pixel[c], (1. - passes) * color[c] + passes * behind[c], 2.5 / 255.) << withOpaque << c;
    }
  }
}

// Far away cells are smaller than pixels: a draft draws them together, and only a draft.
TEST_F(SurfaceDraftTest, hasTheLevelOfDetail)
{
  Scene scene;
  scene.useFloatTarget();
  vtkActor* actor = scene.addIsosurface(makeTestGrid(), "x", 0.1);
  vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
  mapper->SetInteractiveRenderTime(plenty); // one ray a pixel
  scene.setCamera();
  scene.window->SetDesiredUpdateRate(still);
  const auto full = scene.render();
  const vtkIdType octants = mapper->GetNumberOfPrimitives();
  scene.window->SetDesiredUpdateRate(interactive);
  const auto draft = [&](double pixels) {
    mapper->SetLevelOfDetail(pixels);
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    camera->Azimuth(1.);
    scene.render();
    camera->Azimuth(-1.);
    return scene.render();
  };
  EXPECT_EQ(draft(0.), full);
  EXPECT_EQ(draft(1e-3), full);
  const auto coarse = draft(1e3);
  EXPECT_EQ(mapper->GetLastImageSampleDistance(), 1.);
  EXPECT_NE(coarse, full);
  EXPECT_EQ(scene.render(), coarse) << "nothing has moved";
  EXPECT_EQ(draft(1e3), coarse);
  scene.window->SetDesiredUpdateRate(still);
  EXPECT_EQ(scene.render(), full);
  EXPECT_EQ(mapper->GetNumberOfPrimitives(), octants);
  // So is one of other isovalues, and what is selected is never.
  scene.window->SetDesiredUpdateRate(interactive);
  mapper->SetValue(0, -0.3);
  const auto other = scene.render();
  mapper->SetValue(0, 0.1);
  EXPECT_EQ(scene.render(), coarse);
  EXPECT_NE(other, coarse);
}

// vtkTreeAMRIsosurfaceMapper: depths against analytic surfaces, picking, what is rebuilt.
#include "PlaneSurface.h"

#include "MapperInput.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHardwareSelector.h"
#include "vtkInformation.h"
#include "vtkPlane.h"
#include "vtkPropPicker.h"
#include "vtkSelection.h"
#include "vtkSelectionNode.h"
#include "vtkTreeAMRExampleSource.h"

#include <algorithm>

using namespace treeamr::test;

using IsosurfaceMapperTest = PlaneSurfaceTest;

TEST_F(IsosurfaceMapperTest, planeInPerspective)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera();
  expectPlaneDepths(scene, actor);
}

TEST_F(IsosurfaceMapperTest, planeInParallelProjection)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera(true);
  expectPlaneDepths(scene, actor);
}

TEST_F(IsosurfaceMapperTest, planeOfARotatedAndUnevenlyScaledActor)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  actor->SetScale(1.4, 0.5, 0.8);
  actor->RotateWXYZ(40., 1., 2., -1.);
  actor->SetPosition(0.4, -0.2, 0.3);
  scene.setCamera();
  expectPlaneDepths(scene, actor);
}

// In world coordinates, whatever the actor's matrix; taken away again, the surface is whole.
TEST_F(IsosurfaceMapperTest, clippingPlanes)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  actor->SetScale(1.4, 0.5, 0.8);
  actor->RotateWXYZ(40., 1., 2., -1.);
  actor->SetPosition(0.4, -0.2, 0.3);
  scene.setCamera();
  scene.render();
  const std::vector<float> whole = scene.depths();
  const std::array<std::array<Point, 2>, 2> planes{ { { { { 0.1, -0.2, 0.3 }, { 1., 0.2, -0.3 } } },
    { { { 0.4, -0.6, 0.3 }, { -0.5, 1., 0. } } } } };
  for (const auto& [origin, direction] : planes)
  {
    vtkNew<vtkPlane> plane;
    plane->SetOrigin(origin.data());
    plane->SetNormal(direction.data());
    actor->GetMapper()->AddClippingPlane(plane);
  }
  scene.render();
  const std::vector<float> depths = scene.depths();
  int shown = 0;
  int hidden = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const std::size_t pixel = static_cast<std::size_t>(y) * scene.width() + x;
      const PixelRay ray = scene.ray(x, y);
      const PixelRay dataRay = Scene::inDataOf(actor, ray);
      const double s = Scene::meet(dataRay, center, normal);
      if (whole[pixel] == 1.f || !(s > 0. && s < 1.) || !isInside(dataRay.at(s)))
      {
        continue;
      }
      bool isLeft = true;
      bool isNear = false; // the edge
      for (const auto& [origin, direction] : planes)
      {
        const Point p = ray.at(s);
        double distance = 0.;
        for (int a = 0; a < 3; ++a)
        {
          distance += (p[a] - origin[a]) * direction[a];
        }
        isLeft = isLeft && distance >= 0.;
        isNear = isNear || std::abs(distance) < 1e-6;
      }
      if (!isNear)
      {
        ASSERT_EQ(depths[pixel], isLeft ? whole[pixel] : 1.f) << "pixel " << x << ", " << y;
      }
      (isLeft ? shown : hidden) += 1;
    }
  }
  EXPECT_GT(shown, 50);
  EXPECT_GT(hidden, 50);
  actor->GetMapper()->RemoveAllClippingPlanes();
  scene.render();
  EXPECT_EQ(scene.depths(), whole);
}

TEST_F(IsosurfaceMapperTest, planeWithCameraInside)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetPosition(0.5, 0.5, 0.6);
  camera->SetFocalPoint(0., 0., -0.3);
  scene.renderer->ResetCameraClippingRange();
  expectPlaneDepths(scene, actor);
}

TEST_F(IsosurfaceMapperTest, planeInTheSecondViewport)
{
  Scene scene(100, 50);
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.renderer->SetViewport(0.3, 0.1, 1., 0.9);
  vtkNew<vtkRenderer> other;
  other->SetViewport(0., 0., 0.3, 1.);
  scene.window->AddRenderer(other);
  scene.setCamera();
  expectPlaneDepths(scene, actor);
}

// The paper's Figure 10: exact away from the domain's edge.
TEST_F(IsosurfaceMapperTest, productOfCoordinatesOnTheSyntheticGrid)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  source->Update();
  Scene scene(120, 120);
  scene.addIsosurface(source->GetHyperTreeGridOutput(), "xyz", 6.5);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetFocalPoint(2., 2., 2.);
  camera->SetPosition(-4., -3., -6.);
  scene.renderer->ResetCamera();
  scene.render();
  const std::vector<float> depths = scene.depths();
  int compared = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const PixelRay ray = scene.ray(x, y);
      // First root by bisection after a march; the surface is smooth at this scale.
      const auto f = [&](double s) {
        const Point p = ray.at(s);
        return p[0] * p[1] * p[2] - 6.5;
      };
      const auto inDomain = [&](double s, double margin) {
        const Point p = ray.at(s);
        return std::min({ p[0], p[1], p[2] }) >= margin && std::max({ p[0], p[1], p[2] }) <= 4. - margin;
      };
      constexpr int steps = 2000;
      bool found = false;
      double low = 0.;
      for (int i = 0; i < steps && !found; ++i)
      {
        low = static_cast<double>(i) / steps;
        found = inDomain(low, 0.) && f(low) < 0. && f(low + 1. / steps) >= 0.;
      }
      double high = low + 1. / steps;
      // The domain's edge, half a coarse cell wide, must not have shown the ray a surface before.
      if (!found || !inDomain(low, 0.5) || !inDomain(low - 0.1, 0.5))
      {
        continue;
      }
      for (int i = 0; i < 60; ++i)
      {
        const double middle = 0.5 * (low + high);
        (f(middle) < 0. ? low : high) = middle;
      }
      ++compared;
      ASSERT_NEAR(depths[static_cast<std::size_t>(y) * scene.width() + x], windowDepth(scene, ray.at(low)),
        depthTolerance)
        << "pixel " << x << ", " << y;
    }
  }
  EXPECT_GT(compared, 500);
}

TEST_F(IsosurfaceMapperTest, componentsToContour)
{
  const auto grid = planeGrid();
  vtkCellData* cells = grid->GetCellData();
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("v");
  vectors->SetNumberOfComponents(2);
  for (vtkIdType i = 0; i < cells->GetArray("x")->GetNumberOfTuples(); ++i)
  {
    vectors->InsertNextTuple2(7., cells->GetArray("plane")->GetTuple1(i));
  }
  cells->AddArray(vectors);
  Scene scene;
  vtkActor* actor = scene.addIsosurface(grid, "v", 0.);
  Scene::mapperOf(actor)->SetIsosurfaceComponent(1);
  scene.setCamera();
  expectPlaneDepths(scene, actor);
}

TEST_F(IsosurfaceMapperTest, onlyWhatChangedIsRebuilt)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
  scene.setCamera();
  scene.render();
  const vtkMTimeType built = mapper->GetSurfaceBuildTime();
  EXPECT_GT(mapper->GetNumberOfPrimitives(), 0);

  scene.renderer->GetActiveCamera()->Azimuth(20.);
  expectPlaneDepths(scene, actor);
  actor->SetScale(0.9, 1., 1.);
  expectPlaneDepths(scene, actor);
  scene.window->SetSize(120, 88); // the same matrices
  expectPlaneDepths(scene, actor);
  actor->GetProperty()->SetColor(1., 0., 0.);
  scene.render();
  EXPECT_EQ(mapper->GetSurfaceBuildTime(), built);

  mapper->SetValue(0, 0.2);
  scene.render();
  const vtkMTimeType second = mapper->GetSurfaceBuildTime();
  EXPECT_GT(second, built);
  mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "x");
  scene.render();
  EXPECT_GT(mapper->GetSurfaceBuildTime(), second);
}

TEST_F(IsosurfaceMapperTest, isovalueOutOfRange)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 100.);
  scene.setCamera();
  for (const auto& pixel : scene.render())
  {
    ASSERT_EQ(pixel[0], 0.f);
  }
  EXPECT_EQ(Scene::mapperOf(actor)->GetNumberOfPrimitives(), 0);
}

TEST_F(IsosurfaceMapperTest, isovalues)
{
  vtkNew<vtkTreeAMRIsosurfaceMapper> mapper;
  EXPECT_EQ(mapper->GetNumberOfContours(), 1);
  EXPECT_EQ(mapper->GetValue(0), 0.);
  const vtkMTimeType made = mapper->GetMTime();
  mapper->GenerateValues(3, 1., 2.);
  EXPECT_GT(mapper->GetMTime(), made);
  std::array<double, 3> values;
  mapper->GetValues(values.data());
  EXPECT_EQ(values, (std::array{ 1., 1.5, 2. }));
  EXPECT_EQ(mapper->GetValues()[1], 1.5);
  mapper->SetNumberOfContours(2);
  mapper->SetValue(1, 4.);
  EXPECT_EQ(mapper->GetValue(1), 4.);
}

TEST_F(IsosurfaceMapperTest, noIsovalueDrawsNothing)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", 0.);
  scene.setCamera();
  const auto drawn = scene.render();
  Scene::mapperOf(actor)->SetNumberOfContours(0);
  for (const auto& pixel : scene.render())
  {
    ASSERT_EQ(pixel[0], 0.f);
  }
  Scene::mapperOf(actor)->SetValue(0, 0.);
  EXPECT_EQ(scene.render(), drawn);
}

// The first of several surfaces along the ray, whatever their order in the list.
TEST_F(IsosurfaceMapperTest, nearestOfSeveralIsovalues)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(planeGrid(), "plane", -0.3);
  Scene::mapperOf(actor)->SetValue(1, 0.);
  Scene::mapperOf(actor)->SetValue(2, -0.2);
  scene.setCamera();
  expectPlaneDepths(scene, actor);
}

// The picture of one actor is the mirror image of the other's: from a camera in the plane between them.
TEST_F(IsosurfaceMapperTest, actorsShareAMapper)
{
  Scene scene(120, 60);
  const auto grid = planeGrid();
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  actor->SetPosition(1.3, 0., 0.);
  vtkNew<vtkActor> mirrored;
  mirrored->SetMapper(actor->GetMapper());
  mirrored->SetScale(-1., 1., 1.);
  mirrored->SetPosition(-1.3, 0., 0.);
  scene.renderer->AddActor(mirrored);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetFocalPoint(0., 0., 0.);
  camera->SetPosition(0., 2., 5.);
  scene.renderer->ResetCamera();
  const auto expectSymmetry = [&](const std::vector<std::array<float, 4>>& pixels) {
    int drawn = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width() / 2; ++x)
      {
        const auto& left = pixels[y * scene.width() + x];
        const auto& right = pixels[y * scene.width() + scene.width() - 1 - x];
        drawn += left[0] > 0.1f && right[0] > 0.1f;
        ASSERT_NEAR(left[0], right[0], 1. / 255.) << "pixel " << x << ", " << y;
      }
    }
    EXPECT_GT(drawn, 300);
  };
  const auto first = scene.render();
  expectSymmetry(first);
  vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
  const vtkMTimeType built = mapper->GetSurfaceBuildTime();
  const vtkIdType primitives = mapper->GetNumberOfPrimitives();
  EXPECT_EQ(scene.render(), first);
  camera->Elevation(10.);
  expectSymmetry(scene.render());
  EXPECT_EQ(mapper->GetSurfaceBuildTime(), built);
  EXPECT_EQ(mapper->GetNumberOfPrimitives(), primitives);

  // An actor of its own renderer, and one that goes away.
  scene.renderer->RemoveActor(mirrored);
  vtkNew<vtkRenderer> other;
  other->SetViewport(0., 0., 0.5, 1.);
  scene.renderer->SetViewport(0.5, 0., 1., 1.);
  scene.window->AddRenderer(other);
  other->AddActor(actor);
  other->GetActiveCamera()->DeepCopy(camera);
  const auto alone = scene.render();
  other->GetActiveCamera()->Azimuth(40.);
  EXPECT_EQ(scene.render(), alone);
}

TEST_F(IsosurfaceMapperTest, mappersOfAGridShareTheSurface)
{
  const auto field = treeamr::acquireField(planeGrid(), { "plane", -1 });
  const auto surface = treeamr::acquireIsosurface(field, { 0., 0.5 });
  EXPECT_EQ(treeamr::acquireIsosurface(field, { 0., 0.5 }), surface);
  EXPECT_NE(treeamr::acquireIsosurface(field, { 0. }), surface);
  EXPECT_NE(
    treeamr::acquireIsosurface(treeamr::acquireField(planeGrid(), { "x", -1 }), { 0., 0.5 }), surface);
  std::weak_ptr<const treeamr::Isosurface> gone = treeamr::acquireIsosurface(field, { 0.25 });
  EXPECT_TRUE(gone.expired());
}

TEST_F(IsosurfaceMapperTest, withoutAnArrayTheActiveScalarsOrTheFirst)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkNew<vtkTreeAMRIsosurfaceMapper> mapper;
  mapper->SetInputData(grid);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  scene.renderer->AddActor(actor);
  scene.setCamera();
  expectPlaneDepths(scene, actor);
  grid->GetCellData()->SetActiveScalars("y");
  const vtkMTimeType built = mapper->GetSurfaceBuildTime();
  scene.render();
  EXPECT_GT(mapper->GetSurfaceBuildTime(), built);
}

TEST_F(IsosurfaceMapperTest, picking)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkActor* surface = scene.addIsosurface(grid, "plane", 0.);
  // A volume that is not pickable hides nothing from picking.
  vtkVolume* volume = scene.addVolume(grid, "x", { 1., 1., 1. }, 0.5);
  volume->PickableOff();
  MessageCounter messages(Scene::mapperOf(volume));
  vtkActor* rectangle =
    scene.addRectangle({ 0.9, 0.7, 1.2 }, { 0.4, 0., -0.2 }, { 0., 0.4, 0. }, { 1., 0., 0. });
  scene.setCamera();
  const auto colors = scene.render();
  vtkNew<vtkPropPicker> picker;
  int found[3] = { 0, 0, 0 };
  for (int y = 4; y < scene.height(); y += 8)
  {
    for (int x = 4; x < scene.width(); x += 8)
    {
      const PixelRay ray = scene.ray(x, y);
      const Point p = ray.at(Scene::meet(ray, center, normal));
      picker->Pick(x, y, 0., scene.renderer);
      vtkProp* prop = picker->GetViewProp();
      ++found[prop == surface ? 0 : prop == rectangle ? 1 : 2];
      if (prop == surface)
      {
        for (int a = 0; a < 3; ++a)
        {
          // On the surface seen through this pixel; away from the edge it is the plane.
          if (isInside(p))
          {
            // The picker looks along the pixel's corner.
            EXPECT_NEAR(picker->GetPickPosition()[a], p[a], 0.06);
          }
        }
      }
    }
  }
  EXPECT_TRUE(messages.warnings.empty());
  EXPECT_GT(found[0], 5);
  EXPECT_GE(found[1], 1);
  EXPECT_GT(found[2], 5);

  vtkNew<vtkHardwareSelector> selector;
  selector->SetRenderer(scene.renderer);
  selector->SetArea(0, 0, scene.width() - 1, scene.height() - 1);
  selector->SetActorPassOnly(true);
  const auto selection = vtkSmartPointer<vtkSelection>::Take(selector->Select());
  bool selected = false;
  for (unsigned int i = 0; i < selection->GetNumberOfNodes(); ++i)
  {
    selected = selected || selection->GetNode(i)->GetProperties()->Get(vtkSelectionNode::PROP()) == surface;
  }
  EXPECT_TRUE(selected);
  EXPECT_EQ(scene.render(), colors);
}

TEST_F(IsosurfaceMapperTest, bounds)
{
  vtkNew<vtkTreeAMRIsosurfaceMapper> mapper;
  EXPECT_GT(mapper->GetBounds()[0], mapper->GetBounds()[1]) << "uninitialised without input";
  mapper->SetInputData(planeGrid());
  EXPECT_EQ(mapper->GetBounds()[0], -1.);
  EXPECT_EQ(mapper->GetBounds()[5], 1.);
}

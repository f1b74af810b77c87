// Volumes and isosurfaces together with polygons, opaque and translucent, against the layers computed along
// each pixel's line of sight.
#include "CompositingScene.h"

#include "vtkLookupTable.h"

#include <cmath>

using namespace treeamr::test;

TEST_F(CompositingTest, opaquePolygonBehind)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(-2.5, 1.2, blue) };
  addRectangles(scene, rectangles);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, floatTolerance);
}

TEST_F(CompositingTest, opaquePolygonInside)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ obliqueRectangle(blue) };
  addRectangles(scene, rectangles);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, floatTolerance);
}

// Facing: of a multisampled window the depth read is that of one sample, beside the pixel's centre.
TEST_F(CompositingTest, opaquePolygonInsideInWindows)
{
  for (const int samples : { 0, 4 })
  {
    for (const bool stencil : { false, true })
    {
      Scene scene(60, 44, samples);
      scene.window->SetStencilCapable(stencil); // has another depth format
      vtkVolume* volume = addBox(scene);
      const std::vector<Rectangle> rectangles{ facingRectangle(0.3, 1., blue) };
      addRectangles(scene, rectangles);
      scene.setCamera();
      expectLayers(scene, volume, rectangles, eightBits);
    }
  }
}

TEST_F(CompositingTest, opaquePolygonInFront)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(2.2, 0.7, blue) };
  addRectangles(scene, rectangles);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, floatTolerance);
}

TEST_F(CompositingTest, opaquePolygonInParallelProjection)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(0.3, 1., blue) };
  addRectangles(scene, rectangles);
  scene.setCamera(true);
  expectLayers(scene, volume, rectangles, floatTolerance);
}

TEST_F(CompositingTest, opaquePolygonWithCameraInside)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ { { 0.7, 0.2, 0.3 }, { 0., 0.4, 0. }, { 0.1, 0., 0.4 }, blue } };
  addRectangles(scene, rectangles);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetPosition(-0.2, -0.3, 0.1);
  camera->SetFocalPoint(0.9, 0.4, 0.3);
  scene.renderer->ResetCameraClippingRange();
  expectLayers(scene, volume, rectangles, floatTolerance);
}

TEST_F(CompositingTest, opaquePolygonInTheSecondViewport)
{
  Scene scene(90, 40);
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(0.3, 1., blue) };
  addRectangles(scene, rectangles);
  scene.renderer->SetViewport(0.4, 0.1, 1., 0.9);
  vtkNew<vtkRenderer> other;
  other->SetViewport(0., 0., 0.4, 1.);
  scene.window->AddRenderer(other);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, eightBits);
}

// The pass keeps its images with 8 bits a channel and adds up to three roundings for each peel.
constexpr double peelTolerance = 3. / 255.;

TEST_F(CompositingTest, translucentPolygonThroughTheVolume)
{
  for (const int samples : { 0, 4 })
  {
    Scene scene(60, 44, samples);
    // VTK 9.2's own copy of multisampled depths for peeling fails without a stencil buffer.
    scene.window->SetStencilCapable(samples > 0);
    vtkVolume* volume = addBox(scene);
    const std::vector<Rectangle> rectangles{ obliqueRectangle(blue, 0.5) };
    addRectangles(scene, rectangles);
    peel(scene, 4);
    scene.setCamera();
    expectLayers(scene, volume, rectangles, peelTolerance);
  }
}

TEST_F(CompositingTest, translucentPolygonsAndAnOpaqueOne)
{
  Scene scene;
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(-0.2, 1., green, 0.4),
    facingRectangle(0.4, 0.8, blue, 0.5), facingRectangle(1.9, 0.6, white, 0.3),
    facingRectangle(-0.6, 1.1, red), facingRectangle(-2., 1.2, white, 0.6) };
  addRectangles(scene, rectangles);
  peel(scene, 4);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, peelTolerance, { false, 0.5 });
}

TEST_F(CompositingTest, translucentPolygonsOutsideOfTheVolume)
{
  Scene scene;
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(2., 0.6, white, 0.3),
    facingRectangle(-2.4, 1.2, green, 0.6) };
  addRectangles(scene, rectangles);
  peel(scene, 4);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, peelTolerance);
}

TEST_F(CompositingTest, translucentPolygonsInTheSecondViewport)
{
  Scene scene(90, 40);
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ facingRectangle(0.4, 0.8, blue, 0.5),
    facingRectangle(-0.4, 1., green, 0.4) };
  addRectangles(scene, rectangles);
  scene.renderer->SetViewport(0.4, 0.1, 1., 0.9);
  vtkNew<vtkRenderer> other;
  other->SetViewport(0., 0., 0.4, 1.);
  scene.window->AddRenderer(other);
  peel(scene, 4);
  scene.setCamera();
  expectLayers(scene, volume, rectangles, peelTolerance, { false, 0.4 });
}

TEST_F(CompositingTest, translucentPolygonsWithCameraInside)
{
  Scene scene;
  vtkVolume* volume = addBox(scene);
  const std::vector<Rectangle> rectangles{ { { 0.7, 0.2, 0.3 }, { 0., 0.4, 0. }, { 0.1, 0., 0.4 }, blue,
                                             0.5 },
    { { 0.4, 0.1, 0.2 }, { 0., 0.3, 0. }, { 0.1, 0., 0.3 }, green, 0.4 } };
  addRectangles(scene, rectangles);
  peel(scene, 4);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetPosition(-0.2, -0.3, 0.1);
  camera->SetFocalPoint(0.9, 0.4, 0.3);
  scene.renderer->ResetCameraClippingRange();
  expectLayers(scene, volume, rectangles, peelTolerance, { false, 0.4 });
}

// One peel takes the first and the last surface and the segments outside of them. The rest is blended as it
// comes: polygons in the order of their actors, here back to front, then the volume between them over both.
TEST_F(CompositingTest, moreTranslucentPolygonsThanPeels)
{
  Scene scene;
  vtkVolume* volume = addBox(scene);
  const std::array<Rectangle, 4> backToFront{ facingRectangle(-0.35, 0.9, red, 0.5),
    facingRectangle(-0.1, 0.9, green, 0.4), facingRectangle(0.15, 0.9, blue, 0.5),
    facingRectangle(0.4, 0.9, white, 0.3) };
  addRectangles(scene, { backToFront.begin(), backToFront.end() });
  peel(scene, 1);
  scene.setCamera();
  scene.renderer->SetBackground(background.data());
  const auto pixels = scene.render();
  int compared = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const PixelRay ray = scene.ray(x, y);
      std::array<double, 4> s;
      bool all = true;
      for (int i = 0; i < 4; ++i)
      {
        const auto at = hit(ray, backToFront[i]);
        all = all && at;
        s[i] = at.value_or(0.);
      }
      double entry;
      double exit;
      if (!all || !Scene::chord(ray, volume, Box(), entry, exit))
      {
        continue;
      }
      ++compared;
      const auto segment = [&](double from, double to) {
        const double length = std::max(0., std::min(to, exit) - std::max(from, entry)) * ray.length();
        return Layer{ orange, -std::expm1(-extinction * length) };
      };
      const auto polygon = [&](int i) { return Layer{ backToFront[i].color, backToFront[i].opacity }; };
      const Color color =
        composite({ segment(0., s[3]), polygon(3), segment(s[3], s[2]), segment(s[2], s[1]), polygon(2),
                    polygon(1), segment(s[1], s[0]), polygon(0), segment(s[0], 1.) },
          background);
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], color[c], peelTolerance)
          << "channel " << c << " of pixel " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(compared, 300);
}

TEST_F(CompositingTest, translucentPolygonsWithoutPeelingOfVolumes)
{
  for (const bool peeling : { false, true })
  {
    Scene scene;
    vtkVolume* volume = addBox(scene);
    const std::vector<Rectangle> rectangles{ facingRectangle(0.4, 0.8, blue, 0.5),
      facingRectangle(-0.6, 1., red) };
    addRectangles(scene, rectangles);
    scene.renderer->SetUseDepthPeeling(peeling);
    scene.renderer->SetUseDepthPeelingForVolumes(false);
    scene.setCamera();
    expectLayers(scene, volume, rectangles, peelTolerance, { true, 0.4 });
  }
}

TEST_F(SurfaceCompositingTest, insideItsVolume)
{
  Scene scene;
  scene.useFloatTarget();
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
  addSurface(scene, grid, green);
  scene.setCamera();
  expectLayers(scene, volume, { surface(green) }, floatTolerance);
}

TEST_F(SurfaceCompositingTest, insideItsVolumeMultisampled)
{
  Scene scene(60, 44, 4);
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
  addSurface(scene, grid, green);
  scene.setCamera();
  expectLayers(scene, volume, { surface(green) }, eightBits);
}

TEST_F(SurfaceCompositingTest, withOpaquePolygonsAcross)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  addSurface(scene, grid, green);
  const std::vector<Rectangle> across{ obliqueRectangle(blue), facingRectangle(-2.5, 1.2, red) };
  addRectangles(scene, across);
  scene.setCamera();
  // Where the two surfaces cross, depths are equal: no edge of a rectangle, so leave the line out by colour.
  std::vector<Rectangle> all = across;
  all.push_back(surface(green));
  scene.renderer->SetBackground(background.data());
  const auto pixels = scene.render();
  int different = 0;
  int compared = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      if (isEdge(scene, x, y, all))
      {
        continue;
      }
      ++compared;
      const Color color = expected(scene.ray(x, y), nullptr, all, {});
      bool same = true;
      for (int c = 0; c < 3; ++c)
      {
        same = same &&
          std::abs(pixels[static_cast<std::size_t>(y) * scene.width() + x][c] - color[c]) <= eightBits;
      }
      different += !same;
    }
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(compared, 1500);
}

TEST_F(SurfaceCompositingTest, opaqueAmongTranslucentPolygonsAndVolume)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
  addSurface(scene, grid, green);
  std::vector<Rectangle> rectangles{ facingRectangle(0.5, 0.8, blue, 0.5),
    facingRectangle(-1., 1., white, 0.5) };
  addRectangles(scene, rectangles);
  peel(scene, 4);
  scene.setCamera();
  rectangles.push_back(surface(green));
  expectLayers(scene, volume, rectangles, peelTolerance, { false, 0.5 });
}

TEST_F(SurfaceCompositingTest, translucentWithPeelingOfVolumes)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
  addSurface(scene, grid, green, 0.6);
  std::vector<Rectangle> rectangles{ facingRectangle(0.5, 0.8, blue, 0.5), facingRectangle(-1., 1., red) };
  addRectangles(scene, rectangles);
  peel(scene, 4);
  scene.setCamera();
  rectangles.push_back(surface(green, 0.6));
  expectLayers(scene, volume, rectangles, peelTolerance, { false, 0.5 });
}

// A mapper with two values, as many layers in most pixels, among all else that is translucent.
TEST_F(SurfaceCompositingTest, translucentLayersWithPeelingOfVolumes)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
  vtkActor* actor = addSurface(scene, grid, green, 0.6);
  Scene::mapperOf(actor)->SetValue(1, -0.4);
  Rectangle lower = surface(green, 0.6);
  lower.center[2] = -0.4;
  std::vector<Rectangle> rectangles{ facingRectangle(0.5, 0.8, blue, 0.5),
    facingRectangle(-0.3, 0.9, white, 0.4), facingRectangle(-1., 1., red) };
  addRectangles(scene, rectangles);
  peel(scene, 6);
  scene.setCamera();
  rectangles.push_back(surface(green, 0.6));
  rectangles.push_back(lower);
  expectLayers(scene, volume, rectangles, 2. * peelTolerance, { false, 0.6 });
}

// The order of the values is not that of their depths.
TEST_F(SurfaceCompositingTest, translucentLayersWithoutPeeling)
{
  for (const bool fromBelow : { false, true })
  {
    Scene scene;
    vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
    vtkActor* actor = addSurface(scene, grid, white, 0.6);
    vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
    mapper->SetValue(1, -0.4);
    mapper->ScalarVisibilityOn();
    mapper->SetScalarModeToUseCellFieldData();
    mapper->SelectColorArray("z");
    vtkNew<vtkLookupTable> table;
    table->SetNumberOfTableValues(2);
    table->SetTableRange(-0.4, level);
    table->SetTableValue(0, blue[0], blue[1], blue[2]);
    table->SetTableValue(1, green[0], green[1], green[2]);
    mapper->SetLookupTable(table);
    mapper->UseLookupTableScalarRangeOn();
    std::vector<Rectangle> rectangles{ facingRectangle(fromBelow ? 1.2 : -1.2, 1.1, red) };
    addRectangles(scene, rectangles);
    scene.setCamera();
    if (fromBelow)
    {
      scene.renderer->GetActiveCamera()->Elevation(180.);
      scene.renderer->ResetCameraClippingRange();
    }
    Rectangle lower = surface(blue, 0.6);
    lower.center[2] = -0.4;
    rectangles.push_back(surface(green, 0.6));
    rectangles.push_back(lower);
    expectLayers(scene, nullptr, rectangles, 2. * eightBits, { false, 0.4 });
  }
}

TEST_F(SurfaceCompositingTest, translucentWithoutPeeling)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  addSurface(scene, grid, green, 0.6);
  std::vector<Rectangle> rectangles{ facingRectangle(-1.2, 1.1, red) };
  addRectangles(scene, rectangles);
  scene.setCamera();
  rectangles.push_back(surface(green, 0.6));
  expectLayers(scene, nullptr, rectangles, 2. * eightBits);
}

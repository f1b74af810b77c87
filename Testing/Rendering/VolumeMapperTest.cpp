// vtkTreeAMRVolumeMapper alone: opacities of homogeneous boxes against analytic chords, settings, what is
// rebuilt.
#include "RenderingScene.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkDoubleArray.h"
#include "vtkPiecewiseFunction.h"
#include "vtkTransform.h"

#include <cmath>

using namespace treeamr::test;

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
constexpr double extinction = 0.8;

/// Sums of a few dozen floats of size 1.
constexpr double floatTolerance = 5e-6;

class VolumeMapperTest : public RenderingTest
{
protected:
  /// Every pixel against the chord through the box of `volume`, which must be homogeneous, in data units.
  static void expectChords(Scene& scene, vtkVolume* volume, double tolerance)
  {
    const auto pixels = scene.render();
    int inside = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        double entry;
        double exit;
        double alpha = 0.;
        if (Scene::chord(ray, volume, Box(), entry, exit))
        {
          alpha = -std::expm1(-extinction * (exit - entry) * Scene::inDataOf(volume, ray).length());
          ++inside;
        }
        const auto& pixel = pixels[static_cast<std::size_t>(y) * scene.width() + x];
        ASSERT_NEAR(pixel[3], alpha, tolerance) << "pixel " << x << ", " << y;
        for (int c = 0; c < 3; ++c)
        {
          ASSERT_NEAR(pixel[c], orange[c] * alpha, tolerance) << "pixel " << x << ", " << y;
        }
      }
    }
    EXPECT_GT(inside, scene.width() * scene.height() / 10);
  }
};

} // namespace

TEST_F(VolumeMapperTest, homogeneousCubeInPerspective)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.setCamera();
  expectChords(scene, volume, floatTolerance);
}

TEST_F(VolumeMapperTest, homogeneousCubeInParallelProjection)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.setCamera(true);
  expectChords(scene, volume, floatTolerance);
}

TEST_F(VolumeMapperTest, cameraInside)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetPosition(0.2, -0.3, 0.1);
  camera->SetFocalPoint(0.9, 0.4, 0.3);
  camera->SetViewAngle(70.);
  scene.renderer->ResetCameraClippingRange();
  expectChords(scene, volume, floatTolerance);
}

// As VTK's own volume mappers have it: a scaled volume is as opaque as before along its scaled rays.
TEST_F(VolumeMapperTest, rotatedAndUnevenlyScaledVolume)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  volume->SetScale(1.4, 0.3, 0.7);
  volume->RotateWXYZ(50., 1., 2., -1.);
  volume->SetPosition(0.4, -0.2, 0.3);
  scene.setCamera();
  expectChords(scene, volume, floatTolerance);
}

TEST_F(VolumeMapperTest, mirroredVolume)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  vtkNew<vtkTransform> transform;
  transform->Scale(-1., 1., 1.);
  transform->RotateZ(20.);
  volume->SetUserTransform(transform);
  scene.setCamera();
  expectChords(scene, volume, floatTolerance);
}

TEST_F(VolumeMapperTest, unitDistance)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, 4. * extinction);
  volume->GetProperty()->SetScalarOpacityUnitDistance(4.);
  scene.setCamera();
  expectChords(scene, volume, floatTolerance);
}

TEST_F(VolumeMapperTest, eightBitWindow)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.window->AlphaBitPlanesOn();
  scene.setCamera();
  expectChords(scene, volume, 0.501 / 255.);
}

TEST_F(VolumeMapperTest, multisampledWindow)
{
  Scene scene(60, 44, 4);
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.window->AlphaBitPlanesOn();
  scene.setCamera();
  expectChords(scene, volume, 0.501 / 255.);
}

TEST_F(VolumeMapperTest, twoViewports)
{
  Scene scene(90, 40);
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.window->AlphaBitPlanesOn();
  scene.renderer->SetViewport(0.4, 0.1, 1., 0.9);
  vtkNew<vtkRenderer> other;
  other->SetViewport(0., 0., 0.4, 1.);
  other->SetBackground(0.2, 0.4, 0.6);
  scene.window->AddRenderer(other);
  scene.setCamera();
  expectChords(scene, volume, 0.501 / 255.);
  const float* strange = scene.window->GetRGBAPixelData(0, 0, 35, 39, 0);
  for (int i = 0; i < 36 * 40; ++i)
  {
    ASSERT_NEAR(strange[4 * i], 0.2, 0.501 / 255.) << "the other renderer's pixel " << i;
  }
  delete[] strange;
}

TEST_F(VolumeMapperTest, oneMapperInTwoWindows)
{
  Scene first;
  vtkSmartPointer<vtkVolume> volume = first.addVolume(makeTestGrid(), "one", orange, extinction);
  first.window->AlphaBitPlanesOn();
  first.setCamera();
  expectChords(first, volume, 0.501 / 255.);
  first.renderer->RemoveVolume(volume);

  Scene second(50, 60);
  second.renderer->AddVolume(volume);
  second.window->AlphaBitPlanesOn();
  second.setCamera();
  expectChords(second, volume, 0.501 / 255.);
}

TEST_F(VolumeMapperTest, releasedResourcesComeBack)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.window->AlphaBitPlanesOn();
  scene.setCamera();
  expectChords(scene, volume, 0.501 / 255.);
  volume->ReleaseGraphicsResources(scene.window);
  expectChords(scene, volume, 0.501 / 255.);
}

TEST_F(VolumeMapperTest, skippingChangesNoBit)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(0.1, 0.);
  opacity->AddPoint(0.4, 0.9);
  opacity->AddPoint(0.6, 0.);
  volume->GetProperty()->SetScalarOpacity(opacity);
  scene.setCamera();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->SetVertexCacheSize(0); // counts every cell of every frame
  const auto skipping = scene.render();
  const double cells = Scene::statistic(volume, "ReconstructedCells");
  const double nodes = Scene::statistic(volume, "Nodes");
  mapper->SkipEmptySpaceOff();
  const auto everything = scene.render();
  EXPECT_EQ(skipping, everything);
  EXPECT_GT(Scene::statistic(volume, "ReconstructedCells"), cells);
  EXPECT_GT(Scene::statistic(volume, "Nodes"), nodes);
  EXPECT_GT(nodes, 0);
}

TEST_F(VolumeMapperTest, keepsValuesBetweenFrames)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  scene.setCamera();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  const auto first = scene.render();
  EXPECT_GT(Scene::statistic(volume, "ReconstructedCells"), 0);
  EXPECT_EQ(scene.render(), first);
  EXPECT_EQ(Scene::statistic(volume, "ReconstructedCells"), 0);
  mapper->SetVertexCacheSize(0);
  EXPECT_EQ(scene.render(), first);
  EXPECT_GT(Scene::statistic(volume, "ReconstructedCells"), 0);
}

TEST_F(VolumeMapperTest, moreSamplesPerCell)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  // Where the opacity hardly varies more samples are not taken.
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(-1., 0.);
  opacity->AddPoint(1., 0.9);
  volume->GetProperty()->SetScalarOpacity(opacity);
  scene.setCamera();
  scene.render();
  const double samples = Scene::statistic(volume, "Samples");
  Scene::mapperOf(volume)->SetSamplesPerCell(8.);
  scene.render();
  EXPECT_GT(Scene::statistic(volume, "Samples"), 3 * samples);
}

// A camera rebuilds nothing, a colour map the table, an array the field.
TEST_F(VolumeMapperTest, onlyWhatChangedIsRebuilt)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "x", orange, extinction);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  scene.setCamera();
  EXPECT_EQ(mapper->GetFieldBuildTime(), 0u);
  scene.render();
  const vtkMTimeType field = mapper->GetFieldBuildTime();
  const vtkMTimeType table = mapper->GetTransferFunctionBuildTime();
  EXPECT_GT(field, 0u);
  EXPECT_GT(table, field);

  scene.renderer->GetActiveCamera()->Azimuth(30.);
  mapper->SetSamplesPerCell(3.);
  const auto before = scene.render();
  EXPECT_EQ(mapper->GetFieldBuildTime(), field);
  EXPECT_EQ(mapper->GetTransferFunctionBuildTime(), table);

  volume->GetProperty()->GetRGBTransferFunction(0)->AddRGBPoint(1., 0., 0., 1.);
  const auto after = scene.render();
  EXPECT_NE(before, after);
  EXPECT_EQ(mapper->GetFieldBuildTime(), field);
  const vtkMTimeType newTable = mapper->GetTransferFunctionBuildTime();
  EXPECT_GT(newTable, table);

  volume->GetProperty()->SetScalarOpacityUnitDistance(0.5);
  EXPECT_NE(after, scene.render());
  EXPECT_EQ(mapper->GetFieldBuildTime(), field);
  EXPECT_GT(mapper->GetTransferFunctionBuildTime(), newTable);

  mapper->SelectScalarArray("y");
  scene.render();
  EXPECT_GT(mapper->GetFieldBuildTime(), field);

  // Values changed in place.
  const vtkMTimeType secondField = mapper->GetFieldBuildTime();
  grid->GetCellData()->GetArray("y")->Fill(0.25);
  grid->GetCellData()->GetArray("y")->Modified();
  scene.render();
  EXPECT_GT(mapper->GetFieldBuildTime(), secondField);
}

TEST_F(VolumeMapperTest, arraySelection)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "y", orange, extinction);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(-1., 0.);
  opacity->AddPoint(1., 0.9);
  volume->GetProperty()->SetScalarOpacity(opacity);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  scene.setCamera();
  const auto byName = scene.render();

  mapper->SelectScalarArray(2);
  EXPECT_EQ(scene.render(), byName) << "by number";
  mapper->SelectScalarArray("one");
  EXPECT_NE(scene.render(), byName) << "another array";

  mapper->SetScalarModeToDefault();
  grid->GetCellData()->SetActiveScalars("y");
  EXPECT_EQ(scene.render(), byName) << "active scalars, default mode";
  mapper->SetScalarModeToUseCellData();
  EXPECT_EQ(scene.render(), byName) << "active scalars, cell data";

  // The first array without active scalars.
  grid->GetCellData()->SetActiveScalars(nullptr);
  const auto first = scene.render();
  mapper->SetScalarModeToUseCellFieldData();
  EXPECT_EQ(scene.render(), first);
}

TEST_F(VolumeMapperTest, vectorArrays)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkCellData* cells = grid->GetCellData();
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("v");
  vectors->SetNumberOfComponents(3);
  vtkNew<vtkDoubleArray> magnitude;
  magnitude->SetName("m");
  for (vtkIdType i = 0; i < cells->GetArray("x")->GetNumberOfTuples(); ++i)
  {
    const double v[3] = { cells->GetArray("x")->GetTuple1(i), cells->GetArray("y")->GetTuple1(i),
      cells->GetArray("z")->GetTuple1(i) };
    vectors->InsertNextTuple(v);
    magnitude->InsertNextValue(std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  cells->AddArray(vectors);
  cells->AddArray(magnitude);
  vtkVolume* volume = scene.addVolume(grid, "m", orange, extinction);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(-1., 0.);
  opacity->AddPoint(1., 0.9);
  volume->GetProperty()->SetScalarOpacity(opacity);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  scene.setCamera();
  const auto byMagnitude = scene.render();
  mapper->SelectScalarArray("v");
  EXPECT_EQ(scene.render(), byMagnitude);
  mapper->SelectScalarArray("y");
  const auto byY = scene.render();
  mapper->SelectScalarArray("v");
  mapper->SetVectorMode(vtkTreeAMRVolumeMapper::COMPONENT);
  mapper->SetVectorComponent(1);
  EXPECT_EQ(scene.render(), byY);
}

TEST_F(VolumeMapperTest, bounds)
{
  vtkNew<vtkTreeAMRVolumeMapper> mapper;
  EXPECT_GT(mapper->GetBounds()[0], mapper->GetBounds()[1]) << "uninitialised without input";
  GridOptions options;
  options.min = { -3., 1., 0. };
  options.max = { 5., 2., 7. };
  mapper->SetInputData(makeGrid(options, {}));
  const std::array<double, 6> expected{ -3., 5., 1., 2., 0., 7. };
  for (int i = 0; i < 6; ++i)
  {
    EXPECT_EQ(mapper->GetBounds()[i], expected[i]);
  }
}

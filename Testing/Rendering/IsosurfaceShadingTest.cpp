// Lighting and ambient occlusion of isosurfaces against VTK's own polygons, and their colours by arrays.
#include "PlaneSurface.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkLight.h"
#include "vtkLightKit.h"
#include "vtkLookupTable.h"

#include <algorithm>
#include <limits>
#include <numeric>

using namespace treeamr::test;

namespace
{

constexpr double eightBits = 1. / 255.;

// VTK's polygon of the same plane, same property, same lights: the same colours.
class IsosurfaceLightingTest : public PlaneSurfaceTest
{
protected:
  static void setProperty(vtkProperty* property)
  {
    property->LightingOn();
    property->SetAmbientColor(0.9, 0.2, 0.4);
    property->SetDiffuseColor(0.5, 0.8, 0.6);
    property->SetSpecularColor(1., 0.9, 0.7);
    property->SetAmbient(0.15);
    property->SetDiffuse(0.6);
  }

  /// Largest difference of a channel, pixel by pixel.
  template <class Setup>
  static std::vector<double> differencesFromPolygon(const Setup& setup)
  {
    Scene surface;
    Scene polygon;
    vtkActor* actor = surface.addIsosurface(planeGrid(), "plane", 0.);
    vtkActor* polygonActor = addPolygon(polygon);
    setProperty(actor->GetProperty());
    setProperty(polygonActor->GetProperty());
    setup(surface, actor);
    setup(polygon, polygonActor);
    surface.setCamera();
    polygon.setCamera();
    polygon.renderer->GetActiveCamera()->DeepCopy(surface.renderer->GetActiveCamera());
    polygon.renderer->ResetCameraClippingRange();
    const auto pixels = surface.render();
    const auto expected = polygon.render();
    std::vector<double> differences;
    for (int y = 0; y < surface.height(); ++y)
    {
      for (int x = 0; x < surface.width(); ++x)
      {
        const PixelRay ray = Scene::inDataOf(actor, surface.ray(x, y));
        if (isInside(ray.at(Scene::meet(ray, center, normal))))
        {
          const std::size_t i = static_cast<std::size_t>(y) * surface.width() + x;
          double difference = 0.;
          for (int c = 0; c < 3; ++c)
          {
            difference = std::max<double>(difference, std::abs(pixels[i][c] - expected[i][c]));
          }
          differences.push_back(difference);
        }
      }
    }
    EXPECT_GT(differences.size(), 150u);
    return differences;
  }

  template <class Setup>
  static void expectSameAsPolygon(const Setup& setup)
  {
    const std::vector<double> differences = differencesFromPolygon(setup);
    EXPECT_LE(*std::max_element(differences.begin(), differences.end()), 1.01 * eightBits);
  }
};

class IsosurfaceColorTest : public PlaneSurfaceTest
{
protected:
  /// The surface coloured by `array`, unlit, and its pixels against colorOf(the point).
  template <class ColorOf>
  static void expectColors(Scene& scene, const ColorOf& colorOf, int atLeast = 150)
  {
    const auto pixels = scene.render();
    int compared = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const Point p = ray.at(Scene::meet(ray, center, normal));
        Color expected;
        if (!isInside(p) || !colorOf(p, expected))
        {
          continue;
        }
        ++compared;
        for (int c = 0; c < 3; ++c)
        {
          // One entry of the table beside the expected one.
          ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], expected[c], 3. * eightBits)
            << "channel " << c << " of pixel " << x << ", " << y;
        }
      }
    }
    EXPECT_GT(compared, atLeast);
  }

  static vtkSmartPointer<vtkLookupTable> makeTable(double min, double max)
  {
    auto table = vtkSmartPointer<vtkLookupTable>::New();
    table->SetHueRange(0.05, 0.6);
    table->SetTableRange(min, max);
    table->SetNanColor(0.2, 0.1, 0.7, 1.);
    table->Build();
    return table;
  }

  static vtkTreeAMRIsosurfaceMapper* addColored(Scene& scene, vtkHyperTreeGrid* grid, const char* array)
  {
    vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
    actor->GetProperty()->LightingOff();
    actor->GetProperty()->SetAmbient(0.);
    vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
    mapper->ScalarVisibilityOn();
    mapper->SetScalarModeToUseCellFieldData();
    mapper->SelectColorArray(array);
    scene.setCamera();
    return mapper;
  }
};

} // namespace

TEST_F(IsosurfaceLightingTest, headlight)
{
  expectSameAsPolygon([](Scene&, vtkActor*) {});
}

TEST_F(IsosurfaceLightingTest, lightingOff)
{
  expectSameAsPolygon([](Scene&, vtkActor* actor) { actor->GetProperty()->LightingOff(); });
}

TEST_F(IsosurfaceLightingTest, directionalLights)
{
  expectSameAsPolygon([](Scene& scene, vtkActor* actor) {
    actor->GetProperty()->SetSpecular(0.5);
    actor->GetProperty()->SetSpecularPower(6.);
    vtkNew<vtkLight> sceneLight;
    sceneLight->SetLightTypeToSceneLight();
    sceneLight->SetPosition(-2., 3., 4.);
    sceneLight->SetFocalPoint(0., 0., 1.);
    sceneLight->SetColor(0.9, 0.7, 1.);
    sceneLight->SetIntensity(0.6);
    scene.renderer->AddLight(sceneLight);
    vtkNew<vtkLight> cameraLight;
    cameraLight->SetLightTypeToCameraLight();
    cameraLight->SetPosition(1., 1., 1.);
    cameraLight->SetFocalPoint(0., 0., 0.);
    cameraLight->SetIntensity(0.4);
    scene.renderer->AddLight(cameraLight);
    vtkNew<vtkLight> off;
    off->SetSwitch(0);
    scene.renderer->AddLight(off);
  });
}

TEST_F(IsosurfaceLightingTest, positionalLightsWithConeAndAttenuation)
{
  expectSameAsPolygon([](Scene& scene, vtkActor* actor) {
    actor->GetProperty()->SetSpecular(0.5);
    actor->GetProperty()->SetSpecularPower(6.);
    vtkNew<vtkLight> spot;
    spot->SetLightTypeToSceneLight();
    spot->PositionalOn();
    spot->SetPosition(1., 1.5, 1.2);
    spot->SetFocalPoint(0.1, 0., 0.);
    spot->SetConeAngle(24.);
    spot->SetExponent(3.);
    spot->SetAttenuationValues(0.5, 0.1, 0.2);
    scene.renderer->AddLight(spot);
    vtkNew<vtkLight> bulb;
    bulb->SetLightTypeToSceneLight();
    bulb->PositionalOn();
    bulb->SetPosition(-1.2, 0.9, 1.);
    bulb->SetConeAngle(180.);
    bulb->SetAttenuationValues(1., 0.2, 0.3);
    bulb->SetColor(0.3, 0.6, 1.);
    scene.renderer->AddLight(bulb);
    vtkNew<vtkLight> lamp;
    lamp->SetLightTypeToCameraLight();
    lamp->PositionalOn();
    lamp->SetPosition(0.3, 0.4, 0.6);
    lamp->SetConeAngle(40.);
    lamp->SetColor(0.9, 0.3, 0.2);
    scene.renderer->AddLight(lamp);
  });
}

TEST_F(IsosurfaceLightingTest, lightKitOnARotatedAndUnevenlyScaledActor)
{
  expectSameAsPolygon([](Scene& scene, vtkActor* actor) {
    actor->SetScale(1.3, 0.7, 0.9);
    actor->RotateWXYZ(25., 1., 2., -1.);
    actor->SetPosition(0.1, -0.2, 0.1);
    vtkNew<vtkLightKit> kit;
    kit->AddLightsToRenderer(scene.renderer);
    scene.renderer->SetAutomaticLightCreation(false);
  });
}

// The pass reads positions and normals of what is drawn, at random places and from coarse copies, which also
// see that the polygon goes on beyond the grid: so the same on average only.
TEST_F(IsosurfaceLightingTest, ambientOcclusion)
{
  const std::vector<double> differences = differencesFromPolygon([](Scene& scene, vtkActor*) {
    scene.renderer->SetUseSSAO(true);
    scene.renderer->SetSSAORadius(0.1);
    scene.renderer->SetSSAOBias(0.01);
  });
  const double sum = std::accumulate(differences.begin(), differences.end(), 0.);
  EXPECT_LE(sum / static_cast<double>(differences.size()), eightBits);
}

TEST_F(IsosurfaceColorTest, anotherArray)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  const auto byTable = [&](const Point& p, Color& color) {
    table->GetColor(p[0], color.data());
    return true;
  };
  expectColors(scene, byTable);
  const vtkMTimeType built = mapper->GetSurfaceBuildTime();

  mapper->SelectColorArray(1);
  expectColors(scene, byTable);

  // The mapper's own range.
  mapper->UseLookupTableScalarRangeOff();
  mapper->SetScalarRange(-0.4, 0.3);
  expectColors(scene, byTable);
  EXPECT_EQ(table->GetRange()[0], -0.4);
  EXPECT_EQ(mapper->GetSurfaceBuildTime(), built);
}

TEST_F(IsosurfaceColorTest, activeScalars)
{
  Scene scene;
  const auto grid = planeGrid();
  grid->GetCellData()->SetActiveScalars("y");
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  mapper->SetScalarModeToUseCellData();
  const auto byTable = [&](const Point& p, Color& color) {
    table->GetColor(p[1], color.data());
    return true;
  };
  expectColors(scene, byTable);
  mapper->SetScalarModeToDefault();
  expectColors(scene, byTable);
}

TEST_F(IsosurfaceColorTest, theContouredArray)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "plane");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  expectColors(scene, [&](const Point&, Color& color) {
    table->GetColor(0., color.data());
    return true;
  });
}

TEST_F(IsosurfaceColorTest, cellsWithoutAValue)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkDataArray* values = grid->GetCellData()->GetArray("x");
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
  {
    if (values->GetTuple1(i) > 0.25)
    {
      values->SetTuple1(i, std::numeric_limits<double>::quiet_NaN());
    }
  }
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  int without = 0;
  expectColors(
    scene,
    [&](const Point& p, Color& color) {
      if (p[0] > 0.5)
      {
        ++without;
        std::copy(table->GetNanColor(), table->GetNanColor() + 3, color.begin());
        return true;
      }
      table->GetColor(p[0], color.data());
      return p[0] < -0.01;
    },
    100);
  EXPECT_GT(without, 20);
}

TEST_F(IsosurfaceColorTest, componentsOfVectors)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkCellData* cells = grid->GetCellData();
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("v");
  vectors->SetNumberOfComponents(3);
  for (vtkIdType i = 0; i < cells->GetArray("x")->GetNumberOfTuples(); ++i)
  {
    vectors->InsertNextTuple3(cells->GetArray("x")->GetTuple1(i), cells->GetArray("y")->GetTuple1(i), 0.);
  }
  cells->AddArray(vectors);
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "v");
  const auto table = makeTable(-0.8, 0.9);
  table->SetVectorModeToComponent();
  table->SetVectorComponent(1);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  const auto byY = [&](const Point& p, Color& color) {
    table->GetColor(p[1], color.data());
    return true;
  };
  expectColors(scene, byY);
  table->SetVectorModeToMagnitude();
  mapper->ColorByArrayComponent("v", 1);
  expectColors(scene, byY);
}

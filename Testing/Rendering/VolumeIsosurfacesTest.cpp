// Isosurfaces of vtkTreeAMRVolumeMapper, alone and inside the volume, against the layers computed along each
// pixel's line of sight. The field is z, whose surfaces are planes up to half a root cell from the box's ends.
#include "PlaneSurface.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkContourValues.h"
#include "vtkLight.h"
#include "vtkPiecewiseFunction.h"

#include <algorithm>
#include <cmath>

using namespace treeamr::test;

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
constexpr Color blue{ 0.2, 0.3, 0.9 };
constexpr Color background{ 0.1, 0.2, 0.3 };
constexpr double extinction = 0.8;
/// Of the isosurfaces inside the volume, 1 - exp(-extinction) without a scale.
constexpr double opacityScale = 0.6;
/// The depth buffer's last bit, and values in single precision.
constexpr double floatTolerance = 2e-5;

struct Isovalue
{
  double z;
  Color color;
  double opacity;
};
const std::vector<Isovalue> isovalues{ { 0.3, { 0.8, 0.1, 0.2 }, 0.4 }, { -0.4, { 0.1, 0.9, 0.6 }, 0.7 } };

/// A polygon across the whole view: z as a function of x.
struct Slope
{
  double z0;
  double perX;
  double opacity = 1.;
};

class VolumeIsosurfacesTest : public RenderingTest
{
protected:
  static vtkSmartPointer<vtkHyperTreeGrid> grid()
  {
    GridOptions options;
    options.roots = { 4, 4, 4 };
    // Where levels meet the box's sides the reconstruction is not that of the plane.
    options.refine = [](const Point& c, int level) {
      return level < 2 && std::abs(c[0]) < 0.5 && std::abs(c[1]) < 0.5 && c[0] + c[2] > 0.1;
    };
    return makeGrid(options,
      { { "z", [](const Point& p) { return p[2]; } }, { "x", [](const Point& p) { return p[0]; } } });
  }

  /// Colours and opacities of the isovalues; alone, or inside a volume that is orange all over.
  static vtkVolume* addSurfaces(Scene& scene, bool alone)
  {
    vtkVolume* volume = scene.addVolume(grid(), "z", orange, extinction);
    vtkVolumeProperty* property = volume->GetProperty();
    vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
    for (std::size_t i = 0; i < isovalues.size(); ++i)
    {
      const Isovalue& v = isovalues[i];
      property->GetIsoSurfaceValues()->SetValue(static_cast<int>(i), v.z);
      if (alone)
      {
        property->GetRGBTransferFunction(0)->AddRGBPoint(v.z, v.color[0], v.color[1], v.color[2]);
        property->GetScalarOpacity(0)->AddPoint(v.z, v.opacity);
      }
    }
    // Surfaces have no extent.
    property->SetScalarOpacityUnitDistance(alone ? 0.1 : 1.);
    alone ? mapper->SetBlendModeToIsoSurface() : mapper->ShowIsosurfacesOn();
    mapper->SetIsosurfaceOpacityScale(alone ? 1. : opacityScale);
    return volume;
  }

  static void addSlope(Scene& scene, const Slope& slope)
  {
    scene.addRectangle(
      { 0., 0., slope.z0 }, { 3., 0., 3. * slope.perX }, { 0., 3., 0. }, blue, slope.opacity);
  }

  static Color expected(
    const PixelRay& ray, vtkVolume* volume, bool alone, const std::vector<Slope>& slopes, bool& ambiguous)
  {
    double entry = 2.;
    double exit = 2.;
    Scene::chord(ray, volume, Box(), entry, exit);
    std::vector<std::pair<double, Layer>> hits;
    for (const Isovalue& v : isovalues)
    {
      const double s = Scene::meet(ray, { 0., 0., v.z }, { 0., 0., 1. });
      if (s > entry && s < exit)
      {
        const double opacity = -std::expm1(-extinction) * opacityScale;
        hits.push_back({ s, alone ? Layer{ v.color, v.opacity } : Layer{ orange, opacity } });
      }
    }
    for (const Slope& slope : slopes)
    {
      const double s = Scene::meet(ray, { 0., 0., slope.z0 }, { -slope.perX, 0., 1. });
      if (s > 0. && s < 1.)
      {
        hits.push_back({ s, { blue, slope.opacity } });
      }
    }
    std::sort(hits.begin(), hits.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < hits.size(); ++i)
    {
      ambiguous = ambiguous || hits[i].first - hits[i - 1].first < 1e-5;
    }
    std::vector<Layer> layers;
    double reached = entry;
    const auto medium = [&](double to) {
      const double length = std::max(0., std::min(to, exit) - reached) * ray.length();
      reached = std::max(reached, std::min(to, exit));
      layers.push_back({ orange, alone ? 0. : -std::expm1(-extinction * length) });
    };
    for (const auto& [s, layer] : hits)
    {
      medium(s);
      layers.push_back(layer);
    }
    medium(exit);
    return composite(layers, background);
  }

  static void expectLayers(Scene& scene, vtkVolume* volume, bool alone, const std::vector<Slope>& slopes = {},
    double tolerance = floatTolerance)
  {
    scene.renderer->SetBackground(background.data());
    const auto pixels = scene.render();
    int compared = 0;
    int changed = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        bool ambiguous = false;
        const Color color = expected(scene.ray(x, y), volume, alone, slopes, ambiguous);
        if (ambiguous)
        {
          continue;
        }
        ++compared;
        changed += std::abs(color[0] - background[0]) > 0.05;
        for (int c = 0; c < 3; ++c)
        {
          ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], color[c], tolerance)
            << "channel " << c << " of pixel " << x << ", " << y << (alone ? ", alone" : ", inside");
        }
      }
    }
    EXPECT_GT(compared, 0.95 * static_cast<double>(pixels.size()));
    EXPECT_GT(changed, static_cast<int>(pixels.size()) / 10);
  }
};

} // namespace

TEST_F(VolumeIsosurfacesTest, planesAloneAndInsideTheVolume)
{
  for (const bool alone : { false, true })
  {
    for (const bool parallel : { false, true })
    {
      Scene scene;
      scene.useFloatTarget();
      vtkVolume* volume = addSurfaces(scene, alone);
      scene.setCamera(parallel);
      expectLayers(scene, volume, alone);
    }
  }
}

TEST_F(VolumeIsosurfacesTest, cameraBetweenTheSurfaces)
{
  for (const bool alone : { false, true })
  {
    Scene scene;
    scene.useFloatTarget();
    vtkVolume* volume = addSurfaces(scene, alone);
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    camera->SetPosition(0.2, -0.3, 0.1);
    camera->SetFocalPoint(0.9, 0.4, 0.3);
    camera->SetViewAngle(100.);
    scene.renderer->ResetCameraClippingRange();
    expectLayers(scene, volume, alone);
  }
}

TEST_F(VolumeIsosurfacesTest, opaquePolygonsBeforeBetweenAndBehind)
{
  for (const bool alone : { false, true })
  {
    // The last one passes through both surfaces.
    for (const Slope& slope : { Slope{ 0.6, 0. }, Slope{ 0.05, 0. }, Slope{ -0.7, 0. }, Slope{ 0., 0.8 } })
    {
      Scene scene;
      scene.useFloatTarget();
      vtkVolume* volume = addSurfaces(scene, alone);
      addSlope(scene, slope);
      scene.setCameraAlongZ();
      expectLayers(scene, volume, alone, { slope });
    }
  }
}

// Peeling draws the volume in parts: each has its own surfaces, and none twice.
TEST_F(VolumeIsosurfacesTest, translucentPolygonsBetween)
{
  for (const bool alone : { false, true })
  {
    Scene scene;
    vtkVolume* volume = addSurfaces(scene, alone);
    const std::vector<Slope> slopes{ { 0.05, 0.1, 0.5 }, { -0.05, 0.9, 0.3 } };
    for (const Slope& slope : slopes)
    {
      addSlope(scene, slope);
    }
    scene.renderer->SetUseDepthPeeling(true);
    scene.renderer->SetUseDepthPeelingForVolumes(true);
    scene.renderer->SetMaximumNumberOfPeels(4);
    scene.renderer->SetOcclusionRatio(0.);
    scene.setCameraAlongZ();
    expectLayers(scene, volume, alone, slopes, 3. / 255.);
  }
}

TEST_F(VolumeIsosurfacesTest, interactiveFramesHaveFewerHits)
{
  for (const bool alone : { false, true })
  {
    Scene scene;
    scene.useFloatTarget();
    vtkVolume* volume = addSurfaces(scene, alone);
    Scene::mapperOf(volume)->SetInteractiveRenderTime(1e-9);
    scene.setCameraAlongZ();
    scene.window->SetDesiredUpdateRate(15.);
    // The same colour all over: magnified it is still exact.
    expectLayers(scene, volume, alone);
    EXPECT_EQ(Scene::statistic(volume, "ImageSampleDistance"), 5.);
    EXPECT_EQ(Scene::statistic(volume, "SurfaceHits"), 2 * 12 * 9);
    scene.window->SetDesiredUpdateRate(0.002);
    expectLayers(scene, volume, alone);
    EXPECT_EQ(Scene::statistic(volume, "SurfaceHits"), 2 * 60 * 44);
  }
}

TEST_F(VolumeIsosurfacesTest, builtWhenAskedForAndWhenFieldOrValuesChange)
{
  Scene scene;
  vtkVolume* volume = addSurfaces(scene, false);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  vtkVolumeProperty* property = volume->GetProperty();
  scene.setCamera();
  mapper->ShowIsosurfacesOff();
  const auto without = scene.render();
  EXPECT_EQ(mapper->GetIsosurfaceBuildTime(), 0u);
  EXPECT_EQ(Scene::statistic(volume, "SurfaceBytes"), 0.);
  EXPECT_EQ(Scene::statistic(volume, "SurfaceHits"), 0.);

  mapper->ShowIsosurfacesOn();
  EXPECT_NE(scene.render(), without);
  const vtkMTimeType built = mapper->GetIsosurfaceBuildTime();
  EXPECT_GT(built, 0u);
  EXPECT_GT(Scene::statistic(volume, "SurfaceBytes"), 0.);

  scene.renderer->GetActiveCamera()->Azimuth(20.);
  const auto turned = scene.render();
  property->GetRGBTransferFunction(0)->AddRGBPoint(0.3, 1., 1., 1.);
  EXPECT_NE(scene.render(), turned);
  mapper->SetIsosurfaceOpacityScale(0.2);
  mapper->SetBlendModeToIsoSurface();
  scene.render();
  EXPECT_EQ(Scene::statistic(volume, "KeptBytes"), 0.) << "of a volume that is not shown";
  mapper->SetBlendModeToComposite();
  scene.render();
  EXPECT_GT(Scene::statistic(volume, "KeptBytes"), 0.);
  EXPECT_EQ(mapper->GetIsosurfaceBuildTime(), built);

  const auto two = scene.render();
  property->GetIsoSurfaceValues()->SetNumberOfContours(1);
  EXPECT_NE(scene.render(), two);
  const vtkMTimeType rebuilt = mapper->GetIsosurfaceBuildTime();
  EXPECT_GT(rebuilt, built);
  mapper->SelectScalarArray("x");
  scene.render();
  EXPECT_GT(mapper->GetIsosurfaceBuildTime(), rebuilt);

  mapper->ShowIsosurfacesOff();
  scene.render();
  EXPECT_EQ(Scene::statistic(volume, "SurfaceBytes"), 0.);
  EXPECT_EQ(Scene::statistic(volume, "SurfaceHits"), 0.);
}

TEST_F(VolumeIsosurfacesTest, noValuesShowNothing)
{
  Scene scene;
  vtkVolume* volume = addSurfaces(scene, true);
  volume->GetProperty()->GetIsoSurfaceValues()->SetNumberOfContours(0);
  scene.renderer->SetBackground(background.data());
  scene.setCamera();
  const auto alone = scene.render();
  volume->VisibilityOff();
  EXPECT_EQ(scene.render(), alone);
  volume->VisibilityOn();
  Scene::mapperOf(volume)->SetBlendModeToComposite();
  const auto composite = scene.render();
  Scene::mapperOf(volume)->ShowIsosurfacesOff();
  EXPECT_EQ(scene.render(), composite);
}

using VolumeIsosurfacesShadingTest = PlaneSurfaceTest;

// Opaque and shaded, an oblique plane looks like the isosurface mapper's.
TEST_F(VolumeIsosurfacesShadingTest, litLikeAnActor)
{
  const auto place = [](vtkProp3D* prop) {
    prop->SetScale(1.4, 0.5, 0.8);
    prop->RotateWXYZ(50., 1., 2., -1.);
    prop->SetPosition(0.4, -0.2, 0.3);
  };
  const auto look = [](Scene& scene) {
    scene.useFloatTarget();
    scene.setCamera();
    for (const Point& position : { Point{ 3., 1., 2. }, Point{ -4., 5., 1. } })
    {
      vtkNew<vtkLight> light;
      light->SetLightTypeToSceneLight();
      light->SetPosition(position[0], position[1], position[2]);
      light->SetPositional(position[0] > 0.);
      light->SetDiffuseColor(0.9, 0.7, 0.5);
      scene.renderer->AddLight(light);
    }
  };
  Scene actorScene;
  vtkActor* actor = actorScene.addIsosurface(planeGrid(), "plane", 0.);
  vtkProperty* surface = actor->GetProperty();
  surface->SetColor(orange[0], orange[1], orange[2]);
  surface->SetSpecularColor(1., 1., 1.);
  surface->SetAmbient(0.2);
  surface->SetDiffuse(0.5);
  surface->SetSpecular(0.3);
  surface->SetSpecularPower(4.);
  place(actor);
  look(actorScene);

  Scene volumeScene;
  vtkVolume* volume = volumeScene.addVolume(planeGrid(), "plane", orange, 100.);
  Scene::mapperOf(volume)->SetBlendModeToIsoSurface();
  vtkVolumeProperty* property = volume->GetProperty();
  property->GetIsoSurfaceValues()->SetValue(0, 0.);
  property->ShadeOn();
  property->SetAmbient(0.2);
  property->SetDiffuse(0.5);
  property->SetSpecular(0.3);
  property->SetSpecularPower(4.);
  place(volume);
  look(volumeScene);
  volumeScene.renderer->GetActiveCamera()->DeepCopy(actorScene.renderer->GetActiveCamera());

  const auto expected = actorScene.render();
  const auto pixels = volumeScene.render();
  int drawn = 0;
  float darkest = 1.f;
  float brightest = 0.f;
  for (std::size_t i = 0; i < pixels.size(); ++i)
  {
    for (int c = 0; c < 3; ++c)
    {
      ASSERT_NEAR(pixels[i][c], expected[i][c], 1e-5) << i;
    }
    if (pixels[i][3] > 0.f)
    {
      ++drawn;
      darkest = std::min(darkest, pixels[i][0]);
      brightest = std::max(brightest, pixels[i][0]);
    }
  }
  EXPECT_GT(drawn, 150);
  EXPECT_GT(brightest - darkest, 0.01f);

  property->ShadeOff();
  for (const auto& pixel : volumeScene.render())
  {
    ASSERT_NEAR(pixel[0], pixel[3] > 0.f ? orange[0] : 0., 1e-5);
  }
}

// Two bowls in each other, of which the upper one stands in the light of the lower one.
TEST_F(VolumeIsosurfacesShadingTest, occludedAndInShadowLikeAnActor)
{
  GridOptions options;
  options.roots = { 8, 8, 8 };
  const vtkSmartPointer<vtkHyperTreeGrid> bowls = makeGrid(
    options, { { "bowl", [](const Point& p) { return p[1] - 0.4 * (p[0] * p[0] + p[2] * p[2]); } } });
  std::vector<std::array<float, 4>> pictures[2][2];
  for (const bool ofVolume : { false, true })
  {
    Scene scene;
    scene.useFloatTarget();
    vtkNew<vtkLight> light;
    light->SetLightTypeToSceneLight();
    light->SetPosition(1., 6., 2.);
    scene.renderer->AddLight(light);
    vtkActor* actor = ofVolume ? nullptr : scene.addIsosurface(bowls, "bowl", -0.3);
    vtkVolume* volume = ofVolume ? scene.addVolume(bowls, "bowl", orange, 100.) : nullptr;
    const auto set = [](auto* mapper) {
      mapper->SetAmbientOcclusionSamples(8);
      mapper->SetAmbientOcclusionRadius(0.2);
      mapper->ShadowsOn();
    };
    if (ofVolume)
    {
      Scene::mapperOf(volume)->SetBlendModeToIsoSurface();
      Scene::mapperOf(volume)->SetIsosurfaceOpacityScale(0.5);
      volume->GetProperty()->ShadeOn();
      volume->GetProperty()->SetAmbient(0.);
      volume->GetProperty()->SetDiffuse(1.);
      volume->GetProperty()->SetSpecular(0.);
      volume->GetProperty()->GetIsoSurfaceValues()->SetValue(0, -0.3);
      volume->GetProperty()->GetIsoSurfaceValues()->SetValue(1, 0.1);
    }
    else
    {
      actor->GetProperty()->SetColor(orange[0], orange[1], orange[2]);
      actor->GetProperty()->SetOpacity(0.5); // opaque, it would have the nearest points alone share their rays
      Scene::mapperOf(actor)->SetValue(1, 0.1);
    }
    scene.setCamera();
    pictures[ofVolume][0] = scene.render();
    ofVolume ? set(Scene::mapperOf(volume)) : set(Scene::mapperOf(actor));
    pictures[ofVolume][1] = scene.render();
  }
  int darkened = 0;
  for (std::size_t i = 0; i < pictures[0][0].size(); ++i)
  {
    for (int c = 0; c < 3; ++c)
    {
      ASSERT_NEAR(pictures[1][0][i][c], pictures[0][0][i][c], 1e-5) << i;
      ASSERT_NEAR(pictures[1][1][i][c], pictures[0][1][i][c], 1e-5) << i;
    }
    darkened += pictures[1][1][i][0] < pictures[1][0][i][0] - 0.02f;
  }
  EXPECT_GT(darkened, 50);
}

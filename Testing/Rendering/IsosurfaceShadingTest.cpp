// Lighting and ambient occlusion of isosurfaces against VTK's own polygons.
#include "PlaneSurface.h"

#include "vtkContourValues.h"
#include "vtkLight.h"
#include "vtkLightCollection.h"
#include "vtkLightKit.h"
#include "vtkOpenGLRenderer.h"
#include "vtkPolyDataMapper.h"
#include "vtkSphereSource.h"
#include "vtkTransform.h"

#include <algorithm>
#include <cmath>
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

/// Two parallel planes; the camera is between them and looks along the gap onto the one, white, without a
/// headlight.
class IsosurfaceVisibilityTest : public RenderingTest
{
protected:
  static constexpr double gap = 0.5;
  /// Of the grid's bounds.
  static inline const double diagonal = std::sqrt(12.);

  IsosurfaceVisibilityTest()
  {
    actor_ = scene_.addIsosurface(makeTestGrid(), "z", -0.25);
    mapper_ = Scene::mapperOf(actor_);
    mapper_->SetValue(1, -0.25 + gap);
    mapper_->AutoAdjustSampleDistancesOff(); // a slow machine's drafts have fewer rays, also of these
    vtkCamera* camera = scene_.renderer->GetActiveCamera();
    camera->SetPosition(0., 0.1, -0.25 + 0.9 * gap);
    camera->SetFocalPoint(0., 0., -0.25);
    camera->SetViewUp(0., 1., 0.);
    camera->SetViewAngle(40.);
    camera->SetClippingRange(0.1, 5.);
    scene_.renderer->RemoveAllLights();
    scene_.renderer->SetAutomaticLightCreation(false);
    addLight(0.)->SetIntensity(0.); // without any light surfaces show their colours unlit
    actor_->GetProperty()->SetAmbient(0.4);
    actor_->GetProperty()->SetDiffuse(0.5);
  }

  vtkLight* addLight(double z)
  {
    vtkNew<vtkLight> light;
    light->SetLightTypeToSceneLight();
    light->PositionalOn();
    light->SetConeAngle(180.);
    light->SetPosition(0., 0., z);
    scene_.renderer->AddLight(light);
    return light;
  }

  double meanOf(const std::vector<std::array<float, 4>>& pixels)
  {
    double sum = 0.;
    for (const auto& pixel : pixels)
    {
      sum += pixel[0] / static_cast<double>(pixels.size());
    }
    return sum;
  }

  Scene scene_;
  vtkActor* actor_;
  vtkTreeAMRIsosurfaceMapper* mapper_;
};

} // namespace

TEST_F(IsosurfaceLightingTest, headlight)
{
  expectSameAsPolygon([](Scene&, vtkActor*) {});
}

// A sphere in cells of a quarter of its radius: smooth normals are those of the sphere, those of pieces are not.
TEST_F(IsosurfaceLightingTest, curvedSurfaceInSmoothAndFlatInterpolation)
{
  constexpr double radius = 0.7;
  GridOptions options;
  options.roots = { 12, 12, 12 };
  const auto grid =
    makeGrid(options, { { "r", [](const Point& p) { return std::hypot(p[0], p[1], p[2]); } } });
  Scene scene(120, 90);
  vtkActor* actor = scene.addIsosurface(grid, "r", radius);
  actor->GetProperty()->LightingOn();
  scene.setCamera();
  Point toLight; // the headlight is behind the camera
  scene.renderer->GetActiveCamera()->GetDirectionOfProjection(toLight.data());
  const auto largestError = [&](int interpolation) {
    actor->GetProperty()->SetInterpolation(interpolation);
    const auto pixels = scene.render();
    double largest = 0.;
    int seen = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        double squared = 0.; // of the ray's length, and so on, for the nearer root
        double half = 0.;
        double rest = -radius * radius;
        for (int a = 0; a < 3; ++a)
        {
          const double d = ray.far[a] - ray.near[a];
          squared += d * d;
          half += d * ray.near[a];
          rest += ray.near[a] * ray.near[a];
        }
        const double discriminant = half * half - squared * rest;
        if (discriminant < 0.)
        {
          continue;
        }
        const Point p = ray.at((-half - std::sqrt(discriminant)) / squared);
        const double cosine = -(p[0] * toLight[0] + p[1] * toLight[1] + p[2] * toLight[2]) / radius;
        if (cosine > 0.6) // off the silhouette, where a small distance makes a great difference
        {
          ++seen;
          largest = std::max(largest, std::abs(pixels[x + scene.width() * y][0] - cosine));
        }
      }
    }
    EXPECT_GT(seen, 500);
    return largest;
  };
  EXPECT_LT(largestError(VTK_GOURAUD), 0.03);
  EXPECT_GT(largestError(VTK_FLAT), 0.1);
  EXPECT_LT(largestError(VTK_GOURAUD), 0.03);
}

TEST_F(IsosurfaceLightingTest, lightingOff)
{
  expectSameAsPolygon([](Scene&, vtkActor* actor) { actor->GetProperty()->LightingOff(); });
}

// What VTK shows of polygons where no light shines: all of their colour.
TEST_F(IsosurfaceLightingTest, noLights)
{
  expectSameAsPolygon([](Scene& scene, vtkActor* actor) {
    actor->GetProperty()->SetSpecular(0.5);
    scene.renderer->SetAutomaticLightCreation(false);
  });
  expectSameAsPolygon([](Scene& scene, vtkActor* actor) {
    actor->GetProperty()->SetSpecular(0.5);
    scene.renderer->SetAutomaticLightCreation(false);
    vtkNew<vtkLight> off;
    off->SwitchOff();
    off->PositionalOn();
    scene.renderer->AddLight(off);
  });
}

// Spheres in the same light: the whole of the highlight, which the mirrored light of a headlight would have smaller.
TEST_F(IsosurfaceLightingTest, highlightsOfASphere)
{
  constexpr double radius = 0.7;
  GridOptions options;
  options.roots = { 32, 32, 32 };
  const auto grid =
    makeGrid(options, { { "r", [](const Point& p) { return std::hypot(p[0], p[1], p[2]); } } });
  const auto shine = [](auto* property) {
    property->SetAmbient(0.1);
    property->SetDiffuse(0.3);
    property->SetSpecular(0.6);
    property->SetSpecularPower(15.);
  };
  const auto highlightOf = [&](const std::function<void(Scene&)>& add, bool parallel, bool sceneLight) {
    Scene scene(160, 120);
    add(scene);
    scene.setCamera(parallel);
    scene.renderer->GetActiveCamera()->SetParallelScale(0.8);
    scene.renderer->GetActiveCamera()->SetViewAngle(50.);
    scene.renderer->GetActiveCamera()->SetPosition(1.2, 0.9, 1.6);
    scene.renderer->ResetCameraClippingRange();
    if (sceneLight)
    {
      vtkNew<vtkLight> light;
      light->SetLightTypeToSceneLight();
      light->SetPosition(1., 3., 2.);
      scene.renderer->AddLight(light);
    }
    int bright = 0;
    for (const auto& pixel : scene.render())
    {
      bright += pixel[0] > 0.6;
    }
    return bright;
  };
  for (const auto& [parallel, sceneLight] :
    { std::pair(false, false), { true, false }, { false, true }, { true, true } })
  {
    const int polygons = highlightOf(
      [&](Scene& scene) {
        vtkNew<vtkSphereSource> sphere;
        sphere->SetRadius(radius);
        sphere->SetThetaResolution(120);
        sphere->SetPhiResolution(120);
        vtkNew<vtkPolyDataMapper> mapper;
        mapper->SetInputConnection(sphere->GetOutputPort());
        vtkNew<vtkActor> actor;
        actor->SetMapper(mapper);
        shine(actor->GetProperty());
        scene.renderer->AddActor(actor);
      },
      parallel, sceneLight);
    const int actor =
      highlightOf([&](Scene& scene) { shine(scene.addIsosurface(grid, "r", radius)->GetProperty()); },
        parallel, sceneLight);
    const int volume = highlightOf(
      [&](Scene& scene) {
        vtkVolume* prop = scene.addVolume(grid, "r", { 1., 1., 1. }, 100.);
        prop->GetProperty()->GetIsoSurfaceValues()->SetValue(0, radius);
        prop->GetProperty()->ShadeOn();
        shine(prop->GetProperty());
        Scene::mapperOf(prop)->SetBlendModeToIsoSurface();
      },
      parallel, sceneLight);
    EXPECT_GT(polygons, 150);
    EXPECT_NEAR(actor, polygons, 0.03 * polygons) << parallel << sceneLight;
    EXPECT_NEAR(volume, polygons, 0.03 * polygons) << parallel << sceneLight;
  }
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

// The camera's own matrix turns the lights of the scene with the scene, and a user's moves the others.
TEST_F(IsosurfaceLightingTest, modelTransformOfTheCameraAndUserTransformOfLights)
{
  for (const bool headlightAlone : { true, false })
  {
    expectSameAsPolygon([&](Scene& scene, vtkActor* actor) {
      actor->GetProperty()->SetSpecular(0.5);
      actor->GetProperty()->SetSpecularPower(6.);
      vtkNew<vtkTransform> model;
      model->RotateWXYZ(25., 1., -2., 0.5);
      model->Scale(1.1, 0.8, 0.9);
      scene.renderer->GetActiveCamera()->SetModelTransformMatrix(model->GetMatrix());
      vtkNew<vtkTransform> ofLights;
      ofLights->RotateX(70.);
      vtkOpenGLRenderer::SafeDownCast(scene.renderer)->SetUserLightTransform(ofLights);
      if (!headlightAlone)
      {
        vtkNew<vtkLight> light;
        light->SetLightTypeToSceneLight();
        light->PositionalOn();
        light->SetPosition(-0.5, 1.5, 2.);
        light->SetConeAngle(60.);
        scene.renderer->AddLight(light);
        vtkNew<vtkLight> lamp;
        lamp->SetLightTypeToCameraLight();
        lamp->SetPosition(1., 0.5, 1.);
        lamp->SetIntensity(0.5);
        scene.renderer->AddLight(lamp);
      }
    });
  }
}

TEST_F(IsosurfaceLightingTest, lightsOnBothSides)
{
  for (const double turned : { 0., 180. })
  {
    expectSameAsPolygon([turned](Scene& scene, vtkActor* actor) {
      actor->RotateX(turned);
      actor->GetProperty()->SetSpecular(0.4);
      actor->GetProperty()->SetSpecularPower(4.);
      for (const double side : { -1., 1. })
      {
        vtkNew<vtkLight> light;
        light->SetLightTypeToSceneLight();
        light->SetPosition(2. * side, 3. * side, 4. * side);
        light->SetFocalPoint(0., 0., 0.);
        light->SetColor(0.8, 0.5 + 0.3 * side, 0.5 - 0.3 * side);
        scene.renderer->AddLight(light);
      }
    });
  }
}

TEST_F(IsosurfaceLightingTest, positionalHeadlightAndWideConeOnAMirroredActor)
{
  expectSameAsPolygon([](Scene& scene, vtkActor* actor) {
    actor->SetScale(-1., 0.8, 1.1);
    // VTK turns a mirrored polygon's own normals away from the eye, not those that it makes of the faces.
    actor->GetProperty()->SetInterpolationToFlat();
    actor->GetProperty()->SetSpecular(0.5);
    actor->GetProperty()->SetSpecularPower(6.);
    vtkNew<vtkLight> headlight;
    headlight->SetLightTypeToHeadlight();
    headlight->PositionalOn();
    headlight->SetConeAngle(5.);
    headlight->SetExponent(2.);
    headlight->SetIntensity(0.5);
    scene.renderer->AddLight(headlight);
    // Such cones are none, in VTK, too.
    vtkNew<vtkLight> wide;
    wide->SetLightTypeToSceneLight();
    wide->PositionalOn();
    wide->SetConeAngle(90.);
    wide->SetPosition(-0.6, 1., 1.2);
    wide->SetColor(0.3, 0.4, 0.5);
    scene.renderer->AddLight(wide);
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

// A ray at the cosine c meets the other plane at gap / c, and the part c^2 of the rays has less.
TEST_F(IsosurfaceVisibilityTest, ambientOcclusionBetweenPlanes)
{
  const double reach = 1.25 * gap;
  mapper_->SetAmbientOcclusionRadius(reach / diagonal);
  EXPECT_NEAR(meanOf(scene_.render()), 0.4, eightBits);
  mapper_->SetAmbientOcclusionSamples(16);
  for (const auto& pixel : scene_.render())
  {
    // One ray of 16 is six steps of the picture's 256; pixels share theirs.
    EXPECT_NEAR(pixel[0], 0.4 * (gap / reach) * (gap / reach), 2. * eightBits);
  }
  mapper_->SetAmbientOcclusionSamples(64);
  EXPECT_NEAR(meanOf(scene_.render()), 0.4 * (gap / reach) * (gap / reach), eightBits);
  actor_->SetScale(0.5, 0.5, -0.5); // the radius shrinks, too
  vtkCamera* camera = scene_.renderer->GetActiveCamera();
  camera->SetPosition(0., 0.05, 0.125 - 0.45 * gap);
  camera->SetFocalPoint(0., 0., 0.125);
  camera->SetClippingRange(0.05, 5.);
  EXPECT_NEAR(meanOf(scene_.render()), 0.4 * (gap / reach) * (gap / reach), eightBits);
  actor_->GetProperty()->SetOpacity(0.5);
  EXPECT_NEAR(
    meanOf(scene_.render()), 0.5 * 0.4 * (1. - 0.5 * (1. - (gap / reach) * (gap / reach))), eightBits);
  actor_->GetProperty()->SetOpacity(1.);
  actor_->GetProperty()->LightingOff();
  EXPECT_NEAR(meanOf(scene_.render()), 0.9, eightBits);
}

TEST_F(IsosurfaceVisibilityTest, ambientOcclusionGathersInInteractiveFrames)
{
  constexpr int frames = 6;
  scene_.useFloatTarget(); // eight bits could not tell some numbers of rays apart
  mapper_->SetAmbientOcclusionRadius(1.25 * gap / diagonal);
  mapper_->SetAmbientOcclusionSamples(frames * vtkTreeAMRIsosurfaceMapper::InteractiveSamples);
  const auto still = scene_.render();
  vtkCamera* camera = scene_.renderer->GetActiveCamera();
  for (const bool peeling : { false, true })
  {
    // Several passes of one frame are one frame.
    scene_.renderer->SetUseDepthPeeling(peeling);
    camera->Azimuth(1.);
    scene_.render();
    camera->Azimuth(-1.);
    scene_.window->SetDesiredUpdateRate(15.);
    for (int i = 0; i < frames; ++i)
    {
      const auto pixels = scene_.render();
      EXPECT_EQ(pixels == still, i + 1 == frames) << "frame " << i;
    }
    EXPECT_EQ(scene_.render(), still);
    scene_.window->SetDesiredUpdateRate(0.002);
  }
  // A still frame takes what is missing.
  camera->Azimuth(1.);
  scene_.render();
  camera->Azimuth(-1.);
  scene_.window->SetDesiredUpdateRate(15.);
  EXPECT_NE(scene_.render(), still);
  scene_.window->SetDesiredUpdateRate(0.002);
  EXPECT_EQ(scene_.render(), still);
  // More samples are added to those there are, fewer are others.
  mapper_->SetAmbientOcclusionSamples(5);
  EXPECT_NE(scene_.render(), still);
  mapper_->SetAmbientOcclusionSamples(frames * vtkTreeAMRIsosurfaceMapper::InteractiveSamples);
  EXPECT_EQ(scene_.render(), still);
}

// Each eye gathers its own: two pictures in turn, which would be one that starts again with every frame.
TEST_F(IsosurfaceVisibilityTest, ambientOcclusionGathersForBothEyes)
{
  constexpr int frames = 4;
  mapper_->SetAmbientOcclusionRadius(1.25 * gap / diagonal);
  mapper_->SetAmbientOcclusionSamples(frames * vtkTreeAMRIsosurfaceMapper::InteractiveSamples);
  scene_.renderer->GetActiveCamera()->SetEyeAngle(20.);
  scene_.window->SetStereoTypeToRedBlue();
  scene_.window->StereoRenderOn();
  const auto still = scene_.render();
  scene_.renderer->GetActiveCamera()->Azimuth(1.);
  scene_.render();
  scene_.renderer->GetActiveCamera()->Azimuth(-1.);
  scene_.window->SetDesiredUpdateRate(15.);
  EXPECT_NE(scene_.render(), still);
  for (int i = 1; i < frames; ++i)
  {
    scene_.render();
  }
  EXPECT_EQ(scene_.render(), still);
}

TEST_F(IsosurfaceVisibilityTest, shadows)
{
  vtkLight* outside = addLight(0.9);
  const auto unshadowed = scene_.render();
  EXPECT_GT(meanOf(unshadowed), 0.7);
  mapper_->ShadowsOn();
  EXPECT_NEAR(meanOf(scene_.render()), 0.4, eightBits);
  // At the eye, in both senses.
  outside->SetLightTypeToHeadlight();
  EXPECT_GT(meanOf(scene_.render()), 0.7);
  outside->SetLightTypeToSceneLight();
  outside->SetPosition(0., 0., -0.25 + 0.95 * gap);
  EXPECT_GT(meanOf(scene_.render()), 0.7);
  outside->SetPosition(0., 0., 0.9);
  EXPECT_NEAR(meanOf(scene_.render()), 0.4, eightBits);
  addLight(-0.25 + 0.95 * gap); // that one arrives
  EXPECT_GT(meanOf(scene_.render()), 0.7);
  mapper_->ShadowsOff();
  outside->SetPosition(0., 0., 0.9);
  scene_.renderer->GetLights()->RemoveItem(2);
  EXPECT_EQ(scene_.render(), unshadowed);
}

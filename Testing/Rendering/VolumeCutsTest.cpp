// Clipping planes and cropping regions of vtkTreeAMRVolumeMapper: against chords in homogeneous adaptive grids, and
// against VTK's own volume mapper on a uniform grid.
#include "RenderingScene.h"
#include "VolumePair.h"

#include "vtkCamera.h"
#include "vtkContourValues.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPlane.h"
#include "vtkTransform.h"
#include "vtkVolumeMapper.h"

#include <algorithm>
#include <cmath>
#include <optional>

using namespace treeamr::test;

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
constexpr double extinction = 0.8;
constexpr double floatTolerance = 5e-6;

struct Plane
{
  Point origin;
  Point normal;
};

using Planes = std::vector<Plane>;

struct Cropping
{
  std::array<double, 6> planes;
  int flags;
};

double dot(const Point& a, const Point& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void clip(vtkVolumeMapper* mapper, const Planes& planes)
{
  mapper->RemoveAllClippingPlanes();
  for (const Plane& p : planes)
  {
    vtkNew<vtkPlane> plane;
    plane->SetOrigin(p.origin.data());
    plane->SetNormal(p.normal.data());
    mapper->AddClippingPlane(plane);
  }
}

void crop(vtkVolumeMapper* mapper, const std::optional<Cropping>& cropping)
{
  mapper->SetCropping(cropping.has_value());
  if (cropping)
  {
    mapper->SetCroppingRegionPlanes(cropping->planes.data());
    mapper->SetCroppingRegionFlags(cropping->flags);
  }
}

/// One rotated plane, two that make a slab, three in a corner, a rotated box.
std::vector<Planes> planeSets()
{
  const Planes box{ { { -0.5, 0., 0. }, { 0.9, 0.3, 0.1 } }, { { 0.6, 0., 0. }, { -0.9, -0.3, -0.1 } },
    { { 0., -0.6, 0. }, { -0.2, 0.9, 0. } }, { { 0., 0.5, 0. }, { 0.2, -0.9, 0. } },
    { { 0., 0., -0.7 }, { 0., 0.1, 1. } }, { { 0., 0., 0.4 }, { 0., -0.1, -1. } } };
  return { { { { 0.1, 0., 0. }, { 1., 0., 0. } } }, { { { 0., 0.2, 0. }, { 0.4, -1., 0.3 } } },
    { { { 0., 0., -0.35 }, { 0., 0., 1. } }, { { 0., 0., 0.45 }, { 0., 0., -1. } } },
    { { { 0.1, 0.2, 0.1 }, { -1., 0.5, 0.2 } }, { { 0.1, 0.2, 0.1 }, { 0.3, -1., 0.2 } },
      { { 0.1, 0.2, 0.1 }, { 0., -0.2, -3. } } },
    box, { { { 0., 0., 0.2 }, { -1., -1., -1. } }, { { 0., 0.3, 0. }, { 0., -1., 0. } } } };
}

/// VTK's own and random ones.
std::vector<Cropping> croppings()
{
  const std::array<double, 6> planes{ -0.4, 0.3, -0.5, 0.45, -0.2, 0.6 };
  std::vector<Cropping> result;
  for (const int flags : { VTK_CROP_SUBVOLUME, VTK_CROP_FENCE, VTK_CROP_INVERTED_FENCE, VTK_CROP_CROSS,
         VTK_CROP_INVERTED_CROSS, 0x2aaaaaa, 0x5ca3c96, 0x7ffdfff })
  {
    result.push_back({ planes, flags });
  }
  return result;
}

/// The opacity of a pixel of a homogeneous box: chords of the shown regions, in data units, of what the planes leave.
double expectedAlpha(
  vtkVolume* volume, PixelRay ray, const Planes& planes, const std::optional<Cropping>& cropping)
{
  double s0 = 0.;
  double s1 = 1.;
  for (const Plane& plane : planes)
  {
    const Point toOrigin{ plane.origin[0] - ray.near[0], plane.origin[1] - ray.near[1],
      plane.origin[2] - ray.near[2] };
    const Point along{ ray.far[0] - ray.near[0], ray.far[1] - ray.near[1], ray.far[2] - ray.near[2] };
    const double slope = dot(along, plane.normal);
    const double s = dot(toOrigin, plane.normal) / slope;
    (slope > 0. ? s0 : s1) = slope > 0. ? std::max(s0, s) : std::min(s1, s);
  }
  double length = 0.;
  const std::array<double, 6> edges =
    cropping ? cropping->planes : std::array<double, 6>{ -2., 2., -2., 2., -2., 2. };
  for (int region = 0; region < 27; ++region)
  {
    const std::array<int, 3> at{ region % 3, region / 3 % 3, region / 9 };
    bool shown = !cropping || (cropping->flags >> region & 1);
    Box box;
    for (int a = 0; a < 3; ++a)
    {
      const std::array<double, 4> ends{ -1., edges[2 * a], edges[2 * a + 1], 1. };
      box.min[a] = std::max(-1., ends[at[a]]);
      box.max[a] = std::min(1., ends[at[a] + 1]);
      shown = shown && box.min[a] < box.max[a];
    }
    double entry;
    double exit;
    if (shown && Scene::chord(ray, volume, box, entry, exit))
    {
      length += std::max(0., std::min(exit, s1) - std::max(entry, s0));
    }
  }
  return -std::expm1(-extinction * length * Scene::inDataOf(volume, ray).length());
}

void expectCuts(
  Scene& scene, vtkVolume* volume, const Planes& planes, const std::optional<Cropping>& cropping)
{
  clip(Scene::mapperOf(volume), planes);
  crop(Scene::mapperOf(volume), cropping);
  const auto pixels = scene.render();
  int cut = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const double alpha = expectedAlpha(volume, scene.ray(x, y), planes, cropping);
      cut += expectedAlpha(volume, scene.ray(x, y), {}, {}) - alpha > 0.01;
      const auto& pixel = pixels[static_cast<std::size_t>(y) * scene.width() + x];
      ASSERT_NEAR(pixel[3], alpha, floatTolerance) << "pixel " << x << ", " << y;
      ASSERT_NEAR(pixel[0], orange[0] * alpha, floatTolerance) << "pixel " << x << ", " << y;
    }
  }
  EXPECT_GT(cut, scene.width() * scene.height() / 50);
}

/// Of both pictures, cut alike.
double difference(VolumePair& pair, const Planes& planes, const std::optional<Cropping>& cropping)
{
  return pair.difference([&](vtkVolumeMapper* mapper) {
    clip(mapper, planes);
    crop(mapper, cropping);
  });
}

class VolumeCutsTest : public RenderingTest
{
};

} // namespace

TEST_F(VolumeCutsTest, chordsOfAHomogeneousCube)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  for (const bool parallel : { false, true })
  {
    scene.setCamera(parallel);
    for (const Planes& planes : planeSets())
    {
      expectCuts(scene, volume, planes, {});
    }
    for (const Cropping& cropping : croppings())
    {
      expectCuts(scene, volume, {}, cropping);
    }
    expectCuts(scene, volume, planeSets()[4], croppings()[5]);
  }
}

TEST_F(VolumeCutsTest, planesAreInWorldAndRegionsInDataCoordinates)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  volume->SetScale(1.4, 0.6, 0.7);
  volume->RotateWXYZ(50., 1., 2., -1.);
  volume->SetPosition(0.4, -0.2, 0.3);
  vtkNew<vtkTransform> mirror;
  mirror->Scale(-1., 1., 1.);
  for (vtkTransform* transform : { static_cast<vtkTransform*>(nullptr), mirror.Get() })
  {
    volume->SetUserTransform(transform);
    scene.setCamera();
    expectCuts(scene, volume, planeSets()[1], {});
    expectCuts(scene, volume, {}, croppings()[3]);
    expectCuts(scene, volume, planeSets()[3], croppings()[7]);
  }
}

TEST_F(VolumeCutsTest, cameraInside)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetPosition(0.2, -0.3, 0.1);
  camera->SetFocalPoint(0.9, 0.4, 0.3);
  camera->SetViewAngle(70.);
  scene.renderer->ResetCameraClippingRange();
  expectCuts(scene, volume, planeSets()[5], {});
  expectCuts(scene, volume, {}, croppings()[7]);
}

TEST_F(VolumeCutsTest, whatIsCutAwayTakesNothing)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.setCamera();
  scene.render();
  const double all = Scene::statistic(volume, "Samples");
  clip(Scene::mapperOf(volume), { { { 0.5, 0., 0. }, { 1., 0., 0. } } });
  scene.render();
  EXPECT_LT(Scene::statistic(volume, "Samples"), 0.5 * all);
  clip(Scene::mapperOf(volume), { { { 1.5, 0., 0. }, { 1., 0., 0. } } });
  scene.render();
  EXPECT_EQ(Scene::statistic(volume, "Intervals"), 0.);
  EXPECT_EQ(Scene::statistic(volume, "Samples"), 0.);
  EXPECT_EQ(Scene::statistic(volume, "ReconstructedBlocks") + Scene::statistic(volume, "KeptBlocks"), 0.);
}

// What is left is homogeneous: no sample can miss anything of it.
TEST_F(VolumeCutsTest, theErrorIsThatOfWhatIsLeft)
{
  Scene scene;
  GridOptions options;
  options.refine = [](const Point&, int level) { return level < 3; };
  vtkVolume* volume = scene.addVolume(
    makeGrid(options, { { "half", [](const Point& p) { return p[0] < 0. ? 0.5 : wave(p); } } }), "half",
    orange, 1.);
  setWaveColors(volume->GetProperty());
  Scene::mapperOf(volume)->EstimateErrorOn();
  scene.setCamera();
  scene.render();
  EXPECT_GT(Scene::statistic(volume, "EstimatedError"), 1e-5);
  clip(Scene::mapperOf(volume), { { { -0.3, 0., 0. }, { -1., 0., 0. } } });
  scene.render();
  EXPECT_GE(Scene::statistic(volume, "EstimatedError"), 0.);
  EXPECT_LT(Scene::statistic(volume, "EstimatedError"), 1e-6);
}

TEST_F(VolumeCutsTest, fewerRaysThanPixels)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.setCamera();
  clip(Scene::mapperOf(volume), planeSets()[3]);
  crop(Scene::mapperOf(volume), croppings()[0]);
  const auto full = scene.render();
  Scene::mapperOf(volume)->AutoAdjustSampleDistancesOff();
  Scene::mapperOf(volume)->SetImageSampleDistance(2.);
  const auto draft = scene.render();
  double mean = 0.;
  for (std::size_t i = 0; i < full.size(); ++i)
  {
    mean += std::abs(full[i][3] - draft[i][3]) / static_cast<double>(full.size());
  }
  EXPECT_GT(mean, 0.);
  EXPECT_LT(mean, 0.01);
}

// Before, in and behind a translucent rectangle, in the segments of depth peeling.
TEST_F(VolumeCutsTest, translucentPolygonsInside)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  const Point middle{ 0., 0., 0.1 };
  constexpr Color blue{ 0.1, 0.2, 0.9 };
  constexpr double opacity = 0.4;
  scene.addRectangle(middle, { 0.9, 0., 0. }, { 0., 0.9, 0. }, blue, opacity);
  scene.renderer->UseDepthPeelingOn();
  scene.renderer->UseDepthPeelingForVolumesOn();
  scene.setCameraAlongZ();
  const Planes planes{ { { 0., 0., -0.4 }, { 0.3, 0., 1. } }, { { 0., 0., 0.6 }, { 0., 0.2, -1. } } };
  clip(Scene::mapperOf(volume), planes);
  const auto pixels = scene.render();
  int seen = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      PixelRay ray = scene.ray(x, y);
      const double s = Scene::meet(ray, middle, { 0., 0., 1. });
      const Point hit = ray.at(s);
      if (std::max(std::abs(hit[0]), std::abs(hit[1])) > 0.8)
      {
        continue; // on or beside its edge
      }
      ++seen;
      PixelRay front = ray;
      front.far = hit;
      PixelRay back = ray;
      back.near = hit;
      const Color expected =
        composite({ { orange, expectedAlpha(volume, front, planes, {}) }, { blue, opacity },
                    { orange, expectedAlpha(volume, back, planes, {}) } },
          { 0., 0., 0. });
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], expected[c], 2.5 / 255.)
          << "pixel " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(seen, 1000);
}

// The surface x = 0 in the volume, and alone, is cut as the volume is.
TEST_F(VolumeCutsTest, isosurfacesInside)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  volume->GetProperty()->GetIsoSurfaceValues()->SetValue(0, 0.);
  Scene::mapperOf(volume)->SetBlendModeToIsoSurface();
  scene.setCamera();
  const Plane plane{ { 0., 0.1, 0. }, { 0., -1., 0.2 } };
  clip(Scene::mapperOf(volume), { plane });
  const auto pixels = scene.render();
  std::array<int, 2> seen{}; // cut away, left
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const PixelRay ray = scene.ray(x, y);
      const Point hit = ray.at(Scene::meet(ray, { 0., 0., 0. }, { 1., 0., 0. }));
      const double inside =
        dot({ hit[0] - plane.origin[0], hit[1] - plane.origin[1], hit[2] - plane.origin[2] }, plane.normal);
      if (std::max(std::abs(hit[1]), std::abs(hit[2])) < 0.99 && std::abs(inside) > 1e-3)
      {
        ++seen[inside > 0.];
        EXPECT_EQ(pixels[static_cast<std::size_t>(y) * scene.width() + x][3] > 0.f, inside > 0.)
          << "pixel " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(seen[0], 100);
  EXPECT_GT(seen[1], 100);
}

// What is behind a surface that is cut away shows, however opaque that is.
TEST_F(VolumeCutsTest, isosurfacesBehindWhatIsCutAway)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  volume->GetProperty()->GetScalarOpacity()->RemoveAllPoints();
  volume->GetProperty()->GetScalarOpacity()->AddPoint(0., 1.);
  vtkContourValues* values = volume->GetProperty()->GetIsoSurfaceValues();
  values->SetNumberOfContours(2);
  values->SetValue(0, -0.5);
  values->SetValue(1, 0.5);
  Scene::mapperOf(volume)->SetBlendModeToIsoSurface();
  scene.setCamera();
  clip(Scene::mapperOf(volume), { { { 0.2, 0., 0. }, { -1., 0., 0. } } });
  const auto pixels = scene.render();
  int seen = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const PixelRay ray = scene.ray(x, y);
      const auto reach = [&](double at) { // of the plane x = at from the middle
        const Point hit = ray.at(Scene::meet(ray, { at, 0., 0. }, { 1., 0., 0. }));
        return std::max(std::abs(hit[1]), std::abs(hit[2]));
      };
      const double behind = reach(-0.5);
      if (std::abs(behind - 1.) > 0.05)
      {
        seen += behind < 1. && reach(0.5) < 1.;
        EXPECT_EQ(pixels[static_cast<std::size_t>(y) * scene.width() + x][3], behind < 1. ? 1.f : 0.f)
          << "pixel " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(seen, 50);
}

// A translucent actor in the cut volume, which draws it with itself, is whole.
TEST_F(VolumeCutsTest, surfacesOfActorsAreNotCut)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  vtkActor* actor = scene.addIsosurface(makeTestGrid(), "x", 0.);
  constexpr Color blue{ 0.1, 0.2, 0.9 };
  constexpr double opacity = 0.4;
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetColor(blue[0], blue[1], blue[2]);
  actor->GetProperty()->SetOpacity(opacity);
  scene.setCamera();
  const Planes planes{ { { 0.2, 0.1, 0. }, { 0.5, -1., 0.2 } } };
  clip(Scene::mapperOf(volume), planes);
  const auto pixels = scene.render();
  std::array<int, 2> seen{}; // surface in what is cut away, in what is left
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      const PixelRay ray = scene.ray(x, y);
      const Point hit = ray.at(Scene::meet(ray, { 0., 0., 0. }, { 1., 0., 0. }));
      if (std::max(std::abs(hit[1]), std::abs(hit[2])) > 0.75)
      {
        continue; // the surface bends towards the domain's edge
      }
      ++seen[dot({ hit[0] - 0.2, hit[1] - 0.1, hit[2] }, planes[0].normal) > 0.];
      PixelRay front = ray;
      front.far = hit;
      PixelRay back = ray;
      back.near = hit;
      const Color expected =
        composite({ { orange, expectedAlpha(volume, front, planes, {}) }, { blue, opacity },
                    { orange, expectedAlpha(volume, back, planes, {}) } },
          { 0., 0., 0. });
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], expected[c], 2e-5)
          << "pixel " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(seen[0], 50);
  EXPECT_GT(seen[1], 50);
}

TEST_F(VolumeCutsTest, asVtkClips)
{
  VolumePair pair;
  EXPECT_LT(difference(pair, {}, {}), 1.);
  for (const Planes& planes : planeSets())
  {
    EXPECT_LT(difference(pair, planes, {}), 1.5);
  }
}

TEST_F(VolumeCutsTest, asVtkCrops)
{
  VolumePair pair;
  for (const Cropping& cropping : croppings())
  {
    EXPECT_LT(difference(pair, {}, cropping), 1.5) << cropping.flags;
  }
}

TEST_F(VolumeCutsTest, asVtkCutsAMovedVolume)
{
  VolumePair pair;
  vtkNew<vtkTransform> transform;
  transform->Translate(0.3, -0.1, 0.2);
  transform->RotateWXYZ(40., 1., -1., 2.);
  transform->Scale(0.7, 0.7, 0.7);
  pair.move(transform);
  EXPECT_LT(difference(pair, planeSets()[3], {}), 1.5);
  EXPECT_LT(difference(pair, {}, croppings()[2]), 1.5);
  EXPECT_LT(difference(pair, planeSets()[1], croppings()[3]), 1.5);
}

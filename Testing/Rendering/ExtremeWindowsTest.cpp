// Both mappers in windows, with cameras, data and functions at the ends of what is allowed. Each test records the
// worst error it measured ("measured") next to the bound that it keeps ("allowed").
#include "PlaneSurface.h"

#include "vtkColorTransferFunction.h"
#include "vtkPiecewiseFunction.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace treeamr::test;

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
/// Over half of the domain's width.
constexpr double extinction = 0.8;
/// Sums of a few dozen floats of size 1.
constexpr double opacityTolerance = 5e-6;
constexpr double still = 0.002;
constexpr double interactive = 15.;

/// A cubic domain, and a plane through it in its own coordinates, which go from -1 to 1.
struct Domain
{
  Point middle{ 0., 0., 0. };
  double half = 1.;
  Point center{ 0.05, 0.1, -0.1 };
  Point normal{ 0.3, 0.5, 0.6 };
  std::array<int, 3> roots{ 4, 4, 4 };
  std::function<bool(const Point&, int)> refine = [](const Point& u, int level) {
    return level < 2 && u[0] > 0. && u[1] > 0. && u[2] > -0.5;
  };

  Point world(const Point& u) const
  {
    return { middle[0] + half * u[0], middle[1] + half * u[1], middle[2] + half * u[2] };
  }
  Point own(const Point& p) const
  {
    return { (p[0] - middle[0]) / half, (p[1] - middle[1]) / half, (p[2] - middle[2]) / half };
  }
  Box box() const { return { world({ -1., -1., -1. }), world({ 1., 1., 1. }) }; }
  double distance(const Point& u) const
  {
    double d = 0.;
    for (int a = 0; a < 3; ++a)
    {
      d += (u[a] - center[a]) * normal[a];
    }
    return d;
  }
  /// Arrays "one", "plane", whose surface 0 is the plane, and "x".
  vtkSmartPointer<vtkHyperTreeGrid> grid() const
  {
    GridOptions options;
    options.roots = roots;
    options.min = world({ -1., -1., -1. });
    options.max = world({ 1., 1., 1. });
    options.refine = [this](const Point& p, int level) { return refine(own(p), level); };
    return makeGrid(options,
      { { "one", [](const Point&) { return 1.; } },
        { "plane", [this](const Point& p) { return distance(own(p)); } },
        { "x", [this](const Point& p) { return own(p)[0]; } } });
  }
};

struct Errors
{
  double opacity = 0.;
  double depth = 0.;
  int opacities = 0; // compared
  int depths = 0;
};

using Look = std::function<void(Scene&)>;

void lookFromAfar(Scene& scene)
{
  scene.setCamera();
}

Look lookFrom(const Point& from, const Point& at, double near, double far)
{
  return [=](Scene& scene) {
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    camera->SetPosition(from.data());
    camera->SetFocalPoint(at.data());
    camera->SetViewUp(0.1, 0.2, 0.9);
    camera->SetViewAngle(70.);
    camera->SetClippingRange(near, far);
  };
}

class ExtremeWindows : public RenderingTest
{
protected:
  /// Opacities of a homogeneous box between two bounds of it.
  void compareOpacities(Scene& scene, vtkVolume* volume, double perLength, const Box& least, const Box& most)
  {
    const auto pixels = scene.render();
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const auto opacity = [&](const Box& box) {
          double entry;
          double exit;
          return Scene::chord(ray, volume, box, entry, exit)
            ? -std::expm1(-perLength * (exit - entry) * ray.length())
            : 0.;
        };
        const double low = opacity(least);
        const double high = opacity(most);
        const double found = pixels[static_cast<std::size_t>(y) * scene.width() + x][3];
        // In this order NaN counts, too.
        if (!(std::max(low - found, found - high) <= errors_.opacity))
        {
          errors_.opacity = std::max(low - found, found - high);
        }
        errors_.opacities += high > 0.;
      }
    }
  }

  /// Window depths where the plane is and can be exact.
  void compareDepths(
    Scene& scene, const Domain& domain,
    const std::function<bool(const Point&)>& isExact = [](const Point& u) { return isInside(u); })
  {
    scene.render();
    const std::vector<float> depths = scene.depths();
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const double s = Scene::meet(ray, domain.world(domain.center), domain.normal);
        if (!(s > 0. && s < 1.) || !isExact(domain.own(ray.at(s))))
        {
          continue;
        }
        const float found = depths[static_cast<std::size_t>(y) * scene.width() + x];
        const double error = std::abs(found - windowDepth(scene, ray.at(s)));
        if (!(error <= errors_.depth))
        {
          errors_.depth = error;
        }
        ++errors_.depths;
      }
    }
  }

  /// One view by both mappers.
  void compare(const Domain& domain, const Look& look, int width = 60, int height = 44)
  {
    const vtkSmartPointer<vtkHyperTreeGrid> grid = domain.grid();
    {
      Scene scene(width, height);
      scene.useFloatTarget();
      vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
      volume->GetProperty()->SetScalarOpacityUnitDistance(domain.half);
      look(scene);
      compareOpacities(scene, volume, extinction / domain.half, domain.box(), domain.box());
    }
    Scene scene(width, height);
    scene.addIsosurface(grid, "plane", 0.);
    look(scene);
    compareDepths(scene, domain);
  }

  void expectExact()
  {
    EXPECT_LE(errors_.opacity, opacityTolerance);
    EXPECT_LE(errors_.depth, depthTolerance);
    EXPECT_GT(errors_.opacities + errors_.depths, 0);
    std::ostringstream measured;
    std::ostringstream allowed;
    const auto add = [&](const char* what, double worst, double bound, int pixels) {
      if (pixels > 0)
      {
        const char* const separator = measured.str().empty() ? "" : ", ";
        measured << separator << what << ' ' << worst << " (" << pixels << " pixels)";
        allowed << separator << what << ' ' << bound;
      }
    };
    add("opacity error", errors_.opacity, opacityTolerance, errors_.opacities);
    add("error of the depth buffer", errors_.depth, depthTolerance, errors_.depths);
    record(measured.str(), allowed.str());
  }
  static void record(const std::string& measured, const std::string& allowed)
  {
    RecordProperty("measured", measured);
    RecordProperty("allowed", allowed);
  }

  Errors errors_;
};

/// What malloc has given out, of all libraries in the process.
std::size_t heapBytes()
{
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

} // namespace

TEST_F(ExtremeWindows, onePixel)
{
  compare({}, lookFromAfar, 1, 1);
  EXPECT_EQ(errors_.opacities, 1);
  EXPECT_EQ(errors_.depths, 1);
  expectExact();
}

// The longest side that OpenGL drivers draw.
TEST_F(ExtremeWindows, pixels16384x2)
{
  compare(
    {},
    [](Scene& scene) {
      lookFrom({ 2., 1.5, 3. }, { 0., 0., 0. }, 1., 10.)(scene);
      scene.renderer->GetActiveCamera()->UseHorizontalViewAngleOn();
    },
    16384, 2);
  EXPECT_GT(errors_.opacities, 16384);
  EXPECT_GT(errors_.depths, 8192);
  expectExact();
}

TEST_F(ExtremeWindows, viewAngleOfAThousandthDegree)
{
  compare({}, [](Scene& scene) {
    scene.renderer->GetActiveCamera()->SetViewAngle(0.001);
    scene.setCamera();
  });
  EXPECT_GT(errors_.depths, 300);
  expectExact();
}

// The tangents between two pixels in the middle are half a unit apart: from near the plane.
TEST_F(ExtremeWindows, viewAngleOf179Degrees)
{
  compare(
    {},
    [](Scene& scene) {
      lookFrom({ 0.065, 0.125, -0.07 }, { 0.05, 0.1, -0.1 }, 1e-3, 10.)(scene);
      scene.renderer->GetActiveCamera()->SetViewAngle(179.);
    },
    301, 221);
  EXPECT_EQ(errors_.opacities, 301 * 221);
  EXPECT_GT(errors_.depths, 1000);
  expectExact();
}

// Planes between cells are at multiples of 1/2, and of 1/8 where the grid is refined.
TEST_F(ExtremeWindows, cameraOnFacesEdgesAndVerticesOfCells)
{
  for (const Point& from : { Point{ 0.5, 0.2, 0.3 }, Point{ 0.5, 0.625, 0.3 }, Point{ 0.5, 0.5, 0.5 },
         Point{ 0.125, 0.375, 0.625 }, Point{ 0., 0., 0. }, Point{ 0.3, 0.3, 0.3 }, Point{ 1., 0.2, 0.3 },
         Point{ 1., 1., 1. }, Point{ -1., -0.5, 0.5 } })
  {
    // Across, along a face, and along an edge.
    for (const Point& to : { Point{ -0.4, -0.3, -0.5 }, Point{ 0., -0.6, -0.7 }, Point{ 0., 0., -1. } })
    {
      compare({}, lookFrom(from, { from[0] + to[0], from[1] + to[1], from[2] + to[2] }, 1e-3, 5.));
    }
  }
  EXPECT_GT(errors_.opacities, 30000);
  EXPECT_GT(errors_.depths, 5000);
  expectExact();
}

// p4est's deepest level, a cell of 2^-19 of the root, through and before whose corner the plane passes.
TEST_F(ExtremeWindows, oneCellOfLevel19FillsTheWindow)
{
  constexpr double width = 0x1p-18; // of 2
  Domain domain;
  domain.roots = { 1, 1, 1 };
  domain.center = { 1. / 3., 1. / 3., 1. / 3. };
  domain.refine = [&](const Point& u, int level) {
    const double reach = std::ldexp(1., -level);
    return level < 19 && std::abs(u[0] - domain.center[0]) < reach &&
      std::abs(u[1] - domain.center[1]) < reach && std::abs(u[2] - domain.center[2]) < reach;
  };
  const vtkSmartPointer<vtkHyperTreeGrid> grid = domain.grid();
  ASSERT_EQ(grid->GetNumberOfLevels(), 20u);
  for (const bool parallel : { true, false })
  {
    const Look look = [&](Scene& scene) {
      lookFrom({ 1. / 3. + 3. * width, 1. / 3. + 2. * width, 1. / 3. + 4. * width }, domain.center,
        1e-2 * width, 20. * width)(scene);
      scene.renderer->GetActiveCamera()->SetViewAngle(10.);
      scene.renderer->GetActiveCamera()->SetParallelProjection(parallel);
      scene.renderer->GetActiveCamera()->SetParallelScale(0.4 * width);
    };
    {
      Scene scene;
      scene.useFloatTarget();
      vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
      volume->GetProperty()->SetScalarOpacityUnitDistance(5. * width);
      look(scene);
      compareOpacities(scene, volume, extinction / (5. * width), Box(), Box());
    }
    Scene scene;
    scene.addIsosurface(grid, "plane", 0.);
    look(scene);
    compareDepths(scene, domain);
  }
  EXPECT_EQ(errors_.opacities, 2 * 60 * 44);
  EXPECT_EQ(errors_.depths, 2 * 60 * 44);
  expectExact();
}

TEST_F(ExtremeWindows, domainsFrom1em12To1e12Wide)
{
  for (const double half : { 0.5e-12, 0.5e12 })
  {
    Domain domain;
    domain.half = half;
    compare(domain, lookFromAfar);
  }
  EXPECT_GT(errors_.depths, 600);
  expectExact();
}

TEST_F(ExtremeWindows, domainAnOffset1e9FromTheOrigin)
{
  Domain domain;
  domain.middle = { 1e9, -1e9, 1e9 };
  compare(domain, lookFromAfar);
  EXPECT_GT(errors_.depths, 300);
  // A coordinate is rounded to 2^-23 there, far above that of doubles near the origin, but below these.
  expectExact();
}

// Left out like masked cells, whatever their neighbours.
TEST_F(ExtremeWindows, cellsThatAreNotFinite)
{
  Domain domain;
  domain.refine = [](const Point& u, int level) { return level < 2 && u[1] > 0.; };
  for (const double bad : { std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL })
  {
    GridOptions options;
    options.roots = domain.roots;
    options.refine = domain.refine;
    const auto goodBelow = [&](const ScalarField& field) {
      return [=](const Point& p) { return p[0] < 0. ? field(p) : bad; };
    };
    const vtkSmartPointer<vtkHyperTreeGrid> grid = makeGrid(options,
      { { "one", goodBelow([](const Point&) { return 1.; }) },
        { "plane", goodBelow([&](const Point& p) { return domain.distance(p); }) } });
    {
      Scene scene;
      scene.useFloatTarget();
      vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
      scene.setCamera();
      const Box half{ { -1., -1., -1. }, { 0., 1., 1. } };
      compareOpacities(scene, volume, extinction, half, half);
    }
    Scene scene;
    scene.addIsosurface(grid, "plane", 0.);
    scene.setCamera();
    compareDepths(scene, domain, [](const Point& u) { return isInside(u) && u[0] < -0.25; });
    const std::vector<float> depths = scene.depths();
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        double entry;
        double exit;
        if (!Scene::chord(scene.ray(x, y), scene.renderer->GetActors()->GetLastActor(),
              { { -1., -1., -1. }, { 0., 1., 1. } }, entry, exit))
        {
          ASSERT_EQ(depths[static_cast<std::size_t>(y) * scene.width() + x], 1.f);
        }
      }
    }
  }
  EXPECT_GT(errors_.depths, 300);
  expectExact();
}

TEST_F(ExtremeWindows, noCellAndOneCell)
{
  GridOptions options;
  options.trees = false;
  const auto empty = makeGrid(options, { { "one", [](const Point&) { return 1.; } } });
  {
    Scene scene;
    vtkVolume* volume = scene.addVolume(empty, "one", orange, extinction);
    scene.addIsosurface(empty, "one", 1.);
    MessageCounter messages(volume->GetMapper());
    scene.setCamera();
    for (const auto& pixel : scene.render())
    {
      ASSERT_EQ(pixel[0] + pixel[1] + pixel[2], 0.f);
    }
    ASSERT_EQ(messages.errors.size(), 1u);
    EXPECT_NE(messages.errors[0].find("no tree"), std::string::npos);
  }

  // The field of one cell is one value everywhere.
  Domain one;
  one.roots = { 1, 1, 1 };
  one.refine = [](const Point&, int) { return false; };
  const vtkSmartPointer<vtkHyperTreeGrid> grid = one.grid();
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(grid, "one", orange, extinction);
  scene.setCamera();
  compareOpacities(scene, volume, extinction, Box(), Box());
  EXPECT_GT(errors_.opacities, 300);
  EXPECT_LE(errors_.opacity, opacityTolerance);
  volume->VisibilityOff();
  for (const double isovalue : { 0.999, 1.001 })
  {
    vtkActor* actor = scene.addIsosurface(grid, "one", isovalue);
    for (const auto& pixel : scene.render())
    {
      ASSERT_EQ(pixel[3], 0.f);
    }
    EXPECT_EQ(Scene::mapperOf(actor)->GetNumberOfPrimitives(), 0);
  }
  std::ostringstream measured;
  measured << "opacity error " << errors_.opacity << " of one cell; without cells 1 message, nothing drawn";
  record(measured.str(), "opacity error 5e-06; without cells 1 message, nothing drawn");
}

// A ray has lost all its light after one sample.
TEST_F(ExtremeWindows, opacityOfExactlyOne)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  vtkNew<vtkPiecewiseFunction> opaque;
  opaque->AddPoint(-1., 1.);
  opaque->AddPoint(1., 1.);
  volume->GetProperty()->SetScalarOpacity(opaque);
  scene.setCamera();
  const auto pixels = scene.render();
  double worst = 0.;
  int compared = 0;
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      double entry;
      double exit;
      const bool inside = Scene::chord(scene.ray(x, y), volume, Box(), entry, exit);
      const auto& pixel = pixels[static_cast<std::size_t>(y) * scene.width() + x];
      for (int c = 0; c < 4; ++c)
      {
        const double expected = inside ? (c == 3 ? 1. : orange[c]) : 0.;
        worst = std::max(worst, std::abs(pixel[c] - expected));
      }
      compared += inside;
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_LE(worst, opacityTolerance);
  std::ostringstream measured;
  measured << "colour and opacity error " << worst << " (" << compared << " pixels)";
  record(measured.str(), "colour and opacity error 5e-06");
}

// The function jumps between two points at 0: nothing below, fog above.
TEST_F(ExtremeWindows, twoPointsOfTheOpacityFunctionAtOneValue)
{
  Scene scene;
  scene.useFloatTarget();
  Domain domain; // of equal cells around 0
  domain.refine = [](const Point& u, int level) { return level < 2 && u[0] > 0.5; };
  vtkVolume* volume = scene.addVolume(domain.grid(), "x", orange, extinction);
  const double fog = -std::expm1(-extinction);
  vtkNew<vtkPiecewiseFunction> step;
  step->AllowDuplicateScalarsOn();
  step->AddPoint(-1., 0.);
  step->AddPoint(0., 0.);
  step->AddPoint(0., fog);
  step->AddPoint(1., fog);
  volume->GetProperty()->SetScalarOpacity(step);
  scene.setCamera();
  // Two of the 4096 entries of the mapper's table over the width of 2.
  constexpr double blur = 2. * 2. / 4090.;
  compareOpacities(scene, volume, extinction, { { blur, -1., -1. }, { 1., 1., 1. } },
    { { -blur, -1., -1. }, { 1., 1., 1. } });
  EXPECT_GT(errors_.opacities, 300);
  EXPECT_LE(errors_.opacity, opacityTolerance);
  std::ostringstream measured;
  measured << "opacity error " << errors_.opacity << " beyond that of a step 0.001 from its place";
  record(measured.str(), "opacity error 5e-06 beyond it");
}

// Beyond the centres of the outermost cells the field is constant. From within, the surface of the least or greatest
// value is where that begins, from without the face of the domain.
TEST_F(ExtremeWindows, isovalueAtTheLeastAndGreatestValue)
{
  Domain domain;
  domain.refine = [](const Point&, int) { return false; };
  domain.normal = { 1., 0., 0. };
  const vtkSmartPointer<vtkHyperTreeGrid> grid = domain.grid();
  Scene scene;
  vtkActor* actor = scene.addIsosurface(grid, "x", 0.75);
  domain.center = { 0.75, 0., 0. };
  lookFrom({ 0., 0.1, 0.2 }, { 1., 0., 0. }, 1e-2, 5.)(scene);
  compareDepths(scene, domain);
  // From outside through the outermost half cells, which are at the isovalue.
  lookFrom({ 1.5, 0.1, 0.2 }, { 0., 0., 0. }, 1e-2, 5.)(scene);
  compareDepths(scene, domain, [](const Point& u) { return std::abs(u[1]) < 1. && std::abs(u[2]) < 1.; });
  // At the least value all is inside, as contours have it.
  Scene::mapperOf(actor)->SetValue(0, -0.75);
  for (const double x : { 0., -1.5 })
  {
    lookFrom({ x, 0.1, 0.2 }, { x == 0. ? -1. : 0., 0., 0. }, 1e-2, 5.)(scene);
    for (const auto& pixel : scene.render())
    {
      ASSERT_EQ(pixel[0] + pixel[1] + pixel[2], 0.f);
    }
  }
  EXPECT_GT(errors_.depths, 4000);
  expectExact();
}

TEST_F(ExtremeWindows, isovalueThatIsNotANumber)
{
  Scene scene;
  vtkActor* actor = scene.addIsosurface(makeTestGrid(), "x", std::numeric_limits<double>::quiet_NaN());
  MessageCounter messages(actor->GetMapper());
  scene.setCamera();
  for (const auto& pixel : scene.render())
  {
    ASSERT_EQ(pixel[0] + pixel[1] + pixel[2], 0.f);
  }
  scene.render();
  EXPECT_EQ(messages.errors.size(), 1u);
  record(std::to_string(messages.errors.size()) + " message in 2 frames, nothing drawn",
    "1 message, nothing drawn");
}

// Two samples a frame: the last of them makes the picture of one still frame, bit by bit.
TEST_F(ExtremeWindows, tenThousandFramesOfAmbientOcclusion)
{
  constexpr int frames = 10000;
  Scene scene(12, 9);
  vtkActor* actor = scene.addIsosurface(makeTestGrid(), "x", 0.3);
  vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
  mapper->SetNumberOfContours(2);
  mapper->SetValue(1, 0.2);
  mapper->SetAmbientOcclusionRadius(0.2);
  mapper->SetAmbientOcclusionSamples(frames * vtkTreeAMRIsosurfaceMapper::InteractiveSamples);
  mapper->AutoAdjustSampleDistancesOff(); // drafts have fewer rays, also of these
  scene.setCamera();
  scene.window->SetDesiredUpdateRate(still);
  const auto first = scene.render();
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->Azimuth(1.);
  scene.render();
  camera->Azimuth(-1.);
  scene.window->SetDesiredUpdateRate(interactive);
  for (int i = 0; i < 100; ++i)
  {
    scene.window->Render();
  }
  const std::size_t before = heapBytes();
  for (int i = 100; i < frames; ++i)
  {
    scene.window->Render();
  }
  const auto grown = static_cast<std::ptrdiff_t>(heapBytes() - before);
  EXPECT_EQ(scene.render(), first);
  EXPECT_LE(grown, 65536);
  record(std::to_string(grown) + " bytes more after 10000 frames, picture that of the still frame",
    "65536 bytes more, same picture");
}

TEST_F(ExtremeWindows, tenThousandFramesOfAVolume)
{
  constexpr int frames = 10000;
  Scene scene(24, 18);
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  Scene::mapperOf(volume)->SetInteractiveRenderTime(1e-4);
  scene.setCamera();
  scene.window->SetDesiredUpdateRate(still);
  const auto first = scene.render();
  const std::vector<std::string> counts{ "OctreeBytes", "Rays", "Nodes", "Intervals", "Samples" };
  std::vector<double> ofFirst;
  for (const std::string& name : counts)
  {
    ofFirst.push_back(Scene::statistic(volume, name.c_str()));
  }
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  std::size_t before = 0;
  double kept = 0.;
  for (int i = 0; i < frames; ++i)
  {
    scene.window->SetDesiredUpdateRate(i % 100 == 99 ? still : interactive);
    // There and back.
    camera->Azimuth(i % 2 == 0 ? 10. : -10.);
    scene.window->Render();
    if (i == frames / 10)
    {
      before = heapBytes();
      kept = Scene::statistic(volume, "KeptBytes");
    }
  }
  const auto grown = static_cast<std::ptrdiff_t>(heapBytes() - before);
  scene.window->SetDesiredUpdateRate(still);
  double largest = 0.;
  const auto last = scene.render();
  for (std::size_t i = 0; i < first.size(); ++i)
  {
    for (int c = 0; c < 4; ++c)
    {
      largest = std::max(largest, std::abs(static_cast<double>(last[i][c]) - first[i][c]));
    }
  }
  for (std::size_t i = 0; i < counts.size(); ++i)
  {
    EXPECT_EQ(Scene::statistic(volume, counts[i].c_str()), ofFirst[i]) << counts[i];
  }
  EXPECT_EQ(Scene::statistic(volume, "KeptBytes"), kept);
  EXPECT_LE(grown, 65536);
  EXPECT_LE(largest, 1e-6);
  std::ostringstream measured;
  measured << grown << " bytes more after 10000 frames, picture off by " << largest;
  record(measured.str(), "65536 bytes more, picture off by 1e-06, same statistics");
}

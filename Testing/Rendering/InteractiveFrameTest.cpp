// Frames with fewer rays than pixels: where their pixels lie, polygons in them, and when they are drawn.
#include "RenderingScene.h"

#include <algorithm>
#include <cmath>

using namespace treeamr::test;

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
constexpr Color blue{ 0.2, 0.3, 0.9 };
constexpr Color green{ 0.1, 0.8, 0.3 };
constexpr Color background{ 0.1, 0.2, 0.3 };
constexpr double extinction = 0.8;
/// Sums of a few dozen floats of size 1, and weights from differences of coordinates up to 100.
constexpr double floatTolerance = 2e-5;

/// More than any frame takes, and less.
constexpr double plenty = 1e6;
constexpr double nothing = 1e-9;
constexpr double interactive = 15.;
constexpr double still = 0.002;

using Pixels = std::vector<std::array<float, 4>>;

class InteractiveFrameTest : public RenderingTest
{
protected:
  static double distance(vtkVolume* volume) { return Scene::statistic(volume, "ImageSampleDistance"); }
  static double levelOfDetail(vtkVolume* volume) { return Scene::statistic(volume, "LevelOfDetail"); }
};

/// Opacity of the homogeneous test grid at window coordinates (0.5 is the centre of the first pixel).
double opacity(const Scene& scene, vtkVolume* volume, double x, double y)
{
  const PixelRay ray = scene.ray(x - 0.5, y - 0.5);
  double entry;
  double exit;
  return Scene::chord(ray, volume, Box(), entry, exit)
    ? -std::expm1(-extinction * (exit - entry) * ray.length())
    : 0.;
}

/// The same of an image of columns x rows rays, magnified.
double magnifiedOpacity(const Scene& scene, vtkVolume* volume, int columns, int rows, int x, int y)
{
  const double width = static_cast<double>(scene.width()) / columns;
  const double height = static_cast<double>(scene.height()) / rows;
  const double u = (x + 0.5) / width - 0.5;
  const double v = (y + 0.5) / height - 0.5;
  double sum = 0.;
  for (int corner = 0; corner < 4; ++corner)
  {
    const int i = static_cast<int>(std::floor(u)) + corner % 2;
    const int j = static_cast<int>(std::floor(v)) + corner / 2;
    const double weight = (1. - std::abs(u - i)) * (1. - std::abs(v - j));
    sum += weight *
      opacity(scene, volume, (std::clamp(i, 0, columns - 1) + 0.5) * width,
        (std::clamp(j, 0, rows - 1) + 0.5) * height);
  }
  return sum;
}

} // namespace

TEST_F(InteractiveFrameTest, reducedImagesAreMagnifiedEdgeToEdge)
{
  for (const auto& [width, height] : { std::pair(60, 44), std::pair(61, 43), std::pair(7, 5) })
  {
    Scene scene(width, height);
    scene.useFloatTarget();
    vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
    vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
    mapper->AutoAdjustSampleDistancesOff();
    scene.setCamera();
    for (const double distance : { 1.5, 2., 3., 10., 100. })
    {
      mapper->SetImageSampleDistance(distance);
      const Pixels pixels = scene.render();
      const int columns = static_cast<int>(std::ceil(width / distance));
      const int rows = static_cast<int>(std::ceil(height / distance));
      EXPECT_EQ(Scene::statistic(volume, "Rays"), columns * rows);
      for (int y = 0; y < height; ++y)
      {
        for (int x = 0; x < width; ++x)
        {
          const double alpha = magnifiedOpacity(scene, volume, columns, rows, x, y);
          const auto& pixel = pixels[static_cast<std::size_t>(y) * width + x];
          ASSERT_NEAR(pixel[3], alpha, floatTolerance)
            << "pixel " << x << ", " << y << " at distance " << distance;
          for (int c = 0; c < 3; ++c)
          {
            ASSERT_NEAR(pixel[c], orange[c] * alpha, floatTolerance);
          }
        }
      }
    }
  }
}

TEST_F(InteractiveFrameTest, inTheSecondViewport)
{
  Scene scene(90, 40);
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.window->AlphaBitPlanesOn();
  scene.renderer->SetViewport(0.4, 0.1, 1., 0.9);
  vtkNew<vtkRenderer> other;
  other->SetViewport(0., 0., 0.4, 1.);
  scene.window->AddRenderer(other);
  scene.setCamera();
  Scene::mapperOf(volume)->AutoAdjustSampleDistancesOff();
  Scene::mapperOf(volume)->SetImageSampleDistance(4.);
  const Pixels pixels = scene.render();
  for (int y = 0; y < scene.height(); ++y)
  {
    for (int x = 0; x < scene.width(); ++x)
    {
      ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][3],
        magnifiedOpacity(scene, volume, 14, 8, x, y), 0.501 / 255.)
        << "pixel " << x << ", " << y;
    }
  }
}

// Looking along z every ray passes the same length of fog, so that a reduced image has the colours of the full
// one: fewer rays must not show along a polygon's edges.
namespace
{

struct Rectangle
{
  double halfSize;
  double z;
  Color color;
  double opacity;
};

void expectNoHalo(Scene& scene, const std::vector<Rectangle>& nearestFirst, double tolerance)
{
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  for (const Rectangle& r : nearestFirst)
  {
    scene.addRectangle({ 0., 0., r.z }, { r.halfSize, 0., 0. }, { 0., r.halfSize, 0. }, r.color, r.opacity);
  }
  scene.renderer->SetBackground(background.data());
  scene.setCameraAlongZ();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->AutoAdjustSampleDistancesOff();
  for (const double distance : { 1., 2., 3., 4.5 })
  {
    mapper->SetImageSampleDistance(distance);
    const Pixels pixels = scene.render();
    EXPECT_EQ(Scene::statistic(volume, "ImageSampleDistance"), distance);
    int compared = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const double reach = std::max(std::abs(ray.near[0]), std::abs(ray.near[1]));
        std::vector<Layer> layers;
        double top = 1.;
        bool onEdge = false;
        for (const Rectangle& r : nearestFirst)
        {
          // A hair's breadth: which side the centre of a pixel is on must be sure.
          onEdge = onEdge || std::abs(reach - r.halfSize) < 1e-3;
          if (reach < r.halfSize)
          {
            layers.push_back({ orange, -std::expm1(-extinction * (top - r.z)) });
            layers.push_back({ r.color, r.opacity });
            top = r.z;
          }
        }
        layers.push_back({ orange, -std::expm1(-extinction * (top + 1.)) });
        if (onEdge)
        {
          continue;
        }
        ++compared;
        const Color color = composite(layers, background);
        for (int c = 0; c < 3; ++c)
        {
          ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], color[c], tolerance)
            << "channel " << c << " of pixel " << x << ", " << y << " at distance " << distance;
        }
      }
    }
    EXPECT_GT(compared, 0.9 * static_cast<double>(pixels.size()));
  }
}

} // namespace

TEST_F(InteractiveFrameTest, noHaloAroundOpaquePolygons)
{
  Scene scene(61, 44);
  scene.useFloatTarget();
  expectNoHalo(scene, { { 0.31, 0.5, blue, 1. } }, floatTolerance);
}

TEST_F(InteractiveFrameTest, noHaloAroundAPolygonBeforeAnother)
{
  Scene scene(61, 44);
  scene.useFloatTarget();
  expectNoHalo(scene, { { 0.25, 0.5, blue, 1. }, { 0.47, -0.3, green, 1. } }, floatTolerance);
}

TEST_F(InteractiveFrameTest, noHaloAroundTranslucentPolygons)
{
  Scene scene(61, 44);
  scene.renderer->SetUseDepthPeeling(true);
  scene.renderer->SetUseDepthPeelingForVolumes(true);
  scene.renderer->SetMaximumNumberOfPeels(4);
  scene.renderer->SetOcclusionRatio(0.);
  // The pass keeps its images with 8 bits a channel and adds up to three roundings for each peel.
  expectNoHalo(scene, { { 0.31, 0.5, blue, 0.5 }, { 0.31, -0.4, green, 0.4 } }, 3. / 255.);
}

TEST_F(InteractiveFrameTest, stillFramesAreFull)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  scene.setCamera();
  mapper->AutoAdjustSampleDistancesOff();
  const Pixels full = scene.render();
  const double samples = Scene::statistic(volume, "Samples");
  mapper->AutoAdjustSampleDistancesOn();
  mapper->SetInteractiveRenderTime(nothing);

  // Before, between and after interactive frames, with next to no time allocated.
  for (int i = 0; i < 3; ++i)
  {
    scene.window->SetDesiredUpdateRate(still);
    EXPECT_EQ(scene.render(), full);
    EXPECT_EQ(distance(volume), 1.);
    EXPECT_EQ(levelOfDetail(volume), 0.);
    EXPECT_EQ(Scene::statistic(volume, "Rays"), scene.width() * scene.height());
    EXPECT_EQ(Scene::statistic(volume, "Samples"), samples);
    scene.window->SetDesiredUpdateRate(interactive);
    EXPECT_NE(scene.render(), full);
    EXPECT_EQ(distance(volume), 10.);
    EXPECT_EQ(levelOfDetail(volume), 2.);
    EXPECT_LT(Scene::statistic(volume, "Samples"), samples);
  }
}

TEST_F(InteractiveFrameTest, withoutAutoAdjustmentNothingIsAdjusted)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  scene.setCamera();
  scene.window->SetDesiredUpdateRate(still);
  const Pixels full = scene.render();
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetInteractiveRenderTime(nothing);
  scene.window->SetDesiredUpdateRate(interactive);
  EXPECT_EQ(scene.render(), full);
  EXPECT_EQ(distance(volume), 1.);
  EXPECT_EQ(levelOfDetail(volume), 0.);
}

TEST_F(InteractiveFrameTest, distancesStayWithinTheirLimits)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->SetMinimumImageSampleDistance(2.);
  mapper->SetMaximumImageSampleDistance(7.);
  scene.setCamera();
  scene.window->SetDesiredUpdateRate(still);
  scene.render();
  EXPECT_EQ(distance(volume), 2.);
  scene.window->SetDesiredUpdateRate(interactive);
  mapper->SetInteractiveRenderTime(nothing);
  scene.render();
  EXPECT_EQ(distance(volume), 7.);
  mapper->SetInteractiveRenderTime(plenty);
  scene.render();
  EXPECT_EQ(distance(volume), 2.);
  mapper->SetMinimumImageSampleDistance(8.);
  scene.render();
  EXPECT_EQ(distance(volume), 8.);
}

TEST_F(InteractiveFrameTest, theTimeIsTheAllocatedOneUnlessSet)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", orange, extinction);
  scene.setCamera();
  scene.window->SetDesiredUpdateRate(still);
  scene.render();
  // A nanosecond and less for the frame.
  scene.window->SetDesiredUpdateRate(1. / nothing);
  scene.render();
  EXPECT_EQ(distance(volume), 10.);
  Scene::mapperOf(volume)->SetInteractiveRenderTime(plenty);
  scene.render();
  EXPECT_EQ(distance(volume), 1.);
}

// What has been measured counts for the renderer, and until the colours or the field change.
TEST_F(InteractiveFrameTest, timesAreKeptForEachRenderer)
{
  Scene first;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkSmartPointer<vtkVolume> volume = first.addVolume(grid, "x", orange, extinction);
  Scene::mapperOf(volume)->SetInteractiveRenderTime(nothing);
  first.setCamera();
  first.window->SetDesiredUpdateRate(interactive);
  first.render();
  EXPECT_EQ(distance(volume), 5.) << "nothing measured yet";
  first.render();
  EXPECT_EQ(distance(volume), 10.);

  Scene second;
  second.renderer->AddVolume(volume);
  second.setCamera();
  second.window->SetDesiredUpdateRate(interactive);
  second.render();
  EXPECT_EQ(distance(volume), 5.);
  first.render();
  EXPECT_EQ(distance(volume), 10.);

  volume->GetProperty()->SetScalarOpacityUnitDistance(0.5);
  first.render();
  EXPECT_EQ(distance(volume), 5.);
  first.render();
  EXPECT_EQ(distance(volume), 10.);
  Scene::mapperOf(volume)->SelectScalarArray("y");
  first.render();
  EXPECT_EQ(distance(volume), 5.);
}

// A frame with depth peeling is traced in many parts, all alike.
TEST_F(InteractiveFrameTest, peelingIsOneFrame)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "one", orange, extinction);
  scene.addRectangle({ 0., 0., 0.5 }, { 1., 0., 0. }, { 0., 1., 0. }, blue, 0.5); // fills the view
  scene.renderer->SetUseDepthPeeling(true);
  scene.renderer->SetUseDepthPeelingForVolumes(true);
  scene.setCameraAlongZ();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->SetInteractiveRenderTime(nothing);
  scene.window->SetDesiredUpdateRate(interactive);
  scene.render();
  EXPECT_EQ(distance(volume), 5.);
  // Before and behind the polygon.
  EXPECT_EQ(Scene::statistic(volume, "Rays"), 2 * 12 * 9);
  scene.render();
  EXPECT_EQ(distance(volume), 10.);
  EXPECT_EQ(Scene::statistic(volume, "Rays"), 2 * 6 * 5);
  scene.window->SetDesiredUpdateRate(still);
  scene.render();
  EXPECT_EQ(distance(volume), 1.);
  EXPECT_EQ(Scene::statistic(volume, "Rays"), 2 * 60 * 44);
}

TEST_F(InteractiveFrameTest, statisticsOfWhatThereIs)
{
  Scene scene;
  vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  vtkVolume* volume = scene.addVolume(grid, "x", orange, extinction);
  for (const char* name : { "Cells", "OctreeBytes", "KeptBytes", "Rays", "Nodes", "KeptBlocks",
         "ReconstructedBlocks", "ReconstructedCells", "Intervals", "Samples", "SurfaceBytes", "SurfaceHits",
         "ImageSampleDistance", "LevelOfDetail", "SamplesPerCell", "FieldSeconds", "TransferFunctionSeconds",
         "RayCastingSeconds", "ErrorSeconds", "CompositingSeconds" })
  {
    EXPECT_EQ(Scene::statistic(volume, name), 0.) << name;
  }
  scene.setCamera();
  scene.render();
  EXPECT_EQ(Scene::statistic(volume, "Cells"), grid->GetNumberOfLeaves());
  EXPECT_GT(Scene::statistic(volume, "OctreeBytes"), 4. * static_cast<double>(grid->GetNumberOfLeaves()));
  EXPECT_GT(Scene::statistic(volume, "KeptBytes"), 0.);
  EXPECT_EQ(Scene::statistic(volume, "Rays"), scene.width() * scene.height());
  Scene::mapperOf(volume)->SetVertexCacheSize(0);
  scene.render();
  EXPECT_EQ(Scene::statistic(volume, "KeptBytes"), 0.);
}

// Several volumes in one view, beside each other and overlapping.
#include "RenderingScene.h"

#include "vtkColorTransferFunction.h"
#include "vtkPiecewiseFunction.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace treeamr::test;

using Picture = std::vector<std::array<float, 4>>;

class SeveralVolumesTest : public RenderingTest
{
protected:
  SeveralVolumesTest()
    : grid(makeTestGrid())
    , scene(90, 70)
  {
    scene.useFloatTarget();
  }
  vtkVolume* add(const Color& color, const Point& place)
  {
    vtkVolume* volume = scene.addVolume(grid, "one", color, 0.6);
    volume->SetPosition(place[0], place[1], place[2]);
    volume->SetScale(scale, scale, scale);
    volumes.push_back(volume);
    return volume;
  }
  void look(const Point& from)
  {
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    camera->SetFocalPoint(0., 0., 0.);
    camera->SetPosition(from[0], from[1], from[2]);
    camera->SetViewUp(0., 1., 0.1);
    scene.renderer->ResetCamera();
  }
  Picture alone(vtkVolume* shown)
  {
    for (vtkVolume* volume : volumes)
    {
      volume->SetVisibility(volume == shown);
    }
    const Picture picture = scene.render();
    for (vtkVolume* volume : volumes)
    {
      volume->VisibilityOn();
    }
    return picture;
  }
  /// The volumes are drawn before each other in this order.
  void expectOrder(const std::vector<vtkVolume*>& nearestFirst, double tolerance = 1e-6)
  {
    std::vector<Picture> pictures;
    for (vtkVolume* volume : nearestFirst)
    {
      pictures.push_back(this->alone(volume));
    }
    const Picture all = scene.render();
    int several = 0;
    for (std::size_t p = 0; p < all.size(); ++p)
    {
      std::array<double, 3> expected{};
      double through = 1.;
      int drawn = 0;
      for (const Picture& picture : pictures)
      {
        for (int c = 0; c < 3; ++c)
        {
          expected[c] += through * picture[p][c];
        }
        through *= 1. - picture[p][3];
        drawn += picture[p][3] > 0.1f;
      }
      several += drawn > 1;
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(all[p][c], expected[c], tolerance) << "pixel " << p;
      }
    }
    EXPECT_GT(several, 50);
  }

  void setExtinction(double perLength)
  {
    extinction = perLength;
    for (vtkVolume* volume : volumes)
    {
      vtkPiecewiseFunction* function = volume->GetProperty()->GetScalarOpacity();
      function->RemoveAllPoints();
      function->AddPoint(0., -std::expm1(-extinction * scale));
    }
  }
  /// A volume where a ray meets it.
  struct Part
  {
    double begin;
    double end;
    Color color;
  };
  /// What a ray sees of even volumes, by the integral between each two ends.
  Color integral(const std::vector<Part>& parts, double length) const
  {
    std::vector<double> ends;
    for (const Part& part : parts)
    {
      ends.insert(ends.end(), { part.begin, part.end });
    }
    std::sort(ends.begin(), ends.end());
    Color seen{};
    double through = 1.;
    for (std::size_t i = 0; i + 1 < ends.size(); ++i)
    {
      Color sum{};
      double there = 0.;
      for (const Part& part : parts)
      {
        if (part.begin <= ends[i] && part.end >= ends[i + 1])
        {
          ++there;
          for (int c = 0; c < 3; ++c)
          {
            sum[c] += part.color[c];
          }
        }
      }
      const double depth = there * extinction * length * (ends[i + 1] - ends[i]);
      for (int c = 0; there > 0. && c < 3; ++c)
      {
        seen[c] += through * -std::expm1(-depth) * sum[c] / there;
      }
      through *= std::exp(-depth);
    }
    return seen;
  }
  /// Channels are off by no more.
  void expectMerged(double largest, double mean)
  {
    const Picture all = scene.render();
    double sum = 0.;
    int several = 0;
    for (std::size_t p = 0; p < all.size(); ++p)
    {
      const auto width = static_cast<std::size_t>(scene.width());
      const PixelRay ray = scene.ray(static_cast<double>(p % width), static_cast<double>(p / width));
      std::vector<Part> parts;
      for (vtkVolume* volume : volumes)
      {
        Part part{};
        if (Scene::chord(ray, volume, Box(), part.begin, part.end))
        {
          volume->GetProperty()->GetRGBTransferFunction()->GetColor(0., part.color.data());
          parts.push_back(part);
        }
      }
      several += parts.size() > 1;
      const Color expected = this->integral(parts, ray.length());
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(all[p][c], expected[c], largest) << "pixel " << p;
        sum += std::abs(all[p][c] - expected[c]) / (3. * static_cast<double>(all.size()));
      }
    }
    EXPECT_LT(sum, mean);
    EXPECT_GT(several, 100);
  }

  static constexpr double scale = 0.5; // of the data, which are two wide
  double extinction = 0.;
  vtkSmartPointer<vtkHyperTreeGrid> grid;
  Scene scene;
  std::vector<vtkVolume*> volumes;
};

constexpr Color red{ 1., 0.1, 0. };
constexpr Color green{ 0., 1., 0.2 };
constexpr Color blue{ 0.1, 0., 1. };

TEST_F(SeveralVolumesTest, besideEachOtherFromAllSides)
{
  vtkVolume* left = this->add(red, { -0.6, 0., 0. });
  vtkVolume* middle = this->add(green, { 0.5, 0., 0. });
  vtkVolume* right = this->add(blue, { 1.5, 0., 0. }); // shares a face
  for (const bool parallel : { false, true })
  {
    scene.renderer->GetActiveCamera()->SetParallelProjection(parallel);
    this->look({ 4., 0.6, 0.8 });
    this->expectOrder({ right, middle, left });
    this->look({ -4., 0.6, 0.8 });
    this->expectOrder({ left, middle, right });
  }
}

TEST_F(SeveralVolumesTest, centresSayNothing)
{
  // A plate whose centre is farther than that of the cube behind it.
  vtkVolume* plate = this->add(green, { 6., 0., 0.1 });
  vtkVolume* cube = this->add(red, { 0., 0., -0.6 });
  plate->SetScale(7., 0.5, 0.1);
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  camera->SetPosition(-0.2, 0.1, 3.);
  camera->SetFocalPoint(-0.2, 0., 0.);
  camera->SetViewUp(0., 1., 0.);
  scene.renderer->ResetCameraClippingRange();
  this->expectOrder({ plate, cube });
}

TEST_F(SeveralVolumesTest, turnedBoxes)
{
  vtkVolume* first = this->add(red, { 0., 0., 0. });
  vtkVolume* second = this->add(green, { 0.8, 0.8, 0. });
  for (vtkVolume* volume : volumes)
  {
    volume->SetOrientation(0., 0., 45.); // their boxes along the axes overlap
  }
  const MessageCounter messages(Scene::mapperOf(first));
  this->look({ 3., 3., 0.5 });
  this->expectOrder({ second, first });
  this->look({ -3., -3., 0.5 });
  this->expectOrder({ first, second });
  EXPECT_TRUE(messages.warnings.empty());
}

TEST_F(SeveralVolumesTest, ofOneMapper)
{
  vtkVolume* first = this->add(red, { -0.6, 0., 0. });
  vtkVolume* second = this->add(green, { 0.6, 0., 0. });
  second->SetMapper(first->GetMapper());
  this->look({ 4., 0.6, 0.8 });
  this->expectOrder({ second, first });
  this->look({ -4., 0.6, 0.8 });
  this->expectOrder({ first, second });
}

TEST_F(SeveralVolumesTest, inDepthPeeling)
{
  vtkVolume* first = this->add(red, { -0.6, 0., 0. });
  vtkVolume* second = this->add(green, { 0.6, 0., 0. });
  scene.renderer->UseDepthPeelingOn();
  scene.renderer->UseDepthPeelingForVolumesOn();
  // Black and beside the volumes: there is something to peel, which adds nothing to any picture.
  scene.addRectangle({ 0., 5., 0. }, { 0.1, 0., 0. }, { 0., 0., 0.1 }, { 0., 0., 0. }, 0.5);
  this->look({ 4., 0.6, 0.8 });
  constexpr double peeling = 3. / 255.; // its textures have 8 bits
  this->expectOrder({ second, first }, peeling);
  this->look({ -4., 0.6, 0.8 });
  this->expectOrder({ first, second }, peeling);
}

TEST_F(SeveralVolumesTest, overlappingOnesAreMerged)
{
  this->add(red, { 0., 0., 0. });
  this->add(green, { 0.3, 0.2, 0.4 });
  const MessageCounter messages(Scene::mapperOf(volumes.front()));
  for (const double perLength : { 1., 0.1, 20. })
  {
    this->setExtinction(perLength);
    for (const bool parallel : { false, true })
    {
      scene.renderer->GetActiveCamera()->SetParallelProjection(parallel);
      for (const Point& from : { Point{ 4., 0.6, 0.8 }, Point{ -4., 0.6, 0.8 }, Point{ 1., 3., -2. } })
      {
        this->look(from);
        this->expectMerged(2. / 255., 0.4 / 255.);
      }
    }
  }
  // From inside both.
  scene.renderer->GetActiveCamera()->SetParallelProjection(false);
  this->setExtinction(1.);
  this->look({ 4., 0.6, 0.8 });
  scene.renderer->GetActiveCamera()->SetPosition(0.25, 0.15, 0.3);
  scene.renderer->GetActiveCamera()->SetFocalPoint(-1., 0.2, -0.3);
  scene.renderer->GetActiveCamera()->SetClippingRange(0.01, 10.);
  this->expectMerged(2. / 255., 0.4 / 255.);
  EXPECT_TRUE(messages.warnings.empty());
}

TEST_F(SeveralVolumesTest, threeThatOverlapAreMerged)
{
  this->add(red, { 0., 0., 0. });
  this->add(green, { 0.3, 0.2, 0.4 });
  this->add(blue, { -0.3, 0.3, 0.1 });
  this->setExtinction(1.);
  this->look({ 4., 0.6, 0.8 });
  this->expectMerged(2. / 255., 0.4 / 255.);
  // And one behind them all, of a mapper that another has, too.
  this->add(blue, { -2.5, 0., 0. })->SetMapper(volumes.front()->GetMapper());
  this->setExtinction(1.);
  this->look({ 4., 0.6, 0.8 });
  this->expectMerged(2. / 255., 0.4 / 255.);
}

TEST_F(SeveralVolumesTest, overlappingOnesAreMergedInDepthPeeling)
{
  this->add(red, { 0., 0., 0. });
  this->add(green, { 0.3, 0.2, 0.4 });
  this->setExtinction(1.);
  scene.renderer->UseDepthPeelingOn();
  scene.renderer->UseDepthPeelingForVolumesOn();
  scene.addRectangle({ 0., 5., 0. }, { 0.1, 0., 0. }, { 0., 0., 0.1 }, { 0., 0., 0. }, 0.5);
  this->look({ 4., 0.6, 0.8 });
  this->expectMerged(4. / 255., 1.5 / 255.); // textures of 8 bits
}

TEST_F(SeveralVolumesTest, whatCannotBeMergedIsSaidOnce)
{
  vtkVolume* first = this->add(red, { 0., 0., 0. });
  vtkVolume* second = this->add(green, { 0.5, 0., 0. });
  const MessageCounter messages(Scene::mapperOf(first));
  Scene::mapperOf(second)->SetBlendModeToMaximumIntensity();
  this->look({ 4., 0.6, 0.8 });
  this->expectOrder({ second, first });
  scene.render();
  EXPECT_EQ(messages.warnings.size(), 1u);
  Scene::mapperOf(second)->SetBlendModeToComposite();
  Scene::mapperOf(first)->SetEstimateError(true);
  scene.render();
  scene.render();
  EXPECT_EQ(messages.warnings.size(), 2u);
  EXPECT_EQ(Scene::statistic(first, "EstimatedError"), -1.);
}

TEST_F(SeveralVolumesTest, oneThatFailsLeavesTheOthers)
{
  this->add(red, { -0.6, 0., 0. });
  vtkVolume* second = this->add(green, { 0.6, 0., 0. });
  this->look({ 4., 0.6, 0.8 });
  const Picture expected = this->alone(second);
  Scene::mapperOf(volumes.front())->SelectScalarArray("no such");
  const MessageCounter messages(Scene::mapperOf(volumes.front()));
  EXPECT_EQ(scene.render(), expected);
  scene.render();
  EXPECT_EQ(messages.errors.size(), 1u);
}

} // namespace

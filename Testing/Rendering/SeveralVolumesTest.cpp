// Several volumes in one view, beside each other and overlapping.
#include "RenderingScene.h"

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
    volume->SetScale(0.5, 0.5, 0.5); // one wide
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

TEST_F(SeveralVolumesTest, overlappingOnesAreSaidOnce)
{
  vtkVolume* first = this->add(red, { 0., 0., 0. });
  vtkVolume* second = this->add(green, { 0.5, 0., 0. });
  const MessageCounter messages(Scene::mapperOf(first));
  this->look({ 4., 0.6, 0.8 });
  this->expectOrder({ second, first });
  scene.render();
  EXPECT_EQ(messages.warnings.size(), 1u);
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

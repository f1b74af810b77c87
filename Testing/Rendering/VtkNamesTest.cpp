// What programs written for VTK's volume mappers ask for under VTK's names: distances of samples, windows of colours,
// several windows, vtkMultiVolume.
#include "VolumePair.h"

#include "vtkMultiVolume.h"

namespace
{

using namespace treeamr::test;

using Picture = std::vector<std::array<float, 4>>;

class VtkNamesTest : public RenderingTest
{
};

TEST_F(VtkNamesTest, sampleDistances)
{
  Scene scene;
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", { 1., 1., 1. }, 1.);
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  scene.setCamera();
  const auto samples = [&] {
    scene.render();
    return Scene::statistic(volume, "SamplesPerCell");
  };
  EXPECT_EQ(samples(), 2.);
  mapper->SetSampleDistance(0.125); // the widest cells are 0.5 wide
  EXPECT_EQ(samples(), 4.);
  const Picture byDistance = scene.render();
  volume->SetScale(0.5, 2., 1.);
  EXPECT_EQ(samples(), 8.);
  volume->SetScale(1., 1., 1.);
  mapper->LockSampleDistanceToInputSpacingOn();
  EXPECT_EQ(samples(), 2.);
  mapper->LockSampleDistanceToInputSpacingOff();
  mapper->SetSampleDistance(1e-9);
  EXPECT_EQ(samples(), vtkTreeAMRVolumeMapper::MostSamplesPerCell);
  mapper->SetSampleDistance(1e9);
  EXPECT_EQ(samples(), vtkTreeAMRVolumeMapper::FewestSamplesPerCell);
  mapper->SetSampleDistance(-1.);
  EXPECT_EQ(samples(), 2.);
  mapper->SetSamplesPerCell(4.);
  EXPECT_EQ(scene.render(), byDistance);
}

TEST_F(VtkNamesTest, sampleDistancesOfRootsThatDiffer)
{
  GridOptions options;
  options.roots = { 3, 1, 1 };
  options.max = { 2., 0., 3. }; // roots of 1 x 1 x 4
  options.refine = [](const Point&, int level) { return level < 2; };
  Scene scene;
  vtkVolume* volume = scene.addVolume(
    makeGrid(options, { { "x", [](const Point& p) { return p[0]; } } }), "x", { 1., 1., 1. }, 1.);
  Scene::mapperOf(volume)->SetSampleDistance(0.5);
  scene.setCamera();
  scene.render();
  EXPECT_EQ(Scene::statistic(volume, "SamplesPerCell"), 2.); // cells are 1 long at most
}

TEST_F(VtkNamesTest, finalColorsAsVTK)
{
  VolumePair pair;
  const auto with = [&](double window, double level) {
    return pair.difference([&](vtkVolumeMapper* mapper) {
      if (auto* theirs = vtkGPUVolumeRayCastMapper::SafeDownCast(mapper))
      {
        theirs->SetFinalColorWindow(static_cast<float>(window));
        theirs->SetFinalColorLevel(static_cast<float>(level));
      }
      else
      {
        pair.mapper()->SetFinalColorWindow(window);
        pair.mapper()->SetFinalColorLevel(level);
      }
    });
  };
  const Picture plain = pair.scene.render();
  for (const auto& [window, level] : { std::pair(0.5, 0.5), std::pair(0.8, 0.3), std::pair(-1., 0.5) })
  {
    EXPECT_LT(with(window, level), 2.) << window << ", " << level;
  }
  EXPECT_LT(with(1., 0.5), 2.);
  MessageCounter messages(pair.mapper());
  pair.mapper()->SetFinalColorWindow(0.);
  pair.showOurs();
  pair.scene.render();
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("final color window"), std::string::npos);
}

// One after the other, again and again.
TEST_F(VtkNamesTest, oneMapperInTwoWindowsAtOnce)
{
  const auto grid = makeTestGrid();
  std::array<Scene, 2> shared;
  std::array<Scene, 2> apart;
  vtkVolume* first = shared[0].addVolume(grid, "x", { 1., 0.5, 0.2 }, 1.);
  vtkNew<vtkVolume> second;
  second->SetMapper(first->GetMapper());
  shared[1].renderer->AddVolume(second);
  for (int i = 0; i < 2; ++i)
  {
    vtkVolume* volume = apart[i].addVolume(grid, "x", { 1., 0.5, 0.2 }, 1.);
    if (i == 1)
    {
      vtkNew<vtkColorTransferFunction> colors;
      colors->AddRGBPoint(-1., 0., 1., 0.);
      colors->AddRGBPoint(1., 0., 0., 1.);
      volume->GetProperty()->SetColor(colors);
      volume->SetOrientation(10., 20., 30.);
      second->SetOrientation(10., 20., 30.);
      second->SetProperty(volume->GetProperty());
    }
  }
  std::array<Picture, 2> expected;
  for (int i = 0; i < 2; ++i)
  {
    shared[i].setCamera();
    apart[i].setCamera();
    expected[i] = apart[i].render();
  }
  EXPECT_NE(expected[0], expected[1]);
  for (int round = 0; round < 3; ++round)
  {
    for (int i = 0; i < 2; ++i)
    {
      EXPECT_EQ(shared[i].render(), expected[i]) << round << ", " << i;
    }
  }
  shared[0].window->Finalize(); // which releases what it has
  EXPECT_EQ(shared[1].render(), expected[1]);
}

TEST_F(VtkNamesTest, oneSurfaceMapperInTwoWindowsAtOnce)
{
  const auto grid = makeTestGrid();
  std::array<Scene, 2> shared;
  Scene apart;
  vtkActor* first = shared[0].addIsosurface(grid, "x", 0.1);
  vtkNew<vtkActor> second;
  second->SetMapper(first->GetMapper());
  second->GetProperty()->SetColor(0.2, 0.9, 0.3);
  shared[1].renderer->AddActor(second);
  apart.addIsosurface(grid, "x", 0.1)->GetProperty()->SetColor(0.2, 0.9, 0.3);
  for (Scene* scene : { &shared[0], &shared[1], &apart })
  {
    scene->setCamera();
  }
  const Picture ofFirst = shared[0].render();
  const Picture ofSecond = apart.render();
  for (int round = 0; round < 3; ++round)
  {
    EXPECT_EQ(shared[1].render(), ofSecond) << round;
    EXPECT_EQ(shared[0].render(), ofFirst) << round;
  }
  shared[0].window->Finalize();
  EXPECT_EQ(shared[1].render(), ofSecond);
}

TEST_F(VtkNamesTest, multiVolumesAreRefusedOnce)
{
  Scene scene;
  vtkSmartPointer<vtkVolume> volume = scene.addVolume(makeTestGrid(), "x", { 1., 1., 1. }, 1.);
  scene.renderer->RemoveVolume(volume);
  vtkNew<vtkMultiVolume> several;
  several->SetMapper(volume->GetMapper());
  several->SetVolume(volume, 0);
  const MessageCounter messages(Scene::mapperOf(volume));
  // VTK says itself, at each call, that it is for its GPU mapper alone.
  const MessageCounter ofVTK(several);
  scene.renderer->AddVolume(several);
  scene.renderer->SetActiveCamera(vtkNew<vtkCamera>());
  for (int i = 0; i < 3; ++i)
  {
    scene.render();
  }
  EXPECT_LE(messages.errors.size(), 1u);
  EXPECT_GE(messages.errors.size() + ofVTK.errors.size(), 1u);
  for (int i = 0; i < 2; ++i) // whether VTK has asked the mapper or not
  {
    Scene::mapperOf(volume)->Render(scene.renderer, several);
  }
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("vtkMultiVolume"), std::string::npos) << messages.errors[0];
}

} // namespace

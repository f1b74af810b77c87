// Faults from outside, and what the user sees of them:
//
//   fault                                            seen
//   no memory for field, surface or picture          one message; nothing of the prop in that frame, all in the next
//   no memory amid ambient occlusion                 one message; the next frame has each sample once
//   OpenGL context lost and made again               nothing: the next frame is drawn with new resources
//   prop moved to another window, the first closed   nothing
//   one prop or one grid in two windows              nothing; a prop in two windows uploads at each change of window
//   input replaced or changed in the middle of a     nothing of the old input after that; the frame is whole
//     frame, between its passes
//   input removed in the middle of a frame           one message, nothing of the prop; VTK itself then complains at
//                                                    every frame about a visible volume without input
#include "PlaneSurface.h"

#include "Surface/SecondaryRays.h"
#include "Volume/Volume.h"

#include "HyperTreeGridConverter.h"

#include "vtkCallbackCommand.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDoubleArray.h"

#include <dlfcn.h>

#include <functional>
#include <new>

using namespace treeamr::test;

namespace
{

/// The call that makes it 0 finds no memory.
int untilShortage = 0;

bool isShort()
{
  return untilShortage > 0 && --untilShortage == 0;
}

template <class Function>
Function original(const char* name)
{
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

} // namespace

// In front of the libraries' functions.
namespace treeamr
{

std::shared_ptr<const Field> acquireField(vtkHyperTreeGrid* grid, const ArraySelection& selection)
{
  if (isShort())
  {
    throw std::bad_alloc();
  }
  return original<decltype(&acquireField)>(
    "_ZN7treeamr12acquireFieldEP16vtkHyperTreeGridRKNS_14ArraySelectionE")(grid, selection);
}

void traceAmbientOcclusion(const Isosurface& surface, const Camera& camera, const HitImage& hits,
  double radius, int first, int end, std::vector<std::uint16_t>& open, const DataCut& cut, Progress* progress)
{
  original<decltype(&traceAmbientOcclusion)>(
    "_ZN7treeamr21traceAmbientOcclusionERKNS_10IsosurfaceERKNS_6CameraERKNS_8HitImageEdiiRSt6vectorItSaItEE"
    "RKNS_7DataCutEPNS_8ProgressE")(surface, camera, hits, radius, first, end, open, cut, progress);
  if (isShort())
  {
    throw std::bad_alloc(); // after having added what it found
  }
}

} // namespace treeamr

namespace
{

constexpr Color orange{ 0.9, 0.5, 0.2 };
constexpr double extinction = 0.8;
constexpr double still = 0.002;
constexpr double interactive = 15.;

using Pixels = std::vector<std::array<float, 4>>;

class FaultsTest : public RenderingTest
{
protected:
  /// A volume, an isosurface and polygons, all in sight.
  struct Props
  {
    explicit Props(Scene& scene, vtkHyperTreeGrid* grid = makeTestGrid())
    {
      volume = scene.addVolume(grid, "x", orange, extinction);
      surface = scene.addIsosurface(grid, "y", 0.3);
      scene.addRectangle({ 0., 0., -0.2 }, { 0.7, 0., 0. }, { 0., 0.4, 0.3 }, { 0.2, 0.5, 0.8 }, 0.6);
      scene.addRectangle({ 0.5, 0., -0.2 }, { 0., 0., 0.7 }, { 0., 0.4, 0.3 }, { 0.8, 0.5, 0.8 });
      scene.setCamera();
      scene.renderer->GetActiveCamera()->SetClippingRange(0.1, 30.);
    }
    vtkSmartPointer<vtkVolume> volume;
    vtkSmartPointer<vtkActor> surface;
  };

  static void observe(vtkObject* object, unsigned long event, std::function<void()> work)
  {
    vtkNew<vtkCallbackCommand> command;
    command->SetClientData(new std::function<void()>(std::move(work)));
    command->SetClientDataDeleteCallback(
      [](void* data) { delete static_cast<std::function<void()>*>(data); });
    command->SetCallback(
      [](vtkObject*, unsigned long, void* data, void*) { (*static_cast<std::function<void()>*>(data))(); });
    object->AddObserver(event, command);
  }
};

void expectOneMessage(const MessageCounter& messages)
{
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("not enough memory"), std::string::npos) << messages.errors[0];
}

} // namespace

TEST_F(FaultsTest, noMemoryForAnotherField)
{
  Scene scene;
  Props props(scene);
  vtkTreeAMRVolumeMapper* volume = Scene::mapperOf(props.volume);
  vtkTreeAMRIsosurfaceMapper* surface = Scene::mapperOf(props.surface);
  const auto contour = [&](const char* name) {
    surface->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, name);
  };
  const Pixels old = scene.render();
  volume->SelectScalarArray("z");
  contour("z");
  const Pixels expected = scene.render();
  ASSERT_NE(old, expected);
  volume->SelectScalarArray("x");
  contour("y");
  ASSERT_EQ(scene.render(), old);
  {
    MessageCounter messages(volume);
    volume->SelectScalarArray("z");
    untilShortage = 1;
    scene.render();
    expectOneMessage(messages);
  }
  {
    MessageCounter messages(surface);
    contour("z");
    untilShortage = 1;
    scene.render();
    expectOneMessage(messages);
  }
  EXPECT_EQ(untilShortage, 0);
  EXPECT_EQ(scene.render(), expected);
}

TEST_F(FaultsTest, noMemoryAmidAmbientOcclusion)
{
  Scene scene;
  Props props(scene);
  vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(props.surface);
  mapper->SetNumberOfContours(2);
  mapper->SetValue(1, 0.2);
  mapper->SetAmbientOcclusionRadius(0.2);
  mapper->SetAmbientOcclusionSamples(6);
  mapper->AutoAdjustSampleDistancesOff();
  const Pixels expected = scene.render();
  vtkCamera* camera = scene.renderer->GetActiveCamera();
  for (const int frame : { 1, 2 })
  {
    camera->Azimuth(1.);
    scene.render();
    camera->Azimuth(-1.);
    scene.window->SetDesiredUpdateRate(interactive);
    MessageCounter messages(mapper);
    untilShortage = frame;
    for (int i = 0; i < frame; ++i)
    {
      scene.render();
    }
    ASSERT_EQ(untilShortage, 0);
    expectOneMessage(messages);
    scene.window->SetDesiredUpdateRate(still);
    EXPECT_EQ(scene.render(), expected) << "after frame " << frame;
  }
}

TEST_F(FaultsTest, contextLostAndMadeAgain)
{
  for (const bool peeling : { false, true })
  {
    Scene scene;
    Props props(scene);
    scene.renderer->SetUseDepthPeeling(peeling);
    scene.renderer->SetUseDepthPeelingForVolumes(peeling);
    const Pixels expected = scene.render();
    for (int i = 0; i < 3; ++i)
    {
      scene.window->Finalize();
      EXPECT_EQ(scene.render(), expected);
      EXPECT_EQ(scene.render(), expected);
    }
  }
}

TEST_F(FaultsTest, movedToAnotherWindow)
{
  Pixels expected;
  vtkSmartPointer<vtkVolume> volume;
  vtkSmartPointer<vtkActor> surface;
  {
    Scene first;
    Props props(first);
    expected = first.render();
    volume = props.volume;
    surface = props.surface;
  }
  for (int i = 0; i < 3; ++i)
  {
    Scene next;
    Props props(next);
    next.renderer->RemoveVolume(props.volume);
    next.renderer->RemoveActor(props.surface);
    next.renderer->AddVolume(volume);
    next.renderer->AddActor(surface);
    EXPECT_EQ(next.render(), expected);
    EXPECT_EQ(next.render(), expected);
  }
}

// Each window has resources of its own, which the other must not delete.
TEST_F(FaultsTest, onePropInTwoWindows)
{
  for (const bool peeling : { false, true })
  {
    Scene first;
    Props props(first);
    first.renderer->SetUseDepthPeeling(peeling);
    first.renderer->SetUseDepthPeelingForVolumes(peeling);
    const Pixels ofFirst = first.render();

    Scene second(50, 60);
    for (int i = 0; i < 12; ++i)
    {
      second.addRectangle({ 0.1 * i - 0.6, 0.9, 0.1 * i }, { 0.04, 0., 0. }, { 0., 0., 0.3 }, orange);
    }
    Props others(second);
    second.renderer->SetUseDepthPeeling(peeling);
    second.renderer->SetUseDepthPeelingForVolumes(peeling);
    const Pixels ofSecond = second.render();
    second.renderer->RemoveVolume(others.volume);
    second.renderer->RemoveActor(others.surface);
    second.renderer->AddVolume(props.volume);
    second.renderer->AddActor(props.surface);
    for (int i = 0; i < 4; ++i)
    {
      EXPECT_EQ(second.render(), ofSecond) << i;
      EXPECT_EQ(first.render(), ofFirst) << i;
    }
    // More resources in between, whose names are the next free ones.
    Scene third(40, 40);
    Props inThird(third);
    const Pixels ofThird = third.render();
    first.addRectangle({ 0., 0.5, 0. }, { 0.5, 0., 0. }, { 0., 0., 0.5 }, { 1., 0., 0. });
    const Pixels withRectangle = first.render();
    EXPECT_NE(withRectangle, ofFirst);
    EXPECT_EQ(second.render(), ofSecond);
    EXPECT_EQ(third.render(), ofThird);
    EXPECT_EQ(first.render(), withRectangle);
  }
}

TEST_F(FaultsTest, oneGridInTwoWindows)
{
  const vtkSmartPointer<vtkHyperTreeGrid> grid = makeTestGrid();
  Scene first;
  Props props(first, grid);
  Scene second;
  Props others(second, grid);
  const Pixels expected = first.render();
  EXPECT_EQ(second.render(), expected);
  for (int i = 0; i < 3; ++i)
  {
    vtkDataArray* values = grid->GetCellData()->GetArray("x");
    values->SetTuple1(0, i % 2 == 0 ? 1. : -0.75);
    values->Modified();
    grid->GetCellData()->Modified();
    const Pixels changed = first.render();
    EXPECT_EQ(second.render(), changed);
  }
}

// The old grid dies with its replacement.
TEST_F(FaultsTest, inputReplacedAmidAFrame)
{
  GridOptions options;
  options.roots = { 3, 3, 3 };
  const std::vector<std::pair<std::string, ScalarField>> arrays{ { "x", [](const Point& p) { return p[1]; } },
    { "y", [](const Point& p) { return p[0] + 0.2 * p[2]; } } };
  for (const bool peeling : { false, true })
  {
    Scene reference;
    Props ofReference(reference, makeGrid(options, arrays));
    reference.renderer->SetUseDepthPeeling(peeling);
    reference.renderer->SetUseDepthPeelingForVolumes(peeling);
    ofReference.surface->GetProperty()->SetOpacity(peeling ? 0.5 : 1.);
    const Pixels expected = reference.render();
    // Before the first part of a frame, and between two of them.
    for (const int part : { 1, 2 })
    {
      Scene scene;
      Props props(scene);
      scene.renderer->SetUseDepthPeeling(peeling);
      scene.renderer->SetUseDepthPeelingForVolumes(peeling);
      props.surface->GetProperty()->SetOpacity(peeling ? 0.5 : 1.);
      scene.render();
      int starts = 0;
      observe(props.volume->GetMapper(), vtkCommand::VolumeMapperRenderStartEvent, [&] {
        if (++starts == part)
        {
          const vtkSmartPointer<vtkHyperTreeGrid> grid = makeGrid(options, arrays);
          Scene::mapperOf(props.volume)->SetInputData(grid.Get());
          Scene::mapperOf(props.surface)->SetInputData(grid);
        }
      });
      scene.render();
      scene.render();
      EXPECT_GE(starts, part);
      EXPECT_EQ(scene.render(), expected) << "part " << part << (peeling ? " with peeling" : "");
    }
  }
}

TEST_F(FaultsTest, inputRemovedAmidAFrame)
{
  Scene scene;
  Props props(scene);
  const Pixels complete = scene.render();
  props.volume->VisibilityOff();
  const Pixels withoutVolume = scene.render();
  props.volume->VisibilityOn();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(props.volume);
  observe(mapper, vtkCommand::VolumeMapperRenderStartEvent, [&] { mapper->SetInputConnection(nullptr); });
  MessageCounter messages(mapper);
  EXPECT_EQ(scene.render(), withoutVolume);
  ASSERT_EQ(messages.errors.size(), 1u);
  EXPECT_NE(messages.errors[0].find("no input"), std::string::npos);
  mapper->RemoveObservers(vtkCommand::VolumeMapperRenderStartEvent);
  mapper->SetInputData(makeTestGrid().Get());
  EXPECT_EQ(scene.render(), complete);
}

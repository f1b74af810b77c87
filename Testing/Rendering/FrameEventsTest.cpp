// Events of long frames, and frames that are stopped: by any observer, of volumes and surfaces.
#include "RenderingScene.h"

#include "vtkCallbackCommand.h"
#include "vtkCommand.h"
#include "vtkDummyCommunicator.h"
#include "vtkDummyController.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkPiecewiseFunction.h"

#include <chrono>
#include <thread>

namespace
{

using namespace treeamr::test;

/// Calls a function at an event while it lives.
class Observer
{
public:
  Observer(vtkObject* object, unsigned long event, std::function<void(void*)> call)
    : object_(object)
    , call_(std::move(call))
  {
    command_->SetClientData(this);
    command_->SetCallback([](vtkObject*, unsigned long, void* self, void* data) {
      EXPECT_EQ(std::this_thread::get_id(), static_cast<Observer*>(self)->thread_);
      ++static_cast<Observer*>(self)->count;
      static_cast<Observer*>(self)->call_(data);
    });
    tag_ = object->AddObserver(event, command_);
  }
  ~Observer() { object_->RemoveObserver(tag_); }
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

  int count = 0;

private:
  vtkObject* object_;
  std::function<void(void*)> call_;
  std::thread::id thread_ = std::this_thread::get_id();
  vtkNew<vtkCallbackCommand> command_;
  unsigned long tag_;
};

class TwoProcesses : public vtkDummyCommunicator
{
public:
  static TwoProcesses* New();
  vtkTypeMacro(TwoProcesses, vtkDummyCommunicator);

protected:
  TwoProcesses() { this->MaximumNumberOfProcesses = this->NumberOfProcesses = 2; }
};
vtkStandardNewMacro(TwoProcesses);

constexpr unsigned long progressOfVolumes = vtkCommand::VolumeMapperRenderProgressEvent;

using Picture = std::vector<std::array<float, 4>>;

/// Renders a frame that an observer ends when the event comes the second time: then it comes no more.
void stop(Scene& scene, vtkObject* object, unsigned long event)
{
  int count = 0;
  const Observer observer(object, event, [&](void*) { scene.window->SetAbortRender(++count > 1); });
  scene.render();
  EXPECT_EQ(count, 2);
}

class FrameEventsTest : public RenderingTest
{
protected:
  FrameEventsTest()
    : scene(300, 300)
    , volume(scene.addVolume(makeTestGrid(), "x", { 1., 0.6, 0.2 }, 0.4))
    , mapper(Scene::mapperOf(volume))
  {
    // Such as every sample changes.
    volume->GetProperty()->GetScalarOpacity()->AddPoint(-1., 0.01);
    volume->GetProperty()->GetScalarOpacity()->AddPoint(1., 0.3);
    scene.setCamera();
  }
  /// To what takes a second on this machine, or that many times longer, and back.
  void makeLong(double times = 1.)
  {
    mapper->SetSamplesPerCell(256.);
    for (const int size : { 800, 1200, 1800, 2700, 4000 })
    {
      scene.window->SetSize(size, size);
      const auto start = std::chrono::steady_clock::now();
      scene.render();
      if (std::chrono::steady_clock::now() - start > std::chrono::seconds(1))
      {
        break;
      }
    }
    mapper->SetSamplesPerCell(256. * times);
  }
  void makeShort()
  {
    scene.window->SetSize(300, 300);
    mapper->SetSamplesPerCell(2.);
  }

  Scene scene;
  vtkVolume* volume;
  vtkTreeAMRVolumeMapper* mapper;
};

TEST_F(FrameEventsTest, aFrameHasStartAndEnd)
{
  std::vector<int> order;
  const Observer start(mapper, vtkCommand::VolumeMapperRenderStartEvent, [&](void*) { order.push_back(1); });
  const Observer end(mapper, vtkCommand::VolumeMapperRenderEndEvent, [&](void*) { order.push_back(2); });
  scene.render();
  EXPECT_EQ(order, (std::vector{ 1, 2 }));
}

TEST_F(FrameEventsTest, progressIsToldOnThisThread)
{
  this->makeLong();
  double last = 0.;
  const auto rises = [&](void* data) {
    const double part = *static_cast<double*>(data);
    EXPECT_GE(part, last);
    EXPECT_LE(part, 1.);
    last = part;
  };
  const Observer ofVolumes(mapper, progressOfVolumes, rises);
  const Observer ofAlgorithms(mapper, vtkCommand::ProgressEvent, [](void*) {});
  scene.render();
  EXPECT_GT(last, 0.5);
  EXPECT_GE(ofAlgorithms.count, ofVolumes.count); // pipelines have theirs
  EXPECT_GE(ofVolumes.count, 3);
}

TEST_F(FrameEventsTest, progressIsToldOnRequest)
{
  this->makeLong();
  mapper->ReportProgressOff();
  const Observer progress(mapper, progressOfVolumes, [](void*) {});
  const Observer check(scene.window, vtkCommand::AbortCheckEvent, [](void*) {});
  scene.render();
  EXPECT_EQ(progress.count, 0);
  EXPECT_GE(check.count, 2);
}

TEST_F(FrameEventsTest, observersChangeNoPixel)
{
  this->makeLong();
  const Picture expected = scene.render();
  Scene other;
  other.addRectangle({ 0., 0., 0. }, { 1., 0., 0. }, { 0., 1., 0. }, { 1., 0., 0. });
  other.setCamera();
  const Observer progress(mapper, progressOfVolumes, [&](void*) {
    other.render(); // whose context is current now
  });
  const Observer check(scene.window, vtkCommand::AbortCheckEvent, [&](void*) {
    // As others leave it that draw in the same context.
    vtkOpenGLState* state = vtkOpenGLRenderWindow::SafeDownCast(scene.window)->GetState();
    state->vtkglViewport(0, 0, 7, 7);
    state->vtkglDisable(GL_BLEND);
    state->vtkglColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  });
  EXPECT_EQ(scene.render(), expected);
  EXPECT_GE(progress.count, 2);
  EXPECT_GE(check.count, 2);
}

TEST_F(FrameEventsTest, framesWithinFramesAreRefused)
{
  this->makeLong();
  const Picture expected = scene.render();
  Scene other;
  other.renderer->AddVolume(volume);
  other.setCamera();
  const MessageCounter messages(mapper);
  Picture nested;
  const Observer progress(mapper, progressOfVolumes, [&](void*) { nested = other.render(); });
  EXPECT_EQ(scene.render(), expected);
  EXPECT_EQ(messages.warnings.size(), 1u);
  other.renderer->RemoveVolume(volume);
  EXPECT_EQ(nested, other.render()) << "nothing is drawn within";
}

TEST_F(FrameEventsTest, aVolumeIsStopped)
{
  const Picture expected = scene.render();
  this->makeLong(4.);
  stop(scene, mapper, progressOfVolumes);
  EXPECT_EQ(Scene::statistic(volume, "Samples"), 0.);
  this->makeShort();
  EXPECT_EQ(scene.render(), expected);
}

TEST_F(FrameEventsTest, windowsCheckForAborts)
{
  const Picture expected = scene.render();
  this->makeLong(4.);
  const Observer end(mapper, vtkCommand::VolumeMapperRenderEndEvent, [](void*) {});
  stop(scene, scene.window, vtkCommand::AbortCheckEvent); // once at the start
  EXPECT_EQ(end.count, 1);
  EXPECT_EQ(Scene::statistic(volume, "Samples"), 0.);
  this->makeShort();
  EXPECT_EQ(scene.render(), expected);
}

TEST_F(FrameEventsTest, withAnErrorToEstimateOrToMeet)
{
  const Picture expected = scene.render();
  mapper->EstimateErrorOn();
  this->makeLong(4.);
  stop(scene, mapper, progressOfVolumes);
  EXPECT_EQ(Scene::statistic(volume, "EstimatedError"), -1.);
  this->makeShort();
  EXPECT_EQ(scene.render(), expected);
  EXPECT_GT(Scene::statistic(volume, "EstimatedError"), 0.);
}

TEST_F(FrameEventsTest, oneOfSeveralProcessesGoesOn)
{
  this->makeLong();
  const Picture expected = scene.render();
  vtkNew<TwoProcesses> two;
  vtkNew<vtkDummyController> processes;
  processes->SetCommunicator(two);
  ASSERT_EQ(processes->GetNumberOfProcesses(), 2);
  vtkMultiProcessController* const before = vtkMultiProcessController::GetGlobalController();
  vtkMultiProcessController::SetGlobalController(processes);
  const Observer progress(mapper, progressOfVolumes, [&](void*) { scene.window->SetAbortRender(1); });
  const Picture picture = scene.render();
  vtkMultiProcessController::SetGlobalController(before);
  EXPECT_GE(progress.count, 3);
  EXPECT_EQ(picture, expected);
}

TEST_F(FrameEventsTest, depthPeelingIsStopped)
{
  scene.renderer->UseDepthPeelingOn();
  scene.renderer->UseDepthPeelingForVolumesOn();
  scene.addRectangle({ 0., 0., 0. }, { 1., 0.3, 0. }, { 0., 1., 0.4 }, { 0., 0., 1. }, 0.5);
  const Picture expected = scene.render();
  this->makeLong(4.);
  stop(scene, mapper, progressOfVolumes);
  this->makeShort();
  EXPECT_EQ(scene.render(), expected);
}

class SurfaceEventsTest : public RenderingTest
{
protected:
  SurfaceEventsTest()
    : scene(300, 300)
    , actor(scene.addIsosurface(makeTestGrid(), "x", 0.1))
    , mapper(Scene::mapperOf(actor))
  {
    scene.setCamera();
    actor->GetProperty()->LightingOn();
    mapper->SetAmbientOcclusionSamples(4);
  }
  /// Occlusion takes all the time.
  void stopOcclusion(vtkObject* object, unsigned long event = vtkCommand::ProgressEvent)
  {
    const int samples = mapper->GetAmbientOcclusionSamples();
    mapper->SetAmbientOcclusionSamples(4096);
    stop(scene, object, event);
    mapper->SetAmbientOcclusionSamples(samples);
  }

  Scene scene;
  vtkActor* actor;
  vtkTreeAMRIsosurfaceMapper* mapper;
};

TEST_F(SurfaceEventsTest, occlusionIsStopped)
{
  const Picture expected = scene.render();
  this->stopOcclusion(mapper);
  EXPECT_EQ(scene.render(), expected);
}

TEST_F(SurfaceEventsTest, windowsCheckForAborts)
{
  const Picture expected = scene.render();
  this->stopOcclusion(scene.window, vtkCommand::AbortCheckEvent);
  EXPECT_EQ(scene.render(), expected);
}

TEST_F(SurfaceEventsTest, translucentLayersAreStopped)
{
  for (const bool peeling : { false, true })
  {
    scene.renderer->SetUseDepthPeeling(peeling);
    actor->GetProperty()->SetOpacity(0.5);
    const Picture expected = scene.render();
    this->stopOcclusion(mapper);
    EXPECT_EQ(scene.render(), expected);
  }
}

TEST_F(SurfaceEventsTest, aVolumeThatDrawsThemIsStopped)
{
  vtkVolume* volume = scene.addVolume(makeTestGrid(), "x", { 1., 0.6, 0.2 }, 0.4);
  actor->GetProperty()->SetOpacity(0.5);
  const Picture expected = scene.render();
  this->stopOcclusion(Scene::mapperOf(volume), progressOfVolumes);
  EXPECT_EQ(scene.render(), expected);
}

TEST_F(SurfaceEventsTest, theFrameAfterIsWhole)
{
  const Picture expected = scene.render();
  this->stopOcclusion(mapper);
  scene.window->SetAbortRender(1); // VTK takes it back when a frame starts
  EXPECT_EQ(scene.render(), expected);
}

} // namespace

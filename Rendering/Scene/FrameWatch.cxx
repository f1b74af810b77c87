#include "FrameWatch.h"

#include "vtkAlgorithm.h"
#include "vtkCommand.h"
#include "vtkMultiProcessController.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"

namespace treeamr
{

namespace
{

thread_local bool observersAreCalled = false;

/// For observers, which may draw elsewhere.
class Events
{
public:
  explicit Events(vtkRenderWindow* window)
    : window_(vtkOpenGLRenderWindow::SafeDownCast(window))
  {
    observersAreCalled = true;
    if (window_)
    {
      window_->GetState()->Push();
    }
  }
  ~Events()
  {
    observersAreCalled = false;
    if (window_)
    {
      window_->MakeCurrent();
      window_->GetState()->Pop();
    }
  }
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;

private:
  vtkOpenGLRenderWindow* window_;
};

/// A process that stopped alone would leave its part out of the picture of all.
bool isOneOfMany()
{
  vtkMultiProcessController* const all = vtkMultiProcessController::GetGlobalController();
  return all && all->GetNumberOfProcesses() > 1;
}

} // namespace

FrameWatch::FrameWatch(vtkRenderer* renderer, vtkAlgorithm* mapper, bool tells, unsigned long event)
  : renderer_(renderer)
  , mapper_(mapper)
  , tells_(tells)
  , event_(event)
  , isSelection_(renderer->GetSelector() != nullptr)
  , progress_([this](double part) { return this->report(part); })
{
}

bool FrameWatch::isReporting()
{
  return observersAreCalled;
}

/// Whether the window has somebody to ask for aborts.
bool FrameWatch::checks() const
{
  vtkRenderWindow* const window = renderer_->GetRenderWindow();
  return window && window->HasObserver(vtkCommand::AbortCheckEvent);
}

/// Whether the mapper has somebody to tell its progress.
bool FrameWatch::tells() const
{
  return tells_ &&
    (mapper_->HasObserver(vtkCommand::ProgressEvent) || (event_ != 0 && mapper_->HasObserver(event_)));
}

bool FrameWatch::isAborted() const
{
  vtkRenderWindow* const window = renderer_->GetRenderWindow();
  return window && window->GetAbortRender() != 0 && !isOneOfMany();
}

bool FrameWatch::canDraw()
{
  if (observersAreCalled)
  {
    return false;
  }
  if (isSelection_)
  {
    return true;
  }
  if (this->checks())
  {
    const Events events(renderer_->GetRenderWindow());
    renderer_->GetRenderWindow()->CheckAbortStatus();
  }
  return !this->isAborted();
}

bool FrameWatch::report(double part)
{
  const bool checks = this->checks();
  const bool tells = this->tells();
  if (checks || tells)
  {
    vtkRenderWindow* const window = renderer_->GetRenderWindow();
    const Events events(window);
    if (checks)
    {
      window->CheckAbortStatus();
    }
    if (tells)
    {
      if (event_ != 0)
      {
        mapper_->InvokeEvent(event_, &part);
      }
      mapper_->UpdateProgress(part);
    }
  }
  return !this->isAborted();
}

} // namespace treeamr

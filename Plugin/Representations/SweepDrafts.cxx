#include "SweepDrafts.h"

#include "vtkCommand.h"
#include "vtkObjectFactory.h"
#include "vtkPVRenderView.h"
#include "vtkPVSession.h"
#include "vtkProcessModule.h"
#include "vtkRenderWindow.h"
#include "vtkRenderWindowInteractor.h"
#include "vtkSmartPointer.h"

#include <utility>

vtkStandardNewMacro(SweepDrafts);

namespace
{

/// What vtkPVRenderView asks its window for in interactive frames; 1 and more is interactive to the mappers.
constexpr double interactiveRate = 5.;
/// From the draft of the last change to the full picture.
constexpr unsigned long delayInMilliseconds = 300;

/// ParaView hides drawing into the back buffer from the user when it captures and when it selects.
bool isStillOnScreen(vtkRenderWindow* window)
{
  return window->GetDesiredUpdateRate() < 1. && window->GetSwapBuffers();
}

/// Timers of other classes do not run, or nobody runs them.
bool hasEventLoop(vtkRenderWindowInteractor* interactor)
{
  return interactor && interactor->IsA("QVTKInteractor") && interactor->GetEnabled();
}

} // namespace

//------------------------------------------------------------------------------
SweepDrafts::~SweepDrafts()
{
  this->Cancel();
}

//------------------------------------------------------------------------------
void SweepDrafts::StartFrame(vtkPVRenderView* view, const std::vector<double>& values)
{
  ++this->Frames;
  const bool areSwept = !values.empty() && !this->Values.empty() && values != this->Values;
  this->Values = values;
  vtkRenderWindow* window = view->GetRenderWindow();
  if (!isStillOnScreen(window))
  {
    return;
  }
  this->Cancel();
  if (areSwept && hasEventLoop(view->GetInteractor()) && !view->GetUseDistributedRenderingForRender())
  {
    window->SetDesiredUpdateRate(interactiveRate); // until the view's next frame
    this->View = view;
    this->Session = vtkPVSession::SafeDownCast(vtkProcessModule::GetProcessModule()->GetSession());
    this->IsInDraft = true;
    this->StartTimer(0);
  }
}

//------------------------------------------------------------------------------
void SweepDrafts::StartTimer(unsigned long milliseconds)
{
  this->Interactor = this->View->GetInteractor();
  this->Observer = this->Interactor->AddObserver(vtkCommand::TimerEvent, this, &SweepDrafts::TimerFired);
  this->Timer = this->Interactor->CreateOneShotTimer(milliseconds);
}

//------------------------------------------------------------------------------
void SweepDrafts::Cancel()
{
  if (this->Timer != 0 && this->Interactor)
  {
    this->Interactor->RemoveObserver(this->Observer);
    this->Interactor->DestroyTimer(this->Timer);
  }
  this->Timer = 0;
}

//------------------------------------------------------------------------------
void SweepDrafts::TimerFired(vtkObject* vtkNotUsed(caller), unsigned long vtkNotUsed(event), void* timer)
{
  if (*static_cast<int*>(timer) == this->Timer)
  {
    this->DrawStill();
  }
}

//------------------------------------------------------------------------------
void SweepDrafts::DrawStill()
{
  this->Cancel();
  const vtkSmartPointer<vtkPVRenderView> view = this->View.Get();
  if (!view || !hasEventLoop(view->GetInteractor()))
  {
    return;
  }
  // The still frame cancels it. An interactive one, while a mouse button is down, leaves it due.
  this->StartTimer(delayInMilliseconds);
  // The first time the draft has just been drawn, for however long. No frame inside another, nor while a pipeline runs.
  if (std::exchange(this->IsInDraft, false) || (this->Session && this->Session->GetPendingProgress()))
  {
    return;
  }
  const vtkSmartPointer<SweepDrafts> self = this; // rendering may delete the representation
  const unsigned int frames = this->Frames;
  view->GetInteractor()->Render(); // by the view's proxy
  if (this->Timer != 0 && this->Frames == frames)
  {
    // Not by the proxy when its EnableRenderOnInteraction is off.
    this->Cancel();
    view->StillRender();
  }
}

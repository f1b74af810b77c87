#include "SweepDrafts.h"

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

/// ParaView hides drawing into the back buffer from the user when it captures and when it selects.
bool isStillOnScreen(vtkRenderWindow* window)
{
  return window->GetDesiredUpdateRate() < 1. && window->GetSwapBuffers();
}

} // namespace

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
  if (areSwept && InteractorTimer::IsAvailable(view->GetInteractor()) &&
    !view->GetUseDistributedRenderingForRender())
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
  this->Timer.Start(this->View->GetInteractor(), milliseconds, [this] { this->DrawStill(); });
}

//------------------------------------------------------------------------------
void SweepDrafts::DrawStill()
{
  const vtkSmartPointer<vtkPVRenderView> view = this->View.Get();
  if (!view || !InteractorTimer::IsAvailable(view->GetInteractor()))
  {
    return;
  }
  // The still frame cancels it. An interactive one, while a mouse button is down, leaves it due.
  this->StartTimer(InteractorTimer::stillDelay);
  // The first time the draft has just been drawn, for however long. No frame inside another, nor while a pipeline runs.
  if (std::exchange(this->IsInDraft, false) || (this->Session && this->Session->GetPendingProgress()))
  {
    return;
  }
  const vtkSmartPointer<SweepDrafts> self = this; // rendering may delete the representation
  const unsigned int frames = this->Frames;
  view->GetInteractor()->Render(); // by the view's proxy
  if (this->Timer.IsRunning() && this->Frames == frames)
  {
    // Not by the proxy when its EnableRenderOnInteraction is off.
    this->Cancel();
    view->StillRender();
  }
}

#include "SliderPreview.h"

#include "vtkCommand.h"
#include "vtkSMDoubleRangeDomain.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSession.h"
#include "vtkSMUncheckedPropertyHelper.h"
#include "vtkSMViewProxy.h"

//------------------------------------------------------------------------------
SliderPreview::~SliderPreview()
{
  if (this->Property)
  {
    this->Property->RemoveObserver(this->Observer);
  }
}

//------------------------------------------------------------------------------
void SliderPreview::Connect(vtkSMProperty* property, const std::function<vtkSMViewProxy*()>& view,
  const std::function<void(double)>& set)
{
  this->Property = property;
  this->View = view;
  this->Set = set;
  this->Observer = property->AddObserver(
    vtkCommand::UncheckedPropertyModifiedEvent, this, &SliderPreview::UncheckedModified);
}

//------------------------------------------------------------------------------
void SliderPreview::UncheckedModified()
{
  const double value = vtkSMUncheckedPropertyHelper(this->Property).GetAsDouble();
  const bool isSet = value == vtkSMPropertyHelper(this->Property).GetAsDouble();
  if (isSet && this->Drawn.value_or(value) == value)
  {
    // By the panel, which draws, too: with keys and wheels at each step.
    this->Drawn.reset();
    this->Timer.Cancel();
    return;
  }
  this->Schedule(0, &SliderPreview::DrawDraft);
}

//------------------------------------------------------------------------------
void SliderPreview::Schedule(unsigned long milliseconds, void (SliderPreview::*draw)())
{
  vtkSMViewProxy* view = this->View();
  if (view && InteractorTimer::IsAvailable(view->GetInteractor()))
  {
    this->Timer.Start(view->GetInteractor(), milliseconds, [this, draw] {
      vtkSMViewProxy* drawn = this->View();
      if (drawn && drawn->GetSession()->GetPendingProgress())
      {
        this->Schedule(InteractorTimer::stillDelay, draw); // no frame inside another
      }
      else if (drawn)
      {
        (this->*draw)();
      }
    });
  }
}

//------------------------------------------------------------------------------
void SliderPreview::DrawDraft()
{
  const double value = vtkSMUncheckedPropertyHelper(this->Property).GetAsDouble();
  auto range = vtkSMDoubleRangeDomain::SafeDownCast(this->Property->GetDomain("range"));
  // What lies outside is a number that is being typed.
  if (range && range->GetMinimumExists(0) && range->GetMaximumExists(0) && range->GetMinimum(0) <= value &&
    value <= range->GetMaximum(0))
  {
    this->Drawn = value;
    this->Set(value);
    this->Schedule(InteractorTimer::stillDelay, &SliderPreview::DrawStill);
    this->View()->InteractiveRender();
  }
}

//------------------------------------------------------------------------------
void SliderPreview::DrawStill()
{
  this->View()->StillRender();
}

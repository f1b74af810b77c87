#include "InteractorTimer.h"

#include "vtkCommand.h"
#include "vtkRenderWindowInteractor.h"

//------------------------------------------------------------------------------
InteractorTimer::~InteractorTimer()
{
  this->Cancel();
}

//------------------------------------------------------------------------------
bool InteractorTimer::IsAvailable(vtkRenderWindowInteractor* interactor)
{
  return interactor && interactor->IsA("QVTKInteractor") && interactor->GetEnabled();
}

//------------------------------------------------------------------------------
void InteractorTimer::Start(
  vtkRenderWindowInteractor* interactor, unsigned long milliseconds, const std::function<void()>& call)
{
  this->Cancel();
  this->Interactor = interactor;
  this->Call = call;
  this->Observer = interactor->AddObserver(vtkCommand::TimerEvent, this, &InteractorTimer::Fired);
  this->Timer = interactor->CreateOneShotTimer(milliseconds);
}

//------------------------------------------------------------------------------
void InteractorTimer::Cancel()
{
  if (this->Timer != 0 && this->Interactor)
  {
    this->Interactor->RemoveObserver(this->Observer);
    this->Interactor->DestroyTimer(this->Timer);
  }
  this->Timer = 0;
}

//------------------------------------------------------------------------------
void InteractorTimer::Fired(vtkObject* vtkNotUsed(caller), unsigned long vtkNotUsed(event), void* timer)
{
  if (*static_cast<int*>(timer) == this->Timer)
  {
    const std::function<void()> call = this->Call;
    this->Cancel();
    call();
  }
}

// A call from the event loop of ParaView's GUI, some time later.
#pragma once

#include "vtkWeakPointer.h"

#include <functional>

class vtkObject;
class vtkRenderWindowInteractor;

class InteractorTimer
{
public:
  InteractorTimer() = default;
  ~InteractorTimer();
  InteractorTimer(const InteractorTimer&) = delete;
  InteractorTimer& operator=(const InteractorTimer&) = delete;

  /// From the last draft to the full picture, in milliseconds.
  static constexpr unsigned long stillDelay = 300;

  /// Whether there is an event loop: interactors of other programs have no timers that run, or nobody who runs them.
  static bool IsAvailable(vtkRenderWindowInteractor* interactor);

  /// Calls once, unless it is cancelled or started anew before. The call may delete this object.
  void Start(
    vtkRenderWindowInteractor* interactor, unsigned long milliseconds, const std::function<void()>& call);
  void Cancel();
  bool IsRunning() const { return this->Timer != 0; }

private:
  void Fired(vtkObject* caller, unsigned long event, void* timer);

  vtkWeakPointer<vtkRenderWindowInteractor> Interactor;
  unsigned long Observer = 0;
  int Timer = 0; // 0: none
  std::function<void()> Call;
};

// Drafts while isovalues are swept through in ParaView's panels, whose sliders ask for a still frame at each step.
#pragma once

#include "InteractorTimer.h"

#include "vtkObject.h"
#include "vtkWeakPointer.h"

#include <vector>

class vtkPVRenderView;
class vtkPVSession;

/// Makes a still frame of values that have just changed an interactive one, and has it followed by the full picture when
/// they stay. Only in windows of ParaView's GUI, whose event loop brings the latter, and not while a picture is captured,
/// cells are selected, or others than this process draw.
class SweepDrafts : public vtkObject
{
public:
  static SweepDrafts* New();
  vtkTypeMacro(SweepDrafts, vtkObject);

  /// To be called in each REQUEST_RENDER of the view, before anything is drawn. values: what the frame shows; none: nothing
  /// that drafts are wanted of.
  void StartFrame(vtkPVRenderView* view, const std::vector<double>& values);
  /// The full picture that is due, if any, is left to others: because nothing is drawn any more, or all of it.
  void Cancel() { this->Timer.Cancel(); }

protected:
  SweepDrafts() = default;
  ~SweepDrafts() override = default;

private:
  void StartTimer(unsigned long milliseconds);
  void DrawStill();

  std::vector<double> Values; // of the last frame
  unsigned int Frames = 0;

  // Of the full picture that is due.
  vtkWeakPointer<vtkPVRenderView> View;
  vtkWeakPointer<vtkPVSession> Session; // of the view
  InteractorTimer Timer;
  bool IsInDraft = false; // before the event loop runs again
};

// Who follows a frame that takes long, by VTK's events, and may end it. Private to the module.
#pragma once

#include "Progress.h"

class vtkAlgorithm;
class vtkRenderer;

namespace treeamr
{

/// What such an observer asks for in vain.
inline constexpr const char* nestedFrames = "Render() by an observer of another frame's progress";

/// Of one call of a mapper's Render(), on its thread. While the frame is computed its render window checks for aborts
/// (vtkRenderWindow::CheckAbortStatus(), of which VTK lets through five a second), and the mapper tells its progress,
/// twenty times a second; short frames have no such events. Observers find OpenGL as it was and may leave it otherwise,
/// but cannot draw anything with these mappers. Hardware selection has no events.
class FrameWatch
{
public:
  /// tells: whether the mapper has events; event: besides vtkCommand::ProgressEvent, 0 for none.
  FrameWatch(vtkRenderer* renderer, vtkAlgorithm* mapper, bool tells, unsigned long event = 0);

  /// Whether there is anything to draw: neither has the frame been aborted nor is this call made by an observer of it.
  bool canDraw();
  /// Whether this call is made by an observer of a frame.
  static bool isReporting();
  /// Null: none follows, and the frame pays for none.
  Progress* progress() { return !isSelection_ && (this->checks() || this->tells()) ? &progress_ : nullptr; }

private:
  bool checks() const;
  bool tells() const;
  bool isAborted() const;
  bool report(double part);

  vtkRenderer* renderer_;
  vtkAlgorithm* mapper_;
  bool tells_;
  unsigned long event_;
  bool isSelection_;
  Progress progress_;
};

} // namespace treeamr

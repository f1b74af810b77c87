// ParaView's sliders keep to themselves where the mouse drags them, until it is released: the property's unchecked value
// alone follows.
#pragma once

#include "InteractorTimer.h"

#include "vtkWeakPointer.h"

#include <functional>
#include <optional>

class vtkSMProperty;
class vtkSMViewProxy;

/// Draws drafts of values that a panel has not yet set, and the full picture when they stay.
class SliderPreview
{
public:
  SliderPreview() = default;
  ~SliderPreview();
  SliderPreview(const SliderPreview&) = delete;
  SliderPreview& operator=(const SliderPreview&) = delete;

  /// property: of one double. view() gives the one to draw, null for none; set() the value to what is drawn, and
  /// nothing else, as the property will have it when the panel sets it. Only values in the property's domain "range".
  void Connect(vtkSMProperty* property, const std::function<vtkSMViewProxy*()>& view,
    const std::function<void(double)>& set);

private:
  void UncheckedModified();
  void Schedule(unsigned long milliseconds, void (SliderPreview::*draw)());
  void DrawDraft();
  void DrawStill();

  vtkWeakPointer<vtkSMProperty> Property;
  unsigned long Observer = 0;
  InteractorTimer Timer;
  std::function<vtkSMViewProxy*()> View;
  std::function<void(double)> Set;
  std::optional<double> Drawn; // unless it is the property's
};

// What surfaces draw for hardware selection. Private to the module.
#pragma once

#include "SurfaceView.h"

class vtkHardwareSelector;
class vtkHyperTreeGrid;

namespace treeamr
{

/// Tells the selector that a prop is being drawn, for its own lifetime.
class SelectedProp
{
public:
  explicit SelectedProp(vtkHardwareSelector* selector);
  ~SelectedProp();
  SelectedProp(const SelectedProp&) = delete;
  SelectedProp& operator=(const SelectedProp&) = delete;

private:
  vtkHardwareSelector* selector_;
};

/// The nearest hits in the colours of the selector's pass: what they are of, or which cells of the grid they are in.
/// arraySize: values in the grid's cell arrays.
void fillSelection(vtkHardwareSelector* selector, vtkHyperTreeGrid* grid, vtkIdType arraySize,
  unsigned int compositeIndex, const SurfaceView& view, vtkTreeAMRSurfaceImage& image);

} // namespace treeamr

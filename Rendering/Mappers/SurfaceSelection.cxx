#include "SurfaceSelection.h"

#include "GridExchange.h"

#include "vtkHardwareSelector.h"
#include "vtkHyperTreeGrid.h"

#include <array>

namespace treeamr
{

SelectedProp::SelectedProp(vtkHardwareSelector* selector)
  : selector_(selector)
{
  selector_->BeginRenderProp();
}

SelectedProp::~SelectedProp()
{
  selector_->EndRenderProp();
}

void fillSelection(vtkHardwareSelector* selector, vtkHyperTreeGrid* grid, vtkIdType arraySize,
  unsigned int compositeIndex, const SurfaceView& view, vtkTreeAMRSurfaceImage& image)
{
  // Decides whether there is a pass of the high bits; global indices may have gaps.
  selector->UpdateMaximumCellId(largestOrigin(*grid, arraySize));
  // Black in the passes of point ids.
  std::array<float, 3> ofProp{};
  const int pass = selector->GetCurrentPass();
  switch (pass)
  {
    case vtkHardwareSelector::COMPOSITE_INDEX_PASS:
      selector->RenderCompositeIndex(compositeIndex);
      [[fallthrough]];
    case vtkHardwareSelector::ACTOR_PASS:
      selector->GetPropColorValue(ofProp.data());
      break;
    default:
      break;
  }
  const bool low = pass == vtkHardwareSelector::CELL_ID_LOW24;
  const bool high = pass == vtkHardwareSelector::CELL_ID_HIGH24;
  const bool process = pass == vtkHardwareSelector::PROCESS_PASS;
  const auto color = [&](const SurfaceHit& hit) {
    if (!low && !high && !process)
    {
      return ofProp;
    }
    const vtkIdType index = globalIndex(*grid, view.surface()->cell(hit));
    const CellOrigin origin = cellOrigin(*grid, index, selector->GetProcessID());
    std::array<float, 3> rgb;
    // 0 is for no process.
    vtkHardwareSelector::Convert(
      process ? origin.process + 1 : (low ? origin.index : origin.index >> 24), rgb.data());
    return rgb;
  };
  fillHits(view.hits(), view.camera(), color, image);
}

} // namespace treeamr

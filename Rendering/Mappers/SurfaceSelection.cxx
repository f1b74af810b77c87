#include "SurfaceSelection.h"

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
  selector->UpdateMaximumCellId(arraySize - 1);
  // Black in the passes of point ids.
  std::array<float, 3> ofProp{};
  const int pass = selector->GetCurrentPass();
  switch (pass)
  {
    case vtkHardwareSelector::COMPOSITE_INDEX_PASS:
      selector->RenderCompositeIndex(compositeIndex);
      [[fallthrough]];
    case vtkHardwareSelector::ACTOR_PASS:
    case vtkHardwareSelector::PROCESS_PASS:
      selector->GetPropColorValue(ofProp.data());
      break;
    default:
      break;
  }
  const bool low = pass == vtkHardwareSelector::CELL_ID_LOW24;
  const bool high = pass == vtkHardwareSelector::CELL_ID_HIGH24;
  const auto color = [&](const SurfaceHit& hit) {
    if (!low && !high)
    {
      return ofProp;
    }
    const vtkIdType id = globalIndex(*grid, view.surface()->cell(hit));
    std::array<float, 3> rgb;
    vtkHardwareSelector::Convert(low ? id : id >> 24, rgb.data());
    return rgb;
  };
  fillHits(view.hits(), view.camera(), color, image);
}

} // namespace treeamr

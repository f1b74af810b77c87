#include "FilteredArrays.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkDataSetAttributes.h"
#include "vtkHyperTreeGrid.h"

namespace treeamr
{

std::vector<std::string> takenArrays(vtkHyperTreeGrid& grid, vtkDataArraySelection& selection, bool final)
{
  const std::string ghosts = vtkDataSetAttributes::GhostArrayName();
  const bool all = !final && selection.GetNumberOfArrays() == 0;
  vtkCellData* cells = grid.GetCellData();
  std::vector<std::string> names;
  for (int i = 0; i < cells->GetNumberOfArrays(); ++i)
  {
    const char* name = cells->GetArray(i) ? cells->GetArrayName(i) : nullptr;
    if (name && name != ghosts && (all || selection.ArrayIsEnabled(name)))
    {
      names.emplace_back(name);
    }
  }
  for (int i = 0; i < selection.GetNumberOfArrays(); ++i)
  {
    const char* name = selection.GetArrayName(i);
    if (selection.GetArraySetting(i) && name != ghosts && !cells->HasArray(name))
    {
      names.emplace_back(name);
    }
  }
  return names;
}

} // namespace treeamr

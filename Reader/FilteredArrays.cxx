#include "FilteredArrays.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkDataSetAttributes.h"
#include "vtkHyperTreeGrid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

std::vector<std::string> takenArrays(vtkHyperTreeGrid& grid, vtkDataArraySelection& selection)
{
  const std::string ghosts = vtkDataSetAttributes::GhostArrayName();
  const bool all = selection.GetNumberOfArrays() == 0;
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

std::string roundedIntegers(vtkDataArray& array)
{
  constexpr double exact = 1 << std::numeric_limits<float>::digits;
  const int type = array.GetDataType();
  if (type == VTK_FLOAT || type == VTK_DOUBLE || array.GetDataTypeSize() < 4)
  {
    return {};
  }
  double largest = 0.;
  for (int c = 0; c < array.GetNumberOfComponents(); ++c)
  {
    const double* range = array.GetRange(c);
    largest = std::max({ largest, std::abs(range[0]), std::abs(range[1]) });
  }
  if (array.GetNumberOfTuples() == 0 || largest <= exact)
  {
    return {};
  }
  return "hyper tree grid: cell array '" + std::string(array.GetName()) + "' has whole numbers up to " +
    std::to_string(static_cast<long long>(std::min(largest, 9e18))) +
    "; single precision rounds those beyond " + std::to_string(static_cast<int>(exact));
}

} // namespace treeamr

#include "CornerArrays.h"

#include "Field/CornerValues.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleVectorKey.h"
#include "vtkInformationIntegerKey.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

namespace treeamr
{

namespace
{

constexpr std::array<const char*, cornerCount> names{ "000", "100", "010", "110", "001", "101", "011",
  "111" };

} // namespace

vtkInformationIntegerKey* cornerValuesKey()
{
  static vtkInformationIntegerKey* const key =
    vtkInformationIntegerKey::MakeKey("CORNER_VALUES", "vtkTreeAMR");
  return key;
}

void markAsCorners(vtkDataArray& array)
{
  array.SetNumberOfComponents(cornerCount);
  for (int c = 0; c < cornerCount; ++c)
  {
    array.SetComponentName(c, names[c]);
  }
  array.GetInformation()->Set(cornerValuesKey(), 1);
}

bool isAtCorners(vtkDataArray& array)
{
  if (array.GetNumberOfComponents() != cornerCount)
  {
    return false;
  }
  if (array.HasInformation() && array.GetInformation()->Get(cornerValuesKey()) == 1)
  {
    return true;
  }
  bool isNamed = true;
  for (int c = 0; c < cornerCount; ++c)
  {
    const char* name = array.GetComponentName(c);
    isNamed = isNamed && name && std::strcmp(name, names[c]) == 0;
  }
  return isNamed;
}

void setCornerRanges(vtkHyperTreeGrid& grid)
{
  vtkCellData* const cells = grid.GetCellData();
  for (int i = 0; i < cells->GetNumberOfArrays(); ++i)
  {
    vtkDataArray* const array = cells->GetArray(i); // null when it is not of numbers
    if (!array || !isAtCorners(*array) || array->GetNumberOfTuples() == 0)
    {
      continue;
    }
    std::array<double, 2> all{ std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest() };
    for (int c = 0; c < cornerCount; ++c)
    {
      std::array<double, 2> range;
      array->GetFiniteRange(range.data(), c);
      all = { std::min(all[0], range[0]), std::max(all[1], range[1]) };
    }
    array->GetInformation()->Set(vtkDataArray::L2_NORM_RANGE(), all.data(), 2);
    array->GetInformation()->Set(vtkDataArray::L2_NORM_FINITE_RANGE(), all.data(), 2);
  }
}

int fieldComponents(vtkDataArray& array)
{
  return isAtCorners(array) ? 1 : array.GetNumberOfComponents();
}

Remark unevenCorners(vtkDataArray& array, const Field& field)
{
  const std::string about =
    "hyper tree grid: the values of cell array '" + std::string(array.GetName()) + "'";
  std::ostringstream text;
  if (field.cornerJump() > 0.)
  {
    text << about << " at corners that cells share differ by up to " << field.cornerJump()
         << " from cell to cell (an element that is not continuous): the means of the cells are used instead";
    return { about + " at corners", text.str() };
  }
  const double change = field.corners() ? field.corners()->hangingChange() : 0.;
  if (change > 0.)
  {
    text
      << about << " at corners that hang on larger cells differ by up to " << change
      << " from what these have there, as those of elements of higher order do: the larger cells' are used";
    return { about + " at hanging corners", text.str() };
  }
  return {};
}

} // namespace treeamr

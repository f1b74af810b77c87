#include "CornerArrays.h"

#include "Field/CornerValues.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleVectorKey.h"
#include "vtkInformationInformationVectorKey.h"
#include "vtkInformationIntegerKey.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"

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
    vtkInformation* const info = array->GetInformation();
    info->Set(vtkDataArray::L2_NORM_RANGE(), all.data(), 2);
    info->Set(vtkDataArray::L2_NORM_FINITE_RANGE(), all.data(), 2);
    for (auto* const key : { vtkAbstractArray::PER_COMPONENT(), vtkAbstractArray::PER_FINITE_COMPONENT() })
    {
      vtkNew<vtkInformationVector> ofComponents;
      ofComponents->SetNumberOfInformationObjects(cornerCount);
      for (int c = 0; c < cornerCount; ++c)
      {
        ofComponents->GetInformationObject(c)->Set(vtkDataArray::COMPONENT_RANGE(), all.data(), 2);
      }
      info->Set(key, ofComponents);
    }
  }
}

int fieldComponents(vtkDataArray& array)
{
  return isAtCorners(array) ? 1 : array.GetNumberOfComponents();
}

void CornerRemarks::add(vtkDataArray& array, const Field& field)
{
  const auto addTo = [&](Kind& kind, double difference) {
    if (difference > 0. && std::ranges::find(kind.arrays, array.GetName()) == kind.arrays.end())
    {
      kind.arrays.emplace_back(array.GetName());
      kind.largest = std::max(kind.largest, difference);
    }
  };
  addTo(jumping_, field.cornerJump());
  addTo(hanging_, field.cornerJump() > 0. || !field.corners() ? 0. : field.corners()->hangingChange());
}

std::vector<Remark> CornerRemarks::all() const
{
  std::vector<Remark> remarks;
  const auto add = [&](const Kind& kind, const char* where, const char* what) {
    if (!kind.arrays.empty())
    {
      std::string names;
      for (const std::string& name : kind.arrays)
      {
        names += (names.empty() ? "'" : ", '") + name + "'";
      }
      const std::string about = std::string("hyper tree grid: the values of cell array") +
        (kind.arrays.size() > 1 ? "s " : " ") + names + " at corners that " + where;
      std::ostringstream text;
      text << about << " differ by up to " << kind.largest << what;
      remarks.push_back({ about, text.str() });
    }
  };
  add(jumping_, "cells share",
    " from cell to cell (an element that is not continuous): the means of the cells are used instead");
  add(hanging_, "hang on larger cells",
    " from what these have there, as those of elements of higher order do: the larger cells' are used");
  return remarks;
}

Remark unevenCorners(vtkDataArray& array, const Field& field)
{
  CornerRemarks remarks;
  remarks.add(array, field);
  const std::vector<Remark> all = remarks.all();
  return all.empty() ? Remark{} : all.front();
}

} // namespace treeamr

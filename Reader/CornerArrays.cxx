#include "CornerArrays.h"

#include "Field/CornerValues.h"

#include "vtkCellData.h"
#include "vtkCharArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationIntegerKey.h"
#include "vtkIntArray.h"
#include "vtkLongArray.h"
#include "vtkLongLongArray.h"
#include "vtkObjectFactory.h"
#include "vtkShortArray.h"
#include "vtkSignedCharArray.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnsignedIntArray.h"
#include "vtkUnsignedLongArray.h"
#include "vtkUnsignedLongLongArray.h"
#include "vtkUnsignedShortArray.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>
#include <string>

namespace treeamr
{

namespace
{

constexpr std::array<const char*, cornerCount> names{ "000", "100", "010", "110", "001", "101", "011",
  "111" };

/// The magnitude and each component have the range of all: asked of the array or, in VTK 9.3, of the data that hold it. The
/// functions with ghosts override nothing in VTK 9.1.
template <class Array>
class CornerArray : public Array
{
public:
  vtkTemplateTypeMacro(CornerArray<Array>, Array);
  static CornerArray* New() { VTK_STANDARD_NEW_BODY(CornerArray<Array>); }

protected:
  using Ghosts = const unsigned char*;

  bool ComputeScalarRange(double* ranges) override
  {
    return joined(ranges, Array::ComputeScalarRange(ranges));
  }
  bool ComputeScalarRange(double* ranges, Ghosts ghosts, unsigned char skipped)
  {
    return joined(ranges, Array::ComputeScalarRange(ranges, ghosts, skipped));
  }
  bool ComputeFiniteScalarRange(double* ranges) override
  {
    return joined(ranges, Array::ComputeFiniteScalarRange(ranges));
  }
  bool ComputeFiniteScalarRange(double* ranges, Ghosts ghosts, unsigned char skipped)
  {
    return joined(ranges, Array::ComputeFiniteScalarRange(ranges, ghosts, skipped));
  }
  bool ComputeVectorRange(double range[2]) override
  {
    Ranges all;
    return first(range, all, this->ComputeScalarRange(all.data()));
  }
  bool ComputeVectorRange(double range[2], Ghosts ghosts, unsigned char skipped)
  {
    Ranges all;
    return first(range, all, this->ComputeScalarRange(all.data(), ghosts, skipped));
  }
  bool ComputeFiniteVectorRange(double range[2]) override
  {
    Ranges all;
    return first(range, all, this->ComputeFiniteScalarRange(all.data()));
  }
  bool ComputeFiniteVectorRange(double range[2], Ghosts ghosts, unsigned char skipped)
  {
    Ranges all;
    return first(range, all, this->ComputeFiniteScalarRange(all.data(), ghosts, skipped));
  }

private:
  using Ranges = std::array<double, 2 * cornerCount>;

  static bool joined(double* ranges, bool hasAny)
  {
    for (int c = 1; c < cornerCount; ++c)
    {
      ranges[0] = std::min(ranges[0], ranges[2 * c]);
      ranges[1] = std::max(ranges[1], ranges[2 * c + 1]);
    }
    for (int c = 1; c < cornerCount; ++c)
    {
      std::copy_n(ranges, 2, ranges + 2 * c);
    }
    return hasAny;
  }
  static bool first(double range[2], const Ranges& all, bool hasAny)
  {
    std::copy_n(all.data(), 2, range);
    return hasAny;
  }
};

template <class... Arrays>
struct Types
{
};
using CornerTypes = Types<vtkFloatArray, vtkDoubleArray, vtkCharArray, vtkSignedCharArray,
  vtkUnsignedCharArray, vtkShortArray, vtkUnsignedShortArray, vtkIntArray, vtkUnsignedIntArray, vtkLongArray,
  vtkUnsignedLongArray, vtkLongLongArray, vtkUnsignedLongLongArray>;

/// With the array's own memory; null for arrays that have no such, or have that range already.
template <class... Arrays>
vtkSmartPointer<vtkDataArray> withOneRange(vtkDataArray& array, Types<Arrays...>)
{
  vtkSmartPointer<vtkDataArray> result;
  const auto tryType = [&]<class Array>(Array* typed) {
    if (typed && !dynamic_cast<CornerArray<Array>*>(typed))
    {
      result = vtkSmartPointer<CornerArray<Array>>::New();
      result->ShallowCopy(typed);
      result->CopyInformation(typed->GetInformation());
    }
    return typed != nullptr;
  };
  (tryType(vtkArrayDownCast<Arrays>(&array)) || ...);
  return result;
}

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
    if (const vtkSmartPointer<vtkDataArray> copy = withOneRange(*array, CornerTypes()))
    {
      const bool isActive = cells->GetScalars() == array;
      cells->AddArray(copy); // in its place
      if (isActive)
      {
        cells->SetActiveScalars(copy->GetName());
      }
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

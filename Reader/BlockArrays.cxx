#include "BlockArrays.h"

#include "Error.h"
#include "Prefetch.h"

#include "vtkAbstractArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkInformation.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>
#include <mutex>
#include <type_traits>
#include <utility>

namespace treeamr
{

namespace
{

vtkDataSetAttributes* attributesOf(const NamedDataSet& block, bool ofPoints)
{
  return ofPoints ? static_cast<vtkDataSetAttributes*>(block.points) : block.cells;
}

vtkAbstractArray* arrayOf(const NamedDataSet& block, const BlockArray& array)
{
  return attributesOf(block, array.ofPoints)->GetAbstractArray(array.name.c_str());
}

std::string prefixOf(const NamedDataSet& block)
{
  return block.name.empty() ? "" : block.name + ": ";
}

void copyNames(vtkAbstractArray* from, vtkAbstractArray* to)
{
  for (int c = 0; c < from->GetNumberOfComponents() && from->HasAComponentName(); ++c)
  {
    to->SetComponentName(c, from->GetComponentName(c));
  }
  if (from->HasInformation())
  {
    to->CopyInformation(from->GetInformation());
  }
}

template <class T>
using TypedArray = vtkAOSDataArrayTemplate<T>;

/// By block; arrays that do not hold their values one after the other are copied so.
template <class T>
std::vector<vtkSmartPointer<TypedArray<T>>> typedArrays(
  const std::vector<NamedDataSet>& blocks, const BlockArray& array)
{
  std::vector<vtkSmartPointer<TypedArray<T>>> arrays;
  for (const NamedDataSet& block : blocks)
  {
    vtkAbstractArray* const found = arrayOf(block, array);
    vtkSmartPointer<TypedArray<T>> typed = TypedArray<T>::FastDownCast(found);
    if (!typed)
    {
      const auto copy = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(found->GetDataType()));
      copy->DeepCopy(found);
      typed = TypedArray<T>::FastDownCast(copy);
    }
    arrays.push_back(typed);
  }
  return arrays;
}

template <class T>
class CellFiller : public BlendedFiller<T>
{
public:
  CellFiller(const std::vector<NamedDataSet>& blocks, const BlockArray& array, vtkIdType nodes)
    : BlendedFiller<T>(array.name.c_str(), arrayOf(blocks.front(), array)->GetNumberOfComponents(), nodes,
        arrayOf(blocks.front(), array)->GetDataType())
    , arrays_(typedArrays<T>(blocks, array))
  {
    copyNames(arrayOf(blocks.front(), array), this->array());
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    const CellNumber number(leaf.number);
    const T* const from = arrays_[number.block()]->GetPointer(number.cell() * this->components_);
    T* const to = this->tuple(node);
    for (int c = 0; c < this->components_; ++c) // most have one
    {
      to[c] = from[c];
    }
  }
  void prepare(std::uint64_t number) const override
  {
    const CellNumber cell(number);
    prefetch(arrays_[cell.block()]->GetPointer(cell.cell() * this->components_));
  }

private:
  std::vector<vtkSmartPointer<TypedArray<T>>> arrays_; // by block
};

/// The type that VTK gives the means of an array of T.
template <class T>
using MeanType = std::conditional_t<std::is_floating_point_v<T>, T, float>;

template <class T>
class PointMeanFiller : public BlendedFiller<MeanType<T>>
{
public:
  PointMeanFiller(const BlockArrays& arrays, const BlockArray& array, vtkIdType nodes)
    : BlendedFiller<MeanType<T>>(
        array.name.c_str(), arrayOf(arrays.blocks.front(), array)->GetNumberOfComponents(), nodes)
    , points_(arrays.points.points)
    , arrays_(typedArrays<T>(arrays.blocks, array))
  {
    copyNames(arrayOf(arrays.blocks.front(), array), this->array());
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    const CellNumber number(leaf.number);
    const T* const values = arrays_[number.block()]->GetPointer(0);
    MeanType<T>* const mean = this->tuple(node);
    const std::array<vtkIdType, 8> points = points_(number);
    for (int c = 0; c < this->components_; ++c)
    {
      double sum = 0.;
      for (const vtkIdType point : points)
      {
        sum += static_cast<double>(values[point * this->components_ + c]);
      }
      mean[c] = static_cast<MeanType<T>>(sum / 8.);
    }
  }

private:
  const CellPoints& points_;
  std::vector<vtkSmartPointer<TypedArray<T>>> arrays_; // by block
};

template <class T>
class PointCornersFiller : public CornersFiller<T>
{
public:
  PointCornersFiller(const BlockArrays& arrays, const BlockArray& array, vtkIdType nodes)
    : CornersFiller<T>(array.name.c_str(), nodes, arrayOf(arrays.blocks.front(), array)->GetDataType())
    , corners_(arrays.points.corners)
    , arrays_(typedArrays<T>(arrays.blocks, array))
  {
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    const CellNumber number(leaf.number);
    const T* const values = arrays_[number.block()]->GetPointer(0);
    const std::array<vtkIdType, 8> points = corners_(number);
    for (int c = 0; c < cornerCount; ++c)
    {
      this->tuple(node)[c] = values[points[c]];
    }
  }

private:
  const CellPoints& corners_;
  std::vector<vtkSmartPointer<TypedArray<T>>> arrays_; // by block
};

/// Whether each cell has one value at all its points, as writers leave arrays of cells that know arrays of points alone.
template <class T>
bool isOfCells(const BlockArrays& arrays, const BlockArray& array, const CellsInOrder& cells)
{
  const std::vector<vtkSmartPointer<TypedArray<T>>> typed = typedArrays<T>(arrays.blocks, array);
  return tbb::parallel_reduce(
    tbb::blocked_range<std::size_t>(0, cells.count, 4096), true,
    [&](const auto& range, bool same) {
      for (std::size_t i = range.begin(); same && i != range.end(); ++i)
      {
        const CellNumber number = cells.cell(i);
        const T* const values = typed[number.block()]->GetPointer(0);
        const std::array<vtkIdType, 8> points = arrays.points.points(number);
        same = std::ranges::all_of(points, [&](vtkIdType p) { return values[p] == values[points[0]]; });
      }
      return same;
    },
    std::logical_and<>());
}

/// Of one component of float or double.
template <class T>
std::unique_ptr<CellArrayFiller> makeCornersFiller(
  const BlockArrays& arrays, const BlockArray& array, vtkIdType nodes, const CellsInOrder& cells)
{
  if (isOfCells<T>(arrays, array, cells))
  {
    return std::make_unique<PointMeanFiller<T>>(arrays, array, nodes);
  }
  return std::make_unique<PointCornersFiller<T>>(arrays, array, nodes);
}

/// Of what no type of numbers stands for: strings, bits, variants. Rare, so one thread at a time.
class AnyFiller : public CellArrayFiller
{
public:
  AnyFiller(const std::vector<NamedDataSet>& blocks, const BlockArray& array, vtkIdType nodes)
    : array_(vtk::TakeSmartPointer(arrayOf(blocks.front(), array)->NewInstance()))
  {
    for (const NamedDataSet& block : blocks)
    {
      sources_.push_back(arrayOf(block, array));
    }
    array_->SetName(array.name.c_str());
    array_->SetNumberOfComponents(sources_.front()->GetNumberOfComponents());
    array_->SetNumberOfTuples(nodes);
    copyNames(sources_.front(), array_);
  }
  void setLeaf(vtkIdType node, const TreeLeaf& leaf) override
  {
    const std::lock_guard lock(mutex_);
    const CellNumber number(leaf.number);
    array_->SetTuple(node, number.cell(), sources_[number.block()]);
  }
  void setInner(vtkIdType node, vtkIdType firstChild, unsigned present) override
  {
    const std::lock_guard lock(mutex_);
    array_->SetTuple(node, firstChild + std::countr_zero(present), array_);
  }
  void setMissing(vtkIdType node, vtkIdType sibling) override
  {
    const std::lock_guard lock(mutex_);
    array_->SetTuple(node, sibling, array_);
  }
  vtkAbstractArray* array() const noexcept override { return array_; }

private:
  vtkSmartPointer<vtkAbstractArray> array_;
  std::vector<vtkAbstractArray*> sources_; // by block
  std::mutex mutex_;
};

/// Adds the names of the arrays that all blocks have alike.
void addArrays(bool ofPoints, BlockArrays& result)
{
  const std::vector<NamedDataSet>& blocks = result.blocks;
  const std::string kind = ofPoints ? "point" : "cell";
  for (const NamedDataSet& block : blocks)
  {
    vtkDataSetAttributes* const attributes = attributesOf(block, ofPoints);
    for (int i = 0; attributes && i < attributes->GetNumberOfArrays(); ++i)
    {
      vtkAbstractArray* const array = attributes->GetAbstractArray(i);
      const std::string name = array->GetName() ? array->GetName() : "";
      const auto isKnown = [&](const BlockArray& known) { return known.name == name; };
      const bool isWanted = !ofPoints || !result.points.isWanted || result.points.isWanted(name);
      const auto known = std::ranges::find_if(result.arrays, isKnown);
      const std::string hidden = "point array '" + name + "' has the name of a cell array";
      if (isWanted && ofPoints && known != result.arrays.end() && !known->ofPoints &&
        std::ranges::find(result.leftOut, hidden) == result.leftOut.end())
      {
        result.leftOut.push_back(hidden);
      }
      if (!isWanted || name == vtkDataSetAttributes::GhostArrayName() || known != result.arrays.end() ||
        std::ranges::any_of(result.leftOut,
          [&](const std::string& text) { return text.starts_with(kind + " array '" + name + "'"); }))
      {
        continue;
      }
      BlockArray candidate{ name, ofPoints };
      std::string objection;
      if (name.empty())
      {
        objection = "has no name";
      }
      else if (ofPoints && (!vtkDataArray::SafeDownCast(array) || array->GetDataType() == VTK_BIT))
      {
        objection = "has no mean, for it is a " + std::string(array->GetClassName());
      }
      for (const NamedDataSet& other : blocks)
      {
        vtkAbstractArray* const same = objection.empty() ? arrayOf(other, candidate) : nullptr;
        if (objection.empty() &&
          (!same || same->GetDataType() != array->GetDataType() ||
            same->GetNumberOfComponents() != array->GetNumberOfComponents()))
        {
          objection = (same ? "is of another type in " : "is not in ") + other.name;
        }
        const vtkIdType needed = ofPoints ? other.pointCount : other.cellCount;
        if (same && same->GetNumberOfTuples() < needed)
        {
          throw Error(prefixOf(other) + kind + " array '" + name + "' has " +
            std::to_string(same->GetNumberOfTuples()) + " tuples, allowed are " + std::to_string(needed) +
            ", one a " + kind);
        }
      }
      if (objection.empty())
      {
        const int type = array->GetDataType();
        candidate.atCorners = ofPoints && result.points.corners && array->GetNumberOfComponents() == 1 &&
          (type == VTK_FLOAT || type == VTK_DOUBLE);
        result.arrays.push_back(candidate);
        if (ofPoints && !candidate.atCorners)
        {
          result.averaged.push_back(name);
        }
      }
      else
      {
        result.leftOut.push_back(kind + " array '" + name + "' " + objection);
      }
    }
  }
}

} // namespace

std::string nameOfBlock(vtkCompositeDataIterator& block)
{
  std::string name = "block " + std::to_string(block.GetCurrentFlatIndex());
  if (block.HasCurrentMetaData() && block.GetCurrentMetaData()->Has(vtkCompositeDataSet::NAME()))
  {
    name += " '" + std::string(block.GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME())) + "'";
  }
  return name;
}

NamedDataSet::NamedDataSet(vtkDataSet* data, std::string name)
  : cells(data->GetCellData())
  , cellCount(data->GetNumberOfCells())
  , points(data->GetPointData())
  , pointCount(data->GetNumberOfPoints())
  , name(std::move(name))
{
}

NamedDataSet::NamedDataSet(vtkCellData* cells, vtkIdType cellCount, std::string name)
  : cells(cells)
  , cellCount(cellCount)
  , name(std::move(name))
{
}

BlockArrays arraysOf(std::vector<NamedDataSet> blocks, PointArrays points)
{
  BlockArrays result{ std::move(blocks), std::move(points), {}, {}, {} };
  addArrays(false, result);
  const auto cellArrays = result.arrays.size();
  addArrays(true, result);
  for (const bool ofPoints : { true, false }) // those of cells come before
  {
    vtkDataSetAttributes* const attributes = attributesOf(result.blocks.front(), ofPoints);
    vtkDataArray* const scalars = attributes ? attributes->GetScalars() : nullptr;
    const auto found = std::ranges::find_if(result.arrays, [&](const BlockArray& array) {
      return scalars && scalars->GetName() && array.name == scalars->GetName() && array.ofPoints == ofPoints;
    });
    if (found != result.arrays.end() && (!ofPoints || cellArrays == 0))
    {
      std::rotate(result.arrays.begin(), found, found + 1);
    }
  }
  return result;
}

std::unique_ptr<CellArrayFiller> makeFiller(
  const BlockArrays& arrays, const BlockArray& array, vtkIdType nodes, const CellsInOrder& cells)
{
  const int type = arrayOf(arrays.blocks.front(), array)->GetDataType();
  if (array.atCorners)
  {
    return type == VTK_FLOAT ? makeCornersFiller<float>(arrays, array, nodes, cells)
                             : makeCornersFiller<double>(arrays, array, nodes, cells);
  }
  switch (type)
  {
    vtkTemplateMacro(
      if (array.ofPoints) return std::make_unique<PointMeanFiller<VTK_TT>>(arrays, array, nodes);
      return std::make_unique<CellFiller<VTK_TT>>(arrays.blocks, array, nodes));
    default:
      return std::make_unique<AnyFiller>(arrays.blocks, array, nodes);
  }
}

const unsigned char* cellGhosts(const NamedDataSet& block)
{
  auto* const ghosts =
    vtkUnsignedCharArray::SafeDownCast(block.cells->GetArray(vtkDataSetAttributes::GhostArrayName()));
  if (ghosts && ghosts->GetNumberOfTuples() < block.cellCount)
  {
    throw Error(prefixOf(block) + "vtkGhostType has " + std::to_string(ghosts->GetNumberOfTuples()) +
      " tuples, allowed are " + std::to_string(block.cellCount) + ", one a cell");
  }
  return ghosts && block.cellCount > 0 ? ghosts->GetPointer(0) : nullptr;
}

} // namespace treeamr

#include "HexahedronBlocks.h"

#include "Error.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSet.h"
#include "vtkDoubleArray.h"
#include "vtkGenericCell.h"
#include "vtkInformation.h"
#include "vtkPoints.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnstructuredGrid.h"
#include "vtkVersionMacros.h"
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
#include "vtkCellTypeUtilities.h"
#else
#include "vtkCellTypes.h"
#endif

#include <sstream>
#include <utility>

namespace treeamr
{

namespace
{

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
using CellTypeNames = vtkCellTypeUtilities;

vtkDataArray* cellTypesOf(vtkUnstructuredGrid* grid)
{
  return grid->GetCellTypes();
}
#else
using CellTypeNames = vtkCellTypes;

vtkDataArray* cellTypesOf(vtkUnstructuredGrid* grid)
{
  return grid->GetCellTypesArray();
}
#endif

/// The values of an array, one after the other; where it has them otherwise, as VTK 9.6 has what is constant or increases
/// evenly, it becomes a copy.
template <class Value>
const Value* valuesOf(vtkSmartPointer<vtkDataArray>& array)
{
  using Values = vtkAOSDataArrayTemplate<Value>;
  if (!Values::FastDownCast(array))
  {
    const auto copy = vtkSmartPointer<Values>::New();
    copy->DeepCopy(array);
    array = copy;
  }
  return array->GetNumberOfValues() > 0 ? Values::FastDownCast(array)->GetPointer(0) : nullptr;
}

} // namespace

HexahedronBlock::HexahedronBlock(vtkUnstructuredGrid* grid, std::string name)
  : grid_(grid)
  , name_(std::move(name))
  , cellCount_(grid->GetNumberOfCells())
  , pointCount_(grid->GetNumberOfPoints())
{
  const std::string prefix = name_.empty() ? "" : name_ + ": ";
  typeArray_ = cellTypesOf(grid);
  if (!typeArray_ || typeArray_->GetNumberOfValues() < cellCount_)
  {
    throw Error(prefix + std::to_string(typeArray_ ? typeArray_->GetNumberOfValues() : 0) +
      " cell types, allowed are " + std::to_string(cellCount_) + ", one a cell");
  }
  types_ = valuesOf<unsigned char>(typeArray_);
  ghosts_ = cellGhosts({ grid, name_ });

  vtkCellArray* const cells = grid->GetCells();
  idCount_ = cells->GetNumberOfConnectivityIds();
  offsetArray_ = cells->GetOffsetsArray();
  idArray_ = cells->GetConnectivityArray();
  if (vtkAOSDataArrayTemplate<vtkTypeInt32>::FastDownCast(idArray_))
  {
    offsets_ = valuesOf<vtkTypeInt32>(offsetArray_);
    ids_ = valuesOf<vtkTypeInt32>(idArray_);
  }
  else
  {
    longOffsets_ = valuesOf<vtkTypeInt64>(offsetArray_);
    longIds_ = valuesOf<vtkTypeInt64>(idArray_);
  }

  if (pointCount_ > 0)
  {
    coordinates_ = grid->GetPoints()->GetData();
    if (!vtkAOSDataArrayTemplate<float>::FastDownCast(coordinates_) &&
      !vtkAOSDataArrayTemplate<double>::FastDownCast(coordinates_))
    {
      const auto copy = vtkSmartPointer<vtkDoubleArray>::New();
      copy->DeepCopy(coordinates_);
      coordinates_ = copy;
    }
    if (auto* const floats = vtkAOSDataArrayTemplate<float>::FastDownCast(coordinates_))
    {
      floats_ = floats->GetPointer(0);
    }
    else
    {
      doubles_ = vtkAOSDataArrayTemplate<double>::FastDownCast(coordinates_)->GetPointer(0);
    }
  }
}

HexahedronBlock::~HexahedronBlock() = default;
HexahedronBlock::HexahedronBlock(HexahedronBlock&&) noexcept = default;

std::string HexahedronBlock::describe(vtkIdType cell) const
{
  std::ostringstream text;
  text << (name_.empty() ? "" : name_ + ", ") << "cell " << cell;
  if (!this->isHexahedron(cell))
  {
    vtkNew<vtkGenericCell> generic;
    generic->SetCellType(types_[cell]);
    const int dimension = generic->GetCellDimension();
    const char* const typeName = CellTypeNames::GetClassNameFromTypeId(types_[cell]);
    text << ", a " << typeName << (dimension < 3 ? " of " + std::to_string(dimension) + " dimensions" : "");
  }
  if (this->isHexahedron(cell) && !this->hasCorners(cell))
  {
    text << ", a hexahedron whose points are not eight of the " << pointCount_ << " there are";
    return text.str();
  }
  AxisBox box;
  if (this->hasCorners(cell))
  {
    box = boxAround(this->corners(cell));
  }
  else
  {
    std::array<double, 6> bounds;
    grid_->GetCellBounds(cell, bounds.data());
    box = { { bounds[0], bounds[2], bounds[4] }, { bounds[1], bounds[3], bounds[5] } };
  }
  text << ", which reaches from " << textOf(box.low) << " to " << textOf(box.high);
  return text.str();
}

std::vector<HexahedronBlock> hexahedronBlocks(vtkDataObject* input)
{
  std::vector<HexahedronBlock> blocks;
  const auto add = [&](vtkDataObject* data, const std::string& name) {
    if (auto* const grid = vtkUnstructuredGrid::SafeDownCast(data))
    {
      if (grid->GetNumberOfCells() > 0)
      {
        blocks.emplace_back(grid, name);
      }
      return;
    }
    auto* const set = vtkDataSet::SafeDownCast(data);
    if (!set || set->GetNumberOfCells() > 0)
    {
      throw Error((name.empty() ? "the input" : name) + " is a " + data->GetClassName() +
        ", allowed is vtkUnstructuredGrid");
    }
  };
  auto* const composite = vtkCompositeDataSet::SafeDownCast(input);
  if (!composite)
  {
    add(input, {});
    return blocks;
  }
  const auto leaves = vtk::TakeSmartPointer(composite->NewIterator());
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
  {
    add(leaves->GetCurrentDataObject(), nameOfBlock(*leaves));
  }
  return blocks;
}

BlockArrays arraysOf(
  const std::vector<HexahedronBlock>& blocks, std::function<bool(const std::string&)> isWanted)
{
  std::vector<NamedDataSet> sets;
  for (const HexahedronBlock& block : blocks)
  {
    sets.push_back({ block.grid(), block.name() });
  }
  const auto points = [&blocks](const CellNumber& number) {
    std::array<vtkIdType, 8> ids;
    for (int corner = 0; corner < 8; ++corner)
    {
      ids[corner] = blocks[number.block()].point(number.cell(), corner);
    }
    return ids;
  };
  // Hexahedra begin at any of their corners.
  const auto corners = [&blocks, points](const CellNumber& number) {
    const std::array<vtkIdType, 8> ids = points(number);
    const CornerCoordinates at = blocks[number.block()].corners(number.cell());
    const AxisBox box = boxAround(at);
    std::array<vtkIdType, 8> byCorner{};
    for (int i = 0; i < 8; ++i)
    {
      int corner = 0;
      for (int a = 0; a < 3; ++a)
      {
        corner |= (at[a][i] - box.low[a] > box.width(a) / 2. ? 1 : 0) << a;
      }
      byCorner[corner] = ids[i];
    }
    return byCorner;
  };
  return arraysOf(std::move(sets), PointArrays{ points, corners, std::move(isWanted) });
}

} // namespace treeamr

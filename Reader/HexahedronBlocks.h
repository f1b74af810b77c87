// The hexahedra and voxels of unstructured grids, by their corners' coordinates and points, to be read by several threads.
// Private to the module.
#pragma once

#include "BlockArrays.h"
#include "CellNumber.h"
#include "Forest/BoxLattice.h"

#include "vtkCellType.h"
#include "vtkDataSetAttributes.h"
#include "vtkSmartPointer.h"
#include "vtkType.h"
#include "vtkUnstructuredGrid.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

class vtkDataArray;
class vtkDataObject;

namespace treeamr
{

class HexahedronBlock
{
public:
  /// name: for messages, empty when there is no other. Throws Error for a grid that is not whole.
  HexahedronBlock(vtkUnstructuredGrid* grid, std::string name);
  ~HexahedronBlock();
  HexahedronBlock(HexahedronBlock&&) noexcept;

  vtkUnstructuredGrid* grid() const noexcept { return grid_; }
  const std::string& name() const noexcept { return name_; }
  vtkIdType cellCount() const noexcept { return cellCount_; }
  bool hasFloats() const noexcept { return floats_ != nullptr; }

  /// Copies of other processes' cells, and what VTK does not show.
  bool isLeftOut(vtkIdType cell) const noexcept;
  /// Whether the cell is a hexahedron or voxel of eight points there are.
  bool hasCorners(vtkIdType cell) const noexcept;
  /// Of a cell that has corners.
  vtkIdType point(vtkIdType cell, int corner) const noexcept
  {
    return longIds_ ? static_cast<vtkIdType>(longIds_[longOffsets_[cell] + corner])
                    : static_cast<vtkIdType>(ids_[offsets_[cell] + corner]);
  }
  CornerCoordinates corners(vtkIdType cell) const noexcept;

  /// What kind of cell it is and what is wrong with it as a hexahedron, or where it lies. Of one thread.
  std::string describe(vtkIdType cell) const;

private:
  bool isHexahedron(vtkIdType cell) const noexcept
  {
    return types_[cell] == VTK_VOXEL || types_[cell] == VTK_HEXAHEDRON;
  }

  vtkSmartPointer<vtkUnstructuredGrid> grid_;
  std::string name_;
  vtkSmartPointer<vtkDataArray> coordinates_; // of float or double, one after the other
  vtkSmartPointer<vtkDataArray> typeArray_;
  vtkSmartPointer<vtkDataArray> offsetArray_;
  vtkSmartPointer<vtkDataArray> idArray_;
  vtkIdType cellCount_ = 0;
  vtkIdType pointCount_ = 0;
  vtkIdType idCount_ = 0;
  const float* floats_ = nullptr;
  const double* doubles_ = nullptr;
  const unsigned char* types_ = nullptr;
  const unsigned char* ghosts_ = nullptr;
  // Of one or the other width.
  const vtkTypeInt64* longOffsets_ = nullptr;
  const vtkTypeInt64* longIds_ = nullptr;
  const vtkTypeInt32* offsets_ = nullptr;
  const vtkTypeInt32* ids_ = nullptr;
};

inline bool HexahedronBlock::isLeftOut(vtkIdType cell) const noexcept
{
  constexpr unsigned char flags = vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::REFINEDCELL |
    vtkDataSetAttributes::HIDDENCELL;
  return ghosts_ && (ghosts_[cell] & flags) != 0;
}

inline bool HexahedronBlock::hasCorners(vtkIdType cell) const noexcept
{
  if (!this->isHexahedron(cell))
  {
    return false;
  }
  const vtkIdType begin = longIds_ ? vtkIdType(longOffsets_[cell]) : ids_ ? vtkIdType(offsets_[cell]) : 0;
  const vtkIdType end = longIds_ ? vtkIdType(longOffsets_[cell + 1])
    : ids_                       ? vtkIdType(offsets_[cell + 1])
                                 : 0;
  if (end - begin != 8 || begin < 0 || end > idCount_)
  {
    return false;
  }
  for (int corner = 0; corner < 8; ++corner)
  {
    const vtkIdType p = this->point(cell, corner);
    if (p < 0 || p >= pointCount_)
    {
      return false;
    }
  }
  return true;
}

inline CornerCoordinates HexahedronBlock::corners(vtkIdType cell) const noexcept
{
  CornerCoordinates corners;
  for (int corner = 0; corner < 8; ++corner)
  {
    const vtkIdType at = 3 * this->point(cell, corner);
    for (int a = 0; a < 3; ++a)
    {
      corners[a][corner] = floats_ ? double(floats_[at + a]) : doubles_[at + a];
    }
  }
  return corners;
}

/// Those of a vtkUnstructuredGrid or of all in a composite data set that have cells. Throws Error for data of other kinds.
std::vector<HexahedronBlock> hexahedronBlocks(vtkDataObject* input);

/// blocks must outlive them, and have cells. isWanted: of arrays of points, by name.
BlockArrays arraysOf(
  const std::vector<HexahedronBlock>& blocks, std::function<bool(const std::string&)> isWanted);

} // namespace treeamr

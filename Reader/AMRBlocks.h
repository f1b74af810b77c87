// The blocks of block-structured AMR, by where their cells lie and which of them count. Private to the module.
#pragma once

#include "BlockArrays.h"
#include "Forest/BoxLattice.h"

#include "vtkImageData.h"
#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <array>
#include <string>
#include <vector>

class vtkOverlappingAMR;

namespace treeamr
{

class AMRBlock
{
public:
  /// name: for messages. Throws Error for a block of fewer than three dimensions, of axes that are turned, of widths that
  /// are none, and of arrays that are not whole.
  AMRBlock(vtkImageData* data, int level, std::string name);
  ~AMRBlock();
  AMRBlock(AMRBlock&&) noexcept;

  vtkImageData* data() const noexcept { return data_; }
  int level() const noexcept { return level_; }
  const std::string& name() const noexcept { return name_; }
  /// Cells along the axes.
  const std::array<vtkIdType, 3>& size() const noexcept { return size_; }
  vtkIdType cellCount() const noexcept { return size_[0] * size_[1] * size_[2]; }
  const std::array<double, 3>& width() const noexcept { return width_; }

  using CellIndex = std::array<vtkIdType, 3>;
  vtkIdType cell(const CellIndex& index) const noexcept
  {
    return index[0] + size_[0] * (index[1] + size_[1] * index[2]);
  }
  AxisBox boxOf(const CellIndex& index) const noexcept;
  std::array<vtkIdType, 8> points(vtkIdType cell) const noexcept;

  /// Copies of other blocks' cells, and what VTK does not show.
  bool isLeftOut(vtkIdType cell) const noexcept;
  /// Whether a finer block has the cell, as the block itself says.
  bool isRefined(vtkIdType cell) const noexcept;

  /// The cells from `low` on, below `high`, without layers of copies around them; empty when all are copies.
  struct Range
  {
    CellIndex low;
    CellIndex high;
  };
  Range ownCells() const;

private:
  vtkSmartPointer<vtkImageData> data_;
  int level_;
  std::string name_;
  std::array<vtkIdType, 3> size_{};
  std::array<double, 3> low_{};
  std::array<double, 3> width_{}; // of a cell
  const unsigned char* ghosts_ = nullptr;
  const unsigned char* pointGhosts_ = nullptr;
};

/// Those that have cells, from the coarsest level on, in the order of the input. Throws Error for cells that are not
/// 2, 4, 8 ... times smaller than those of the level before along all axes, or not alike on a level.
std::vector<AMRBlock> blocksOf(vtkOverlappingAMR* input);

/// blocks must outlive them; one or more.
BlockArrays arraysOf(const std::vector<AMRBlock>& blocks);

} // namespace treeamr

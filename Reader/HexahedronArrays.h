// The arrays of hexahedra as cell arrays of a grid that is made of them (ParallelGridBuilder.h). Private to the module.
#pragma once

#include "CellArrayFillers.h"
#include "HexahedronBlocks.h"

#include <memory>
#include <string>
#include <vector>

namespace treeamr
{

/// An array that all blocks have.
struct HexahedronArray
{
  std::string name;
  bool ofPoints; // else of cells
};

struct HexahedronArrays
{
  std::vector<HexahedronArray> arrays; // the active scalars first
  std::vector<std::string> averaged;   // names of those of points
  std::vector<std::string> leftOut;    // what is wrong with others
};

/// Cell arrays by name, and those of points that no cell array has the name of. Without vtkGhostType, which says what cells
/// are left out. Throws Error for an array of fewer tuples than cells or points.
HexahedronArrays arraysOf(const std::vector<HexahedronBlock>& blocks);

/// A cell has its own value, or the mean of its points' as vtkPointDataToCellData makes it, of integers in float. blocks must outlive the filler,
/// which gets a leaf's CellNumber as its number and may be called from several threads.
std::unique_ptr<CellArrayFiller> makeFiller(
  const std::vector<HexahedronBlock>& blocks, const HexahedronArray& array, vtkIdType nodes);

} // namespace treeamr

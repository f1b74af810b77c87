// The arrays of data sets, whose cells become those of one grid (ParallelGridBuilder.h), as its cell arrays. Private to
// the module.
#pragma once

#include "CellArrayFillers.h"
#include "CellNumber.h"

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

class vtkCellData;
class vtkCompositeDataIterator;
class vtkDataSet;
class vtkPointData;

namespace treeamr
{

/// The arrays of one. name: for messages, empty when there is no other.
struct NamedDataSet
{
  NamedDataSet(vtkDataSet* data, std::string name);
  /// Of data without points.
  NamedDataSet(vtkCellData* cells, vtkIdType cellCount, std::string name);

  vtkCellData* cells;
  vtkIdType cellCount;
  vtkPointData* points = nullptr;
  vtkIdType pointCount = 0;
  std::string name;
};

/// By its number, and its name where it has one.
std::string nameOfBlock(vtkCompositeDataIterator& block);

/// The points of a cell, called from several threads.
using CellPoints = std::function<std::array<vtkIdType, 8>(const CellNumber&)>;

/// An array that all blocks have.
struct BlockArray
{
  std::string name;
  bool ofPoints;          // else of cells
  bool atCorners = false; // of those of points: its values become those at the cells' corners, not their mean
};

/// What becomes of arrays of points.
struct PointArrays
{
  CellPoints points;
  CellPoints corners = {}; // the same by corner, as in Octant.h; none: all have means
  std::function<bool(const std::string&)> isWanted = {}; // by name; none: all are
};

struct BlockArrays
{
  std::vector<NamedDataSet> blocks;
  PointArrays points;
  std::vector<BlockArray> arrays;    // the active scalars first
  std::vector<std::string> averaged; // names of those of points that have means
  std::vector<std::string> leftOut;  // what is wrong with others
};

/// Cell arrays by name, and those of points that no cell array has the name of. Without vtkGhostType, which says what cells
/// are left out. blocks: one or more. Throws Error for an array of fewer tuples than cells or points.
BlockArrays arraysOf(std::vector<NamedDataSet> blocks, PointArrays points);

/// The cells by their number of order.
struct CellsInOrder
{
  std::size_t count;
  std::function<CellNumber(std::size_t)> cell; // called from several threads
};

/// A cell has its own value, or the mean of its points' as vtkPointDataToCellData makes it, of integers in float; or, of one
/// component of float or double, its points' values at its corners (CornerArrays.h), unless each cell has one value at all of
/// them: that is its own. arrays must outlive the filler, which gets a leaf's CellNumber as its number and may be called from
/// several threads.
std::unique_ptr<CellArrayFiller> makeFiller(
  const BlockArrays& arrays, const BlockArray& array, vtkIdType nodes, const CellsInOrder& cells);

/// What vtkGhostType says of a block's cells, null when there is none. Throws Error for one of fewer tuples than cells.
const unsigned char* cellGhosts(const NamedDataSet& block);

} // namespace treeamr

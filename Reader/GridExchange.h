// Grids of any source in parallel: whatever cells each process has, afterwards it has those of a box of its own, and those
// beyond that the field there depends on (GridPartition.h).
#pragma once

#include "vtkTreeAMRReaderModule.h" // for the export macro

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <string>
#include <vector>

class vtkHyperTreeGrid;
class vtkMultiProcessController;

namespace treeamr
{

struct ExchangeOptions
{
  /// Names of the cell arrays to take; none: all.
  std::vector<std::string> arrays{};
  /// Adds a cell array that tells where each cell came from, for cellOrigin().
  bool keepsOrigins = false;
  /// Whether field data may be added to the grid itself where that comes back: else a copy does, for which VTK walks all of a
  /// masked grid.
  bool mayChange = false;
};

struct ExchangedGrid
{
  vtkSmartPointer<vtkHyperTreeGrid> grid;
  std::vector<std::string> leftOut; // what is wrong with arrays of this process
};

/// Every process of the controller calls it with the grid that it has: null, or without trees, where it has none. Returns that
/// grid itself where all are partitioned for these processes already, or there is one process or no tree at all.
///
/// Cells marked as ghosts, hidden and masked ones are left out. Of cells that several processes count the first one's is
/// taken; grids with the same content are one. Arrays are those that all grids have alike, of numbers. Coordinates increase
/// in what is made, also where grids are mirrored; the depth limit is the deepest. Field data stay those of the process.
///
/// Throws on all processes the Error of the first where there is one: a grid that acquireField() does not take, other roots
/// than on another process, cells of different levels that overlap, not enough memory.
VTKTREEAMRREADER_EXPORT ExchangedGrid exchangeGrid(
  vtkHyperTreeGrid* local, vtkMultiProcessController* controller, const ExchangeOptions& options = {});

struct CellOrigin
{
  int process;
  vtkIdType index;
};
/// The process that had a cell and its place in the cell arrays there, of a grid with origins; else `own` and `index`.
VTKTREEAMRREADER_EXPORT CellOrigin cellOrigin(vtkHyperTreeGrid& grid, vtkIdType index, int own);
/// The largest index of an origin. size: of the cell arrays.
VTKTREEAMRREADER_EXPORT vtkIdType largestOrigin(vtkHyperTreeGrid& grid, vtkIdType size);

} // namespace treeamr

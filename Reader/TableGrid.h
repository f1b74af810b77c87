// A vtkHyperTreeGrid of tables with a row for each cell. Private to the module.
#pragma once

#include "BlockArrays.h"

#include "vtkCellData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <string>
#include <vector>

class vtkDataArray;
class vtkHyperTreeGrid;
class vtkTable;

namespace treeamr
{

/// A table's columns: those that say where cells are, and the others.
struct TableBlock
{
  /// names: of the columns of levels and of indices along x, y, z. Throws Error for a column that is missing, has several
  /// components or no numbers.
  TableBlock(vtkTable* table, const std::array<std::string, 4>& names, std::string name);

  std::array<vtkDataArray*, 4> places;
  vtkSmartPointer<vtkCellData> others; // the levels where there are no other columns
  vtkIdType rows;
  std::vector<std::string> leftOut; // what is wrong with columns
  std::string name;                 // for messages, empty when there is no other
};

struct TableLattice
{
  std::array<double, 3> origin;
  std::array<double, 3> spacing; // of the roots
  std::array<int, 3> roots;      // 0: as many as cells need
};

/// blocks: one or more. grid: an empty one. Throws Error for a row that is no cell on the lattice, naming it, and for cells
/// that overlap.
void makeGrid(const std::vector<TableBlock>& blocks, const TableLattice& lattice, const BlockArrays& arrays,
  vtkHyperTreeGrid* grid);

} // namespace treeamr

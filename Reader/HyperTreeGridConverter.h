// From vtkHyperTreeGrid to the core's octree and fields, each made once for all copies of a grid.
//
// Drawn are the leaves of the trees, or the vertices at the grid's depth limit with the volume-weighted mean
// of the leaves below. Left out are cells that are masked or hidden (HIDDENCELL in vtkGhostType), and cells
// whose value is not finite or beyond the range of float. Leaves marked DUPLICATECELL become ghosts, but for grids with a
// box (GridPartition.h). Values
// are computed in double and stored as float, those of doubles and integers, where it takes that to keep their digits,
// less an offset (Field/FieldOffset.h). It comes from the range of the values that are drawn, whatever is left out. Arrays
// of values at corners (CornerArrays.h) become fields of these.
#pragma once

#include "vtkTreeAMRReaderModule.h" // for the export macro

#include "Error.h"
#include "Field/Field.h"

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <memory>
#include <string>

class vtkDataArray;
class vtkHyperTreeGrid;

namespace treeamr
{

/// A cell array by name. component < 0: the magnitude; of a scalar array the value itself.
struct ArraySelection
{
  std::string name;   // of a cell array
  int component = -1; // from 0 on
};

/// All cells are masked or hidden, as of a filter that keeps none: there is nothing to draw, and nothing wrong.
class VTKTREEAMRREADER_EXPORT NoCells : public Error
{
public:
  using Error::Error;
};

/// No cell has a value of an array that a float can hold.
class VTKTREEAMRREADER_EXPORT NoFiniteValue : public Error
{
public:
  /// message: names the array.
  NoFiniteValue(const std::string& message, bool isNaN)
    : Error(message)
    , isNaN(isNaN)
  {
  }
  /// Whether all values are NaN, not some infinite or too large.
  bool isNaN;
};

/// The field of an array and its octree, from a process-wide cache that keeps nothing alive by itself: copies
/// of a grid (VTK copies at every step of a pipeline) share one octree, whatever the array, unless an array's
/// non-finite values cut different cells. Each call reads topology and
/// values once to recognise them (a few ms per million cells): keep the result while the MTime of grid and arrays
/// stays. Safe from several threads while none changes the grid.
///
/// Throws Error when the grid is null, has no tree or no drawable cell (NoCells), is not three-dimensional, has a
/// branch factor other than 2 or material interfaces, when its coordinates along an axis are not finite or
/// neither strictly increase nor strictly decrease (a mirrored grid), when it is too deep for RootGrid, and when
/// the array does not exist, is not numeric, is too short, has no such component or has doubles all below the
/// normal numbers of float, 1.2e-38. NoFiniteValue, an Error, when no cell has a finite value or all are beyond float.
VTKTREEAMRREADER_EXPORT std::shared_ptr<const Field> acquireField(
  vtkHyperTreeGrid* grid, const ArraySelection& selection);

/// An array whose values are names rather than quantities (VTK's indexed look-up).
struct Categories
{
  /// Each leaf's place in `values`; at the grid's depth limit of the value with the largest volume below.
  Field numbers;
  /// Those of the cells, each once, ascending, of the array's type; magnitudes are double, bits unsigned char.
  vtkSmartPointer<vtkDataArray> values;
};

/// As acquireField(), and in the same cache. Values are read as double: whole numbers beyond 2^53 may become one. Throws
/// Error also for more different values than TransferFunction::mostCategories.
VTKTREEAMRREADER_EXPORT std::shared_ptr<const Categories> acquireCategories(
  vtkHyperTreeGrid* grid, const ArraySelection& selection);

/// The octree of all cells that are not masked or hidden, whatever their values, from the same cache. Throws Error as
/// acquireField() for the grid.
VTKTREEAMRREADER_EXPORT std::shared_ptr<const Octree> acquireOctree(vtkHyperTreeGrid* grid);

/// A cell array of numbers. Throws Error when there is no such array, naming those there are, or it is not numeric.
VTKTREEAMRREADER_EXPORT vtkDataArray& numericCellArray(vtkHyperTreeGrid& grid, const std::string& name);

/// The place in the cell arrays of the values of a cell, leaf or coarse, of a grid that acquireField() takes. Throws
/// Error when the grid has no such cell. Safe from several threads while none changes the grid.
VTKTREEAMRREADER_EXPORT vtkIdType globalIndex(vtkHyperTreeGrid& grid, const CellId& cell);

/// Bounds (xmin, xmax, ymin, ...) of the trees that this process holds; uninitialised (1, -1, ...) when there
/// is none or the grid is not one that acquireField() takes; of a grid with a box (GridPartition.h) what lies in it.
/// vtkHyperTreeGrid::GetBounds() gives the whole lattice up to VTK 9.2; 9.3 knows no bounds of mirrored grids.
VTKTREEAMRREADER_EXPORT void computeLocalBounds(vtkHyperTreeGrid* grid, double bounds[6]);

} // namespace treeamr

// What the two mappers share on their input side: which array is meant, and its field kept between frames.
// Private to the module.
#pragma once

#include "HyperTreeGridConverter.h"
#include "LostDigits.h"

#include "Geometry/RayStops.h"
#include "Surface/Isosurface.h"

#include "vtkType.h"

#include <array>
#include <exception>
#include <memory>
#include <string>
#include <vector>

class vtkAbstractMapper;
class vtkAlgorithm;
class vtkHyperTreeGrid;
class vtkProp3D;

namespace treeamr
{

/// Changes with the trees' mask, coordinates and cell arrays: vtkHyperTreeGrid::GetMTime() leaves these out.
vtkMTimeType gridModificationTime(vtkHyperTreeGrid* grid);

/// Of a mapper's first port; null: there is none.
vtkHyperTreeGrid* inputGrid(vtkAlgorithm* mapper);
/// Gives a mapper the input connection of another, or none.
void shareInput(vtkAlgorithm* mapper, vtkAlgorithm* other);

/// The name of a grid's cell array. Throws Error listing the arrays there are.
std::string cellArrayName(vtkHyperTreeGrid* grid, int arrayId);
/// The active scalars, else the first array; empty when the grid has no array.
std::string defaultCellArrayName(vtkHyperTreeGrid* grid);
/// Of the array that an algorithm is to process, or else that one.
std::string processedArrayName(vtkAlgorithm* algorithm, vtkHyperTreeGrid* grid);

/// The array that ScalarMode, ArrayAccessMode, ArrayId and ArrayName of a VTK mapper mean. `fallback` is
/// meant by modes that name no array. Throws Error for a name of no array of numbers and for modes of point
/// or field data, which hyper tree grids have not.
std::string selectedCellArrayName(vtkHyperTreeGrid* grid, int scalarMode, int accessMode, int arrayId,
  const char* arrayName, const std::string& fallback);

/// Whether two selections mean the same values: a scalar array has one component and is its own magnitude.
bool isSameArray(vtkHyperTreeGrid* grid, const ArraySelection& a, const ArraySelection& b);

/// What one array is converted to, made again only when grid or selection change. A failure is kept, too:
/// reading an unfit array again at every frame would take as long as reading a fit one. Made: Field or
/// Categories.
template <class Made>
class InputSlot
{
public:
  /// Throws Error as acquireField() and acquireCategories().
  const std::shared_ptr<const Made>& acquire(vtkHyperTreeGrid* grid, const ArraySelection& selection);
  /// What users should know of what acquire() gave last; nothing of categories.
  const Remark& remark() const noexcept { return remark_; }
  /// For when it is not needed any more.
  void release() { *this = InputSlot(); }

private:
  // Not dereferenced; a new grid at an old address has another modification time.
  vtkHyperTreeGrid* grid_ = nullptr;
  vtkMTimeType time_ = 0;
  ArraySelection selection_;
  std::shared_ptr<const Made> made_;
  std::exception_ptr failure_;
  Remark remark_;
};

using FieldSlot = InputSlot<Field>;
using CategorySlot = InputSlot<Categories>;

/// The surfaces of a field, shared by all who ask for the same. Throws Error as Isosurface.
std::shared_ptr<const Isosurface> acquireIsosurface(const std::shared_ptr<const Field>& field,
  const std::vector<double>& isovalues, int mostCellDepth = Isosurface::allCellDepths);

/// Local bounds, computed again only when the grid changes.
class BoundsSlot
{
public:
  /// Uninitialised bounds for no grid and no tree; the whole lattice's for a grid that cannot be drawn.
  void get(vtkHyperTreeGrid* grid, double bounds[6]);

private:
  vtkHyperTreeGrid* grid_ = nullptr;
  vtkMTimeType time_ = 0;
  std::array<double, 6> bounds_{ 1., -1., 1., -1., 1., -1. };
};

/// Where a mapper draws: within its clipping planes, and in parallel in the box of its grid (GridPartition.h).
DataCut cutOf(vtkAbstractMapper* mapper, vtkProp3D* prop);

/// What to tell the user of whatever ended a frame.
const char* describe(const std::exception& error);

} // namespace treeamr

#include "MapperInput.h"

#include "CornerArrays.h"
#include "Error.h"
#include "GridPartition.h"
#include "MachineShare.h"
#include "SceneConversion.h"

#include "vtkAbstractMapper.h"
#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkExecutive.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkMath.h"

#include <algorithm>
#include <mutex>
#include <new>
#include <type_traits>

namespace treeamr
{

namespace
{

std::string listOfArrays(vtkHyperTreeGrid* grid)
{
  std::string list;
  vtkCellData* cells = grid->GetCellData();
  for (int i = 0; i < cells->GetNumberOfArrays(); ++i)
  {
    const char* name = cells->GetArrayName(i);
    list += (i > 0 ? ", '" : "'") + std::string(name ? name : "") + "'";
  }
  return list.empty() ? "none" : list;
}

} // namespace

vtkMTimeType gridModificationTime(vtkHyperTreeGrid* grid)
{
  vtkMTimeType time = std::max(grid->GetMTime(), grid->GetCellData()->GetMTime());
  for (vtkObject* part :
    { static_cast<vtkObject*>(grid->GetMask()), static_cast<vtkObject*>(grid->GetXCoordinates()),
      static_cast<vtkObject*>(grid->GetYCoordinates()), static_cast<vtkObject*>(grid->GetZCoordinates()) })
  {
    time = part ? std::max(time, part->GetMTime()) : time;
  }
  return time;
}

vtkHyperTreeGrid* inputGrid(vtkAlgorithm* mapper)
{
  return mapper->GetNumberOfInputConnections(0) < 1
    ? nullptr
    : vtkHyperTreeGrid::SafeDownCast(mapper->GetExecutive()->GetInputData(0, 0));
}

void shareInput(vtkAlgorithm* mapper, vtkAlgorithm* other)
{
  mapper->SetInputConnection(
    other->GetNumberOfInputConnections(0) > 0 ? other->GetInputConnection(0, 0) : nullptr);
}

std::string cellArrayName(vtkHyperTreeGrid* grid, int arrayId)
{
  vtkCellData* cells = grid->GetCellData();
  const char* name =
    arrayId >= 0 && arrayId < cells->GetNumberOfArrays() ? cells->GetArrayName(arrayId) : nullptr;
  if (!name)
  {
    throw Error("hyper tree grid: no cell array has the number " + std::to_string(arrayId) + ", there are " +
      listOfArrays(grid));
  }
  return name;
}

std::string defaultCellArrayName(vtkHyperTreeGrid* grid)
{
  vtkCellData* cells = grid->GetCellData();
  vtkDataArray* scalars = cells->GetScalars();
  if (scalars && scalars->GetName())
  {
    return scalars->GetName();
  }
  for (int i = 0; i < cells->GetNumberOfArrays(); ++i)
  {
    // Null for strings and the like; ghost marks are no data.
    vtkDataArray* array = cells->GetArray(i);
    if (array && array->GetName() && std::string(array->GetName()) != vtkDataSetAttributes::GhostArrayName())
    {
      return array->GetName();
    }
  }
  return {};
}

std::string processedArrayName(vtkAlgorithm* algorithm, vtkHyperTreeGrid* grid)
{
  const char* name = algorithm->GetInputArrayInformation(0)->Get(vtkDataObject::FIELD_NAME());
  return name && *name ? name : defaultCellArrayName(grid);
}

std::string selectedCellArrayName(vtkHyperTreeGrid* grid, int scalarMode, int accessMode, int arrayId,
  const char* arrayName, const std::string& fallback)
{
  switch (scalarMode)
  {
    case VTK_SCALAR_MODE_DEFAULT:
    case VTK_SCALAR_MODE_USE_CELL_DATA:
      return fallback;
    case VTK_SCALAR_MODE_USE_CELL_FIELD_DATA:
    {
      std::string name = arrayName ? arrayName : "";
      if (accessMode == VTK_GET_ARRAY_BY_ID)
      {
        name = cellArrayName(grid, arrayId);
      }
      numericCellArray(*grid, name);
      return name;
    }
    default:
      throw Error("hyper tree grid: scalar mode " + std::to_string(scalarMode) +
        " asks for point or field data, allowed are the default, cell data and cell field data");
  }
}

bool isSameArray(vtkHyperTreeGrid* grid, const ArraySelection& a, const ArraySelection& b)
{
  if (a.name != b.name)
  {
    return false;
  }
  vtkDataArray* array = grid->GetCellData()->GetArray(a.name.c_str());
  return (array && fieldComponents(*array) == 1) || std::max(a.component, -1) == std::max(b.component, -1);
}

template <class Made>
const std::shared_ptr<const Made>& InputSlot<Made>::acquire(
  vtkHyperTreeGrid* grid, const ArraySelection& selection)
{
  const vtkMTimeType time = grid ? gridModificationTime(grid) : 0;
  const bool known = grid_ == grid && time_ == time && selection_.name == selection.name &&
    selection_.component == selection.component;
  if (known && failure_)
  {
    std::rethrow_exception(failure_);
  }
  if (!known || !made_)
  {
    grid_ = grid;
    time_ = time;
    selection_ = selection;
    failure_ = nullptr;
    remark_ = {};
    try
    {
      // The old one lives until the new one is there: they may share an octree.
      if constexpr (std::is_same_v<Made, Categories>)
      {
        made_ = acquireCategories(grid, selection);
      }
      else
      {
        made_ = acquireField(grid, selection);
        vtkDataArray& array = numericCellArray(*grid, selection.name);
        const Remark corners = unevenCorners(array, *made_);
        remark_ = corners.text.empty() ? unsuitableRange(array, *made_) : corners;
      }
    }
    catch (const Error&)
    {
      made_.reset();
      failure_ = std::current_exception();
      throw;
    }
    catch (...)
    {
      made_.reset(); // the old one is not what was asked for; another time there may be memory
      throw;
    }
  }
  return made_;
}

template class InputSlot<Field>;
template class InputSlot<Categories>;

std::shared_ptr<const Isosurface> acquireIsosurface(
  const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues, int mostCellDepth)
{
  struct Known
  {
    const Field* field; // lives as long as the surface
    std::vector<double> isovalues;
    int mostCellDepth;
    std::weak_ptr<const Isosurface> surface;
  };
  static std::vector<Known> all;
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  std::erase_if(all, [](const Known& known) { return known.surface.expired(); });
  for (const Known& known : all)
  {
    if (known.field == field.get() && known.isovalues == isovalues && known.mostCellDepth == mostCellDepth)
    {
      if (std::shared_ptr<const Isosurface> surface = known.surface.lock())
      {
        return surface;
      }
    }
  }
  auto surface = std::make_shared<const Isosurface>(
    field, isovalues, shareOfMachine(Isosurface::defaultKeptBytes), mostCellDepth);
  all.push_back({ field.get(), isovalues, mostCellDepth, surface });
  return surface;
}

void BoundsSlot::get(vtkHyperTreeGrid* grid, double bounds[6])
{
  const vtkMTimeType time = grid ? gridModificationTime(grid) : 0;
  if (grid != grid_ || time != time_)
  {
    computeLocalBounds(grid, bounds_.data());
    // A prop without bounds is not asked to draw, and could not say what is wrong with its grid.
    if (grid && !vtkMath::AreBoundsInitialized(bounds_.data()) && grid->GetNumberOfNonEmptyTrees() > 0)
    {
      grid->GetBounds(bounds_.data());
    }
    grid_ = grid;
    time_ = time;
  }
  std::copy(bounds_.begin(), bounds_.end(), bounds);
}

DataCut cutOf(vtkAbstractMapper* mapper, vtkProp3D* prop)
{
  DataCut cut{ convertClippingPlanes(mapper, prop), {} };
  if (vtkHyperTreeGrid* grid = inputGrid(mapper))
  {
    const std::vector<HalfSpace> faces = partitionFaces(*grid);
    cut.halfSpaces.insert(cut.halfSpaces.end(), faces.begin(), faces.end());
  }
  return cut;
}

const char* describe(const std::exception& error)
{
  return dynamic_cast<const std::bad_alloc*>(&error) ? "not enough memory" : error.what();
}

} // namespace treeamr

// The arrays that a volume mapper draws, and their fields.
#include "vtkTreeAMRVolumeMapper.h"

#include "SceneConversion.h"
#include "TransferFunctionConversion.h"
#include "VolumeEffects.h"
#include "VolumeMapperInternals.h"

#include "CornerArrays.h"
#include "Error.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkTimerLog.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace
{

/// Throws Error where one of two arrays has values in cells where the other one has none.
void checkSameCells(const treeamr::ArraySelection& a, const treeamr::Field& ofA,
  const treeamr::ArraySelection& b, const treeamr::Field& ofB)
{
  if (ofA.sharedOctree() == ofB.sharedOctree())
  {
    return;
  }
  const auto described = [](const treeamr::ArraySelection& array, const treeamr::Field& values) {
    return "'" + array.name +
      (array.component < 0 ? "'" : "', component " + std::to_string(array.component) + ",") + " in " +
      std::to_string(values.octree().leafCount());
  };
  throw treeamr::Error("volume mapper: finite values of cell array " + described(a, ofA) + " cells, of " +
    described(b, ofB) + "; colour by one and opacity by the other need both in the same cells");
}

} // anonymous namespace

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper::Components vtkTreeAMRVolumeMapper::GetComponents(vtkVolume* volume)
{
  const bool areIndependent = volume->GetProperty()->GetIndependentComponents();
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  if (!grid || !this->OpacityArrayName.empty() || (areIndependent && this->VectorMode != DISABLED))
  {
    return Components::One;
  }
  try
  {
    vtkDataArray* array = grid->GetCellData()->GetArray(this->SelectArray().name.c_str());
    const int count = array ? treeamr::fieldComponents(*array) : 1;
    if (areIndependent)
    {
      return count >= 2 && count <= 4 ? Components::Independent : Components::One;
    }
    return count == 2 ? Components::Pair : count == 4 ? Components::RGBA : Components::One;
  }
  catch (const treeamr::Error&) // which the frame tells
  {
    return Components::One;
  }
}

//------------------------------------------------------------------------------
int vtkTreeAMRVolumeMapper::GetComponentOfUnitDistance() const
{
  const Internals& internals = *this->Private;
  if (internals.Drawn == Components::RGBA)
  {
    return 3;
  }
  return internals.Drawn == Components::Pair && internals.OpacityField ? 1 : 0;
}

//------------------------------------------------------------------------------
std::optional<treeamr::ArraySelection> vtkTreeAMRVolumeMapper::SelectOpacity(vtkVolume* volume)
{
  if (!this->CanMix(volume))
  {
    return std::nullopt;
  }
  if (!this->OpacityArrayName.empty())
  {
    return this->SelectComponent("OpacityComponent", this->OpacityArrayName, this->OpacityComponent);
  }
  if (this->GetComponents(volume) == Components::Pair)
  {
    return treeamr::ArraySelection{ this->SelectArray().name, 1 };
  }
  return std::nullopt;
}

//------------------------------------------------------------------------------
treeamr::ArraySelection vtkTreeAMRVolumeMapper::SelectComponent(
  const std::string& setting, const std::string& name, int component)
{
  // As VTK and ParaView's list of components have it, one beyond the last is the magnitude.
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  vtkDataArray* array = grid ? grid->GetCellData()->GetArray(name.c_str()) : nullptr;
  const int count = array ? array->GetNumberOfComponents() : 0;
  if (array && (component < -1 || component > count))
  {
    this->Private->Messages.warning({ setting,
      setting + " " + std::to_string(component) + " of '" + name + "', allowed are 0 to " +
        std::to_string(count - 1) + ", and -1 or " + std::to_string(count) +
        " for the magnitude, which is taken" });
  }
  return { name, array && component >= count ? -1 : component };
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::CanMix(vtkVolume* volume)
{
  return this->ShowsVolume() && !treeamr::blendsValues(this) &&
    !treeamr::hasCategories(volume->GetProperty());
}

//------------------------------------------------------------------------------
treeamr::ArraySelection vtkTreeAMRVolumeMapper::SelectArray()
{
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  if (!grid)
  {
    throw treeamr::Error("volume mapper: no input, needed is a vtkHyperTreeGrid");
  }
  treeamr::ArraySelection selection;
  selection.name = treeamr::selectedCellArrayName(grid, this->ScalarMode, this->ArrayAccessMode,
    this->ArrayId, this->ArrayName, treeamr::defaultCellArrayName(grid));
  selection.component = this->VectorMode == COMPONENT ? this->VectorComponent : -1;
  return selection;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateField(vtkVolume* volume)
{
  treeamr::ArraySelection selection = this->SelectArray();
  Internals& internals = *this->Private;
  const Components components = this->GetComponents(volume);
  if (components != Components::One)
  {
    selection.component = components == Components::RGBA ? 3 : 0;
  }
  const double start = vtkTimerLog::GetUniversalTime();
  std::shared_ptr<const treeamr::Field> field;
  if (this->ShowsVolume() && treeamr::hasCategories(volume->GetProperty()))
  {
    internals.Categories = internals.CategorySlot.acquire(this->GetHyperTreeGrid(), selection);
    field = { internals.Categories, &internals.Categories->numbers };
  }
  else
  {
    field = internals.FieldSlot.acquire(this->GetHyperTreeGrid(), selection);
    internals.CategorySlot.release();
    internals.Categories.reset();
  }
  std::shared_ptr<const treeamr::Field> opacityField;
  if (const std::optional<treeamr::ArraySelection> ofOpacity = this->SelectOpacity(volume))
  {
    opacityField = internals.OpacitySlot.acquire(this->GetHyperTreeGrid(), *ofOpacity);
    internals.Messages.warning(internals.OpacitySlot.remark());
    checkSameCells(selection, *field, *ofOpacity, *opacityField);
  }
  else
  {
    internals.OpacitySlot.release();
  }
  const bool readsTable = this->ReadsTable(volume);
  const auto tableField = this->AcquireTableField(readsTable, selection, *field);
  const auto others =
    this->AcquireComponents(this->CanMix(volume) ? components : Components::One, selection, *field);
  (opacityField ? opacityField : field)->nodeRanges(); // made now, they do not count as a frame's time
  internals.Messages.warning(internals.FieldSlot.remark());
  if (field != internals.Field || opacityField != internals.OpacityField ||
    others != internals.OtherComponents || components != internals.Drawn ||
    readsTable != internals.ReadsTable || tableField != internals.TableField)
  {
    internals.FieldSeconds = vtkTimerLog::GetUniversalTime() - start;
    internals.Field = field;
    internals.OpacityField = opacityField;
    internals.OtherComponents = others;
    internals.Drawn = components;
    internals.ReadsTable = readsTable;
    internals.TableField = tableField;
    internals.Volume.reset();
    internals.SamplesPerCell.clear();
    internals.FieldTime.Modified();
  }
}

//------------------------------------------------------------------------------
std::vector<std::shared_ptr<const treeamr::Field>> vtkTreeAMRVolumeMapper::AcquireComponents(
  Components components, const treeamr::ArraySelection& own, const treeamr::Field& field)
{
  Internals& internals = *this->Private;
  std::vector<std::shared_ptr<const treeamr::Field>> fields;
  const int first = components == Components::Independent ? 1 : 0;
  int end = first;
  if (components == Components::RGBA)
  {
    end = 3;
  }
  else if (components == Components::Independent)
  {
    end = treeamr::fieldComponents(*this->GetHyperTreeGrid()->GetCellData()->GetArray(own.name.c_str()));
  }
  for (int i = 0; i < static_cast<int>(internals.ComponentSlots.size()); ++i)
  {
    treeamr::FieldSlot& slot = internals.ComponentSlots[i];
    const treeamr::ArraySelection selection{ own.name, first + i };
    if (selection.component >= end)
    {
      slot.release();
      continue;
    }
    fields.push_back(slot.acquire(this->GetHyperTreeGrid(), selection));
    checkSameCells(own, field, selection, *fields.back());
  }
  return fields;
}

//------------------------------------------------------------------------------
std::shared_ptr<const treeamr::Field> vtkTreeAMRVolumeMapper::AcquireTableField(
  bool readsTable, const treeamr::ArraySelection& own, const treeamr::Field& field)
{
  treeamr::FieldSlot& slot = this->Private->TableSlot;
  if (!readsTable || this->Transfer2DYAxisArray.empty())
  {
    slot.release();
    return nullptr;
  }
  const treeamr::ArraySelection selection = this->SelectComponent(
    "Transfer2DYAxisComponent", this->Transfer2DYAxisArray, this->Transfer2DYAxisComponent);
  std::shared_ptr<const treeamr::Field> second = slot.acquire(this->GetHyperTreeGrid(), selection);
  this->Private->Messages.warning(slot.remark());
  checkSameCells(own, field, selection, *second);
  return second;
}

// What the functions of a property make of a volume mapper's fields.
#include "vtkTreeAMRVolumeMapper.h"

#include "MachineShare.h"
#include "TransferFunction2DConversion.h"
#include "TransferFunctionConversion.h"
#include "VolumeEffects.h"
#include "VolumeMapperInternals.h"

#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <array>
#include <cstddef>
#include <exception>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateVolume(vtkVolume* volume)
{
  Internals& internals = *this->Private;
  vtkVolumeProperty* property = this->ShowsVolume() ? volume->GetProperty() : nullptr;
  const int size = this->ShowsVolume() ? this->VertexCacheSize : 0;
  const std::size_t bytes = treeamr::shareOfMachine(static_cast<std::size_t>(size) << 20);
  if (!internals.Volume || internals.Property != property ||
    internals.PropertyTime != (property ? property->GetMTime() : 0) ||
    (internals.ReadsTable && internals.TableRange != this->GetTableRange()))
  {
    internals.Property = nullptr; // until it is converted
    internals.PropertyTime = 0;
    internals.SampleDistances.clear();
    internals.TransferFunctionSeconds = 0.;
    const treeamr::Stopwatch stopwatch(internals.TransferFunctionSeconds);
    internals.ReadsTable ? this->SetTable(property, bytes) : this->SetFunctions(property, bytes);
    internals.Property = property;
    // Asking for functions that were never set has made them.
    internals.PropertyTime = property ? property->GetMTime() : 0;
    internals.TransferFunctionTime.Modified();
  }
  internals.Volume->setKeptBytes(bytes);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetFunctions(vtkVolumeProperty* property, std::size_t keptBytes)
{
  Internals& internals = *this->Private;
  const std::shared_ptr<const treeamr::Field>& field =
    internals.OpacityField ? internals.OpacityField : internals.Field;
  treeamr::TransferFunction function = !property ? treeamr::TransferFunction(0., 1., { {}, {} })
    : internals.Categories ? treeamr::convertCategories(property, internals.Categories->values)
                           : treeamr::convertTransferFunction(property, field->range(), field->offset(),
                               { 0, this->GetComponentOfUnitDistance() });
  if (internals.Volume)
  {
    internals.Volume->setTransferFunction(std::move(function));
  }
  else
  {
    internals.Volume.emplace(field, std::move(function), keptBytes);
  }
  if (property)
  {
    this->MixComponents(property);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetTable(vtkVolumeProperty* property, std::size_t keptBytes)
{
  Internals& internals = *this->Private;
  const treeamr::TransferRange2D range = this->GetTableRange();
  const treeamr::TransferFunction2D table = treeamr::convertTransferFunction2D(property, range);
  if (!internals.Volume)
  {
    internals.Volume.emplace(internals.Field, table.mostOverFirst(), keptBytes);
  }
  internals.Volume->setTable(internals.TableField, table);
  internals.TableRange = range;
}

//------------------------------------------------------------------------------
std::array<double, 4> vtkTreeAMRVolumeMapper::GetTableRange() const
{
  const Internals& internals = *this->Private;
  const double offsets[2] = { internals.Field->offset(),
    internals.TableField ? internals.TableField->offset() : 0. };
  treeamr::TransferRange2D range;
  const treeamr::TransferRange2D ofData =
    internals.AgreedRange ? *internals.AgreedRange : this->GetTableRangeOfData();
  for (int i = 0; i < 4; ++i)
  {
    const int axis = i / 2;
    const bool isAsked = this->Transfer2DRange[2 * axis] <= this->Transfer2DRange[2 * axis + 1];
    range[i] = (isAsked ? this->Transfer2DRange[i] : ofData[i]) - offsets[axis];
  }
  return range;
}

//------------------------------------------------------------------------------
std::array<double, 4> vtkTreeAMRVolumeMapper::GetTableRangeOfData() const
{
  const treeamr::Field& first = *this->Private->Field;
  const treeamr::Field* const second = this->Private->TableField.get();
  const double low = first.offset() + first.range().min;
  const double high = first.offset() + first.range().max;
  if (second)
  {
    return { low, high, second->offset() + second->range().min, second->offset() + second->range().max };
  }
  return { low, high, 0., treeamr::longestGradient(high - low, treeamr::finestWidth(first)) };
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::AgreeOnTransfer2DRange(
  vtkVolume* volume, const std::function<void(std::array<double, 3>&)>& largest)
{
  Internals& internals = *this->Private;
  internals.AgreedRange.reset();
  vtkVolumeProperty* property = volume->GetProperty();
  if (property->GetTransferFunctionMode() != vtkVolumeProperty::TF_2D || !property->GetTransferFunction2D())
  {
    return; // on all
  }
  constexpr double none = -std::numeric_limits<double>::infinity();
  std::array<double, 3> first{ none, none,
    none }; // the least value's negative, the largest, and the finest width's negative
  std::array<double, 3> second{ none, none, none };
  try
  {
    this->UpdateField(volume);
    if (internals.ReadsTable)
    {
      const std::array<double, 4> own = this->GetTableRangeOfData();
      first = { -own[0], own[1], -treeamr::finestWidth(*internals.Field) };
      second = { -own[2], own[3], internals.TableField ? 1. : none };
    }
  }
  catch (const std::exception&) // which the frame tells
  {
  }
  largest(first);
  largest(second);
  if (first[1] == none)
  {
    return; // there are no cells
  }
  const bool isOfGradients = second[2] == none;
  const double longest = treeamr::longestGradient(first[0] + first[1], -first[2]);
  internals.AgreedRange = { -first[0], first[1], -second[0], isOfGradients ? longest : second[1] };
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::ReadsTable(vtkVolume* volume)
{
  vtkVolumeProperty* property = volume->GetProperty();
  return property->GetTransferFunctionMode() == vtkVolumeProperty::TF_2D &&
    property->GetTransferFunction2D() && this->OpacityArrayName.empty() && this->CanMix(volume) &&
    this->GetComponents(volume) == Components::One;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::MixComponents(vtkVolumeProperty* property)
{
  Internals& internals = *this->Private;
  const auto functionOf = [property](const treeamr::Field& field, int component) {
    return treeamr::convertTransferFunction(
      property, field.range(), field.offset(), { component, component });
  };
  const auto& others = internals.OtherComponents;
  if (internals.OpacityField)
  {
    internals.Volume->setColors(internals.Field, functionOf(*internals.Field, 0));
  }
  else if (internals.Drawn == Components::RGBA && !others.empty())
  {
    internals.Volume->setChannels({ others[0], others[1], others[2] });
  }
  else if (internals.Drawn == Components::Independent && !others.empty())
  {
    std::vector<treeamr::Volume::Component> components;
    for (const auto& field : others)
    {
      const int component = static_cast<int>(components.size()) + 1;
      components.push_back({ field, functionOf(*field, component),
        static_cast<float>(property->GetComponentWeight(component)) });
    }
    internals.Volume->setComponents(
      std::move(components), static_cast<float>(property->GetComponentWeight(0)));
  }
}

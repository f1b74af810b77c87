#include "SurfaceColoring.h"

#include "Error.h"

#include <cstddef>
#include <limits>
#include <vector>

namespace treeamr
{

namespace
{

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// Null, with a warning of values beyond float, for an array that is NaN everywhere.
template <class Made>
std::shared_ptr<const Made> acquire(
  InputSlot<Made>& slot, vtkHyperTreeGrid* grid, const ArraySelection& selection, MapperMessages& messages)
{
  try
  {
    const std::shared_ptr<const Made>& made = slot.acquire(grid, selection);
    messages.warning(slot.remark());
    return made;
  }
  catch (const NoFiniteValue& error)
  {
    if (!error.isNaN)
    {
      messages.warning({ error.what(), error.what() });
    }
    return nullptr;
  }
}

} // namespace

HitColors SurfaceColoring::map(vtkMapper* mapper, MapperMessages& messages, SurfaceActorView& view,
  vtkHyperTreeGrid* grid, const ArraySelection& contoured)
{
  const ColorSource source = selectColors(mapper, grid);
  if (!source.array)
  {
    return {};
  }
  const std::size_t count = source.components.size();
  const bool isContoured = count == 1 && isSameArray(grid, source.components[0], contoured);
  if (hasCategories(mapper, source))
  {
    return this->mapCells(mapper, messages, view, grid, source, isContoured);
  }
  categories_.release();
  if (isContoured)
  {
    return mapIsovalues(mapper, source, view.surface.surface()->isovalues());
  }
  std::vector<std::shared_ptr<const Field>> fields;
  for (std::size_t c = 0; c < count; ++c)
  {
    fields.push_back(acquire(fields_[c], grid, source.components[c], messages));
  }
  if (view.colorFields != fields)
  {
    view.colorFields.clear();
    view.colorValues.assign(count * view.surface.hits().hits.size(), unknown);
    for (std::size_t c = 0; c < count; ++c)
    {
      if (fields[c])
      {
        valuesAtHits(fields[c], view.surface.camera(), view.surface.hits(), count, &view.colorValues[c]);
      }
    }
    view.colorFields = fields;
  }
  std::vector<double> offsets;
  for (const auto& field : fields)
  {
    offsets.push_back(field ? field->offset() : 0.);
  }
  return mapValues(mapper, source, view.colorValues, offsets);
}

HitColors SurfaceColoring::mapCells(vtkMapper* mapper, MapperMessages& messages, SurfaceActorView& view,
  vtkHyperTreeGrid* grid, const ColorSource& source, bool isContoured)
{
  const std::shared_ptr<const Categories> categories =
    acquire(categories_, grid, source.components[0], messages);
  fields_ = {};
  const auto& hits = view.surface.hits().hits;
  if (!categories)
  {
    view.colorFields.clear();
    view.colorValues.assign(hits.size(), unknown);
    return mapValues(mapper, source, view.colorValues, { 0. });
  }
  const std::vector<std::shared_ptr<const Field>> numbers{ { categories, &categories->numbers } };
  if (view.colorFields != numbers)
  {
    view.colorValues = categoriesAtHits(*categories, *view.surface.surface(), hits);
    view.colorFields = numbers;
  }
  return mapCategories(mapper, *categories, view.colorValues, hits,
    isContoured ? &view.surface.surface()->isovalues() : nullptr);
}

} // namespace treeamr

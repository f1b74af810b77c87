#include "SurfaceColors.h"

#include "MapperInput.h"

#include "Octree/Forest.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMapper.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkScalarsToColors.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

constexpr std::size_t hitsPerTask = 4096;

vtkSmartPointer<vtkUnsignedCharArray> mapScalars(vtkMapper* mapper, vtkDataArray* scalars)
{
  vtkScalarsToColors* table = mapper->GetLookupTable();
  if (!mapper->GetUseLookupTableScalarRange())
  {
    table->SetRange(mapper->GetScalarRange());
  }
  table->Build();
  return vtkSmartPointer<vtkUnsignedCharArray>::Take(
    table->MapScalars(scalars, VTK_COLOR_MODE_MAP_SCALARS, 0, VTK_RGBA));
}

vtkSmartPointer<vtkUnsignedCharArray> mapScalars(vtkMapper* mapper, const std::vector<double>& values)
{
  vtkNew<vtkDoubleArray> scalars;
  for (const double value : values)
  {
    scalars->InsertNextValue(value);
  }
  return mapScalars(mapper, scalars);
}

/// The leaf at a cell's place, or what is there instead.
NodeRef nodeAt(const Octree& octree, const CellId& cell)
{
  NodeRef node = octree.root();
  for (int up = octree.grid().paddingDepth() + cell.level - 1; up >= 0 && node.isInner(); --up)
  {
    node = octree.child(node, detail::octantAbove(cell.index, up));
  }
  return node;
}

} // namespace

ArraySelection selectColors(vtkMapper* mapper, vtkHyperTreeGrid* grid)
{
  ArraySelection selection;
  if (!mapper->GetScalarVisibility())
  {
    return selection;
  }
  vtkDataArray* active = grid->GetCellData()->GetScalars();
  selection.name = selectedCellArrayName(grid, mapper->GetScalarMode(), mapper->GetArrayAccessMode(),
    mapper->GetArrayId(), mapper->GetArrayName(), active && active->GetName() ? active->GetName() : "");
  vtkDataArray* array =
    selection.name.empty() ? nullptr : grid->GetCellData()->GetArray(selection.name.c_str());
  if (!array)
  {
    return {};
  }
  vtkScalarsToColors* table = mapper->GetLookupTable();
  if (mapper->GetArrayComponent() >= 0)
  {
    selection.component = mapper->GetArrayComponent();
  }
  else if (table->GetVectorMode() == vtkScalarsToColors::COMPONENT)
  {
    selection.component = table->GetVectorComponent();
  }
  // As vtkMapper does for components that the array has not.
  if (selection.component >= array->GetNumberOfComponents())
  {
    selection.component = 0;
  }
  return selection;
}

HitColors mapIsovalues(vtkMapper* mapper, const std::vector<double>& isovalues)
{
  return { mapScalars(mapper, isovalues), HitColors::Per::Surface };
}

HitColors mapValues(vtkMapper* mapper, std::vector<float>& values)
{
  vtkNew<vtkFloatArray> scalars;
  constexpr int staysOurs = 1;
  scalars->SetArray(values.data(), static_cast<vtkIdType>(values.size()), staysOurs);
  return { mapScalars(mapper, scalars), HitColors::Per::Hit };
}

bool hasCategories(vtkMapper* mapper)
{
  return mapper->GetLookupTable()->GetIndexedLookup() != 0;
}

std::vector<float> categoriesAtHits(
  const Categories& categories, const Isosurface& surface, std::span<const SurfaceHit> hits)
{
  std::vector<float> numbers(hits.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, hits.size(), hitsPerTask), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
    {
      const NodeRef node = nodeAt(categories.numbers.octree(), surface.cell(hits[i]));
      numbers[i] = node.isLeaf() ? categories.numbers.value(node) : std::numeric_limits<float>::quiet_NaN();
    }
  });
  return numbers;
}

HitColors mapCategories(vtkMapper* mapper, const Categories& categories, const std::vector<float>& numbers,
  std::span<const SurfaceHit> hits, const std::vector<double>* isovalues)
{
  const auto ofCategories = mapScalars(mapper, categories.values);
  const auto ofNothing = mapScalars(mapper, { vtkMath::Nan() });
  const auto ofIsovalues = isovalues ? mapScalars(mapper, *isovalues) : nullptr;
  std::vector<bool> isListed; // of the isovalues
  for (vtkIdType i = 0; ofIsovalues && i < ofIsovalues->GetNumberOfTuples(); ++i)
  {
    isListed.push_back(mapper->GetLookupTable()->GetAnnotatedValueIndex((*isovalues)[i]) >= 0);
  }
  vtkNew<vtkUnsignedCharArray> rgba;
  rgba->SetNumberOfComponents(4);
  rgba->SetNumberOfTuples(static_cast<vtkIdType>(hits.size()));
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    const std::uint32_t surface = hits[i].surface;
    const unsigned char* const color = ofIsovalues && isListed[surface] ? ofIsovalues->GetPointer(4 * surface)
      : std::isnan(numbers[i])                                          ? ofNothing->GetPointer(0)
                               : ofCategories->GetPointer(4 * static_cast<vtkIdType>(numbers[i]));
    std::copy_n(color, 4, rgba->GetPointer(4 * static_cast<vtkIdType>(i)));
  }
  return { rgba, HitColors::Per::Hit };
}

} // namespace treeamr

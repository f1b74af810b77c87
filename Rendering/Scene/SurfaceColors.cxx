#include "SurfaceColors.h"

#include "MapperInput.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkLookupTable.h"
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

vtkSmartPointer<vtkUnsignedCharArray> mapScalars(
  vtkMapper* mapper, vtkDataArray* scalars, int colorMode = VTK_COLOR_MODE_MAP_SCALARS)
{
  vtkScalarsToColors* table = mapper->GetLookupTable();
  if (!mapper->GetUseLookupTableScalarRange())
  {
    table->SetRange(mapper->GetScalarRange());
  }
  table->Build();
  // One value is no component of a vector any more; several are a vector or a colour, whole.
  const int component = scalars->GetNumberOfComponents() == 1 ? 0 : -1;
  return vtkSmartPointer<vtkUnsignedCharArray>::Take(
    table->MapScalars(scalars, colorMode, component, VTK_RGBA));
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

/// Values of the source's own type: colours of integers count from 0 to 255, of floating point numbers from 0
/// to 1.
template <class Value>
vtkSmartPointer<vtkUnsignedCharArray> mapColors(
  vtkMapper* mapper, const ColorSource& source, const std::vector<Value>& values)
{
  auto colors = vtkSmartPointer<vtkDataArray>::Take(source.array->NewInstance());
  const auto components = static_cast<int>(source.components.size());
  colors->SetNumberOfComponents(components);
  colors->SetNumberOfTuples(static_cast<vtkIdType>(values.size()) / components);
  const int type = source.array->GetDataType();
  const bool isReal = type == VTK_FLOAT || type == VTK_DOUBLE;
  const double least = source.array->GetDataTypeMin();
  const double greatest = source.array->GetDataTypeMax();
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    double value = std::isnan(values[i]) ? 0. : values[i]; // there is no cell: black
    if (!isReal)
    {
      value = std::clamp(std::round(value), least, greatest);
    }
    colors->SetComponent(static_cast<vtkIdType>(i) / components, static_cast<int>(i) % components, value);
  }
  return mapScalars(mapper, colors, VTK_COLOR_MODE_DIRECT_SCALARS);
}

/// Values of hits: of each its components. Array: of these.
template <class Array, class Value>
HitColors mapTuples(vtkMapper* mapper, const ColorSource& source, std::vector<Value>& values)
{
  if (source.direct)
  {
    return { mapColors(mapper, source, values), HitColors::Per::Hit };
  }
  vtkNew<Array> scalars;
  scalars->SetNumberOfComponents(static_cast<int>(source.components.size()));
  constexpr int staysOurs = 1;
  scalars->SetArray(values.data(), static_cast<vtkIdType>(values.size()), staysOurs);
  return { mapScalars(mapper, scalars), HitColors::Per::Hit };
}

bool mayBeColor(vtkDataArray* array)
{
  return array->GetNumberOfComponents() <= 4; // luminance and colour, each with an opacity or without
}

/// Whether the values are colours themselves.
bool isDirect(vtkMapper* mapper, vtkDataArray* array)
{
  const int mode = mapper->GetColorMode();
  return mayBeColor(array) &&
    (mode == VTK_COLOR_MODE_DIRECT_SCALARS ||
      (mode == VTK_COLOR_MODE_DEFAULT && array->GetDataType() == VTK_UNSIGNED_CHAR));
}

/// Whether the table makes colours of whole tuples.
bool isMappedColor(vtkMapper* mapper, vtkDataArray* array)
{
  return mayBeColor(array) && array->GetNumberOfComponents() > 1 && mapper->GetArrayComponent() < 0 &&
    mapper->GetLookupTable()->GetVectorMode() == vtkScalarsToColors::RGBCOLORS;
}

/// The leaf at a cell's place, or what is there instead.
NodeRef nodeAt(const Octree& octree, const CellId& cell)
{
  NodeRef node = octree.root();
  for (int up = octree.grid().paddingDepth() + cell.level - 1; up >= 0 && node.isInner(); --up)
  {
    node = octree.child(node, octantAbove(cell.index, up));
  }
  return node;
}

} // namespace

ColorSource selectColors(vtkMapper* mapper, vtkHyperTreeGrid* grid)
{
  ColorSource source;
  if (!mapper->GetScalarVisibility())
  {
    return source;
  }
  vtkDataArray* active = grid->GetCellData()->GetScalars();
  const std::string name = selectedCellArrayName(grid, mapper->GetScalarMode(), mapper->GetArrayAccessMode(),
    mapper->GetArrayId(), mapper->GetArrayName(), active && active->GetName() ? active->GetName() : "");
  source.array = name.empty() ? nullptr : grid->GetCellData()->GetArray(name.c_str());
  if (!source.array)
  {
    return source;
  }
  if (vtkLookupTable* own = source.array->GetLookupTable())
  {
    mapper->SetLookupTable(own);
  }
  vtkScalarsToColors* table = mapper->GetLookupTable();
  const int components = source.array->GetNumberOfComponents();
  source.direct = isDirect(mapper, source.array);
  if (source.direct || isMappedColor(mapper, source.array))
  {
    for (int c = 0; c < components; ++c)
    {
      source.components.push_back({ name, c });
    }
    return source;
  }
  int component = -1;
  if (mapper->GetArrayComponent() >= 0)
  {
    component = mapper->GetArrayComponent();
  }
  else if (table->GetVectorMode() == vtkScalarsToColors::COMPONENT)
  {
    component = table->GetVectorComponent();
  }
  // As vtkMapper does for components that the array has not.
  source.components.push_back({ name, component < components ? component : 0 });
  return source;
}

bool isTranslucent(vtkMapper* mapper, vtkDataArray* array)
{
  vtkScalarsToColors* table = mapper->GetLookupTable();
  table->Build();
  if (!table->IsOpaque(array, mapper->GetColorMode(), mapper->GetArrayComponent()))
  {
    return true;
  }
  const bool hasColors = array && (isDirect(mapper, array) || isMappedColor(mapper, array));
  return !hasColors && mapScalars(mapper, { vtkMath::Nan() })->GetValue(3) < 255;
}

HitColors mapIsovalues(vtkMapper* mapper, const ColorSource& source, const std::vector<double>& isovalues)
{
  return { source.direct ? mapColors(mapper, source, isovalues) : mapScalars(mapper, isovalues),
    HitColors::Per::Surface };
}

HitColors mapValues(vtkMapper* mapper, const ColorSource& source, std::vector<float>& values,
  const std::vector<double>& offsets)
{
  if (std::any_of(offsets.begin(), offsets.end(), [](double offset) { return offset != 0.; }))
  {
    std::vector<double> whole(values.begin(), values.end());
    for (std::size_t i = 0; i < whole.size(); ++i)
    {
      whole[i] += offsets[i % offsets.size()];
    }
    return mapTuples<vtkDoubleArray>(mapper, source, whole);
  }
  return mapTuples<vtkFloatArray>(mapper, source, values);
}

bool hasCategories(vtkMapper* mapper, const ColorSource& source)
{
  return !source.direct && mapper->GetLookupTable()->GetIndexedLookup() != 0;
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

#include "SurfaceColors.h"

#include "MapperInput.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMapper.h"
#include "vtkNew.h"
#include "vtkScalarsToColors.h"

namespace treeamr
{

namespace
{

HitColors mapScalars(vtkMapper* mapper, vtkDataArray* scalars, HitColors::Per per)
{
  vtkScalarsToColors* table = mapper->GetLookupTable();
  if (!mapper->GetUseLookupTableScalarRange())
  {
    table->SetRange(mapper->GetScalarRange());
  }
  table->Build();
  return { vtkSmartPointer<vtkUnsignedCharArray>::Take(
             table->MapScalars(scalars, VTK_COLOR_MODE_MAP_SCALARS, 0, VTK_RGBA)),
    per };
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
  vtkNew<vtkDoubleArray> scalars;
  for (const double isovalue : isovalues)
  {
    scalars->InsertNextValue(isovalue);
  }
  return mapScalars(mapper, scalars, HitColors::Per::Surface);
}

HitColors mapValues(vtkMapper* mapper, std::vector<float>& values)
{
  vtkNew<vtkFloatArray> scalars;
  constexpr int staysOurs = 1;
  scalars->SetArray(values.data(), static_cast<vtkIdType>(values.size()), staysOurs);
  return mapScalars(mapper, scalars, HitColors::Per::Hit);
}

} // namespace treeamr

#include "vtkTreeAMRIsosurfaceMapper.h"

#include "IsosurfaceMapperInternals.h"
#include "LinePick.h"
#include "SurfaceColors.h"

#include "Error.h"

#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"

#include <algorithm>
#include <exception>

vtkStandardNewMacro(vtkTreeAMRIsosurfaceMapper);

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceMapper::vtkTreeAMRIsosurfaceMapper()
  : Private(std::make_unique<Internals>(this))
{
}

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceMapper::~vtkTreeAMRIsosurfaceMapper() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetAmbientOcclusionSamples(int value)
{
  treeamr::setWithin(this, "AmbientOcclusionSamples", this->AmbientOcclusionSamples, value, 0, 65535);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetAmbientOcclusionRadius(double value)
{
  treeamr::setWithin(this, "AmbientOcclusionRadius", this->AmbientOcclusionRadius, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetImageSampleDistance(double value)
{
  treeamr::setWithin(this, "ImageSampleDistance", this->ImageSampleDistance, value, 1., 100.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetMinimumImageSampleDistance(double value)
{
  treeamr::setWithin(this, "MinimumImageSampleDistance", this->MinimumImageSampleDistance, value, 1., 100.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetMaximumImageSampleDistance(double value)
{
  treeamr::setWithin(this, "MaximumImageSampleDistance", this->MaximumImageSampleDistance, value, 1., 100.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetInteractiveRenderTime(double value)
{
  treeamr::setWithin(this, "InteractiveRenderTime", this->InteractiveRenderTime, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetLevelOfDetail(double value)
{
  treeamr::setWithin(this, "LevelOfDetail", this->LevelOfDetail, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  this->ContourValues->PrintSelf(os, indent);
  os << indent << "IsosurfaceComponent: " << this->IsosurfaceComponent << endl;
  os << indent << "CompositeIndex: " << this->CompositeIndex << endl;
  os << indent << "AmbientOcclusionSamples: " << this->AmbientOcclusionSamples << endl;
  os << indent << "AmbientOcclusionRadius: " << this->AmbientOcclusionRadius << endl;
  os << indent << "Shadows: " << this->Shadows << endl;
  os << indent << "AutoAdjustSampleDistances: " << this->AutoAdjustSampleDistances << endl;
  os << indent << "ImageSampleDistance: " << this->ImageSampleDistance << endl;
  os << indent << "MinimumImageSampleDistance: " << this->MinimumImageSampleDistance << endl;
  os << indent << "MaximumImageSampleDistance: " << this->MaximumImageSampleDistance << endl;
  os << indent << "InteractiveRenderTime: " << this->InteractiveRenderTime << endl;
  os << indent << "LevelOfDetail: " << this->LevelOfDetail << endl;
  os << indent << "NumberOfPrimitives: " << this->GetNumberOfPrimitives() << endl;
}

//------------------------------------------------------------------------------
int vtkTreeAMRIsosurfaceMapper::FillInputPortInformation(int vtkNotUsed(port), vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  return 1;
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetInputData(vtkHyperTreeGrid* grid)
{
  this->SetInputDataInternal(0, grid);
}

//------------------------------------------------------------------------------
vtkHyperTreeGrid* vtkTreeAMRIsosurfaceMapper::GetHyperTreeGrid()
{
  return treeamr::inputGrid(this);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::ShallowCopy(vtkAbstractMapper* mapper)
{
  this->Superclass::ShallowCopy(mapper);
  if (vtkTreeAMRIsosurfaceMapper* other = vtkTreeAMRIsosurfaceMapper::SafeDownCast(mapper))
  {
    treeamr::shareInput(this, other);
    this->SetInputArrayToProcess(0, other->GetInputArrayInformation(0));
    this->ContourValues->DeepCopy(other->ContourValues);
    this->SetIsosurfaceComponent(other->IsosurfaceComponent);
    this->SetCompositeIndex(other->CompositeIndex);
    this->SetAmbientOcclusionSamples(other->AmbientOcclusionSamples);
    this->SetAmbientOcclusionRadius(other->AmbientOcclusionRadius);
    this->SetShadows(other->Shadows);
    this->SetAutoAdjustSampleDistances(other->AutoAdjustSampleDistances);
    this->SetImageSampleDistance(other->ImageSampleDistance);
    this->SetMinimumImageSampleDistance(other->MinimumImageSampleDistance);
    this->SetMaximumImageSampleDistance(other->MaximumImageSampleDistance);
    this->SetInteractiveRenderTime(other->InteractiveRenderTime);
    this->SetLevelOfDetail(other->LevelOfDetail);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetValue(int i, double value)
{
  this->ContourValues->SetValue(i, value);
}

//------------------------------------------------------------------------------
double vtkTreeAMRIsosurfaceMapper::GetValue(int i)
{
  return this->ContourValues->GetValue(i);
}

//------------------------------------------------------------------------------
double* vtkTreeAMRIsosurfaceMapper::GetValues()
{
  return this->ContourValues->GetValues();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::GetValues(double* values)
{
  this->ContourValues->GetValues(values);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetNumberOfContours(int number)
{
  this->ContourValues->SetNumberOfContours(number);
}

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRIsosurfaceMapper::GetNumberOfContours()
{
  return this->ContourValues->GetNumberOfContours();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::GenerateValues(int number, double range[2])
{
  this->ContourValues->GenerateValues(number, range);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::GenerateValues(int number, double rangeStart, double rangeEnd)
{
  this->ContourValues->GenerateValues(number, rangeStart, rangeEnd);
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRIsosurfaceMapper::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->ContourValues->GetMTime());
}

//------------------------------------------------------------------------------
vtkHyperTreeGrid* vtkTreeAMRIsosurfaceMapper::UpdateInput()
{
  if (this->GetNumberOfInputConnections(0) > 0 && !this->Static)
  {
    this->Update();
  }
  return this->GetHyperTreeGrid();
}

//------------------------------------------------------------------------------
double* vtkTreeAMRIsosurfaceMapper::GetBounds()
{
  this->Private->BoundsSlot.get(this->UpdateInput(), this->Bounds);
  return this->Bounds;
}

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRIsosurfaceMapper::GetNumberOfPrimitives()
{
  const std::shared_ptr<const treeamr::Isosurface>& surface = this->Private->Surfaces.madeInFull();
  return surface ? static_cast<vtkIdType>(surface->octantCount()) : 0;
}

//------------------------------------------------------------------------------
double vtkTreeAMRIsosurfaceMapper::GetLastImageSampleDistance()
{
  return this->Private->LastSampleDistance;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRIsosurfaceMapper::GetSurfaceBuildTime()
{
  return this->Private->SurfaceTime.GetMTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::UpdateSurface(vtkHyperTreeGrid* grid)
{
  if (!grid)
  {
    throw treeamr::Error("isosurface mapper: no input, needed is a vtkHyperTreeGrid");
  }
  treeamr::ArraySelection contoured;
  contoured.name = treeamr::processedArrayName(this, grid);
  contoured.component = this->IsosurfaceComponent;
  Internals& internals = *this->Private;
  const std::shared_ptr<const treeamr::Field>& field = internals.ContourSlot.acquire(grid, contoured);
  field->nodeRanges(); // made now, they do not count as a frame's time
  std::vector<double> isovalues(this->GetNumberOfContours());
  this->GetValues(isovalues.data());
  if (internals.Surfaces.set(field, isovalues))
  {
    // Before there are others.
    for (const std::unique_ptr<treeamr::SurfaceActorView>& view : internals.Views)
    {
      view->surface.release();
    }
    if (!isovalues.empty())
    {
      internals.SurfaceTime.Modified();
    }
    internals.Field = field;
  }
  internals.Contoured = contoured;
}

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRIsosurfaceMapper::IntersectWithLine(
  const double p1[3], const double p2[3], double t1, double t2, double& t, double normal[3], double& value)
{
  try
  {
    vtkHyperTreeGrid* grid = this->UpdateInput();
    this->UpdateSurface(grid);
    if (this->Private->Surfaces.isEmpty())
    {
      return -1;
    }
    const auto pick =
      treeamr::pickSurface(*this->Private->Surfaces.inFull(), treeamr::pickLine(p1, p2, t1, t2));
    return pick ? treeamr::tell(*pick, grid, t, normal, value) : -1;
  }
  catch (const std::exception& error)
  {
    this->Private->Messages.error(error);
    return -1;
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::HasTranslucentPolygonalGeometry()
{
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  try
  {
    vtkDataArray* array = grid ? treeamr::selectColors(this, grid).array : nullptr;
    return array && this->HasTranslucentColors(array);
  }
  catch (const treeamr::Error&)
  {
    return false; // Render() says why there are no colours
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::HasTranslucentColors(vtkDataArray* array)
{
  return treeamr::isTranslucent(this, array);
}

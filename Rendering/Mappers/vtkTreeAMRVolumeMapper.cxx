#include "vtkTreeAMRVolumeMapper.h"

#include "NewerSettings.h"
#include "SceneConversion.h"
#include "TransferFunctionConversion.h"
#include "UnsupportedSettings.h"
#include "VolumeEffects.h"
#include "VolumeMapperInternals.h"

#include "Error.h"
#include "MemoryBudget.h"

#include "vtkContourValues.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkRenderer.h"
#include "vtkTypeInt64Array.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <cmath>
#include <string>

vtkStandardNewMacro(vtkTreeAMRVolumeMapper);

namespace
{

template <typename Array, typename Value>
void addColumn(vtkTable* table, const char* name, Value value)
{
  vtkNew<Array> column;
  column->SetName(name);
  column->InsertNextValue(value);
  table->AddColumn(column);
}

void addColumn(vtkTable* table, const char* name, std::uint64_t value)
{
  addColumn<vtkTypeInt64Array>(table, name, static_cast<vtkTypeInt64>(value));
}

void addColumn(vtkTable* table, const char* name, double value)
{
  addColumn<vtkDoubleArray>(table, name, value);
}

} // anonymous namespace

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper::vtkTreeAMRVolumeMapper()
  : VertexCacheSize(static_cast<int>(treeamr::defaultKeptBytes >> 20))
  , Private(std::make_unique<Internals>(this))
{
}

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper::~vtkTreeAMRVolumeMapper() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetSamplesPerCell(double value)
{
  treeamr::setWithin(
    this, "SamplesPerCell", this->SamplesPerCell, value, FewestSamplesPerCell, MostSamplesPerCell);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetVertexCacheSize(int value)
{
  treeamr::setWithin(this, "VertexCacheSize", this->VertexCacheSize, value, 0, VTK_INT_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetImageSampleDistance(double value)
{
  treeamr::setWithin(this, "ImageSampleDistance", this->ImageSampleDistance, value, 1., 100.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetMinimumImageSampleDistance(double value)
{
  treeamr::setWithin(this, "MinimumImageSampleDistance", this->MinimumImageSampleDistance, value, 1., 100.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetMaximumImageSampleDistance(double value)
{
  treeamr::setWithin(this, "MaximumImageSampleDistance", this->MaximumImageSampleDistance, value, 1., 100.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetInteractiveRenderTime(double value)
{
  treeamr::setWithin(this, "InteractiveRenderTime", this->InteractiveRenderTime, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetLevelOfDetail(double value)
{
  treeamr::setWithin(this, "LevelOfDetail", this->LevelOfDetail, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetTargetError(double value)
{
  treeamr::setWithin(this, "TargetError", this->TargetError, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetIsosurfaceOpacityScale(double value)
{
  treeamr::setWithin(this, "IsosurfaceOpacityScale", this->IsosurfaceOpacityScale, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetAmbientOcclusionSamples(int value)
{
  treeamr::setWithin(this, "AmbientOcclusionSamples", this->AmbientOcclusionSamples, value, 0, 65535);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetAmbientOcclusionRadius(double value)
{
  treeamr::setWithin(this, "AmbientOcclusionRadius", this->AmbientOcclusionRadius, value, 0., VTK_DOUBLE_MAX);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VectorMode: " << this->VectorMode << endl;
  os << indent << "VectorComponent: " << this->VectorComponent << endl;
  os << indent << "OpacityArrayName: " << this->OpacityArrayName << endl;
  os << indent << "OpacityComponent: " << this->OpacityComponent << endl;
  os << indent << "Transfer2DYAxisArray: " << this->Transfer2DYAxisArray << endl;
  os << indent << "Transfer2DYAxisComponent: " << this->Transfer2DYAxisComponent << endl;
  os << indent << "Transfer2DRange: " << this->Transfer2DRange[0] << " " << this->Transfer2DRange[1] << " "
     << this->Transfer2DRange[2] << " " << this->Transfer2DRange[3] << endl;
  os << indent << "SamplesPerCell: " << this->SamplesPerCell << endl;
  os << indent << "SampleDistance: " << this->SampleDistance << endl;
  os << indent << "LockSampleDistanceToInputSpacing: " << this->LockSampleDistanceToInputSpacing << endl;
  os << indent << "UseJittering: " << this->UseJittering << endl;
  os << indent << "FinalColorWindow: " << this->FinalColorWindow << endl;
  os << indent << "FinalColorLevel: " << this->FinalColorLevel << endl;
  os << indent << "ReportProgress: " << this->ReportProgress << endl;
  os << indent << "SkipEmptySpace: " << this->SkipEmptySpace << endl;
  os << indent << "VertexCacheSize: " << this->VertexCacheSize << endl;
  os << indent << "AutoAdjustSampleDistances: " << this->AutoAdjustSampleDistances << endl;
  os << indent << "ImageSampleDistance: " << this->ImageSampleDistance << endl;
  os << indent << "MinimumImageSampleDistance: " << this->MinimumImageSampleDistance << endl;
  os << indent << "MaximumImageSampleDistance: " << this->MaximumImageSampleDistance << endl;
  os << indent << "InteractiveRenderTime: " << this->InteractiveRenderTime << endl;
  os << indent << "LevelOfDetail: " << this->LevelOfDetail << endl;
  os << indent << "EstimateError: " << this->EstimateError << endl;
  os << indent << "TargetError: " << this->TargetError << endl;
  os << indent << "ShowIsosurfaces: " << this->ShowIsosurfaces << endl;
  os << indent << "ShadeIsosurfaces: " << this->ShadeIsosurfaces << endl;
  os << indent << "IsosurfaceOpacityScale: " << this->IsosurfaceOpacityScale << endl;
  os << indent << "AmbientOcclusionSamples: " << this->AmbientOcclusionSamples << endl;
  os << indent << "AmbientOcclusionRadius: " << this->AmbientOcclusionRadius << endl;
  os << indent << "Shadows: " << this->Shadows << endl;
  os << indent << "VolumetricScatteringBlending: " << this->VolumetricScatteringBlending << endl;
  os << indent << "GlobalIlluminationReach: " << this->GlobalIlluminationReach << endl;
  os << indent << "Statistics:" << endl;
  vtkTable* statistics = this->GetStatistics();
  for (vtkIdType i = 0; i < statistics->GetNumberOfColumns(); ++i)
  {
    os << indent.GetNextIndent() << statistics->GetColumnName(i) << ": "
       << statistics->GetValue(0, i).ToString() << endl;
  }
}

//------------------------------------------------------------------------------
int vtkTreeAMRVolumeMapper::FillInputPortInformation(int vtkNotUsed(port), vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  return 1;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetInputData(vtkHyperTreeGrid* grid)
{
  this->SetInputDataInternal(0, grid);
}

//------------------------------------------------------------------------------
vtkHyperTreeGrid* vtkTreeAMRVolumeMapper::GetHyperTreeGrid()
{
  return treeamr::inputGrid(this);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::ShallowCopy(vtkAbstractMapper* mapper)
{
  this->Superclass::ShallowCopy(mapper);
  if (vtkVolumeMapper* other = vtkVolumeMapper::SafeDownCast(mapper))
  {
    // VTK's volume mappers leave out what is theirs.
    this->SetScalarMode(other->GetScalarMode());
    if (other->GetArrayAccessMode() == VTK_GET_ARRAY_BY_ID)
    {
      this->SelectScalarArray(other->GetArrayId());
    }
    else
    {
      this->SelectScalarArray(other->GetArrayName());
    }
    this->SetBlendMode(other->GetBlendMode());
    this->SetAverageIPScalarRange(other->GetAverageIPScalarRange());
    treeamr::computeNormalFromOpacity(*this, treeamr::computesNormalFromOpacity(*other));
    this->SetCropping(other->GetCropping());
    this->SetCroppingRegionPlanes(other->GetCroppingRegionPlanes());
    this->SetCroppingRegionFlags(other->GetCroppingRegionFlags());
  }
  if (vtkTreeAMRVolumeMapper* other = vtkTreeAMRVolumeMapper::SafeDownCast(mapper))
  {
    treeamr::shareInput(this, other);
    this->SetVectorMode(other->VectorMode);
    this->SetVectorComponent(other->VectorComponent);
    this->SetOpacityArrayName(other->OpacityArrayName.c_str());
    this->SetOpacityComponent(other->OpacityComponent);
    this->SetTransfer2DYAxisArray(other->Transfer2DYAxisArray.c_str());
    this->SetTransfer2DYAxisComponent(other->Transfer2DYAxisComponent);
    this->SetTransfer2DRange(other->Transfer2DRange);
    this->SetSamplesPerCell(other->SamplesPerCell);
    this->SetSampleDistance(other->SampleDistance);
    this->SetLockSampleDistanceToInputSpacing(other->LockSampleDistanceToInputSpacing);
    this->SetUseJittering(other->UseJittering);
    this->SetFinalColorWindow(other->FinalColorWindow);
    this->SetFinalColorLevel(other->FinalColorLevel);
    this->SetReportProgress(other->ReportProgress);
    this->SetVertexCacheSize(other->VertexCacheSize);
    this->SetSkipEmptySpace(other->SkipEmptySpace);
    this->SetAutoAdjustSampleDistances(other->AutoAdjustSampleDistances);
    this->SetImageSampleDistance(other->ImageSampleDistance);
    this->SetMinimumImageSampleDistance(other->MinimumImageSampleDistance);
    this->SetMaximumImageSampleDistance(other->MaximumImageSampleDistance);
    this->SetInteractiveRenderTime(other->InteractiveRenderTime);
    this->SetLevelOfDetail(other->LevelOfDetail);
    this->SetEstimateError(other->EstimateError);
    this->SetTargetError(other->TargetError);
    this->SetShowIsosurfaces(other->ShowIsosurfaces);
    this->SetShadeIsosurfaces(other->ShadeIsosurfaces);
    this->SetIsosurfaceOpacityScale(other->IsosurfaceOpacityScale);
    this->SetAmbientOcclusionSamples(other->AmbientOcclusionSamples);
    this->SetAmbientOcclusionRadius(other->AmbientOcclusionRadius);
    this->SetShadows(other->Shadows);
    this->SetVolumetricScatteringBlending(other->VolumetricScatteringBlending);
    this->SetGlobalIlluminationReach(other->GlobalIlluminationReach);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetOpacityArrayName(const char* name)
{
  const std::string wanted = name ? name : "";
  if (wanted != this->OpacityArrayName)
  {
    this->OpacityArrayName = wanted;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetTransfer2DYAxisArray(const char* name)
{
  const std::string wanted = name ? name : "";
  if (wanted != this->Transfer2DYAxisArray)
  {
    this->Transfer2DYAxisArray = wanted;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
double* vtkTreeAMRVolumeMapper::GetBounds()
{
  if (this->GetNumberOfInputConnections(0) > 0)
  {
    this->Update();
  }
  this->Private->BoundsSlot.get(this->GetHyperTreeGrid(), this->Bounds);
  if (this->Private->Peers && this->GetHyperTreeGrid())
  {
    treeamr::addRelayed(*this->GetHyperTreeGrid(), this->Private->MayGather, this->Bounds);
  }
  return this->Bounds;
}

//------------------------------------------------------------------------------
vtkTable* vtkTreeAMRVolumeMapper::GetStatistics()
{
  const Internals& internals = *this->Private;
  const treeamr::VolumeFrame& frame = internals.CurrentFrame;
  const treeamr::Field* field = internals.Field.get();
  vtkTable* table = internals.Statistics;
  table->Initialize();
  addColumn(table, "Cells", field ? field->octree().leafCount() : 0);
  addColumn(table, "OctreeBytes", field ? field->byteSize() + field->octree().byteSize() : 0);
  addColumn(table, "KeptBytes", internals.Volume ? internals.Volume->keptBytes() : 0);
  addColumn(table, "Rays", frame.Counts.rays);
  addColumn(table, "Nodes", frame.Counts.nodes);
  addColumn(table, "KeptBlocks", frame.Counts.kept);
  addColumn(table, "ReconstructedBlocks", frame.Counts.blocks);
  addColumn(table, "ReconstructedCells", frame.Counts.cells);
  addColumn(table, "KeptGradients", frame.Counts.keptGradients);
  addColumn(table, "ReconstructedGradients", frame.Counts.gradients);
  addColumn(table, "Intervals", frame.Counts.intervals);
  addColumn(table, "Samples", frame.Counts.samples);
  const treeamr::VolumeSurfaces& seen = internals.Surfaces[frame.Eye];
  const treeamr::Isosurface* surfaces = seen.engine();
  const treeamr::IsosurfaceStatistics ofSurfaces =
    surfaces ? surfaces->statistics() : treeamr::IsosurfaceStatistics();
  addColumn(table, "SurfaceBytes",
    ofSurfaces.blockBytes + ofSurfaces.hierarchyBytes + ofSurfaces.keptBytes + ofSurfaces.gradientBytes);
  addColumn(table, "SurfaceHits", seen.hitCount());
  addColumn(table, "ImageSampleDistance", frame.ImageSampleDistance);
  addColumn(table, "LevelOfDetail", frame.LevelOfDetail);
  addColumn(table, "SamplesPerCell", frame.SamplesPerCell);
  addColumn(table, "EstimatedError", frame.SquaredError < 0. ? -1. : std::sqrt(frame.SquaredError));
  addColumn(table, "FieldSeconds", internals.FieldSeconds);
  addColumn(table, "TransferFunctionSeconds", internals.TransferFunctionSeconds);
  addColumn(table, "RayCastingSeconds", frame.RayCastingSeconds);
  addColumn(table, "ErrorSeconds", frame.ErrorSeconds);
  addColumn(table, "CompositingSeconds", frame.CompositingSeconds);
  return table;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRVolumeMapper::GetFieldBuildTime()
{
  return this->Private->FieldTime.GetMTime();
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRVolumeMapper::GetTransferFunctionBuildTime()
{
  return this->Private->TransferFunctionTime.GetMTime();
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRVolumeMapper::GetIsosurfaceBuildTime()
{
  return this->Private->SurfaceTime.GetMTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::CheckSettings()
{
  if (this->BlendMode < vtkVolumeMapper::COMPOSITE_BLEND || this->BlendMode > vtkVolumeMapper::SLICE_BLEND)
  {
    throw treeamr::Error("volume mapper: blend mode " + std::to_string(this->BlendMode) +
      ", allowed are 0 (composite), 1 and 2 (maximum and minimum intensity), 3 (average), 4 (additive), 5 "
      "(isosurface) and 6 (slice)");
  }
  for (const auto& [name, value] : { std::pair("image sample distance", this->ImageSampleDistance),
         std::pair("minimum image sample distance", this->MinimumImageSampleDistance),
         std::pair("maximum image sample distance", this->MaximumImageSampleDistance),
         std::pair("interactive render time", this->InteractiveRenderTime),
         std::pair("level of detail", this->LevelOfDetail), std::pair("target error", this->TargetError),
         std::pair("sample distance", this->SampleDistance),
         std::pair("final color window", this->FinalColorWindow),
         std::pair("final color level", this->FinalColorLevel),
         std::pair("isosurface opacity scale", this->IsosurfaceOpacityScale),
         std::pair("first number of the Transfer2DRange", this->Transfer2DRange[0]),
         std::pair("second number of the Transfer2DRange", this->Transfer2DRange[1]),
         std::pair("third number of the Transfer2DRange", this->Transfer2DRange[2]),
         std::pair("fourth number of the Transfer2DRange", this->Transfer2DRange[3]),
         std::pair("ambient occlusion radius", this->AmbientOcclusionRadius),
         std::pair("volumetric scattering blending", static_cast<double>(this->VolumetricScatteringBlending)),
         std::pair("global illumination reach", static_cast<double>(this->GlobalIlluminationReach)) })
  {
    if (std::isnan(value)) // passes VTK's clamping
    {
      throw treeamr::Error(std::string("volume mapper: the ") + name + " is not a number");
    }
  }
  if (this->FinalColorWindow == 0.)
  {
    throw treeamr::Error("volume mapper: a final color window of 0, allowed are all others");
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::WarnOfSettings(vtkVolume* volume)
{
  const bool hasSurfaces = this->ShowIsosurfaces || !this->ShowsVolume();
  const bool hasCategories = this->ShowsVolume() && treeamr::hasCategories(volume->GetProperty());
  const bool hasOpacityArray = !this->OpacityArrayName.empty();
  const bool hasOpacity = this->SelectOpacity(volume).has_value();
  const bool canMix = this->CanMix(volume);
  const Components components = this->GetComponents(volume);
  const bool areIndependent = components == Components::Independent;
  treeamr::SettingNames names = treeamr::unsupportedSettings(volume, this,
    { hasCategories, hasSurfaces, canMix && components != Components::One && !areIndependent,
      canMix && areIndependent, this->VolumetricScatteringBlending > 0.f, this->ReadsTable(volume) });
  if (areIndependent && this->ShowsVolume() && !canMix)
  {
    names.emplace_back(
      hasCategories ? "VectorMode DISABLED of categories" : "VectorMode DISABLED with a BlendMode of values");
  }
  if (hasOpacityArray && this->ShowsVolume() && !hasOpacity)
  {
    names.emplace_back(
      hasCategories ? "OpacityArrayName of categories" : "OpacityArrayName with a BlendMode of values");
  }
  if (this->UseJittering)
  {
    names.emplace_back("UseJittering");
  }
  this->Private->Messages.unsupported(names);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::ShowsVolume() const
{
  return this->BlendMode != vtkVolumeMapper::ISOSURFACE_BLEND;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateIsosurfaces(vtkRenderer* renderer, vtkVolume* volume)
{
  Internals& internals = *this->Private;
  vtkContourValues* contours = volume->GetProperty()->GetIsoSurfaceValues();
  const int count = contours->GetNumberOfContours();
  if (count == 0 || (this->ShowsVolume() && !this->ShowIsosurfaces) || treeamr::blendsValues(this))
  {
    for (treeamr::VolumeSurfaces& surfaces : internals.Surfaces)
    {
      surfaces.release();
    }
    if (internals.Categories)
    {
      internals.FieldSlot.release();
    }
    return;
  }
  if (!treeamr::isStereo(renderer))
  {
    internals.Surfaces[1].release();
  }
  const double* isovalues = contours->GetValues();
  const std::shared_ptr<const treeamr::Field> field = internals.Categories
    ? internals.FieldSlot.acquire(this->GetHyperTreeGrid(), this->SelectArray())
    : internals.Field;
  if (internals.Surfaces[treeamr::eyeOf(renderer)].set(
        field, std::vector<double>(isovalues, isovalues + count)))
  {
    internals.SurfaceTime.Modified();
    internals.SampleDistances.clear();
  }
}

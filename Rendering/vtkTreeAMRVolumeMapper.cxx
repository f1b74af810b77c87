#include "vtkTreeAMRVolumeMapper.h"

#include "MapperInput.h"
#include "SceneConversion.h"
#include "vtkTreeAMRDepthPeeling.h"
#include "vtkTreeAMRFramebuffer.h"

#include "Error.h"
#include "RayTracing/VertexCache.h"
#include "RayTracing/VolumeRenderer.h"

#include "vtkCommand.h"
#include "vtkExecutive.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPlaneCollection.h"
#include "vtkRenderer.h"
#include "vtkTimerLog.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <optional>

vtkStandardNewMacro(vtkTreeAMRVolumeMapper);

//------------------------------------------------------------------------------
struct vtkTreeAMRVolumeMapper::Internals
{
  vtkTreeAMRFramebuffer Framebuffer;
  vtkTreeAMRDepthPeeling DepthPeeling;
  treeamr::FieldSlot FieldSlot;
  treeamr::BoundsSlot BoundsSlot;
  treeamr::OnceReporter Errors;
  treeamr::OnceReporter Warnings;

  std::shared_ptr<const treeamr::Field> Field;
  vtkTimeStamp FieldTime;
  std::unique_ptr<treeamr::VertexCache> Kept; // of this field, of this size in MiB
  int KeptSize = 0;
  // Of this property at this time, for this field.
  std::optional<treeamr::TransferFunction> TransferFunction;
  vtkVolumeProperty* Property = nullptr; // not dereferenced
  vtkMTimeType PropertyTime = 0;
  vtkTimeStamp TransferFunctionTime;
};

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper::vtkTreeAMRVolumeMapper()
  : Private(std::make_unique<Internals>())
{
}

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper::~vtkTreeAMRVolumeMapper() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VectorMode: " << this->VectorMode << endl;
  os << indent << "VectorComponent: " << this->VectorComponent << endl;
  os << indent << "SamplesPerCell: " << this->SamplesPerCell << endl;
  os << indent << "SkipEmptySpace: " << this->SkipEmptySpace << endl;
  os << indent << "VertexCacheSize: " << this->VertexCacheSize << endl;
  os << indent << "LastNumberOfNodes: " << this->LastNumberOfNodes << endl;
  os << indent << "LastNumberOfCells: " << this->LastNumberOfCells << endl;
  os << indent << "LastNumberOfSamples: " << this->LastNumberOfSamples << endl;
  os << indent << "BuildSeconds: " << this->BuildSeconds << endl;
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
  return this->GetNumberOfInputConnections(0) < 1
    ? nullptr
    : vtkHyperTreeGrid::SafeDownCast(this->GetExecutive()->GetInputData(0, 0));
}

//------------------------------------------------------------------------------
double* vtkTreeAMRVolumeMapper::GetBounds()
{
  if (this->GetNumberOfInputConnections(0) > 0)
  {
    this->Update();
  }
  this->Private->BoundsSlot.get(this->GetHyperTreeGrid(), this->Bounds);
  return this->Bounds;
}

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRVolumeMapper::GetNumberOfCells()
{
  const auto& field = this->Private->Field;
  return field ? static_cast<vtkIdType>(field->octree().leafCount()) : 0;
}

//------------------------------------------------------------------------------
vtkTypeUInt64 vtkTreeAMRVolumeMapper::GetOctreeBytes()
{
  const auto& field = this->Private->Field;
  return field ? field->byteSize() + field->octree().byteSize() : 0;
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
void vtkTreeAMRVolumeMapper::CheckSettings()
{
  if (this->BlendMode != vtkVolumeMapper::COMPOSITE_BLEND)
  {
    throw treeamr::Error(
      "volume mapper: blend mode " + std::to_string(this->BlendMode) + ", allowed is 0 (composite)");
  }
  vtkPlaneCollection* planes = this->GetClippingPlanes();
  if (this->Cropping || (planes && planes->GetNumberOfItems() > 0))
  {
    const char* const message = "Cropping and clipping planes are not implemented and have no effect.";
    if (this->Private->Warnings.isNews(message, this->GetMTime()))
    {
      vtkWarningMacro(<< message);
    }
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateField()
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
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  const std::shared_ptr<const treeamr::Field>& field =
    this->Private->FieldSlot.acquire(grid, selection, true);
  timer->StopTimer();
  if (field != this->Private->Field)
  {
    this->BuildSeconds = timer->GetElapsedTime();
    this->Private->Field = field;
    this->Private->Kept.reset();
    this->Private->FieldTime.Modified();
    this->Private->TransferFunction.reset();
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateVertexCache()
{
  Internals& internals = *this->Private;
  if (!internals.Kept || internals.KeptSize != this->VertexCacheSize)
  {
    internals.Kept.reset(); // before the new one is allocated
    internals.Kept = std::make_unique<treeamr::VertexCache>(
      internals.Field->octree(), static_cast<std::size_t>(this->VertexCacheSize) << 20);
    internals.KeptSize = this->VertexCacheSize;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateTransferFunction(vtkVolume* volume)
{
  Internals& internals = *this->Private;
  vtkVolumeProperty* property = volume->GetProperty();
  if (!internals.TransferFunction || internals.Property != property ||
    internals.PropertyTime != property->GetMTime())
  {
    internals.TransferFunction.reset();
    internals.TransferFunction = treeamr::convertTransferFunction(property, internals.Field->range());
    internals.Property = property;
    // Asking for functions that were never set has made them.
    internals.PropertyTime = property->GetMTime();
    internals.TransferFunctionTime.Modified();
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::RenderVolume(vtkRenderer* renderer, vtkVolume* volume)
{
  Internals& internals = *this->Private;
  this->CheckSettings();
  this->UpdateField();
  this->UpdateVertexCache();
  this->UpdateTransferFunction(volume);

  const vtkTreeAMRViewport viewport = vtkTreeAMRFramebuffer::GetViewport(renderer);
  const treeamr::Camera camera(
    treeamr::clipFromData(renderer, volume), treeamr::worldFromData(volume), viewport.Width, viewport.Height);
  const treeamr::VolumeSettings settings{ this->SamplesPerCell, this->SkipEmptySpace };
  treeamr::VolumeStatistics statistics;
  const auto trace = [&](const treeamr::DepthInterval& interval, treeamr::Image& image) {
    statistics += treeamr::renderVolume(
      *internals.Field, *internals.TransferFunction, camera, interval, settings, *internals.Kept, image);
  };

  treeamr::Image image(viewport.Width, viewport.Height);
  if (vtkTreeAMRDepthPeeling::IsPeeling(volume))
  {
    vtkTreeAMRRaySegments front;
    vtkTreeAMRRaySegments back;
    internals.DepthPeeling.Begin(renderer, this, volume, viewport.Width, viewport.Height, front, back);
    treeamr::Image frontImage(viewport.Width, viewport.Height);
    if (!front.IsEmpty())
    {
      trace({ front.Begin.data(), front.End.data() }, frontImage);
    }
    if (!back.IsEmpty())
    {
      trace({ back.Begin.data(), back.End.data() }, image);
    }
    internals.DepthPeeling.Draw(renderer, frontImage, image);
  }
  else
  {
    std::vector<float> opaqueDepth;
    internals.Framebuffer.ReadDepth(renderer, viewport, opaqueDepth);
    trace({ nullptr, opaqueDepth.data() }, image);
    internals.Framebuffer.DrawOver(renderer, image);
  }
  this->LastNumberOfNodes = static_cast<vtkIdType>(statistics.nodes);
  this->LastNumberOfCells = static_cast<vtkIdType>(statistics.cells);
  this->LastNumberOfSamples = static_cast<vtkIdType>(statistics.samples);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::Report(const char* message, vtkVolume* volume)
{
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  const vtkMTimeType stamp = std::max({ this->GetMTime(), volume->GetProperty()->GetMTime(),
    grid ? treeamr::gridModificationTime(grid) : vtkMTimeType(0) });
  if (this->Private->Errors.isNews(message, stamp))
  {
    vtkErrorMacro(<< message);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::Render(vtkRenderer* renderer, vtkVolume* volume)
{
  if (renderer->GetSelector())
  {
    return;
  }
  this->InvokeEvent(vtkCommand::VolumeMapperRenderStartEvent, nullptr);
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  try
  {
    this->RenderVolume(renderer, volume);
    this->Private->Errors.clear();
  }
  catch (const std::exception& error)
  {
    this->Report(error.what(), volume);
  }
  timer->StopTimer();
  this->TimeToDraw = timer->GetElapsedTime();
  this->InvokeEvent(vtkCommand::VolumeMapperRenderEndEvent, nullptr);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Private->Framebuffer.ReleaseGraphicsResources(window);
  this->Private->DepthPeeling.ReleaseGraphicsResources(window);
}

#include "vtkTreeAMRVolumeMapper.h"

#include "FramePlan.h"
#include "MapperInput.h"
#include "MapperMessages.h"
#include "SceneConversion.h"
#include "SurfaceShading.h"
#include "TranslucentScene.h"
#include "UnsupportedSettings.h"
#include "VolumeSurfaces.h"
#include "vtkTreeAMRDepthPeeling.h"
#include "vtkTreeAMRDepthReader.h"
#include "vtkTreeAMRImagePainter.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRTarget.h"

#include "Error.h"
#include "Interpolation/BlockCache.h"
#include "Volume/ErrorEstimate.h"
#include "Volume/VolumeRenderer.h"

#include "vtkCommand.h"
#include "vtkContourValues.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkTable.h"
#include "vtkTimerLog.h"
#include "vtkTypeInt64Array.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

vtkStandardNewMacro(vtkTreeAMRVolumeMapper);

namespace
{

/// What a frame did. Depth peeling draws one in many parts.
struct Frame
{
  // Not dereferenced.
  std::pair<vtkRenderer*, vtkVolume*> Of{ nullptr, nullptr };
  int Eye = 0; // of a stereo window
  int Pixels = 0;
  bool Interactive = false;
  double ImageSampleDistance = 0.;
  double LevelOfDetail = 0.;
  double SamplesPerCell = 0.;
  double NextSamplesPerCell = 0.; // to meet the target, the most that any part asks for
  double SquaredError = -1.;      // sum over the parts; negative: not estimated
  treeamr::VolumeStatistics Counts;
  double RayCastingSeconds = 0.;
  double ErrorSeconds = 0.;
  double CompositingSeconds = 0.;
};

/// Adds the wall-clock seconds of its own lifetime.
class Stopwatch
{
public:
  explicit Stopwatch(double& sum)
    : Sum(sum)
    , Start(vtkTimerLog::GetUniversalTime())
  {
  }
  ~Stopwatch() { this->Sum += vtkTimerLog::GetUniversalTime() - this->Start; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  double& Sum;
  double Start;
};

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
struct vtkTreeAMRVolumeMapper::Internals
{
  explicit Internals(vtkTreeAMRVolumeMapper* self)
    : Messages(self)
  {
  }

  vtkTreeAMRImagePainter Painter;
  vtkTreeAMRDepthPeeling DepthPeeling;
  treeamr::FieldSlot FieldSlot;
  treeamr::CategorySlot CategorySlot;
  treeamr::BoundsSlot BoundsSlot;
  treeamr::MapperMessages Messages; // of a call of Render()

  std::shared_ptr<const treeamr::Field> Field;           // that rays see
  std::shared_ptr<const treeamr::Categories> Categories; // whose numbers it is; null: it is the array's
  vtkTimeStamp FieldTime;
  double FieldSeconds = 0.;
  std::unique_ptr<treeamr::BlockCache> Kept; // of this field, of this size in MiB
  int KeptSize = 0;
  // Of this property at this time, for this field. Without a property: transparent.
  std::optional<treeamr::TransferFunction> TransferFunction;
  vtkVolumeProperty* Property = nullptr; // not dereferenced
  vtkMTimeType PropertyTime = 0;
  vtkTimeStamp TransferFunctionTime;
  double TransferFunctionSeconds = 0.;
  std::array<treeamr::VolumeSurfaces, 2> Surfaces; // of the field, seen by each eye
  vtkTimeStamp SurfaceTime;
  treeamr::CollectedLayers Layers; // of these and of the actors that are drawn with the volume

  Frame CurrentFrame;
  // Of this field with this transfer function.
  std::map<std::pair<vtkRenderer*, vtkVolume*>, treeamr::SampleDistanceControl> SampleDistances;
  // That met the target in the last still frame.
  std::map<std::pair<vtkRenderer*, vtkVolume*>, double> SamplesPerCell;
  vtkNew<vtkTable> Statistics;
};

//------------------------------------------------------------------------------
// What a call of Render() draws.
struct vtkTreeAMRVolumeMapper::Picture
{
  vtkRenderer* Renderer;
  vtkVolume* Volume;
  vtkTreeAMRViewport Viewport;
  bool IsWhole; // with all that is translucent in the renderer
  bool IsPeeling;
  bool HasVolume; // else it failed
  treeamr::DataCut Cut;
  treeamr::ActorLayers Actors;
  std::optional<std::vector<treeamr::SurfaceShader>> Shaders; // once they are traced, the mapper's own first
};

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper::vtkTreeAMRVolumeMapper()
  : VertexCacheSize(static_cast<int>(treeamr::defaultKeptBytes >> 20))
  , Private(std::make_unique<Internals>(this))
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
  os << indent << "AutoAdjustSampleDistances: " << this->AutoAdjustSampleDistances << endl;
  os << indent << "ImageSampleDistance: " << this->ImageSampleDistance << endl;
  os << indent << "MinimumImageSampleDistance: " << this->MinimumImageSampleDistance << endl;
  os << indent << "MaximumImageSampleDistance: " << this->MaximumImageSampleDistance << endl;
  os << indent << "InteractiveRenderTime: " << this->InteractiveRenderTime << endl;
  os << indent << "LevelOfDetail: " << this->LevelOfDetail << endl;
  os << indent << "EstimateError: " << this->EstimateError << endl;
  os << indent << "TargetError: " << this->TargetError << endl;
  os << indent << "ShowIsosurfaces: " << this->ShowIsosurfaces << endl;
  os << indent << "IsosurfaceOpacityScale: " << this->IsosurfaceOpacityScale << endl;
  os << indent << "AmbientOcclusionSamples: " << this->AmbientOcclusionSamples << endl;
  os << indent << "AmbientOcclusionRadius: " << this->AmbientOcclusionRadius << endl;
  os << indent << "Shadows: " << this->Shadows << endl;
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
    this->SetComputeNormalFromOpacity(other->GetComputeNormalFromOpacity());
    this->SetCropping(other->GetCropping());
    this->SetCroppingRegionPlanes(other->GetCroppingRegionPlanes());
    this->SetCroppingRegionFlags(other->GetCroppingRegionFlags());
  }
  if (vtkTreeAMRVolumeMapper* other = vtkTreeAMRVolumeMapper::SafeDownCast(mapper))
  {
    treeamr::shareInput(this, other);
    this->SetVectorMode(other->VectorMode);
    this->SetVectorComponent(other->VectorComponent);
    this->SetSamplesPerCell(other->SamplesPerCell);
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
    this->SetIsosurfaceOpacityScale(other->IsosurfaceOpacityScale);
    this->SetAmbientOcclusionSamples(other->AmbientOcclusionSamples);
    this->SetAmbientOcclusionRadius(other->AmbientOcclusionRadius);
    this->SetShadows(other->Shadows);
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
  return this->Bounds;
}

//------------------------------------------------------------------------------
vtkTable* vtkTreeAMRVolumeMapper::GetStatistics()
{
  const Internals& internals = *this->Private;
  const Frame& frame = internals.CurrentFrame;
  const treeamr::Field* field = internals.Field.get();
  vtkTable* table = internals.Statistics;
  table->Initialize();
  addColumn(table, "Cells", field ? field->octree().leafCount() : 0);
  addColumn(table, "OctreeBytes", field ? field->byteSize() + field->octree().byteSize() : 0);
  addColumn(table, "KeptBytes", internals.Kept ? internals.Kept->byteSize() : 0);
  addColumn(table, "Rays", frame.Counts.rays);
  addColumn(table, "Nodes", frame.Counts.nodes);
  addColumn(table, "KeptBlocks", frame.Counts.kept);
  addColumn(table, "ReconstructedBlocks", frame.Counts.blocks);
  addColumn(table, "ReconstructedCells", frame.Counts.cells);
  addColumn(table, "Intervals", frame.Counts.intervals);
  addColumn(table, "Samples", frame.Counts.samples);
  const treeamr::VolumeSurfaces& seen = internals.Surfaces[frame.Eye];
  const treeamr::Isosurface* surfaces = seen.engine();
  const treeamr::IsosurfaceStatistics ofSurfaces =
    surfaces ? surfaces->statistics() : treeamr::IsosurfaceStatistics();
  addColumn(table, "SurfaceBytes", ofSurfaces.blockBytes + ofSurfaces.hierarchyBytes + ofSurfaces.keptBytes);
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
  if (this->BlendMode != vtkVolumeMapper::COMPOSITE_BLEND &&
    this->BlendMode != vtkVolumeMapper::ISOSURFACE_BLEND)
  {
    throw treeamr::Error("volume mapper: blend mode " + std::to_string(this->BlendMode) +
      ", allowed are 0 (composite) and 5 (isosurface)");
  }
  for (const auto& [name, value] : { std::pair("image sample distance", this->ImageSampleDistance),
         std::pair("minimum image sample distance", this->MinimumImageSampleDistance),
         std::pair("maximum image sample distance", this->MaximumImageSampleDistance),
         std::pair("interactive render time", this->InteractiveRenderTime),
         std::pair("level of detail", this->LevelOfDetail), std::pair("target error", this->TargetError),
         std::pair("isosurface opacity scale", this->IsosurfaceOpacityScale),
         std::pair("ambient occlusion radius", this->AmbientOcclusionRadius) })
  {
    if (std::isnan(value)) // passes VTK's clamping
    {
      throw treeamr::Error(std::string("volume mapper: the ") + name + " is not a number");
    }
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::WarnOfSettings(vtkVolume* volume)
{
  const bool hasSurfaces = this->ShowIsosurfaces || !this->ShowsVolume();
  this->Private->Messages.unsupported(treeamr::unsupportedSettings(volume, this, hasSurfaces));
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
  const treeamr::ArraySelection selection = this->SelectArray();
  Internals& internals = *this->Private;
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
  field->nodeRanges(); // made now, they do not count as a frame's time
  internals.Messages.warning(internals.FieldSlot.remark());
  if (field != internals.Field)
  {
    internals.FieldSeconds = vtkTimerLog::GetUniversalTime() - start;
    internals.Field = field;
    internals.Kept.reset();
    internals.SamplesPerCell.clear();
    internals.FieldTime.Modified();
    internals.TransferFunction.reset();
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::ShowsVolume() const
{
  return this->BlendMode == vtkVolumeMapper::COMPOSITE_BLEND;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateVertexCache()
{
  Internals& internals = *this->Private;
  const int size = this->ShowsVolume() && !internals.Categories ? this->VertexCacheSize : 0;
  if (!internals.Kept || internals.KeptSize != size)
  {
    internals.Kept.reset(); // before the new one is allocated
    internals.Kept =
      std::make_unique<treeamr::BlockCache>(internals.Field->octree(), static_cast<std::size_t>(size) << 20);
    internals.KeptSize = size;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateTransferFunction(vtkVolume* volume)
{
  Internals& internals = *this->Private;
  vtkVolumeProperty* property = this->ShowsVolume() ? volume->GetProperty() : nullptr;
  if (!internals.TransferFunction || internals.Property != property ||
    internals.PropertyTime != (property ? property->GetMTime() : 0))
  {
    internals.TransferFunction.reset();
    internals.SampleDistances.clear();
    internals.TransferFunctionSeconds = 0.;
    const Stopwatch stopwatch(internals.TransferFunctionSeconds);
    internals.TransferFunction = !property ? treeamr::TransferFunction(0., 1., { {}, {} })
      : internals.Categories ? treeamr::convertCategories(property, internals.Categories->values)
                             : treeamr::convertTransferFunction(property, internals.Field->range());
    internals.Property = property;
    // Asking for functions that were never set has made them.
    internals.PropertyTime = property ? property->GetMTime() : 0;
    internals.TransferFunctionTime.Modified();
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::UpdateIsosurfaces(vtkRenderer* renderer, vtkVolume* volume)
{
  Internals& internals = *this->Private;
  vtkContourValues* contours = volume->GetProperty()->GetIsoSurfaceValues();
  const int count = contours->GetNumberOfContours();
  if (count == 0 || (this->ShowsVolume() && !this->ShowIsosurfaces))
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

//------------------------------------------------------------------------------
treeamr::DraftSettings vtkTreeAMRVolumeMapper::GetDraftSettings() const
{
  return { this->AutoAdjustSampleDistances, this->ImageSampleDistance, this->MinimumImageSampleDistance,
    this->MaximumImageSampleDistance, this->InteractiveRenderTime, this->LevelOfDetail };
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::StartFrame(const Picture& picture)
{
  Internals& internals = *this->Private;
  vtkRenderer* renderer = picture.Renderer;
  vtkVolume* volume = picture.Volume;
  const int pixels = picture.Viewport.Width * picture.Viewport.Height;
  const Frame& last = internals.CurrentFrame;
  const auto measured = internals.SampleDistances.find(last.Of);
  if (measured != internals.SampleDistances.end() && last.RayCastingSeconds > 0.)
  {
    measured->second.record(last.ImageSampleDistance, last.RayCastingSeconds / last.Pixels, last.Interactive);
  }

  Frame frame;
  frame.Of = { renderer, volume };
  frame.Eye = treeamr::eyeOf(renderer);
  frame.Pixels = pixels;
  const treeamr::FramePlan plan = treeamr::planFrame(
    renderer, volume, pixels, this->GetDraftSettings(), internals.SampleDistances[frame.Of]);
  frame.Interactive = plan.isDraft;
  frame.ImageSampleDistance = plan.sampleDistance;
  frame.LevelOfDetail = internals.Categories ? 0. : plan.levelOfDetail;
  frame.SamplesPerCell = this->SamplesPerCell;
  if (!frame.Interactive && (this->EstimateError || this->TargetError > 0.))
  {
    frame.SquaredError = 0.;
    if (this->TargetError > 0.)
    {
      const auto found = internals.SamplesPerCell.find(frame.Of);
      frame.SamplesPerCell =
        treeamr::ErrorTarget(found != internals.SamplesPerCell.end() ? found->second : this->SamplesPerCell)
          .samplesPerCell();
    }
  }
  if (!picture.Actors.isEmpty())
  {
    frame.ImageSampleDistance =
      picture.Actors.chooseSampleDistance(picture.HasVolume ? frame.ImageSampleDistance : 0.);
  }
  internals.CurrentFrame = frame;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::CastRays(
  const treeamr::Camera& camera, const treeamr::RayStops& stops, bool isPart, treeamr::Image& image)
{
  Internals& internals = *this->Private;
  Frame& frame = internals.CurrentFrame;
  treeamr::VolumeSettings settings;
  settings.samplesPerCell = frame.SamplesPerCell;
  settings.skipEmpty = this->SkipEmptySpace || !this->ShowsVolume();
  settings.levelOfDetailPixels = frame.LevelOfDetail;
  const auto render = [&] {
    const Stopwatch stopwatch(frame.RayCastingSeconds);
    frame.Counts += treeamr::renderVolume(
      *internals.Field, *internals.TransferFunction, camera, stops, settings, *internals.Kept, image);
  };
  render();
  if (frame.SquaredError < 0.)
  {
    return;
  }
  double squaredError = 0.;
  treeamr::ErrorTarget target(settings.samplesPerCell);
  const auto estimate = [&] {
    const Stopwatch stopwatch(frame.ErrorSeconds);
    treeamr::ErrorEstimator estimator(
      *internals.Field, *internals.TransferFunction, camera, stops, settings, *internals.Kept, image);
    squaredError = std::pow(estimator.error(), 2);
    return this->TargetError > 0. && target.update(estimator, this->TargetError);
  };
  constexpr int mostRepeats = 2;
  for (int repeats = 0; estimate() && !isPart && repeats < mostRepeats; ++repeats)
  {
    settings.samplesPerCell = frame.SamplesPerCell = target.samplesPerCell();
    render();
  }
  frame.SquaredError += squaredError;
  if (this->TargetError > 0.)
  {
    frame.NextSamplesPerCell = std::max(frame.NextSamplesPerCell, target.samplesPerCell());
    internals.SamplesPerCell[frame.Of] = frame.NextSamplesPerCell;
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::PrepareVolume(vtkRenderer* renderer, vtkVolume* volume)
{
  try
  {
    this->CheckSettings();
    this->UpdateField(volume);
    this->UpdateVertexCache();
    this->UpdateTransferFunction(volume);
    this->UpdateIsosurfaces(renderer, volume);
    return true;
  }
  catch (const std::exception& error)
  {
    this->Private->Messages.error(error);
    return false;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::TraceSurfaces(Picture& picture)
{
  Internals& internals = *this->Private;
  const Frame& frame = internals.CurrentFrame;
  picture.Shaders.emplace();
  treeamr::VolumeSurfaces& own = internals.Surfaces[frame.Eye];
  if (picture.HasVolume && !own.isEmpty())
  {
    const Stopwatch stopwatch(internals.CurrentFrame.RayCastingSeconds);
    treeamr::SurfacePose pose;
    pose.clipFromData = treeamr::clipFromData(picture.Renderer, picture.Volume);
    pose.viewFromData = treeamr::viewFromData(picture.Renderer, picture.Volume);
    pose.width = picture.Viewport.Width;
    pose.height = picture.Viewport.Height;
    pose.layers = treeamr::SurfaceLayers::All;
    pose.cut = picture.Cut;
    treeamr::SurfaceView& view = own.trace(pose, frame.ImageSampleDistance, frame.LevelOfDetail);
    treeamr::SurfaceAppearance appearance;
    appearance.opaque = false;
    appearance.lights = treeamr::convertLights(picture.Renderer);
    appearance.surfaces = treeamr::convertSurfaceMaterials(picture.Volume->GetProperty(),
      own.engine()->isovalues(), this->IsosurfaceOpacityScale, appearance.lights);
    treeamr::SecondaryRays wanted;
    if (picture.Volume->GetProperty()->GetShade(0) && !appearance.lights.empty())
    {
      wanted.occlusionSamples = this->AmbientOcclusionSamples;
      wanted.occlusionRadius =
        this->AmbientOcclusionRadius * view.diagonalOf(internals.Field->octree().grid());
      wanted.shadows = this->Shadows;
      if (treeamr::isInteractive(picture.Renderer))
      {
        wanted.mostNewSamples = vtkTreeAMRIsosurfaceMapper::InteractiveSamples;
      }
    }
    const treeamr::SurfaceVisibility& visibility = view.updateVisibility(wanted, appearance.lights);
    picture.Shaders->emplace_back(
      view.hits(), view.camera(), std::move(appearance), visibility, treeamr::HitColors());
  }
  const std::vector<treeamr::SurfaceShader>& ofActors = picture.Actors.trace(frame.ImageSampleDistance);
  picture.Shaders->insert(picture.Shaders->end(), ofActors.begin(), ofActors.end());
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::Composite(
  Picture& picture, const vtkTreeAMRRaySegments& rays, treeamr::Image& image)
{
  Internals& internals = *this->Private;
  // In data coordinates, as in VTK's own volume mappers: the unit distance takes part in the volume's scale.
  const treeamr::Camera camera(
    treeamr::clipFromData(picture.Renderer, picture.Volume), image.width, image.height);
  const bool isFirst = !picture.Shaders;
  if (isFirst) // the same for the other part of the rays
  {
    this->TraceSurfaces(picture);
  }
  const std::vector<treeamr::SurfaceShader>& shaders = *picture.Shaders;
  if (picture.HasVolume)
  {
    if (isFirst && !shaders.empty())
    {
      const double start = vtkTimerLog::GetUniversalTime();
      treeamr::collectLayers(shaders, camera,
        picture.IsWhole ? std::span<const float>(rays.End) : std::span<const float>(), internals.Layers);
      picture.Actors.recordShading(vtkTimerLog::GetUniversalTime() - start);
    }
    treeamr::RayStops stops = treeamr::RayStops::depths(
      rays.Begin.empty() ? nullptr : rays.Begin.data(), rays.End.empty() ? nullptr : rays.End.data());
    stops.cut = picture.Cut;
    if (!shaders.empty())
    {
      stops.hits = internals.Layers.hits();
    }
    try
    {
      this->CastRays(camera, stops, picture.IsPeeling && !picture.IsWhole, image);
      return;
    }
    catch (const std::exception& error)
    {
      this->Private->Messages.error(error);
    }
  }
  // A volume that fails does not take the actors' surfaces with it.
  if (!shaders.empty())
  {
    const std::vector<float> everything(rays.End.empty() ? image.rgba.size() / 4 : 0, 1.f);
    treeamr::flattenLayers(shaders, rays.End.empty() ? everything : rays.End, image);
  }
}

//------------------------------------------------------------------------------
vtkTreeAMRRayImage vtkTreeAMRVolumeMapper::Trace(Picture& picture, const vtkTreeAMRRaySegments& pixels)
{
  Frame& frame = this->Private->CurrentFrame;
  const treeamr::ImageReduction reduction(
    picture.Viewport.Width, picture.Viewport.Height, frame.ImageSampleDistance);
  vtkTreeAMRRayImage result{ reduction, treeamr::Image(reduction.width(), reduction.height()), {} };
  vtkTreeAMRRaySegments reduced;
  if (!reduction.isFull())
  {
    const Stopwatch stopwatch(frame.CompositingSeconds);
    reduced = pixels.Reduce(reduction);
    result.Lengths = pixels.GetLengths();
  }
  const vtkTreeAMRRaySegments& rays = reduction.isFull() ? pixels : reduced;
  if (!rays.IsEmpty())
  {
    this->Composite(picture, rays, result.Image);
  }
  return result;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::DrawPeeled(Picture& picture)
{
  Internals& internals = *this->Private;
  Frame& frame = internals.CurrentFrame;
  vtkTreeAMRRaySegments front;
  vtkTreeAMRRaySegments back;
  const double start = vtkTimerLog::GetUniversalTime();
  internals.DepthPeeling.Begin(
    picture.Renderer, this, picture.Volume, picture.Viewport.Width, picture.Viewport.Height, front, back);
  const double begun = vtkTimerLog::GetUniversalTime();
  if (internals.DepthPeeling.IsFrameStart())
  {
    this->StartFrame(picture);
  }
  frame.CompositingSeconds += begun - start;
  back.Simplify();
  const vtkTreeAMRRayImage frontImage = this->Trace(picture, front);
  const vtkTreeAMRRayImage backImage = this->Trace(picture, back);
  const Stopwatch stopwatch(frame.CompositingSeconds);
  internals.DepthPeeling.Draw(picture.Renderer, frontImage, backImage);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::DrawOver(Picture& picture)
{
  Internals& internals = *this->Private;
  Frame& frame = internals.CurrentFrame;
  this->StartFrame(picture);
  vtkTreeAMRRaySegments segments;
  {
    const Stopwatch stopwatch(frame.CompositingSeconds);
    vtkTreeAMRDepthReader::Read(picture.Renderer, picture.Viewport, segments.End);
    segments.Simplify();
  }
  const vtkTreeAMRRayImage image = this->Trace(picture, segments);
  const Stopwatch stopwatch(frame.CompositingSeconds);
  internals.Painter.DrawOver(picture.Renderer, image);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::RenderVolume(vtkRenderer* renderer, vtkVolume* volume)
{
  treeamr::TranslucentScene scene = treeamr::findTranslucentScene(renderer);
  const bool isWhole = scene.volume == volume;
  const bool isPeeling = vtkTreeAMRDepthPeeling::IsPeeling(volume);
  if (isWhole && isPeeling && !vtkTreeAMRDepthPeeling::IsFirstStage(this, volume))
  {
    return false; // that one has drawn everything
  }
  if (!isWhole)
  {
    scene.surfaces.clear();
  }
  Picture picture{ renderer, volume, vtkTreeAMRTarget::GetViewport(renderer), isWhole, isPeeling,
    this->PrepareVolume(renderer, volume),
    { treeamr::convertClippingPlanes(this, volume), treeamr::convertCropping(this) },
    { renderer, scene.surfaces, treeamr::SurfaceLayers::All }, {} };
  if (picture.HasVolume || !picture.Actors.isEmpty())
  {
    isPeeling ? this->DrawPeeled(picture) : this->DrawOver(picture);
  }
  return true;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::Render(vtkRenderer* renderer, vtkVolume* volume)
{
  if (renderer->GetSelector())
  {
    return; // as if there were no volume
  }
  this->WarnOfSettings(volume);
  this->InvokeEvent(vtkCommand::VolumeMapperRenderStartEvent, nullptr);
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  bool isRound = true;
  try
  {
    isRound = this->RenderVolume(renderer, volume);
  }
  catch (const std::exception& error)
  {
    this->Private->Messages.error(error);
  }
  if (isRound)
  {
    this->Private->Messages.endErrors();
    this->Private->Messages.endWarnings();
  }
  timer->StopTimer();
  this->TimeToDraw = timer->GetElapsedTime();
  this->InvokeEvent(vtkCommand::VolumeMapperRenderEndEvent, nullptr);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Private->Painter.ReleaseGraphicsResources(window);
  this->Private->DepthPeeling.ReleaseGraphicsResources(window);
}

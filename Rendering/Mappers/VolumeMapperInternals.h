// What a volume mapper keeps, and what a call of its Render() draws. Private to the module.
#pragma once

#include "MapperInput.h"
#include "MapperMessages.h"
#include "SurfaceShading.h"
#include "TranslucentScene.h"
#include "VolumeOrder.h"
#include "VolumeRelay.h"
#include "VolumeSurfaces.h"
#include "vtkTreeAMRDepthPeeling.h"
#include "vtkTreeAMRImagePainter.h"
#include "vtkTreeAMRTarget.h"
#include "vtkTreeAMRVolumeMapper.h"

#include "Geometry/RayStops.h"
#include "Volume/Volume.h"

#include "vtkNew.h"
#include "vtkTable.h"
#include "vtkTimeStamp.h"
#include "vtkTimerLog.h"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

class vtkRenderer;
class vtkVolume;
class vtkVolumeProperty;

namespace treeamr
{

/// What a frame did. Depth peeling draws one in many parts.
struct VolumeFrame
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
  bool IsRecorded = false; // for the drafts to come
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

} // namespace treeamr

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

  std::shared_ptr<const treeamr::Field> Field; // that rays see
  treeamr::FieldSlot OpacitySlot;
  std::shared_ptr<const treeamr::Field> OpacityField; // that makes them opaque then; null: the same
  vtkTreeAMRVolumeMapper::Components Drawn = vtkTreeAMRVolumeMapper::Components::One;
  std::array<treeamr::FieldSlot, 3> ComponentSlots;
  /// Of RGBA the colours, of independent ones those after the first; the same octree's.
  std::vector<std::shared_ptr<const treeamr::Field>> OtherComponents;
  bool ReadsTable = false; // of the property's function of two values
  treeamr::FieldSlot TableSlot;
  std::shared_ptr<const treeamr::Field>
    TableField; // whose value is the second one; null: the gradient's length is
  std::array<double, 4> TableRange{};
  std::optional<std::array<double, 4>> AgreedRange;      // of all processes
  std::shared_ptr<const treeamr::Categories> Categories; // whose numbers it is; null: it is the array's
  vtkTimeStamp FieldTime;
  double FieldSeconds = 0.;
  // Of this field, with the functions of this property at this time; without a property transparent.
  std::optional<treeamr::Volume> Volume;
  vtkVolumeProperty* Property = nullptr; // not dereferenced
  vtkMTimeType PropertyTime = 0;
  treeamr::VolumeSettings Effects; // of this frame
  vtkTimeStamp TransferFunctionTime;
  double TransferFunctionSeconds = 0.;
  std::array<treeamr::VolumeSurfaces, 2> Surfaces; // of the field, seen by each eye
  vtkTimeStamp SurfaceTime;
  treeamr::CollectedLayers Layers; // of these and of the actors that are drawn with the volume

  std::shared_ptr<treeamr::BoxPeers> Peers; // null: nobody
  bool MayGather = false;                   // the frame to come, for which its pixels may be larger than the window's
  treeamr::VolumeFrame CurrentFrame;
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
  treeamr::Progress* Progress;                                // null: none follows
  treeamr::VolumeRelay* Relay;                                // null: the volume is by itself
  std::optional<std::vector<treeamr::SurfaceShader>> Shaders; // once they are traced, the mapper's own first
};

//------------------------------------------------------------------------------
// Of several volumes in one view, nearest first: all with one distance between rays.
struct vtkTreeAMRVolumeMapper::Pictures
{
  treeamr::VolumeOrder Order;
  std::vector<std::unique_ptr<Picture>> Volumes; // without those that failed

  bool areLayered() const { return this->Order.overlaps() && this->Order.isLayered; }
};

// How a volume mapper draws: the frame's plan, its rays, and the ways into the window.
#include "FramePlan.h"
#include "FrameWatch.h"
#include "SampleDistance.h"
#include "SceneConversion.h"
#include "VolumeEffects.h"
#include "VolumeLayers.h"
#include "VolumeMapperInternals.h"
#include "VolumeOrder.h"
#include "vtkTreeAMRDepthReader.h"
#include "vtkTreeAMRIsosurfaceMapper.h"

#include "Error.h"
#include "Volume/ErrorEstimate.h"

#include "vtkCommand.h"
#include "vtkHardwareSelector.h"
#include "vtkMultiVolume.h"
#include "vtkRenderer.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <span>

//------------------------------------------------------------------------------
vtkTreeAMRVolumeMapper* vtkTreeAMRVolumeMapper::MapperOf(const Picture& picture)
{
  return static_cast<vtkTreeAMRVolumeMapper*>(picture.Volume->GetMapper());
}

//------------------------------------------------------------------------------
treeamr::DraftSettings vtkTreeAMRVolumeMapper::GetDraftSettings() const
{
  return { this->AutoAdjustSampleDistances, this->ImageSampleDistance, this->MinimumImageSampleDistance,
    this->MaximumImageSampleDistance, this->InteractiveRenderTime, this->LevelOfDetail };
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::RecordLastFrame()
{
  Internals& internals = *this->Private;
  treeamr::VolumeFrame& last = internals.CurrentFrame;
  const auto measured = internals.SampleDistances.find(last.Of);
  if (measured != internals.SampleDistances.end() && last.RayCastingSeconds > 0. && !last.IsRecorded)
  {
    measured->second.record(last.ImageSampleDistance, last.RayCastingSeconds / last.Pixels, last.Interactive);
    last.IsRecorded = true;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::AgreeOnDrafts(
  vtkRenderer* renderer, vtkVolume* volume, const std::function<void(std::array<double, 3>&)>& largest)
{
  this->RecordLastFrame();
  this->Private->SampleDistances[{ renderer, volume }].agree(largest);
  this->Private->MayGather = this->AutoAdjustSampleDistances
    ? treeamr::isInteractive(renderer) || this->MinimumImageSampleDistance > 1.
    : this->ImageSampleDistance > 1.;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SetPeers(std::shared_ptr<treeamr::BoxPeers> peers)
{
  this->Private->Peers = std::move(peers);
}

//------------------------------------------------------------------------------
double vtkTreeAMRVolumeMapper::GetFrameSamplesPerCell(vtkVolume* volume)
{
  const auto& field = this->Private->Field;
  if (!(this->SampleDistance > 0.) || this->LockSampleDistanceToInputSpacing || !field)
  {
    return this->SamplesPerCell;
  }
  const double samples = treeamr::samplesPerCellFor(this->SampleDistance, field->octree(), volume);
  return std::clamp(samples, FewestSamplesPerCell, MostSamplesPerCell);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::StartFrame(const Picture& picture)
{
  Internals& internals = *this->Private;
  vtkRenderer* renderer = picture.Renderer;
  vtkVolume* volume = picture.Volume;
  const int pixels = picture.Viewport.Width * picture.Viewport.Height;
  this->RecordLastFrame();

  treeamr::VolumeFrame frame;
  frame.Of = { renderer, volume };
  frame.Eye = treeamr::eyeOf(renderer);
  frame.Pixels = pixels;
  const treeamr::FramePlan plan = treeamr::planFrame(
    renderer, volume, pixels, this->GetDraftSettings(), internals.SampleDistances[frame.Of]);
  frame.Interactive = plan.isDraft;
  frame.ImageSampleDistance = plan.sampleDistance;
  frame.LevelOfDetail = internals.Categories ? 0. : plan.levelOfDetail;
  frame.SamplesPerCell = this->GetFrameSamplesPerCell(volume);
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
  const treeamr::RayView& view, bool isPart, treeamr::BoxRelay* relay, treeamr::Image& image)
{
  Internals& internals = *this->Private;
  treeamr::VolumeFrame& frame = internals.CurrentFrame;
  treeamr::VolumeSettings settings = internals.Effects;
  settings.samplesPerCell = frame.SamplesPerCell;
  settings.skipEmpty = this->SkipEmptySpace || !this->ShowsVolume();
  settings.levelOfDetailPixels = frame.LevelOfDetail;
  const auto render = [&] {
    const treeamr::Stopwatch stopwatch(frame.RayCastingSeconds);
    frame.Counts += relay ? internals.Volume->render(view, settings, image, *relay)
                          : internals.Volume->render(view, settings, image);
  };
  render();
  if (frame.SquaredError < 0.)
  {
    return;
  }
  double squaredError = 0.;
  treeamr::ErrorTarget target(settings.samplesPerCell);
  const auto estimate = [&] {
    const treeamr::Stopwatch stopwatch(frame.ErrorSeconds);
    treeamr::ErrorEstimator estimator(*internals.Volume, view, settings, image,
      this->TargetError > 0. ? treeamr::EstimateEffort::Thorough : treeamr::EstimateEffort::Quick);
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
    this->UpdateVolume(volume);
    this->Private->Effects = treeamr::convertVolumeEffects(
      renderer, volume, this, this->Private->Volume->field(), this->GetComponentOfUnitDistance());
    if (this->Private->Effects.shading && this->VolumetricScatteringBlending > 0.f &&
      this->Private->Volume->canScatter())
    {
      this->Private->Effects.shading->scattering =
        treeamr::convertScattering(volume->GetProperty(), this->Private->Volume->field(),
          this->VolumetricScatteringBlending, this->GlobalIlluminationReach, this->SampleDistance);
    }
    if (this->Private->Effects.shading && this->Private->Drawn == Components::Independent)
    {
      const int others = static_cast<int>(this->Private->OtherComponents.size());
      for (int component = 1; component <= others; ++component)
      {
        this->Private->Effects.componentShading.push_back(
          *treeamr::convertVolumeShading(renderer, volume, component));
      }
    }
    this->UpdateIsosurfaces(renderer, volume);
    return true;
  }
  catch (const std::exception& error)
  {
    this->Private->Messages.error(error);
    this->Private->CurrentFrame = treeamr::VolumeFrame(); // no figures of a frame before
    return false;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::TraceSurfaces(Picture& picture)
{
  Internals& internals = *this->Private;
  const treeamr::VolumeFrame& frame = internals.CurrentFrame;
  picture.Shaders.emplace();
  treeamr::VolumeSurfaces& own = internals.Surfaces[frame.Eye];
  if (picture.HasVolume && !own.isEmpty())
  {
    const treeamr::Stopwatch stopwatch(internals.CurrentFrame.RayCastingSeconds);
    treeamr::SurfacePose pose;
    pose.clipFromData = treeamr::clipFromData(picture.Renderer, picture.Volume);
    pose.viewFromData = treeamr::viewFromData(picture.Renderer, picture.Volume);
    pose.width = picture.Viewport.Width;
    pose.height = picture.Viewport.Height;
    pose.layers = treeamr::SurfaceLayers::All;
    const bool shaded = picture.Volume->GetProperty()->GetShade(0) || this->ShadeIsosurfaces;
    pose.normals = shaded ? treeamr::SurfaceNormals::Smooth : treeamr::SurfaceNormals::None;
    pose.cut = picture.Cut;
    treeamr::SurfaceView& view =
      own.trace(pose, frame.ImageSampleDistance, frame.LevelOfDetail, picture.Progress);
    treeamr::SurfaceAppearance appearance;
    appearance.opaque = false;
    appearance.lights = treeamr::convertLights(picture.Renderer);
    appearance.surfaces = treeamr::convertSurfaceMaterials(picture.Volume->GetProperty(),
      own.engine()->isovalues(), this->IsosurfaceOpacityScale, shaded, appearance.lights);
    treeamr::SecondaryRays wanted;
    if (shaded && !appearance.lights.empty())
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
    const treeamr::SurfaceVisibility& visibility =
      view.updateVisibility(wanted, appearance.lights, picture.Progress);
    picture.Shaders->emplace_back(
      view.hits(), view.camera(), std::move(appearance), visibility, treeamr::HitColors());
  }
  const std::vector<treeamr::SurfaceShader>& ofActors = picture.Actors.trace(frame.ImageSampleDistance);
  picture.Shaders->insert(picture.Shaders->end(), ofActors.begin(), ofActors.end());
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::Composite(
  Picture& picture, const vtkTreeAMRRaySegments& rays, const treeamr::ImagePart& part, treeamr::Image& image)
{
  Internals& internals = *this->Private;
  // In data coordinates, as in VTK's own volume mappers: the unit distance takes part in the volume's scale.
  const treeamr::Matrix4 clipFromData = treeamr::clipFromData(picture.Renderer, picture.Volume);
  const treeamr::Camera camera(part.clip(clipFromData), part.width, part.height);
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
      treeamr::collectLayers(shaders, treeamr::Camera(clipFromData, part.imageWidth, part.imageHeight),
        picture.IsWhole ? std::span<const float>(rays.End) : std::span<const float>(), internals.Layers);
      picture.Actors.recordShading(vtkTimerLog::GetUniversalTime() - start);
    }
    treeamr::RayStops stops = treeamr::RayStops::depths(
      rays.Begin.empty() ? nullptr : rays.Begin.data(), rays.End.empty() ? nullptr : rays.End.data());
    stops.cut = picture.Cut;
    std::optional<treeamr::HitsOfPart> hits;
    if (!shaders.empty())
    {
      stops.hits = internals.Layers.hits();
      if (!part.isWhole())
      {
        hits.emplace(*stops.hits, part);
        stops.hits = { hits->first, hits->hits };
      }
    }
    // Estimates of errors are of whole rays. Values have no part in translucent scenes.
    const bool isAlone = picture.IsWhole || (treeamr::blendsValues(this) && !picture.IsPeeling);
    const bool isFull = image.width == picture.Viewport.Width && image.height == picture.Viewport.Height;
    const bool canRelay = picture.Relay && isAlone && part.isWhole() && (isFull || internals.MayGather) &&
      internals.CurrentFrame.SquaredError < 0.;
    const treeamr::Field& field = internals.Volume->field();
    const std::array<double, 4> alike{ field.range().min, field.range().max, field.offset(),
      static_cast<double>(internals.Effects.blend) }; // what values are told in
    const treeamr::BoxRelay::Terms terms{ alike,
      internals.Effects.blend == treeamr::VolumeBlend::Slice, stops.hits ? &*stops.hits : nullptr };
    const treeamr::Camera ofViewport(clipFromData, picture.Viewport.Width, picture.Viewport.Height);
    treeamr::BoxRelay* const relay =
      canRelay ? picture.Relay->begin(ofViewport, stops.endDepth, image, terms) : nullptr;
    if (relay && relay->box())
    {
      stops.cut.halfSpaces = treeamr::convertClippingPlanes(this, picture.Volume); // no faces of boxes
    }
    try
    {
      this->CastRays(
        { camera, stops, picture.Progress }, picture.IsPeeling && !picture.IsWhole, relay, image);
      return;
    }
    catch (const treeamr::Interrupted&)
    {
      if (relay)
      {
        picture.Relay->giveUp(false);
      }
      throw;
    }
    catch (const std::exception& error)
    {
      this->Private->Messages.error(error);
    }
    if (relay)
    {
      picture.Relay->giveUp(true);
      return;
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
  treeamr::VolumeFrame& frame = this->Private->CurrentFrame;
  const treeamr::ImageReduction reduction(
    picture.Viewport.Width, picture.Viewport.Height, frame.ImageSampleDistance);
  vtkTreeAMRRayImage result{ reduction, treeamr::Image(reduction.width(), reduction.height()), {} };
  vtkTreeAMRRaySegments reduced;
  if (!reduction.isFull())
  {
    const treeamr::Stopwatch stopwatch(frame.CompositingSeconds);
    reduced = pixels.Reduce(reduction);
    result.Lengths = pixels.GetLengths();
  }
  const vtkTreeAMRRaySegments& rays = reduction.isFull() ? pixels : reduced;
  if (!rays.IsEmpty())
  {
    this->Composite(picture, rays, { reduction.width(), reduction.height() }, result.Image);
    treeamr::applyColorWindow(this->FinalColorWindow, this->FinalColorLevel, result.Image);
  }
  return result;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::StartFrames(const Pictures& pictures)
{
  double distance = 0.;
  for (const std::unique_ptr<Picture>& picture : pictures.Volumes)
  {
    vtkTreeAMRVolumeMapper* mapper = MapperOf(*picture);
    mapper->StartFrame(*picture);
    treeamr::VolumeFrame& frame = mapper->Private->CurrentFrame;
    frame.SquaredError = pictures.areLayered() ? -1. : frame.SquaredError; // estimates are of whole rays
    distance = distance == 0. ? frame.ImageSampleDistance
      : frame.Interactive     ? std::max(distance, frame.ImageSampleDistance)
                              : std::min(distance, frame.ImageSampleDistance);
  }
  for (const std::unique_ptr<Picture>& picture : pictures.Volumes)
  {
    MapperOf(*picture)->Private->CurrentFrame.ImageSampleDistance = distance;
  }
}

//------------------------------------------------------------------------------
vtkTreeAMRRayImage vtkTreeAMRVolumeMapper::TraceAll(
  const Pictures& pictures, const vtkTreeAMRRaySegments& pixels)
{
  if (pictures.areLayered())
  {
    return this->TraceLayers(pictures, pixels);
  }
  std::optional<vtkTreeAMRRayImage> all;
  for (const std::unique_ptr<Picture>& picture : pictures.Volumes)
  {
    PrepareShared(pictures, *picture);
    vtkTreeAMRRayImage image = MapperOf(*picture)->Trace(*picture, pixels);
    if (all)
    {
      treeamr::putBehind(image.Image, all->Image);
    }
    else
    {
      all.emplace(std::move(image));
    }
  }
  return std::move(*all);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::DrawPeeled(const Pictures& pictures)
{
  Internals& internals = *this->Private;
  treeamr::VolumeFrame& frame = internals.CurrentFrame;
  const Picture& own = *pictures.Volumes.front();
  vtkTreeAMRRaySegments front;
  vtkTreeAMRRaySegments back;
  const double start = vtkTimerLog::GetUniversalTime();
  internals.DepthPeeling.Begin(
    own.Renderer, this, own.Volume, own.Viewport.Width, own.Viewport.Height, front, back);
  const double begun = vtkTimerLog::GetUniversalTime();
  if (internals.DepthPeeling.IsFrameStart())
  {
    this->StartFrames(pictures);
  }
  frame.CompositingSeconds += begun - start;
  back.Simplify();
  std::optional<vtkTreeAMRRayImage> frontImage;
  if (!front.IsEmpty())
  {
    frontImage = this->TraceAll(pictures, front);
  }
  const vtkTreeAMRRayImage backImage = this->TraceAll(pictures, back);
  const treeamr::Stopwatch stopwatch(frame.CompositingSeconds);
  internals.DepthPeeling.Draw(own.Renderer, frontImage ? &*frontImage : nullptr, backImage);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::DrawOver(const Pictures& pictures)
{
  Internals& internals = *this->Private;
  treeamr::VolumeFrame& frame = internals.CurrentFrame;
  const Picture& own = *pictures.Volumes.front();
  this->StartFrames(pictures);
  vtkTreeAMRRaySegments segments;
  {
    const treeamr::Stopwatch stopwatch(frame.CompositingSeconds);
    vtkTreeAMRDepthReader::Read(own.Renderer, own.Viewport, segments.End);
    segments.Simplify();
  }
  const vtkTreeAMRRayImage image = this->TraceAll(pictures, segments);
  const treeamr::Stopwatch stopwatch(frame.CompositingSeconds);
  internals.Painter.DrawOver(own.Renderer, image);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeMapper::RenderVolume(
  vtkRenderer* renderer, vtkVolume* volume, treeamr::VolumeRelay& relay, treeamr::Progress* progress)
{
  if (vtkMultiVolume::SafeDownCast(volume))
  {
    throw treeamr::Error(
      "volume mapper: in a vtkMultiVolume, needed is a vtkVolume of its own for each grid");
  }
  Pictures pictures{ treeamr::orderVolumes(renderer), {} };
  treeamr::VolumeOrder& order = pictures.Order;
  if (order.volumes.size() < 2 ||
    std::find(order.volumes.begin(), order.volumes.end(), volume) == order.volumes.end())
  {
    order = { { volume }, { {} }, volume };
  }
  treeamr::TranslucentScene scene = treeamr::findTranslucentScene(renderer);
  const bool isWhole = scene.volume == volume && order.volumes.size() == 1;
  const bool isPeeling = vtkTreeAMRDepthPeeling::IsPeeling(volume);
  if (order.first != volume || (isWhole && isPeeling && !vtkTreeAMRDepthPeeling::IsFirstStage(this, volume)))
  {
    return false; // that one, or that stage, draws everything
  }
  if (order.overlaps() && !order.isLayered)
  {
    this->Private->Messages.warning({ "overlap",
      "Two volumes of one view overlap, one of which blends values: each is drawn as a whole, that whose "
      "centre "
      "is nearer before the other." });
  }
  if (pictures.areLayered() && (this->EstimateError || this->TargetError > 0.))
  {
    this->Private->Messages.warning({ "overlap of estimates",
      "EstimateError and TargetError: no error is estimated of volumes that overlap others." });
  }
  if (isPeeling && this->Private->Peers && treeamr::blendsValues(this))
  {
    this->Private->Messages.warning({ "peeled values",
      "BlendMode: beside translucent surfaces each of several processes shows its own values, those before the "
      "others'. One process draws them right." });
  }
  if (!isWhole)
  {
    scene.surfaces.clear();
  }
  for (vtkVolume* shown : order.volumes)
  {
    auto* mapper = static_cast<vtkTreeAMRVolumeMapper*>(shown->GetMapper());
    treeamr::DataCut cut = treeamr::cutOf(mapper, shown);
    cut.cropping = treeamr::convertCropping(mapper);
    if (cut.cropping && cut.cropping->hasNoMiddle())
    {
      mapper->Private->Messages.warning({ "cropping",
        "CroppingRegionPlanes: along an axis the lower plane is not below the upper one, so that nothing is "
        "between them" });
    }
    std::unique_ptr<Picture> picture(new Picture{ renderer, shown, vtkTreeAMRTarget::GetViewport(renderer),
      isWhole, isPeeling, mapper->PrepareVolume(renderer, shown), std::move(cut),
      { renderer, scene.surfaces, treeamr::SurfaceLayers::All, progress }, progress,
      order.volumes.size() == 1 ? &relay : nullptr, {} });
    if (picture->HasVolume || !picture->Actors.isEmpty())
    {
      pictures.Volumes.push_back(std::move(picture));
    }
  }
  if (!pictures.Volumes.empty())
  {
    isPeeling ? this->DrawPeeled(pictures) : this->DrawOver(pictures);
  }
  return true;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::Render(vtkRenderer* renderer, vtkVolume* volume)
{
  if (vtkHardwareSelector* selector = renderer->GetSelector())
  {
    if (selector->GetActorPassOnly())
    {
      this->SelectProp(renderer, volume);
    }
    return; // of cells and points as if there were no volume
  }
  if (treeamr::FrameWatch::isReporting())
  {
    this->Private->Messages.unsupported({ treeamr::nestedFrames });
  }
  this->WarnOfSettings(volume);
  this->InvokeEvent(vtkCommand::VolumeMapperRenderStartEvent, nullptr);
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  bool isRound = true;
  treeamr::FrameWatch watch(
    renderer, this, this->ReportProgress, vtkCommand::VolumeMapperRenderProgressEvent);
  try
  {
    // Of a frame that is peeled the first stage draws everything, or processes do not draw as one.
    const bool isFirst =
      !vtkTreeAMRDepthPeeling::IsPeeling(volume) || vtkTreeAMRDepthPeeling::IsFirstStage(this, volume);
    treeamr::VolumeRelay relay(
      isFirst ? this->Private->Peers.get() : nullptr, this->GetHyperTreeGrid(), renderer, volume);
    isRound = watch.canDraw() && this->RenderVolume(renderer, volume, relay, watch.progress());
    relay.end();
  }
  catch (const treeamr::Interrupted&)
  {
    isRound = false;
    this->Private->CurrentFrame = treeamr::VolumeFrame(); // nothing of it is drawn or counts
    for (vtkVolume* shown : treeamr::orderVolumes(renderer).volumes)
    {
      static_cast<vtkTreeAMRVolumeMapper*>(shown->GetMapper())->Private->CurrentFrame =
        treeamr::VolumeFrame();
    }
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

// How an isosurface mapper draws: its views, their hits and light, and the ways into the window.
#include "FrameWatch.h"
#include "ImageReduction.h"
#include "IsosurfaceMapperInternals.h"
#include "RenderPasses.h"
#include "SceneConversion.h"
#include "SurfaceSelection.h"
#include "SurfaceShading.h"
#include "TranslucentScene.h"
#include "UnsupportedSettings.h"
#include "vtkTreeAMRDepthReader.h"
#include "vtkTreeAMRTarget.h"

#include "Error.h"

#include "vtkActor.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHardwareSelector.h"
#include "vtkHyperTreeGrid.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkTimerLog.h"

#include <cmath>
#include <limits>
#include <utility>

namespace
{

constexpr std::size_t allLayers = std::numeric_limits<std::size_t>::max();

/// How many layers of an opacity let light through that 8 bits could show.
std::size_t layersBeforeOpaque(double opacity)
{
  if (!(opacity > 0.))
  {
    return allLayers;
  }
  constexpr double nothing = 1. / 512.;
  return opacity >= 1. ? 1 : static_cast<std::size_t>(std::ceil(std::log(nothing) / std::log1p(-opacity)));
}

} // anonymous namespace

//------------------------------------------------------------------------------
treeamr::SurfaceActorView& vtkTreeAMRIsosurfaceMapper::Internals::ViewOf(
  vtkMapper* self, vtkRenderer* renderer, vtkActor* actor)
{
  using View = treeamr::SurfaceActorView;
  std::erase_if(this->Views, [self](const std::unique_ptr<View>& view) {
    return !view->renderer || !view->actor || view->actor->GetMapper() != self;
  });
  const int eye = treeamr::eyeOf(renderer);
  for (const std::unique_ptr<View>& view : this->Views)
  {
    if (view->renderer == renderer && view->actor == actor && view->eye == eye)
    {
      return *view;
    }
  }
  this->Views.push_back(std::make_unique<View>(renderer, actor, eye, [this] {
    if (this->ErrorsAreOfThisFrame) // the first of all views to be told
    {
      this->Messages.endErrors();
      this->ErrorsAreOfThisFrame = false;
    }
  }));
  return *this->Views.back();
}

//------------------------------------------------------------------------------
treeamr::SurfaceActorView& vtkTreeAMRIsosurfaceMapper::FindView(
  vtkRenderer* renderer, vtkActor* actor, treeamr::SurfaceLayers layers)
{
  treeamr::SurfaceActorView& view = this->Private->ViewOf(this, renderer, actor);
  this->Private->ErrorsAreOfThisFrame = true;
  const vtkTreeAMRViewport viewport = vtkTreeAMRTarget::GetViewport(renderer);
  treeamr::SurfacePose& pose = view.pose;
  pose.width = viewport.Width;
  pose.height = viewport.Height;
  pose.clipFromData = treeamr::clipFromData(renderer, actor);
  pose.viewFromData = treeamr::viewFromData(renderer, actor);
  pose.cut = treeamr::cutOf(this, actor);
  if (pose.layers != layers)
  {
    view.sampleDistances = {};
  }
  pose.layers = layers;
  vtkProperty* property = actor->GetProperty();
  pose.normals = property->GetLighting() && property->GetInterpolation() != VTK_FLAT
    ? treeamr::SurfaceNormals::Smooth
    : treeamr::SurfaceNormals::None;
  // Translucent colours may let light through anywhere.
  pose.mostHits = layers == treeamr::SurfaceLayers::Nearest || this->HasTranslucentPolygonalGeometry()
    ? allLayers
    : layersBeforeOpaque(property->GetOpacity());
  return view;
}

//------------------------------------------------------------------------------
treeamr::MapperMessages& vtkTreeAMRIsosurfaceMapper::GetMessages()
{
  return this->Private->Messages;
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::UpdateSurface(treeamr::SurfaceActorView& view)
{
  this->UpdateSurface(this->UpdateInput());
  // Now a picture of what has changed is none to keep.
  view.plan =
    treeamr::planFrame(view.renderer, view.actor, static_cast<double>(view.pose.width) * view.pose.height,
      { this->AutoAdjustSampleDistances, this->ImageSampleDistance, this->MinimumImageSampleDistance,
        this->MaximumImageSampleDistance, this->InteractiveRenderTime, this->LevelOfDetail },
      view.sampleDistances, view.surface.isOf(view.pose) ? view.surface.sampleDistance() : 0.);
  return !this->Private->Surfaces.isEmpty();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::UpdateHits(
  treeamr::SurfaceActorView& view, double distance, treeamr::Progress* progress)
{
  // Draft or not: a still camera loses nothing, and takes no time while something else moves.
  if (view.surface.isOf(view.pose) && view.surface.sampleDistance() == distance &&
    (view.plan.isDraft || view.surface.surface() == this->Private->Surfaces.madeInFull()))
  {
    return;
  }
  view.pictureIsOfThisFrame = false;
  view.colorFields.clear();
  const double start = vtkTimerLog::GetUniversalTime();
  view.surface.trace(this->Private->Surfaces, view.pose, distance, view.plan.levelOfDetail, progress);
  view.seconds = vtkTimerLog::GetUniversalTime() - start;
}

//------------------------------------------------------------------------------
treeamr::SurfaceShader vtkTreeAMRIsosurfaceMapper::Light(
  treeamr::SurfaceActorView& view, treeamr::Progress* progress)
{
  Internals& internals = *this->Private;
  vtkProperty* property = view.actor->GetProperty();
  treeamr::SurfaceAppearance appearance;
  appearance.lights = treeamr::convertLights(view.renderer);
  const bool lit = treeamr::isLit(property, appearance.lights);
  appearance.material = treeamr::convertMaterial(property, lit);
  appearance.opaque = view.pose.layers == treeamr::SurfaceLayers::Nearest;
  appearance.opacity = appearance.opaque ? 1.f : static_cast<float>(property->GetOpacity());
  appearance.flat = property->GetInterpolation() == VTK_FLAT;
  appearance.ambientOfColors =
    static_cast<float>(lit ? property->GetAmbient() : property->GetAmbient() + property->GetDiffuse());
  appearance.diffuseOfColors = static_cast<float>(lit ? property->GetDiffuse() : 0.);
  static const treeamr::SurfaceVisibility everywhere;
  const treeamr::SurfaceVisibility* visibility = &everywhere;
  if (property->GetLighting())
  {
    treeamr::SecondaryRays wanted;
    wanted.occlusionSamples = this->AmbientOcclusionSamples;
    wanted.occlusionRadius =
      this->AmbientOcclusionRadius * view.surface.diagonalOf(internals.Field->octree().grid());
    wanted.mostNewSamples = view.plan.isInteractive ? InteractiveSamples : this->AmbientOcclusionSamples;
    wanted.shadows = this->Shadows;
    visibility = &view.surface.updateVisibility(wanted, appearance.lights, progress);
  }

  treeamr::HitColors colors;
  this->Private->Messages.warning(internals.ContourSlot.remark());
  try
  {
    colors =
      internals.Coloring.map(this, internals.Messages, view, this->GetHyperTreeGrid(), internals.Contoured);
  }
  catch (const treeamr::Error& error)
  {
    this->Private->Messages.warning({ error.what(), error.what() });
  }
  internals.Messages.endWarnings();
  return { view.surface.hits(), view.surface.camera(), std::move(appearance), *visibility,
    std::move(colors) };
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::AgreeOnDrafts(
  vtkRenderer* renderer, vtkActor* actor, const std::function<void(std::array<double, 3>&)>& largest)
{
  this->Private->ViewOf(this, renderer, actor).sampleDistances.agree(largest);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::RecordFrame(treeamr::SurfaceActorView& view, double shadingSeconds)
{
  if (view.seconds >= 0.)
  {
    const double pixels = static_cast<double>(view.pose.width) * view.pose.height;
    view.sampleDistances.record(
      view.surface.sampleDistance(), (view.seconds + shadingSeconds) / pixels, view.plan.isInteractive);
    view.seconds = -1.;
  }
  this->Private->LastSampleDistance = view.surface.sampleDistance();
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::ReadDepthToFlatten(
  const treeamr::SurfaceActorView& view, bool hasAll, std::vector<float>& depth)
{
  Internals& internals = *this->Private;
  if (view.pose.layers == treeamr::SurfaceLayers::Nearest)
  {
    return false;
  }
  if (!treeamr::isDepthPeeling(view.actor))
  {
    // VTK's order independent pass would average layers.
    vtkTreeAMRDepthReader::Read(view.renderer, vtkTreeAMRTarget::GetViewport(view.renderer), depth);
    return true;
  }
  // Each peel draws all layers: where nothing can lie between them, one is the same.
  return hasAll &&
    internals.DepthPeeling.ReadOpaqueDepth(
      view.renderer, this, view.actor, view.pose.width, view.pose.height, depth);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::MakePicture(treeamr::SurfaceActorView& view,
  const std::vector<vtkActor*>& actors, bool hasAll, treeamr::Progress* progress)
{
  Internals& internals = *this->Private;
  vtkTreeAMRSurfaceImage& image = internals.Image;
  const bool geometry = treeamr::wantsGeometry(view.actor);
  treeamr::ActorLayers layers(view.renderer, actors, view.pose.layers, progress);
  const double distance = layers.chooseSampleDistance(0.);
  const std::vector<treeamr::SurfaceShader>& shaders = layers.trace(distance);
  const treeamr::ImageReduction reduction(view.pose.width, view.pose.height, distance);
  const double start = vtkTimerLog::GetUniversalTime();
  std::vector<float> depth;
  image.NumberOfTiles = 0;
  if (!shaders.empty() && this->ReadDepthToFlatten(view, hasAll, depth))
  {
    treeamr::flattenLayers(
      shaders, reduction.isFull() ? depth : reduction.sample(depth), !reduction.isFull(), image);
  }
  else if (!shaders.empty())
  {
    treeamr::shadeHits(shaders.front(), !reduction.isFull(), image);
    if (geometry)
    {
      treeamr::placeHits(shaders.front().hits(), shaders.front().camera(), image);
    }
  }
  view.picture.Upload(vtkTreeAMRTarget::GetWindow(view.renderer), reduction, image, geometry);
  view.picturePose = view.pose;
  view.pictureIsOfThisFrame = true;
  layers.recordShading(vtkTimerLog::GetUniversalTime() - start);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::RenderSurface(
  vtkRenderer* renderer, vtkActor* actor, treeamr::Progress* progress)
{
  Internals& internals = *this->Private;
  internals.Messages.unsupported(treeamr::unsupportedSettings(actor, this));
  const bool translucent = actor->IsRenderingTranslucentPolygonalGeometry();
  std::vector<vtkActor*> actors{ actor };
  bool hasAll = false; // of what is translucent
  if (translucent)
  {
    treeamr::TranslucentScene scene = treeamr::findTranslucentScene(renderer);
    hasAll = scene.has(actor);
    if (hasAll && (scene.isDrawnAsVolume || scene.drawer != actor))
    {
      return; // another draws it, or this one later
    }
    if (hasAll)
    {
      actors = std::move(scene.surfaces);
    }
  }
  treeamr::SurfaceActorView& view = this->FindView(
    renderer, actor, translucent ? treeamr::SurfaceLayers::All : treeamr::SurfaceLayers::Nearest);
  if (renderer->GetSelector())
  {
    if (this->UpdateSurface(view))
    {
      this->UpdateHits(view, view.plan.sampleDistance, progress);
      this->Select(view);
    }
    return;
  }
  if (!view.pictureIsOfThisFrame || view.picturePose != view.pose ||
    view.picture.HasGeometry() != treeamr::wantsGeometry(actor))
  {
    this->MakePicture(view, actors, hasAll, progress);
  }
  internals.Painter.Draw(renderer, actor, this, view.picture);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::DrawLayers(
  vtkRenderer* renderer, vtkActor* actor, treeamr::Progress* progress)
{
  Internals& internals = *this->Private;
  const treeamr::TranslucentScene scene = treeamr::findTranslucentScene(renderer);
  const bool isPeeling = vtkTreeAMRDepthPeeling::IsPeeling(actor);
  const vtkTreeAMRViewport viewport = vtkTreeAMRTarget::GetViewport(renderer);
  std::vector<float> depth;
  if (isPeeling) // but there is nothing to peel
  {
    internals.DepthPeeling.BeginWithoutPeels(
      renderer, internals.StandIn, actor, viewport.Width, viewport.Height, depth);
  }
  else
  {
    vtkTreeAMRDepthReader::Read(renderer, viewport, depth);
  }
  treeamr::ActorLayers layers(renderer, scene.surfaces, treeamr::SurfaceLayers::All, progress);
  const double distance = layers.chooseSampleDistance(0.);
  const std::vector<treeamr::SurfaceShader>& shaders = layers.trace(distance);
  if (shaders.empty())
  {
    return;
  }
  const double start = vtkTimerLog::GetUniversalTime();
  const treeamr::ImageReduction reduction(viewport.Width, viewport.Height, distance);
  vtkTreeAMRRayImage picture{ reduction, treeamr::Image(reduction.width(), reduction.height()), {} };
  if (reduction.isFull())
  {
    treeamr::flattenLayers(shaders, depth, picture.Image);
  }
  else
  {
    treeamr::flattenLayers(shaders, reduction.sample(depth), picture.Image);
    picture.Lengths = std::move(depth);
  }
  isPeeling ? internals.DepthPeeling.Draw(renderer, nullptr, picture)
            : internals.ImagePainter.DrawOver(renderer, picture);
  layers.recordShading(vtkTimerLog::GetUniversalTime() - start);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::RenderWithVolumes(vtkRenderer* renderer, vtkActor* actor)
{
  if (renderer->GetSelector())
  {
    return;
  }
  this->Watch(renderer, [&](treeamr::Progress* progress) {
    const treeamr::TranslucentScene scene = treeamr::findTranslucentScene(renderer);
    const bool isLater = vtkTreeAMRDepthPeeling::IsPeeling(actor) &&
      !vtkTreeAMRDepthPeeling::IsFirstStage(this->Private->StandIn, actor);
    if (scene.isDrawnAsVolume && scene.drawer == actor && !isLater)
    {
      this->DrawLayers(renderer, actor, progress);
    }
  });
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::RenderAfterOpaque(vtkRenderer* renderer, vtkActor* actor)
{
  const treeamr::TranslucentScene scene = treeamr::findTranslucentScene(renderer);
  if (renderer->GetSelector() || !treeamr::comesAfterOpaque(renderer, scene) || !scene.has(actor))
  {
    return false;
  }
  this->Private->Messages.unsupported(treeamr::unsupportedSettings(actor, this));
  if (scene.surfaces.back() == actor)
  {
    this->Watch(renderer, [&](treeamr::Progress* progress) { this->DrawLayers(renderer, actor, progress); });
  }
  return true;
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Watch(
  vtkRenderer* renderer, const std::function<void(treeamr::Progress*)>& draw)
{
  treeamr::FrameWatch watch(renderer, this, true);
  if (treeamr::FrameWatch::isReporting())
  {
    this->Private->Messages.unsupported({ treeamr::nestedFrames });
  }
  if (!watch.canDraw())
  {
    return;
  }
  try
  {
    draw(watch.progress());
  }
  catch (const treeamr::Interrupted&)
  {
    // Nothing of it is drawn or kept.
  }
  catch (const std::exception& error)
  {
    this->Private->Messages.error(error);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Select(treeamr::SurfaceActorView& view)
{
  Internals& internals = *this->Private;
  vtkHardwareSelector* selector = view.renderer->GetSelector();
  if (selector->GetFieldAssociation() == vtkDataObject::FIELD_ASSOCIATION_POINTS)
  {
    return; // there are none; those behind are hidden by the depths that the selector draws first
  }
  if (this->CompositeIndex == 0)
  {
    internals.Messages.unsupported({ "Selection of cells of several grids that are drawn as one" });
    return;
  }
  const treeamr::SelectedProp selected(selector);
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  vtkDataArray* array = grid->GetCellData()->GetArray(internals.Contoured.name.c_str());
  treeamr::fillSelection(
    selector, grid, array->GetNumberOfTuples(), this->CompositeIndex, view.surface, internals.Image);
  view.pictureIsOfThisFrame = false;
  view.picture.Upload(
    vtkTreeAMRTarget::GetWindow(view.renderer), view.surface.reduction(), internals.Image, false);
  internals.Painter.Draw(view.renderer, view.actor, this, view.picture);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Render(vtkRenderer* renderer, vtkActor* actor)
{
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  this->Watch(renderer, [&](treeamr::Progress* progress) { this->RenderSurface(renderer, actor, progress); });
  timer->StopTimer();
  this->TimeToDraw = timer->GetElapsedTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Private->Painter.ReleaseGraphicsResources();
  this->Private->ImagePainter.ReleaseGraphicsResources(window);
  this->Private->DepthPeeling.ReleaseGraphicsResources(window);
  for (const std::unique_ptr<treeamr::SurfaceActorView>& view : this->Private->Views)
  {
    view->picture.ReleaseGraphicsResources(window);
    view->pictureIsOfThisFrame = false;
  }
}

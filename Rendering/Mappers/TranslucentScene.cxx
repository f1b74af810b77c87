#include "TranslucentScene.h"

#include "MapperMessages.h"
#include "SceneConversion.h"
#include "SurfaceActorView.h"
#include "VolumeEffects.h"
#include "vtkTreeAMRIsosurfaceActor.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRVolumeMapper.h"

#include "vtkActor.h"
#include "vtkCameraPass.h"
#include "vtkCuller.h"
#include "vtkCullerCollection.h"
#include "vtkFrustumCoverageCuller.h"
#include "vtkImageProcessingPass.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPropCollection.h"
#include "vtkRenderStepsPass.h"
#include "vtkRenderer.h"
#include "vtkVolume.h"

#include <algorithm>
#include <exception>
#include <string>

namespace treeamr
{

namespace
{

/// VTK's own order has volumes last; passes of the user's need not draw them at all.
bool drawsVolumesLast(vtkRenderer* renderer)
{
  vtkRenderPass* pass = renderer->GetPass();
  while (pass)
  {
    if (auto camera = vtkCameraPass::SafeDownCast(pass))
    {
      pass = camera->GetDelegatePass();
    }
    else if (auto processing = vtkImageProcessingPass::SafeDownCast(pass))
    {
      pass = processing->GetDelegatePass();
    }
    else if (auto steps = vtkRenderStepsPass::SafeDownCast(pass))
    {
      return steps->GetTranslucentPass() && steps->GetVolumetricPass();
    }
    else
    {
      // ParaView's default one, in parallel within that of IceT, whose header the plugin alone may include.
      return pass->IsA("vtkPVDefaultPass") || pass->IsA("vtkIceTCompositePass") ||
        std::string(pass->GetClassName()) == "vtkDefaultPass";
    }
  }
  return !renderer->GetPass();
}

/// Whether all is drawn by the renderer itself, or ParaView's pass that asks it to.
bool hasOwnOrder(vtkRenderer* renderer)
{
  vtkRenderPass* pass = renderer->GetPass();
  if (auto camera = vtkCameraPass::SafeDownCast(pass))
  {
    pass = camera->GetDelegatePass();
  }
  bool sorts = false;
  vtkCullerCollection* cullers = renderer->GetCullers();
  vtkCollectionSimpleIterator at;
  cullers->InitTraversal(at);
  while (vtkCuller* culler = cullers->GetNextCuller(at))
  {
    auto frustum = vtkFrustumCoverageCuller::SafeDownCast(culler);
    sorts = sorts ||
      (frustum ? frustum->GetSortingStyle() != VTK_CULLER_SORT_NONE : !culler->IsA("vtkPVRendererCuller"));
  }
  return (!pass || pass->IsA("vtkPVDefaultPass")) && !sorts;
}

/// Whether some prop that is drawn as a volume is in it.
bool hasVolumes(vtkProp* prop)
{
  vtkNew<vtkPropCollection> volumes;
  prop->GetVolumes(volumes);
  return volumes->GetNumberOfItems() > 0 || prop->IsA("vtkLODProp3D");
}

} // namespace

bool isCulled(vtkRenderer* renderer, vtkProp* prop)
{
  return renderer->GetCullers()->GetNumberOfItems() > 0 && prop->GetRenderTimeMultiplier() == 0.;
}

bool isTranslucent(vtkActor* actor)
{
  auto own = vtkTreeAMRIsosurfaceActor::SafeDownCast(actor);
  return own ? own->IsTranslucent() : actor->HasTranslucentPolygonalGeometry();
}

bool TranslucentScene::has(const vtkActor* actor) const
{
  return std::find(surfaces.begin(), surfaces.end(), actor) != surfaces.end();
}

TranslucentScene findTranslucentScene(vtkRenderer* renderer)
{
  TranslucentScene scene;
  vtkPropCollection* props = renderer->GetViewProps();
  vtkCollectionSimpleIterator at;
  props->InitTraversal(at);
  while (vtkProp* prop = props->GetNextProp(at))
  {
    if (!prop->GetVisibility() || isCulled(renderer, prop))
    {
      continue;
    }
    auto volume = vtkVolume::SafeDownCast(prop);
    auto ownMapper = volume ? vtkTreeAMRVolumeMapper::SafeDownCast(volume->GetMapper()) : nullptr;
    if (ownMapper && !blendsValues(ownMapper) && !scene.volume)
    {
      // Without an input VTK does not ask it to draw.
      scene.volume = ownMapper->GetDataObjectInput() ? volume : nullptr;
      continue;
    }
    auto actor = vtkActor::SafeDownCast(prop);
    const bool isSurface = actor && vtkTreeAMRIsosurfaceMapper::SafeDownCast(actor->GetMapper());
    if (isSurface && isTranslucent(actor))
    {
      if (vtkMath::AreBoundsInitialized(actor->GetMapper()->GetBounds())) // else there is nothing of it here
      {
        scene.surfaces.push_back(actor);
      }
    }
    else if (!isSurface && (prop->HasTranslucentPolygonalGeometry() || hasVolumes(prop)))
    {
      return {};
    }
  }
  const bool canBeVolume = drawsVolumesLast(renderer);
  if (scene.volume && !canBeVolume)
  {
    return {};
  }
  const auto own = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
    [](vtkActor* actor) { return vtkTreeAMRIsosurfaceActor::SafeDownCast(actor) != nullptr; });
  scene.isDrawnAsVolume = scene.volume || (canBeVolume && own != scene.surfaces.end());
  if (scene.volume)
  {
    scene.drawer = scene.volume;
  }
  else if (!scene.surfaces.empty())
  {
    scene.drawer = scene.isDrawnAsVolume ? *own : scene.surfaces.front();
  }
  return scene;
}

bool comesAfterOpaque(vtkRenderer* renderer, const TranslucentScene& scene)
{
  const bool areOwn = std::all_of(scene.surfaces.begin(), scene.surfaces.end(),
    [](vtkActor* actor) { return vtkTreeAMRIsosurfaceActor::SafeDownCast(actor) != nullptr; });
  if (scene.surfaces.empty() || !areOwn || scene.volume || !scene.isDrawnAsVolume || !hasOwnOrder(renderer) ||
    renderer->GetUseSSAO() || renderer->GetUseShadows() || renderer->GetUseHiddenLineRemoval())
  {
    return false;
  }
  bool isBehind = true;
  vtkPropCollection* props = renderer->GetViewProps();
  vtkCollectionSimpleIterator at;
  props->InitTraversal(at);
  while (vtkProp* prop = props->GetNextProp(at))
  {
    if (prop == scene.surfaces.back())
    {
      isBehind = true;
    }
    else if (prop->GetVisibility() && !isCulled(renderer, prop) && prop->HasOpaqueGeometry())
    {
      isBehind = false;
    }
  }
  return isBehind;
}

//------------------------------------------------------------------------------
ActorLayers::ActorLayers(
  vtkRenderer* renderer, std::span<vtkActor* const> actors, SurfaceLayers layers, Progress* progress)
  : isInteractive_(isInteractive(renderer))
  , progress_(progress)
{
  for (vtkActor* actor : actors)
  {
    auto mapper = static_cast<vtkTreeAMRIsosurfaceMapper*>(actor->GetMapper());
    try
    {
      SurfaceActorView& view = mapper->FindView(renderer, actor, layers);
      if (mapper->UpdateSurface(view))
      {
        surfaces_.push_back({ mapper, &view, view.plan.sampleDistance });
      }
    }
    catch (const std::exception& error)
    {
      mapper->GetMessages().error(error);
    }
  }
}

double ActorLayers::chooseSampleDistance(double own) const
{
  double distance = own;
  for (const Surface& surface : surfaces_)
  {
    distance = distance == 0. ? surface.wantedDistance
      : isInteractive_        ? std::max(distance, surface.wantedDistance)
                              : std::min(distance, surface.wantedDistance);
  }
  return std::max(1., distance);
}

const std::vector<SurfaceShader>& ActorLayers::trace(double sampleDistance)
{
  shaders_.clear();
  std::erase_if(surfaces_, [&](const Surface& surface) {
    try
    {
      surface.mapper->UpdateHits(*surface.view, sampleDistance, progress_);
      shaders_.push_back(surface.mapper->Light(*surface.view, progress_));
      return false;
    }
    catch (const std::exception& error)
    {
      surface.mapper->GetMessages().error(error);
      return true;
    }
  });
  return shaders_;
}

void ActorLayers::recordShading(double seconds)
{
  for (const Surface& surface : surfaces_)
  {
    surface.mapper->RecordFrame(*surface.view, seconds / static_cast<double>(surfaces_.size()));
  }
}

} // namespace treeamr

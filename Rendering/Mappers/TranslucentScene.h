// What lets light through in a renderer, when all of that is known here: it needs no sorting by VTK then, but is
// drawn as one picture, each ray once through everything. Private to the module.
//
// vtkDualDepthPeelingPass sorts by drawing all layers once for each that it takes off, keeps colours in 8 bits and
// walks through a volume from peel to peel. Where nothing of others lies between, the surfaces' hits and the volume
// are composited along each ray instead: one of the props draws all of them, the others nothing. That is the volume;
// without one a vtkTreeAMRIsosurfaceActor, which is asked to draw with the volumes, too; else the first of the actors,
// as one layer of polygons. Where the last of such actors comes behind all that is opaque, it draws right after that, as
// the renderer's smoothing of edges wants it, and VTK has nothing translucent to prepare its passes for.
#pragma once

#include "SurfaceShading.h"

#include <cstddef>
#include <span>
#include <vector>

class vtkActor;
class vtkProp;
class vtkRenderer;
class vtkTreeAMRIsosurfaceMapper;
class vtkVolume;

namespace treeamr
{

struct SurfaceActorView;

/// The props of a renderer that are translucent, visible and not culled, and which of them draws all.
struct TranslucentScene
{
  std::vector<vtkActor*> surfaces; // of vtkTreeAMRIsosurfaceMapper, as the renderer has them
  vtkVolume* volume = nullptr;     // of vtkTreeAMRVolumeMapper
  vtkProp* drawer = nullptr;
  /// When volumes are drawn, where nothing has to be peeled; else with the translucent polygons.
  bool isDrawnAsVolume = false;

  bool has(const vtkActor* actor) const;
};

/// Whether light comes through, whoever draws it.
bool isTranslucent(vtkActor* actor);

/// Cullers take props out of the frame by giving them no time.
bool isCulled(vtkRenderer* renderer, vtkProp* prop);

/// Empty when anything else is translucent, or drawn as a volume, or part of an assembly; and when volumes may not be drawn
/// after surfaces (the renderer has passes that are not known). While the renderer draws.
TranslucentScene findTranslucentScene(vtkRenderer* renderer);

/// Whether all of it are vtkTreeAMRIsosurfaceActors, the last of which is drawn behind everything that is opaque, with
/// nothing to follow that looks at opaque things alone. While the renderer draws.
bool comesAfterOpaque(vtkRenderer* renderer, const TranslucentScene& scene);

/// The surfaces of actors on their way into one picture. Errors are reported by the actors' mappers, once; such an
/// actor is left out.
class ActorLayers
{
public:
  /// Takes all their layers, or of each the nearest surface. progress: of tracing them; null: none follows.
  ActorLayers(
    vtkRenderer* renderer, std::span<vtkActor* const> actors, SurfaceLayers layers, Progress* progress);
  ActorLayers(const ActorLayers&) = delete;
  ActorLayers& operator=(const ActorLayers&) = delete;

  bool isEmpty() const noexcept { return surfaces_.empty(); }
  /// Of one picture: the distance between rays that all can keep up with while the camera moves, else the least that
  /// any asks for. `own`: of whoever draws the surfaces besides; 0 for none.
  double chooseSampleDistance(double own) const;
  /// Traces what is not known yet. Throws Interrupted. The shaders last as long as this.
  const std::vector<SurfaceShader>& trace(double sampleDistance);
  /// What it took to shade all of them, to be shared.
  void recordShading(double seconds);

private:
  struct Surface
  {
    vtkTreeAMRIsosurfaceMapper* mapper;
    SurfaceActorView* view;
    double wantedDistance;
  };
  bool isInteractive_;
  Progress* progress_;
  std::vector<Surface> surfaces_; // that have something to draw
  std::vector<SurfaceShader> shaders_;
};

} // namespace treeamr

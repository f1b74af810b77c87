// An actor of isosurfaces in one renderer, as one eye sees it. Private to the module.
#pragma once

#include "FramePlan.h"
#include "ImageReduction.h"
#include "SurfaceView.h"
#include "vtkTreeAMRSurfaceImage.h"

#include "vtkActor.h"
#include "vtkCommand.h"
#include "vtkRenderer.h"
#include "vtkWeakPointer.h"

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace treeamr
{

struct SurfaceActorView
{
  vtkWeakPointer<vtkRenderer> renderer;
  vtkWeakPointer<vtkActor> actor;
  int eye;

  SurfacePose pose; // of this frame
  FramePlan plan;
  /// Its hits serve all frames until something moves.
  SurfaceView surface;
  // Known of the hits besides.
  std::vector<std::shared_ptr<const Field>> colorFields;
  std::vector<float> colorValues; // of each hit one of each field, less its offset

  // What it took to trace and shade them, for the drafts to come.
  SampleDistanceControl sampleDistances;
  double seconds = 0.; // negative: known

  /// Of all that is drawn with this actor; it serves all passes of a frame (depth peeling).
  vtkTreeAMRSurfaceTextures picture;
  SurfacePose picturePose;
  bool pictureIsOfThisFrame = false;

  SurfaceActorView(
    vtkRenderer* ofRenderer, vtkActor* ofActor, int ofEye, std::function<void()> atStartOfFrame)
    : renderer(ofRenderer)
    , actor(ofActor)
    , eye(ofEye)
    , atStartOfFrame_(std::move(atStartOfFrame))
    , observer_(renderer->AddObserver(vtkCommand::StartEvent, this, &SurfaceActorView::startFrame))
  {
  }
  ~SurfaceActorView()
  {
    if (renderer)
    {
      renderer->RemoveObserver(observer_);
    }
  }
  SurfaceActorView(const SurfaceActorView&) = delete;
  SurfaceActorView& operator=(const SurfaceActorView&) = delete;

private:
  void startFrame()
  {
    pictureIsOfThisFrame = false;
    atStartOfFrame_();
  }

  std::function<void()> atStartOfFrame_;
  unsigned long observer_;
};

} // namespace treeamr

// What an isosurface mapper keeps. Private to the module.
#pragma once

#include "MapperInput.h"
#include "MapperMessages.h"
#include "SurfaceActorView.h"
#include "SurfaceColoring.h"
#include "SurfaceLevels.h"
#include "vtkTreeAMRDepthPeeling.h"
#include "vtkTreeAMRImagePainter.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRSurfacePainter.h"
#include "vtkTreeAMRVolumeMapper.h"

#include "vtkNew.h"
#include "vtkTimeStamp.h"

#include <memory>
#include <vector>

//------------------------------------------------------------------------------
struct vtkTreeAMRIsosurfaceMapper::Internals
{
  explicit Internals(vtkTreeAMRIsosurfaceMapper* self)
    : Messages(self)
  {
  }

  vtkTreeAMRSurfacePainter Painter;
  vtkTreeAMRImagePainter ImagePainter;
  vtkNew<vtkTreeAMRVolumeMapper> StandIn; // VTK's passes tell volumes what they tell no surface
  vtkTreeAMRDepthPeeling DepthPeeling;
  treeamr::FieldSlot ContourSlot;
  treeamr::SurfaceColoring Coloring;
  treeamr::BoundsSlot BoundsSlot;
  treeamr::MapperMessages Messages; // errors of a frame, warnings of a call of Light()
  bool ErrorsAreOfThisFrame = false;

  std::shared_ptr<const treeamr::Field> Field;
  treeamr::SurfaceLevels Surfaces; // of the field
  treeamr::ArraySelection Contoured;
  vtkTimeStamp SurfaceTime;

  std::vector<std::unique_ptr<treeamr::SurfaceActorView>> Views;
  double LastSampleDistance = 0.;
  vtkTreeAMRSurfaceImage Image; // on its way to the graphics card

  treeamr::SurfaceActorView& ViewOf(vtkMapper* self, vtkRenderer* renderer, vtkActor* actor);
};

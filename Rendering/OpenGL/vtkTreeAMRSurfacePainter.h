// Surface points into the framebuffer, each at its depth.
#pragma once

#include "vtkTreeAMRQuad.h"
#include "vtkTreeAMRSurfaceImage.h"

class vtkAbstractMapper;
class vtkActor;
class vtkRenderer;

class vtkTreeAMRSurfacePainter
{
public:
  vtkTreeAMRSurfacePainter();
  vtkTreeAMRSurfacePainter(const vtkTreeAMRSurfacePainter&) = delete;
  vtkTreeAMRSurfacePainter& operator=(const vtkTreeAMRSurfacePainter&) = delete;

  /// Draws with real depth: opaque points in the opaque pass; in the translucent pass by the protocol of the
  /// pass (order independent or depth peeling), blended with the image's alpha, back to front in each pixel.
  /// Throws treeamr::Error.
  void Draw(vtkRenderer* renderer, vtkActor* actor, vtkAbstractMapper* mapper,
    const vtkTreeAMRSurfaceTextures& textures);
  void ReleaseGraphicsResources();

private:
  vtkTreeAMRQuad& GetQuad(vtkActor* actor, vtkAbstractMapper* mapper, bool full);

  // The passes rewrite the shader and have stages of their own: one program for each text they make.
  vtkTreeAMRQuadSet Quads;
};

// Images of rays over what is drawn.
#pragma once

#include "vtkTreeAMRQuad.h"
#include "vtkTreeAMRRayImage.h"

class vtkRenderer;
class vtkWindow;

class vtkTreeAMRImagePainter
{
public:
  vtkTreeAMRImagePainter() = default;
  vtkTreeAMRImagePainter(const vtkTreeAMRImagePainter&) = delete;
  vtkTreeAMRImagePainter& operator=(const vtkTreeAMRImagePainter&) = delete;

  /// Blends an image over the viewport's colour and alpha (IceT composites with the alpha); depth is neither
  /// tested nor written. Throws treeamr::Error.
  void DrawOver(vtkRenderer* renderer, const vtkTreeAMRRayImage& image);
  void ReleaseGraphicsResources(vtkWindow* window);

private:
  vtkTreeAMRQuadSet Quads;
  vtkTreeAMRRayTexture Texture{ "treeamrImage" };
};

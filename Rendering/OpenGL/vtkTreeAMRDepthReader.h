// Depths out of the framebuffer that is bound for drawing. All OpenGL state is restored: vtkOpenGLState keeps a copy
// of it and, in debugging builds of VTK, compares the two at every call.
#pragma once

#include "vtkTreeAMRTarget.h"

#include <vector>

class vtkTreeAMRDepthReader
{
public:
  /// Window depth of each pixel of the viewport; 1 everywhere when the framebuffer has no depth. Of a
  /// multisampled framebuffer one sample a pixel. Throws Error.
  static void Read(vtkRenderer* renderer, const vtkTreeAMRViewport& viewport, std::vector<float>& depth);
};

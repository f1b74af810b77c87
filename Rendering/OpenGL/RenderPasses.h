// The OpenGL passes around a prop's rendering, which it has to take part in. Private to the module.
#pragma once

#include <vector>

class vtkOpenGLRenderPass;
class vtkProp;

namespace treeamr
{

/// Outermost first; empty outside of passes.
std::vector<vtkOpenGLRenderPass*> renderPasses(vtkProp* prop);
/// The first of a class or of one that is derived from it; null: none.
vtkOpenGLRenderPass* findRenderPass(vtkProp* prop, const char* className);

/// Whether a pass takes positions and normals (vtkSSAOPass).
bool wantsGeometry(vtkProp* prop);
/// Whether a pass sorts fragments by depth.
bool isDepthPeeling(vtkProp* prop);

} // namespace treeamr

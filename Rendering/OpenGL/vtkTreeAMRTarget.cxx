#include "vtkTreeAMRTarget.h"

#include "Error.h"

#include "vtkObject.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderer.h"

#include <string>

//------------------------------------------------------------------------------
vtkOpenGLRenderWindow* vtkTreeAMRTarget::GetWindow(vtkRenderer* renderer)
{
  vtkRenderWindow* window = renderer ? renderer->GetRenderWindow() : nullptr;
  vtkOpenGLRenderWindow* openGLWindow = vtkOpenGLRenderWindow::SafeDownCast(window);
  if (!openGLWindow)
  {
    throw treeamr::Error(std::string("framebuffer: the renderer draws into ") +
      (window ? window->GetClassName() : "no window") + ", needed is a vtkOpenGLRenderWindow");
  }
  return openGLWindow;
}

//------------------------------------------------------------------------------
vtkTreeAMRViewport vtkTreeAMRTarget::GetViewport(vtkRenderer* renderer)
{
  int box[4] = { 0, 0, 0, 0 };
  GetWindow(renderer)->GetState()->vtkglGetIntegerv(GL_VIEWPORT, box);
  if (box[2] < 1 || box[3] < 1)
  {
    throw treeamr::Error(
      "framebuffer: the viewport has " + std::to_string(box[2]) + " x " + std::to_string(box[3]) + " pixels");
  }
  return { box[0], box[1], box[2], box[3] };
}

//------------------------------------------------------------------------------
void vtkTreeAMRTarget::DiscardErrors()
{
  // Bounded: without a current context glGetError() never runs dry.
  constexpr int kindsOfErrors = 8;
  for (int i = 0; i < kindsOfErrors && glGetError() != GL_NO_ERROR; ++i)
  {
  }
}

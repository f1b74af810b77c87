#include "vtkTreeAMRImagePainter.h"

#include "vtkTreeAMRTarget.h"

#include "vtkObject.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderer.h"
#include "vtkShaderProgram.h"

#include <string>

namespace
{

const char* const overShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
//TreeAMR::Image::Dec
void main()
{
  gl_FragData[0] = treeamrImage();
}
)";

} // anonymous namespace

//------------------------------------------------------------------------------
void vtkTreeAMRImagePainter::DrawOver(vtkRenderer* renderer, const vtkTreeAMRRayImage& image)
{
  vtkOpenGLRenderWindow* window = vtkTreeAMRTarget::GetWindow(renderer);
  vtkOpenGLState* state = window->GetState();
  this->Texture.Upload(window, image);
  std::string shader = overShader;
  vtkShaderProgram::Substitute(shader, "//TreeAMR::Image::Dec", this->Texture.GetDeclaration());
  vtkTreeAMRQuad& quad = this->Quads.Get(shader);
  vtkShaderProgram* program = quad.Use(window);

  vtkOpenGLState::ScopedglDepthMask depthMask(state);
  vtkOpenGLState::ScopedglEnableDisable depthTest(state, GL_DEPTH_TEST);
  vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND);
  vtkOpenGLState::ScopedglBlendFuncSeparate blendFunction(state);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglEnable(GL_BLEND);
  state->vtkglBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);

  const vtkTreeAMRRayTexture::Binding binding(this->Texture, program);
  quad.Draw();
}

//------------------------------------------------------------------------------
void vtkTreeAMRImagePainter::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Quads.ReleaseGraphicsResources();
  this->Texture.ReleaseGraphicsResources(window);
}

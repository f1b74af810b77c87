#include "vtkTreeAMRQuad.h"

#include "Error.h"

#include "vtkObject.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4
#include "vtkOpenGLQuadHelper.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLShaderCache.h"
#include "vtkOpenGLState.h"
#include "vtkOpenGLVertexArrayObject.h"
#include "vtkShaderProgram.h"
#include "vtkTextureObject.h"

#include <utility>

//------------------------------------------------------------------------------
vtkTreeAMRQuad::vtkTreeAMRQuad(std::string fragmentShader, std::string vertexShader)
  : FragmentShader(std::move(fragmentShader))
  , VertexShader(std::move(vertexShader))
{
}

//------------------------------------------------------------------------------
vtkTreeAMRQuad::~vtkTreeAMRQuad() = default;

//------------------------------------------------------------------------------
vtkShaderProgram* vtkTreeAMRQuad::Use(vtkOpenGLRenderWindow* window)
{
  if (this->Helper && this->Window != window)
  {
    this->ReleaseGraphicsResources();
  }
  if (!this->Helper)
  {
    this->Window = window;
    this->Helper = std::make_unique<vtkOpenGLQuadHelper>(window,
      this->VertexShader.empty() ? nullptr : this->VertexShader.c_str(), this->FragmentShader.c_str(),
      nullptr);
  }
  else
  {
    window->GetShaderCache()->ReadyShaderProgram(this->Helper->Program);
  }
  if (!this->Helper->Program || !this->Helper->Program->GetCompiled())
  {
    this->ReleaseGraphicsResources();
    throw treeamr::Error("framebuffer: the OpenGL driver refused a shader");
  }
  return this->Helper->Program;
}

//------------------------------------------------------------------------------
vtkOpenGLVertexArrayObject* vtkTreeAMRQuad::GetVertexArray()
{
  return this->Helper ? this->Helper->VAO : nullptr;
}

//------------------------------------------------------------------------------
void vtkTreeAMRQuad::Draw(int instances)
{
  vtkOpenGLState* state = this->Window->GetState();
  vtkOpenGLState::ScopedglEnableDisable cullFace(state, GL_CULL_FACE);
  state->vtkglDisable(GL_CULL_FACE);
  this->Helper->VAO->Bind();
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, instances);
  this->Helper->VAO->Release();
}

//------------------------------------------------------------------------------
void vtkTreeAMRQuad::ReleaseGraphicsResources()
{
  this->Helper.reset();
  this->Window = nullptr;
}

//------------------------------------------------------------------------------
vtkTreeAMRQuadSet::vtkTreeAMRQuadSet(std::string vertexShader)
  : VertexShader(std::move(vertexShader))
{
}

//------------------------------------------------------------------------------
vtkTreeAMRQuad& vtkTreeAMRQuadSet::Get(const std::string& fragmentShader)
{
  std::unique_ptr<vtkTreeAMRQuad>& quad = this->Quads[fragmentShader];
  if (!quad)
  {
    quad = std::make_unique<vtkTreeAMRQuad>(fragmentShader, this->VertexShader);
  }
  return *quad;
}

//------------------------------------------------------------------------------
void vtkTreeAMRQuadSet::ReleaseGraphicsResources()
{
  this->Quads.clear();
}

//------------------------------------------------------------------------------
vtkTreeAMRFloatTexture::vtkTreeAMRFloatTexture()
  : Texture(vtkSmartPointer<vtkTextureObject>::New())
{
}

//------------------------------------------------------------------------------
vtkTreeAMRFloatTexture::~vtkTreeAMRFloatTexture() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRFloatTexture::Upload(
  vtkOpenGLRenderWindow* window, int width, int height, int components, const float* values)
{
  if (this->Texture->GetContext() && this->Texture->GetContext() != window)
  {
    this->Texture->ReleaseGraphicsResources(this->Texture->GetContext());
  }
  this->Texture->SetContext(window);
  this->Texture->SetWrapS(vtkTextureObject::ClampToEdge);
  this->Texture->SetWrapT(vtkTextureObject::ClampToEdge);
  this->Texture->SetMinificationFilter(vtkTextureObject::Nearest);
  this->Texture->SetMagnificationFilter(vtkTextureObject::Nearest);
  // VTK only reads, but does not say so.
  if (!this->Texture->Create2DFromRaw(width, height, components, VTK_FLOAT, const_cast<float*>(values)))
  {
    throw treeamr::Error("framebuffer: no texture of " + std::to_string(width) + " x " +
      std::to_string(height) + " pixels with " + std::to_string(components) + " floats each");
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRFloatTexture::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Texture->ReleaseGraphicsResources(window);
}

//------------------------------------------------------------------------------
vtkTreeAMRFloatTexture::Binding::Binding(
  const vtkTreeAMRFloatTexture& texture, vtkShaderProgram* program, const char* name)
  : Texture(texture.Texture)
{
  this->Texture->Activate();
  program->SetUniformi(name, this->Texture->GetTextureUnit());
}

//------------------------------------------------------------------------------
vtkTreeAMRFloatTexture::Binding::~Binding()
{
  this->Texture->Deactivate();
}

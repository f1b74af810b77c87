// A quad over the whole viewport with a fragment shader of its own: how images get into a framebuffer.
//
// VTK's vtkOpenGLQuadHelper, plus what its users repeat: compiling on first use, a second context, float
// textures that are bound for one draw.
#pragma once

#include "vtkSmartPointer.h"
#include "vtkWeakPointer.h"

#include <map>
#include <memory>
#include <string>

class vtkOpenGLQuadHelper;
class vtkOpenGLRenderWindow;
class vtkOpenGLVertexArrayObject;
class vtkShaderProgram;
class vtkTextureObject;
class vtkWindow;

class vtkTreeAMRQuad
{
public:
  /// The shaders hold the tags //VTK::System::Dec and //VTK::Output::Dec. The vertex shader turns `vec4
  /// ndCoordIn` and `vec2 texCoordIn` of the quad over the viewport into gl_Position and `vec2 texCoord`;
  /// when empty it is VTK's, that copies them.
  explicit vtkTreeAMRQuad(std::string fragmentShader, std::string vertexShader = {});
  ~vtkTreeAMRQuad();
  vtkTreeAMRQuad(const vtkTreeAMRQuad&) = delete;
  vtkTreeAMRQuad& operator=(const vtkTreeAMRQuad&) = delete;

  /// Compiles when needed and makes the program current. Throws treeamr::Error when it does not compile.
  vtkShaderProgram* Use(vtkOpenGLRenderWindow* window);
  vtkOpenGLVertexArrayObject* GetVertexArray();
  /// With the current program and state; only culling is switched off, for the pass may have it on.
  void Draw(int instances = 1);
  void ReleaseGraphicsResources();

private:
  std::string FragmentShader;
  std::string VertexShader;
  std::unique_ptr<vtkOpenGLQuadHelper> Helper;
  vtkWeakPointer<vtkOpenGLRenderWindow> Window;
};

/// Quads by their fragment shaders, made when first asked for, with the same vertex shader.
class vtkTreeAMRQuadSet
{
public:
  explicit vtkTreeAMRQuadSet(std::string vertexShader = {});
  vtkTreeAMRQuad& Get(const std::string& fragmentShader);
  void ReleaseGraphicsResources();

private:
  std::string VertexShader;
  std::map<std::string, std::unique_ptr<vtkTreeAMRQuad>> Quads;
};

/// A 2D texture of floats, read without interpolation.
class vtkTreeAMRFloatTexture
{
public:
  vtkTreeAMRFloatTexture();
  ~vtkTreeAMRFloatTexture();
  vtkTreeAMRFloatTexture(const vtkTreeAMRFloatTexture&) = delete;
  vtkTreeAMRFloatTexture& operator=(const vtkTreeAMRFloatTexture&) = delete;

  /// values: height x width x components, lower left first. Throws treeamr::Error when the driver refuses.
  void Upload(vtkOpenGLRenderWindow* window, int width, int height, int components, const float* values);
  void ReleaseGraphicsResources(vtkWindow* window);

  /// Binds the texture to a unit and to the sampler `name` of the current program for its own lifetime.
  class Binding
  {
  public:
    Binding(const vtkTreeAMRFloatTexture& texture, vtkShaderProgram* program, const char* name);
    ~Binding();
    Binding(const Binding&) = delete;
    Binding& operator=(const Binding&) = delete;

  private:
    vtkTextureObject* Texture;
  };

private:
  vtkSmartPointer<vtkTextureObject> Texture;
};

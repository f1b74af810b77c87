#include "vtkTreeAMRFramebuffer.h"

#include "Error.h"

#include "vtkActor.h"
#include "vtkInformation.h"
#include "vtkInformationObjectBaseVectorKey.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4
#include "vtkOpenGLRenderPass.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderer.h"
#include "vtkShaderProgram.h"

#include <algorithm>
#include <optional>
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

// Only tiles with points are drawn, each as often as it has layers: a surface with many layers in a few
// places costs little elsewhere.
const char* const surfaceVertexShader = R"(//VTK::System::Dec
in vec4 ndCoordIn;
in vec2 texCoordIn;
out vec2 texCoord;
flat out int treeamrLayer;
uniform sampler2D treeamrTiles;
uniform vec2 treeamrTileSize;
void main()
{
  int columns = textureSize(treeamrTiles, 0).x;
  vec3 tile = texelFetch(treeamrTiles, ivec2(gl_InstanceID % columns, gl_InstanceID / columns), 0).xyz;
  treeamrLayer = int(tile.z);
  texCoord = min((tile.xy + texCoordIn) * treeamrTileSize, 1.0);
  gl_Position = vec4(2.0 * texCoord - 1.0, ndCoordIn.z, 1.0);
}
)";

// The tags are those of VTK's polygon shaders. The passes of depth peeling read gl_FragDepth after PreColor
// and gl_FragData[0] after Impl.
const char* const surfaceShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
flat in int treeamrLayer;
uniform sampler2D treeamrRuns;
uniform sampler2D treeamrColor;
uniform sampler2D treeamrDepth;
//TreeAMR::Slope::Dec
//VTK::DepthPeeling::Dec
//TreeAMR::Geometry::Dec
void main()
{
  vec3 run = texture2D(treeamrRuns, texCoord).xyz;
  if (treeamrLayer >= int(run.z))
  {
    discard;
  }
  int columns = textureSize(treeamrDepth, 0).x;
  int column = int(run.x) + treeamrLayer;
  ivec2 point = ivec2(column % columns, int(run.y) + column / columns);
  gl_FragDepth = texelFetch(treeamrDepth, point, 0).r;
  //TreeAMR::Slope::Impl
  //VTK::DepthPeeling::PreColor
  gl_FragData[0] = texelFetch(treeamrColor, point, 0);
  //TreeAMR::Geometry::Impl
  //VTK::DepthPeeling::Impl
}
)";

const char* const slopeDeclaration = "uniform sampler2D treeamrSlope;\n";
const char* const slopeImplementation =
  "  vec2 size = vec2(textureSize(treeamrRuns, 0));\n"
  "  vec2 fromMiddle = texCoord - (floor(texCoord * size) + 0.5) / size;\n"
  "  gl_FragDepth += dot(texelFetch(treeamrSlope, point, 0).xy, fromMiddle);\n"
  "  gl_FragDepth = clamp(gl_FragDepth, 0.0, 1.0);\n";
const char* const geometryDeclarations = "uniform sampler2D treeamrPosition;\n"
                                         "uniform sampler2D treeamrNormal;\n";
const char* const geometryOutputs =
  "  gl_FragData[1] = vec4(texelFetch(treeamrPosition, point, 0).xyz, 1.0);\n"
  "  gl_FragData[2] = vec4(texelFetch(treeamrNormal, point, 0).xyz, 1.0);\n";

// Saves and restores what reading pixels touches. Raw OpenGL: vtkOpenGLState never learns of it.
class PixelReadState
{
public:
  PixelReadState()
    : Scissor(glIsEnabled(GL_SCISSOR_TEST))
  {
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &this->ReadBinding);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &this->DrawBinding);
    glGetIntegerv(GL_RENDERBUFFER_BINDING, &this->RenderbufferBinding);
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &this->PackBuffer);
    glGetIntegerv(GL_PACK_ALIGNMENT, &this->PackAlignment);
    glDisable(GL_SCISSOR_TEST); // it would cut blits
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
  }
  ~PixelReadState()
  {
    glPixelStorei(GL_PACK_ALIGNMENT, this->PackAlignment);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(this->PackBuffer));
    glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(this->RenderbufferBinding));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(this->ReadBinding));
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(this->DrawBinding));
    if (this->Scissor)
    {
      glEnable(GL_SCISSOR_TEST);
    }
  }
  PixelReadState(const PixelReadState&) = delete;
  PixelReadState& operator=(const PixelReadState&) = delete;

  GLuint GetDrawBinding() const { return static_cast<GLuint>(this->DrawBinding); }

private:
  GLboolean Scissor;
  GLint ReadBinding = 0;
  GLint DrawBinding = 0;
  GLint RenderbufferBinding = 0;
  GLint PackBuffer = 0;
  GLint PackAlignment = 4;
};

// The names of the default framebuffer's attachments differ from those of a framebuffer object.
GLint getDepthParameter(GLuint framebuffer, GLenum parameter)
{
  GLint value = 0;
  glGetFramebufferAttachmentParameteriv(
    GL_DRAW_FRAMEBUFFER, framebuffer == 0 ? GL_DEPTH : GL_DEPTH_ATTACHMENT, parameter, &value);
  return value;
}

bool hasStencil(GLuint framebuffer)
{
  const GLenum attachment = framebuffer == 0 ? GL_STENCIL : GL_STENCIL_ATTACHMENT;
  GLint type = GL_NONE;
  glGetFramebufferAttachmentParameteriv(
    GL_DRAW_FRAMEBUFFER, attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
  if (type == GL_NONE)
  {
    return false;
  }
  GLint bits = 0;
  glGetFramebufferAttachmentParameteriv(
    GL_DRAW_FRAMEBUFFER, attachment, GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE, &bits);
  return bits > 0;
}

// The format of the bound depth buffer: a blit between different ones is an error.
GLenum getDepthFormat(GLuint framebuffer)
{
  const bool stencil = hasStencil(framebuffer);
  if (getDepthParameter(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_FLOAT)
  {
    return stencil ? GL_DEPTH32F_STENCIL8 : GL_DEPTH_COMPONENT32F;
  }
  if (stencil)
  {
    return GL_DEPTH24_STENCIL8;
  }
  switch (getDepthParameter(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE))
  {
    case 16:
      return GL_DEPTH_COMPONENT16;
    case 32:
      return GL_DEPTH_COMPONENT32;
    default:
      return GL_DEPTH_COMPONENT24;
  }
}

// A framebuffer with nothing but depth, single-sampled. Lives for one read: next to tracing an image it costs
// nothing, and nothing has to be released when a window goes away.
class ResolvedDepth
{
public:
  ResolvedDepth(GLenum format, int width, int height)
  {
    glGenRenderbuffers(1, &this->Renderbuffer);
    glBindRenderbuffer(GL_RENDERBUFFER, this->Renderbuffer);
    glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    glGenFramebuffers(1, &this->Framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, this->Framebuffer); // for reading, too: it has no colours to read
    const bool stencil = format == GL_DEPTH24_STENCIL8 || format == GL_DEPTH32F_STENCIL8;
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT,
      GL_RENDERBUFFER, this->Renderbuffer);
    const GLenum none = GL_NONE;
    glDrawBuffers(1, &none);
    glReadBuffer(GL_NONE);
  }
  ~ResolvedDepth()
  {
    glDeleteFramebuffers(1, &this->Framebuffer);
    glDeleteRenderbuffers(1, &this->Renderbuffer);
  }
  ResolvedDepth(const ResolvedDepth&) = delete;
  ResolvedDepth& operator=(const ResolvedDepth&) = delete;

  GLuint GetFramebuffer() const { return this->Framebuffer; }

private:
  GLuint Framebuffer = 0;
  GLuint Renderbuffer = 0;
};

std::vector<vtkOpenGLRenderPass*> getPasses(vtkProp* prop)
{
  std::vector<vtkOpenGLRenderPass*> passes;
  vtkInformation* keys = prop->GetPropertyKeys();
  if (keys && keys->Has(vtkOpenGLRenderPass::RenderPasses()))
  {
    const int count = keys->Length(vtkOpenGLRenderPass::RenderPasses());
    for (int i = 0; i < count; ++i)
    {
      vtkObjectBase* object = keys->Get(vtkOpenGLRenderPass::RenderPasses(), i);
      if (vtkOpenGLRenderPass* pass = vtkOpenGLRenderPass::SafeDownCast(object))
      {
        passes.push_back(pass);
      }
    }
  }
  return passes;
}

bool isAmbientOcclusion(vtkOpenGLRenderPass* pass)
{
  return pass->IsA("vtkSSAOPass") != 0;
}

} // anonymous namespace

//------------------------------------------------------------------------------
void vtkTreeAMRSurfaceTextures::Upload(vtkOpenGLRenderWindow* window,
  const treeamr::ImageReduction& reduction, const vtkTreeAMRSurfaceImage& image, bool geometry)
{
  this->NumberOfTiles = image.NumberOfTiles;
  this->Geometry = geometry;
  this->Full = reduction.isFull();
  if (image.NumberOfTiles == 0)
  {
    return;
  }
  this->TileSize[0] = static_cast<float>(vtkTreeAMRSurfaceImage::TileSize) / reduction.width();
  this->TileSize[1] = static_cast<float>(vtkTreeAMRSurfaceImage::TileSize) / reduction.height();
  constexpr int columns = vtkTreeAMRSurfaceImage::Columns;
  const int rows = static_cast<int>(image.Depth.size() / columns);
  this->Tiles.Upload(
    window, columns, static_cast<int>(image.Tiles.size() / 3 / columns), 3, image.Tiles.data());
  this->Runs.Upload(window, reduction.width(), reduction.height(), 3, image.Runs.data());
  this->Color.Upload(window, columns, rows, 4, image.RGBA.data());
  this->Depth.Upload(window, columns, rows, 1, image.Depth.data());
  if (!this->Full)
  {
    this->Slope.Upload(window, columns, rows, 2, image.Slope.data());
  }
  if (geometry)
  {
    this->Position.Upload(window, columns, rows, 3, image.Position.data());
    this->Normal.Upload(window, columns, rows, 3, image.Normal.data());
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRSurfaceTextures::ReleaseGraphicsResources(vtkWindow* window)
{
  for (vtkTreeAMRFloatTexture* texture :
    { &this->Tiles, &this->Runs, &this->Color, &this->Depth, &this->Slope, &this->Position, &this->Normal })
  {
    texture->ReleaseGraphicsResources(window);
  }
}

//------------------------------------------------------------------------------
vtkTreeAMRFramebuffer::vtkTreeAMRFramebuffer()
  : SurfaceQuads(surfaceVertexShader)
{
}

//------------------------------------------------------------------------------
vtkOpenGLRenderWindow* vtkTreeAMRFramebuffer::GetWindow(vtkRenderer* renderer)
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
vtkTreeAMRViewport vtkTreeAMRFramebuffer::GetViewport(vtkRenderer* renderer)
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
void vtkTreeAMRFramebuffer::DiscardErrors()
{
  // Bounded: without a current context glGetError() never runs dry.
  constexpr int kindsOfErrors = 8;
  for (int i = 0; i < kindsOfErrors && glGetError() != GL_NO_ERROR; ++i)
  {
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRFramebuffer::ReadDepth(
  vtkRenderer* renderer, const vtkTreeAMRViewport& viewport, std::vector<float>& depth)
{
  GetWindow(renderer);
  depth.assign(static_cast<std::size_t>(viewport.Width) * viewport.Height, 1.f);

  DiscardErrors();
  GLenum error = GL_NO_ERROR;
  {
    PixelReadState state;
    const GLuint source = state.GetDrawBinding();
    if (getDepthParameter(source, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) == GL_NONE)
    {
      return;
    }
    GLint sampleBuffers = 0;
    glGetIntegerv(GL_SAMPLE_BUFFERS, &sampleBuffers);
    int x = viewport.X;
    int y = viewport.Y;
    std::optional<ResolvedDepth> resolved;
    if (sampleBuffers > 0)
    {
      resolved.emplace(getDepthFormat(source), viewport.Width, viewport.Height);
      glBindFramebuffer(GL_READ_FRAMEBUFFER, source);
      glBlitFramebuffer(x, y, x + viewport.Width, y + viewport.Height, 0, 0, viewport.Width, viewport.Height,
        GL_DEPTH_BUFFER_BIT, GL_NEAREST);
      x = y = 0;
    }
    glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved ? resolved->GetFramebuffer() : source);
    glReadPixels(x, y, viewport.Width, viewport.Height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
    error = glGetError();
  }
  if (error != GL_NO_ERROR)
  {
    throw treeamr::Error(
      "framebuffer: OpenGL error " + std::to_string(error) + " while reading the depth buffer");
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRFramebuffer::DrawOver(vtkRenderer* renderer, const vtkTreeAMRRayImage& image)
{
  vtkOpenGLRenderWindow* window = GetWindow(renderer);
  vtkOpenGLState* state = window->GetState();
  this->Over.Upload(window, image);
  std::string shader = overShader;
  vtkShaderProgram::Substitute(shader, "//TreeAMR::Image::Dec", this->Over.GetDeclaration());
  vtkTreeAMRQuad& quad = this->OverQuads.Get(shader);
  vtkShaderProgram* program = quad.Use(window);

  vtkOpenGLState::ScopedglDepthMask depthMask(state);
  vtkOpenGLState::ScopedglEnableDisable depthTest(state, GL_DEPTH_TEST);
  vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND);
  vtkOpenGLState::ScopedglBlendFuncSeparate blendFunction(state);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglEnable(GL_BLEND);
  state->vtkglBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);

  const vtkTreeAMRRayTexture::Binding binding(this->Over, program);
  quad.Draw();
}

//------------------------------------------------------------------------------
bool vtkTreeAMRFramebuffer::WantsGeometry(vtkProp* prop)
{
  const std::vector<vtkOpenGLRenderPass*> passes = getPasses(prop);
  return std::any_of(passes.begin(), passes.end(), isAmbientOcclusion);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRFramebuffer::IsDepthPeeling(vtkProp* prop)
{
  const std::vector<vtkOpenGLRenderPass*> passes = getPasses(prop);
  return std::any_of(passes.begin(), passes.end(),
    [](vtkOpenGLRenderPass* pass) { return pass->IsA("vtkDepthPeelingPass") != 0; });
}

//------------------------------------------------------------------------------
vtkTreeAMRQuad& vtkTreeAMRFramebuffer::SurfaceQuad(vtkActor* actor, vtkAbstractMapper* mapper, bool full)
{
  std::string vertexShader;
  std::string geometryShader;
  std::string fragmentShader = surfaceShader;
  const std::vector<vtkOpenGLRenderPass*> passes = getPasses(actor);
  for (vtkOpenGLRenderPass* pass : passes)
  {
    pass->PreReplaceShaderValues(vertexShader, geometryShader, fragmentShader, mapper, actor);
  }
  if (!full)
  {
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Slope::Dec", slopeDeclaration);
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Slope::Impl", slopeImplementation);
  }
  if (WantsGeometry(actor))
  {
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Geometry::Dec", geometryDeclarations);
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Geometry::Impl", geometryOutputs);
  }
  for (vtkOpenGLRenderPass* pass : passes)
  {
    pass->PostReplaceShaderValues(vertexShader, geometryShader, fragmentShader, mapper, actor);
  }
  return this->SurfaceQuads.Get(fragmentShader);
}

//------------------------------------------------------------------------------
void vtkTreeAMRFramebuffer::DrawSurface(vtkRenderer* renderer, vtkActor* actor, vtkAbstractMapper* mapper,
  const vtkTreeAMRSurfaceTextures& textures)
{
  if (textures.NumberOfTiles == 0)
  {
    return;
  }
  vtkOpenGLRenderWindow* window = GetWindow(renderer);
  vtkOpenGLState* state = window->GetState();
  vtkTreeAMRQuad& quad = this->SurfaceQuad(actor, mapper, textures.Full);
  vtkShaderProgram* program = quad.Use(window);
  for (vtkOpenGLRenderPass* pass : getPasses(actor))
  {
    if (isAmbientOcclusion(pass))
    {
      // It gives its position and normal buffers to vtkOpenGLPolyDataMapper alone and would take them away
      // here.
      unsigned int buffers[] = { GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2 };
      state->vtkglDrawBuffers(3, buffers);
    }
    else
    {
      pass->SetShaderParameters(program, mapper, actor, quad.GetVertexArray());
    }
  }

  vtkOpenGLState::ScopedglDepthMask depthMask(state);
  vtkOpenGLState::ScopedglDepthFunc depthFunction(state);
  vtkOpenGLState::ScopedglEnableDisable depthTest(state, GL_DEPTH_TEST);
  vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND);
  // The passes of translucent geometry have their own blending, and depth peeling no depth test.
  if (!actor->IsRenderingTranslucentPolygonalGeometry())
  {
    state->vtkglEnable(GL_DEPTH_TEST);
    state->vtkglDepthFunc(GL_LEQUAL);
    state->vtkglDepthMask(GL_TRUE);
    state->vtkglDisable(GL_BLEND);
  }

  program->SetUniform2f("treeamrTileSize", textures.TileSize);
  const vtkTreeAMRFloatTexture::Binding tiles(textures.Tiles, program, "treeamrTiles");
  const vtkTreeAMRFloatTexture::Binding runs(textures.Runs, program, "treeamrRuns");
  const vtkTreeAMRFloatTexture::Binding color(textures.Color, program, "treeamrColor");
  const vtkTreeAMRFloatTexture::Binding depth(textures.Depth, program, "treeamrDepth");
  std::optional<vtkTreeAMRFloatTexture::Binding> slope;
  if (!textures.Full)
  {
    slope.emplace(textures.Slope, program, "treeamrSlope");
  }
  std::optional<vtkTreeAMRFloatTexture::Binding> position;
  std::optional<vtkTreeAMRFloatTexture::Binding> normal;
  if (textures.Geometry)
  {
    position.emplace(textures.Position, program, "treeamrPosition");
    normal.emplace(textures.Normal, program, "treeamrNormal");
  }
  quad.Draw(textures.NumberOfTiles);
}

//------------------------------------------------------------------------------
void vtkTreeAMRFramebuffer::ReleaseGraphicsResources(vtkWindow* window)
{
  this->OverQuads.ReleaseGraphicsResources();
  this->Over.ReleaseGraphicsResources(window);
  this->SurfaceQuads.ReleaseGraphicsResources();
}

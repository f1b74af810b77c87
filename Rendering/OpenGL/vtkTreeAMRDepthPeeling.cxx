#include "vtkTreeAMRDepthPeeling.h"

#include "RenderPasses.h"
#include "vtkTreeAMRTarget.h"

#include "Error.h"
#include "LargeArray.h"

#include "vtkObject.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4
#include "vtkOpenGLRenderPass.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkProp.h"
#include "vtkRenderer.h"
#include "vtkShaderProgram.h"

#include <optional>
#include <string>

namespace
{

// Uniforms that a shader does not use do not exist: this one uses all that are asked for. The pass offers the
// opaque depth as well; it is in outerDepthTex already, for nothing translucent behind it is peeled.
const char* const probeShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
uniform sampler2D innerDepthTex;
uniform sampler2D outerDepthTex;
uniform sampler2D lastFrontColorTex;
uniform sampler2D depthRangeTex;
void main()
{
  gl_FragData[0] = texture2D(innerDepthTex, texCoord) + texture2D(outerDepthTex, texCoord) +
    texture2D(lastFrontColorTex, texCoord) + texture2D(depthRangeTex, texCoord);
}
)";

const char* const opaqueShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
uniform sampler2D opaqueDepth;
void main()
{
  gl_FragData[0] = texture2D(opaqueDepth, texCoord);
}
)";

const char* const outsideShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
//TreeAMR::Front::Dec
//TreeAMR::Back::Dec
void main()
{
  gl_FragData[0] = treeamrBack();
  gl_FragData[1] = treeamrFront();
}
)";

// The front buffer is blended by maximum: it takes everything in front so far, put under the last peel here.
const char* const peelShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
//TreeAMR::Front::Dec
//TreeAMR::Back::Dec
uniform sampler2D lastFrontColorTex;
void main()
{
  vec4 front = treeamrFront();
  vec4 last = texture2D(lastFrontColorTex, texCoord);
  gl_FragData[0] = treeamrBack();
  gl_FragData[1] = last + (1.0 - last.a) * front;
}
)";

const char* const remainderShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
//TreeAMR::Back::Dec
void main()
{
  gl_FragData[0] = treeamrBack();
}
)";

bool declares(const std::string& shader, const char* sampler)
{
  return shader.find(sampler) != std::string::npos;
}

// The unit that a pass put into a sampler of the current program.
GLint getTextureUnit(vtkShaderProgram* program, const char* sampler)
{
  const GLint location = glGetUniformLocation(static_cast<GLuint>(program->GetHandle()), sampler);
  if (location < 0)
  {
    throw treeamr::Error(std::string("depth peeling: the probe shader has no sampler ") + sampler);
  }
  GLint unit = 0;
  glGetUniformiv(static_cast<GLuint>(program->GetHandle()), location, &unit);
  return unit;
}

// The texture in that unit: height x width pairs.
treeamr::LargeArray<float> readDepths(vtkShaderProgram* program, const char* sampler, int width, int height)
{
  const GLint unit = getTextureUnit(program, sampler);
  treeamr::LargeArray<float> values =
    treeamr::makeLargeArray<float>(2 * static_cast<std::size_t>(width) * height);

  vtkTreeAMRTarget::DiscardErrors();
  GLint activeTexture = GL_TEXTURE0;
  GLint packAlignment = 4;
  GLint packBuffer = 0;
  glGetIntegerv(GL_ACTIVE_TEXTURE, &activeTexture);
  glGetIntegerv(GL_PACK_ALIGNMENT, &packAlignment);
  glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &packBuffer);
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  GLint textureWidth = 0;
  GLint textureHeight = 0;
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &textureWidth);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &textureHeight);
  const bool fits = textureWidth == width && textureHeight == height;
  if (fits)
  {
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RG, GL_FLOAT, values.get());
  }
  const GLenum error = glGetError();
  glPixelStorei(GL_PACK_ALIGNMENT, packAlignment);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(packBuffer));
  glActiveTexture(static_cast<GLenum>(activeTexture));

  if (!fits || error != GL_NO_ERROR)
  {
    throw treeamr::Error(std::string("depth peeling: texture ") + sampler + " has " +
      std::to_string(textureWidth) + " x " + std::to_string(textureHeight) + " pixels, the viewport " +
      std::to_string(width) + " x " + std::to_string(height) + " (OpenGL error " + std::to_string(error) +
      ")");
  }
  return values;
}

// The pass's depth textures hold (-nearest, farthest), because they are blended by maximum; -1 is "none".
constexpr float none = -1.f;

// Of what is opaque, from its texture, which has the same depth twice; 1 where nothing is.
void readOpaqueDepths(
  vtkShaderProgram* program, const char* sampler, int width, int height, std::vector<float>& depth)
{
  const treeamr::LargeArray<float> pairs = readDepths(program, sampler, width, height);
  depth.resize(static_cast<std::size_t>(width) * height);
  for (std::size_t i = 0; i < depth.size(); ++i)
  {
    depth[i] = pairs[2 * i + 1] == none ? 1.f : pairs[2 * i + 1];
  }
}

} // anonymous namespace

//------------------------------------------------------------------------------
vtkTreeAMRDepthPeeling::vtkTreeAMRDepthPeeling()
  : ProbeQuad(probeShader)
  , OpaqueQuad(opaqueShader)
{
}

//------------------------------------------------------------------------------
vtkOpenGLRenderPass* vtkTreeAMRDepthPeeling::FindPass(vtkProp* volume)
{
  return treeamr::findRenderPass(volume, "vtkDualDepthPeelingPass");
}

//------------------------------------------------------------------------------
bool vtkTreeAMRDepthPeeling::IsPeeling(vtkProp* volume)
{
  return FindPass(volume) != nullptr;
}

//------------------------------------------------------------------------------
vtkTreeAMRDepthPeeling::Stage vtkTreeAMRDepthPeeling::FindStage(
  vtkOpenGLRenderPass* pass, vtkAbstractMapper* mapper, vtkProp* volume)
{
  std::string vertexShader;
  std::string geometryShader;
  std::string fragmentShader = "//VTK::DepthPeeling::Dec\n";
  pass->PreReplaceShaderValues(vertexShader, geometryShader, fragmentShader, mapper, volume);
  if (declares(fragmentShader, "depthRangeTex"))
  {
    return Stage::Remainder;
  }
  if (declares(fragmentShader, "lastFrontColorTex"))
  {
    return Stage::Peel;
  }
  if (declares(fragmentShader, "innerDepthTex"))
  {
    return Stage::Outside;
  }
  throw treeamr::Error("depth peeling: a stage of vtkDualDepthPeelingPass that is not known here");
}

//------------------------------------------------------------------------------
bool vtkTreeAMRDepthPeeling::IsFirstStage(vtkAbstractMapper* mapper, vtkProp* volume)
{
  vtkOpenGLRenderPass* pass = FindPass(volume);
  return pass && FindStage(pass, mapper, volume) == Stage::Outside;
}

//------------------------------------------------------------------------------
vtkShaderProgram* vtkTreeAMRDepthPeeling::Probe(
  vtkRenderer* renderer, vtkAbstractMapper* mapper, vtkProp* volume)
{
  vtkOpenGLRenderPass* pass = FindPass(volume);
  if (!pass)
  {
    throw treeamr::Error("depth peeling: the volume is in no vtkDualDepthPeelingPass");
  }
  this->CurrentStage = FindStage(pass, mapper, volume);
  vtkShaderProgram* program = this->ProbeQuad.Use(vtkTreeAMRTarget::GetWindow(renderer));
  pass->SetShaderParameters(program, mapper, volume, this->ProbeQuad.GetVertexArray());
  return program;
}

//------------------------------------------------------------------------------
void vtkTreeAMRDepthPeeling::BeginWithoutPeels(vtkRenderer* renderer, vtkAbstractMapper* mapper,
  vtkProp* volume, int width, int height, std::vector<float>& depth)
{
  readOpaqueDepths(this->Probe(renderer, mapper, volume), "outerDepthTex", width, height, depth);
}

//------------------------------------------------------------------------------
void vtkTreeAMRDepthPeeling::Begin(vtkRenderer* renderer, vtkAbstractMapper* mapper, vtkProp* volume,
  int width, int height, vtkTreeAMRRaySegments& front, vtkTreeAMRRaySegments& back)
{
  vtkShaderProgram* program = this->Probe(renderer, mapper, volume);
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  for (vtkTreeAMRRaySegments* segments : { &front, &back })
  {
    segments->Begin.assign(pixels, 0.f);
    segments->End.assign(pixels, 0.f);
  }

  if (this->CurrentStage == Stage::Remainder)
  {
    const treeamr::LargeArray<float> range = readDepths(program, "depthRangeTex", width, height);
    for (std::size_t i = 0; i < pixels; ++i)
    {
      if (range[2 * i] != none)
      {
        back.Begin[i] = -range[2 * i];
        back.End[i] = range[2 * i + 1];
      }
    }
    return;
  }

  const treeamr::LargeArray<float> inner = readDepths(program, "innerDepthTex", width, height);
  const treeamr::LargeArray<float> outer = readDepths(program, "outerDepthTex", width, height);
  if (this->CurrentStage == Stage::Outside)
  {
    // inner: the translucent surfaces, else the opaque one; outer: the opaque surface.
    for (std::size_t i = 0; i < pixels; ++i)
    {
      const float opaque = outer[2 * i + 1];
      back.End[i] = opaque >= 0.f ? opaque : 1.f;
      if (inner[2 * i] != none)
      {
        front.End[i] = -inner[2 * i];
        back.Begin[i] = inner[2 * i + 1];
      }
    }
    return;
  }

  // outer: the surfaces of this peel, or the opaque one; inner: those of the next peel.
  this->LastFrontColorUnit = getTextureUnit(program, "lastFrontColorTex");
  for (std::size_t i = 0; i < pixels; ++i)
  {
    if (outer[2 * i] == none)
    {
      continue;
    }
    front.Begin[i] = -outer[2 * i];
    if (inner[2 * i] == none)
    {
      front.End[i] = outer[2 * i + 1];
    }
    else
    {
      front.End[i] = -inner[2 * i];
      back.Begin[i] = inner[2 * i + 1];
      back.End[i] = outer[2 * i + 1];
    }
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRDepthPeeling::ReadOpaqueDepth(vtkRenderer* renderer, vtkAbstractMapper* mapper,
  vtkProp* surface, int width, int height, std::vector<float>& depth)
{
  vtkOpenGLRenderPass* pass = FindPass(surface);
  if (!pass)
  {
    return false;
  }
  std::string vertexShader;
  std::string geometryShader;
  std::string fragmentShader = "//VTK::DepthPeeling::Dec\n";
  pass->PostReplaceShaderValues(vertexShader, geometryShader, fragmentShader, mapper, surface);
  if (!declares(fragmentShader, "opaqueDepth"))
  {
    return false;
  }
  vtkShaderProgram* program = this->OpaqueQuad.Use(vtkTreeAMRTarget::GetWindow(renderer));
  pass->SetShaderParameters(program, mapper, surface, this->OpaqueQuad.GetVertexArray());
  readOpaqueDepths(program, "opaqueDepth", width, height, depth);
  return true;
}

//------------------------------------------------------------------------------
const char* vtkTreeAMRDepthPeeling::StageShader() const
{
  switch (this->CurrentStage)
  {
    case Stage::Outside:
      return outsideShader;
    case Stage::Peel:
      return peelShader;
    case Stage::Remainder:
      break;
  }
  return remainderShader;
}

//------------------------------------------------------------------------------
void vtkTreeAMRDepthPeeling::Draw(
  vtkRenderer* renderer, const vtkTreeAMRRayImage* front, const vtkTreeAMRRayImage& back)
{
  vtkOpenGLRenderWindow* window = vtkTreeAMRTarget::GetWindow(renderer);
  const bool hasFront = front && this->CurrentStage != Stage::Remainder;
  std::string shader = this->StageShader();
  this->Back.Upload(window, back);
  vtkShaderProgram::Substitute(shader, "//TreeAMR::Back::Dec", this->Back.GetDeclaration());
  if (hasFront)
  {
    this->Front.Upload(window, *front);
    vtkShaderProgram::Substitute(shader, "//TreeAMR::Front::Dec", this->Front.GetDeclaration());
  }
  else
  {
    vtkShaderProgram::Substitute(shader, "treeamrFront()", "vec4(0.0)");
  }
  vtkTreeAMRQuad& quad = this->StageQuads.Get(shader);
  vtkShaderProgram* program = quad.Use(window);
  const vtkTreeAMRRayTexture::Binding backBinding(this->Back, program);
  std::optional<vtkTreeAMRRayTexture::Binding> frontBinding;
  if (hasFront)
  {
    frontBinding.emplace(this->Front, program);
  }
  if (this->CurrentStage == Stage::Peel)
  {
    program->SetUniformi("lastFrontColorTex", this->LastFrontColorUnit);
  }
  quad.Draw(); // blending is the pass's
}

//------------------------------------------------------------------------------
void vtkTreeAMRDepthPeeling::ReleaseGraphicsResources(vtkWindow* window)
{
  this->ProbeQuad.ReleaseGraphicsResources();
  this->OpaqueQuad.ReleaseGraphicsResources();
  this->StageQuads.ReleaseGraphicsResources();
  this->Front.ReleaseGraphicsResources(window);
  this->Back.ReleaseGraphicsResources(window);
}

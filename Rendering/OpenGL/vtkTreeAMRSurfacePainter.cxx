#include "vtkTreeAMRSurfacePainter.h"

#include "RenderPasses.h"
#include "vtkTreeAMRTarget.h"

#include "vtkActor.h"
#include "vtkObject.h"
#include "vtkOpenGLError.h" // brings the GL loader of this VTK: glew up to 9.3, glad from 9.4
#include "vtkOpenGLRenderPass.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkRenderer.h"
#include "vtkShaderProgram.h"

#include <optional>
#include <string>
#include <vector>

namespace
{

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

} // anonymous namespace

//------------------------------------------------------------------------------
vtkTreeAMRSurfacePainter::vtkTreeAMRSurfacePainter()
  : Quads(surfaceVertexShader)
{
}

//------------------------------------------------------------------------------
vtkTreeAMRQuad& vtkTreeAMRSurfacePainter::GetQuad(vtkActor* actor, vtkAbstractMapper* mapper, bool full)
{
  std::string vertexShader;
  std::string geometryShader;
  std::string fragmentShader = surfaceShader;
  const std::vector<vtkOpenGLRenderPass*> passes = treeamr::renderPasses(actor);
  for (vtkOpenGLRenderPass* pass : passes)
  {
    pass->PreReplaceShaderValues(vertexShader, geometryShader, fragmentShader, mapper, actor);
  }
  if (!full)
  {
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Slope::Dec", slopeDeclaration);
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Slope::Impl", slopeImplementation);
  }
  if (treeamr::wantsGeometry(actor))
  {
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Geometry::Dec", geometryDeclarations);
    vtkShaderProgram::Substitute(fragmentShader, "//TreeAMR::Geometry::Impl", geometryOutputs);
  }
  for (vtkOpenGLRenderPass* pass : passes)
  {
    pass->PostReplaceShaderValues(vertexShader, geometryShader, fragmentShader, mapper, actor);
  }
  return this->Quads.Get(fragmentShader);
}

//------------------------------------------------------------------------------
void vtkTreeAMRSurfacePainter::Draw(vtkRenderer* renderer, vtkActor* actor, vtkAbstractMapper* mapper,
  const vtkTreeAMRSurfaceTextures& textures)
{
  if (textures.NumberOfTiles == 0)
  {
    return;
  }
  vtkOpenGLRenderWindow* window = vtkTreeAMRTarget::GetWindow(renderer);
  vtkOpenGLState* state = window->GetState();
  vtkTreeAMRQuad& quad = this->GetQuad(actor, mapper, textures.Full);
  vtkShaderProgram* program = quad.Use(window);
  for (vtkOpenGLRenderPass* pass : treeamr::renderPasses(actor))
  {
    if (pass->IsA("vtkSSAOPass"))
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
void vtkTreeAMRSurfacePainter::ReleaseGraphicsResources()
{
  this->Quads.ReleaseGraphicsResources();
}

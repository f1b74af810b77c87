#include "vtkTreeAMRRayImage.h"

#include "vtkOpenGLRenderWindow.h"
#include "vtkShaderProgram.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace
{

const char* const noMagnification = R"(uniform sampler2D NAMEColor;
vec4 NAME()
{
  return texture2D(NAMEColor, texCoord);
}
)";

const char* const bilinearMagnification = R"(uniform sampler2D NAMEColor;
SHIFT_DECLARATION
vec4 NAME()
{
  vec2 at = texCoord * vec2(textureSize(NAMEColor, 0)) - 0.5;
  vec2 f = fract(at);
  ivec2 last = textureSize(NAMEColor, 0) - 1;
  ivec2 low = clamp(ivec2(floor(at)), ivec2(0), last);
  ivec2 high = clamp(ivec2(floor(at)) + 1, ivec2(0), last);
  ivec2 lowHigh = ivec2(low.x, high.y);
  ivec2 highLow = ivec2(high.x, low.y);
  vec4 w = vec4(1.0 - f.x, f.x, 1.0 - f.x, f.x) * vec4(vec2(1.0 - f.y), vec2(f.y));
SHIFT_IMPLEMENTATION
  return w.x * texelFetch(NAMEColor, low, 0) + w.y * texelFetch(NAMEColor, highLow, 0) +
    w.z * texelFetch(NAMEColor, lowHigh, 0) + w.w * texelFetch(NAMEColor, high, 0);
}
)";

const char* const shiftDeclaration = R"(uniform sampler2D NAMERayLength;
uniform sampler2D NAMEPixelLength;
)";
// From the bilinear weights towards those texels alone whose lengths differ from the mean as the pixel's
// does.
const char* const shiftImplementation = R"(
  vec4 lengths = vec4(texelFetch(NAMERayLength, low, 0).r, texelFetch(NAMERayLength, highLow, 0).r,
    texelFetch(NAMERayLength, lowHigh, 0).r, texelFetch(NAMERayLength, high, 0).r);
  float mean = dot(w, lengths);
  float wanted = texture2D(NAMEPixelLength, texCoord).r - mean;
  vec4 beyond = max(sign(wanted) * (lengths - mean), 0.0);
  float sum = dot(w, beyond);
  if (sum > 0.0)
  {
    vec4 side = w * beyond / sum;
    w = mix(w, side, min(abs(wanted) / dot(side, beyond), 1.0));
  }
)";

} // anonymous namespace

//------------------------------------------------------------------------------
bool vtkTreeAMRRaySegments::IsEmpty() const
{
  for (std::size_t i = 0; i < this->End.size(); ++i)
  {
    if ((this->Begin.empty() ? 0.f : this->Begin[i]) < this->End[i])
    {
      return false;
    }
  }
  return !this->End.empty();
}

//------------------------------------------------------------------------------
void vtkTreeAMRRaySegments::Simplify()
{
  if (std::all_of(this->Begin.begin(), this->Begin.end(), [](float depth) { return depth == 0.f; }))
  {
    this->Begin.clear();
    if (std::all_of(this->End.begin(), this->End.end(), [](float depth) { return depth == 1.f; }))
    {
      this->End.clear();
    }
  }
}

//------------------------------------------------------------------------------
std::vector<float> vtkTreeAMRRaySegments::GetLengths() const
{
  std::vector<float> lengths = this->End;
  for (std::size_t i = 0; i < this->Begin.size(); ++i)
  {
    lengths[i] = std::max(0.f, this->End[i] - this->Begin[i]);
  }
  return lengths;
}

//------------------------------------------------------------------------------
vtkTreeAMRRaySegments vtkTreeAMRRaySegments::Reduce(const treeamr::ImageReduction& reduction) const
{
  const auto sample = [&](const std::vector<float>& values) {
    return values.empty() ? values : reduction.sample(values);
  };
  return { sample(this->Begin), sample(this->End) };
}

//------------------------------------------------------------------------------
vtkTreeAMRRayTexture::vtkTreeAMRRayTexture(std::string name)
  : Name(std::move(name))
{
}

//------------------------------------------------------------------------------
void vtkTreeAMRRayTexture::Upload(vtkOpenGLRenderWindow* window, const vtkTreeAMRRayImage& image)
{
  const treeamr::ImageReduction& reduction = image.Reduction;
  const std::vector<float>& lengths = image.Lengths;
  this->Color.Upload(window, reduction.width(), reduction.height(), 4, image.Image.rgba.data());
  this->RayLength.ReleaseGraphicsResources(window);
  this->PixelLength.ReleaseGraphicsResources(window);
  if (reduction.isFull())
  {
    this->Mode = Magnification::None;
  }
  else if (std::all_of(lengths.begin(), lengths.end(), [&](float l) { return l == lengths.front(); }))
  {
    this->Mode = Magnification::Bilinear;
  }
  else
  {
    this->Mode = Magnification::ByLength;
    this->RayLength.Upload(
      window, reduction.width(), reduction.height(), 1, reduction.sample(lengths).data());
    this->PixelLength.Upload(window, reduction.fullWidth(), reduction.fullHeight(), 1, lengths.data());
  }
}

//------------------------------------------------------------------------------
std::string vtkTreeAMRRayTexture::GetDeclaration() const
{
  const bool shift = this->Mode == Magnification::ByLength;
  std::string code = this->Mode == Magnification::None ? noMagnification : bilinearMagnification;
  vtkShaderProgram::Substitute(code, "SHIFT_DECLARATION", shift ? shiftDeclaration : "");
  vtkShaderProgram::Substitute(code, "SHIFT_IMPLEMENTATION", shift ? shiftImplementation : "");
  vtkShaderProgram::Substitute(code, "NAME", this->Name);
  return code;
}

//------------------------------------------------------------------------------
void vtkTreeAMRRayTexture::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Color.ReleaseGraphicsResources(window);
  this->RayLength.ReleaseGraphicsResources(window);
  this->PixelLength.ReleaseGraphicsResources(window);
}

//------------------------------------------------------------------------------
vtkTreeAMRRayTexture::Binding::Binding(vtkTreeAMRRayTexture& texture, vtkShaderProgram* program)
  : Color(texture.Color, program, (texture.Name + "Color").c_str())
{
  if (texture.Mode == Magnification::ByLength)
  {
    this->RayLength.emplace(texture.RayLength, program, (texture.Name + "RayLength").c_str());
    this->PixelLength.emplace(texture.PixelLength, program, (texture.Name + "PixelLength").c_str());
  }
}

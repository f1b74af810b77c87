// An image of rays on its way to a viewport's pixels, of which it may have fewer.
//
// Where the image is full, a pixel is a texel. A reduced image is magnified bilinearly, with edges in common.
// Where rays ended at other depths than a pixel's own ray would, the weights of the four texels around it are
// shifted so that their rays' lengths average to the pixel's: fog behind the edge of a surface does not show
// in front of it, and on a plane, whose depth is linear in the window, nothing is shifted.
#pragma once

#include "Geometry/Image.h"
#include "ImageReduction.h"
#include "vtkTreeAMRQuad.h"

#include <optional>
#include <string>
#include <vector>

class vtkOpenGLRenderWindow;
class vtkShaderProgram;
class vtkWindow;

/// A part of each pixel's ray in window depths, lower left first; nothing where Begin >= End.
struct vtkTreeAMRRaySegments
{
  std::vector<float> Begin; // empty: 0 everywhere
  std::vector<float> End;   // empty: 1 everywhere, and then Begin is empty, too

  /// Whether there is nothing to trace.
  bool IsEmpty() const;
  /// Renderers need not look at each ray's ends where all are the whole.
  void Simplify();
  /// End - Begin, at least 0; empty when End is.
  std::vector<float> GetLengths() const;
  vtkTreeAMRRaySegments Reduce(const treeamr::ImageReduction& reduction) const;
};

struct vtkTreeAMRRayImage
{
  treeamr::ImageReduction Reduction;
  treeamr::Image Image; // of the reduction's size, premultiplied
  /// Of the segments of the viewport's pixels, only for reduced images; empty: all alike.
  std::vector<float> Lengths;
};

/// Such an image for the shader of a vtkTreeAMRQuad.
class vtkTreeAMRRayTexture
{
public:
  /// The shader finds it as function `vec4 name()`.
  explicit vtkTreeAMRRayTexture(std::string name);
  vtkTreeAMRRayTexture(const vtkTreeAMRRayTexture&) = delete;
  vtkTreeAMRRayTexture& operator=(const vtkTreeAMRRayTexture&) = delete;

  /// Throws treeamr::Error when the driver refuses.
  void Upload(vtkOpenGLRenderWindow* window, const vtkTreeAMRRayImage& image);
  /// GLSL for the image that was uploaded: it goes where its function is to be declared.
  std::string GetDeclaration() const;
  void ReleaseGraphicsResources(vtkWindow* window);

  /// Binds the textures for its own lifetime.
  class Binding
  {
  public:
    Binding(vtkTreeAMRRayTexture& texture, vtkShaderProgram* program);

  private:
    vtkTreeAMRFloatTexture::Binding Color;
    std::optional<vtkTreeAMRFloatTexture::Binding> RayLength;
    std::optional<vtkTreeAMRFloatTexture::Binding> PixelLength;
  };

private:
  enum class Magnification
  {
    None,
    Bilinear,
    ByLength
  };
  std::string Name;
  Magnification Mode = Magnification::None;
  vtkTreeAMRFloatTexture Color;
  vtkTreeAMRFloatTexture RayLength;
  vtkTreeAMRFloatTexture PixelLength;
};

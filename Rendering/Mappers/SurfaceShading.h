// From the hits of an isosurface to the points of a lit surface. Private to the module.
#pragma once

#include "SurfaceColors.h"
#include "vtkTreeAMRSurfaceImage.h"

#include "Geometry/Image.h"
#include "Geometry/RayStops.h"
#include "Surface/Isosurface.h"
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Shading.h"
#include "Surface/SurfaceFrame.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace treeamr
{

/// Of the surface of one isovalue.
struct SurfaceMaterial
{
  Material material;
  float opacity = 1.f;
};

/// What all hits share.
struct SurfaceAppearance
{
  /// Of each surface; empty: all have `material` and `opacity`.
  std::vector<SurfaceMaterial> surfaces;
  Material material;
  std::vector<Light> lights;
  bool opaque = true; // whatever the opacities of colours
  float opacity = 1.f;
  /// Whether each trilinear piece shows its own gradient, which changes abruptly from one to the next.
  bool flat = false;
  /// Factors of the colours that replace the material's ambient and diffuse ones, when there are such
  /// colours.
  float ambientOfColors = 0.f;
  float diffuseOfColors = 1.f;
};

/// What secondary rays found; each may be empty.
struct SurfaceVisibility
{
  std::vector<float> open;       // the part of each hit's surroundings that is
  std::vector<std::uint8_t> lit; // lit[l + lights * hit]
};

/// Values of a field at the hits, less its offset, into every stride-th of `values`; NaN where it has no cell.
void valuesAtHits(const std::shared_ptr<const Field>& field, const Camera& camera, const HitImage& hits,
  std::size_t stride, float* values);

/// A pixel's ray, and the way back along it in view coordinates.
struct Sight
{
  Ray ray;
  Vec3 toEye;
};

/// Lights hits in view coordinates, which are the camera's world. The surface blocks light like a layer of its
/// opacity. What it is made of must outlive it.
class SurfaceShader
{
public:
  SurfaceShader(const HitImage& hits, const Camera& camera, SurfaceAppearance appearance,
    const SurfaceVisibility& visibility, HitColors colors);

  const HitImage& hits() const noexcept { return *hits_; }
  const Camera& camera() const noexcept { return *camera_; }
  Sight sight(std::size_t pixel) const noexcept;
  /// Colour, not premultiplied, and opacity of a hit of the pixel that the sight is of.
  std::array<float, 4> operator()(std::size_t hit, const Sight& sight) const noexcept;
  /// The same in three steps, for many hits at once, where lightsTogether(): adds a hit, and returns its opacity; lights
  /// all; what comes of the one that got this colour.
  bool lightsTogether() const noexcept { return lightsTogether_; }
  float add(std::size_t hit, const Sight& sight, HitsToLight& hits) const noexcept;
  void light(HitsToLight& hits) const noexcept;
  std::array<float, 4> lit(std::size_t hit, const std::array<float, 3>& rgb, float opacity) const noexcept;
  /// The change of the window depth of its tangent plane over the whole image, along x and y; less, where that
  /// would leave the surface within a pixel.
  std::array<float, 2> depthSlope(std::size_t hit, const Sight& sight) const noexcept;

private:
  SurfaceMaterial materialOf(std::size_t hit) const noexcept;

  const HitImage* hits_;
  const Camera* camera_;
  SurfaceFrame frame_;
  SurfaceAppearance appearance_;
  const SurfaceVisibility* visibility_;
  HitColors colors_;
  bool lightsTogether_; // whether lightHits() can
};

/// Walks through the hits of one pixel in pictures of one size, taken from one place: nearest first.
class LayerWalk
{
public:
  explicit LayerWalk(std::span<const SurfaceShader> shaders);

  void start(std::size_t pixel);
  /// To the first hit, then to the next ones; false: there are no more.
  bool next();
  double depth() const noexcept
  {
    const Source& source = sources_[current_];
    return sources_.size() > 1 ? source.depth : source.depthOfHit();
  }
  /// On a camera's ray of the pixel.
  double t(const Camera& camera, const Ray& ray) const noexcept;
  /// Which of the shaders' hits it is, and its sight.
  std::size_t source() const noexcept { return current_; }
  const SurfaceShader& shader() const noexcept { return *sources_[current_].shader; }
  std::size_t hit() const noexcept { return sources_[current_].hit; }
  const Sight& sight() const noexcept { return sources_[current_].sight; }
  std::array<float, 2> depthSlope() const noexcept;

private:
  struct Source
  {
    const SurfaceShader* shader;
    std::size_t hit = 0;
    std::size_t end = 0;
    double depth = 0.; // in the window, of that hit: by which several sources are compared
    Sight sight{};

    double depthOfHit() const noexcept;
  };
  std::vector<Source> sources_;
  std::size_t current_ = 0;
  bool isStarted_ = false;
};

/// Fills all of the image but Position, Normal and, unless it is asked for, Slope.
void shadeHits(const SurfaceShader& shader, bool withSlope, vtkTreeAMRSurfaceImage& image);

/// Makes one layer, where the nearest is, of all that lie before the window depths `depth` of the pixels: blended in
/// their order, as far as light comes through. At least one shader, all with pictures of one size, taken from one
/// place. Fills what shadeHits() fills.
void flattenLayers(std::span<const SurfaceShader> shaders, std::span<const float> depth, bool withSlope,
  vtkTreeAMRSurfaceImage& image);
/// The same layer as an image.
void flattenLayers(std::span<const SurfaceShader> shaders, std::span<const float> depth, Image& image);

/// Layers of several pictures on their way through a volume.
struct CollectedLayers
{
  LargeVector<std::size_t> first; // of each pixel's, and their end
  LargeVector<TranslucentHit> layers;

  TranslucentHits hits() const noexcept { return { first, layers }; }
};
/// For a camera that takes the same picture: layers, as far as light comes through, before the window depths, which
/// may be none. Places of those behind are infinite.
void collectLayers(std::span<const SurfaceShader> shaders, const Camera& camera, std::span<const float> depth,
  CollectedLayers& layers);

/// RGB of a hit. Called from several threads.
using HitColor = std::function<std::array<float, 3>(const SurfaceHit&)>;
/// The nearest hits in colours without lighting, for hardware selection.
void fillHits(
  const HitImage& hits, const Camera& camera, const HitColor& color, vtkTreeAMRSurfaceImage& image);

/// Fills Position and Normal of the image.
void placeHits(const HitImage& hits, const Camera& camera, vtkTreeAMRSurfaceImage& image);

} // namespace treeamr

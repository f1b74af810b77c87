// From the hits of an isosurface to the points of a lit surface. Private to the module.
#pragma once

#include "SurfaceColors.h"
#include "vtkTreeAMRFramebuffer.h"

#include "Surface/Isosurface.h"
#include "Surface/Shading.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace treeamr
{

/// What all hits share.
struct SurfaceAppearance
{
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

/// Values of a field at the hits into every stride-th of `values`; NaN where it has no cell.
void valuesAtHits(const std::shared_ptr<const Field>& field, const Camera& camera, const HitImage& hits,
  std::size_t stride, float* values);

/// Lights the hits in view coordinates, which are the camera's world. The surface blocks light like a layer
/// of its opacity. Fills all of the image but Position and Normal.
void shadeHits(const HitImage& hits, const Camera& camera, const SurfaceAppearance& appearance,
  const SurfaceVisibility& visibility, const HitColors& colors, vtkTreeAMRSurfaceImage& image);

/// Makes one layer of all that lie before the window depths `depth` of the pixels, blended in their order,
/// where the nearest is.
void flattenLayers(
  const HitImage& hits, const Camera& camera, const std::vector<float>& depth, vtkTreeAMRSurfaceImage& image);

/// Fills Slope of the image, of the depths that shadeHits() has filled.
void slopeHits(const HitImage& hits, const Camera& camera, vtkTreeAMRSurfaceImage& image);

/// RGB of a hit. Called from several threads.
using HitColor = std::function<std::array<float, 3>(const SurfaceHit&)>;
/// The nearest hits in colours without lighting, for hardware selection.
void fillHits(
  const HitImage& hits, const Camera& camera, const HitColor& color, vtkTreeAMRSurfaceImage& image);

/// Fills Position and Normal of the image.
void placeHits(const HitImage& hits, const Camera& camera, vtkTreeAMRSurfaceImage& image);

} // namespace treeamr

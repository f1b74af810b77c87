// From the hits of an isosurface to the pixels of a lit surface. Private to the module.
#pragma once

#include "vtkTreeAMRFramebuffer.h"

#include "RayTracing/Isosurface.h"
#include "RayTracing/Shading.h"

#include <array>
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
  float opacity = 1.f;
  /// Factors of the colours that replace the material's ambient and diffuse ones, when there are such
  /// colours.
  float ambientOfColors = 0.f;
  float diffuseOfColors = 1.f;
};

/// The hits' pixels x + width * y, in the order of the hits.
std::vector<std::size_t> pixelsOfHits(const HitImage& hits);

/// Values of a field at the hits; NaN where it has no cell.
std::vector<float> valuesAtHits(
  const std::shared_ptr<const Field>& field, const Camera& camera, const HitImage& hits);

/// Lights the nearest hits in world coordinates. colors: RGBA of each hit, or null. Fills RGBA and Depth of the
/// image.
void shadeHits(const HitImage& hits, const Camera& camera, const Matrix4& worldFromData,
  const SurfaceAppearance& appearance, const unsigned char* colors, vtkTreeAMRSurfaceImage& image);

/// RGB of a hit. Called from several threads.
using HitColor = std::function<std::array<float, 3>(const SurfaceHit&)>;
/// The nearest hits in colours without lighting, for hardware selection.
void fillHits(
  const HitImage& hits, const Camera& camera, const HitColor& color, vtkTreeAMRSurfaceImage& image);

/// Fills Position and Normal of the image.
void placeHits(
  const HitImage& hits, const Camera& camera, const Matrix4& viewFromData, vtkTreeAMRSurfaceImage& image);

} // namespace treeamr

// Local lighting of opaque hits: VTK's terms (ambient, diffuse, specular) for any number of lights.
#pragma once

#include "Geometry/Camera.h"

#include <array>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Colours include their coefficient.
struct Material
{
  std::array<float, 3> ambient{};
  std::array<float, 3> diffuse{};
  std::array<float, 3> specular{};
  float specularPower = 1.f;
};

/// Whether it has highlights.
inline bool shines(const Material& material) noexcept
{
  return material.specular != std::array<float, 3>{};
}

/// In the coordinates of the points that it shines on.
struct Light
{
  bool positional = false;
  Vec3 position{};         // positional only
  Vec3 direction{};        // the way the light travels, unit length
  double coneAngle = 180.; // half angle in degrees; >= 90: no cone; positional only
  double exponent = 1.;
  Vec3 attenuation{ 1., 0., 0. };              // constant, linear, quadratic
  std::array<float, 3> color{ 1.f, 1.f, 1.f }; // times intensity
  bool castsShadows = true;
  /// Whether the highlight depends on the angle between the light and the normal, as VTK has it for a headlight alone,
  /// rather than on that between the mirrored light and the eye: it is larger then.
  bool highlightByCosine = false;

  bool operator==(const Light&) const = default;
};

/// normal and toEye: unit length; toEye: of materials that shine. lit: of each light, whether nothing stands
/// before it, else the part `opacity` of it is lost; null: all are lit. Returns linear RGB, clamped to [0, 1].
std::array<float, 3> shade(const Material& material, const std::vector<Light>& lights, const Vec3& point,
  const Vec3& normal, const Vec3& toEye, const std::uint8_t* lit = nullptr, float opacity = 1.f) noexcept;

} // namespace treeamr

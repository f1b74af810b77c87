// Local lighting of opaque hits: VTK's terms (ambient, diffuse, specular) for any number of lights.
#pragma once

#include "Geometry/Light.h"

#include <array>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Colours (red, green, blue) include their coefficient.
struct Material
{
  std::array<float, 3> ambient{};  // of light from nowhere
  std::array<float, 3> diffuse{};  // whatever the eye's place
  std::array<float, 3> specular{}; // of highlights
  float specularPower = 1.f;       // larger ones make highlights smaller
};

/// Whether it has highlights.
inline bool shines(const Material& material) noexcept
{
  return material.specular != std::array<float, 3>{};
}

/// normal and toEye: unit length; toEye: of materials that shine. lit: of each light, whether nothing stands
/// before it, else the part `opacity` of it is lost; null: all are lit. Returns linear RGB, clamped to [0, 1].
std::array<float, 3> shade(const Material& material, const std::vector<Light>& lights, const Vec3& point,
  const Vec3& normal, const Vec3& toEye, const std::uint8_t* lit = nullptr, float opacity = 1.f) noexcept;

} // namespace treeamr

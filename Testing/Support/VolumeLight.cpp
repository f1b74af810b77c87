#include "Support/VolumeLight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace treeamr::test
{

double gradientOpacity(const GradientOpacity& function, const Vec3& gradient)
{
  const auto last = static_cast<double>(function.entries.size() - 1);
  const double at = std::min(std::sqrt(dot(gradient, gradient)) / function.longest * last, last);
  const auto entry = std::min(static_cast<std::size_t>(at), function.entries.size() - 2);
  return std::lerp(function.entries[entry], function.entries[entry + 1], at - static_cast<double>(entry));
}

std::array<double, 3> lightVolume(
  const VolumeShading& shading, const Vec3& point, const Vec3& gradient, const std::array<double, 3>& color)
{
  const Matrix4& m = shading.lightsFromData;
  std::array<Vec3, 3> columns; // of directions
  Vec3 at;
  for (int r = 0; r < 3; ++r)
  {
    at[r] = m[4 * r + 3];
    for (int a = 0; a < 3; ++a)
    {
      columns[a][r] = m[4 * r + a];
      at[r] += m[4 * r + a] * point[a];
    }
  }
  // The vector whose product with each column is the gradient's component.
  const double volume = dot(columns[0], cross(columns[1], columns[2]));
  Vec3 normal{};
  for (int a = 0; a < 3; ++a)
  {
    const Vec3 dual = cross(columns[(a + 1) % 3], columns[(a + 2) % 3]);
    for (int r = 0; r < 3; ++r)
    {
      normal[r] += gradient[a] * dual[r] / volume;
    }
  }
  normal = normalized(normal);
  const Vec3 toEye = normalized({ -at[0], -at[1], -at[2] });
  std::array<double, 3> lit;
  for (int c = 0; c < 3; ++c)
  {
    lit[c] = shading.ambient * color[c] + shading.ambientLight[c];
  }
  for (const Light& light : shading.lights)
  {
    Vec3 travels = light.direction;
    double arrives = 1.;
    if (light.positional)
    {
      const Vec3 way{ at[0] - light.position[0], at[1] - light.position[1], at[2] - light.position[2] };
      const double distance = std::sqrt(dot(way, way));
      travels = normalized(way);
      arrives = 1. /
        (light.attenuation[0] + light.attenuation[1] * distance + light.attenuation[2] * distance * distance);
      const double cosine = dot(travels, light.direction);
      if (light.coneAngle < 90.)
      {
        arrives *= cosine >= std::cos(light.coneAngle * std::numbers::pi / 180.)
          ? std::pow(cosine, light.exponent)
          : 0.;
      }
    }
    const double cosine = dot(normal, travels);
    const double facing = shading.twoSided ? std::abs(cosine) : std::max(cosine, 0.);
    if (facing == 0.)
    {
      continue;
    }
    const Vec3 mirrored{ travels[0] - 2. * cosine * normal[0], travels[1] - 2. * cosine * normal[1],
      travels[2] - 2. * cosine * normal[2] };
    const double closeness = dot(mirrored, toEye);
    const double highlight = closeness > 0. ? std::pow(closeness, shading.specularPower) : 0.;
    for (int c = 0; c < 3; ++c)
    {
      lit[c] += arrives *
        (shading.diffuse * light.color[c] * facing * color[c] +
          shading.specular * light.specularColor[c] * highlight);
    }
  }
  for (double& channel : lit)
  {
    channel = std::clamp(channel, 0., 1.);
  }
  return lit;
}

} // namespace treeamr::test

#include "Surface/Shading.h"

#include "Surface/SurfaceFrame.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace treeamr
{

namespace
{

/// Unit direction in which the light travels at the point, and how much of it arrives.
Vec3 incoming(const Light& light, const Vec3& point, double& arrives) noexcept
{
  arrives = 1.;
  if (!light.positional)
  {
    return light.direction;
  }
  Vec3 d;
  for (int a = 0; a < 3; ++a)
  {
    d[a] = point[a] - light.position[a];
  }
  const double distance = std::sqrt(dot(d, d));
  if (distance == 0.)
  {
    arrives = 0.;
    return light.direction;
  }
  for (double& x : d)
  {
    x /= distance;
  }
  const Vec3& k = light.attenuation;
  arrives = 1. / (k[0] + k[1] * distance + k[2] * distance * distance);
  if (light.coneAngle < 90.)
  {
    const double cosine = dot(d, light.direction);
    const bool inside = cosine >= std::cos(light.coneAngle * std::numbers::pi / 180.);
    arrives *= inside ? std::pow(cosine, light.exponent) : 0.;
  }
  return d;
}

} // namespace

std::array<float, 3> shade(const Material& material, const std::vector<Light>& lights, const Vec3& point,
  const Vec3& normal, const Vec3& toEye, const std::uint8_t* lit, float opacity) noexcept
{
  std::array<double, 3> sum{ material.ambient[0], material.ambient[1], material.ambient[2] };
  for (std::size_t l = 0; l < lights.size(); ++l)
  {
    const Light& light = lights[l];
    double strength;
    const Vec3 travels = incoming(light, point, strength);
    strength *= lit && !lit[l] ? 1. - opacity : 1.;
    const double cosine = -dot(normal, travels);
    if (!(cosine > 0.) || !(strength > 0.))
    {
      continue;
    }
    for (int c = 0; c < 3; ++c)
    {
      sum[c] += strength * light.color[c] * cosine * material.diffuse[c];
    }
    if (!shines(material))
    {
      continue;
    }
    double closeness = cosine;
    if (!light.highlightByCosine)
    {
      Vec3 mirrored;
      for (int a = 0; a < 3; ++a)
      {
        mirrored[a] = travels[a] + 2. * cosine * normal[a];
      }
      closeness = std::max(0., dot(mirrored, toEye));
    }
    const double highlight = std::pow(closeness, material.specularPower);
    for (int c = 0; c < 3; ++c)
    {
      sum[c] += strength * light.color[c] * highlight * material.specular[c];
    }
  }
  std::array<float, 3> rgb;
  for (int c = 0; c < 3; ++c)
  {
    rgb[c] = static_cast<float>(std::clamp(sum[c], 0., 1.));
  }
  return rgb;
}

} // namespace treeamr

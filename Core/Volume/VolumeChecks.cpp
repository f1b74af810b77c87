#include "Volume/VolumeChecks.h"

#include "Error.h"

#include <array>
#include <cmath>
#include <string>

namespace treeamr
{

namespace
{

void check(const VolumeShading& shading)
{
  const auto checkAll = [](const char* what, const auto&... numbers) {
    for (const auto& all : { std::span<const double>(numbers)... })
    {
      for (const double number : all)
      {
        if (!std::isfinite(number))
        {
          throw Error("volume: " + std::string(what) + " of " + std::to_string(number) +
            ", allowed are finite numbers");
        }
      }
    }
  };
  const auto three = [](const std::array<float, 3>& rgb) { return Vec3{ rgb[0], rgb[1], rgb[2] }; };
  checkAll("an ambient coefficient", Vec3{ shading.ambient, 0., 0. });
  checkAll("a diffuse coefficient", Vec3{ shading.diffuse, 0., 0. });
  checkAll("a specular coefficient", Vec3{ shading.specular, 0., 0. });
  checkAll("an ambient light", three(shading.ambientLight));
  checkAll("an element of the lights' matrix", shading.lightsFromData);
  if (!(shading.specularPower >= 0.f) || !std::isfinite(shading.specularPower))
  {
    throw Error("volume: a specular power of " + std::to_string(shading.specularPower) +
      ", allowed are finite numbers from 0 on");
  }
  if (shading.scattering)
  {
    const VolumeScattering& scattering = *shading.scattering;
    const bool isAllowed = scattering.blending > 0.f && scattering.blending <= 2.f && scattering.reach >= 0. &&
      std::abs(scattering.anisotropy) < 1.f && scattering.sampleLength >= 0.;
    if (!isAllowed)
    {
      throw Error("volume: scattered light with a blending of " + std::to_string(scattering.blending) +
        ", a reach of " + std::to_string(scattering.reach) + ", an anisotropy of " +
        std::to_string(scattering.anisotropy) + " and samples of " + std::to_string(scattering.sampleLength) +
        ", allowed are a blending above 0 up to 2, lengths from 0 on, and an anisotropy between -1 and 1");
    }
  }
  for (const Light& light : shading.lights)
  {
    checkAll("a property of a light", light.position, light.direction, light.attenuation, three(light.color),
      three(light.specularColor), Vec3{ light.coneAngle, light.exponent, 0. });
  }
}

void check(const GradientOpacity& function)
{
  if (!(function.longest > 0.) || !std::isfinite(function.longest))
  {
    throw Error("volume: a longest gradient of " + std::to_string(function.longest) +
      ", allowed are finite numbers above 0");
  }
  if (function.entries.size() < 2)
  {
    throw Error(
      "volume: gradient opacity of " + std::to_string(function.entries.size()) + " entries, needed are two");
  }
  for (const float entry : function.entries)
  {
    if (!(entry >= 0.f && entry <= 1.f))
    {
      throw Error("volume: a gradient opacity of " + std::to_string(entry) + ", allowed are 0 to 1");
    }
  }
}

} // namespace

void checkVolume(const Camera& camera, const Image& image)
{
  if (image.width != camera.width() || image.height != camera.height())
  {
    throw Error("volume: an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
      " pixels for a camera of " + std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
  }
}

void checkVolume(const Field& field, const TransferFunction& transferFunction)
{
  const Range values = field.range();
  if (transferFunction.hasCategories() &&
    !(values.min >= 0.f && values.max < static_cast<float>(transferFunction.entries().size())))
  {
    throw Error("volume: values from " + std::to_string(values.min) + " to " + std::to_string(values.max) +
      " for " + std::to_string(transferFunction.entries().size()) +
      " categories, allowed are their numbers from 0 on");
  }
}

void checkVolume(const RayView& view, const VolumeSettings& settings)
{
  if (!(settings.samplesPerCell > 0.) || !(settings.samplesPerCell <= VolumeSettings::maxSamplesPerCell))
  {
    throw Error("volume: " + std::to_string(settings.samplesPerCell) +
      " samples per cell, allowed are values above 0 up to " +
      std::to_string(VolumeSettings::maxSamplesPerCell));
  }
  if (!(settings.leastTransmittance > 0.f) || !(settings.leastTransmittance < 1.f))
  {
    throw Error("volume: rays that end with " + std::to_string(settings.leastTransmittance) +
      " of their light, allowed are values above 0 and below 1");
  }
  view.stops.check(view.camera, "volume");
  const bool isComposite = settings.blend == VolumeBlend::Composite;
  if (view.stops.hits && blendsValues(settings.blend))
  {
    throw Error("volume: surfaces in a blend of values, allowed in composites and slices alone");
  }
  if (!isComposite && (!(settings.unitDistance > 0.) || !std::isfinite(settings.unitDistance)))
  {
    throw Error("volume: a unit distance of " + std::to_string(settings.unitDistance) +
      ", allowed are lengths above 0");
  }
  if (settings.blend == VolumeBlend::Slice)
  {
    const auto& [normal, offset] = settings.slice;
    if (!std::isfinite(dot(normal, normal)) || !(dot(normal, normal) > 0.) || !std::isfinite(offset))
    {
      throw Error("volume: a slice by the normal " + std::to_string(normal[0]) + " " +
        std::to_string(normal[1]) + " " + std::to_string(normal[2]) + " at " + std::to_string(offset) +
        ", allowed are finite numbers, not all of the normal 0");
    }
  }
  if (std::isnan(settings.averageRange.min) || std::isnan(settings.averageRange.max))
  {
    throw Error("volume: the range of an average is not a number");
  }
  if (settings.shading)
  {
    check(*settings.shading);
  }
  for (const VolumeShading& shading : settings.componentShading)
  {
    check(shading);
  }
  if (settings.gradientOpacity)
  {
    check(*settings.gradientOpacity);
  }
}

void checkVolume(const Camera& camera, std::span<const PixelGroup> groups, std::span<const float> rgba)
{
  if (rgba.size() != groups.size() * PixelGroup::rgbaSize)
  {
    throw Error("volume: " + std::to_string(rgba.size()) + " floats for " + std::to_string(groups.size()) +
      " groups of pixels, needed are " + std::to_string(PixelGroup::rgbaSize) + " for each");
  }
  for (const auto& [x, y] : groups)
  {
    if (x < 0 || x >= camera.width() || x % PixelGroup::width != 0 || y < 0 || y >= camera.height() ||
      y % PixelGroup::width != 0)
    {
      throw Error("volume: a group of pixels at " + std::to_string(x) + ", " + std::to_string(y) +
        ", allowed are multiples of " + std::to_string(PixelGroup::width) + " in an image of " +
        std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
    }
  }
}

} // namespace treeamr

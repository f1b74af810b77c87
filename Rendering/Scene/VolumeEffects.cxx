#include "VolumeEffects.h"

#include "NewerSettings.h"
#include "SceneConversion.h"

#include "Error.h"
#include "Field/Field.h"
#include "Geometry/Image.h"

#include "vtkImplicitFunction.h"
#include "vtkLight.h"
#include "vtkLightCollection.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPlane.h"
#include "vtkRenderer.h"
#include "vtkVolume.h"
#include "vtkVolumeMapper.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace treeamr
{

namespace
{

/// Of the lights that are switched on.
std::array<float, 3> ambientLight(vtkRenderer* renderer)
{
  std::array<float, 3> sum{};
  vtkLightCollection* collection = renderer->GetLights();
  vtkCollectionSimpleIterator iterator;
  collection->InitTraversal(iterator);
  while (vtkLight* light = collection->GetNextLight(iterator))
  {
    for (int c = 0; c < 3 && light->GetSwitch(); ++c)
    {
      sum[c] += static_cast<float>(light->GetAmbientColor()[c] * light->GetIntensity());
    }
  }
  return sum;
}

/// Across the finest cells.
double largestChange(double range)
{
  return range > 0. ? 0.25 * range : 0.25;
}

double rangeOf(const Field& field)
{
  return static_cast<double>(field.range().max) - field.range().min;
}

} // namespace

VolumeBlend convertBlendMode(int mode)
{
  switch (mode)
  {
    case vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND:
      return VolumeBlend::Maximum;
    case vtkVolumeMapper::MINIMUM_INTENSITY_BLEND:
      return VolumeBlend::Minimum;
    case vtkVolumeMapper::AVERAGE_INTENSITY_BLEND:
      return VolumeBlend::Average;
    case vtkVolumeMapper::ADDITIVE_BLEND:
      return VolumeBlend::Additive;
    case vtkVolumeMapper::SLICE_BLEND:
      return VolumeBlend::Slice;
    default:
      return VolumeBlend::Composite;
  }
}

bool blendsValues(vtkVolumeMapper* mapper)
{
  return blendsValues(convertBlendMode(mapper->GetBlendMode()));
}

std::optional<VolumeShading> convertVolumeShading(vtkRenderer* renderer, vtkVolume* volume, int component)
{
  vtkVolumeProperty* property = volume->GetProperty();
  if (!property->GetShade(0))
  {
    return std::nullopt;
  }
  VolumeShading shading;
  shading.lights = convertLights(renderer);
  const auto ambient = static_cast<float>(property->GetAmbient(component));
  shading.ambient = 0.f;
  shading.diffuse = static_cast<float>(property->GetDiffuse(component));
  shading.specular = static_cast<float>(property->GetSpecular(component));
  shading.specularPower = static_cast<float>(property->GetSpecularPower(component));
  shading.twoSided = renderer->GetTwoSidedLighting();
  shading.lightsFromData = viewFromData(renderer, volume);
  if (shading.lights.size() == 1 && shading.lights[0].highlightByCosine) // a headlight alone
  {
    Light& atEye = shading.lights[0];
    atEye.positional = true;
    atEye.position = {};
    atEye.coneAngle = 180.;
    atEye.attenuation = { 1., 0., 0. };
    shading.ambient = ambient;
    return shading;
  }
  shading.ambientLight = ambientLight(renderer);
  for (float& channel : shading.ambientLight)
  {
    channel *= ambient;
  }
  return shading;
}

bool hasGradientOpacity(vtkVolumeProperty* property)
{
  if (!property->HasGradientOpacity() || property->GetDisableGradientOpacity())
  {
    return false;
  }
  vtkPiecewiseFunction* function = property->GetGradientOpacity();
  return std::strcmp(function->GetType(), "Constant") != 0 || function->GetValue(0.) != 1.;
}

std::optional<GradientOpacity> convertGradientOpacity(vtkVolumeProperty* property, const Field& field)
{
  if (!hasGradientOpacity(property))
  {
    return std::nullopt;
  }
  constexpr int entries = 4096;
  const double largest = largestChange(rangeOf(field));
  GradientOpacity result{ largest / finestWidth(field), std::vector<float>(entries) };
  property->GetGradientOpacity()->GetTable(0., largest, entries, result.entries.data());
  for (float& entry : result.entries)
  {
    entry = std::clamp(std::isnan(entry) ? 0.f : entry, 0.f, 1.f);
  }
  return result;
}

double longestGradient(double range, double finestWidth)
{
  return largestChange(range) / finestWidth;
}

double finestWidth(const Field& field)
{
  const RootGrid& grid = field.octree().grid();
  const Bounds bounds = grid.bounds();
  double sum = 0.;
  for (int a = 0; a < 3; ++a)
  {
    sum += (bounds.max[a] - bounds.min[a]) / static_cast<double>(grid.roots()[a]);
  }
  return std::ldexp(sum / 3., -field.octree().leafLevels());
}

void applyColorWindow(double window, double level, Image& image)
{
  if (window == 1. && level == 0.5)
  {
    return;
  }
  const auto scale = static_cast<float>(1. / window);
  const auto bias = static_cast<float>(0.5 - level / window);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
  {
    for (int c = 0; c < 3; ++c)
    {
      image.rgba[i + c] = std::clamp(scale * image.rgba[i + c] + bias * image.rgba[i + 3], 0.f, 1.f);
    }
  }
}

HalfSpace convertSlice(vtkVolume* volume)
{
  vtkImplicitFunction* function = volume->GetProperty()->GetSliceFunction();
  if (vtkPlane* plane = vtkPlane::SafeDownCast(function))
  {
    const double* const origin = plane->GetOrigin();
    const double* const normal = plane->GetNormal();
    const bool areFinite = std::all_of(origin, origin + 3, [](double x) { return std::isfinite(x); }) &&
      std::all_of(normal, normal + 3, [](double x) { return std::isfinite(x); });
    if (!areFinite || std::all_of(normal, normal + 3, [](double x) { return x == 0.; }))
    {
      std::ostringstream text;
      text << "volume property: a slice function with the Origin (" << origin[0] << ", " << origin[1] << ", "
           << origin[2] << ") and the Normal (" << normal[0] << ", " << normal[1] << ", " << normal[2]
           << "), allowed are finite numbers, not all of the normal 0";
      throw Error(text.str());
    }
    return convertPlane(plane, volume);
  }
  throw Error(std::string("volume property: ") + (function ? function->GetClassName() : "no") +
    (function ? " as slice function, allowed is a vtkPlane" : " slice function, needed is a vtkPlane"));
}

HalfSpace insideOfFaces(HalfSpace slice, const Bounds& domain)
{
  Vec3 size;
  for (int a = 0; a < 3; ++a)
  {
    size[a] = domain.max[a] - domain.min[a];
  }
  // Rays find the domain's face and the plane in single precision, along ways of about its diagonal.
  constexpr double unresolved = 0x1p-18;
  const double least = unresolved * std::sqrt(dot(size, size));
  const double length = std::sqrt(dot(slice.normal, slice.normal));
  for (int a = 0; a < 3; ++a)
  {
    if (!(std::abs(slice.normal[a]) * (1. + 1e-12) >= length) || !(size[a] > 2. * least))
    {
      continue; // not along the face, or nowhere inside
    }
    const double place = slice.offset / slice.normal[a];
    for (const double face : { domain.min[a], domain.max[a] })
    {
      if (std::abs(place - face) < least)
      {
        slice.offset = slice.normal[a] * (face == domain.min[a] ? face + least : face - least);
      }
    }
  }
  return slice;
}

VolumeScattering convertScattering(vtkVolumeProperty* property, const Field& field, float blending,
  float globalIlluminationReach, double sampleDistance)
{
  VolumeScattering scattering;
  scattering.blending = blending;
  scattering.sampleLength = sampleDistance > 0. ? sampleDistance : finestWidth(field);
  const Bounds bounds = field.octree().grid().bounds();
  double longest = 0.;
  for (int a = 0; a < 3; ++a)
  {
    longest = std::max(longest, bounds.max[a] - bounds.min[a]);
  }
  // Between a sample's length and the diagonal of the cube.
  const double most = std::sqrt(3.);
  const double least = std::min(scattering.sampleLength / longest, most);
  scattering.reach = most + (least - most) * std::pow(1. - globalIlluminationReach, 0.33);
  constexpr float extreme = 0.999f; // beyond, one direction has all of the light
  scattering.anisotropy = std::clamp(scatteringAnisotropy(*property), -extreme, extreme);
  return scattering;
}

VolumeSettings convertVolumeEffects(
  vtkRenderer* renderer, vtkVolume* volume, vtkVolumeMapper* mapper, const Field& field, int component)
{
  vtkVolumeProperty* property = volume->GetProperty();
  VolumeSettings settings;
  settings.blend = convertBlendMode(mapper->GetBlendMode());
  settings.nearest = property->GetInterpolationType() == VTK_NEAREST_INTERPOLATION;
  settings.unitDistance = property->GetScalarOpacityUnitDistance(component);
  if (settings.blend == VolumeBlend::Slice)
  {
    settings.slice = insideOfFaces(convertSlice(volume), field.octree().grid().bounds());
  }
  const double* const counted = mapper->GetAverageIPScalarRange();
  const auto relative = [&](double value) {
    constexpr double most = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value - field.offset(), -most, most));
  };
  settings.averageRange = { relative(counted[0]), relative(counted[1]) };
  if (mapper->GetBlendMode() != vtkVolumeMapper::ISOSURFACE_BLEND && !blendsValues(settings.blend))
  {
    settings.shading = convertVolumeShading(renderer, volume);
    settings.gradientOpacity = convertGradientOpacity(property, field);
  }
  return settings;
}

} // namespace treeamr

#include "SceneConversion.h"

#include "Error.h"

#include "vtkCamera.h"
#include "vtkColorTransferFunction.h"
#include "vtkDataArray.h"
#include "vtkLight.h"
#include "vtkLightCollection.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkOpenGLCamera.h"
#include "vtkOpenGLRenderer.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPlane.h"
#include "vtkPlaneCollection.h"
#include "vtkProp3D.h"
#include "vtkProperty.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkTransform.h"
#include "vtkVolumeMapper.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace treeamr
{

namespace
{

/// Finer than 8-bit colours can tell apart along any ramp; 64 KiB stay in the L2 cache.
constexpr int tableSize = 4096;

struct Interval
{
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  void add(const double range[2])
  {
    min = std::min(min, range[0]);
    max = std::max(max, range[1]);
  }
};

/// The functions of a property, evaluated one value at a time: vtkColorTransferFunction::GetTable() spaces a
/// table over several values logarithmically when the function's scale is.
class PropertyFunctions
{
public:
  explicit PropertyFunctions(vtkVolumeProperty* property)
    : opacity_(property->GetScalarOpacity(0))
    , gray_(property->GetColorChannels(0) == 1 ? property->GetGrayTransferFunction(0) : nullptr)
    , color_(gray_ ? nullptr : property->GetRGBTransferFunction(0))
    , unitDistance_(property->GetScalarOpacityUnitDistance(0))
  {
  }

  /// Hull of the nodes of all functions: outside of it each is constant.
  Interval nodeRange() const
  {
    Interval hull;
    for (vtkPiecewiseFunction* function : { opacity_, gray_ })
    {
      if (function && function->GetSize() > 0)
      {
        hull.add(function->GetRange());
      }
    }
    if (color_ && color_->GetSize() > 0)
    {
      hull.add(color_->GetRange());
    }
    return hull;
  }

  Vec3 color(double value) const
  {
    double rgb[3];
    if (gray_)
    {
      rgb[0] = rgb[1] = rgb[2] = gray_->GetValue(value);
    }
    else
    {
      color_->GetColor(value, rgb);
    }
    return { rgb[0], rgb[1], rgb[2] };
  }

  double opacity(double value) const { return opacity_->GetValue(value); }

  float extinction(double value) const
  {
    return TransferFunction::extinctionFromOpacity(opacity(value), unitDistance_);
  }

  TransferFunction::Entry at(double value) const
  {
    const Vec3 rgb = color(value);
    return { static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]),
      extinction(value) };
  }

private:
  vtkPiecewiseFunction* opacity_;
  vtkPiecewiseFunction* gray_;
  vtkColorTransferFunction* color_;
  double unitDistance_;
};

void checkUnitDistance(vtkVolumeProperty* property)
{
  const double unitDistance = property->GetScalarOpacityUnitDistance(0);
  if (!(unitDistance > 0.) || !std::isfinite(unitDistance))
  {
    throw Error("volume property: scalar opacity unit distance " + std::to_string(unitDistance) +
      ", allowed are positive lengths");
  }
}

/// Transposed, as OpenGL has them.
struct KeyMatrices
{
  vtkMatrix4x4* viewFromWorld = nullptr;
  vtkMatrix4x4* clipFromWorld = nullptr;
};

KeyMatrices keyMatrices(vtkRenderer* renderer)
{
  vtkCamera* camera = renderer->GetActiveCamera();
  vtkOpenGLCamera* openGLCamera = vtkOpenGLCamera::SafeDownCast(camera);
  if (!openGLCamera)
  {
    throw Error(
      std::string("camera: the renderer has a ") + camera->GetClassName() + ", needed is a vtkOpenGLCamera");
  }
  KeyMatrices matrices;
  vtkMatrix3x3* normals = nullptr;
  vtkMatrix4x4* clipFromView = nullptr;
  openGLCamera->GetKeyMatrices(
    renderer, matrices.viewFromWorld, normals, clipFromView, matrices.clipFromWorld);
  return matrices;
}

Matrix4 timesPropMatrix(vtkMatrix4x4* transposed, vtkProp3D* prop)
{
  vtkNew<vtkMatrix4x4> left;
  vtkMatrix4x4::Transpose(transposed, left);
  vtkNew<vtkMatrix4x4> product;
  prop->GetMatrix(product);
  vtkMatrix4x4::Multiply4x4(left, product, product);
  Matrix4 m;
  for (int i = 0; i < 16; ++i)
  {
    m[i] = product->GetElement(i / 4, i % 4);
  }
  return m;
}

Vec3 toVec3(const double v[3])
{
  return { v[0], v[1], v[2] };
}

/// What an OpenGL renderer applies to all lights but those of the scene, in view coordinates; may be null.
vtkTransform* userLightTransform(vtkRenderer* renderer)
{
  vtkOpenGLRenderer* const openGLRenderer = vtkOpenGLRenderer::SafeDownCast(renderer);
  return openGLRenderer ? openGLRenderer->GetUserLightTransform() : nullptr;
}

std::array<float, 3> scaledColor(const double rgb[3], double scale)
{
  return { static_cast<float>(rgb[0] * scale), static_cast<float>(rgb[1] * scale),
    static_cast<float>(rgb[2] * scale) };
}

} // namespace

Matrix4 viewFromData(vtkRenderer* renderer, vtkProp3D* prop)
{
  return timesPropMatrix(keyMatrices(renderer).viewFromWorld, prop);
}

Matrix4 clipFromData(vtkRenderer* renderer, vtkProp3D* prop)
{
  return timesPropMatrix(keyMatrices(renderer).clipFromWorld, prop);
}

std::vector<HalfSpace> convertClippingPlanes(vtkAbstractMapper* mapper, vtkProp3D* prop)
{
  std::vector<HalfSpace> halfSpaces;
  vtkPlaneCollection* planes = mapper->GetClippingPlanes();
  vtkNew<vtkMatrix4x4> transposed; // world from data
  prop->GetMatrix(transposed);
  transposed->Transpose();
  for (int i = 0; planes && i < planes->GetNumberOfItems(); ++i)
  {
    // A plane is a row vector: its product with points of it vanishes.
    double plane[4];
    vtkPlane* ofWorld = planes->GetItem(i);
    ofWorld->GetNormal(plane);
    plane[3] = -vtkMath::Dot(plane, ofWorld->GetOrigin());
    transposed->MultiplyPoint(plane, plane);
    halfSpaces.push_back({ toVec3(plane), -plane[3] });
  }
  return halfSpaces;
}

std::optional<CroppingRegions> convertCropping(vtkVolumeMapper* mapper)
{
  if (!mapper->GetCropping())
  {
    return std::nullopt;
  }
  CroppingRegions regions{};
  mapper->GetCroppingRegionPlanes(regions.planes.data());
  regions.shown = static_cast<std::uint32_t>(mapper->GetCroppingRegionFlags());
  return regions;
}

bool isStereo(vtkRenderer* renderer)
{
  vtkRenderWindow* window = renderer->GetRenderWindow();
  return window && window->GetStereoRender();
}

int eyeOf(vtkRenderer* renderer)
{
  return isStereo(renderer) && !renderer->GetActiveCamera()->GetLeftEye() ? 1 : 0;
}

bool isInteractive(vtkRenderer* renderer)
{
  constexpr double slowest = 1.; // frames a second
  return renderer->GetRenderWindow()->GetDesiredUpdateRate() >= slowest;
}

std::vector<Light> convertLights(vtkRenderer* renderer)
{
  std::vector<Light> lights;
  bool anyPositional = false;
  vtkTransform* const viewFromWorld = renderer->GetActiveCamera()->GetModelViewTransformObject();
  vtkLightCollection* collection = renderer->GetLights();
  vtkCollectionSimpleIterator iterator;
  collection->InitTraversal(iterator);
  while (vtkLight* light = collection->GetNextLight(iterator))
  {
    anyPositional = anyPositional || light->GetPositional();
    if (!light->GetSwitch())
    {
      continue;
    }
    // The transformed ones: headlights and camera lights move with the camera.
    double position[3];
    double focalPoint[3];
    light->GetTransformedPosition(position);
    light->GetTransformedFocalPoint(focalPoint);
    double direction[3];
    vtkMath::Subtract(focalPoint, position, direction);
    vtkMath::Normalize(direction);
    viewFromWorld->TransformNormal(direction, direction);
    viewFromWorld->TransformPoint(position, position);
    vtkTransform* const ofUser = userLightTransform(renderer);
    if (ofUser && !light->LightTypeIsSceneLight())
    {
      ofUser->TransformNormal(direction, direction);
      ofUser->TransformPoint(position, position);
    }

    Light converted;
    converted.positional = light->GetPositional() != 0;
    converted.position = toVec3(position);
    converted.direction = toVec3(direction);
    converted.coneAngle = light->GetConeAngle();
    converted.exponent = light->GetExponent();
    converted.attenuation = toVec3(light->GetAttenuationValues());
    converted.color = scaledColor(light->GetDiffuseColor(), light->GetIntensity());
    // At the eye: its shadows are out of sight.
    converted.castsShadows = !light->LightTypeIsHeadlight();
    lights.push_back(converted);
  }
  // VTK has a shader of its own for this case.
  if (lights.size() == 1 && !lights[0].castsShadows && !anyPositional)
  {
    lights[0].direction = { 0., 0., -1. };
    lights[0].highlightByCosine = true;
  }
  return lights;
}

bool isLit(vtkProperty* property, const std::vector<Light>& lights)
{
  return property->GetLighting() && !lights.empty();
}

Material convertMaterial(vtkProperty* property, bool lit)
{
  Material material;
  material.ambient = scaledColor(property->GetAmbientColor(), property->GetAmbient());
  material.diffuse = scaledColor(property->GetDiffuseColor(), property->GetDiffuse());
  if (!lit)
  {
    for (int c = 0; c < 3; ++c)
    {
      material.ambient[c] += material.diffuse[c];
    }
    material.diffuse = {};
    return material;
  }
  material.specular = scaledColor(property->GetSpecularColor(), property->GetSpecular());
  material.specularPower = static_cast<float>(property->GetSpecularPower());
  return material;
}

TransferFunction convertTransferFunction(vtkVolumeProperty* property, Range dataRange, double offset)
{
  checkUnitDistance(property);
  const PropertyFunctions functions(property);
  Interval part = functions.nodeRange();
  part.min -= offset;
  part.max -= offset;
  if (!(part.min < part.max))
  {
    // No nodes, or all at one value, where clamped functions and range colours may jump.
    part = { dataRange.min, dataRange.max };
  }
  if (dataRange.max <= part.min || dataRange.min >= part.max)
  {
    // Constant over the data, up to a value that is common to both: the far end tells.
    const TransferFunction::Entry entry =
      functions.at(offset + (dataRange.max <= part.min ? dataRange.min : dataRange.max));
    return TransferFunction(dataRange.min, dataRange.max, { entry, entry });
  }
  part.min = std::max<double>(part.min, dataRange.min);
  part.max = std::min<double>(part.max, dataRange.max);

  // Two entries beyond each end: functions may jump there, to zero when clamping is off or to the colours for
  // values out of range, and values far out must not touch the entries within.
  constexpr int beyond = 2;
  constexpr int last = tableSize - 1 - beyond;
  const double step = (part.max - part.min) / (last - beyond);
  std::vector<TransferFunction::Entry> entries(tableSize);
  for (int i = 0; i < tableSize; ++i)
  {
    // The ends exactly: rounding must not take them over the jump. vtkPiecewiseFunction without clamping is
    // zero on its first node, too.
    double value = offset + (i == last ? part.max : part.min + (i - beyond) * step);
    if (i == beyond)
    {
      value = std::nextafter(value, offset + part.max);
    }
    entries[i] = functions.at(value);
  }
  return TransferFunction(part.min - beyond * step, part.max + beyond * step, std::move(entries));
}

bool hasCategories(vtkVolumeProperty* property)
{
  return property->GetColorChannels(0) == 3 && property->GetRGBTransferFunction(0)->GetIndexedLookup();
}

TransferFunction convertCategories(vtkVolumeProperty* property, vtkDataArray* values)
{
  checkUnitDistance(property);
  const PropertyFunctions functions(property);
  vtkColorTransferFunction* table = property->GetRGBTransferFunction(0);
  // What a function without nodes maps nothing to.
  std::array<unsigned char, 4> nothing{};
  for (int c = 0; c < 3; ++c)
  {
    nothing[c] = static_cast<unsigned char>(255. * table->GetNanColor()[c] + 0.5);
  }
  std::vector<std::array<unsigned char, 4>> colors(
    static_cast<std::size_t>(values->GetNumberOfTuples()), nothing);
  table->Build();
  table->MapScalarsThroughTable(values, colors.front().data(), VTK_RGBA);
  std::vector<TransferFunction::Entry> entries;
  entries.reserve(colors.size());
  for (const std::array<unsigned char, 4>& rgba : colors)
  {
    const double value = values->GetComponent(static_cast<vtkIdType>(entries.size()), 0);
    entries.push_back({ rgba[0] / 255.f, rgba[1] / 255.f, rgba[2] / 255.f, functions.extinction(value) });
  }
  return TransferFunction::ofCategories(std::move(entries));
}

std::vector<SurfaceMaterial> convertSurfaceMaterials(vtkVolumeProperty* property,
  const std::vector<double>& isovalues, double opacityScale, const std::vector<Light>& lights)
{
  const PropertyFunctions functions(property);
  const bool shaded = property->GetShade(0) != 0;
  const double unshaded = shaded ? property->GetAmbient(0) + property->GetDiffuse(0) : 1.;
  std::vector<SurfaceMaterial> materials;
  for (const double isovalue : isovalues)
  {
    const Vec3 color = functions.color(isovalue);
    SurfaceMaterial surface;
    if (!shaded || lights.empty())
    {
      surface.material.ambient = scaledColor(color.data(), unshaded);
    }
    else
    {
      surface.material.ambient = scaledColor(color.data(), property->GetAmbient(0));
      surface.material.diffuse = scaledColor(color.data(), property->GetDiffuse(0));
      surface.material.specular.fill(static_cast<float>(property->GetSpecular(0)));
      surface.material.specularPower = static_cast<float>(property->GetSpecularPower(0));
    }
    surface.opacity = static_cast<float>(std::clamp(functions.opacity(isovalue) * opacityScale, 0., 1.));
    materials.push_back(surface);
  }
  return materials;
}

} // namespace treeamr

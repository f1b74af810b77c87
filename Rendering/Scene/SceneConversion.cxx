#include "SceneConversion.h"

#include "Error.h"

#include "vtkCamera.h"
#include "vtkColorTransferFunction.h"
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
#include <span>
#include <sstream>
#include <string>

namespace treeamr
{

namespace
{

Vec3 toVec3(const double v[3])
{
  return { v[0], v[1], v[2] };
}

std::string textOf(const double v[3])
{
  std::ostringstream text;
  text << '(' << v[0] << ", " << v[1] << ", " << v[2] << ')';
  return text.str();
}

bool areFinite(std::span<const double> numbers)
{
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

bool isDirection(std::span<const double, 3> v)
{
  return areFinite(v) && (v[0] != 0. || v[1] != 0. || v[2] != 0.);
}

/// Names what leaves no way back from the picture to the data. Others that are singular Camera refuses.
void checkScene(vtkCamera* camera, vtkProp3D* prop)
{
  const std::span<const double, 3> direction(camera->GetDirectionOfProjection(), 3);
  double across[3];
  vtkMath::Cross(direction.data(), camera->GetViewUp(), across);
  if (!isDirection(direction) || !isDirection(across) || !std::isfinite(camera->GetViewAngle()) ||
    !areFinite({ camera->GetClippingRange(), 2 }))
  {
    std::ostringstream text;
    text
      << "camera: position " << textOf(camera->GetPosition()) << ", focal point "
      << textOf(camera->GetFocalPoint()) << ", view up " << textOf(camera->GetViewUp()) << ", view angle "
      << camera->GetViewAngle() << ", clipping range " << camera->GetClippingRange()[0] << " to "
      << camera->GetClippingRange()[1]
      << ": a singular view; allowed are finite numbers, and a view up that is not along the line of sight";
    throw Error(text.str());
  }
  vtkMatrix4x4* const matrix = prop->GetMatrix();
  for (int c = 0; c < 4; ++c)
  {
    const double column[3]{ matrix->GetElement(0, c), matrix->GetElement(1, c), matrix->GetElement(2, c) };
    if (c < 3 ? !isDirection(column) : !areFinite(column))
    {
      throw Error(std::string(prop->GetClassName()) + ": its matrix is singular or not finite: scale " +
        textOf(prop->GetScale()) + ", position " + textOf(prop->GetPosition()) + ", " +
        (c < 3 ? std::string("data axis ") + "xyz"[c] + " becomes " : "data origin becomes ") +
        textOf(column) + "; allowed are finite numbers, and no axis of length 0");
    }
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
  checkScene(renderer->GetActiveCamera(), prop);
  return timesPropMatrix(keyMatrices(renderer).clipFromWorld, prop);
}

HalfSpace convertPlane(vtkPlane* ofWorld, vtkProp3D* prop)
{
  vtkNew<vtkMatrix4x4> transposed; // world from data
  prop->GetMatrix(transposed);
  transposed->Transpose();
  // A plane is a row vector: its product with points of it vanishes.
  double plane[4];
  ofWorld->GetNormal(plane);
  plane[3] = -vtkMath::Dot(plane, ofWorld->GetOrigin());
  transposed->MultiplyPoint(plane, plane);
  return { toVec3(plane), -plane[3] };
}

std::vector<HalfSpace> convertClippingPlanes(vtkAbstractMapper* mapper, vtkProp3D* prop)
{
  std::vector<HalfSpace> halfSpaces;
  vtkPlaneCollection* planes = mapper->GetClippingPlanes();
  for (int i = 0; planes && i < planes->GetNumberOfItems(); ++i)
  {
    halfSpaces.push_back(convertPlane(planes->GetItem(i), prop));
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
    converted.specularColor = scaledColor(light->GetSpecularColor(), light->GetIntensity());
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

std::vector<SurfaceMaterial> convertSurfaceMaterials(vtkVolumeProperty* property,
  const std::vector<double>& isovalues, double opacityScale, bool shaded, const std::vector<Light>& lights)
{
  vtkPiecewiseFunction* const gray =
    property->GetColorChannels(0) == 1 ? property->GetGrayTransferFunction(0) : nullptr;
  const double unshaded = shaded ? property->GetAmbient(0) + property->GetDiffuse(0) : 1.;
  std::vector<SurfaceMaterial> materials;
  for (const double isovalue : isovalues)
  {
    Vec3 color;
    if (gray)
    {
      color.fill(gray->GetValue(isovalue));
    }
    else
    {
      property->GetRGBTransferFunction(0)->GetColor(isovalue, color.data());
    }
    const double opacity = property->GetScalarOpacity(0)->GetValue(isovalue);
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
    surface.opacity = static_cast<float>(std::clamp(opacity * opacityScale, 0., 1.));
    materials.push_back(surface);
  }
  return materials;
}

} // namespace treeamr

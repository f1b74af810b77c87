// VTK's cameras, lights and properties in the core's terms. Private to the module.
#pragma once

#include "SurfaceShading.h"

#include "Geometry/Camera.h"
#include "Geometry/RayStops.h"
#include "Surface/Shading.h"

#include <optional>
#include <vector>

class vtkAbstractMapper;
class vtkPlane;
class vtkProp3D;
class vtkProperty;
class vtkRenderer;
class vtkVolumeMapper;
class vtkVolumeProperty;

namespace treeamr
{

/// Data coordinates to those of the view, where the eye is at the origin and looks along -z, and to clip
/// space with z from -1 to 1: by the matrices that VTK's own mappers draw with, of the eye whose picture a
/// stereo window draws. Throw Error for a camera that does not belong to OpenGL; the latter for a camera or a prop's
/// matrix that is singular or not finite, too, and names why.
Matrix4 viewFromData(vtkRenderer* renderer, vtkProp3D* prop);
Matrix4 clipFromData(vtkRenderer* renderer, vtkProp3D* prop);

/// Whether its window draws a picture for each eye.
bool isStereo(vtkRenderer* renderer);
/// 1 while a stereo window draws the picture of the right eye, else 0.
int eyeOf(vtkRenderer* renderer);

/// Whether the window wants frames at a rate rather than the best picture.
bool isInteractive(vtkRenderer* renderer);

/// The side of a plane of world coordinates that its normal points to, in those of the prop's data.
HalfSpace convertPlane(vtkPlane* plane, vtkProp3D* prop);
/// The mapper's clipping planes, which VTK has in world coordinates, in those of the prop's data.
std::vector<HalfSpace> convertClippingPlanes(vtkAbstractMapper* mapper, vtkProp3D* prop);
/// Nothing while cropping is off.
std::optional<CroppingRegions> convertCropping(vtkVolumeMapper* mapper);

/// The lights that are switched on, in view coordinates.
std::vector<Light> convertLights(vtkRenderer* renderer);
/// Whether the property wants light and there is any: else VTK shows ambient and diffuse colours as they are.
bool isLit(vtkProperty* property, const std::vector<Light>& lights);
/// Of what is not lit everything is in the ambient term.
Material convertMaterial(vtkProperty* property, bool lit);

/// How VTK's own volume mapper shows the surfaces of isovalues: the functions at the isovalue give colour and
/// opacity, whatever the unit distance; without shading the colour is all there is, and with it but without
/// light what polygons show. Opacities are multiplied by opacityScale, up to 1.
std::vector<SurfaceMaterial> convertSurfaceMaterials(vtkVolumeProperty* property,
  const std::vector<double>& isovalues, double opacityScale, bool shaded, const std::vector<Light>& lights);

} // namespace treeamr

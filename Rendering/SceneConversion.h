// VTK's cameras, lights and properties in the core's terms. Private to the module.
#pragma once

#include "Octree/Field.h"
#include "RayTracing/Camera.h"
#include "RayTracing/Shading.h"
#include "RayTracing/TransferFunction.h"
#include "VolumeSurfaces.h"

#include <vector>

class vtkMatrix4x4;
class vtkProp3D;
class vtkProperty;
class vtkRenderer;
class vtkVolumeProperty;

namespace treeamr
{

Matrix4 convertMatrix(const vtkMatrix4x4* matrix);
Matrix4 worldFromData(vtkProp3D* prop);
/// Data coordinates to clip space with z from -1 to 1. Honours an explicit projection (IceT sets one).
Matrix4 clipFromData(vtkRenderer* renderer, vtkProp3D* prop);

/// Whether the window wants frames at a rate rather than the best picture.
bool isInteractive(vtkRenderer* renderer);

/// The lights that are switched on, in world coordinates.
std::vector<Light> convertLights(vtkRenderer* renderer);
/// Of an unlit property everything is in the ambient term.
Material convertMaterial(vtkProperty* property);

/// A table of the property's colours and scalar opacities (component 0) for values of dataRange, its entries
/// spent on the part of it that the functions distinguish. Throws Error for a unit distance that is not
/// positive.
TransferFunction convertTransferFunction(vtkVolumeProperty* property, Range dataRange);

/// How VTK's own volume mapper shows the surfaces of isovalues: the functions at the isovalue give colour and
/// opacity, whatever the unit distance; without shading the colour is all there is. Opacities are multiplied by
/// opacityScale, up to 1.
std::vector<SurfaceMaterial> convertSurfaceMaterials(
  vtkVolumeProperty* property, const std::vector<double>& isovalues, double opacityScale);

} // namespace treeamr

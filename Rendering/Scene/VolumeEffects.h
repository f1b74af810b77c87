// What vtkVolumeProperty and vtkVolumeMapper ask for beyond colours and opacities, in the core's terms. Private to the
// module.
#pragma once

#include "Geometry/RayStops.h"
#include "Octree/RootGrid.h"
#include "Volume/VolumeSettings.h"

#include <optional>

class vtkRenderer;
class vtkVolume;
class vtkVolumeMapper;
class vtkVolumeProperty;

namespace treeamr
{

class Field;
struct Image;

/// VTK's blend modes of values, and slices; composite for all others.
VolumeBlend convertBlendMode(int mode);
bool blendsValues(vtkVolumeMapper* mapper);

/// As VTK's GPU mapper does: a headlight alone shines from the eye along each line of sight, with the ambient term in
/// the sample's colour; of other lights that term is in their ambient colours, black by default, as all is without
/// lights. Nothing without shading, of the first component for all. component: whose coefficients these are.
std::optional<VolumeShading> convertVolumeShading(
  vtkRenderer* renderer, vtkVolume* volume, int component = 0);

/// A function that is 1 everywhere, which VTK makes when it copies properties, changes nothing.
bool hasGradientOpacity(vtkVolumeProperty* property);
/// The property's function of the change of the field across the width of its finest cells, which VTK has of an image's
/// spacing: up to a quarter of the field's range, and constant beyond, as VTK's tables.
std::optional<GradientOpacity> convertGradientOpacity(vtkVolumeProperty* property, const Field& field);
/// That quarter, or of no range .25, as a gradient: the last one that has a place of its own in VTK's tables. finestWidth:
/// of cells.
double longestGradient(double range, double finestWidth);
/// Of the finest cells: the mean over the axes.
double finestWidth(const Field& field);

/// What the property's slice function shows, in data coordinates. Throws Error where it is no vtkPlane, as VTK's mapper
/// takes no other.
HalfSpace convertSlice(vtkVolume* volume);

/// The slice, or one just inside of a face of the domain that it lies in: of rays in such a face some would miss the domain.
HalfSpace insideOfFaces(HalfSpace slice, const Bounds& domain);

/// As VTK's mappers take the final colours of an image, premultiplied, from a window and level (a window of 1 about 0.5
/// changes nothing).
void applyColorWindow(double window, double level, Image& image);

/// As VTK's GPU mapper has it of its settings and the property. sampleDistance: 0 or less: the width of the finest cells.
VolumeScattering convertScattering(vtkVolumeProperty* property, const Field& field, float blending,
  float globalIlluminationReach, double sampleDistance);

/// All of these but the last two. component: whose unit distance counts.
VolumeSettings convertVolumeEffects(
  vtkRenderer* renderer, vtkVolume* volume, vtkVolumeMapper* mapper, const Field& field, int component);

} // namespace treeamr

// The functions of a vtkVolumeProperty in the core's terms. Private to the module.
#pragma once

#include "PropertyFunctions.h"

#include "Field/Field.h"
#include "Field/TransferFunction.h"

class vtkDataArray;
class vtkVolumeProperty;

namespace treeamr
{

/// A component's colours and scalar opacities for values of dataRange, as VTK evaluates them at every
/// float of it, to 1/512 of a channel: nodes where they bend or jump. dataRange and nodes: less the offset, which the
/// property's values are not. Throws Error for a unit distance that is not positive.
TransferFunction convertTransferFunction(
  vtkVolumeProperty* property, Range dataRange, double offset = -0., const PropertyComponent& component = {});

/// Throws Error unless the component's unit distance is a positive length.
void checkUnitDistance(vtkVolumeProperty* property, int component);

/// Whether the property's colours are of categories (VTK's indexed look-up): of values by themselves, with
/// nothing in between.
bool hasCategories(vtkVolumeProperty* property);
/// For the numbers of these values, which the property has the colours of, as VTK colours surfaces by them,
/// and opacities. Throws Error as convertTransferFunction().
TransferFunction convertCategories(vtkVolumeProperty* property, vtkDataArray* values);

} // namespace treeamr

// A vtkVolumeProperty's transfer function of two values in the core's terms. Private to the module.
#pragma once

#include "Field/TransferFunction2D.h"

#include <array>

class vtkVolumeProperty;

namespace treeamr
{

/// Where the function lies: the least and the largest of the first value, then of the second one, less their fields' offsets.
using TransferRange2D = std::array<double, 4>;

/// Component 0's image as VTK's mappers read textures: its pixels' centres lie half a pixel inside the range, in between
/// colours and opacities are bilinear, beyond them constant. Opacities are over the component's unit distance. Throws Error
/// for an image that is none of RGBA in one plane, and as convertTransferFunction().
TransferFunction2D convertTransferFunction2D(vtkVolumeProperty* property, const TransferRange2D& range);

} // namespace treeamr

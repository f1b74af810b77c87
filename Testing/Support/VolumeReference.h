// The volume renderer in plain double precision, one ray and sample after the other, without what makes the kernels
// fast: what they are tested against.
#pragma once

#include "Volume/Volume.h"

namespace treeamr::test
{

/// As Volume::setColors() has them.
struct ReferenceColors
{
  const Field& field;
  const TransferFunction& function;
};

/// As Volume::setTable() has it; second: null for the gradient's length.
struct ReferenceTable
{
  const TransferFunction2D& function;
  const Field* second;
};

/// Like Volume::render(), for arguments that it would take, with as many point samples in every leaf as asked for.
/// With a table the transfer function says alone what is transparent.
VolumeStatistics renderVolumeReference(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, Image& image,
  const ReferenceColors* colors = nullptr, const ReferenceTable* table = nullptr);

/// The picture itself: octant by octant in steps that are cut until the field is all but a line in them, whatever the
/// function does there, and light is integrated over all of that, one part after the other.
void renderVolumeConverged(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, Image& image);

} // namespace treeamr::test

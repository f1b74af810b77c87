// The volume renderer in plain double precision, one ray and sample after the other: what the kernels are
// tested against, and what renders fields, domains and zooms beyond single precision's comfort.
#pragma once

#include "Volume/Volume.h"

namespace treeamr
{

/// Like Volume::render(), for arguments that it has checked.
VolumeStatistics renderVolumeReference(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, Image& image);

} // namespace treeamr

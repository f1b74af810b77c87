// What a frame would take if only its rays' intervals and samples were left: no walk over the tree, every value
// in the innermost cache.
#pragma once

#include "Volume/VolumeRenderer.h"

namespace treeamr::bench
{

/// CPU seconds for as many intervals, steps and lit steps as the frame's statistics count, each at the time that
/// it takes alone.
double limitSeconds(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const VolumeStatistics& frame);

} // namespace treeamr::bench

// What a frame would take if only its rays' intervals and samples were left: no walk over the tree, every value
// in the innermost cache.
#pragma once

#include "Volume/Volume.h"

namespace treeamr::bench
{

/// CPU seconds for as many intervals, steps and lit steps as the frame's statistics count, each at the time that
/// it takes alone.
double limitSeconds(const std::shared_ptr<const Field>& field, const TransferFunction& transferFunction,
  const Camera& camera, const VolumeStatistics& frame);

} // namespace treeamr::bench

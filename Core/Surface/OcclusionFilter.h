// Ambient occlusion of few rays without grain: the hits of a smooth piece of surface share their rays.
//
// A joint bilateral filter (Petschnigg et al. 2004) as wide as the pattern in which traceAmbientOcclusion() gives
// pixels rays that complete each other (Keller, Heidrich 2001).
#pragma once

#include "Surface/Isosurface.h"

#include <cstdint>
#include <vector>

namespace treeamr
{

/// The part of open rays at each hit, in [0, 1], from its own and those of hits in the 5 x 5 pixels around it that
/// lie on the same surface, nearly in its tangent plane and with nearly its normal; of each pixel only the hit
/// whose distance from the camera is nearest to the own. A hit without such neighbours, and one without a finite
/// place, keeps its own part. With more rays the neighbours must be more alike and change less: the result
/// converges to the own part.
/// open: of each hit's `samples` rays (at least 1), how many meet nothing. Throws Error for other numbers of both,
/// and for hits of another picture than the camera's.
std::vector<float> filterAmbientOcclusion(
  const Camera& camera, const HitImage& hits, const std::vector<std::uint16_t>& open, int samples);

} // namespace treeamr

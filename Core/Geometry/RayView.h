// What the rays of an image see.
#pragma once

#include "Geometry/Camera.h"
#include "Geometry/RayStops.h"

namespace treeamr
{

/// Where nothing is left out between a camera's near and far plane.
inline const RayStops noStops;

/// A camera and the stops on its rays, or a camera alone. Does not own them.
struct RayView
{
  RayView(const Camera& camera, const RayStops& stops = noStops) noexcept
    : camera(camera)
    , stops(stops)
  {
  }
  const Camera& camera;
  const RayStops& stops;
};

} // namespace treeamr

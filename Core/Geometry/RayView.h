// What the rays of an image see.
#pragma once

#include "Geometry/Camera.h"
#include "Geometry/RayStops.h"

namespace treeamr
{

/// Where nothing is left out between a camera's near and far plane.
inline const RayStops noStops;

class Progress;

/// A camera and the stops on its rays, or a camera alone, and who follows the image's progress, if anyone does. Does not
/// own them.
struct RayView
{
  /// All of them must outlive the view. progress: null for nobody.
  RayView(const Camera& camera, const RayStops& stops = noStops, Progress* progress = nullptr) noexcept
    : camera(camera)
    , stops(stops)
    , progress(progress)
  {
  }
  const Camera& camera;  // whose pixels are rendered
  const RayStops& stops; // on its rays
  Progress* progress;    // null: nobody's
};

} // namespace treeamr

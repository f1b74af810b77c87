// Time of the reconstruction at points: of a PointSampler, and of queries that remember nothing.
#pragma once

#include "Report.h"

#include "Field/Field.h"
#include "Geometry/Camera.h"

#include <memory>
#include <vector>

namespace treeamr::bench
{

/// Nanoseconds a point on one thread, in rows of a slice, at the hits of a frame of an isosurface, tile by tile, and at
/// random. Throws Error when the two differ in a bit of a value.
std::vector<Figure> pointFigures(
  const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera);

} // namespace treeamr::bench

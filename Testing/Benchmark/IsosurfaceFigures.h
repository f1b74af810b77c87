// Time and memory of an isosurface: the ray tracer's, and the paper's extraction beside it.
#pragma once

#include "Octree/Field.h"
#include "RayTracing/Camera.h"
#include "Report.h"

#include <memory>

namespace treeamr::bench
{

/// The paper's table 2, and what the ray tracer takes.
std::vector<Figure> isosurfaceFigures(
  const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera);

/// The paper's figure 14: filtered extraction over the share of active cells.
std::vector<Figure> activityFigures(const Field& field, double isovalue);

} // namespace treeamr::bench

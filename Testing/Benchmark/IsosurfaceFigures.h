// Time and memory of an isosurface: the ray tracer's, and the paper's extraction beside it.
#pragma once

#include "Field/Field.h"
#include "Geometry/Camera.h"
#include "Meter.h"
#include "Report.h"
#include "Surface/Isosurface.h"

#include <memory>

namespace treeamr::bench
{

/// What the ray tracer takes.
struct IsosurfaceCosts
{
  Cost extraction;
  Cost construction; // extraction and hierarchy
  Cost coldFrame;    // the first after it
  Cost frame;
  Cost draft;                      // a hundredth of the frame's rays
  IsosurfaceStatistics statistics; // after the frames
  // Of two surfaces, at 4/10 and 9/10 of the isovalue.
  Cost opaqueOfTwo;
  Cost layersOfTwo; // all of them
};
IsosurfaceCosts measureIsosurface(
  const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera);

/// The paper's table 2, and the ray tracer's costs.
std::vector<Figure> isosurfaceFigures(
  const std::shared_ptr<const Field>& field, double isovalue, const IsosurfaceCosts& own);

/// The paper's figure 14: filtered extraction over the share of active cells.
std::vector<Figure> activityFigures(const Field& field, double isovalue);

} // namespace treeamr::bench

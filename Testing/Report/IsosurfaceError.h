// Distance of isosurfaces from the analytic surface, and angle of their normals, over CPU seconds.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

/// Methods are "implicit", measured where the rays of the benchmark's camera hit any layer, and the contour's
/// triangles: "contour-vertices"; "contour-flat" at points spread evenly over the triangles, with the
/// triangles' normals; "contour-smooth" at the same points, with normals interpolated from the vertices'
/// gradients.
/// What a method has not is null: a frame of the contour is the window's work. All but cpu_s_... is the same
/// on every machine with one standard library, up to rounding. cpu_s_build begins with the field and its node
/// ranges.
void measureIsosurfaceError(const Options& options, bench::Report& errors, bench::Report& orders);

} // namespace treeamr::report

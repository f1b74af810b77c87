// Distance of isosurfaces from the analytic surface, and angle of their normals, over CPU seconds.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

void measureIsosurfaceError(const Options& options, bench::Report& report);

} // namespace treeamr::report

// Error of the interpolation methods against analytic fields, over refinement and over time per query.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

void measureFieldError(const Options& options, bench::Report& report);

} // namespace treeamr::report

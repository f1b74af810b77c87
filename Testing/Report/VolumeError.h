// Error of volume pictures over CPU seconds, every setting a point.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

void measureVolumeError(const Options& options, bench::Report& report);

} // namespace treeamr::report

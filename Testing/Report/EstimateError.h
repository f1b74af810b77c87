// The renderer's estimate of its own error against the true one, and frames that are to meet an error.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

void measureErrorEstimate(const Options& options, bench::Report& report);

} // namespace treeamr::report

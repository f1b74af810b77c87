// Volumes by transfer functions of every kind on fields of every kind: error over samples and run time.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

/// A row for each of the samples per cell, fields and functions of Support/VolumeCases: root mean square error over red,
/// green, blue and opacity against the converged picture, and CPU seconds a frame. Errors are the same on every machine,
/// up to rounding.
void measureFunctionError(const Options& options, bench::Report& report);

} // namespace treeamr::report

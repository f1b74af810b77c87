// What is left of values that lie close together beside their size, as floats alone and less an offset.
#pragma once

#include "Report.h"

namespace treeamr::report
{

/// Of fields that are linear where it is looked, so that the reconstruction is exact, each stored in both ways: a row
/// each. Errors are the largest, in parts of the range of the field that was meant: of what a sampler gives; of the
/// field at points of a contour and at hits of an isosurface, less the isovalue, 1 where there is none; and of the
/// pixels of a volume, less those of the same field less its constant. The same on every machine, up to rounding.
void measureDigits(bench::Report& report);

} // namespace treeamr::report

// Error of volume pictures over CPU seconds, every setting a point.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

/// A row for each setting ("setting") of what varies ("series"), the rest as shipped, against the converged picture.
/// That also ends a ray with a 1024th of its light left, which puts it 73 dB (Mandelbulb 0.3M) or 78 dB (Sheet) from
/// one that does not: above, pictures are compared with the same cut, no longer with the integral.
///
/// samples, nodes: the same on every machine. intervals: of the machine's vectors. kept_bytes: up to a chunk more for
/// each thread, and blocks that two have computed.
///
/// The series "interpolation" is by a plain ray marcher in a smaller picture ("pixels", along an edge), against
/// converged GTI: how far apart the methods are; the row of GTI is what the marcher adds.
void measureVolumeError(const Options& options, bench::Report& report);

} // namespace treeamr::report

#include "VolumeError.h"

namespace treeamr::report
{

void measureVolumeError(const Options& /*options*/, bench::Report& /*report*/) {}

} // namespace treeamr::report

#include "IsosurfaceError.h"

namespace treeamr::report
{

void measureIsosurfaceError(const Options& /*options*/, bench::Report& /*report*/) {}

} // namespace treeamr::report

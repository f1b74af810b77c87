#include "FieldError.h"

namespace treeamr::report
{

void measureFieldError(const Options& /*options*/, bench::Report& /*report*/) {}

} // namespace treeamr::report

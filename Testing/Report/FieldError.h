// Error of the interpolation methods against analytic fields, over refinement and over time per query.
#pragma once

#include "Options.h"
#include "Report.h"

namespace treeamr::report
{

/// errors: of fields of about unit range at random points, and the length of the gradient's error over that
/// of the longest gradient. Each region of a tree is a row: "inside" keeps the width of a root from the
/// domain's end, where missing cells leave no method more than first order; of it, "near" are the points in
/// leaves that touch one of another level, "away" all others, where all methods but nearest agree.
/// orders: fitted to the finer half of the refinements; none where a method is exact. A mean over "near" or
/// "away" also follows what these lose and gain as they shrink and grow.
/// All but ns_per_query, of random queries one at a time, is the same on every machine with one standard
/// library, up to the rounding of the mathematical one.
void measureFieldError(const Options& options, bench::Report& errors, bench::Report& orders);

} // namespace treeamr::report

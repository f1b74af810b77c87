#include "Convergence.h"

#include <cmath>
#include <limits>

namespace treeamr::report
{

ConvergenceOrder fittedOrder(const std::vector<ErrorNorms>& errors)
{
  const double middle = 0.5 * (static_cast<double>(errors.size()) - 1.);
  ConvergenceOrder covariance{ 0., 0. };
  double variance = 0.;
  for (std::size_t i = 0; i < errors.size(); ++i)
  {
    const double d = static_cast<double>(i) - middle;
    covariance.ofMax -= d * std::log2(errors[i].max());
    covariance.ofMean -= d * std::log2(errors[i].mean());
    variance += d * d;
  }
  const auto finite = [](double order) {
    return std::isfinite(order) ? order : std::numeric_limits<double>::quiet_NaN();
  };
  return { finite(covariance.ofMax / variance), finite(covariance.ofMean / variance) };
}

} // namespace treeamr::report

// Errors at many points, and the order at which they fall as cells become smaller.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace treeamr::report
{

class ErrorNorms
{
public:
  void add(double error)
  {
    max_ = std::max(max_, error);
    sum_ += error;
    ++count_;
  }
  double max() const { return max_; }
  double mean() const { return sum_ / static_cast<double>(count_); }
  std::size_t count() const { return count_; }

private:
  double max_ = 0.;
  double sum_ = 0.;
  std::size_t count_ = 0;
};

struct ConvergenceOrder
{
  double ofMax;
  double ofMean;
};

/// Of errors at widths that halve from one to the next, by least squares; NaN for less than two errors and
/// for zeros.
ConvergenceOrder fittedOrder(const std::vector<ErrorNorms>& errors);

} // namespace treeamr::report

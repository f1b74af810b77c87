// An array whose values are names: which there are, and a cell's by its number among these. Private to the converter.
//
// The numbers are whole and few enough for floats, whatever the values: ids up to 2^53 keep their digits.
#pragma once

#include "HyperTreeGridSource.h"

#include "Field/TransferFunction.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace treeamr
{

/// Numbers, each once.
class DistinctValues
{
public:
  /// The memory in use is a small multiple of the result's. Throws Error beyond `most`.
  explicit DistinctValues(std::size_t most)
    : most_(most)
  {
  }
  void add(double value)
  {
    // Neighbours mostly have the same.
    if (values_.size() > sorted_ && values_.back() == value)
    {
      return;
    }
    values_.push_back(value);
    if (values_.size() >= limit_)
    {
      sort();
    }
  }
  void add(const DistinctValues& other)
  {
    for (const double value : other.values_)
    {
      add(value);
    }
  }
  /// Ascending.
  const std::vector<double>& sort()
  {
    std::sort(values_.begin() + static_cast<std::ptrdiff_t>(sorted_), values_.end());
    std::inplace_merge(
      values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(sorted_), values_.end());
    values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
    sorted_ = values_.size();
    if (sorted_ > most_)
    {
      throw Error("more than " + std::to_string(most_) +
        " different values, which is as many categories as there may be");
    }
    limit_ = std::max<std::size_t>(2 * sorted_, 1 << 12);
    return values_;
  }

private:
  std::size_t most_;
  std::vector<double> values_; // the first sorted_ ascending, each once
  std::size_t sorted_ = 0;
  std::size_t limit_ = 1 << 12;
};

/// In place of CellValues: numbers of values.
class CategoryNumbers
{
public:
  /// Of the leaves that exist. Keeps a reference to the values. Throws Error for more than
  /// TransferFunction::mostCategories.
  CategoryNumbers(const HyperTreeGridTopology& topology, const CellValues& values)
    : values_(values)
  {
    try
    {
      tbb::enumerable_thread_specific<DistinctValues> found(TransferFunction::mostCategories);
      topology.forEachLeaf([&](vtkIdType index) { found.local().add(values(index)); });
      DistinctValues all(TransferFunction::mostCategories);
      found.combine_each([&](const DistinctValues& part) { all.add(part); });
      categories_ = all.sort();
    }
    catch (const Error& error)
    {
      throw Error(
        "hyper tree grid: cell array '" + std::string(values.array().GetName()) + "' has " + error.what());
    }
  }

  double operator()(vtkIdType index) const
  {
    return static_cast<double>(
      std::lower_bound(categories_.begin(), categories_.end(), values_(index)) - categories_.begin());
  }
  const std::vector<double>& categories() const noexcept { return categories_; }

  /// The one with the largest share, of equals the first: numbers have no mean.
  class Blend
  {
  public:
    void add(double number, double weight)
    {
      const auto at = std::lower_bound(
        shares_.begin(), shares_.end(), number, [](const auto& share, double n) { return share.first < n; });
      if (at != shares_.end() && at->first == number)
      {
        at->second += weight;
      }
      else
      {
        shares_.insert(at, { number, weight });
      }
    }
    double value() const
    {
      return std::max_element(shares_.begin(), shares_.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      })->first;
    }

  private:
    std::vector<std::pair<double, double>> shares_; // by number
  };

private:
  const CellValues& values_;
  std::vector<double> categories_;
};

} // namespace treeamr

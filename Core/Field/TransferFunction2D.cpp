#include "Field/TransferFunction2D.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

using Axis = TransferFunction2D::Axis;

/// Of a value among the axis' entries, 0 to size - 1.
double position(const Axis& axis, double value) noexcept
{
  const auto last = static_cast<double>(axis.size - 1);
  const double p = axis.max > axis.min ? (value - axis.min) * (last / (axis.max - axis.min)) : 0.;
  return p > 0. ? std::min(p, last) : 0.;
}

} // namespace

TransferFunction2D::TransferFunction2D(const Axis& first, const Axis& second, std::vector<Entry> entries)
  : first_(first)
  , second_(second)
  , entries_(std::move(entries))
{
  const bool areTwo = first.size >= 2 && second.size >= 2;
  if (!areTwo || entries_.size() / first.size != second.size || entries_.size() % first.size != 0 ||
    entries_.size() > mostEntries)
  {
    throw Error("transfer function of two values: " + std::to_string(entries_.size()) + " entries for " +
      std::to_string(first.size) + " x " + std::to_string(second.size) +
      ", allowed are as many as that, two or more along each axis, and " + std::to_string(mostEntries) +
      " in all");
  }
  // What these refuse is refused here.
  mostOverFirst();
  mostOverSecond();
  for (std::size_t i = 0; i < entries_.size(); ++i)
  {
    const Entry& e = entries_[i];
    if (!(e.extinction >= 0.f) || !std::isfinite(e.extinction) || !std::isfinite(e.r + e.g + e.b))
    {
      throw Error("transfer function of two values: entry " + std::to_string(i) + " has extinction " +
        std::to_string(e.extinction) + "; colours must be finite, extinctions finite and not negative");
    }
  }
}

TransferFunction2D::Entry TransferFunction2D::at(double first, double second) const noexcept
{
  const double x = position(first_, first);
  const double y = position(second_, second);
  const std::size_t column = std::min(static_cast<std::size_t>(x), first_.size - 2);
  const std::size_t row = std::min(static_cast<std::size_t>(y), second_.size - 2);
  const auto inRow = [&](std::size_t r) {
    const Entry* const low = entries_.data() + r * first_.size + column;
    return TransferFunction::between(low[0], low[1], static_cast<float>(x - static_cast<double>(column)));
  };
  return TransferFunction::between(
    inRow(row), inRow(row + 1), static_cast<float>(y - static_cast<double>(row)));
}

TransferFunction2D TransferFunction2D::withExtinctionsTimes(double factor) const
{
  TransferFunction2D result = *this;
  for (Entry& entry : result.entries_)
  {
    entry.extinction =
      static_cast<float>(std::min(entry.extinction * factor, TransferFunction::opaqueExtinction));
  }
  return result;
}

TransferFunction TransferFunction2D::mostOverFirst() const
{
  std::vector<Entry> most(first_.size, Entry{});
  for (std::size_t i = 0; i < entries_.size(); ++i)
  {
    float& extinction = most[i % first_.size].extinction;
    extinction = std::max(extinction, entries_[i].extinction);
  }
  return TransferFunction(first_.min, first_.max, std::move(most));
}

TransferFunction TransferFunction2D::mostOverSecond() const
{
  std::vector<Entry> most(second_.size, Entry{});
  for (std::size_t i = 0; i < entries_.size(); ++i)
  {
    float& extinction = most[i / first_.size].extinction;
    extinction = std::max(extinction, entries_[i].extinction);
  }
  return TransferFunction(second_.min, second_.max, std::move(most));
}

} // namespace treeamr

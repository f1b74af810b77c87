#include "Field/TransferFunction.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace treeamr
{

TransferFunction::TransferFunction(double min, double max, std::vector<Entry> entries)
  : min_(min)
  , scale_(max > min ? static_cast<double>(entries.size() - 1) / (max - min) : 0.)
  , last_(static_cast<double>(entries.size()) - 1.)
  , entries_(std::move(entries))
{
  if (entries_.size() < 2)
  {
    throw Error("transfer function: " + std::to_string(entries_.size()) + " entries, allowed are 2 or more");
  }
  if (!std::isfinite(max - min) || max < min)
  {
    throw Error("transfer function: interval [" + std::to_string(min) + ", " + std::to_string(max) +
      "], allowed are finite ones that do not decrease");
  }
  visibleBefore_.resize(entries_.size() + 1, 0);
  for (std::size_t i = 0; i < entries_.size(); ++i)
  {
    const Entry& e = entries_[i];
    if (!(e.extinction >= 0.f) || !std::isfinite(e.extinction) || !std::isfinite(e.r + e.g + e.b))
    {
      throw Error("transfer function: entry " + std::to_string(i) + " has extinction " +
        std::to_string(e.extinction) + "; colours must be finite, extinctions finite and not negative");
    }
    visibleBefore_[i + 1] = visibleBefore_[i] + (e.extinction > 0.f);
  }
}

TransferFunction TransferFunction::ofCategories(std::vector<Entry> entries)
{
  if (entries.empty() || entries.size() > mostCategories)
  {
    throw Error("transfer function: " + std::to_string(entries.size()) + " categories, allowed are 1 to " +
      std::to_string(mostCategories));
  }
  if (entries.size() == 1)
  {
    entries.push_back(entries.front());
  }
  const auto last = static_cast<double>(entries.size() - 1);
  TransferFunction result(0., last, std::move(entries));
  result.reach_ = 1;
  return result;
}

float TransferFunction::extinctionFromOpacity(double opacity, double unitDistance) noexcept
{
  if (!(opacity > 0.))
  {
    return 0.f;
  }
  return static_cast<float>(
    opacity < 1. ? std::min(opaqueExtinction, -std::log1p(-opacity) / unitDistance) : opaqueExtinction);
}

TransferFunction::Entry TransferFunction::at(float value) const noexcept
{
  return atPosition(position(value));
}

TransferFunction::Entry TransferFunction::atPosition(double p) const noexcept
{
  const auto i = std::min(static_cast<std::size_t>(p), entries_.size() - 2);
  const auto f = static_cast<float>(p - static_cast<double>(i));
  const Entry& a = entries_[i];
  const Entry& b = entries_[i + 1];
  // Exact at both ends, however opaque one is.
  return { std::lerp(a.r, b.r, f), std::lerp(a.g, b.g, f), std::lerp(a.b, b.b, f),
    std::lerp(a.extinction, b.extinction, f) };
}

} // namespace treeamr

#include "Field/TransferFunction.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace treeamr
{

namespace
{

void check(const TransferFunction::Entry& e, const char* kind, std::size_t i)
{
  if (!(e.extinction >= 0.f) || !std::isfinite(e.extinction) || !std::isfinite(e.r + e.g + e.b))
  {
    throw Error("transfer function: " + std::string(kind) + " " + std::to_string(i) + " has extinction " +
      std::to_string(e.extinction) + "; colours must be finite, extinctions finite and not negative");
  }
}

} // namespace

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
    check(entries_[i], "entry", i);
    visibleBefore_[i + 1] = visibleBefore_[i] + (entries_[i].extinction > 0.f);
  }
}

TransferFunction TransferFunction::ofNodes(std::vector<Node> nodes)
{
  if (nodes.empty())
  {
    throw Error("transfer function: 0 nodes, allowed are 1 or more");
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    check(nodes[i].below, "below node", i);
    check(nodes[i].above, "above node", i);
    if (!std::isfinite(nodes[i].value) || (i > 0 && !(nodes[i - 1].value < nodes[i].value)))
    {
      throw Error("transfer function: node " + std::to_string(i) + " at " + std::to_string(nodes[i].value) +
        (i > 0 ? " after " + std::to_string(nodes[i - 1].value) : "") +
        ", allowed are finite values that increase");
    }
  }
  constexpr std::size_t samples = 4096;
  double min = nodes.front().value;
  double max = nodes.back().value;
  // What lies beyond a jump at an end has an entry, too.
  const double width = max > min ? max - min : std::max(std::abs(max), std::numeric_limits<double>::min());
  const double beside = 2. * width / samples;
  min -= nodes.front().below == nodes.front().above ? 0. : beside;
  max += nodes.back().below == nodes.back().above ? 0. : beside;

  if (!std::isfinite(max - min))
  {
    throw Error("transfer function: nodes from " + std::to_string(min) + " to " + std::to_string(max) +
      ", allowed is a finite width");
  }

  TransferFunction result;
  result.nodes_ = std::move(nodes);
  result.min_ = min;
  result.last_ = samples - 1.;
  result.scale_ = max > min ? result.last_ / (max - min) : 0.;
  result.nodesBefore_.assign(samples + 1, 0);
  for (const Node& node : result.nodes_)
  {
    ++result.nodesBefore_[static_cast<std::size_t>(result.position(node.value)) + 1];
  }
  std::partial_sum(result.nodesBefore_.begin(), result.nodesBefore_.end(), result.nodesBefore_.begin());
  result.entries_.resize(samples);
  for (std::size_t i = 0; i < samples; ++i)
  {
    result.entries_[i] =
      result.atValue(i + 1 < samples ? min + static_cast<double>(i) / result.last_ * (max - min) : max);
  }
  result.visibleBefore_.assign(1, 0);
  for (std::size_t i = 0; i <= result.nodes_.size(); ++i)
  {
    const bool isVisible = (i > 0 && result.nodes_[i - 1].above.extinction > 0.f) ||
      (i < result.nodes_.size() && result.nodes_[i].below.extinction > 0.f);
    result.visibleBefore_.push_back(result.visibleBefore_.back() + isVisible);
  }
  return result;
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

TransferFunction TransferFunction::withExtinction(float extinction) const
{
  if (!nodes_.empty())
  {
    std::vector<Node> nodes = nodes_;
    for (Node& node : nodes)
    {
      node.below.extinction = node.above.extinction = extinction;
    }
    return ofNodes(std::move(nodes));
  }
  std::vector<Entry> entries = entries_;
  for (Entry& entry : entries)
  {
    entry.extinction = extinction;
  }
  return TransferFunction(min_, scale_ > 0. ? min_ + last_ / scale_ : min_, std::move(entries));
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
  return nodes_.empty() ? atPosition(position(value)) : atValue(value);
}

TransferFunction::Entry TransferFunction::atPosition(double p) const noexcept
{
  const auto i = std::min(static_cast<std::size_t>(p), entries_.size() - 2);
  return between(entries_[i], entries_[i + 1], static_cast<float>(p - static_cast<double>(i)));
}

TransferFunction::Entry TransferFunction::between(const Entry& a, const Entry& b, float part) noexcept
{
  return { std::lerp(a.r, b.r, part), std::lerp(a.g, b.g, part), std::lerp(a.b, b.b, part),
    std::lerp(a.extinction, b.extinction, part) };
}

TransferFunction::Entry TransferFunction::atValue(double value) const noexcept
{
  const std::size_t next = nodesUpTo(value);
  if (next == 0 || next == nodes_.size())
  {
    return next == 0 ? nodes_.front().below : nodes_.back().above;
  }
  const Node& a = nodes_[next - 1];
  const Node& b = nodes_[next];
  // Halves: the difference of the largest numbers is none.
  return between(
    a.above, b.below, static_cast<float>((0.5 * value - 0.5 * a.value) / (0.5 * b.value - 0.5 * a.value)));
}

} // namespace treeamr

#include "Support/LineIntegral.h"

#include <algorithm>
#include <cmath>

namespace treeamr::test
{

namespace
{

/// Or sums have no digits for what is less.
double atMostDense(double extinction)
{
  return std::min(extinction, 1e9);
}

} // namespace

LineIntegral::LineIntegral(const TransferFunction& transferFunction)
{
  const auto valuesOf = [](const TransferFunction::Entry& e) {
    return Values{ e.r, e.g, e.b, e.extinction };
  };
  for (const auto& node : transferFunction.nodes())
  {
    nodes_.push_back({ node.value, valuesOf(node.below), valuesOf(node.above) });
  }
  const auto& entries = transferFunction.entries();
  for (std::size_t i = 0; transferFunction.nodes().empty() && i < entries.size(); ++i)
  {
    const double scale = transferFunction.scale();
    nodes_.push_back({ transferFunction.min() + (scale > 0. ? static_cast<double>(i) / scale : 0.),
      valuesOf(entries[i]), valuesOf(entries[i]) });
    if (scale == 0.)
    {
      break;
    }
  }
  depths_.push_back(0.);
  for (std::size_t i = 1; i < nodes_.size(); ++i)
  {
    depths_.push_back(depths_.back() +
      (nodes_[i].value - nodes_[i - 1].value) * 0.5 *
        (atMostDense(nodes_[i - 1].above[3]) + atMostDense(nodes_[i].below[3])));
  }
}

std::size_t LineIntegral::nodesUpTo(double value) const
{
  return static_cast<std::size_t>(std::upper_bound(nodes_.begin(), nodes_.end(), value,
                                    [](double v, const Node& node) { return v < node.value; }) -
    nodes_.begin());
}

double LineIntegral::depthUpTo(double value) const
{
  const std::size_t next = nodesUpTo(value);
  const std::size_t node = next > 0 ? next - 1 : 0;
  const double begin = next > 0 ? nodes_[node].above[3] : nodes_[node].below[3];
  return depths_[node] +
    (value - nodes_[node].value) * 0.5 * (atMostDense(begin) + atMostDense(at(value, next)[3]));
}

double LineIntegral::opticalDepth(double from, double to, double length) const
{
  if (from == to)
  {
    return length * at(from, nodesUpTo(from))[3];
  }
  return length * (depthUpTo(to) - depthUpTo(from)) / (to - from);
}

LineIntegral::Values LineIntegral::at(double value, std::size_t next) const
{
  if (next == 0 || next == nodes_.size())
  {
    return next == 0 ? nodes_.front().below : nodes_.back().above;
  }
  const Node& a = nodes_[next - 1];
  const Node& b = nodes_[next];
  const double part = (value - a.value) / (b.value - a.value);
  Values values;
  for (int c = 0; c < 4; ++c)
  {
    values[c] = (1. - part) * a.above[c] + part * b.below[c];
  }
  return values;
}

void LineIntegral::addLight(
  double from, double to, double length, std::array<double, 4>& color, double& transmittance) const
{
  std::size_t next = nodesUpTo(from);
  const std::size_t last = nodesUpTo(to);
  if (next == last)
  {
    addLine(at(from, next), at(to, next), length, color, transmittance);
    return;
  }
  const bool rises = from < to;
  const double perValue = length / (to - from);
  double value = from;
  Values values = at(from, next);
  while (next != last)
  {
    const Node& node = nodes_[rises ? next : next - 1];
    addLine(values, rises ? node.below : node.above, perValue * (node.value - value), color, transmittance);
    value = node.value;
    values = rises ? node.above : node.below;
    next = rises ? next + 1 : next - 1;
  }
  addLine(values, at(to, next), perValue * (to - value), color, transmittance);
}

void LineIntegral::addLine(const Values& from, const Values& to, double length, std::array<double, 4>& color,
  double& transmittance, int depth)
{
  const double optical = 0.5 * (from[3] + to[3]) * length;
  if (!(optical > 0.))
  {
    return;
  }
  double change = 0.; // of colour
  for (int c = 0; c < 3; ++c)
  {
    change = std::max(change, std::abs(to[c] - from[c]));
  }
  const double bend = std::abs(to[3] - from[3]) / (to[3] + from[3]);
  const double seen = transmittance * std::min(1., optical);
  // The product of colour and extinction bends, and what is in front counts more than what is behind it.
  constexpr double tolerance = 1e-7;
  constexpr int deepest = 60;
  if (depth < deepest && change * seen * (0.2 * bend + std::min(1., optical)) > tolerance)
  {
    Values middle;
    for (int c = 0; c < 4; ++c)
    {
      middle[c] = 0.5 * (from[c] + to[c]);
    }
    addLine(from, middle, 0.5 * length, color, transmittance, depth + 1);
    addLine(middle, to, 0.5 * length, color, transmittance, depth + 1);
    return;
  }
  const double held = transmittance * -std::expm1(-optical);
  for (int c = 0; c < 3; ++c)
  {
    color[c] += held * 0.5 * (from[c] + to[c]);
  }
  color[3] += held;
  transmittance -= held;
}

} // namespace treeamr::test

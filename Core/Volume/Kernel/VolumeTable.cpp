#include "Volume/Kernel/VolumeTable.h"

#include "Geometry/Bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace treeamr
{

namespace
{

/// A table of few entries is tabulated anew, unless nothing lies between its entries.
std::size_t entriesPerEntry(const TransferFunction& transferFunction)
{
  if (transferFunction.hasCategories())
  {
    return 1;
  }
  constexpr std::size_t fewest = 4096;
  return (fewest - 2) / (transferFunction.entries().size() - 1) + 1;
}

bool fits(const Field& field, const TransferFunction& transferFunction, double perEntry)
{
  constexpr double large = std::numeric_limits<float>::max() / 4.;
  const Range range = field.range();
  const double width = static_cast<double>(range.max) - range.min;
  const double low = std::abs(transferFunction.min());
  const double scale = transferFunction.scale() * perEntry;
  // A block cannot count steps of a denormal hull: it must be a small part of an entry.
  constexpr double steep = 0.1 / std::numeric_limits<float>::min();
  // Where the field crosses the table: two farthest places would tell nothing of it.
  const double reach = std::min(range.max - transferFunction.min(), transferFunction.min() - range.min);
  return width < large && low < large && scale < steep && (scale == 0. || scale > 1. / large) &&
    !(reach * scale > farthestPlace) && !IntegralTable::needsDoubles(transferFunction);
}

/// The function at a value, found from a node near to it.
TransferFunction::Entry entryNear(
  const std::vector<TransferFunction::Node>& nodes, std::size_t near, double value)
{
  std::size_t next = near;
  while (next > 0 && nodes[next - 1].value > value)
  {
    --next;
  }
  while (next < nodes.size() && nodes[next].value <= value)
  {
    ++next;
  }
  if (next == 0 || next == nodes.size())
  {
    return next == 0 ? nodes.front().below : nodes.back().above;
  }
  const TransferFunction::Node& a = nodes[next - 1];
  const TransferFunction::Node& b = nodes[next];
  return TransferFunction::between(
    a.above, b.below, static_cast<float>((value - a.value) / (b.value - a.value)));
}

/// Whether peaks that are seen are so narrow that places of the field have few digits in them as floats. diagonal: of the
/// domain.
bool hasNarrowPeaks(const Field& field, const TransferFunction& transferFunction, double diagonal)
{
  const std::vector<TransferFunction::Node>& nodes = transferFunction.nodes();
  if (nodes.empty())
  {
    return false;
  }
  constexpr double part = 0x1p-14;
  constexpr double leastDepth = 1. / 64.; // where the field crosses all of that once on the way
  const double all = std::min(
    static_cast<double>(field.range().max) - field.range().min, nodes.back().value - nodes.front().value);
  const double width = part * all;
  const double seen = leastDepth * all / diagonal;
  const auto termsOf = [](const TransferFunction::Entry& e) {
    return std::array{ e.extinction * e.r, e.extinction * e.g, e.extinction * e.b, e.extinction };
  };
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
  {
    const TransferFunction::Node& low = nodes[i];
    const TransferFunction::Node& high = nodes[i + 1];
    const double between = high.value - low.value;
    if (!(between < width) || std::max(low.above.extinction, high.below.extinction) * between < seen)
    {
      continue;
    }
    const auto before = termsOf(entryNear(nodes, i, low.value - width));
    const auto begin = termsOf(low.above);
    const auto end = termsOf(high.below);
    const auto after = termsOf(entryNear(nodes, i + 1, high.value + width));
    for (int c = 0; c < 4; ++c)
    {
      const double largest = std::max(begin[c], end[c]);
      const double beside = std::max(before[c], after[c]);
      if (largest > 2. * beside && (largest - beside) * between >= seen)
      {
        return true;
      }
    }
  }
  return false;
}

} // namespace

double relativeLeafWidth(const RootGrid& grid, int level)
{
  const Bounds domain = grid.bounds();
  double width = 0.;
  for (int a = 0; a < 3; ++a)
  {
    width = std::max(width, (domain.max[a] - domain.min[a]) / grid.roots()[a]);
  }
  return std::ldexp(width / diagonalOf(domain), -level);
}

VolumeTable::VolumeTable(const Field& field, const TransferFunction& transferFunction, int worldMagnitude)
  : perEntry(static_cast<double>(entriesPerEntry(transferFunction)))
  , worldMagnitude_(worldMagnitude)
  , diagonal_(diagonalOf(field.octree().grid().bounds()))
  , smallestLeaf_(
      std::ldexp(relativeLeafWidth(field.octree().grid(), field.octree().leafLevels()), worldMagnitude))
  // Opaque across a millionth of the smallest leaf: more would only cost the integrals their digits.
  , mostExtinction_(1e6 / smallestLeaf_)
{
  fitsSinglePrecision =
    fits(field, transferFunction, perEntry) && !hasNarrowPeaks(field, transferFunction, diagonal_);
  const std::size_t size = (transferFunction.entries().size() - 1) * static_cast<std::size_t>(perEntry) + 1;
  last = static_cast<float>(size - 1);
  std::vector<TransferFunction::Entry> tabulated(size);
  entries.resize(size);
  for (std::size_t i = 0; i < size; ++i)
  {
    tabulated[i] = transferFunction.atPosition(static_cast<double>(i) / perEntry);
    entries[i] = inTable(tabulated[i]);
  }
  if (transferFunction.hasCategories())
  {
    return;
  }
  const std::vector<EmissionTerms> terms = termsOf(tabulated);
  findRoughGaps(transferFunction, tabulated);
  variation.assign(size, 0.);
  curvature.assign(size, 0.);
  for (std::size_t i = 1; i < size; ++i)
  {
    double change = 0.;
    double bend = 0.;
    for (int c = 0; c < 4; ++c)
    {
      change = std::max(change, std::abs(terms[i][c] - terms[i - 1][c]));
      // Constant beyond the ends.
      const double next = terms[std::min(i + 1, size - 1)][c];
      const double last = terms[i - 1][c];
      bend = std::max(
        bend, std::abs(next - 2. * terms[i][c] + last) + (i == 1 ? std::abs(terms[1][c] - last) : 0.));
    }
    variation[i] = variation[i - 1] + change;
    curvature[i] = curvature[i - 1] + bend;
  }
}

TransferFunction::Entry VolumeTable::inTable(TransferFunction::Entry entry) const noexcept
{
  entry.extinction = static_cast<float>(
    std::min<double>(entry.extinction * diagonal_ * std::numbers::log2e, TransferFunction::opaqueExtinction));
  return entry;
}

void VolumeTable::integrate(const TransferFunction& transferFunction)
{
  if (!integrals)
  {
    integrals = std::make_unique<IntegralTable>(transferFunction, diagonal_, mostExtinction_, smallestLeaf_);
  }
}

void VolumeTable::findRoughGaps(
  const TransferFunction& transferFunction, const std::vector<TransferFunction::Entry>& tabulated)
{
  // Of a channel, and of extinctions: a part, but where depth across the domain hardly depends on it.
  constexpr float channel = 1.f / 512.f;
  constexpr double part = 1. / 64.;
  constexpr double depth = 1. / 8.;
  const auto differs = [&](const TransferFunction::Entry& a, const TransferFunction::Entry& b) {
    const float extinction = std::max(a.extinction, b.extinction);
    const double change = std::abs(static_cast<double>(a.extinction) - b.extinction);
    return extinction > 0.f &&
      ((change > part * extinction && change * diagonal_ > depth) ||
        std::max({ std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b) }) > channel);
  };
  std::vector<bool> isRough(entries.size(), false);
  for (std::size_t i = 0; i + 1 < entries.size(); ++i)
  {
    const TransferFunction::Entry& a = tabulated[i];
    const TransferFunction::Entry& b = tabulated[i + 1];
    const TransferFunction::Entry middle = TransferFunction::between(a, b, 0.5f);
    isRough[i] = differs(a, middle) || differs(middle, b);
  }
  for (const TransferFunction::Node& node : transferFunction.nodes())
  {
    const double position = transferFunction.position(node.value);
    const TransferFunction::Entry& nearest = tabulated[static_cast<std::size_t>(position + 0.5)];
    if (differs(nearest, node.below) || differs(nearest, node.above))
    {
      const auto gap = static_cast<std::size_t>(position);
      isRough[gap] = true;
      // Rounding may take a place to the other side of an entry.
      isRough[gap > 0 ? gap - 1 : 0] = true;
    }
  }
  rough.assign(entries.size(), 0);
  for (std::size_t i = 1; i < entries.size(); ++i)
  {
    rough[i] = rough[i - 1] + isRough[i - 1];
  }
}

std::vector<EmissionTerms> VolumeTable::termsOf(const std::vector<TransferFunction::Entry>& tabulated) const
{
  std::vector<EmissionTerms> terms;
  terms.reserve(tabulated.size());
  for (const TransferFunction::Entry& e : tabulated)
  {
    const double extinction = std::min(e.extinction * diagonal_, mostExtinction_);
    terms.push_back({ extinction * e.r, extinction * e.g, extinction * e.b, extinction });
  }
  return terms;
}

} // namespace treeamr

#include "Volume/Kernel/VolumeTable.h"

#include "Geometry/Bounds.h"

#include <algorithm>
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
    !(reach * scale > farthestPlace);
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
  // Opaque across a millionth of the smallest leaf: more would only cost the integrals their digits.
  , mostExtinction_(std::ldexp(
      1e6 / relativeLeafWidth(field.octree().grid(), field.octree().leafLevels()), -worldMagnitude))
{
  fitsSinglePrecision = fits(field, transferFunction, perEntry);
  const std::size_t size = (transferFunction.entries().size() - 1) * static_cast<std::size_t>(perEntry) + 1;
  last = static_cast<float>(size - 1);
  entries.resize(size);
  for (std::size_t i = 0; i < size; ++i)
  {
    entries[i] = transferFunction.atPosition(static_cast<double>(i) / perEntry);
    entries[i].extinction = static_cast<float>(std::min<double>(
      entries[i].extinction * diagonal_ * std::numbers::log2e, TransferFunction::opaqueExtinction));
  }
  if (transferFunction.hasCategories())
  {
    return;
  }
  const std::vector<std::array<double, 4>> terms = this->terms(transferFunction);
  variation.assign(size, 0.);
  curvature.assign(size, 0.);
  for (std::size_t i = 1; i < size; ++i)
  {
    double change = 0.;
    double bend = 0.;
    for (int c = 0; c < 4; ++c)
    {
      change = std::max(change, std::abs(terms[i][c] - terms[i - 1][c]));
      bend =
        i + 1 < size ? std::max(bend, std::abs(terms[i + 1][c] - 2. * terms[i][c] + terms[i - 1][c])) : 0.;
    }
    variation[i] = variation[i - 1] + change;
    curvature[i] = curvature[i - 1] + bend;
  }
}

void VolumeTable::integrate(const TransferFunction& transferFunction)
{
  if (!integrals.empty())
  {
    return;
  }
  const std::vector<std::array<double, 4>> terms = this->terms(transferFunction);
  integrals.resize(terms.size());
  std::array<double, 4> sum{};
  for (std::size_t i = 0; i < terms.size(); ++i)
  {
    for (int c = 0; c < 4; ++c)
    {
      integrals[i].sum[c] = static_cast<float>(sum[c]);
      integrals[i].rest[c] = static_cast<float>(sum[c] - integrals[i].sum[c]);
      integrals[i].own[c] = static_cast<float>(terms[i][c]);
      sum[c] += terms[i][c];
    }
  }
}

std::vector<std::array<double, 4>> VolumeTable::terms(const TransferFunction& transferFunction) const
{
  std::vector<std::array<double, 4>> terms;
  terms.reserve(entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    const TransferFunction::Entry e = transferFunction.atPosition(static_cast<double>(i) / perEntry);
    const double extinction = std::min(e.extinction * diagonal_, mostExtinction_);
    terms.push_back({ extinction * e.r, extinction * e.g, extinction * e.b, extinction });
  }
  return terms;
}

} // namespace treeamr

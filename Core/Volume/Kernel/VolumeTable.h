// A transfer function as the volume kernel reads it: by entry, whatever the camera. Of few entries it makes more, so
// that the nearest one stands for what lies between them.
//
// Extinctions count per diagonal of the domain in data coordinates: the kernel's rays know how much of the world that
// is.
#pragma once

#include "Field/Field.h"
#include "Field/TransferFunction.h"
#include "Volume/Kernel/IntegralTable.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace treeamr
{

class VolumeTable
{
public:
  /// worldMagnitude: the power of two of what a data coordinate is in the world. It says what is opaque, no more.
  VolumeTable(const Field& field, const TransferFunction& transferFunction, int worldMagnitude);

  int worldMagnitude() const noexcept { return worldMagnitude_; }

  /// What the function has at a value, as entries have it, but between them, too.
  TransferFunction::Entry at(const TransferFunction& transferFunction, float value) const noexcept
  {
    const double place = transferFunction.position(value) * perEntry;
    const std::size_t i = std::min(static_cast<std::size_t>(place), entries.size() - 2);
    if (!rough.empty() && rough[i + 1] != rough[i])
    {
      return inTable(transferFunction.at(value));
    }
    return TransferFunction::between(
      entries[i], entries[i + 1], static_cast<float>(place - static_cast<double>(i)));
  }

  /// Makes the integrals, unless they are there. Not for categories.
  void integrate(const TransferFunction& transferFunction);

  /// Whether the kernel's single precision follows it: differences of values and their positions must not leave it.
  bool fitsSinglePrecision;
  double perEntry; // entries for one of the transfer function
  float last;      // number of the last entry
  /// For point samples: the nearest entry, its extinction in binary orders of magnitude.
  std::vector<TransferFunction::Entry> entries;
  /// Sums over the entries before each one of what changes from entry to entry: of the extinction or its product
  /// with a colour, whichever changes most. None for categories, of which no leaf varies; as the others.
  std::vector<double> variation;
  /// The same for the changes of these changes.
  std::vector<double> curvature;
  /// How many of the gaps behind the entries before each one hide what their nearest entry does not show.
  std::vector<std::uint32_t> rough;
  std::unique_ptr<const IntegralTable> integrals; // once they are made

private:
  /// With the extinction as entries have it.
  TransferFunction::Entry inTable(TransferFunction::Entry entry) const noexcept;
  // tabulated: the function's values at all entries.
  /// Extinction times colour and extinction.
  std::vector<EmissionTerms> termsOf(const std::vector<TransferFunction::Entry>& tabulated) const;
  void findRoughGaps(
    const TransferFunction& transferFunction, const std::vector<TransferFunction::Entry>& tabulated);

  int worldMagnitude_;
  double diagonal_;
  double smallestLeaf_;   // its width, for the terms
  double mostExtinction_; // in the terms
};

/// What float lanes count of a place in the table that is farther from it. Doubles count all.
constexpr double farthestPlace = 0x1p100;

/// Width of a leaf of a level in diagonals of the domain; of the mean root where these differ.
double relativeLeafWidth(const RootGrid& grid, int level);

} // namespace treeamr

// A transfer function's integrals over the field's value, for steps of any width: of parts between which the function
// bends or jumps, found in a look-up by place and a short search.
#pragma once

#include "Field/TransferFunction.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Extinction times red, green and blue, and extinction, in the order of TransferFunction::Entry.
using EmissionTerms = std::array<double, 4>;

class IntegralTable
{
public:
  /// A part of the function, linear in the place: its terms where it begins, their slope, and their integrals from the
  /// first node up to there in two floats each, the sum and what rounding left of it; to be multiplied by unscale().
  struct Row
  {
    float own[4];
    float slope[4];
    float sum[4];
    float rest[4];
  };

  /// Extinctions count times unit; sums cap them at mostExtinction. smallestLeaf: its width, for extinctions so counted.
  /// Not for categories.
  IntegralTable(
    const TransferFunction& transferFunction, double unit, double mostExtinction, double smallestLeaf);

  /// Whether its lowest nodes lie where float lanes, whose places have less room, have no digits left: beyond 55 decades.
  static bool needsDoubles(const TransferFunction& transferFunction);

  /// A value's place: its distance from a value of the function's, where places have most digits, in a power of two.
  double placeOf(double value) const noexcept { return (value - reference_) * scale_; }
  double reference() const noexcept { return reference_; }
  double placesPerValue() const noexcept { return scale_; }
  /// The row of a place: how many nodes lie there or below it.
  std::size_t rowOf(double place) const noexcept;
  /// Mean extinction, as of entries, over all values between two places.
  double meanExtinction(double firstPlace, double lastPlace) const noexcept;
  /// Sum of the changes of a term, whichever changes most, from a row on to before another one; of those that share with
  /// them, too.
  double variation(std::size_t firstRow, std::size_t endRow) const noexcept
  {
    const std::size_t beforeGroup = (std::size_t(1) << sharing_) - 1;
    return variation_[(endRow + beforeGroup) >> sharing_] - variation_[firstRow >> sharing_];
  }
  /// The widest step of places that follows the function between two of them to 1/512 of a channel: none across a jump.
  float finestStep(double firstPlace, double lastPlace) const noexcept;

  // For the kernel.
  const std::vector<Row>& rows() const noexcept { return rows_; }
  /// Where a row begins (the first one ends); beyond the last row as many infinite ones as a search may ask for.
  const float* places() const noexcept { return places_.data(); }
  /// Rows that share what only estimates are made of, as a power of two: of tables of few nodes each has its own.
  int sharing() const noexcept { return sharing_; }
  /// How far the colours of all that is visible have changed up to where rows that share begin, and by how much more per
  /// place.
  struct ColorChange
  {
    float before;
    float perPlace;
  };
  const std::vector<ColorChange>& colorChanges() const noexcept { return colorChanges_; }
  double unscale() const noexcept { return unscale_; }

  /// Cells of equal width in places or, where nodes crowd, in bits of floats: each has a first row, and its rows are
  /// searched by so many halvings.
  struct Index
  {
    bool byBits = false;
    float first = 0.f; // of places, and the last one
    float last = 0.f;
    float cellsPerPlace = 0.f;
    int shift = 0;              // of orderedBits()
    std::int32_t firstBits = 0; // shifted
    std::int32_t lastCell = 0;
    int halvings = 0;
    std::vector<float> firstRow; // as numbers of the kernel's lanes
  };
  const Index& index() const noexcept { return index_; }
  /// Of memory.
  std::size_t bytes() const noexcept;

private:
  struct Station;
  std::vector<Station> makeStations(const TransferFunction& transferFunction,
    const std::vector<TransferFunction::Node>& nodes, double unit) const;
  static void thin(std::vector<Station>& stations, double tolerance);
  static bool isSteep(const Station& low, const Station& high);
  static std::vector<Station> withStairs(const std::vector<Station>& stations);
  void makeRows(const std::vector<Station>& stations, double mostInSums);
  void shareColorChanges();
  void makeFinestSteps(const std::vector<Station>& stations, double smallestLeaf);
  Index indexBy(bool bits) const;
  std::vector<float>::const_iterator endOfPlaces() const noexcept
  {
    return places_.begin() + static_cast<std::ptrdiff_t>(rows_.size()) - 1;
  }

  double reference_;
  double scale_;
  double unscale_;
  bool isOfMany_; // nodes
  int sharing_ = 0;
  std::vector<Row> rows_;
  std::vector<float> places_;
  std::vector<ColorChange> colorChanges_;
  std::vector<double> variation_;
  std::vector<float> finestSteps_; // of rows that share; negative where a row begins with a jump that is seen
  std::vector<std::vector<float>> finestOfGroups_; // the least of 2^i groups of rows from each on
  Index index_;
};

/// Integers in the order of floats: as bits, those of negative ones turned round.
inline std::int32_t orderedBits(std::int32_t bits) noexcept
{
  return bits ^ ((bits >> 31) & 0x7fffffff);
}

} // namespace treeamr

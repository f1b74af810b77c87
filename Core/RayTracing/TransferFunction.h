// Colour and extinction over the field's value, tabulated.
#pragma once

#include "Octree/Field.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace treeamr
{

class TransferFunction
{
public:
  struct Entry
  {
    float r, g, b;    // not premultiplied
    float extinction; // per unit of world length
  };
  /// entries: >= 2 samples equally spaced over [min, max], the ends included; linear in between, constant
  /// beyond. Where min == max, which is allowed, all values have the first entry. Throws Error for fewer entries, a
  /// non-finite or empty interval, negative or NaN extinction.
  TransferFunction(double min, double max, std::vector<Entry> entries);

  /// Opaque over any step, yet finite, so that interpolation beside it makes no NaN.
  static constexpr double opaqueExtinction = 1e30;
  /// Extinction per world length of a volume whose opacity over `unitDistance` is `opacity`.
  static float extinctionFromOpacity(double opacity, double unitDistance) noexcept;

  double min() const noexcept { return min_; }
  /// Entries per unit of value.
  double scale() const noexcept { return scale_; }
  const std::vector<Entry>& entries() const noexcept { return entries_; }

  /// Of a value in the table, 0 to entries - 1.
  double position(float value) const noexcept
  {
    const double p = (value - min_) * scale_;
    return p > 0. ? std::min(p, last_) : 0.;
  }
  Entry at(float value) const noexcept;
  Entry atPosition(double position) const noexcept;
  /// Whether some value of the range has extinction: exact, so that skipping by it never changes a pixel.
  bool isVisible(Range range) const noexcept
  {
    // position() does not decrease, so every value of the range reads entries between these two.
    const auto first = std::min(static_cast<std::size_t>(position(range.min)), entries_.size() - 2);
    const auto last = std::min(static_cast<std::size_t>(position(range.max)), entries_.size() - 2) + 1;
    return visibleBefore_[last + 1] > visibleBefore_[first];
  }

private:
  double min_; // double: values up to 1e38 have differences beyond float
  double scale_;
  double last_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> visibleBefore_; // entries with extinction among the first i
};

} // namespace treeamr

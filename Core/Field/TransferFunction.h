// Colour and extinction over the field's value, tabulated, or of categories.
#pragma once

#include "Field/Field.h"

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
  /// Categories: the leaf value i, a whole number, has entry i, and means nothing between two. So volumes show
  /// each leaf in its own value's entry, without reconstruction, whatever the settings. One entry or more, at most
  /// mostCategories; throws Error for others, and for entries as above.
  static TransferFunction ofCategories(std::vector<Entry> entries);
  /// Whole numbers that floats, the values of fields, can count.
  static constexpr std::size_t mostCategories = std::size_t(1) << 24;

  /// Opaque over any step, yet finite, so that interpolation beside it makes no NaN.
  static constexpr double opaqueExtinction = 1e30;
  /// Extinction per world length of a volume whose opacity over `unitDistance` is `opacity`.
  static float extinctionFromOpacity(double opacity, double unitDistance) noexcept;

  double min() const noexcept { return min_; }
  /// Entries per unit of value.
  double scale() const noexcept { return scale_; }
  const std::vector<Entry>& entries() const noexcept { return entries_; }
  bool hasCategories() const noexcept { return reach_ == 1; }

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
    const std::size_t end = entries_.size() - reach_;
    const auto first = std::min(static_cast<std::size_t>(position(range.min)), end);
    const auto last = std::min(static_cast<std::size_t>(position(range.max)), end) + reach_ - 1;
    return visibleBefore_[last + 1] > visibleBefore_[first];
  }

private:
  double min_; // double: values up to 1e38 have differences beyond float
  double scale_;
  double last_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> visibleBefore_; // entries with extinction among the first i
  std::size_t reach_ = 2;                    // entries that one value reads: of a category its own alone
};

} // namespace treeamr

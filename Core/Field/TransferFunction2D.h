// Colour and extinction over two values at once: the field's, and the length of its gradient or another field's.
#pragma once

#include "Field/TransferFunction.h"

#include <cstddef>
#include <vector>

namespace treeamr
{

/// Of values less their fields' offsets.
class TransferFunction2D
{
public:
  /// Of two values.
  using Entry = TransferFunction::Entry;
  /// Entries are equally spaced over [min, max], the ends included. Where min == max, which is allowed, all values have
  /// the first one.
  struct Axis
  {
    double min;       // of the first entry
    double max;       // of the last one
    std::size_t size; // of entries, two or more
  };
  /// entries: first.size for each entry of the second axis, one after the other; bilinear in between, constant beyond.
  /// Throws Error for others, more than mostEntries, and for axes and entries as TransferFunction.
  TransferFunction2D(const Axis& first, const Axis& second, std::vector<Entry> entries);
  /// Whose floats the kernel's lanes can count.
  static constexpr std::size_t mostEntries = std::size_t(1) << 24;

  ///@{
  /// What it was made of.
  const Axis& first() const noexcept { return first_; }
  const Axis& second() const noexcept { return second_; }
  const std::vector<Entry>& entries() const noexcept { return entries_; }
  ///@}
  /// At two values.
  Entry at(double first, double second) const noexcept;

  /// The same with extinctions times a factor.
  TransferFunction2D withExtinctionsTimes(double factor) const;
  ///@{
  /// For values of one axis the largest extinctions, whatever the other value is: transparent where nothing is seen.
  TransferFunction mostOverFirst() const;
  TransferFunction mostOverSecond() const;
  ///@}

private:
  Axis first_;
  Axis second_;
  std::vector<Entry> entries_;
};

} // namespace treeamr

// A node's range in two bytes: its ends as 255ths of the parent's range, rounded outwards.
//
// Whoever walks down hands the parent's decoded range on. Each level may widen a range by a 255th of the
// parent's at either end and never narrows it, so what is skipped by it is invisible.
#pragma once

#include <algorithm>
#include <cstdint>

namespace treeamr
{

/// Of values, both ends included.
struct Range
{
  float min; // the least value
  float max; // the largest one
};

/// Two bytes for a range within another one, the parent's.
class RangeCode
{
public:
  RangeCode() noexcept = default;
  /// The tightest code that decodes to a range around `exact`, which lies within `parent`.
  RangeCode(Range exact, Range parent) noexcept
    : lower_(0)
    , upper_(255)
  {
    const double perStep = step(parent) > 0. ? 1. / step(parent) : 0.;
    // Where the parent's range is a single value or a few denormals the steps have no width.
    const auto guess = [&](float value) {
      const double steps = (static_cast<double>(value) - parent.min) * perStep;
      return value >= parent.max ? 255 : static_cast<int>(std::clamp(steps, 0., 254.));
    };
    int lower = guess(exact.min);
    while (lower > 0 && position(lower, parent) > exact.min)
    {
      --lower;
    }
    while (lower < 255 && position(lower + 1, parent) <= exact.min)
    {
      ++lower;
    }
    int upper = guess(exact.max);
    while (upper < 255 && position(upper, parent) < exact.max)
    {
      ++upper;
    }
    while (upper > 0 && position(upper - 1, parent) >= exact.max)
    {
      --upper;
    }
    lower_ = static_cast<std::uint8_t>(lower);
    upper_ = static_cast<std::uint8_t>(upper);
  }

  /// Around the exact range, within the parent's.
  Range decode(Range parent) const noexcept { return { position(lower_, parent), position(upper_, parent) }; }

private:
  /// In double: the width of a range of floats may be beyond float. Rounded to float, so that its product
  /// with a code is exact and a fused multiply-add, which some targets use, gives the same bits.
  static double step(Range parent) noexcept
  {
    return static_cast<float>((static_cast<double>(parent.max) - parent.min) * (1. / 255.));
  }
  /// Counted from the nearer end: 0 is parent.min and 255 parent.max exactly.
  static float position(int code, Range parent) noexcept
  {
    const bool low = code < 128;
    const double from = low ? parent.min : parent.max;
    return static_cast<float>(from + (low ? code : code - 255) * step(parent));
  }

  std::uint8_t lower_;
  std::uint8_t upper_;
};
static_assert(sizeof(RangeCode) == 2);

} // namespace treeamr

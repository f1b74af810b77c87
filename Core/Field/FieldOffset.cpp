#include "Field/FieldOffset.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

/// From a float to the next one beyond.
double stepAt(double value) noexcept
{
  using Float = std::numeric_limits<float>;
  const int exponent = value > Float::min() ? std::ilogb(value) : Float::min_exponent - 1;
  return std::ldexp(1., exponent + 1 - Float::digits);
}

} // namespace

double offsetFor(double least, double greatest, double base) noexcept
{
  constexpr double mostLost = 0x1p-16; // of the range
  const double range = greatest - least;
  const double farthest = std::max(std::abs(least), std::abs(greatest));
  if (base == 0. ? stepAt(farthest) / 2. <= mostLost * range : farthest <= 2. * range)
  {
    return base;
  }
  if (range == 0.)
  {
    return base + least;
  }
  const double unit = std::ldexp(1., std::ilogb(range));
  return base + unit * std::round((0.5 * least + 0.5 * greatest) / unit);
}

} // namespace treeamr

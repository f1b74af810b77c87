#include "Forest/PayloadGuess.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <sstream>

namespace treeamr
{
namespace
{

/// Of the stored exponent, which is 0 for zero and denormals.
constexpr int exponentOf(std::uint64_t bits)
{
  return static_cast<int>(bits >> 52 & 0x7ff);
}

/// Zero, or between 2^-64 and 2^64: half of all patterns, but nearly all floats of a simulation.
bool isUsualFloat(std::uint32_t bits)
{
  const int exponent = static_cast<int>(bits >> 23 & 0xff) - 127;
  return bits << 1 == 0 || std::abs(exponent) <= 64;
}

/// A count, index or rank: one pattern in 2^11.
bool isUsualCount(std::uint32_t bits)
{
  return std::abs(static_cast<std::int64_t>(std::bit_cast<std::int32_t>(bits))) < 1 << 20;
}

} // namespace

void DoubleGuess::add(const std::byte* payload) noexcept
{
  std::uint64_t bits;
  std::memcpy(&bits, payload, sizeof(bits));
  const double value = std::bit_cast<double>(bits);
  notFinite_ += std::isfinite(value) ? 0 : 1;
  largest_ = std::max(largest_, std::abs(value)); // a NaN leaves it
  const int exponent = exponentOf(bits);
  leastExponent_ = count_ == 0 ? exponent : std::min(leastExponent_, exponent);
  greatestExponent_ = count_ == 0 ? exponent : std::max(greatestExponent_, exponent);
  ++count_;

  constexpr std::uint32_t belowFloat = (std::uint32_t(1) << 29) - 1; // mantissa bits that a float has not
  const auto lower = static_cast<std::uint32_t>(bits);
  lowerAreShort_ = lowerAreShort_ && (lower & belowFloat) == 0;
  lowerAreFloats_ = lowerAreFloats_ && isUsualFloat(lower);
  lowerAreCounts_ = lowerAreCounts_ && isUsualCount(lower);
}

std::string DoubleGuess::objection() const
{
  using Float = std::numeric_limits<float>;
  std::ostringstream text;
  if (notFinite_ > 0)
  {
    text << "are not finite in " << notFinite_ << " of " << count_ << " cells";
  }
  else if (largest_ == 0.)
  {
    text << "are all 0";
  }
  else if (largest_ < double(Float::min()) || largest_ > double(Float::max()))
  {
    text << "go up to " << largest_ << ", which single precision does not hold";
  }
  else if (leastExponent_ == greatestExponent_)
  {
    text << "all have one exponent, as " << largest_;
  }
  else if (!lowerAreShort_ && (lowerAreFloats_ || lowerAreCounts_))
  {
    text << "would be two numbers of 4 bytes side by side, the first of them "
         << (lowerAreCounts_ ? "an integer" : "a float");
  }
  return text.str();
}

} // namespace treeamr

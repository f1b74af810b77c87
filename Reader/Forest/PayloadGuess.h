// Whether 8 bytes a cell, of which nobody told what they are, look like a double.
//
// Integers and pointers give denormals, NaNs or values of one exponent when read as double; hashes give values
// that no single-precision field can hold; structs of two numbers have a number of its own where a double has
// the last half of its mantissa. An answer in doubt is no: then the user is asked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace treeamr
{

class DoubleGuess
{
public:
  /// 8 bytes at any alignment.
  void add(const std::byte* payload) noexcept;

  /// What speaks against doubles, to follow "read as double they "; empty when nothing does.
  std::string objection() const;

private:
  std::uint64_t count_ = 0;
  std::uint64_t notFinite_ = 0;
  double largest_ = 0.; // magnitude
  int leastExponent_ = 0;
  int greatestExponent_ = 0;
  // What all of the lower halves are, so far. Those of doubles that were floats or short numbers are zeros, or
  // zeros but for three bits.
  bool lowerAreShort_ = true;
  bool lowerAreFloats_ = true;
  bool lowerAreCounts_ = true;
};

} // namespace treeamr

// The layout of a quadrant's payload, told by the user as text, because the file knows its size only.
//
// The text lists the members of the C struct that the program kept in its quadrants:
//   double rho; double velocity[3]; int rank, flags
// Types, with fixed sizes wherever the file comes from:
//   char, signed char, int8                  1 byte     unsigned char, uint8       1 byte
//   short, int16                             2 bytes    unsigned short, uint16     2 bytes
//   int, int32                               4 bytes    unsigned, uint32           4 bytes
//   long, long long, int64                   8 bytes    unsigned long, uint64      8 bytes
//   float                                    4 bytes    double                     8 bytes
// (also int8_t ..., unsigned int, short int and the like). name[n] is an array of n components, pad[n] are n
// bytes to leave out. As a compiler does, each member begins at a multiple of its type's size and the whole
// is rounded up to a multiple of the largest type's. After the word packed neither is so, as in a packed struct:
//   packed char kind; double rho
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace treeamr
{

enum class PayloadType : std::uint8_t
{
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Int64,
  UInt64,
  Float32,
  Float64
};

/// Bytes of one value.
std::size_t payloadTypeSize(PayloadType type) noexcept;

struct PayloadField
{
  struct Term
  {
    std::uint32_t index; // of a value stored from the field's offset on
    double weight;
  };

  std::string name;
  PayloadType type; // of the stored values
  int components;
  std::size_t offset; // bytes from the payload's begin
  /// Of which stored values each component is the sum, of a field of floats or doubles; none: the components are stored.
  std::vector<std::vector<Term>> sums{};
  /// Whether the components are values at the eight corners of a quadrant, in the order of its tree's own axes, x fastest.
  bool isAtCorners = false;
};

class PayloadLayout
{
public:
  /// Throws Error with the text, the position in it (from 1), what was found there and what is allowed.
  static PayloadLayout parse(std::string_view text);

  /// In the order of the text, without padding; may be empty.
  const std::vector<PayloadField>& fields() const noexcept { return fields_; }
  /// Bytes of the whole, as sizeof would say.
  std::size_t size() const noexcept { return size_; }

private:
  friend class PayloadParser;
  std::vector<PayloadField> fields_;
  std::size_t size_ = 0;
};

} // namespace treeamr

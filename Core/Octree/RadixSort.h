// Parallel radix sort of records by an unsigned key, from the highest digit down until few bits are left:
// after the first pass each part is sorted within a cache, and bits in which the keys of a part agree cost
// nothing.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace treeamr
{

/// Record: trivially copyable, with an unsigned `key`.
template <class Record>
requires std::unsigned_integral<decltype(Record::key)>
class RadixSort
{
public:
  /// Sorts records[0 .. count); scratch is as long. Equal keys come in any order.
  static void sort(Record* records, Record* scratch, std::size_t count)
  {
    place(records, scratch, count, records);
  }

private:
  using Key = decltype(Record::key);
  static constexpr int maxDigitBits = 11;
  static constexpr int maxPassBits = 10;
  static constexpr std::size_t parallelCount = std::size_t(1) << 17;

  struct Digit
  {
    int shift;
    int bits;
    std::size_t operator()(const Record& r) const noexcept
    {
      return static_cast<std::size_t>(r.key >> shift) & ((std::size_t(1) << bits) - 1);
    }
  };

  /// Sorts `from` into `result`, which is `from` or `other`; the contents of the remaining one are lost.
  static void place(Record* from, Record* other, std::size_t count, Record* result)
  {
    constexpr std::size_t insertionCount = 24;
    if (count <= insertionCount)
    {
      insert(from, count, result);
      return;
    }
    const Key varying = count < parallelCount ? varyingBits(from, 0, count) : varyingBits(from, count);
    if (varying == 0)
    {
      if (result != from)
      {
        std::copy_n(from, count, result);
      }
      return;
    }
    const int high = static_cast<int>(std::bit_width(varying));
    // Few bits are left: from the lowest digit up, in so many passes that the last one ends in `result`.
    const int passes = result == from ? 2 : 3;
    const int passBits = (high + passes - 1) / passes;
    if (count < parallelCount && passBits <= maxPassBits && count >> passBits != 0)
    {
      placeFromLowest(from, other, count, passes, passBits);
      return;
    }
    // A few records for each value of the digit, so that the next digit is the last.
    const int bits = std::min({ high, maxDigitBits, static_cast<int>(std::bit_width(count)) - 3 });
    const Digit digit{ high - bits, bits };
    std::array<std::size_t, (1 << maxDigitBits) + 1> begin;
    count < parallelCount ? scatter(from, count, digit, other, begin)
                          : scatterInParallel(from, count, digit, other, begin);
    const auto placePart = [&](std::size_t d) {
      const std::size_t b = begin[d];
      place(other + b, from + b, begin[d + 1] - b, result + b);
    };
    const std::size_t parts = std::size_t(1) << bits;
    if (count < parallelCount)
    {
      for (std::size_t d = 0; d < parts; ++d)
      {
        placePart(d);
      }
    }
    else
    {
      tbb::parallel_for(std::size_t(0), parts, placePart);
    }
  }

  static void insert(const Record* from, std::size_t count, Record* result)
  {
    for (std::size_t i = 0; i < count; ++i)
    {
      const Record r = from[i];
      std::size_t at = i;
      for (; at > 0 && result[at - 1].key > r.key; --at)
      {
        result[at] = result[at - 1];
      }
      result[at] = r;
    }
  }

  /// Sorts by the lowest passes * bits of the key; an even number of passes ends in `from`, an odd one in
  /// `other`.
  static void placeFromLowest(Record* from, Record* other, std::size_t count, int passes, int bits)
  {
    const std::size_t values = std::size_t(1) << bits;
    std::array<std::array<std::uint32_t, 1 << maxPassBits>, 3> next;
    for (int p = 0; p < passes; ++p)
    {
      std::fill_n(next[p].begin(), values, 0);
    }
    for (std::size_t i = 0; i < count; ++i)
    {
      for (int p = 0; p < passes; ++p)
      {
        ++next[p][Digit{ p * bits, bits }(from[i])];
      }
    }
    for (int p = 0; p < passes; ++p)
    {
      std::exclusive_scan(next[p].begin(), next[p].begin() + values, next[p].begin(), std::uint32_t(0));
      const Digit digit{ p * bits, bits };
      for (std::size_t i = 0; i < count; ++i)
      {
        other[next[p][digit(from[i])]++] = from[i];
      }
      std::swap(from, other);
    }
  }

  static Key varyingBits(const Record* from, std::size_t begin, std::size_t end)
  {
    Key varying = 0;
    for (std::size_t i = begin; i < end; ++i)
    {
      varying |= from[i].key ^ from[0].key;
    }
    return varying;
  }
  static Key varyingBits(const Record* from, std::size_t count)
  {
    return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, parallelCount / 4), Key(0),
      [&](const auto& range, Key varying) {
        return static_cast<Key>(varying | varyingBits(from, range.begin(), range.end()));
      },
      [](Key a, Key b) { return static_cast<Key>(a | b); });
  }

  /// begin[d]: place of the first record with digit d; and the end.
  static void scatter(const Record* from, std::size_t count, Digit digit, Record* to,
    std::array<std::size_t, (1 << maxDigitBits) + 1>& begin)
  {
    const std::size_t values = std::size_t(1) << digit.bits;
    std::array<std::uint32_t, 1 << maxDigitBits> next;
    std::fill_n(next.begin(), values, 0);
    for (std::size_t i = 0; i < count; ++i)
    {
      ++next[digit(from[i])];
    }
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < values; ++d)
    {
      begin[d] = sum;
      sum += next[d];
      next[d] = static_cast<std::uint32_t>(begin[d]);
    }
    begin[values] = count;
    for (std::size_t i = 0; i < count; ++i)
    {
      to[next[digit(from[i])]++] = from[i];
    }
  }

  static void scatterInParallel(const Record* from, std::size_t count, Digit digit, Record* to,
    std::array<std::size_t, (1 << maxDigitBits) + 1>& begin)
  {
    const std::size_t values = std::size_t(1) << digit.bits;
    const std::size_t stretch = std::max(parallelCount / 2, count / 64 + 1);
    const std::size_t stretches = (count + stretch - 1) / stretch;
    std::vector<std::size_t> next(stretches * values, 0); // by stretch, then digit
    tbb::parallel_for(std::size_t(0), stretches, [&](std::size_t s) {
      std::size_t* const n = next.data() + s * values;
      for (std::size_t i = s * stretch; i < std::min(count, (s + 1) * stretch); ++i)
      {
        ++n[digit(from[i])];
      }
    });
    std::size_t sum = 0;
    for (std::size_t d = 0; d < values; ++d)
    {
      begin[d] = sum;
      for (std::size_t s = 0; s < stretches; ++s)
      {
        sum += std::exchange(next[s * values + d], sum);
      }
    }
    begin[values] = count;
    tbb::parallel_for(std::size_t(0), stretches, [&](std::size_t s) {
      std::size_t* const n = next.data() + s * values;
      for (std::size_t i = s * stretch; i < std::min(count, (s + 1) * stretch); ++i)
      {
        to[n[digit(from[i])]++] = from[i];
      }
    });
  }
};

} // namespace treeamr

// Cells as sortable integers: the octants on the way down to a cell, three bits each, then a one.
//
// The final one stands for the cell's size: it puts the cell in the middle of the keys of all that lies
// inside it, so disjoint cells sort in Morton order (x fastest) and of overlapping cells two are neighbours.
#pragma once

#include "Octree/RootGrid.h"

#include <array>
#include <bit>
#include <cstdint>

namespace treeamr
{

/// x's low 21 bits, each followed by two zeros towards the high end.
constexpr std::uint64_t spreadBits(std::uint64_t x) noexcept
{
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}
/// The inverse: every third bit of x.
constexpr std::uint64_t gatherBits(std::uint64_t x) noexcept
{
  x &= 0x1249249249249249;
  x = (x | x >> 2) & 0x10c30c30c30c30c3;
  x = (x | x >> 4) & 0x100f00f00f00f00f;
  x = (x | x >> 8) & 0x1f0000ff0000ff;
  x = (x | x >> 16) & 0x1f00000000ffff;
  return (x | x >> 32) & 0x1fffff;
}
constexpr std::uint64_t interleave(std::uint64_t x, std::uint64_t y, std::uint64_t z) noexcept
{
  return spreadBits(x) | spreadBits(y) << 1 | spreadBits(z) << 2;
}

/// Keys of one word, for cells down to a depth.
template <class Word>
class MortonKeys
{
public:
  using Key = Word;
  /// Deepest level below the padded root that fits the word.
  static constexpr int maxDepth = (8 * static_cast<int>(sizeof(Word)) - 1) / 3;

  explicit MortonKeys(int depth) noexcept
    : depth_(depth)
  {
  }
  /// index: on the lattice of `depth`.
  Key key(const std::array<Coord, 3>& index, int depth) const noexcept
  {
    const std::uint64_t path = interleave(index[0], index[1], index[2]);
    return static_cast<Word>((path << 1 | 1) << 3 * (depth_ - depth));
  }
  int depth(Key key) const noexcept { return depth_ - std::countr_zero(key) / 3; }
  /// The octant that leads to depth `depth` on the way to the cell.
  int octant(Key key, int depth) const noexcept
  {
    return static_cast<int>(key >> (3 * (depth_ - depth) + 1) & 7);
  }
  /// On the lattice of a depth, of the cell or of what is around it.
  std::array<Coord, 3> index(Key key, int depth) const noexcept
  {
    const std::uint64_t path = std::uint64_t(key) >> 3 * (depth_ - depth) >> 1;
    return { static_cast<Coord>(gatherBits(path)), static_cast<Coord>(gatherBits(path >> 1)),
      static_cast<Coord>(gatherBits(path >> 2)) };
  }
  /// Depth of the deepest node around two disjoint cells; of overlapping ones at least that of the coarser.
  int commonDepth(Key a, Key b) const noexcept
  {
    return (3 * depth_ + 1 - static_cast<int>(std::bit_width(static_cast<Word>(a ^ b)))) / 3;
  }

private:
  int depth_;
};

/// Three words of 21 octants, the first the most significant, for any octree; the final one is the high bit
/// of the octant after the last.
struct WideKey
{
  std::array<std::uint64_t, 3> words;

  auto operator<=>(const WideKey&) const noexcept = default;
};

template <>
class MortonKeys<WideKey>
{
public:
  using Key = WideKey;
  static constexpr int maxDepth = 62;

  explicit MortonKeys(int /*depth*/) noexcept {}
  Key key(const std::array<Coord, 3>& index, int depth) const noexcept
  {
    std::array<std::uint64_t, 3> at;
    for (int a = 0; a < 3; ++a)
    {
      at[a] = static_cast<std::uint64_t>(index[a]) << (digits - depth);
    }
    at[2] |= std::uint64_t(1) << (digits - depth - 1);
    Key k;
    for (int w = 0; w < 3; ++w)
    {
      const int down = 21 * (2 - w);
      k.words[w] = interleave(at[0] >> down, at[1] >> down, at[2] >> down);
    }
    return k;
  }
  int depth(const Key& key) const noexcept
  {
    int last = 2;
    while (key.words[last] == 0)
    {
      --last;
    }
    return 21 * last + 20 - std::countr_zero(key.words[last]) / 3;
  }
  int octant(const Key& key, int depth) const noexcept
  {
    return static_cast<int>(key.words[(depth - 1) / 21] >> 3 * (20 - (depth - 1) % 21) & 7);
  }
  std::array<Coord, 3> index(const Key& key, int depth) const noexcept
  {
    std::array<Coord, 3> index{};
    for (int d = 1; d <= depth; ++d)
    {
      index = indexOfChild(index, octant(key, d));
    }
    return index;
  }
  int commonDepth(const Key& a, const Key& b) const noexcept
  {
    for (int w = 0; w < 3; ++w)
    {
      if (const std::uint64_t difference = a.words[w] ^ b.words[w]; difference != 0)
      {
        return 21 * w + (63 - static_cast<int>(std::bit_width(difference))) / 3;
      }
    }
    return maxDepth;
  }

private:
  static constexpr int digits = 63;
};

} // namespace treeamr

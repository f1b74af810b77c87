// A 128-bit digest of the content that a cached object was made from.
//
// VTK gives no identity for the topology of a vtkHyperTreeGrid: ShallowCopy() makes new vtkHyperTree objects
// that share storage nobody outside can hold, and refining a tree changes no MTime. So the content itself is
// the key. Two lanes of multiply and xor-shift with odd constants of MurmurHash3's and SplitMix64's
// finalisers; each step is a bijection of the lane's state, so contents that differ in one word only never
// collide. Not meant to resist an attacker.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <cstdint>
#include <cstring>
#include <vector>

namespace treeamr
{

class ContentDigest
{
public:
  void add(std::uint64_t word) noexcept
  {
    lanes_[0] = (lanes_[0] ^ word) * 0xff51afd7ed558ccdull;
    lanes_[0] ^= lanes_[0] >> 33;
    lanes_[1] = (lanes_[1] ^ word) * 0xbf58476d1ce4e5b9ull;
    lanes_[1] ^= lanes_[1] >> 31;
  }
  void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const ContentDigest& other) noexcept
  {
    add(other.lanes_[0]);
    add(other.lanes_[1]);
  }

  /// Adds `size` bytes, digested in parallel in blocks of a fixed size: the result does not depend on the
  /// number of threads.
  void addBytes(const void* data, std::size_t size)
  {
    constexpr std::size_t blockSize = std::size_t(1) << 18;
    const auto* bytes = static_cast<const unsigned char*>(data);
    std::vector<ContentDigest> blocks((size + blockSize - 1) / blockSize);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 1), [&](const auto& range) {
      for (std::size_t b = range.begin(); b != range.end(); ++b)
      {
        const std::size_t begin = b * blockSize;
        blocks[b].addBlock(bytes + begin, std::min(blockSize, size - begin));
      }
    });
    add(std::uint64_t(size));
    for (const ContentDigest& block : blocks)
    {
      add(block);
    }
  }

  auto operator<=>(const ContentDigest&) const noexcept = default;

private:
  void addBlock(const unsigned char* bytes, std::size_t size) noexcept
  {
    std::uint64_t word = 0;
    for (; size >= sizeof(word); size -= sizeof(word), bytes += sizeof(word))
    {
      std::memcpy(&word, bytes, sizeof(word));
      add(word);
    }
    word = 0;
    std::memcpy(&word, bytes, size);
    add(word);
  }

  std::array<std::uint64_t, 2> lanes_{ 0x9e3779b97f4a7c15ull, 0xc4ceb9fe1a85ec53ull };
};

} // namespace treeamr

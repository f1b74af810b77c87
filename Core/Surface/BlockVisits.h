// The blocks that the rays of a tile come to, until all have been found: neighbouring rays come to the same ones.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// For each block which rays of which packets come to it. Keeps its memory.
class BlockVisits
{
public:
  static constexpr std::uint32_t none = 0xffffffffu;

  struct Visit
  {
    std::uint16_t first;  // ray of a packet
    std::uint16_t wanted; // bits of those of its 16 that come
    std::uint32_t next;   // visit of the block; none: the last
  };

  /// Adds a visit; depth(): where the block is along the rays, asked for once.
  template <class Depth>
  void add(std::uint32_t block, int first, std::uint32_t wanted, const Depth& depth)
  {
    if (2 * (blocks_.size() + 1) > slots_.size())
    {
      this->grow();
    }
    std::uint32_t& slot = slots_[this->slotOf(block)];
    visits_.push_back({ static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(wanted), none });
    const auto visit = static_cast<std::uint32_t>(visits_.size() - 1);
    if (slot == none)
    {
      const auto number = static_cast<std::uint32_t>(blocks_.size());
      order_.push_back(orderOf(depth()) << 32 | number);
      blocks_.push_back({ block, visit, visit });
      slot = number;
    }
    else
    {
      Block& known = blocks_[slot];
      visits_[known.lastVisit].next = visit;
      known.lastVisit = visit;
    }
  }
  void clear() noexcept
  {
    if (blocks_.empty())
    {
      return;
    }
    visits_.clear();
    blocks_.clear();
    order_.clear();
    std::fill(slots_.begin(), slots_.end(), none);
  }

  /// From now on the blocks are those from near to far.
  void sort() { std::sort(order_.begin(), order_.end()); }
  std::size_t blockCount() const noexcept { return order_.size(); }
  std::uint32_t block(std::size_t i) const noexcept { return this->at(i).block; }
  /// Calls body(visit) for those of the i-th block, packet by packet.
  template <class Body>
  void forVisits(std::size_t i, const Body& body) const
  {
    for (std::uint32_t v = this->at(i).firstVisit; v != none; v = visits_[v].next)
    {
      body(visits_[v]);
    }
  }

private:
  struct Block
  {
    std::uint32_t block;
    std::uint32_t firstVisit;
    std::uint32_t lastVisit;
  };

  /// In the order of floats, as numbers without sign.
  static std::uint64_t orderOf(float depth) noexcept
  {
    const auto bits = std::bit_cast<std::uint32_t>(depth);
    return bits ^ (bits >> 31 ? 0xffffffffu : 0x80000000u);
  }
  const Block& at(std::size_t i) const noexcept { return blocks_[order_[i] & 0xffffffffu]; }
  /// Where a block is, or may be put.
  std::size_t slotOf(std::uint32_t block) const noexcept
  {
    std::size_t slot = (block * 0x9e3779b97f4a7c15u >> 32) & (slots_.size() - 1);
    while (slots_[slot] != none && blocks_[slots_[slot]].block != block)
    {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    return slot;
  }
  void grow()
  {
    constexpr std::size_t least = 256;
    slots_.assign(std::max(least, 2 * slots_.size()), none);
    for (std::size_t i = 0; i < blocks_.size(); ++i)
    {
      slots_[this->slotOf(blocks_[i].block)] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<Visit> visits_;
  std::vector<Block> blocks_;
  std::vector<std::uint64_t> order_; // depth << 32 | number among the blocks
  /// A hash table of the blocks' numbers, half empty; its size is a power of two.
  std::vector<std::uint32_t> slots_;
};

} // namespace treeamr

// Vertex values of blocks of leaves kept between tiles and frames, within a budget of memory.
//
// Filled by the renderer's threads without locks: a block's record is written first and published then. Two
// threads may compute the same block at once; both records are right and one is wasted. Only blocks that some
// frame has seen take memory.
#pragma once

#include "ChunkPool.h"
#include "Interpolation/BlockValues.h"
#include "Prefetch.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace treeamr
{

/// A block's 125 vertex values in 65535 steps of their hull: 33 bytes a leaf. A step is 2^-17 of the hull at
/// most from the value, far below what a picture shows; where the transfer function sees single steps the
/// renderer computes the values again.
struct alignas(64) BlockRecord
{
  static constexpr float steps = 65535.f;
  std::array<std::uint16_t, 128> values;

  /// The hull's width must be finite.
  explicit BlockRecord(const BlockValues& block) noexcept;
  BlockRecord() noexcept = default;
};
static_assert(sizeof(BlockRecord) == 256);

class BlockCache
{
  /// Ranges apart, so that finding a block transparent does not touch its values.
  struct Chunk
  {
    static constexpr std::uint32_t size = 256;
    std::array<BlockRecord, size> records;
    std::array<Range, size> ranges;
  };

public:
  /// For one field. A budget too small for the table of its inner nodes keeps nothing.
  BlockCache(const Field& field, std::size_t budgetBytes);

  struct Found
  {
    const BlockRecord* record; // null when the block is not kept
    Range range;
  };
  Found find(std::uint64_t inner, BlockCells cells) const noexcept
  {
    const auto& slots = slotsOf(cells);
    if (slots.empty())
    {
      return { nullptr, {} };
    }
    const std::uint32_t slot = slots[inner].load(std::memory_order_acquire);
    if (slot == 0)
    {
      return { nullptr, {} };
    }
    const Chunk& chunk = pool_.chunkOf(slot);
    return { &chunk.records[slot % Chunk::size], chunk.ranges[slot % Chunk::size] };
  }

  /// Announces that find() will be called for an inner node, or one of the seven after it.
  void prefetchSlot(std::uint64_t inner, BlockCells cells) const noexcept
  {
    treeamr::prefetch(slotsOf(cells).data() + inner);
  }
  /// The same for a node whose slot is there: for what is kept of it.
  void prefetchRecord(std::uint64_t inner, BlockCells cells) const noexcept
  {
    const auto& slots = slotsOf(cells);
    const std::uint32_t slot = slots.empty() ? 0 : slots[inner].load(std::memory_order_acquire);
    if (slot != 0)
    {
      const Chunk& chunk = pool_.chunkOf(slot);
      treeamr::prefetch(&chunk.ranges[slot % Chunk::size]);
      const auto* values = chunk.records[slot % Chunk::size].values.data();
      for (std::size_t i = 0; i < sizeof(BlockRecord) / sizeof(*values); i += 32)
      {
        treeamr::prefetch(values + i);
      }
    }
  }

  /// Keeps the block of an inner node; null when the budget is used up. Its hull's width must be finite.
  const BlockRecord* keep(std::uint64_t inner, BlockCells cells, const BlockValues& block);

  /// Call when no thread renders and blocks of means are going to be kept: they have a table of their own.
  void prepareMeans();
  /// Call when no thread renders, after a frame that found and computed so many blocks. When the budget was used
  /// up before it and most of what is kept was of no use, forgets all, so that a new view gets its share.
  void endFrame(std::uint64_t found, std::uint64_t computed);

  /// Allocated bytes.
  std::size_t byteSize() const noexcept;
  /// Bytes of one block, for budgets.
  static constexpr std::size_t blockBytes = sizeof(Chunk) / Chunk::size;

private:
  using Slots = LargeVector<std::atomic<std::uint32_t>>; // by inner node; 0: not kept
  const Slots& slotsOf(BlockCells cells) const noexcept
  {
    return cells == BlockCells::Leaves ? slots_ : meanSlots_;
  }
  Slots slots_;
  Slots meanSlots_; // empty until they are prepared
  ChunkPool<Chunk> pool_;
  // Of threads, not of their tasks, for as long as the cache lives: else each task would begin a chunk.
  tbb::enumerable_thread_specific<ChunkPool<Chunk>::Writer> writers_;
  bool full_ = false; // overflowed in an earlier frame
};

} // namespace treeamr

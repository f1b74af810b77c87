// What is known of blocks of leaves, kept between tiles and frames within a budget of memory.
//
// Filled by the renderer's threads without locks: a block's record is written first and published then. Two
// threads may compute the same block at once; both records are right and one is wasted. Only blocks that some
// frame has seen take memory.
#pragma once

#include "ChunkPool.h"
#include "Field/Field.h"
#include "Interpolation/BlockValues.h"
#include "Prefetch.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace treeamr
{

/// Chunk: as ChunkPool wants it.
template <class Chunk>
class BlockStore
{
public:
  /// For one field. A budget too small for the table of its inner nodes keeps nothing.
  BlockStore(const Field& field, std::size_t budgetBytes)
    : slots_(budgetBytes < field.octree().innerCount() * sizeof(slots_[0]) + sizeof(Chunk)
          ? 0
          : field.octree().innerCount())
    , pool_(slots_.size(), budgetBytes - slots_.size() * sizeof(slots_[0]))
    , writers_([this] { return typename ChunkPool<Chunk>::Writer(pool_); })
  {
  }

  struct Found
  {
    const Chunk* chunk; // null when the block is not kept
    std::uint32_t index;
  };
  Found find(std::uint64_t inner, BlockCells cells) const noexcept
  {
    const auto& slots = slotsOf(cells);
    const std::uint32_t slot = slots.empty() ? 0 : slots[inner].load(std::memory_order_acquire);
    return slot == 0 ? Found{ nullptr, 0 } : Found{ &pool_.chunkOf(slot), slot % Chunk::size };
  }

  /// Announces that find() will be called for an inner node, or one of the seven after it.
  void prefetchSlot(std::uint64_t inner, BlockCells cells) const noexcept
  {
    treeamr::prefetch(slotsOf(cells).data() + inner);
  }

  /// Keeps what write(chunk, index) writes for an inner node there; null when the budget is used up.
  template <class Write>
  Found keep(std::uint64_t inner, BlockCells cells, const Write& write)
  {
    Slots& slots = cells == BlockCells::Leaves ? slots_ : meanSlots_;
    if (slots.empty())
    {
      return { nullptr, 0 };
    }
    typename ChunkPool<Chunk>::Writer& writer = writers_.local();
    Chunk* chunk = writer.room();
    if (!chunk)
    {
      return { nullptr, 0 };
    }
    const std::uint32_t index = writer.index();
    write(*chunk, index);
    slots[inner].store(writer.keep(), std::memory_order_release);
    return { chunk, index };
  }

  /// Call when no thread renders and blocks of means are going to be kept: they have a table of their own.
  void prepareMeans()
  {
    // The budget's chunks pay for it.
    if (!slots_.empty() && meanSlots_.empty() && pool_.giveUp(slots_.size() * sizeof(slots_[0])))
    {
      meanSlots_ = Slots(slots_.size());
    }
  }
  /// Call when no thread renders, after a frame that found and computed so many blocks. When the budget was used
  /// up before it and most of what is kept was of no use, forgets all, so that a new view gets its share.
  void endFrame(std::uint64_t found, std::uint64_t computed)
  {
    if (full_ && found < computed)
    {
      for (Slots* slots : { &slots_, &meanSlots_ })
      {
        for (auto& slot : *slots)
        {
          slot.store(0, std::memory_order_relaxed);
        }
      }
      pool_.forget();
      writers_.clear();
    }
    full_ = pool_.overflowed();
  }

  /// Whether an earlier frame had more blocks than the budget has room for.
  bool isFull() const noexcept { return full_; }

  /// Allocated bytes.
  std::size_t byteSize() const noexcept
  {
    return (slots_.size() + meanSlots_.size()) * sizeof(slots_[0]) + pool_.byteSize();
  }

private:
  using Slots = LargeVector<std::atomic<std::uint32_t>>; // by inner node; 0: not kept
  const Slots& slotsOf(BlockCells cells) const noexcept
  {
    return cells == BlockCells::Leaves ? slots_ : meanSlots_;
  }

  Slots slots_;
  Slots meanSlots_; // empty until they are prepared
  ChunkPool<Chunk> pool_;
  // Of threads, not of their tasks, for as long as the store lives: else each task would begin a chunk.
  tbb::enumerable_thread_specific<typename ChunkPool<Chunk>::Writer> writers_;
  bool full_ = false; // overflowed in an earlier frame
};

} // namespace treeamr

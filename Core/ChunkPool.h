// Records that many threads add without locks, within a budget of memory.
//
// A record is written first; its number, published by the caller through an atomic with release order, makes it
// and its chunk visible to other threads.
#pragma once

#include "LargeArray.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <vector>

namespace treeamr
{

/// Chunk: Chunk::size records in whatever arrangement. Numbers of records start at 1.
template <class Chunk>
class ChunkPool
{
public:
  /// For up to `records` records, fewer when they do not fit the budget.
  ChunkPool(std::uint64_t records, std::size_t budgetBytes)
  {
    // Threads fill chunks of their own, so some stay partly empty: twice the records is room enough.
    const std::uint64_t wanted = records == 0 ? 0 : 2 * (records / Chunk::size + 64);
    const std::uint64_t addressable = std::numeric_limits<std::uint32_t>::max() / Chunk::size;
    const auto chunks = std::min<std::uint64_t>({ budgetBytes / sizeof(Chunk), wanted, addressable });
    chunks_.resize(chunks);
    slabs_.resize(slabOf(chunks) + 1);
    limit_ = static_cast<std::uint32_t>(chunks);
  }

  /// Record `number` is record number % Chunk::size of this.
  const Chunk& chunkOf(std::uint32_t number) const noexcept { return *chunks_[number / Chunk::size]; }

  /// One for each thread.
  class Writer
  {
  public:
    explicit Writer(ChunkPool& pool) noexcept
      : pool_(pool)
    {
    }
    /// The chunk with room for the next record, at index(); null when the budget is used up.
    Chunk* room()
    {
      if (next_ == end_)
      {
        next_ = end_ = pool_.addChunk();
        if (next_ == 0)
        {
          return nullptr;
        }
        end_ = (next_ / Chunk::size + 1) * Chunk::size;
      }
      return pool_.chunks_[next_ / Chunk::size];
    }
    std::uint32_t index() const noexcept { return next_ % Chunk::size; }
    /// Keeps what was written there: its number.
    std::uint32_t keep() noexcept { return next_++; }

  private:
    ChunkPool& pool_;
    std::uint32_t next_ = 0;
    std::uint32_t end_ = 0;
  };

  /// Whether a writer asked in vain. This and the rest: while no thread writes, writers start anew after it.
  bool overflowed() const noexcept { return overflowed_; }
  void forget() noexcept
  {
    used_ = 0;
    overflowed_ = false;
  }
  /// Gives up the room for so many bytes; false when it is in use.
  bool giveUp(std::size_t bytes)
  {
    const std::size_t chunks = (bytes + sizeof(Chunk) - 1) / sizeof(Chunk);
    if (used_ + chunks >= limit_)
    {
      return false;
    }
    limit_ -= static_cast<std::uint32_t>(chunks);
    std::fill(chunks_.begin() + limit_, chunks_.end(), nullptr);
    std::for_each(slabs_.begin() + slabOf(limit_ - 1) + 1, slabs_.end(), [](auto& slab) { slab.reset(); });
    return true;
  }

  /// Bytes of the chunks in use.
  std::size_t byteSize() const noexcept
  {
    return chunks_.size() * sizeof(chunks_[0]) + std::min<std::size_t>(used_, limit_) * sizeof(Chunk);
  }

private:
  /// Chunks that are allocated together, on large pages; the first ones one by one: little data takes little memory.
  static constexpr std::uint32_t slabChunks = (largeArrayBytes + sizeof(Chunk) - 1) / sizeof(Chunk);
  static constexpr std::uint32_t slabOf(std::uint32_t chunk) noexcept
  {
    return chunk < slabChunks ? chunk : slabChunks - 1 + chunk / slabChunks;
  }

  /// First number of a new chunk; 0 when there is none left.
  std::uint32_t addChunk()
  {
    // The load keeps a full pool from counting on for ever.
    std::uint32_t chunk = used_.load(std::memory_order_relaxed);
    chunk = chunk < limit_ ? used_.fetch_add(1, std::memory_order_relaxed) : chunk;
    if (chunk >= limit_)
    {
      overflowed_.store(true, std::memory_order_relaxed);
      return 0;
    }
    const std::lock_guard lock(allocates_);
    if (!chunks_[chunk])
    {
      try
      {
        const std::uint32_t first = chunk < slabChunks ? chunk : chunk / slabChunks * slabChunks;
        const std::uint32_t count = chunk < slabChunks ? 1 : std::min(slabChunks, limit_ - first);
        LargeArray<Chunk>& slab = slabs_[slabOf(chunk)];
        slab = makeLargeArray<Chunk>(count);
        for (std::uint32_t i = 0; i < count; ++i)
        {
          chunks_[first + i] = &slab[i];
        }
      }
      catch (const std::bad_alloc&)
      {
        return 0; // memory is short: the caller goes without
      }
    }
    return chunk == 0 ? 1 : chunk * Chunk::size;
  }

  std::vector<Chunk*> chunks_;
  std::vector<LargeArray<Chunk>> slabs_;
  std::mutex allocates_;
  std::uint32_t limit_ = 0; // of chunks, that the budget allows
  std::atomic<std::uint32_t> used_{ 0 };
  std::atomic<bool> overflowed_{ false };
};

} // namespace treeamr

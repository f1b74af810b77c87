// Records of one size that many threads add without locks, within a budget of memory.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <vector>

namespace treeamr
{

template <class Record>
class RecordPool
{
  static constexpr std::uint32_t chunkRecords = 256;
  struct Chunk
  {
    std::array<Record, chunkRecords> records;
  };

public:
  /// For up to `records` records, fewer when they do not fit the budget.
  RecordPool(std::uint64_t records, std::size_t budgetBytes)
  {
    // Threads fill chunks of their own, so some stay partly empty: twice the records is room enough.
    const std::uint64_t wanted = 2 * (records / chunkRecords + 64);
    const std::uint64_t addressable = std::numeric_limits<std::uint32_t>::max() / chunkRecords;
    const auto chunks = std::min<std::uint64_t>({ budgetBytes / sizeof(Chunk), wanted, addressable });
    chunks_ = std::vector<std::unique_ptr<Chunk>>(records == 0 ? 0 : chunks);
  }

  /// A number that a writer gave, after its record was written.
  const Record& at(std::uint32_t number) const noexcept
  {
    return chunks_[number / chunkRecords]->records[number % chunkRecords];
  }

  /// One for each thread.
  class Writer
  {
  public:
    explicit Writer(RecordPool& pool) noexcept
      : pool_(pool)
    {
    }
    /// Room to write the next record; null when the budget is used up.
    Record* room()
    {
      if (next_ == end_)
      {
        next_ = pool_.addChunk();
        if (next_ == 0)
        {
          end_ = 0;
          return nullptr;
        }
        end_ = (next_ / chunkRecords + 1) * chunkRecords;
      }
      return &pool_.chunks_[next_ / chunkRecords]->records[next_ % chunkRecords];
    }
    /// Keeps what was written there: its number, not 0.
    std::uint32_t keep() noexcept { return next_++; }

  private:
    RecordPool& pool_;
    std::uint32_t next_ = 0;
    std::uint32_t end_ = 0;
  };

  /// Allocated bytes.
  std::size_t byteSize() const noexcept
  {
    return chunks_.size() * sizeof(chunks_[0]) +
      std::min<std::size_t>(used_.load(), chunks_.size()) * sizeof(Chunk);
  }

private:
  /// First number of a new chunk; 0 when there is none left.
  std::uint32_t addChunk()
  {
    // The load keeps a full pool from counting on for ever.
    if (used_.load(std::memory_order_relaxed) >= chunks_.size())
    {
      return 0;
    }
    const std::uint32_t chunk = used_.fetch_add(1, std::memory_order_relaxed);
    if (chunk >= chunks_.size())
    {
      return 0;
    }
    // Records reach other threads through the atomic that publishes their number, chunks with them.
    chunks_[chunk].reset(new (std::nothrow) Chunk);
    if (!chunks_[chunk])
    {
      return 0; // memory is short: the caller goes without
    }
    return chunk == 0 ? 1 : chunk * chunkRecords;
  }

  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::atomic<std::uint32_t> used_{ 0 };
};

} // namespace treeamr

#include "RayTracing/VertexCache.h"

#include "Interpolation/BlockKernel.h"

#include <algorithm>
#include <limits>
#include <new>

namespace treeamr
{

BlockRecord::BlockRecord(const BlockValues& block) noexcept
{
  quantise(block.values, block.range, steps, values);
}

VertexCache::VertexCache(const Octree& octree, std::size_t budgetBytes)
{
  const std::uint64_t nodes = octree.innerCount();
  const std::size_t tableBytes = nodes * sizeof(slots_[0]);
  if (nodes == 0 || budgetBytes < tableBytes + sizeof(Chunk))
  {
    return;
  }
  // Threads fill chunks of their own, so some stay partly empty: twice the nodes is room enough.
  const std::size_t wanted = 2 * (nodes / chunkRecords + 64);
  const std::size_t addressable = std::numeric_limits<std::uint32_t>::max() / chunkRecords;
  const std::size_t chunks = std::min({ (budgetBytes - tableBytes) / sizeof(Chunk), wanted, addressable });
  slots_ = Slots(nodes);
  chunks_ = std::vector<std::atomic<Chunk*>>(chunks);
  storage_.resize(chunks);
  chunkLimit_ = static_cast<std::uint32_t>(chunks);
}

std::uint32_t VertexCache::addChunk()
{
  // The load keeps a full cache from counting on for ever.
  if (usedChunks_.load(std::memory_order_relaxed) >= chunkLimit_)
  {
    overflowed_.store(true, std::memory_order_relaxed);
    return 0;
  }
  const std::uint32_t chunk = usedChunks_.fetch_add(1, std::memory_order_relaxed);
  if (chunk >= chunkLimit_)
  {
    overflowed_.store(true, std::memory_order_relaxed);
    return 0;
  }
  if (!storage_[chunk])
  {
    storage_[chunk].reset(new (std::nothrow) Chunk);
    if (!storage_[chunk])
    {
      return 0; // memory is short: compute instead of keeping
    }
    chunks_[chunk].store(storage_[chunk].get(), std::memory_order_release);
  }
  // Slot 0 means none.
  return chunk == 0 ? 1 : chunk * chunkRecords;
}

void VertexCache::prepareMeans()
{
  // The budget's chunks pay for it.
  const std::size_t chunks = (slots_.size() * sizeof(slots_[0]) + sizeof(Chunk) - 1) / sizeof(Chunk);
  if (slots_.empty() || !meanSlots_.empty() || usedChunks_ + chunks >= chunkLimit_)
  {
    return;
  }
  chunkLimit_ -= static_cast<std::uint32_t>(chunks);
  for (std::size_t i = chunkLimit_; i < chunkLimit_ + chunks; ++i)
  {
    storage_[i].reset();
  }
  meanSlots_ = Slots(slots_.size());
}

const BlockRecord* VertexCache::Writer::keep(std::uint64_t inner, BlockCells cells, const BlockValues& block)
{
  Slots& slots = cells == BlockCells::Leaves ? cache_.slots_ : cache_.meanSlots_;
  if (slots.empty())
  {
    return nullptr;
  }
  if (next_ == end_)
  {
    next_ = cache_.addChunk();
    if (next_ == 0)
    {
      end_ = 0;
      return nullptr;
    }
    end_ = (next_ / chunkRecords + 1) * chunkRecords;
  }
  Chunk& chunk = *cache_.chunks_[next_ / chunkRecords].load(std::memory_order_relaxed);
  const BlockRecord* kept = new (&chunk.records[next_ % chunkRecords]) BlockRecord(block);
  chunk.ranges[next_ % chunkRecords] = block.range;
  slots[inner].store(next_++, std::memory_order_release);
  return kept;
}

void VertexCache::endFrame(std::uint64_t found, std::uint64_t computed)
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
    usedChunks_ = 0;
    overflowed_ = false;
  }
  full_ = overflowed_;
}

std::size_t VertexCache::byteSize() const noexcept
{
  const std::size_t chunks = std::min<std::size_t>(usedChunks_, chunkLimit_);
  return (slots_.size() + meanSlots_.size()) * sizeof(slots_[0]) +
    chunks_.size() * (sizeof(chunks_[0]) + sizeof(storage_[0])) + chunks * sizeof(Chunk);
}

} // namespace treeamr

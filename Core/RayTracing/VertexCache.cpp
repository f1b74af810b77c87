#include "RayTracing/VertexCache.h"

#include <algorithm>
#include <limits>
#include <new>

namespace treeamr
{

VertexCache::VertexCache(std::uint64_t leafCount, std::size_t budgetBytes)
{
  constexpr std::size_t chunkBytes = chunkRecords * sizeof(VertexRecord);
  const std::size_t tableBytes = leafCount * sizeof(slots_[0]);
  if (leafCount == 0 || budgetBytes < tableBytes + chunkBytes)
  {
    return;
  }
  // Threads fill chunks of their own, so some stay partly empty: twice the leaves is room enough.
  const std::size_t wanted = 2 * (leafCount / chunkRecords + 64);
  const std::size_t addressable = std::numeric_limits<std::uint32_t>::max() / chunkRecords;
  const std::size_t chunks = std::min({ (budgetBytes - tableBytes) / chunkBytes, wanted, addressable });
  slots_ = std::vector<std::atomic<std::uint32_t>>(leafCount);
  chunks_ = std::vector<std::atomic<VertexRecord*>>(chunks);
  storage_.resize(chunks);
}

std::uint32_t VertexCache::addChunk()
{
  // The load keeps a full cache from counting on for ever.
  if (usedChunks_.load(std::memory_order_relaxed) >= chunks_.size())
  {
    overflowed_.store(true, std::memory_order_relaxed);
    return 0;
  }
  const std::uint32_t chunk = usedChunks_.fetch_add(1, std::memory_order_relaxed);
  if (chunk >= chunks_.size())
  {
    overflowed_.store(true, std::memory_order_relaxed);
    return 0;
  }
  if (!storage_[chunk])
  {
    storage_[chunk].reset(new (std::nothrow) VertexRecord[chunkRecords]);
    if (!storage_[chunk])
    {
      return 0; // memory is short: compute instead of keeping
    }
    chunks_[chunk].store(storage_[chunk].get(), std::memory_order_release);
  }
  // Slot 0 means none.
  return chunk == 0 ? 1 : chunk * chunkRecords;
}

VertexRecord* VertexCache::Writer::reserve()
{
  if (next_ == end_)
  {
    next_ = cache_.slots_.empty() ? 0 : cache_.addChunk();
    if (next_ == 0)
    {
      end_ = 0;
      return nullptr;
    }
    end_ = (next_ / chunkRecords + 1) * chunkRecords;
  }
  return cache_.record(next_);
}

void VertexCache::beginFrame()
{
  if (overflowed_)
  {
    for (auto& slot : slots_)
    {
      slot.store(0, std::memory_order_relaxed);
    }
    usedChunks_ = 0;
    overflowed_ = false;
  }
}

std::size_t VertexCache::byteSize() const noexcept
{
  const std::size_t chunks = std::min<std::size_t>(usedChunks_, chunks_.size());
  return slots_.size() * sizeof(slots_[0]) + chunks_.size() * (sizeof(chunks_[0]) + sizeof(storage_[0])) +
    chunks * chunkRecords * sizeof(VertexRecord);
}

} // namespace treeamr

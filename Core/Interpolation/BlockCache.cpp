#include "Interpolation/BlockCache.h"

#include "Interpolation/BlockKernel.h"

#include <new>

namespace treeamr
{

BlockRecord::BlockRecord(const BlockValues& block) noexcept
{
  quantise(block.values, block.range, steps, values);
}

BlockCache::BlockCache(const Field& field, std::size_t budgetBytes)
  : slots_(budgetBytes < field.octree().innerCount() * sizeof(slots_[0]) + sizeof(Chunk)
        ? 0
        : field.octree().innerCount())
  , pool_(slots_.size(), budgetBytes - slots_.size() * sizeof(slots_[0]))
  , writers_([this] { return ChunkPool<Chunk>::Writer(pool_); })
{
}

void BlockCache::prepareMeans()
{
  // The budget's chunks pay for it.
  if (!slots_.empty() && meanSlots_.empty() && pool_.giveUp(slots_.size() * sizeof(slots_[0])))
  {
    meanSlots_ = Slots(slots_.size());
  }
}

const BlockRecord* BlockCache::keep(std::uint64_t inner, BlockCells cells, const BlockValues& block)
{
  Slots& slots = cells == BlockCells::Leaves ? slots_ : meanSlots_;
  if (slots.empty())
  {
    return nullptr;
  }
  ChunkPool<Chunk>::Writer& writer = writers_.local();
  Chunk* chunk = writer.room();
  if (!chunk)
  {
    return nullptr;
  }
  const std::uint32_t index = writer.index();
  const BlockRecord* kept = new (&chunk->records[index]) BlockRecord(block);
  chunk->ranges[index] = block.range;
  slots[inner].store(writer.keep(), std::memory_order_release);
  return kept;
}

void BlockCache::endFrame(std::uint64_t found, std::uint64_t computed)
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

std::size_t BlockCache::byteSize() const noexcept
{
  return (slots_.size() + meanSlots_.size()) * sizeof(slots_[0]) + pool_.byteSize();
}

} // namespace treeamr

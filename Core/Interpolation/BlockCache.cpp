#include "Interpolation/BlockCache.h"

#include "Error.h"
#include "Interpolation/BlockKernel.h"

#include <new>
#include <string>

namespace treeamr
{

BlockRecord::BlockRecord(const BlockValues& block) noexcept
{
  quantise(block.values, block.range, steps, values);
}

BlockCache::BlockCache(const Octree& octree, std::size_t budgetBytes)
  : octree_(octree.identity())
  , slots_(budgetBytes < octree.innerCount() * sizeof(slots_[0]) + sizeof(Chunk) ? 0 : octree.innerCount())
  , pool_(slots_.size(), budgetBytes - slots_.size() * sizeof(slots_[0]))
{
}

void BlockCache::startFrame(const Field& field)
{
  if (octree_ != field.octree().identity())
  {
    throw Error("vertex cache: made for another octree than that of the field, which has " +
      std::to_string(field.octree().innerCount()) + " inner nodes");
  }
  if (field_.value_or(field.identity()) != field.identity())
  {
    throw Error(
      "vertex cache: holds values of another field on the same octree, allowed is one field for each");
  }
  field_ = field.identity();
}

void BlockCache::prepareMeans()
{
  // The budget's chunks pay for it.
  if (!slots_.empty() && meanSlots_.empty() && pool_.giveUp(slots_.size() * sizeof(slots_[0])))
  {
    meanSlots_ = Slots(slots_.size());
  }
}

const BlockRecord* BlockCache::Writer::keep(std::uint64_t inner, BlockCells cells, const BlockValues& block)
{
  Slots& slots = cells == BlockCells::Leaves ? cache_.slots_ : cache_.meanSlots_;
  Chunk* chunk = slots.empty() ? nullptr : records_.room();
  if (!chunk)
  {
    return nullptr;
  }
  const std::uint32_t index = records_.index();
  const BlockRecord* kept = new (&chunk->records[index]) BlockRecord(block);
  chunk->ranges[index] = block.range;
  slots[inner].store(records_.keep(), std::memory_order_release);
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
  }
  full_ = pool_.overflowed();
}

std::size_t BlockCache::byteSize() const noexcept
{
  return (slots_.size() + meanSlots_.size()) * sizeof(slots_[0]) + pool_.byteSize();
}

} // namespace treeamr

#include "Interpolation/BlockCache.h"

#include "Interpolation/BlockKernel.h"

#include <new>

namespace treeamr
{

BlockRecord::BlockRecord(const BlockValues& block) noexcept
{
  quantise(block.values, block.range, steps, values);
}

const BlockRecord* BlockCache::keep(std::uint64_t inner, BlockCells cells, const BlockValues& block)
{
  const auto [chunk, index] = store_.keep(inner, cells, [&](Chunk& into, std::uint32_t at) {
    new (&into.records[at]) BlockRecord(block);
    into.ranges[at] = block.range;
  });
  return chunk ? &chunk->records[index] : nullptr;
}

} // namespace treeamr

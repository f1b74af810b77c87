// Vertex values of blocks of leaves kept between tiles and frames, within a budget of memory.
#pragma once

#include "Interpolation/BlockStore.h"
#include "Interpolation/BlockValues.h"
#include "Prefetch.h"

#include <cstdint>

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
  /// For one field, as BlockStore.
  BlockCache(const Field& field, std::size_t budgetBytes)
    : store_(field, budgetBytes)
    , budget_(budgetBytes)
  {
  }

  std::size_t budget() const noexcept { return budget_; }
  bool isFull() const noexcept { return store_.isFull(); }

  struct Found
  {
    const BlockRecord* record; // null when the block is not kept
    Range range;
  };
  Found find(std::uint64_t inner, BlockCells cells) const noexcept
  {
    const auto [chunk, index] = store_.find(inner, cells);
    return chunk ? Found{ &chunk->records[index], chunk->ranges[index] } : Found{ nullptr, {} };
  }

  void prefetchSlot(std::uint64_t inner, BlockCells cells) const noexcept
  {
    store_.prefetchSlot(inner, cells);
  }
  /// The same for a node whose slot is there: for what is kept of it.
  void prefetchRecord(std::uint64_t inner, BlockCells cells) const noexcept
  {
    const auto [chunk, index] = store_.find(inner, cells);
    if (chunk)
    {
      treeamr::prefetch(&chunk->ranges[index]);
      const auto* values = chunk->records[index].values.data();
      for (std::size_t i = 0; i < sizeof(BlockRecord) / sizeof(*values); i += 32)
      {
        treeamr::prefetch(values + i);
      }
    }
  }

  /// Keeps the block of an inner node; null when the budget is used up. Its hull's width must be finite.
  const BlockRecord* keep(std::uint64_t inner, BlockCells cells, const BlockValues& block);

  void prepareMeans() { store_.prepareMeans(); }
  void endFrame(std::uint64_t found, std::uint64_t computed) { store_.endFrame(found, computed); }
  /// Allocated bytes.
  std::size_t byteSize() const noexcept { return store_.byteSize(); }
  /// Bytes of one block, for budgets.
  static constexpr std::size_t blockBytes = sizeof(Chunk) / Chunk::size;

private:
  BlockStore<Chunk> store_;
  std::size_t budget_;
};

} // namespace treeamr

// Vertex gradients of blocks of leaves, to light volumes by: kept between tiles and frames, within a budget of memory.
#pragma once

#include "Interpolation/BlockGradients.h"
#include "Interpolation/BlockStore.h"

#include <array>
#include <cstdint>
#include <cstring>

namespace treeamr
{

/// A block's 125 vertex gradients in steps of their largest component: 96 bytes a leaf.
struct alignas(64) BlockGradientRecord
{
  static constexpr int most = 32767; // steps

  /// Where a leaf's gradients are never shorter than this many times `most` / leastParts steps: rounding is left room for.
  static constexpr float leastParts = 128.f;

  /// By axis, in the order of BlockValues. What the last three words of an axis hold is none of them.
  std::array<std::array<std::int16_t, 128>, 3> steps;

  /// Gradients times `scale`. Those that are not finite are none; vertices that were not asked for hold anything.
  BlockGradientRecord(const BlockGradients& gradients, const BlockVertices& vertices, double scale) noexcept;
  BlockGradientRecord() noexcept = default;

  /// Of a step, as the gradients are scaled.
  float length() const noexcept
  {
    float length;
    std::memcpy(&length, &steps[0][block::vertexCount + 1], sizeof(length));
    return length;
  }
  /// By child; of those whose vertices were asked for.
  std::array<std::uint8_t, 8> least() const noexcept
  {
    std::array<std::uint8_t, 8> least;
    std::memcpy(least.data(), &steps[1][block::vertexCount], 6);
    std::memcpy(least.data() + 6, &steps[2][block::vertexCount], 2);
    return least;
  }

private:
  void findLeast() noexcept;
};
static_assert(sizeof(BlockGradientRecord) == 768);

class GradientCache
{
  struct Chunk
  {
    static constexpr std::uint32_t size = 128;
    std::array<BlockGradientRecord, size> records;
  };

public:
  /// For one field, as BlockStore.
  GradientCache(const Field& field, std::size_t budgetBytes)
    : store_(field, budgetBytes)
    , scale_(scaleOf(field))
  {
  }

  /// That records have gradients times: of a field that changes by all of its range across the domain's diagonal they
  /// are 1 then.
  double scale() const noexcept { return scale_; }

  /// Null when the block is not kept.
  const BlockGradientRecord* find(std::uint64_t inner, BlockCells cells) const noexcept
  {
    const auto [chunk, index] = store_.find(inner, cells);
    return chunk ? &chunk->records[index] : nullptr;
  }
  void prefetchSlot(std::uint64_t inner, BlockCells cells) const noexcept
  {
    store_.prefetchSlot(inner, cells);
  }
  /// The same for a node whose slot is there: for what is kept of it.
  void prefetchRecord(std::uint64_t inner, BlockCells cells) const noexcept
  {
    if (const BlockGradientRecord* record = this->find(inner, cells))
    {
      const auto* const steps = record->steps[0].data();
      for (std::size_t i = 0; i < sizeof(*record) / sizeof(*steps); i += 32)
      {
        treeamr::prefetch(steps + i);
      }
    }
  }
  /// Keeps the block of an inner node; null when the budget is used up.
  const BlockGradientRecord* keep(std::uint64_t inner, BlockCells cells, const BlockGradientRecord& record);

  void prepareMeans() { store_.prepareMeans(); }
  void endFrame(std::uint64_t found, std::uint64_t computed) { store_.endFrame(found, computed); }
  /// Allocated bytes.
  std::size_t byteSize() const noexcept { return store_.byteSize(); }
  /// Bytes of one block, for budgets.
  static constexpr std::size_t blockBytes = sizeof(Chunk) / Chunk::size;

private:
  static double scaleOf(const Field& field) noexcept;

  BlockStore<Chunk> store_;
  double scale_;
};

} // namespace treeamr

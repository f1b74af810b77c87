// The vertex gradients of the blocks that isosurfaces are seen in: what their normals are interpolated from.
//
// Computed where hits are, and kept where memory is plenty; nothing is allocated before the first is asked for.
#pragma once

#include "Interpolation/BlockGradients.h"
#include "Surface/SurfaceBlocks.h"

#include <array>
#include <atomic>
#include <mutex>

namespace treeamr
{

/// At the vertices of some of a block's octants, in the order of BlockValues and times a power of two of the block's own:
/// single precision has their digits then, whatever the size of values and cells. Those of octants that are ready do
/// not change any more while others are added.
struct alignas(64) GradientRecord
{
  using Vertex = std::array<float, 3>; // by axis

  mutable std::array<Vertex, block::vertexCount> vertices;

  /// Announces that those of an octant's corners will be read.
  void prefetch(int octant) const noexcept
  {
    const int first = firstVertex(octant);
    for (int edge = 0; edge < 4; ++edge)
    {
      const int low = first + (edge & 1) * block::vertexStride[1] + (edge >> 1) * block::vertexStride[2];
      treeamr::prefetch(&vertices[low]);
      treeamr::prefetch(&vertices[low + 1][2]);
    }
  }
  /// Octants x + 4 y + 16 z.
  std::uint64_t ready(std::memory_order order) const noexcept { return std::atomic_ref(octants).load(order); }

private:
  friend class SurfaceGradients;

  mutable std::uint64_t octants;
  mutable int exponent; // set before other threads see the record
};

/// Safe from several threads.
class SurfaceGradients
{
public:
  SurfaceGradients(const SurfaceBlocks& blocks, std::size_t budgetBytes);

  /// With some octants, active ones. values: the block's. Valid until the thread's next call, for ever when it is kept.
  const GradientRecord& record(std::uint32_t block, const SurfaceRecord& values, std::uint64_t octants) const
  {
    const GradientRecord* kept = this->find(block);
    return kept && (octants & ~kept->ready(std::memory_order_acquire)) == 0
      ? *kept
      : this->complete(block, values, octants);
  }
  /// Announces that a block's will be asked for.
  void prefetch(std::uint32_t block) const noexcept
  {
    if (isPrepared_.load(std::memory_order_acquire))
    {
      treeamr::prefetch(&numbers_[block]);
    }
  }
  /// Announces that it will be looked at which of a block's octants are ready.
  void prefetchReady(std::uint32_t block) const noexcept
  {
    if (const GradientRecord* kept = this->find(block))
    {
      treeamr::prefetch(&kept->octants);
    }
  }
  /// Whether an octant is not there yet, and would be kept: many of a block together cost less.
  bool lacks(std::uint32_t block, int octant) const
  {
    const GradientRecord* kept = this->find(block);
    return kept ? !(kept->ready(std::memory_order_relaxed) >> octant & 1)
                : !isPrepared_.load(std::memory_order_acquire) || !pool_->overflowed();
  }

  /// Whether its record is valid for ever.
  bool isKept(std::uint32_t block) const noexcept { return this->find(block) != nullptr; }

  /// As SurfaceBlocks::startFrame().
  void startFrame() const;
  /// Allocated bytes.
  std::size_t byteSize() const noexcept;

private:
  struct Chunk
  {
    static constexpr std::uint32_t size = 128;
    std::array<GradientRecord, size> records;
  };
  /// By block the number of its record; 0: not kept.
  using Numbers = LargeVector<std::atomic<std::uint32_t>>;
  struct Worker
  {
    GradientEvaluator evaluator;
    ChunkPool<Chunk>::Writer writer;
    BlockGradients gradients;
    GradientRecord unkept;
    std::uint32_t unkeptBlock; // whose it is
  };
  static constexpr std::uint32_t noBlock = std::numeric_limits<std::uint32_t>::max();

  void prepare() const;
  /// Null: none is kept.
  const GradientRecord* find(std::uint32_t block) const noexcept
  {
    if (!isPrepared_.load(std::memory_order_acquire))
    {
      return nullptr;
    }
    const std::uint32_t number = numbers_[block].load(std::memory_order_acquire);
    return number != 0 ? &pool_->chunkOf(number).records[number % Chunk::size] : nullptr;
  }
  const GradientRecord& complete(
    std::uint32_t block, const SurfaceRecord& values, std::uint64_t octants) const;
  Worker& worker() const;
  void add(std::uint64_t octants, std::uint32_t block, const SurfaceRecord& values, Worker& worker,
    const GradientRecord& record) const noexcept;

  const SurfaceBlocks& blocks_;
  std::size_t budgetBytes_;
  /// Of the threads that add to records of blocks with one remainder.
  static constexpr std::size_t lockCount = 64;
  mutable std::array<std::mutex, lockCount> adds_;
  mutable std::once_flag prepares_;
  mutable std::atomic<bool> isPrepared_{ false };
  mutable Numbers numbers_;
  mutable std::optional<ChunkPool<Chunk>> pool_;   // once prepared
  mutable std::atomic<std::uint64_t> unkept_{ 0 }; // records begun since startFrame()
  mutable tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers_;
};

} // namespace treeamr

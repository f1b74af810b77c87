// Vertex values of leaves kept between tiles and frames, within a budget of memory.
//
// Filled by the renderer's threads without locks: a leaf's record is written first and published then. Two
// threads may compute the same leaf at once; both records are right and one is wasted. Only leaves that some
// frame has seen take memory.
#pragma once

#include "Interpolation/VertexValues.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace treeamr
{

/// A leaf's 27 vertex values and their hull, padded to whole cache lines.
struct alignas(64) VertexRecord
{
  VertexValues values;
  Range range;
  std::array<float, 3> padding;

  /// The path must end at the leaf.
  void compute(const TreePath& path, const Field& field, VertexMemo& memo) noexcept
  {
    values = vertexValues<VertexRule::GTI>(path, field, memo);
    range = hull(values);
    padding = {};
  }
};
static_assert(sizeof(VertexRecord) == 128);

class VertexCache
{
public:
  /// For the leaves of one field. A budget too small for the table of leaves keeps nothing.
  VertexCache(std::uint64_t leafCount, std::size_t budgetBytes);

  /// Null when the leaf is not kept.
  const VertexRecord* find(std::uint64_t leaf) const noexcept
  {
    if (slots_.empty())
    {
      return nullptr;
    }
    const std::uint32_t slot = slots_[leaf].load(std::memory_order_acquire);
    return slot == 0 ? nullptr : record(slot);
  }

  /// A writer's supply of records: one for each thread.
  class Writer
  {
  public:
    explicit Writer(VertexCache& cache) noexcept
      : cache_(cache)
    {
    }
    /// A record to fill and publish; null when the budget is used up.
    VertexRecord* reserve();
    /// Makes the last reserved record the leaf's.
    void publish(std::uint64_t leaf) noexcept
    {
      cache_.slots_[leaf].store(next_++, std::memory_order_release);
    }

  private:
    VertexCache& cache_;
    std::uint32_t next_ = 0;
    std::uint32_t end_ = 0;
  };

  /// Call when no thread renders. Forgets all when the last frame ran out of budget, so that a new view gets
  /// its share.
  void beginFrame();

  /// Allocated bytes.
  std::size_t byteSize() const noexcept;

private:
  static constexpr std::uint32_t chunkRecords = 1024;

  VertexRecord* record(std::uint32_t slot) const noexcept
  {
    return chunks_[slot / chunkRecords].load(std::memory_order_acquire) + slot % chunkRecords;
  }
  /// First slot of a new chunk; 0 when there is none left.
  std::uint32_t addChunk();

  std::vector<std::atomic<std::uint32_t>> slots_; // by leaf; 0: not kept
  std::vector<std::atomic<VertexRecord*>> chunks_;
  std::vector<std::unique_ptr<VertexRecord[]>> storage_; // of chunks_, for their release
  std::atomic<std::uint32_t> usedChunks_{ 0 };
  std::atomic<bool> overflowed_{ false };
};

} // namespace treeamr

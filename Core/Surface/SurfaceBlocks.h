// The inner nodes through whose leaves isosurfaces pass, and their vertex values.
//
// The paper's section 6.2 keeps octants and dual cells with eight values each. Here a primitive is an inner node
// with all its leaf children, 24 bytes for up to 64 octants, found by the ranges of the nodes alone. Its vertex values,
// which tell the octants that the surface passes through, are computed where rays come, and kept where memory is
// plenty.
#pragma once

#include "ChunkPool.h"
#include "Interpolation/BlockValues.h"
#include "Prefetch.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace treeamr
{

/// An inner node by its place: depth and index on the lattice of that depth, of 40 bits per axis. With the
/// extent of its active octants, in octants.
class SurfaceBlock
{
public:
  SurfaceBlock() noexcept = default;
  /// depth -1: the parent that the octree's root would have, for an octree of a single cell.
  SurfaceBlock(const std::array<Coord, 3>& index, int depth) noexcept
    : depth_(static_cast<std::int8_t>(depth))
  {
    for (int a = 0; a < 3; ++a)
    {
      low_[a] = static_cast<std::uint32_t>(index[a]);
      high_[a] = static_cast<std::uint8_t>(index[a] >> 32);
    }
  }
  static constexpr int maxDepth = 40;

  int depth() const noexcept { return depth_; }
  Coord index(int axis) const noexcept { return static_cast<Coord>(high_[axis]) << 32 | low_[axis]; }

  /// By axis the octants that may be active; all of them until the block's values have been computed.
  int firstActive(int axis) const noexcept { return extent(axis) & 7; }
  int endActive(int axis) const noexcept { return extent(axis) >> 3; }
  bool isEmpty() const noexcept { return endActive(0) == 0; }
  bool isNarrowed() const noexcept { return extent(0) != all || extent(1) != all || extent(2) != all; }

private:
  friend class SurfaceBlocks;

  static constexpr std::uint8_t all = 4 << 3;

  /// To octants x + 4 y + 16 z. Several threads may, to the same ones, while others look.
  void narrow(std::uint64_t octants) noexcept;
  int extent(int axis) const noexcept
  {
    return std::atomic_ref(const_cast<std::uint8_t&>(extent_[axis])).load(std::memory_order_relaxed);
  }

  std::array<std::uint32_t, 3> low_;
  std::uint32_t record_ = 0; // where the values are kept; 0: not yet
  std::array<std::uint8_t, 3> high_;
  std::int8_t depth_;
  std::array<std::uint8_t, 3> extent_{ all, all, all };
};
static_assert(sizeof(SurfaceBlock) == 24);

/// Of an octant's eight corners the first, in a block's vertex values.
constexpr int firstVertex(int octant) noexcept
{
  return (octant & 3) + 5 * (octant >> 2 & 3) + 25 * (octant >> 4);
}

/// The vertex values of a block in double precision: both sides of a level boundary agree to its rounding.
struct alignas(64) SurfaceRecord
{
  std::array<double, 125> values; // order of BlockValues
  std::uint64_t active;           // octants x + 4 y + 16 z of drawn leaves that an isovalue passes through
  double tolerance;               // bound of the rounding errors of interpolated values
  double signedWidth;             // see width() and isMixed()

  /// Largest less least value.
  double width() const noexcept { return std::abs(signedWidth); }
  /// Whether some octant's values differ so little beside the width that the tolerance is too wide for it.
  bool isMixed() const noexcept { return signedWidth < 0.; }

  /// Announces that it will be read, of the values those in some layers of octants along z.
  void prefetch(int firstLayer = 0, int endLayer = 4) const noexcept
  {
    constexpr int line = 64 / sizeof(values[0]);
    const int end = 25 * (endLayer + 1);
    for (int i = 25 * firstLayer / line * line; i < end; i += line)
    {
      treeamr::prefetch(values.data() + i);
    }
    treeamr::prefetch(&active);
  }
};

/// Safe from several threads.
class SurfaceBlocks
{
public:
  /// All blocks that may have active octants, in Morton order. isovalues: less the field's offset, ascending, at least
  /// one. mostCellDepth: as Isosurface's. Throws Error for a tree deeper than SurfaceBlock::maxDepth.
  SurfaceBlocks(std::shared_ptr<const Field> field, std::vector<double> isovalues, std::size_t budgetBytes,
    int mostCellDepth);

  const LargeVector<SurfaceBlock>& all() const noexcept { return blocks_; }
  const std::vector<double>& isovalues() const noexcept { return isovalues_; }
  /// Of the tolerance, to the largest value: of the double precision in which both sides of a face interpolate, and of what
  /// is stored of corners on one side and interpolated on the other.
  double rounding() const noexcept { return field_->corners() ? 0x1p-22 : 0x1p-49; }
  const Field& field() const noexcept { return *field_; }
  /// To the node of a block whose depth is not -1, and what its cells are: means where they are drawn together.
  BlockPath pathTo(const SurfaceBlock& block) const noexcept
  {
    return BlockPath(field_->octree(), { block.index(0), block.index(1), block.index(2) }, block.depth());
  }
  BlockCells cellsOf(const SurfaceBlock& block, std::uint64_t node) const noexcept
  {
    const Octree& octree = field_->octree();
    return block.depth() >= deepest_ && octree.children(node).inner() != 0 && !octree.hasGhostsBelow(node)
      ? BlockCells::Means
      : BlockCells::Leaves;
  }
  bool isKept(std::uint32_t block) const noexcept
  {
    return std::atomic_ref(blocks_[block].record_).load(std::memory_order_relaxed) != 0;
  }
  /// Valid until the thread's next call, for ever when it is kept.
  const SurfaceRecord& record(std::uint32_t block) const
  {
    const std::uint32_t number = std::atomic_ref(blocks_[block].record_).load(std::memory_order_acquire);
    return number != 0 ? pool_.chunkOf(number).records[number % Chunk::size] : compute(block);
  }
  /// Announces that a block will be looked at.
  void prefetchBlock(std::uint32_t block) const noexcept { treeamr::prefetch(&blocks_[block]); }
  /// Announces that the values of a block, when they are kept, will be read.
  void prefetch(std::uint32_t block) const noexcept
  {
    const SurfaceBlock& place = blocks_[block];
    const std::uint32_t number = std::atomic_ref(place.record_).load(std::memory_order_acquire);
    if (number != 0)
    {
      pool_.chunkOf(number).records[number % Chunk::size].prefetch(place.firstActive(2), place.endActive(2));
    }
  }

  /// Call when no thread asks for records, before a frame. When the budget is used up and most of the records of
  /// the last frame were not kept, forgets all, so that a new view gets its share.
  void startFrame() const;

  /// How often values were computed, and the extent of a block may have become narrower.
  std::uint64_t computedCount() const noexcept { return computed_; }
  /// Whether so many have become narrower since a count that boxes of all are worth to be drawn tighter.
  bool areMuchNarrower(std::uint64_t computedBefore) const noexcept
  {
    return computed_ > computedBefore && computed_ >= blocks_.size() / 64 + 2 * computedBefore;
  }
  /// Active octants of all blocks. The first call computes the values of all that are not kept.
  std::uint64_t octantCount() const;
  /// Allocated bytes: of the blocks, and of the records.
  std::size_t byteSize() const noexcept;
  std::size_t keptBytes() const noexcept { return pool_.byteSize(); }
  /// What the records of all blocks would take.
  std::size_t mostKeptBytes() const noexcept { return blocks_.size() * sizeof(SurfaceRecord); }

private:
  static constexpr std::size_t together = 8; // values that are computed at once

  struct Chunk
  {
    static constexpr std::uint32_t size = 256;
    std::array<SurfaceRecord, size> records;
  };
  struct Worker
  {
    BlockEvaluator evaluator;
    ChunkPool<Chunk>::Writer writer;
    SurfaceRecord unkept;
  };

  Worker& worker() const;
  void evaluate(const SurfaceBlock& block, Worker& worker, SurfaceRecord& record) const noexcept;
  /// And those of its neighbours, while there is room.
  const SurfaceRecord& compute(std::uint32_t block) const;
  /// Which octants of drawn leaves an isovalue passes through, of a record's values and tolerance; and whether it is
  /// mixed.
  void findActiveOctants(SurfaceRecord& record, unsigned drawn) const noexcept;

  std::shared_ptr<const Field> field_;
  std::vector<double> isovalues_;
  int deepest_;                              // of the blocks, in the padded octree, that have no ghosts below
  mutable LargeVector<SurfaceBlock> blocks_; // rays add their records
  mutable std::optional<std::uint64_t> octants_;
  mutable std::atomic<std::uint64_t> computed_{ 0 };
  mutable std::atomic<std::uint64_t> unkept_{ 0 }; // records computed since startFrame()
  std::size_t budgetBytes_;
  mutable ChunkPool<Chunk> pool_;
  mutable tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers_;
};

} // namespace treeamr

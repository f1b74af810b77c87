#include "Surface/SurfaceBlocks.h"

#include "Error.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

namespace treeamr
{

namespace
{

class Search
{
public:
  Search(const Field& field, const std::vector<double>& isovalues, int deepest)
    : ranges_(field.nodeRanges())
    , octree_(field.octree())
    , isovalues_(isovalues)
    , deepest_(deepest)
    , serialDepth_(octree_.grid().paddingDepth() + octree_.leafLevels() - 4)
  {
  }

  /// parent: the range of the node's parent, of the root the field's.
  void visit(std::uint64_t node, const std::array<Coord, 3>& index, int depth, Range parent,
    LargeVector<SurfaceBlock>& found) const
  {
    const Range range = ranges_.of(node, parent);
    if (!holdsIsovalue(range))
    {
      return;
    }
    const Octree::Children children = octree_.children(node);
    // A mean of ghosts and others would draw the ghosts.
    const bool isLast = depth >= deepest_ && !octree_.hasGhostsBelow(node);
    if (children.leaf != 0 || isLast)
    {
      if (depth > SurfaceBlock::maxDepth)
      {
        throw Error("isosurface: a cell at depth " + std::to_string(depth + 1) + ", allowed are up to " +
          std::to_string(SurfaceBlock::maxDepth + 1));
      }
      found.emplace_back(index, depth);
    }
    if (isLast)
    {
      return;
    }
    const auto visitChild = [&](int octant, LargeVector<SurfaceBlock>& into) {
      visit(children.innerIndex(octant), indexOfChild(index, octant), depth + 1, range, into);
    };
    if (depth >= serialDepth_)
    {
      for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
      {
        visitChild(std::countr_zero(rest), found);
      }
      return;
    }
    std::array<LargeVector<SurfaceBlock>, 8> parts;
    tbb::parallel_for(0, 8, [&](int o) {
      if (children.inner() >> o & 1)
      {
        visitChild(o, parts[o]);
      }
    });
    for (const auto& part : parts)
    {
      found.insert(found.end(), part.begin(), part.end());
    }
  }

private:
  bool holdsIsovalue(Range range) const noexcept
  {
    // The range bounds values rounded to float, the surface has those before.
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const auto first =
      std::lower_bound(isovalues_.begin(), isovalues_.end(), std::nextafter(range.min, -infinity));
    return first != isovalues_.end() && *first <= std::nextafter(range.max, infinity);
  }

  const NodeRanges& ranges_;
  const Octree& octree_;
  const std::vector<double>& isovalues_;
  int deepest_;
  int serialDepth_;
};

constexpr int childOf(int octant)
{
  return (octant >> 1 & 1) | (octant >> 3 & 1) << 1 | (octant >> 5) << 2;
}

/// Octants of a block by the child that they are part of.
constexpr std::array<std::uint64_t, 8> octantsOfChild = [] {
  std::array<std::uint64_t, 8> masks{};
  for (int octant = 0; octant < 64; ++octant)
  {
    masks[childOf(octant)] |= std::uint64_t(1) << octant;
  }
  return masks;
}();

/// By octant the least, or with std::greater the largest, of its eight vertex values.
template <class Compare>
std::array<double, 64> extremes(const std::array<double, 125>& values, Compare compare) noexcept
{
  const auto pick = [compare](double a, double b) { return compare(a, b) ? a : b; };
  std::array<double, 100> x;
  for (int row = 0; row < 25; ++row)
  {
    for (int i = 0; i < 4; ++i)
    {
      x[4 * row + i] = pick(values[5 * row + i], values[5 * row + i + 1]);
    }
  }
  std::array<double, 80> y;
  for (int z = 0; z < 5; ++z)
  {
    for (int i = 0; i < 16; ++i)
    {
      y[16 * z + i] = pick(x[20 * z + i], x[20 * z + i + 4]);
    }
  }
  std::array<double, 64> z;
  for (int i = 0; i < 64; ++i)
  {
    z[i] = pick(y[i], y[i + 16]);
  }
  return z;
}

/// All blocks whose range holds one of the isovalues, in Morton order.
LargeVector<SurfaceBlock> findCandidates(
  const Field& field, const std::vector<double>& isovalues, int deepest)
{
  LargeVector<SurfaceBlock> found;
  const NodeRef root = field.octree().root();
  if (root.isInner())
  {
    Search(field, isovalues, deepest).visit(root.index(), {}, 0, field.range(), found);
  }
  else if (root.isLeaf())
  {
    found.emplace_back(std::array<Coord, 3>{}, -1);
  }
  return found;
}

} // namespace

void SurfaceBlock::narrow(std::uint64_t octants) noexcept
{
  // By axis the octants of the layers 0, 1, 2 and 3.
  constexpr std::array<std::uint64_t, 3> layer{ 0x1111111111111111u, 0x000f000f000f000fu, 0xffffu };
  for (int a = 0; a < 3; ++a)
  {
    int first = 0;
    int end = octants != 0 ? 4 : 0;
    while (first < end && (octants & layer[a] << (first << 2 * a)) == 0)
    {
      ++first;
    }
    while (first < end && (octants & layer[a] << ((end - 1) << 2 * a)) == 0)
    {
      --end;
    }
    std::atomic_ref(extent_[a]).store(static_cast<std::uint8_t>(first | end << 3), std::memory_order_relaxed);
  }
}

SurfaceBlocks::SurfaceBlocks(std::shared_ptr<const Field> field, std::vector<double> isovalues,
  std::size_t budgetBytes, int mostCellDepth)
  : field_(std::move(field))
  , isovalues_(std::move(isovalues))
  , deepest_(field_->octree().grid().paddingDepth() + std::clamp(mostCellDepth, 1, Octree::maxDepth) - 1)
  , blocks_(findCandidates(*field_, isovalues_, deepest_))
  , budgetBytes_(budgetBytes)
  , pool_(blocks_.size(), budgetBytes)
{
  blocks_.shrink_to_fit();
}

SurfaceBlocks::Worker& SurfaceBlocks::worker() const
{
  std::unique_ptr<Worker>& worker = workers_.local();
  if (!worker)
  {
    worker.reset(new Worker{ BlockEvaluator(*field_), ChunkPool<Chunk>::Writer(pool_), {} });
  }
  return *worker;
}

std::uint64_t SurfaceBlocks::octantCount() const
{
  if (!octants_)
  {
    std::atomic<std::uint64_t> octants{ 0 };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks_.size(), 256),
      [&](const tbb::blocked_range<std::size_t>& range) {
        Worker& own = worker();
        std::uint64_t active = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i)
        {
          const bool isKept = blocks_[i].record_ != 0;
          if (!isKept)
          {
            evaluate(blocks_[i], own, own.unkept);
          }
          active += std::popcount(isKept ? record(static_cast<std::uint32_t>(i)).active : own.unkept.active);
        }
        octants += active;
      });
    octants_ = octants;
  }
  return *octants_;
}

std::size_t SurfaceBlocks::byteSize() const noexcept
{
  return blocks_.capacity() * sizeof(blocks_[0]);
}

void SurfaceBlocks::findActiveOctants(SurfaceRecord& record, unsigned drawn) const noexcept
{
  std::uint64_t octants = 0;
  for (; drawn != 0; drawn &= drawn - 1)
  {
    octants |= octantsOfChild[std::countr_zero(drawn)];
  }
  const std::array<double, 64> low = extremes(record.values, std::less<>{});
  const std::array<double, 64> high = extremes(record.values, std::greater<>{});
  std::uint64_t active = 0;
  for (const double isovalue : isovalues_)
  {
    const double above = isovalue + record.tolerance;
    const double below = isovalue - record.tolerance;
    for (int o = 0; o < 64; ++o)
    {
      active |= static_cast<std::uint64_t>(low[o] <= above && high[o] >= below) << o;
    }
  }
  // Where all is at one isovalue no surface passes: a plateau ends where other octants begin.
  for (std::uint64_t rest = active; rest != 0; rest &= rest - 1)
  {
    const int o = std::countr_zero(rest);
    const double rounding = 0x1p-49 * std::max(std::abs(low[o]), std::abs(high[o]));
    active &= ~(static_cast<std::uint64_t>(high[o] - low[o] <= rounding) << o);
  }
  record.active = active & octants;
  // An octant that is narrower by far has its digits in the double precision of the block, but not in its tolerance.
  constexpr double mixed = 0x1p-20;
  double narrowest = record.width();
  for (std::uint64_t rest = record.active; rest != 0; rest &= rest - 1)
  {
    const int o = std::countr_zero(rest);
    narrowest = std::min(narrowest, high[o] - low[o]);
  }
  record.signedWidth = std::copysign(record.signedWidth, narrowest < mixed * record.width() ? -1. : 1.);
}

void SurfaceBlocks::evaluate(const SurfaceBlock& block, Worker& worker, SurfaceRecord& record) const noexcept
{
  const Octree& octree = field_->octree();
  unsigned drawn = 1;
  if (block.depth() < 0)
  {
    if (field_->corners())
    {
      worker.evaluator.computeUnrounded(BlockPath(), BlockCells::Leaves, record.values);
    }
    else
    {
      record.values.fill(field_->relative(octree.root()));
    }
    drawn = octree.isGhost(octree.root().index()) ? 0 : 1;
  }
  else
  {
    const BlockPath path = this->pathTo(block);
    const std::uint64_t node = path.node[path.depth];
    const Octree::Children children = octree.children(node);
    const BlockCells cells = this->cellsOf(block, node);
    const bool byMeans = cells == BlockCells::Means;
    worker.evaluator.computeUnrounded(path, cells, record.values);
    drawn = byMeans ? children.exists : children.leaf;
    for (unsigned rest = octree.hasGhosts() && !byMeans ? drawn : 0; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      drawn &= ~(static_cast<unsigned>(octree.isGhost(children.leafIndex(octant))) << octant);
    }
  }
  const auto [low, high] = std::minmax_element(record.values.begin(), record.values.end());
  record.signedWidth = *high - *low;
  // Isovalues that pass through are no larger.
  record.tolerance = this->rounding() * std::max(std::abs(*low), std::abs(*high));
  findActiveOctants(record, drawn);
}

const SurfaceRecord& SurfaceBlocks::compute(std::uint32_t block) const
{
  Worker& own = worker();
  // Neighbours in Morton order cost a fraction each, and rays are about to come to most of them. They must not take the
  // room of what rays do come to.
  const bool isRoomy = pool_.byteSize() < budgetBytes_ / 4;
  const std::size_t first = isRoomy ? block / together * together : block;
  const std::size_t end = isRoomy ? std::min(first + together, blocks_.size()) : first + 1;
  const SurfaceRecord* asked = nullptr;
  for (std::size_t i = first; i < end; ++i)
  {
    SurfaceBlock& neighbour = blocks_[i];
    Chunk* kept = i == block || !(neighbour.isNarrowed() || isKept(static_cast<std::uint32_t>(i)))
      ? own.writer.room()
      : nullptr;
    if (!kept)
    {
      continue;
    }
    SurfaceRecord& record = kept->records[own.writer.index()];
    evaluate(neighbour, own, record);
    neighbour.narrow(record.active);
    computed_.fetch_add(1, std::memory_order_relaxed);
    if (record.active != 0)
    {
      asked = i == block ? &record : asked;
      std::atomic_ref(neighbour.record_).store(own.writer.keep(), std::memory_order_release);
    }
    else if (i == block)
    {
      own.unkept.active = 0; // all that matters of it
      asked = &own.unkept;
    }
  }
  if (!asked)
  {
    evaluate(blocks_[block], own, own.unkept);
    blocks_[block].narrow(own.unkept.active);
    computed_.fetch_add(1, std::memory_order_relaxed);
    unkept_.fetch_add(1, std::memory_order_relaxed);
    asked = &own.unkept;
  }
  return *asked;
}

void SurfaceBlocks::startFrame() const
{
  if (unkept_ > pool_.byteSize() / sizeof(SurfaceRecord))
  {
    for (SurfaceBlock& block : blocks_)
    {
      block.record_ = 0;
    }
    workers_.clear();
    pool_.forget();
  }
  unkept_ = 0;
}

} // namespace treeamr

// Index boxes on the lattice that the coarsest cells are the roots of say what cells of a block finer ones cover: all of
// it, none, or, where blocks are not aligned, a part. What is left of these is divided until it is cells.
#include "AMRGrid.h"

#include "Error.h"
#include "GridOfCells.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <map>

namespace treeamr
{

namespace
{

using Index = std::array<Coord, 3>;

/// Cells of a level of the lattice from `low` on, below `high`.
struct IndexBox
{
  Index low;
  Index high;
  int level;

  bool isEmpty() const noexcept { return low[0] >= high[0] || low[1] >= high[1] || low[2] >= high[2]; }
  bool intersects(const IndexBox& other) const noexcept
  {
    bool meets = true;
    for (int a = 0; a < 3; ++a)
    {
      meets = meets && low[a] < other.high[a] && other.low[a] < high[a];
    }
    return meets;
  }
  bool contains(const IndexBox& other) const noexcept
  {
    bool has = true;
    for (int a = 0; a < 3; ++a)
    {
      has = has && low[a] <= other.low[a] && other.high[a] <= high[a];
    }
    return has;
  }
  /// On a finer level.
  IndexBox refined(int to) const noexcept
  {
    IndexBox box{ low, high, to };
    for (int a = 0; a < 3; ++a)
    {
      box.low[a] <<= to - level;
      box.high[a] <<= to - level;
    }
    return box;
  }
  /// The cells of a coarser level that have any part in it.
  IndexBox around(int to) const noexcept
  {
    const int up = level - to;
    IndexBox box{ low, high, to };
    for (int a = 0; a < 3; ++a)
    {
      box.low[a] = low[a] >> up;
      box.high[a] = -(-high[a] >> up); // rounded up
    }
    return box;
  }
  /// Those that lie in it.
  IndexBox inside(int to) const noexcept
  {
    const int up = level - to;
    IndexBox box{ low, high, to };
    for (int a = 0; a < 3; ++a)
    {
      box.low[a] = -(-low[a] >> up);
      box.high[a] = high[a] >> up;
    }
    return box;
  }
};

IndexBox cellAt(const Index& index, int level) noexcept
{
  return { index, { index[0] + 1, index[1] + 1, index[2] + 1 }, level };
}

/// The boxes of one level, to be searched.
class LevelBoxes
{
public:
  /// boxes: one or more, not empty, of one level.
  explicit LevelBoxes(std::vector<IndexBox> boxes)
    : boxes_(std::move(boxes))
  {
    std::ranges::sort(boxes_, {}, [](const IndexBox& box) { return box.low[0]; });
    for (const IndexBox& box : boxes_)
    {
      widest_ = std::max(widest_, box.high[0] - box.low[0]);
    }
  }
  int level() const noexcept { return boxes_.front().level; }
  /// Appends those that have a part of a box of a coarser level in common.
  void find(const IndexBox& coarse, std::vector<IndexBox>& found) const
  {
    const IndexBox region = coarse.refined(level());
    const auto low = [](const IndexBox& box) { return box.low[0]; };
    for (auto box = std::ranges::upper_bound(boxes_, region.low[0] - widest_, {}, low);
         box != boxes_.end() && box->low[0] < region.high[0]; ++box)
    {
      if (box->intersects(region))
      {
        found.push_back(*box);
      }
    }
  }

private:
  std::vector<IndexBox> boxes_; // sorted by the lower ends along x
  Coord widest_ = 0;            // along x
};

enum class Coverage : std::uint8_t
{
  None,
  Part,
  Whole
};

/// By cells of a box, x fastest.
std::vector<Coverage> coverageOf(const IndexBox& region, const std::vector<IndexBox>& finer)
{
  const Index size{ region.high[0] - region.low[0], region.high[1] - region.low[1],
    region.high[2] - region.low[2] };
  std::vector<Coverage> cells(static_cast<std::size_t>(size[0] * size[1] * size[2]), Coverage::None);
  const auto raise = [&](const IndexBox& to, Coverage coverage) {
    Index low;
    Index high;
    for (int a = 0; a < 3; ++a)
    {
      low[a] = std::max(to.low[a] - region.low[a], Coord(0));
      high[a] = std::min(to.high[a] - region.low[a], size[a]);
    }
    for (Coord z = low[2]; z < high[2]; ++z)
    {
      for (Coord y = low[1]; y < high[1]; ++y)
      {
        Coverage* const row = cells.data() + size[0] * (y + size[1] * z);
        std::for_each(row + low[0], row + std::max(low[0], high[0]),
          [&](Coverage& cell) { cell = std::max(cell, coverage); });
      }
    }
  };
  for (const IndexBox& box : finer)
  {
    raise(box.around(region.level), Coverage::Part);
    raise(box.inside(region.level), Coverage::Whole);
  }
  return cells;
}

/// Calls leaf(cell) for the largest cells within one, of any level below it, that have no part in any box.
template <class Leaf>
void divide(const CellId& cell, const std::vector<IndexBox>& finer, const Leaf& leaf)
{
  for (int octant = 0; octant < 8; ++octant)
  {
    const CellId child{ indexOfChild(cell.index, octant), cell.level + 1 };
    const IndexBox box = cellAt(child.index, child.level);
    bool isPartOf = false;
    bool isCovered = false;
    for (const IndexBox& other : finer)
    {
      const int level = std::max(other.level, child.level); // boxes are of several
      const IndexBox otherThere = other.refined(level);
      const IndexBox boxThere = box.refined(level);
      isPartOf = isPartOf || otherThere.intersects(boxThere);
      isCovered = isCovered || otherThere.contains(boxThere);
    }
    if (!isPartOf)
    {
      leaf(child);
    }
    else if (!isCovered)
    {
      divide(child, finer, leaf);
    }
  }
}

/// Layers of a block, for a thread, and how many leaves are made of chunks before.
struct Chunk
{
  std::size_t block;
  vtkIdType begin;
  vtkIdType end;
  std::size_t before = 0;
};

class AMRConverter
{
public:
  explicit AMRConverter(const std::vector<AMRBlock>& blocks)
    : blocks_(blocks)
    , lattice_(sizesOf(blocks), 0x1p-53)
  {
    std::map<int, std::vector<IndexBox>> boxes; // by level
    for (std::size_t b = 0; b < blocks.size(); ++b)
    {
      const AMRBlock& block = blocks[b];
      const auto [x, y, z] = block.size();
      places_.push_back(placeOf(block, { {}, block.size() }));
      const AMRBlock::Range own = block.ownCells();
      const bool hasOwn = own.low[0] < own.high[0];
      if (hasOwn)
      {
        const IndexBox box = placeOf(block, own);
        boxes[box.level].push_back(box);
      }
      const vtkIdType length = std::max<vtkIdType>((1 << 14) / (x * y), 1);
      for (vtkIdType begin = 0; begin < z; begin += length)
      {
        chunks_.push_back({ b, begin, std::min(begin + length, z) });
      }
    }
    for (auto& [level, ofLevel] : boxes)
    {
      levels_.emplace_back(std::move(ofLevel));
    }
  }

  const BoxLattice& lattice() const noexcept { return lattice_; }

  template <class Keys>
  SortedCells<Keys, std::uint64_t> sortCells()
  {
    forEachChunk(
      [&](Chunk& chunk) { forEachLeaf(chunk, [&](const CellId&, const CellNumber&) { ++chunk.before; }); });
    std::size_t count = 0;
    for (Chunk& chunk : chunks_)
    {
      count += std::exchange(chunk.before, count);
    }
    SortedCells<Keys, std::uint64_t> cells(paddingOf(lattice_), lattice_.deepest(), count);
    forEachChunk([&](const Chunk& chunk) {
      std::size_t at = chunk.before;
      forEachLeaf(
        chunk, [&](const CellId& cell, const CellNumber& number) { cells.set(at++, cell, number.number()); });
    });
    cells.sort();
    cells.removeDuplicates(); // where blocks of a level overlap
    return cells;
  }

  /// Of the first block with a cell that was divided, or null.
  const AMRBlock* divided() const noexcept
  {
    return firstDivided_ < blocks_.size() ? &blocks_[firstDivided_] : nullptr;
  }

private:
  /// Of the cells at two opposite corners of each block, which tell as well as all.
  static BoxSizes sizesOf(const std::vector<AMRBlock>& blocks)
  {
    BoxSizes sizes;
    for (const AMRBlock& block : blocks)
    {
      const auto [x, y, z] = block.size();
      sizes.add(block.boxOf({ 0, 0, 0 }), static_cast<std::uint64_t>(block.cellCount()));
      sizes.add(block.boxOf({ x - 1, y - 1, z - 1 }), 0);
    }
    return sizes;
  }

  IndexBox placeOf(const AMRBlock& block, const AMRBlock::Range& range) const
  {
    const std::optional<CellId> first = lattice_.place(cornersOf(block.boxOf(range.low)));
    const auto [x, y, z] = range.high;
    const std::optional<CellId> last = lattice_.place(cornersOf(block.boxOf({ x - 1, y - 1, z - 1 })));
    bool fits = first && last && first->level == last->level;
    for (int a = 0; fits && a < 3; ++a)
    {
      fits = last->index[a] - first->index[a] == range.high[a] - range.low[a] - 1;
    }
    if (!fits)
    {
      throw Error(block.name() + ", whose cells of " + textOf(block.width()) + " begin at " +
        textOf(block.boxOf({ 0, 0, 0 }).low) + ", fits not the lattice of the coarsest ones, which are " +
        textOf(lattice_.largestWidths()) + " wide like that from " + textOf(lattice_.widest().low) + " to " +
        textOf(lattice_.widest().high) +
        "; allowed are blocks that begin at multiples of their own cells' widths from such a cell, and " +
        std::to_string(BoxLattice::deepestLevel) + " levels of halves at most");
    }
    return { first->index, { last->index[0] + 1, last->index[1] + 1, last->index[2] + 1 }, first->level };
  }

  template <class Body>
  void forEachChunk(const Body& body)
  {
    tbb::parallel_for(std::size_t(0), chunks_.size(), [&](std::size_t c) { body(chunks_[c]); });
  }

  /// Calls leaf(cell, number) for all that a chunk has.
  template <class Leaf>
  void forEachLeaf(const Chunk& chunk, const Leaf& leaf)
  {
    const AMRBlock& block = blocks_[chunk.block];
    IndexBox region = places_[chunk.block];
    const Index first = region.low;
    region.high[2] = first[2] + chunk.end;
    region.low[2] = first[2] + chunk.begin;
    std::vector<IndexBox> finer;
    for (const LevelBoxes& level : levels_)
    {
      if (level.level() > region.level)
      {
        level.find(region, finer);
      }
    }
    const std::vector<Coverage> coverage =
      finer.empty() ? std::vector<Coverage>() : coverageOf(region, finer);

    std::size_t i = 0;
    CellId cell{ {}, region.level };
    for (cell.index[2] = region.low[2]; cell.index[2] < region.high[2]; ++cell.index[2])
    {
      for (cell.index[1] = region.low[1]; cell.index[1] < region.high[1]; ++cell.index[1])
      {
        for (cell.index[0] = region.low[0]; cell.index[0] < region.high[0]; ++cell.index[0], ++i)
        {
          const vtkIdType in =
            block.cell({ cell.index[0] - first[0], cell.index[1] - first[1], cell.index[2] - first[2] });
          const Coverage covered = coverage.empty() ? Coverage::None : coverage[i];
          if (covered == Coverage::Whole || block.isLeftOut(in))
          {
            continue;
          }
          const CellNumber number(chunk.block, in);
          if (covered == Coverage::Part)
          {
            divide(cell, finer, [&](const CellId& part) {
              noteDivided(chunk.block);
              leaf(part, number);
            });
          }
          else if (!block.isRefined(in))
          {
            leaf(cell, number);
          }
        }
      }
    }
  }

  void noteDivided(std::size_t block) noexcept
  {
    std::size_t now = firstDivided_.load(std::memory_order_relaxed);
    while (block < now && !firstDivided_.compare_exchange_weak(now, block))
    {
    }
  }

  const std::vector<AMRBlock>& blocks_;
  BoxLattice lattice_;
  std::vector<IndexBox> places_;   // by block
  std::vector<LevelBoxes> levels_; // of what blocks cover, from the coarsest on
  std::vector<Chunk> chunks_;
  std::atomic<std::size_t> firstDivided_{ std::numeric_limits<std::size_t>::max() };
};

} // namespace

const AMRBlock* makeGrid(
  const std::vector<AMRBlock>& blocks, const BlockArrays& arrays, vtkHyperTreeGrid* grid)
{
  AMRConverter converter(blocks);
  withKeys(paddingOf(converter.lattice()) + converter.lattice().deepest(), [&]<class Keys>() {
    const SortedCells<Keys, std::uint64_t> cells = converter.sortCells<Keys>();
    if (cells.size() > 0)
    {
      buildGrid(cells, converter.lattice().planes(), arrays, grid);
    }
  });
  return converter.divided();
}

} // namespace treeamr

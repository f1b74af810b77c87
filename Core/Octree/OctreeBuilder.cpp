// From a list of cells: keys, a sort, and the nodes between each cell's key and the one before.
#include "Octree/OctreeBuilder.h"

#include "Error.h"
#include "Octree/MortonKey.h"
#include "Octree/OctreeAssembler.h"
#include "Octree/RadixSort.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <concepts>
#include <memory>
#include <optional>
#include <string>

namespace treeamr
{

namespace
{

std::string name(const CellId& c)
{
  return "cell (" + std::to_string(c.index[0]) + ", " + std::to_string(c.index[1]) + ", " +
    std::to_string(c.index[2]) + ") of level " + std::to_string(c.level);
}

void checkCell(const RootGrid& grid, const CellId& cell)
{
  if (cell.level < 0 || cell.level > grid.maxLevel())
  {
    throw Error("octree: " + name(cell) + ", allowed are levels 0 to " + std::to_string(grid.maxLevel()));
  }
  for (int a = 0; a < 3; ++a)
  {
    const Coord end = Coord(grid.roots()[a]) << cell.level;
    if (cell.index[a] < 0 || cell.index[a] >= end)
    {
      throw Error("octree: " + name(cell) + " lies outside the root grid, which ends at " +
        std::to_string(end) + " along " + "xyz"[a]);
    }
  }
}

/// [0, count) in equal parts, short enough for many threads, long enough for what is kept per part.
class Parts
{
public:
  explicit Parts(std::size_t count)
    : count_(count)
    , length_(std::max(std::size_t(1) << 14, count / 1024 + 1))
  {
  }
  std::size_t size() const { return (count_ + length_ - 1) / length_; }
  std::size_t begin(std::size_t part) const { return part * length_; }
  std::size_t end(std::size_t part) const { return std::min(count_, begin(part) + length_); }

  /// body(part) for each, in parallel.
  template <class Body>
  void forEach(const Body& body) const
  {
    tbb::parallel_for(std::size_t(0), size(), body);
  }

private:
  std::size_t count_;
  std::size_t length_;
};

/// Throws for the first cell that is not allowed; returns the deepest level.
template <class Cells>
int checkCells(const RootGrid& grid, const Cells& cells)
{
  const Parts parts(cells.size());
  std::vector<int> deepest(parts.size(), 0);
  parts.forEach([&](std::size_t p) {
    for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
    {
      checkCell(grid, cells[i].cell);
      deepest[p] = std::max(deepest[p], cells[i].cell.level);
    }
  });
  return cells.empty() ? 0 : *std::max_element(deepest.begin(), deepest.end());
}

template <class Key>
struct KeyedValue
{
  Key key;
  float value;
};

template <class Record>
void sortByKey(LargeArray<Record>& records, std::size_t count)
{
  if constexpr (std::unsigned_integral<decltype(Record::key)>)
  {
    const auto scratch = makeLargeArray<Record>(count);
    RadixSort<Record>::sort(records.get(), scratch.get(), count);
  }
  else
  {
    tbb::parallel_sort(
      records.get(), records.get() + count, [](const Record& a, const Record& b) { return a.key < b.key; });
  }
}

/// Cells sorted by key as a sequence of nodes: what starts with cell i are the nodes below the deepest one
/// around it and cell i - 1.
template <class Keys>
class SortedCells
{
public:
  using Record = KeyedValue<typename Keys::Key>;

  template <class Cells>
  SortedCells(const RootGrid& grid, Cells cells, int deepestLevel)
    : padding_(grid.paddingDepth())
    , keys_(padding_ + deepestLevel)
    , count_(cells.size())
    , records_(makeLargeArray<Record>(cells.size()))
  {
    const Parts parts(count_);
    std::vector<std::uint8_t> sorted(parts.size());
    parts.forEach([&](std::size_t p) {
      const auto keyOf = [&](const LeafCell& c) { return keys_.key(c.cell.index, padding_ + c.cell.level); };
      auto before = keyOf(cells[parts.begin(p) > 0 ? parts.begin(p) - 1 : 0]);
      bool ascending = true;
      for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
      {
        records_[i] = { keyOf(cells[i]), cells[i].value };
        ascending = ascending && before <= records_[i].key;
        before = records_[i].key;
      }
      sorted[p] = ascending;
    });
    Cells().swap(cells);
    if (std::find(sorted.begin(), sorted.end(), 0) != sorted.end())
    {
      sortByKey(records_, count_);
    }
  }

  OctreeAndValues build(RootGrid grid) const
  {
    const Parts parts(count_);
    std::vector<NodeCounts> counts(parts.size());
    std::vector<std::size_t> overlap(parts.size(), none);
    parts.forEach([&](std::size_t p) {
      for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
      {
        const int depth = keys_.depth(records_[i].key);
        const int first = firstDepth(i);
        // Inner nodes from `first` on and then the leaf.
        for (int d = first; d < depth; ++d)
        {
          counts[p].startInner(d, 0);
        }
        counts[p].startLeaf(depth, 0);
        if (i > 0 && overlap[p] == none && first > std::min(depth, keys_.depth(records_[i - 1].key)))
        {
          overlap[p] = i;
        }
      }
    });
    for (const std::size_t i : overlap)
    {
      if (i != none)
      {
        throw Error("octree: " + name(cellOf(i)) + " overlaps " + name(cellOf(i - 1)));
      }
    }

    OctreeAssembler assembler(std::move(grid), std::move(counts), false);
    OctreeAndValues result;
    result.values.resize(count_);
    parts.forEach([&](std::size_t p) {
      OctreeAssembler::Writer writer(assembler, p);
      for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
      {
        const auto key = records_[i].key;
        const int depth = keys_.depth(key);
        for (int d = firstDepth(i); d < depth; ++d)
        {
          writer.startInner(d, octant(key, d));
        }
        result.values[writer.startLeaf(depth, octant(key, depth))] = records_[i].value;
      }
    });
    result.octree = assembler.finish();
    return result;
  }

private:
  static constexpr std::size_t none = ~std::size_t(0);

  /// Depth of the first node that starts with cell i.
  int firstDepth(std::size_t i) const
  {
    return i == 0 ? 0 : keys_.commonDepth(records_[i - 1].key, records_[i].key) + 1;
  }
  int octant(const typename Keys::Key& key, int depth) const
  {
    return depth == 0 ? 0 : keys_.octant(key, depth);
  }
  CellId cellOf(std::size_t i) const
  {
    const int depth = keys_.depth(records_[i].key);
    CellId cell{ {}, depth - padding_ };
    for (int d = 1; d <= depth; ++d)
    {
      cell.index = indexOfChild(cell.index, octant(records_[i].key, d));
    }
    return cell;
  }

  int padding_;
  Keys keys_;
  std::size_t count_;
  LargeArray<Record> records_;
};

template <class Keys, class Cells>
std::optional<OctreeAndValues> buildWith(RootGrid& grid, Cells& cells, int deepestLevel)
{
  if (grid.paddingDepth() + deepestLevel > Keys::maxDepth)
  {
    return {};
  }
  const SortedCells<Keys> sorted(grid, std::move(cells), deepestLevel);
  return sorted.build(std::move(grid));
}

} // namespace

template <class Allocator>
OctreeAndValues buildOctree(RootGrid grid, std::vector<LeafCell, Allocator> cells)
{
  const int deepestLevel = checkCells(grid, cells);
  auto built = buildWith<MortonKeys<std::uint32_t>>(grid, cells, deepestLevel);
  if (!built)
  {
    built = buildWith<MortonKeys<std::uint64_t>>(grid, cells, deepestLevel);
  }
  if (!built)
  {
    built = buildWith<MortonKeys<WideKey>>(grid, cells, deepestLevel);
  }
  return std::move(*built);
}
template OctreeAndValues buildOctree(RootGrid grid, LargeVector<LeafCell> cells);

OctreeAndValues buildOctree(RootGrid grid, std::vector<LeafCell> cells)
{
  return buildOctree<std::allocator<LeafCell>>(std::move(grid), std::move(cells));
}

} // namespace treeamr

// Cells with a value each, sorted by their Morton keys: a sequence of nodes, for what starts with cell i are the nodes
// below the deepest one around it and cell i - 1.
#pragma once

#include "LargeArray.h"
#include "Octree/MortonKey.h"
#include "Octree/Parts.h"
#include "Octree/RadixSort.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Keys: one of MortonKey.h's. Value: trivially copyable.
template <class Keys, class Value>
class SortedCells
{
public:
  using Key = typename Keys::Key;

  /// Depths count from the padded root, whose roots lie at `padding`; padding + deepestLevel <= Keys::maxDepth.
  SortedCells(int padding, int deepestLevel, std::size_t count)
    : padding_(padding)
    , keys_(padding + deepestLevel)
    , count_(count)
    , records_(makeLargeArray<Record>(count))
  {
  }

  /// Before sort(), of each cell, from several threads.
  void set(std::size_t i, const CellId& cell, const Value& value) noexcept
  {
    records_[i] = { keys_.key(cell.index, padding_ + cell.level), value };
  }
  /// What is in order already is left as it is. Else takes as much memory again meanwhile.
  void sort()
  {
    if (isSorted())
    {
      return;
    }
    if constexpr (std::unsigned_integral<Key>)
    {
      const auto scratch = makeLargeArray<Record>(count_);
      RadixSort<Record>::sort(records_.get(), scratch.get(), count_);
    }
    else
    {
      tbb::parallel_sort(records_.get(), records_.get() + count_,
        [](const Record& a, const Record& b) { return a.key < b.key; });
    }
  }
  /// Of cells at one place the one with the least value is kept.
  void removeDuplicates()
  {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i)
    {
      if (kept > 0 && records_[kept - 1].key == records_[i].key)
      {
        records_[kept - 1].value = std::min(records_[kept - 1].value, records_[i].value);
      }
      else
      {
        records_[kept++] = records_[i];
      }
    }
    count_ = kept;
  }

  std::size_t size() const noexcept { return count_; }
  int padding() const noexcept { return padding_; }
  const Value& value(std::size_t i) const noexcept { return records_[i].value; }
  const Key& key(std::size_t i) const noexcept { return records_[i].key; }
  int depth(std::size_t i) const noexcept { return keys_.depth(records_[i].key); }
  /// That leads to depth `depth` on the way to the cell.
  int octant(std::size_t i, int depth) const noexcept
  {
    return depth == 0 ? 0 : keys_.octant(records_[i].key, depth);
  }
  /// Depth of the first node that starts with cell i.
  int firstDepth(std::size_t i) const noexcept
  {
    return i == 0 ? 0 : keys_.commonDepth(records_[i - 1].key, records_[i].key) + 1;
  }
  /// Whether cell i > 0 and the one before have a place in common.
  bool overlapsBefore(std::size_t i) const noexcept
  {
    return firstDepth(i) > std::min(depth(i), depth(i - 1));
  }
  bool isSameAsBefore(std::size_t i) const noexcept { return records_[i].key == records_[i - 1].key; }
  /// Index on the lattice of the cell's level, or, of one around it, on that of depth `depth`.
  std::array<Coord, 3> index(std::size_t i, int depth) const noexcept
  {
    return keys_.index(records_[i].key, depth);
  }
  CellId cell(std::size_t i) const noexcept { return { index(i, depth(i)), depth(i) - padding_ }; }

private:
  struct Record
  {
    Key key;
    Value value;
  };

  bool isSorted() const
  {
    const Parts parts(count_);
    std::vector<std::uint8_t> sorted(parts.size());
    parts.forEach([&](std::size_t p) {
      const std::size_t first = parts.begin(p) > 0 ? parts.begin(p) - 1 : 0;
      sorted[p] = std::is_sorted(records_.get() + first, records_.get() + parts.end(p),
        [](const Record& a, const Record& b) { return a.key < b.key; });
    });
    return std::find(sorted.begin(), sorted.end(), 0) == sorted.end();
  }

  int padding_;
  Keys keys_;
  std::size_t count_;
  LargeArray<Record> records_;
};

} // namespace treeamr

// Sorts items along the Morton curve: what belongs to one place ends up together, neighbours nearly so.
#pragma once

#include "Octree/MortonKey.h"
#include "Octree/RadixSort.h"

#include <memory>

namespace treeamr
{

/// place(item): on a lattice of 2^bits per axis; where it has more than 2^21, nearby places may come in any
/// order. Items that are equal in that order are sorted by <, which must tell places apart.
template <class Item, class Place>
void sortByPlace(std::vector<Item>& items, int bits, const Place& place)
{
  struct Record
  {
    std::uint64_t key;
    std::uint64_t item;
  };
  const std::size_t count = items.size();
  const int drop = std::max(0, bits - 21);
  const auto records = std::make_unique_for_overwrite<Record[]>(count);
  const auto forRanges = [&](const auto& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096),
      [&](const auto& range) { body(range.begin(), range.end()); });
  };
  forRanges([&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i)
    {
      const std::array<Coord, 3> at = place(items[i]);
      records[i] = { interleave(at[0] >> drop, at[1] >> drop, at[2] >> drop), i };
    }
  });
  {
    const auto scratch = std::make_unique_for_overwrite<Record[]>(count);
    RadixSort<Record>::sort(records.get(), scratch.get(), count);
  }
  std::vector<Item> sorted(count);
  forRanges([&](std::size_t first, std::size_t end) {
    const auto beginsRun = [&](std::size_t i) { return i == 0 || records[i].key != records[i - 1].key; };
    while (first < end && !beginsRun(first))
    {
      ++first;
    }
    while (first < end)
    {
      std::size_t runEnd = first;
      do
      {
        sorted[runEnd] = items[records[runEnd].item];
        ++runEnd;
      }
      while (runEnd < count && !beginsRun(runEnd));
      std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first),
        sorted.begin() + static_cast<std::ptrdiff_t>(runEnd));
      first = runEnd;
    }
  });
  items.swap(sorted);
}

} // namespace treeamr

// Places in an octree, cells of any levels: sorted, none inside another.
#pragma once

#include "Octree/MortonKey.h"

#include <algorithm>
#include <vector>

namespace treeamr
{

class CellSet
{
public:
  /// None. padding: of the root grid.
  explicit CellSet(int padding)
    : padding_(padding)
  {
  }
  /// In any order; what is inside another, or is it, is left out. Levels 0 and up.
  CellSet(int padding, const std::vector<CellId>& cells)
    : padding_(padding)
  {
    add(cells);
  }

  void add(const std::vector<CellId>& cells)
  {
    std::vector<Key> keys = std::move(keys_);
    keys.reserve(keys.size() + cells.size());
    for (const CellId& cell : cells)
    {
      keys.push_back(keyOf(cell));
    }
    std::ranges::sort(keys);
    keys_.clear();
    for (const Key& key : keys) // what is inside comes right before or after
    {
      while (!keys_.empty() && isInside(keys_.back(), key))
      {
        keys_.pop_back();
      }
      if (keys_.empty() || !isInside(key, keys_.back()))
      {
        keys_.push_back(key);
      }
    }
  }

  std::size_t size() const noexcept { return keys_.size(); }
  bool isEmpty() const noexcept { return keys_.empty(); }
  CellId operator[](std::size_t i) const noexcept
  {
    const int depth = of_.depth(keys_[i]);
    return { of_.index(keys_[i], depth), depth - padding_ };
  }
  /// Whether the cell is one, or inside one.
  bool covers(const CellId& cell) const noexcept
  {
    const Key key = keyOf(cell);
    const auto next = std::ranges::lower_bound(keys_, key);
    return (next != keys_.end() && isInside(key, *next)) ||
      (next != keys_.begin() && isInside(key, *std::prev(next)));
  }
  /// Whether some are inside the cell, or it covers it.
  bool meets(const CellId& cell) const noexcept
  {
    const Key key = keyOf(cell);
    const auto next = std::ranges::lower_bound(keys_, key);
    const auto isNested = [&](const Key& other) { return isInside(key, other) || isInside(other, key); };
    return (next != keys_.end() && isNested(*next)) || (next != keys_.begin() && isNested(*std::prev(next)));
  }

private:
  using Key = WideKey;

  Key keyOf(const CellId& cell) const noexcept { return of_.key(cell.index, padding_ + cell.level); }
  /// Whether a is b or inside it.
  bool isInside(const Key& a, const Key& b) const noexcept
  {
    return of_.depth(a) >= of_.depth(b) && of_.index(a, of_.depth(b)) == of_.index(b, of_.depth(b));
  }

  int padding_;
  MortonKeys<Key> of_{ 0 };
  std::vector<Key> keys_;
};

} // namespace treeamr

// Adaptive refinement of the unit cube, balanced 2:1 across faces, edges and corners. Private to the example
// source.
//
// Only the cells that are refined are held, level by level, as sorted Morton keys (x fastest). Balancing goes
// from the finest level up: the 26 neighbours of a refined cell must exist, so their parents must be refined.
// That is the smallest balanced tree, the one p8est_balance(P8EST_CONNECT_FULL) makes.
#pragma once

#include "Error.h"
#include "Octree/MortonKey.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace treeamr
{

/// Index of a cell on the lattice of its level, 21 bits per axis interleaved.
using MortonKey = std::uint64_t;

inline MortonKey mortonKey(const std::array<std::uint32_t, 3>& index) noexcept
{
  return interleave(index[0], index[1], index[2]);
}

inline std::array<std::uint32_t, 3> mortonIndex(MortonKey key) noexcept
{
  std::array<std::uint32_t, 3> index{};
  for (int bit = 0; bit < 21; ++bit)
  {
    for (int a = 0; a < 3; ++a)
    {
      index[a] |= static_cast<std::uint32_t>(key >> (3 * bit + a) & 1) << bit;
    }
  }
  return index;
}

class BalancedTreeBuilder
{
public:
  /// Refines every cell coarser than minimumLevel, and of the others coarser than maximumLevel (<= 20) those
  /// for which refine(index, level), called from several threads, is true; then balances. Throws Error beyond
  /// `cellLimit` cells.
  template <class Refine>
  BalancedTreeBuilder(int minimumLevel, int maximumLevel, std::uint64_t cellLimit, const Refine& refine)
    : cellLimit_(cellLimit)
  {
    if (std::uint64_t(1) << (3 * minimumLevel) > cellLimit)
    {
      failTooMany();
    }
    std::vector<MortonKey> candidates(1, 0);
    for (int level = 0; level < maximumLevel && !candidates.empty(); ++level)
    {
      if (level >= minimumLevel)
      {
        keepRefined(candidates, level, refine);
      }
      count(candidates.size());
      refined_.push_back(std::move(candidates));
      candidates.resize(8 * refined_.back().size());
      tbb::parallel_for(std::size_t(0), candidates.size(),
        [&](std::size_t i) { candidates[i] = 8 * refined_.back()[i / 8] + i % 8; });
    }
    while (!refined_.empty() && refined_.back().empty())
    {
      refined_.pop_back();
    }
    for (int level = static_cast<int>(refined_.size()) - 1; level > 0; --level)
    {
      refineParentsOfNeighbours(level);
    }
  }

  /// [level]: the refined cells, sorted.
  const std::vector<std::vector<MortonKey>>& refined() const noexcept { return refined_; }
  std::uint64_t refinedCount() const noexcept { return refinedCount_; }

private:
  template <class Refine>
  static void keepRefined(std::vector<MortonKey>& candidates, int level, const Refine& refine)
  {
    std::vector<char> keep(candidates.size());
    tbb::parallel_for(std::size_t(0), candidates.size(),
      [&](std::size_t i) { keep[i] = refine(mortonIndex(candidates[i]), level); });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < candidates.size(); ++i)
    {
      candidates[kept] = candidates[i];
      kept += keep[i] != 0;
    }
    candidates.resize(kept);
  }

  /// Among the 26 neighbours of a cell are children of its own parent and of seven others: along each axis
  /// the parent's neighbour on the side where the cell lies in it.
  void refineParentsOfNeighbours(int level)
  {
    const std::vector<MortonKey>& cells = refined_[level];
    std::vector<MortonKey>& parents = refined_[level - 1];
    const std::uint32_t end = std::uint32_t(1) << (level - 1); // of the parents' lattice, per axis
    tbb::enumerable_thread_specific<std::vector<MortonKey>> missingHere;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), 1024), [&](const auto& range) {
      std::vector<MortonKey>& missing = missingHere.local();
      for (std::size_t i = range.begin(); i != range.end(); ++i)
      {
        const std::array<std::uint32_t, 3> cell = mortonIndex(cells[i]);
        for (unsigned side = 1; side < 8; ++side)
        {
          std::array<std::uint32_t, 3> parent;
          bool inside = true;
          for (int a = 0; a < 3; ++a)
          {
            const std::uint32_t step = cell[a] & 1 ? 1 : ~std::uint32_t(0);
            parent[a] = (cell[a] >> 1) + (side >> a & 1 ? step : 0);
            inside = inside && parent[a] < end; // -1 wraps around
          }
          const MortonKey key = inside ? mortonKey(parent) : 0;
          if (inside && !std::binary_search(parents.begin(), parents.end(), key))
          {
            missing.push_back(key);
          }
        }
      }
    });

    std::vector<MortonKey> missing;
    for (const std::vector<MortonKey>& part : missingHere)
    {
      missing.insert(missing.end(), part.begin(), part.end());
    }
    tbb::parallel_sort(missing.begin(), missing.end());
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    count(missing.size());
    const std::size_t middle = parents.size();
    parents.insert(parents.end(), missing.begin(), missing.end());
    std::inplace_merge(parents.begin(), parents.begin() + static_cast<std::ptrdiff_t>(middle), parents.end());
  }

  void count(std::uint64_t more)
  {
    refinedCount_ += more;
    if (8 * refinedCount_ + 1 > cellLimit_)
    {
      failTooMany();
    }
  }

  [[noreturn]] void failTooMany() const
  {
    throw Error("refinement: more than " + std::to_string(cellLimit_) +
      " cells, coarse ones included, which is what is allowed; lower levels or a larger threshold give "
      "fewer");
  }

  std::uint64_t cellLimit_;
  std::uint64_t refinedCount_ = 0;
  std::vector<std::vector<MortonKey>> refined_;
};

} // namespace treeamr

#include "Forest/ForestPiece.h"

#include "Forest/QuadrantSearch.h"
#include "Octree/OctreeBuilder.h"
#include "Partition/BoxCuts.h"
#include "Partition/FieldSupport.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <map>
#include <mutex>
#include <utility>

namespace treeamr
{

namespace
{

/// Sorts ranges and joins those that follow each other.
void normalise(std::vector<LeafRange>& ranges)
{
  std::ranges::sort(ranges, {}, &LeafRange::begin);
  std::size_t kept = 0;
  for (const LeafRange& range : ranges)
  {
    if (range.begin >= range.end)
    {
      continue;
    }
    if (kept > 0 && ranges[kept - 1].end >= range.begin)
    {
      ranges[kept - 1].end = std::max(ranges[kept - 1].end, range.end);
    }
    else
    {
      ranges[kept++] = range;
    }
  }
  ranges.resize(kept);
}

} // namespace

/// A node of a tree and the quadrants in it.
struct ForestPiece::Place
{
  std::int32_t tree;
  std::array<std::uint32_t, 3> index;
  int level;
  LeafRange range;

  bool isLeaf() const noexcept { return range.count() == 1; }
};

/// What a piece reads to find out what it needs.
struct ForestPiece::Listed
{
  std::vector<LeafRange> inBox;    // all of them
  std::vector<LeafRange> atBorder; // of these those near the box's faces
  std::vector<LeafRange> beyond;   // the box, near its faces
  std::vector<CellId> known;       // places whose quadrants `beyond` has

  void append(const Listed& other)
  {
    const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    add(inBox, other.inBox);
    add(atBorder, other.atBorder);
    add(beyond, other.beyond);
    add(known, other.known);
  }
};

/// One thread's way down the trees.
class ForestPiece::Walk
{
public:
  explicit Walk(const P4estForestFile& file)
    : search_(file)
  {
  }

  /// visit(place): whether to go on to its children.
  template <class Visit>
  void visit(const Place& place, const Visit& visit)
  {
    if (place.range.count() == 0 || !visit(place) || place.isLeaf() ||
      place.level >= P4estForestFile::maxLevel)
    {
      return;
    }
    LeafRange rest = place.range;
    for (int o = 0; o < 8; ++o)
    {
      Place child = childOf(place, rest, o);
      rest.begin = child.range.end;
      this->visit(child, visit);
    }
  }

  /// Its child that a cell is in.
  Place descend(const Place& place, int octant) { return childOf(place, place.range, octant); }

private:
  Place childOf(const Place& place, const LeafRange& rest, int octant)
  {
    Place child{ place.tree, {}, place.level + 1, search_.child(rest, place.level, octant) };
    for (int a = 0; a < 3; ++a)
    {
      child.index[a] = 2 * place.index[a] + static_cast<std::uint32_t>(octant >> a & 1);
    }
    return child;
  }

  QuadrantSearch search_;
};

ForestPiece::ForestPiece(const P4estForestFile& file, const TreeLattice& lattice, int piece, int pieces)
  : file_(file)
  , lattice_(lattice)
  , grid_(lattice.planes())
  , piece_(piece)
{
  cutBoxes(pieces);
  Listed listed = findQuadrants(splitTrees());

  std::vector<LeafCell> cells; // near the box's faces
  readCells(listed.atBorder, [&](const CellId& cell, std::uint64_t /*number*/) {
    cells.push_back({ cell, 0.f });
  });
  effort_.quadrantsRead = cells.size();
  std::vector<std::pair<CellId, std::uint64_t>> outside;
  const auto addOutside = [&](std::vector<LeafRange> ranges) {
    readCells(ranges, [&](const CellId& cell, std::uint64_t number) {
      ++effort_.quadrantsRead;
      if (!box().meets(cell))
      {
        outside.emplace_back(cell, number);
      }
    });
  };
  addOutside(listed.beyond);
  CellSet known(grid_.paddingDepth(), listed.known);
  for (;;)
  {
    std::vector<LeafCell> all = cells;
    for (const auto& [cell, number] : outside)
    {
      all.push_back({ cell, 0.f });
    }
    ++effort_.rounds;
    const FieldSupport support = findFieldSupport(*buildOctree(grid_, std::move(all)).octree, box(), known);
    if (support.unknown.isEmpty())
    {
      for (const auto& [cell, number] : outside)
      {
        if (support.needed.meets(cell))
        {
          listed.inBox.push_back({ number, number + 1 });
        }
      }
      break;
    }
    std::vector<CellId> unknown;
    for (std::size_t i = 0; i < support.unknown.size(); ++i)
    {
      unknown.push_back(support.unknown[i]);
    }
    addOutside(readUnknown(unknown));
    known.add(unknown);
    // Places that overlap bring the same quadrants.
    std::ranges::sort(outside, {}, [](const auto& one) { return one.second; });
    const auto [first, last] = std::ranges::unique(outside, {}, [](const auto& one) { return one.second; });
    outside.erase(first, last);
  }
  ranges_ = std::move(listed.inBox);
  normalise(ranges_);
  starts_.push_back(0);
  for (const LeafRange& range : ranges_)
  {
    starts_.push_back(starts_.back() + range.count());
  }
}

/// Trees, and of large ones nodes, enough for all threads.
std::vector<ForestPiece::Place> ForestPiece::splitTrees() const
{
  std::vector<Place> places;
  Walk walk(file_);
  const std::uint64_t large = std::max<std::uint64_t>(file_.quadrantCount() / 256, 1);
  std::uint64_t begin = 0;
  for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
  {
    const std::uint64_t end = begin + file_.quadrantCount(tree);
    walk.visit({ tree, {}, 0, { begin, end } }, [&](const Place& place) {
      const bool isLarge = place.range.count() > large && place.level < 4;
      if (!isLarge)
      {
        places.push_back(place);
      }
      return isLarge;
    });
    begin = end;
  }
  return places;
}

/// By quadrants spread over the file, each for those around it, about one for each of the histogram's places, or all of a
/// small forest: what all processes read is to be far below what each reads for itself.
void ForestPiece::cutBoxes(int pieces)
{
  const std::array<int, 3>& roots = grid_.roots();
  CellHistogram histogram(roots, CellHistogram::levelFor(roots, pieces, P4estForestFile::maxLevel));
  const std::uint64_t count = file_.quadrantCount();
  const std::uint64_t most = std::max<std::uint64_t>(histogram.counts().size(), 1 << 18);
  const std::uint64_t stride = (count + most - 1) / most;
  std::mutex mutex;
  constexpr std::uint64_t blockSamples = 2048;
  tbb::parallel_for(std::uint64_t(0), (count - 1) / (stride * blockSamples) + 1, [&](std::uint64_t b) {
    std::vector<LeafRange> ranges;
    const std::uint64_t end = std::min(count, (b + 1) * stride * blockSamples);
    for (std::uint64_t first = b * stride * blockSamples; first < end; first += stride)
    {
      const std::uint64_t middle = first + (std::min(stride, count - first) - 1) / 2;
      ranges.push_back({ middle, middle + 1 });
    }
    normalise(ranges);
    LeafBlock block;
    file_.readQuadrants(ranges, block);
    const std::scoped_lock lock(mutex);
    for (const TreeLeaf& leaf : block.leaves)
    {
      const std::uint64_t first = leaf.number / stride * stride;
      // Whole numbers and their halves: the sum is the same in any order.
      histogram.add(lattice_.cellOf(leaf.tree, leaf.index, leaf.level),
        static_cast<double>(std::min(stride, count - first)));
    }
  });
  boxes_ = treeamr::cutBoxes(histogram, pieces);
}

/// And one node of this level all around, which is not coarser than the box's.
LatticeBox ForestPiece::withBorder(int level) const
{
  LatticeBox wide = box();
  for (int a = 0; a < 3; ++a)
  {
    const int finer = level - wide.level;
    wide.begin[a] = std::max<Coord>((wide.begin[a] << finer) - 1, 0);
    wide.end[a] = std::min((wide.end[a] << finer) + 1, Coord(grid_.roots()[a]) << level);
  }
  wide.level = level;
  return wide;
}

ForestPiece::Listed ForestPiece::findQuadrants(const std::vector<Place>& places) const
{
  // The border is as wide as this level's nodes or, where these have many quadrants, smaller ones: most cells that are needed
  // lie in it, and those read for nothing do not grow with the box.
  const int borderLevel = std::min(box().level + 1, P4estForestFile::maxLevel);
  constexpr std::uint64_t fewQuadrants = 512;
  const auto near = [this](const CellId& cell, Coord reach) {
    CellId first = cell;
    CellId last = cell;
    for (int a = 0; a < 3; ++a)
    {
      first.index[a] = std::max<Coord>(cell.index[a] - reach, 0);
      last.index[a] = std::min(cell.index[a] + reach, (Coord(grid_.roots()[a]) << cell.level) - 1);
    }
    return std::pair(first, last);
  };
  // What lies deeper than five of a node's own widths in the box is of no use to tell what is needed outside
  // (FieldSupport.cpp reaches three widths and the nodes around).
  const auto isDeep = [&](const CellId& cell) {
    const auto [first, last] = near(cell, 5);
    return box().contains(first) && box().contains(last);
  };
  // Of a node deeper than the border's level: whether it meets the box or is the next to one that does.
  const auto isBeside = [&](const CellId& cell) {
    const auto [first, last] = near(cell, 1);
    const int finer = cell.level - box().level;
    bool beside = true;
    for (int a = 0; a < 3; ++a)
    {
      beside = beside && last.index[a] >= box().begin[a] << finer && first.index[a] < box().end[a] << finer;
    }
    return beside;
  };
  const LatticeBox wide = withBorder(borderLevel);

  Listed all;
  if (box().isEmpty())
  {
    return all;
  }
  std::mutex mutex;
  tbb::enumerable_thread_specific<Walk> walks([this] { return Walk(file_); });
  tbb::parallel_for(std::size_t(0), places.size(), [&](std::size_t i) {
    Listed listed;
    walks.local().visit(places[i], [&](const Place& place) {
      const CellId cell = lattice_.cellOf(place.tree, place.index, place.level);
      if (!wide.meets(cell) || (cell.level > borderLevel && !isBeside(cell)))
      {
        return false;
      }
      const bool isInside = box().contains(cell);
      if (isInside && isDeep(cell))
      {
        listed.inBox.push_back(place.range);
        return false;
      }
      if (!place.isLeaf() && (place.level < borderLevel || place.range.count() > fewQuadrants))
      {
        return true;
      }
      if (box().meets(cell))
      {
        listed.inBox.push_back(place.range);
        listed.atBorder.push_back(place.range);
      }
      else
      {
        listed.beyond.push_back(place.range);
        listed.known.push_back(cell);
      }
      return false;
    });
    const std::scoped_lock lock(mutex);
    all.append(listed);
  });
  normalise(all.atBorder);
  normalise(all.beyond);
  return all;
}

/// Of the quadrants in and around places on the lattice.
std::vector<LeafRange> ForestPiece::readUnknown(const std::vector<CellId>& cells) const
{
  std::map<std::array<int, 3>, std::int32_t> trees;
  for (std::int32_t tree = 0; tree < lattice_.treeCount(); ++tree)
  {
    trees.emplace(lattice_.place(tree), tree);
  }
  std::vector<std::uint64_t> firstOfTree{ 0 };
  for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
  {
    firstOfTree.push_back(firstOfTree.back() + file_.quadrantCount(tree));
  }
  std::vector<LeafRange> ranges(cells.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), 512), [&](const auto& part) {
    Walk walk(file_);
    std::vector<Place>
      way; // to the place before, from its tree's root on: cells that follow each other share most of it
    for (std::size_t i = part.begin(); i != part.end(); ++i)
    {
      const CellId& cell = cells[i];
      std::array<int, 3> root;
      for (int a = 0; a < 3; ++a)
      {
        root[a] = static_cast<int>(cell.index[a] >> cell.level);
      }
      const auto tree = trees.find(root);
      if (tree == trees.end())
      {
        continue;
      }
      const auto isAround = [&](const Place& place) {
        const CellId node = lattice_.cellOf(place.tree, place.index, place.level);
        bool around = node.level <= cell.level;
        for (int a = 0; around && a < 3; ++a)
        {
          around = cell.index[a] >> (cell.level - node.level) == node.index[a];
        }
        return around;
      };
      while (!way.empty() && !isAround(way.back()))
      {
        way.pop_back();
      }
      if (way.empty())
      {
        const auto number = static_cast<std::size_t>(tree->second);
        way.push_back({ tree->second, {}, 0, { firstOfTree[number], firstOfTree[number + 1] } });
      }
      while (way.back().level < cell.level && way.back().range.count() > 1)
      {
        // The child around the cell is in the same octant, as the lattice's axes have it.
        const int wanted = octantAbove(cell.index, cell.level - way.back().level - 1);
        const TreeOrientation& corners = lattice_.orientation(way.back().tree);
        const auto octant = static_cast<int>(std::ranges::find(corners, wanted) - corners.begin());
        way.push_back(walk.descend(way.back(), octant));
      }
      ranges[i] = way.back().range;
    }
  });
  normalise(ranges);
  return ranges;
}

/// Calls visit(cell, number) of all leaves, one after the other.
template <class Visit>
void ForestPiece::readCells(const std::vector<LeafRange>& ranges, const Visit& visit) const
{
  LeafBlock block;
  std::vector<LeafRange> some;
  std::uint64_t count = 0;
  const auto readSome = [&] {
    file_.readQuadrants(some, block);
    for (const TreeLeaf& leaf : block.leaves)
    {
      visit(lattice_.cellOf(leaf.tree, leaf.index, leaf.level), leaf.number);
    }
    some.clear();
    count = 0;
  };
  const std::uint64_t most = file_.blockQuadrants();
  for (LeafRange range : ranges)
  {
    while (range.count() > 0)
    {
      some.push_back({ range.begin, std::min(range.end, range.begin + most - count) });
      count += some.back().count();
      range.begin = some.back().end;
      if (count == most)
      {
        readSome();
      }
    }
  }
  readSome();
}

std::vector<LeafRange> ForestPiece::ranges(std::uint64_t begin, std::uint64_t end) const
{
  std::vector<LeafRange> list;
  auto at = static_cast<std::size_t>(std::ranges::upper_bound(starts_, begin) - starts_.begin() - 1);
  for (; begin < end; ++at)
  {
    const std::uint64_t skipped = begin - starts_[at];
    const std::uint64_t taken = std::min(end, starts_[at + 1]) - begin;
    list.push_back({ ranges_[at].begin + skipped, ranges_[at].begin + skipped + taken });
    begin += taken;
  }
  return list;
}

std::vector<std::uint64_t> ForestPiece::nodeCounts() const
{
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(file_.treeCount()), 0);
  const std::uint64_t step = file_.blockQuadrants();
  const std::uint64_t blocks = (leafCount() + step - 1) / step;
  std::mutex mutex;
  tbb::parallel_for(std::uint64_t(0), blocks, [&](std::uint64_t b) {
    // Nodes of a tree are told by each of its leaves and the one before.
    const std::uint64_t first = b * step - (b > 0 ? 1 : 0);
    LeafBlock block;
    file_.readQuadrants(ranges(first, std::min(leafCount(), (b + 1) * step)), block);
    std::vector<std::pair<std::int32_t, std::uint64_t>> nodes;
    for (std::size_t i = b > 0 ? 1 : 0; i < block.leaves.size(); ++i)
    {
      const TreeLeaf& leaf = block.leaves[i];
      const bool isFirst = i == 0 || block.leaves[i - 1].tree != leaf.tree;
      const int known = isFirst ? 0 : commonLevel(block.leaves[i - 1], leaf) + 1;
      if (nodes.empty() || nodes.back().first != leaf.tree)
      {
        nodes.emplace_back(leaf.tree, 0);
      }
      nodes.back().second += 8 * static_cast<std::uint64_t>(leaf.level - known) + (isFirst ? 1 : 0);
    }
    const std::scoped_lock lock(mutex);
    for (const auto& [tree, count] : nodes)
    {
      counts[static_cast<std::size_t>(tree)] += count;
    }
  });
  return counts;
}

} // namespace treeamr

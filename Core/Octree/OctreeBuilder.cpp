// From a list of cells: keys, a sort, and the nodes between each cell's key and the one before.
#include "Octree/OctreeBuilder.h"

#include "Error.h"
#include "Octree/OctreeAssembler.h"
#include "Octree/SortedCells.h"

#include <algorithm>
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

template <class Keys, class Cells>
SortedCells<Keys, float> sortCells(int padding, Cells cells, int deepestLevel)
{
  SortedCells<Keys, float> sorted(padding, deepestLevel, cells.size());
  const Parts parts(cells.size());
  parts.forEach([&](std::size_t p) {
    for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
    {
      sorted.set(i, cells[i].cell, cells[i].value);
    }
  });
  Cells().swap(cells);
  sorted.sort();
  return sorted;
}

template <class Keys>
OctreeAndValues buildSorted(RootGrid grid, const SortedCells<Keys, float>& cells)
{
  constexpr std::size_t none = ~std::size_t(0);
  const Parts parts(cells.size());
  std::vector<NodeCounts> counts(parts.size());
  std::vector<std::size_t> overlap(parts.size(), none);
  parts.forEach([&](std::size_t p) {
    for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
    {
      // Inner nodes from the first one on and then the leaf.
      const int depth = cells.depth(i);
      for (int d = cells.firstDepth(i); d < depth; ++d)
      {
        counts[p].startInner(d, 0);
      }
      counts[p].startLeaf(depth, 0);
      if (i > 0 && overlap[p] == none && cells.overlapsBefore(i))
      {
        overlap[p] = i;
      }
    }
  });
  for (const std::size_t i : overlap)
  {
    if (i != none)
    {
      throw Error("octree: " + name(cells.cell(i)) + " overlaps " + name(cells.cell(i - 1)));
    }
  }

  OctreeAssembler assembler(std::move(grid), std::move(counts), false);
  OctreeAndValues result;
  result.values.resize(cells.size());
  parts.forEach([&](std::size_t p) {
    OctreeAssembler::Writer writer(assembler, p);
    for (std::size_t i = parts.begin(p); i < parts.end(p); ++i)
    {
      const int depth = cells.depth(i);
      for (int d = cells.firstDepth(i); d < depth; ++d)
      {
        writer.startInner(d, cells.octant(i, d));
      }
      result.values[writer.startLeaf(depth, cells.octant(i, depth))] = cells.value(i);
    }
  });
  result.octree = assembler.finish();
  return result;
}

template <class Keys, class Cells>
std::optional<OctreeAndValues> buildWith(RootGrid& grid, Cells& cells, int deepestLevel)
{
  if (grid.paddingDepth() + deepestLevel > Keys::maxDepth)
  {
    return {};
  }
  const auto sorted = sortCells<Keys>(grid.paddingDepth(), std::move(cells), deepestLevel);
  return buildSorted(std::move(grid), sorted);
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

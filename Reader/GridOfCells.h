// A vtkHyperTreeGrid of cells on a lattice and the arrays they come with. Private to the module.
#pragma once

#include "BlockArrays.h"
#include "Forest/BoxLattice.h"
#include "ParallelGridBuilder.h"

#include "Octree/RootGrid.h"

#include <algorithm>
#include <vector>

namespace treeamr
{

/// Depth of the roots below the padded one, for SortedCells.
inline int paddingOf(const BoxLattice& lattice)
{
  return RootGrid(lattice.planes()).paddingDepth();
}

/// Calls body.operator()<Keys>() with the shortest keys that cells have room in. deepest: below the padded root.
template <class Body>
auto withKeys(int deepest, const Body& body)
{
  using ShortKeys = MortonKeys<std::uint64_t>;
  return deepest <= ShortKeys::maxDepth ? body.template operator()<ShortKeys>()
                                        : body.template operator()<MortonKeys<WideKey>>();
}

/// Of cells at one place keeps that of the least CellNumber, their values. cells: sorted. Calls fail(first number, second
/// number, place of the later one) for two of different levels that overlap.
template <class Keys, class Fail>
void keepFirstOfDuplicates(SortedCells<Keys, std::uint64_t>& cells, const Fail& fail)
{
  const Parts parts(cells.size());
  std::vector<std::uint8_t> duplicates(parts.size(), 0);
  std::vector<std::size_t> overlaps(parts.size(), 0);
  parts.forEach([&](std::size_t p) {
    for (std::size_t i = std::max<std::size_t>(parts.begin(p), 1); i < parts.end(p); ++i)
    {
      if (cells.overlapsBefore(i) && cells.isSameAsBefore(i))
      {
        duplicates[p] = 1;
      }
      else if (cells.overlapsBefore(i) && overlaps[p] == 0)
      {
        overlaps[p] = i;
      }
    }
  });
  for (const std::size_t i : overlaps)
  {
    if (i > 0)
    {
      const auto [first, second] = std::minmax(cells.value(i - 1), cells.value(i));
      fail(CellNumber(first), CellNumber(second), cells.cell(i));
    }
  }
  if (std::ranges::find(duplicates, 1) != duplicates.end())
  {
    cells.removeDuplicates();
  }
}

/// cells: with their CellNumbers, disjoint, sorted. planes: between roots, per axis. grid: an empty one. addMore(builder): of
/// further arrays.
template <class Keys, class AddMore>
void buildGrid(const SortedCells<Keys, std::uint64_t>& cells,
  const std::array<std::vector<double>, 3>& planes, const BlockArrays& arrays, vtkHyperTreeGrid* grid,
  const AddMore& addMore)
{
  setLattice(grid, planes);
  ParallelGridBuilder<Keys> builder(cells);
  for (const BlockArray& array : arrays.arrays)
  {
    builder.addArray(makeFiller(arrays, array, builder.nodeCount(),
      { cells.size(), [&](std::size_t i) { return CellNumber(cells.value(i)); } }));
  }
  addMore(builder);
  builder.build(grid);
}
template <class Keys>
void buildGrid(const SortedCells<Keys, std::uint64_t>& cells,
  const std::array<std::vector<double>, 3>& planes, const BlockArrays& arrays, vtkHyperTreeGrid* grid)
{
  buildGrid(cells, planes, arrays, grid, [](ParallelGridBuilder<Keys>& /*builder*/) {});
}

} // namespace treeamr

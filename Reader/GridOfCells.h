// A vtkHyperTreeGrid of cells on a lattice and the arrays they come with. Private to the module.
#pragma once

#include "BlockArrays.h"
#include "Forest/BoxLattice.h"
#include "ParallelGridBuilder.h"

#include "Octree/RootGrid.h"

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
  return deepest <= ShortKeys::maxDepth
    ? body.template operator()<ShortKeys>()
    : body.template operator()<MortonKeys<WideKey>>();
}

/// cells: with their CellNumbers, disjoint, sorted. planes: between roots, per axis. grid: an empty one.
template <class Keys>
void buildGrid(const SortedCells<Keys, std::uint64_t>& cells,
  const std::array<std::vector<double>, 3>& planes, const BlockArrays& arrays, vtkHyperTreeGrid* grid)
{
  setLattice(grid, planes);
  ParallelGridBuilder<Keys> builder(cells);
  for (const BlockArray& array : arrays.arrays)
  {
    builder.addArray(makeFiller(arrays, array, builder.nodeCount(),
      { cells.size(), [&](std::size_t i) { return CellNumber(cells.value(i)); } }));
  }
  builder.build(grid);
}

} // namespace treeamr

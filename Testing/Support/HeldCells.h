// The cells that a process holds that draws a box of a domain.
#pragma once

#include "Octree/OctreeBuilder.h"
#include "Partition/FieldSupport.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <vector>

namespace treeamr::test
{

inline std::shared_ptr<const Octree> octreeOf(const RootGrid& grid, const std::vector<LeafCell>& cells)
{
  return buildOctree(grid, cells).octree;
}

/// The cells that are in the box or, wholly or with a part, in places.
inline std::vector<LeafCell> held(const std::vector<LeafCell>& cells, const LatticeBox& box, const CellSet& places)
{
  std::vector<LeafCell> kept;
  std::ranges::copy_if(cells, std::back_inserter(kept),
    [&](const LeafCell& leaf) { return box.meets(leaf.cell) || places.meets(leaf.cell); });
  return kept;
}

struct Support
{
  std::vector<LeafCell> cells;
  int rounds = 0;
};

/// As a process that sees no more than it has asked for.
inline Support supportOf(const RootGrid& grid, const std::vector<LeafCell>& cells, const LatticeBox& box)
{
  CellSet known(grid.paddingDepth());
  Support support;
  for (;;)
  {
    ++support.rounds;
    const std::vector<LeafCell> sofar = held(cells, box, known);
    const FieldSupport found = findFieldSupport(*octreeOf(grid, sofar), box, known);
    if (found.unknown.isEmpty())
    {
      support.cells = held(cells, box, found.needed);
      return support;
    }
    std::vector<CellId> more;
    for (std::size_t i = 0; i < found.unknown.size(); ++i)
    {
      more.push_back(found.unknown[i]);
    }
    known.add(more);
    EXPECT_LT(support.rounds, 30);
  }
}

} // namespace treeamr::test

// Whether cells are missing in an octree.
#pragma once

#include "Octree/Octree.h"

namespace treeamr
{

/// Whether the domain is covered.
inline bool hasAllCells(const Octree& octree) noexcept
{
  std::uint64_t cells = 1; // when none is refined
  for (const int roots : octree.grid().roots())
  {
    cells *= static_cast<std::uint64_t>(roots);
  }
  const int padding = octree.grid().paddingDepth();
  const std::uint64_t above =
    padding < octree.innerDepths() ? octree.firstInner(padding) : octree.innerCount();
  return octree.leafCount() == cells + 7 * (octree.innerCount() - above);
}

} // namespace treeamr

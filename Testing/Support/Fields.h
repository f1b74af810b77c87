// Fields for tests.
#pragma once

#include "Field/Field.h"
#include "Octree/OctreeBuilder.h"

#include <array>
#include <memory>
#include <vector>

namespace treeamr::test
{

inline std::shared_ptr<const Field> makeField(const RootGrid& grid, const std::vector<LeafCell>& cells)
{
  auto built = buildOctree(grid, cells);
  return std::make_shared<const Field>(built.octree, built.values);
}

/// Roots are unit cubes from the origin on.
inline RootGrid unitRoots(const std::array<int, 3>& roots)
{
  return RootGrid::uniform(roots, { 0., 0., 0. }, { 1., 1., 1. });
}

} // namespace treeamr::test

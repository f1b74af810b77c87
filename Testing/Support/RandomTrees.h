// Random octrees for property tests.
#pragma once

#include "Octree/OctreeBuilder.h"
#include "Octree/TreePath.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace treeamr::test
{

struct RandomTree
{
  std::uint32_t seed = 1;
  std::array<int, 3> roots{ 1, 1, 1 };
  int levels = 4;        // deepest level
  double refine = 0.5;   // probability that a cell above the deepest level is refined
  double missing = 0.;   // probability that a leaf is left out
  bool balanced = false; // 2:1 across faces, edges and corners
};

/// At least one cell; values uniform in [-1, 1].
std::vector<LeafCell> makeRandomTree(const RandomTree& options);

/// Centre in units of roots.
std::array<double, 3> centre(const CellId& cell);
/// Replaces the values by a function of the centres in units of roots.
void setValues(std::vector<LeafCell>& cells, const std::function<double(const std::array<double, 3>&)>& f);

/// The property tests' set: balanced, unbalanced (jumps up to 5 levels), sparse, several roots; 36 trees.
std::vector<RandomTree> propertyTrees();

/// Calls f at every node, parents first.
void forEachNode(TreePath& path, const std::function<void(const TreePath&)>& f);

} // namespace treeamr::test

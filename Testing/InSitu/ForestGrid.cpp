#include "InSitu/ForestGrid.h"

#include "HyperTreeGridBuilder.h"

#include "vtkHyperTreeGrid.h"

#include <algorithm>
#include <iterator>

namespace treeamr::test
{
namespace
{

/// Of each tree at corner 0 (the least) and 7 (the largest).
const double* cornerOf(const p8est_connectivity_t& connectivity, p4est_topidx_t tree, int corner)
{
  return connectivity.vertices + 3 * connectivity.tree_to_vertex[8 * tree + corner];
}

TreeLattice latticeOf(const p8est_connectivity_t& connectivity)
{
  std::array<std::vector<double>, 3> planes;
  for (int a = 0; a < 3; ++a)
  {
    for (p4est_topidx_t tree = 0; tree < connectivity.num_trees; ++tree)
    {
      planes[a].push_back(cornerOf(connectivity, tree, 0)[a]);
      planes[a].push_back(cornerOf(connectivity, tree, 7)[a]);
    }
    std::ranges::sort(planes[a]);
    planes[a].erase(std::unique(planes[a].begin(), planes[a].end()), planes[a].end());
  }
  std::vector<std::array<int, 3>> places;
  for (p4est_topidx_t tree = 0; tree < connectivity.num_trees; ++tree)
  {
    std::array<int, 3>& place = places.emplace_back();
    for (int a = 0; a < 3; ++a)
    {
      const auto plane = std::ranges::lower_bound(planes[a], cornerOf(connectivity, tree, 0)[a]);
      place[a] = static_cast<int>(plane - planes[a].begin());
    }
  }
  return { std::move(planes), std::move(places) };
}

/// The local quadrants of a forest as a list of leaves, which is nowhere made.
class LocalLeaves
{
public:
  explicit LocalLeaves(const p8est_t& forest)
    : forest_(forest)
  {
    for (p4est_topidx_t t = forest.first_local_tree; t <= forest.last_local_tree; ++t)
    {
      trees_.push_back(p8est_tree_array_index(forest.trees, t));
    }
  }

  std::uint64_t count() const noexcept { return static_cast<std::uint64_t>(forest_.local_num_quadrants); }

  /// visit(leaf) of [begin, end).
  template <class Visit>
  void visit(std::uint64_t begin, std::uint64_t end, const Visit& visit) const
  {
    const auto startsAfter = [](std::uint64_t at, p8est_tree_t* tree) {
      return at < static_cast<std::uint64_t>(tree->quadrants_offset);
    };
    auto tree = std::upper_bound(trees_.begin(), trees_.end(), begin, startsAfter) - trees_.begin() - 1;
    for (; begin < end; ++tree)
    {
      sc_array_t* const quadrants = &trees_[tree]->quadrants;
      const auto offset = static_cast<std::uint64_t>(trees_[tree]->quadrants_offset);
      for (; begin < end && begin - offset < quadrants->elem_count; ++begin)
      {
        const p8est_quadrant_t& q = *p8est_quadrant_array_index(quadrants, begin - offset);
        const int up = P8EST_MAXLEVEL - q.level;
        const auto index = [up](p4est_qcoord_t at) { return static_cast<std::uint32_t>(at >> up); };
        visit(TreeLeaf{ static_cast<std::int32_t>(forest_.first_local_tree + tree),
          { index(q.x), index(q.y), index(q.z) }, q.level, begin, static_cast<const std::byte*>(q.p.user_data) });
      }
    }
  }

private:
  const p8est_t& forest_;
  std::vector<p8est_tree_t*> trees_; // those with quadrants here
};

} // namespace

vtkSmartPointer<vtkHyperTreeGrid> gridOfForest(const p8est_t& forest, const char* name, std::size_t offset)
{
  const TreeLattice lattice = latticeOf(*forest.connectivity);
  const LocalLeaves leaves(forest);
  std::vector<NodeCounter> counters(static_cast<std::size_t>(lattice.treeCount()));
  leaves.visit(0, leaves.count(), [&](const TreeLeaf& leaf) { counters[leaf.tree].add(leaf); });
  std::vector<std::uint64_t> nodes;
  std::ranges::transform(counters, std::back_inserter(nodes), &NodeCounter::count);

  const auto grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
  HyperTreeGridBuilder builder(grid, lattice, nodes, "the forest");
  builder.addArray(makeFiller({ name, PayloadType::Float64, 1, offset }, builder.nodeCount()));
  constexpr std::uint64_t blockLeaves = 16384;
  builder.build(leaves.count(), blockLeaves, [&](std::uint64_t begin, std::uint64_t end, LeafBlock& block) {
    block.leaves.clear();
    leaves.visit(begin, end, [&](const TreeLeaf& leaf) { block.leaves.push_back(leaf); });
  });
  return grid;
}

} // namespace treeamr::test

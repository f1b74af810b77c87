// The trees of a vtkHyperTreeGrid, checked once and then safe to read from several threads. Private to the
// converter.
//
// Along an axis with decreasing coordinates, as in the mirrored grids of vtkHyperTreeGridAxisReflection, roots and
// octants are counted from the other end: places are always in the order of increasing coordinates. Vertices and
// global indices stay those of the grid.
//
// Read directly from the storage behind vtkHyperTree: VTK's cursors are not thread-safe and cost an object
// each. A vertex that is not drawn (masked, hidden, without a finite value) is marked in one byte per vertex;
// the bytes exist only when the grid has such vertices or ghosts.
//
// Where VTK leaves the meaning open:
// - vtkGhostType counts on leaves only. Writers set it on coarse vertices without meaning the cells below.
// - A mask shorter than the cells masks nothing beyond its end, as in vtkHyperTree::InitializeForReader().
// - A vertex at the depth limit is a leaf; it exists when a leaf below it does, and is a ghost when all are.
#pragma once

#include "ContentDigest.h"

#include "Octree/RootGrid.h"

#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_for_each.h>

#include <atomic>
#include <limits>
#include <vector>

namespace treeamr
{

/// One tree of a grid. Vertices are its nodes, coarse ones and leaves, as VTK numbers them.
struct HyperTreeView
{
  std::array<Coord, 3> root{}; // on the root lattice
  int turned = 0;              // turnedAxes() of the grid
  vtkHyperTree* tree = nullptr;
  vtkIdType vertexCount = 0;
  const unsigned int* elderChild = nullptr; // [elderChildCount]; a vertex beyond is a leaf
  std::size_t elderChildCount = 0;
  vtkIdType globalStart = 0;  // negative: the tree has an explicit table of global indices
  std::size_t firstState = 0; // of the tree's vertices among the topology's bytes

  bool isLeaf(vtkIdType vertex) const noexcept
  {
    // A tree never refined may hold 0 for its root in place of "no child".
    return static_cast<std::size_t>(vertex) >= elderChildCount || vertexCount == 1 ||
      elderChild[vertex] == std::numeric_limits<unsigned int>::max();
  }
  /// Of the eight, one after the other, of a coarse vertex.
  vtkIdType firstChild(vtkIdType vertex) const noexcept { return static_cast<vtkIdType>(elderChild[vertex]); }
  vtkIdType child(vtkIdType vertex, int octant) const noexcept
  {
    return firstChild(vertex) + (octant ^ turned);
  }
  /// The place of the vertex's value in the cell arrays.
  vtkIdType globalIndex(vtkIdType vertex) const
  {
    return globalStart >= 0 ? globalStart + vertex : tree->GetGlobalIndexFromLocal(vertex);
  }
};

/// Mask of the axes along which coordinates decrease.
int turnedAxes(vtkHyperTreeGrid& grid);

/// A root's index along an axis on the grid's own lattice from that on the root lattice, and back.
inline Coord turnedRoot(Coord index, Coord roots, bool isTurned) noexcept
{
  return isTurned ? roots - 1 - index : index;
}

/// The coordinates of the planes between roots, increasing. Throws Error for a grid that is not three-dimensional and
/// for coordinates that are not finite or neither strictly increase nor strictly decrease.
std::array<std::vector<double>, 3> readRootPlanes(vtkHyperTreeGrid& grid);

/// The trees that the grid holds, in the order of their places (x fastest). Throws Error for a tree that is
/// not an octree, lies outside the root lattice or has no global indices.
std::vector<HyperTreeView> collectTrees(vtkHyperTreeGrid& grid);

class HyperTreeGridTopology
{
public:
  /// Throws Error naming what the converter cannot take.
  explicit HyperTreeGridTopology(vtkHyperTreeGrid* grid);

  const RootGrid& rootGrid() const noexcept { return rootGrid_; }
  const std::vector<HyperTreeView>& trees() const noexcept { return trees_; }
  unsigned int depthLimit() const noexcept { return depthLimit_; }
  /// One more than the largest global index: what an array needs to have a value for every vertex.
  vtkIdType globalIndexEnd() const noexcept { return globalIndexEnd_; }

  bool exists(const HyperTreeView& tree, vtkIdType vertex) const noexcept
  {
    return states_.empty() || (states_[tree.firstState + vertex] & existsBit);
  }
  bool hasGhosts() const noexcept { return hasGhosts_; }
  /// Whether ghosts are cells like others, for a box says what is drawn (GridPartition.h).
  bool isPartitioned() const noexcept { return isPartitioned_; }
  bool isGhost(const HyperTreeView& tree, vtkIdType vertex) const noexcept
  {
    return hasGhosts_ && (states_[tree.firstState + vertex] & ghostBit);
  }
  bool hasCells() const noexcept;
  /// Throws Error when coarse vertices of the level have children too deep for the root grid.
  void checkDepth(unsigned int level) const;

  /// Calls body(global index) for every leaf that exists, from several threads.
  template <class Body>
  void forEachLeaf(const Body& body) const
  {
    forEachVertex([&](const HyperTreeView& tree, vtkIdType v) {
      if (tree.isLeaf(v) && exists(tree, v))
      {
        body(tree.globalIndex(v));
      }
    });
  }

  /// Leaves out the leaves for which isFinite(global index), called from several threads, is false. False:
  /// none.
  template <class IsFinite>
  bool excludeNonFinite(const IsFinite& isFinite);

  /// Of all that decides the octree's nodes: equal digests, equal octrees.
  ContentDigest octreeDigest() const;
  /// Of the map from vertices to values.
  const ContentDigest& globalIndexDigest() const noexcept { return globalIndexDigest_; }

private:
  static constexpr std::uint8_t existsBit = 1;
  static constexpr std::uint8_t ghostBit = 2;

  static vtkHyperTreeGrid& checked(vtkHyperTreeGrid* grid);
  /// Calls body(tree, vertex) for every vertex, in parallel.
  template <class Body>
  void forEachVertex(const Body& body) const;
  void checkTrees() const;
  void measureGlobalIndices();
  void markMaskAndGhosts(vtkHyperTreeGrid& grid);
  void allocateStates();
  void propagateStates();
  std::uint8_t propagateStates(
    const HyperTreeView& tree, vtkIdType vertex, unsigned int level, bool belowMasked);

  RootGrid rootGrid_;
  std::vector<HyperTreeView> trees_;
  unsigned int depthLimit_;
  vtkIdType globalIndexEnd_ = 0;
  ContentDigest globalIndexDigest_;
  std::vector<std::uint8_t> states_; // per vertex, tree after tree; empty: all exist, none is a ghost
  bool hasGhosts_ = false;
  bool isPartitioned_;
};

template <class Body>
void HyperTreeGridTopology::forEachVertex(const Body& body) const
{
  tbb::parallel_for_each(trees_.begin(), trees_.end(), [&](const HyperTreeView& tree) {
    tbb::parallel_for(tbb::blocked_range<vtkIdType>(0, tree.vertexCount, 4096), [&](const auto& range) {
      for (vtkIdType v = range.begin(); v != range.end(); ++v)
      {
        body(tree, v);
      }
    });
  });
}

template <class IsFinite>
bool HyperTreeGridTopology::excludeNonFinite(const IsFinite& isFinite)
{
  const auto excluded = [&](const HyperTreeView& tree, vtkIdType v) {
    return tree.isLeaf(v) && exists(tree, v) && !isFinite(tree.globalIndex(v));
  };
  std::atomic<bool> found{ false };
  forEachVertex([&](const HyperTreeView& tree, vtkIdType v) {
    if (!found.load(std::memory_order_relaxed) && excluded(tree, v))
    {
      found.store(true, std::memory_order_relaxed);
    }
  });
  if (!found)
  {
    return false;
  }
  allocateStates();
  forEachVertex([&](const HyperTreeView& tree, vtkIdType v) {
    if (excluded(tree, v))
    {
      states_[tree.firstState + v] = 0;
    }
  });
  propagateStates();
  return true;
}

} // namespace treeamr

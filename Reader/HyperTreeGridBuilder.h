// A vtkHyperTreeGrid from the leaves of a forest of octrees, whatever they were read from.
//
// Leaves come tree by tree, in Morton order of the tree's own axes (the first one fastest), which is a depth-first order: the path from the root to the
// current place is all that is kept, and an inner node gets its values when its eighth child is complete. Where no leaf
// comes, the coarsest cells that hold none are masked. The number of nodes must be known beforehand, so that arrays
// are allocated once: of a tree that has leaves everywhere it is one for each leaf and one for each seven, of others
// NodeCounter tells it. In a plane, four children and three.
//
// Used so: make one, add the arrays that are wanted, add all leaves, finish.
#pragma once

#include "CellArrayFillers.h"
#include "Forest/TreeLattice.h"
#include "Forest/TreeLeaf.h"
#include "vtkTreeAMRReaderModule.h" // for the export macro

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

class vtkBitArray;
class vtkHyperTree;
class vtkHyperTreeGrid;

namespace treeamr
{

/// The nodes of a tree from its leaves, in Morton order.
class NodeCounter
{
public:
  void add(const TreeLeaf& leaf) noexcept
  {
    // Inner nodes are those above the leaf but for what it shares with the leaf before.
    int shared = 0; // levels
    if (hasLeaf_)
    {
      std::uint32_t differing = 0; // at the coarser one's level
      const int level = leaf.level < last_.level ? leaf.level : last_.level;
      for (int a = 0; a < 3; ++a)
      {
        differing |= (leaf.index[a] >> (leaf.level - level)) ^ (last_.index[a] >> (last_.level - level));
      }
      shared = level - static_cast<int>(std::bit_width(differing)) + 1;
    }
    inner_ += static_cast<std::uint64_t>(leaf.level - shared);
    hasLeaf_ = true;
    last_ = leaf;
  }
  /// With the places that no leaf is at.
  std::uint64_t count() const noexcept { return hasLeaf_ ? 1 + 8 * inner_ : 0; }

private:
  bool hasLeaf_ = false;
  TreeLeaf last_{};
  std::uint64_t inner_ = 0;
};

/// Branch factor 2, and the planes between roots per axis, a single one across an axis that the grid has not. grid: an
/// empty one. Throws Error for more roots than it can have.
VTKTREEAMRREADER_EXPORT void setLattice(
  vtkHyperTreeGrid* grid, const std::array<std::vector<double>, 3>& planes);

class VTKTREEAMRREADER_EXPORT HyperTreeGridBuilder
{
public:
  /// The deepest leaves of any source.
  static constexpr int maxLevel = 31;

  /// grid: gets branch factor, lattice and trees, an empty one. nodeCounts: of each tree, with its inner nodes and
  /// places without a leaf; 0: there is none. source: the name of what is read, for messages. Throws Error when a tree has
  /// more nodes than a vtkHyperTree can have.
  HyperTreeGridBuilder(vtkHyperTreeGrid* grid, const TreeLattice& lattice,
    const std::vector<std::uint64_t>& nodeCounts, std::string source);
  ~HyperTreeGridBuilder();

  /// Of all trees: tuples of each cell array.
  vtkIdType nodeCount() const noexcept { return treeStarts_.back(); }
  /// Before the first leaf. The first array becomes the active scalars.
  void addArray(std::unique_ptr<CellArrayFiller> filler);

  /// Throws Error for a leaf that does not follow the one before, and for more nodes than were told.
  void add(const TreeLeaf& leaf);
  /// After the last leaf. Throws Error for fewer nodes than were told.
  void finish();

private:
  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const;
  void startTree(std::int32_t tree);
  void finishTree();
  bool isAround(const TreeLeaf& leaf) const noexcept;
  void subdivide();
  void mask();
  void goOn(bool hasCell);

  vtkHyperTreeGrid* grid_;
  const TreeLattice& lattice_;
  const int childCount_;
  std::string source_;
  std::vector<vtkIdType> treeStarts_; // and the end of the last one
  std::vector<std::unique_ptr<CellArrayFiller>> fillers_;
  vtkSmartPointer<vtkBitArray> mask_; // null: nothing is masked

  vtkHyperTree* tree_ = nullptr;
  std::int32_t treeNumber_ = -1;
  bool complete_ = true; // the current tree
  // The path from the root to where the next leaf begins.
  int level_ = 0;
  TreeOrientation orientation_ = alongAxes;
  std::array<int, maxLevel + 1> child_{};            // by level, its number in the order of leaves
  std::array<vtkIdType, maxLevel + 1> node_{};       // by level
  std::array<vtkIdType, maxLevel + 1> firstChild_{}; // of the node of a level
  std::array<unsigned, maxLevel + 1> filled_{};      // mask of its children that have cells below
  std::array<std::array<std::uint32_t, 3>, maxLevel + 1> index_{};
};

} // namespace treeamr

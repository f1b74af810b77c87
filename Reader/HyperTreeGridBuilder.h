// A vtkHyperTreeGrid from the leaves of a forest of octrees, whatever they were read from, in parallel.
//
// Leaves come tree by tree, in Morton order of the tree's own axes (the first one fastest), which is a depth-first order,
// and VTK's trees number their nodes as they are subdivided, here in that order: so with inner nodes counted in blocks of
// leaves first, every node's place is known to whoever comes by it. Blocks are read, counted and filled by several
// threads, a few of them at once; only the subdivision itself is done by one, while others read the next blocks. Where no
// leaf comes, the coarsest cells that hold none are masked.
//
// The number of nodes must be known beforehand, so that arrays are allocated once: of a tree that has leaves everywhere it
// is one for each leaf and one for each seven, of others NodeCounter tells it. In a plane, four children and three.
//
// Used so: make one, add the arrays that are wanted, build.
#pragma once

#include "CellArrayFillers.h"
#include "Forest/TreeLattice.h"
#include "Forest/TreeLeaf.h"
#include "vtkTreeAMRReaderModule.h" // for the export macro

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <array>
#include <cstdint>
#include <functional>
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
    inner_ += static_cast<std::uint64_t>(leaf.level - (hasLeaf_ ? commonLevel(leaf, last_) + 1 : 0));
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

/// A new tree's memory for its nodes, all at once: it would double as they come.
void reserveNodes(vtkHyperTree* tree, vtkIdType nodes);

class VTKTREEAMRREADER_EXPORT HyperTreeGridBuilder
{
public:
  /// The deepest leaves of any source.
  static constexpr int maxLevel = 31;

  /// Fills a block with the leaves [begin, end) of all; called by several threads.
  using ReadLeaves = std::function<void(std::uint64_t begin, std::uint64_t end, LeafBlock& block)>;

  /// grid: gets branch factor, lattice and trees, an empty one. lattice: kept by reference. nodeCounts: of each tree, with
  /// its inner nodes and places without a leaf; 0: there is none. source: the name of what is read, for messages. Throws
  /// Error when a tree has more nodes than a vtkHyperTree can have.
  HyperTreeGridBuilder(vtkHyperTreeGrid* grid, const TreeLattice& lattice,
    const std::vector<std::uint64_t>& nodeCounts, std::string source);
  ~HyperTreeGridBuilder();

  /// Of all trees: tuples of each cell array.
  vtkIdType nodeCount() const noexcept { return treeStarts_.back(); }
  /// The first array becomes the active scalars. Its filler is called by several threads.
  void addArray(std::unique_ptr<CellArrayFiller> filler);

  /// Once. blockLeaves: how many to read at a time. progress: called by this thread now and then, with the leaves that there
  /// are by then. Throws what `read` throws, of the first block where it does, and Error for a leaf that does not follow the
  /// one before, and for more or fewer nodes than were told.
  void build(std::uint64_t leafCount, std::uint64_t blockLeaves, const ReadLeaves& read,
    const std::function<void(std::uint64_t)>& progress = {});

private:
  static constexpr std::uint64_t none = ~std::uint64_t(0);
  /// Of the ancestors of a leaf, by their levels: which of their tree's inner nodes, in depth-first order.
  using Path = std::array<std::uint64_t, maxLevel>;

  /// An inner node with children yet to come, or the last of them just gone.
  struct Family
  {
    vtkIdType node; // as the other, among those of all trees
    vtkIdType firstChild;
    unsigned present; // mask of the children that have cells
  };
  struct Block;

  [[noreturn]] void fail(std::int32_t tree, const std::string& found, const std::string& allowed) const;
  std::uint64_t told(std::int32_t tree) const noexcept
  {
    return static_cast<std::uint64_t>(treeStarts_[tree + 1] - treeStarts_[tree]);
  }
  std::uint64_t nodesWith(std::uint64_t inner) const noexcept
  {
    return 1 + static_cast<std::uint64_t>(childCount_) * inner;
  }
  int stepTo(const TreeLeaf& leaf, const TreeLeaf* before) const;
  void count(Block& block) const;
  void startAt(Block& block);
  void goToTree(std::int32_t tree, std::int32_t before) const;
  void endTree(std::int32_t tree, std::uint64_t inner) const;
  void place(Block& block) const;
  void fill(Block& block) const;
  void fillAndMask(const Family& family, std::vector<vtkIdType>& masked) const;
  void finish(Block& block);
  void closeTo(std::size_t level);
  void mask(const std::vector<vtkIdType>& nodes);
  void makeTree(std::int32_t number);

  vtkHyperTreeGrid* grid_;
  const TreeLattice& lattice_;
  const int childCount_;
  std::string source_;
  std::vector<vtkIdType> treeStarts_; // and the end of the last one
  std::vector<std::unique_ptr<CellArrayFiller>> fillers_;
  vtkSmartPointer<vtkBitArray> mask_; // null: nothing is masked

  // Behind the blocks that startAt() has seen.
  TreeLeaf last_{ -1, {}, 0, 0, nullptr };
  std::uint64_t inner_ = 0; // of the last one's tree
  Path path_{};
  // Behind those that finish() has seen.
  vtkHyperTree* tree_ = nullptr;
  std::vector<Family> open_; // by levels
};

} // namespace treeamr

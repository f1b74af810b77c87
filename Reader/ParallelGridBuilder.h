// A vtkHyperTreeGrid from leaves that are sorted by their Morton keys, in parallel.
//
// VTK's trees number their nodes as they are subdivided: here inner nodes in depth-first order, so that the children of
// the n-th of a tree, 0 first, are its nodes 8 n + 1 to 8 n + 8. Hence with inner nodes counted in parts of the leaves
// first, every node's place is known to whoever comes by it, and only the subdivision itself is done by one thread.
// Where no leaf is, the coarsest cells that hold none are masked.
//
// Used so: make one, add the arrays that are wanted, build.
#pragma once

#include "CellArrayFillers.h"
#include "HyperTreeGridBuilder.h"
#include "LargeArray.h"
#include "Octree/SortedCells.h"

#include "Error.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"

#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace treeamr
{

/// Keys: one of MortonKey.h's. The cells' values are what fillers get as their leaf's number.
template <class Keys>
class ParallelGridBuilder
{
public:
  using Cells = SortedCells<Keys, std::uint64_t>;

  /// cells: disjoint, on a lattice whose roots are the depth of their padding; kept by reference. Throws Error for a tree
  /// of more nodes than a vtkHyperTree can have.
  explicit ParallelGridBuilder(const Cells& cells)
    : cells_(cells)
    , parts_(cells.size())
    , starts_(parts_.size() + 1)
  {
    parts_.forEach([&](std::size_t p) { starts_[p + 1] = count(p); });
    for (std::size_t p = 0; p < parts_.size(); ++p)
    {
      starts_[p + 1].continueFrom(starts_[p]);
    }
  }

  /// Of all trees, with inner nodes and places without a leaf: tuples of each cell array.
  vtkIdType nodeCount() const noexcept
  {
    return static_cast<vtkIdType>(starts_.back().trees + 8 * starts_.back().inner);
  }
  /// The first array becomes the active scalars. Its filler is called from several threads.
  void addArray(std::unique_ptr<CellArrayFiller> filler) { fillers_.push_back(std::move(filler)); }

  /// grid: an empty one with a lattice.
  void build(vtkHyperTreeGrid* grid)
  {
    inner_ = makeLargeArray<Inner>(starts_.back().inner);
    tbb::parallel_for(
      std::uint64_t(0), starts_.back().inner, [&](std::uint64_t n) { inner_[n].present = 0; });
    trees_.resize(starts_.back().trees);
    parts_.forEach([&](std::size_t p) { walk(p); });
    checkTrees();
    makeTrees(grid);
    mask(grid);
    fillInner();
    for (const auto& filler : fillers_)
    {
      grid->GetCellData()->AddArray(filler->array());
    }
    if (!fillers_.empty())
    {
      grid->GetCellData()->SetActiveScalars(fillers_.front()->array()->GetName());
    }
  }

private:
  static constexpr std::uint64_t none = ~std::uint64_t(0);

  struct Inner
  {
    vtkIdType node; // among those of all trees
    std::uint32_t tree;
    std::uint8_t level;
    std::uint8_t present; // mask of the children that have cells, to which several threads add
  };
  struct Tree
  {
    std::array<Coord, 3> place;
    std::uint64_t firstInner; // the number of inner nodes before
  };
  /// What there is before a part: its leaves count on from here.
  struct Start
  {
    std::uint64_t trees = 0;
    std::uint64_t inner = 0;
    std::array<std::uint64_t, Keys::maxDepth + 1> path{}; // the latest inner node of a depth

    /// Made of counts from 0 on.
    void continueFrom(const Start& before)
    {
      for (int d = 0; d <= Keys::maxDepth; ++d)
      {
        path[d] = path[d] == none ? before.path[d] : path[d] + before.inner;
      }
      trees += before.trees;
      inner += before.inner;
    }
  };

  /// Calls startTree(i), startInner(i, depth) and leaf(i) in depth-first order.
  template <class StartTree, class StartInner, class Leaf>
  void visit(
    std::size_t part, const StartTree& startTree, const StartInner& startInner, const Leaf& leaf) const
  {
    const int padding = cells_.padding();
    for (std::size_t i = parts_.begin(part); i < parts_.end(part); ++i)
    {
      const int depth = cells_.depth(i);
      int d = cells_.firstDepth(i);
      if (d <= padding)
      {
        startTree(i);
        d = padding;
      }
      for (; d < depth; ++d)
      {
        startInner(i, d);
      }
      leaf(i, depth);
    }
  }

  Start count(std::size_t part) const
  {
    Start counted;
    counted.path.fill(none);
    visit(
      part, [&](std::size_t /*i*/) { ++counted.trees; },
      [&](std::size_t /*i*/, int depth) { counted.path[depth] = counted.inner++; },
      [](std::size_t /*i*/, int /*depth*/) {});
    return counted;
  }

  /// Fills in what starts in a part.
  void walk(std::size_t part)
  {
    const int padding = cells_.padding();
    Start at = starts_[part];
    const auto nodeOf = [&](std::size_t i, int depth) {
      const std::uint64_t tree = at.trees - 1;
      if (depth == padding)
      {
        return static_cast<vtkIdType>(tree + 8 * at.inner); // its root comes after all nodes of trees before
      }
      const std::uint64_t parent = at.path[depth - 1];
      const int octant = cells_.octant(i, depth);
      std::atomic_ref(inner_[parent].present)
        .fetch_or(static_cast<std::uint8_t>(1u << octant), std::memory_order_relaxed);
      return static_cast<vtkIdType>(tree + 8 * parent + 1) + octant;
    };
    visit(
      part,
      [&](std::size_t i) {
        trees_[at.trees++] = { cells_.index(i, padding), at.inner };
      },
      [&](std::size_t i, int depth) {
        Inner& inner = inner_[at.inner];
        inner.node = nodeOf(i, depth);
        inner.tree = static_cast<std::uint32_t>(at.trees - 1);
        inner.level = static_cast<std::uint8_t>(depth - padding);
        at.path[depth] = at.inner++;
      },
      [&](std::size_t i, int depth) {
        const vtkIdType node = nodeOf(i, depth);
        const std::uint64_t soon = cells_.value(std::min(i + 16, cells_.size() - 1));
        TreeLeaf leaf{ static_cast<std::int32_t>(at.trees - 1), {}, depth - padding, cells_.value(i),
          nullptr };
        const std::array<Coord, 3> index = cells_.index(i, depth);
        for (int a = 0; a < 3; ++a)
        {
          leaf.index[a] = static_cast<std::uint32_t>(index[a] & ((Coord(1) << leaf.level) - 1));
        }
        for (const auto& filler : fillers_)
        {
          filler->prepare(soon);
          filler->setLeaf(node, leaf);
        }
      });
  }

  std::uint64_t endOfInner(std::size_t tree) const
  {
    return tree + 1 < trees_.size() ? trees_[tree + 1].firstInner : starts_.back().inner;
  }

  void checkTrees() const
  {
    constexpr std::uint64_t maxNodes = std::numeric_limits<unsigned int>::max();
    for (std::size_t t = 0; t < trees_.size(); ++t)
    {
      const std::uint64_t nodes = 8 * (endOfInner(t) - trees_[t].firstInner) + 1;
      if (nodes > maxNodes)
      {
        throw Error("tree " + std::to_string(t) + ": " + std::to_string(nodes) + " nodes, allowed " +
          std::to_string(maxNodes) + ", the most of a vtkHyperTree");
      }
    }
  }

  void makeTrees(vtkHyperTreeGrid* grid) const
  {
    for (std::size_t t = 0; t < trees_.size(); ++t)
    {
      const auto [place, first] = trees_[t];
      vtkIdType number = 0;
      grid->GetIndexFromLevelZeroCoordinates(number, static_cast<unsigned int>(place[0]),
        static_cast<unsigned int>(place[1]), static_cast<unsigned int>(place[2]));
      vtkHyperTree* const tree = grid->GetTree(number, true);
      const auto start = static_cast<vtkIdType>(t + 8 * first);
      tree->SetGlobalIndexStart(start);
      reserveNodes(tree, static_cast<vtkIdType>(8 * (endOfInner(t) - first) + 1));
      for (std::uint64_t n = first; n < endOfInner(t); ++n)
      {
        tree->SubdivideLeaf(inner_[n].node - start, inner_[n].level);
      }
    }
  }

  vtkIdType firstChild(std::uint64_t n) const { return static_cast<vtkIdType>(inner_[n].tree + 8 * n + 1); }

  void mask(vtkHyperTreeGrid* grid) const
  {
    vtkSmartPointer<vtkBitArray> bits;
    for (std::uint64_t n = 0; n < starts_.back().inner; ++n)
    {
      for (unsigned missing = ~inner_[n].present & 0xffu; missing != 0; missing &= missing - 1)
      {
        if (!bits)
        {
          bits = vtkSmartPointer<vtkBitArray>::New();
          bits->SetNumberOfValues(nodeCount());
          std::fill_n(bits->GetPointer(0), (nodeCount() + 7) / 8, static_cast<unsigned char>(0));
        }
        bits->SetValue(firstChild(n) + std::countr_zero(missing), 1);
      }
    }
    if (bits)
    {
      grid->SetMask(bits);
    }
  }

  /// From the children up: those that a part has all of in parallel, the others after them.
  void fillInner() const
  {
    const auto fill = [&](std::uint64_t n) {
      for (const auto& filler : fillers_)
      {
        fillFamily(*filler, inner_[n].node, firstChild(n), inner_[n].present);
      }
    };
    std::vector<std::vector<std::uint64_t>> open(parts_.size()); // by part, from the deepest up
    parts_.forEach([&](std::size_t p) {
      const std::size_t next = parts_.end(p);
      const int firstDepth = next < cells_.size() ? cells_.firstDepth(next) : 0;
      for (int d = firstDepth; d-- > cells_.padding();)
      {
        if (starts_[p + 1].path[d] >= starts_[p].inner)
        {
          open[p].push_back(starts_[p + 1].path[d]);
        }
      }
      auto skipped = open[p].begin();
      for (std::uint64_t n = starts_[p + 1].inner; n-- > starts_[p].inner;)
      {
        if (skipped != open[p].end() && *skipped == n)
        {
          ++skipped;
        }
        else
        {
          fill(n);
        }
      }
    });
    for (std::size_t p = parts_.size(); p-- > 0;)
    {
      for (const std::uint64_t n : open[p])
      {
        fill(n);
      }
    }
  }

  const Cells& cells_;
  Parts parts_;
  std::vector<Start> starts_; // of each part, and the end
  std::vector<std::unique_ptr<CellArrayFiller>> fillers_;
  LargeArray<Inner> inner_; // of all trees in depth-first order
  std::vector<Tree> trees_;
};

} // namespace treeamr

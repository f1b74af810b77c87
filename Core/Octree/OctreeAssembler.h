// Writes an octree in parallel. Its leaves in Morton order are cut into stretches: one pass counts the nodes
// that each stretch starts, running sums over the counts give their places, a second pass writes them.
#pragma once

#include "Octree/Octree.h"

#include <array>
#include <memory>
#include <vector>

namespace treeamr
{

/// How many nodes a stretch starts, by depth. A node starts where its first leaf does.
struct NodeCounts
{
  std::array<std::uint64_t, Octree::maxDepth + 1> inner{};
  std::array<std::uint64_t, Octree::maxDepth + 1> leaf{};

  void startInner(int depth, int /*octant*/) noexcept { ++inner[depth]; }
  void startLeaf(int depth, int /*octant*/) noexcept { ++leaf[depth]; }
};

/// The only writer of Octree's storage.
class OctreeAssembler
{
public:
  /// counts: of each stretch, in Morton order.
  OctreeAssembler(RootGrid grid, std::vector<NodeCounts> counts, bool mayHaveGhosts);

  const Octree& octree() const noexcept { return *octree_; }

  /// Takes the nodes of one stretch, parents before their children and siblings in the order of octants,
  /// except that leaves need not wait for the inner nodes before them. Different stretches in different
  /// threads.
  class Writer
  {
  public:
    Writer(OctreeAssembler& assembler, std::size_t stretch) noexcept;
    void startInner(int depth, int octant) noexcept
    {
      addToParent(depth, octant, false);
      parent_[depth + 1] = next_.inner[depth]++;
      table_.start(parent_[depth + 1], next_.inner[depth + 1], next_.leaf[depth + 1]);
    }
    /// Returns the leaf's index.
    std::uint64_t startLeaf(int depth, int octant) noexcept
    {
      addToParent(depth, octant, true);
      return next_.leaf[depth]++;
    }
    void markGhost(std::uint64_t leaf) noexcept;

  private:
    void addToParent(int depth, int octant, bool asLeaf) noexcept
    {
      if (parent_[depth] == startedBefore)
      {
        late_[depth].add(octant, asLeaf);
      }
      else
      {
        table_.addChild(parent_[depth], octant, asLeaf);
      }
    }
    static constexpr std::uint64_t startedBefore = ~std::uint64_t(0);

    Octree::Table& table_;
    std::vector<std::uint64_t>& ghosts_;
    std::array<ChildMasks, Octree::maxDepth + 1>& late_;
    NodeCounts next_;                                          // place of the next node
    std::array<std::uint64_t, Octree::maxDepth + 1> parent_{}; // of the next node of a depth
  };

  /// After all stretches are written.
  std::shared_ptr<const Octree> finish();

private:
  void findGhostsBelow();

  std::shared_ptr<Octree> octree_;
  std::vector<NodeCounts> first_; // by stretch: places of its first nodes
  /// By stretch and depth: children of a node that an earlier stretch started, which may be writing it.
  std::vector<std::array<ChildMasks, Octree::maxDepth + 1>> late_;
};

} // namespace treeamr

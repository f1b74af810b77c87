// The trees of a Source (OctreeBuilder.h) in Morton order and the two walks over them: the first finds of
// what kind the nodes are and cuts the work into stretches (OctreeAssembler.h), whole trees, subtrees of a
// large tree or a single node above such subtrees; the second writes them.
#pragma once

#include "Error.h"
#include "Octree/OctreeAssembler.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <string>
#include <vector>

namespace treeamr::detail
{

/// Whether p comes before q in Morton order, x fastest. The axis with the highest differing bit decides; of
/// equals, the later (slower) axis.
inline bool mortonLess(const std::array<Coord, 3>& p, const std::array<Coord, 3>& q) noexcept
{
  std::uint64_t deciding = 0;
  bool less = false;
  for (int a = 0; a < 3; ++a)
  {
    const auto difference = static_cast<std::uint64_t>(p[a] ^ q[a]);
    if (difference != 0 && std::bit_width(difference) >= std::bit_width(deciding))
    {
      deciding = difference;
      less = p[a] < q[a];
    }
  }
  return less;
}

/// A source's trees that have cells, in Morton order, and the walks over them.
template <class Source>
class Forest
{
public:
  using Handle = typename Source::Handle;

  /// A part of the work, in Morton order. A root brings the nodes above it that no earlier root has brought.
  struct Stretch
  {
    enum class Extent
    {
      Trees, // firstRoot up to endRoot
      Subtree,
      OneNode // and those of its children that are leaves
    };
    Extent extent = Extent::Trees;
    std::size_t firstRoot = 0;
    std::size_t endRoot = 0;
    Handle node{}; // of a subtree or one node
    int depth = 0;
    int octant = 0;
    std::vector<ChildMasks> masks; // of the inner nodes, parents first
    NodeCounts counts;
  };

  Forest(const RootGrid& grid, const Source& source)
    : source_(source)
    , padding_(grid.paddingDepth())
    , maxLevel_(grid.maxLevel())
  {
    for (std::size_t i = 0; i < source.rootCount(); ++i)
    {
      if (source.kind(source.root(i)) != NodeKind::None)
      {
        roots_.push_back(i);
      }
    }
    const auto less = [&](std::size_t a, std::size_t b) {
      return mortonLess(source.rootPlace(a), source.rootPlace(b));
    };
    if (!std::is_sorted(roots_.begin(), roots_.end(), less))
    {
      tbb::parallel_sort(roots_.begin(), roots_.end(), less);
    }
    // Cut so many times that several hundred stretches come out where trees are refined evenly.
    constexpr std::size_t wanted = 256;
    runLength_ = std::max<std::size_t>(1, roots_.size() / wanted);
    for (std::size_t nodes = roots_.size(); nodes < wanted && cutLevels_ < manyCuts; nodes *= 8)
    {
      ++cutLevels_;
    }
  }

  std::vector<Stretch> stretches() const { return cutTrees(0, roots_.size()); }

  /// Writes a stretch; visitLeaf(index, handle) is called at each leaf.
  template <class VisitLeaf>
  void write(const Stretch& stretch, OctreeAssembler::Writer& writer, const VisitLeaf& visitLeaf) const
  {
    const ChildMasks* next = stretch.masks.data();
    switch (stretch.extent)
    {
      case Stretch::Extent::Trees:
        for (std::size_t r = stretch.firstRoot; r < stretch.endRoot; ++r)
        {
          startAbove(r, writer);
          const Handle root = source_.root(roots_[r]);
          if (source_.kind(root) == NodeKind::Leaf)
          {
            visitLeaf(writer.startLeaf(padding_, rootOctant(r)), root);
          }
          else
          {
            writeSubtree(root, padding_, rootOctant(r), next, writer, visitLeaf);
          }
        }
        return;
      case Stretch::Extent::Subtree:
        writeSubtree(stretch.node, stretch.depth, stretch.octant, next, writer, visitLeaf);
        return;
      case Stretch::Extent::OneNode:
        if (stretch.depth == padding_)
        {
          startAbove(stretch.firstRoot, writer);
        }
        writer.startInner(stretch.depth, stretch.octant);
        for (int o = 0; o < 8; ++o)
        {
          if (next->isLeaf(o))
          {
            visitLeaf(writer.startLeaf(stretch.depth + 1, o), source_.child(stretch.node, o));
          }
        }
    }
  }

private:
  static constexpr int manyCuts = 3;
  /// A stretch with more inner nodes is cut, if need be after they were counted in vain.
  static constexpr std::size_t stretchNodes = std::size_t(1) << 18;

  int rootOctant(std::size_t r) const { return octantAbove(source_.rootPlace(roots_[r]), 0); }

  /// The nodes of the padding that start with a root.
  template <class Sink>
  void startAbove(std::size_t r, Sink& sink) const
  {
    const std::array<Coord, 3> place = source_.rootPlace(roots_[r]);
    int depth = 0;
    if (r > 0)
    {
      const std::array<Coord, 3> before = source_.rootPlace(roots_[r - 1]);
      std::uint64_t differing = 0;
      for (int a = 0; a < 3; ++a)
      {
        differing |= static_cast<std::uint64_t>(place[a] ^ before[a]);
      }
      depth = padding_ + 1 - static_cast<int>(std::bit_width(differing));
    }
    for (; depth < padding_; ++depth)
    {
      sink.startInner(depth, octantAbove(place, padding_ - depth));
    }
  }

  template <class VisitLeaf>
  void writeSubtree(const Handle& node, int depth, int octant, const ChildMasks*& next,
    OctreeAssembler::Writer& writer, const VisitLeaf& visitLeaf) const
  {
    const ChildMasks masks = *next++;
    writer.startInner(depth, octant);
    for (int o = 0; o < 8; ++o)
    {
      if (masks.isLeaf(o))
      {
        visitLeaf(writer.startLeaf(depth + 1, o), source_.child(node, o));
      }
      else if (masks.isInner(o))
      {
        writeSubtree(source_.child(node, o), depth + 1, o, next, writer, visitLeaf);
      }
    }
  }

  /// Counts an inner node and its leaf children; children[o] of kind None may hold anything.
  ChildMasks classify(
    const Handle& node, int depth, std::array<Handle, 8>& children, NodeCounts& counts) const
  {
    if (depth - padding_ >= maxLevel_)
    {
      throw Error("octree: cells deeper than level " + std::to_string(maxLevel_) +
        ", the deepest that 64-bit lattice coordinates allow on this root grid");
    }
    counts.startInner(depth, 0);
    ChildMasks masks;
    for (int o = 0; o < 8; ++o)
    {
      children[o] = source_.child(node, o);
      const NodeKind kind = source_.kind(children[o]);
      if (kind != NodeKind::None)
      {
        masks.add(o, kind == NodeKind::Leaf);
      }
    }
    if (masks.exists == 0)
    {
      throw Error("octree: a source's inner node at depth " + std::to_string(depth) + " has no children");
    }
    counts.leaf[depth + 1] += bitCount(masks.leaf);
    return masks;
  }

  /// False when the stretch becomes too long.
  bool countSubtree(const Handle& node, int depth, Stretch& stretch) const
  {
    if (stretch.masks.size() >= stretchNodes)
    {
      return false;
    }
    std::array<Handle, 8> children;
    const ChildMasks masks = classify(node, depth, children, stretch.counts);
    stretch.masks.push_back(masks);
    for (int o = 0; o < 8; ++o)
    {
      if (masks.isInner(o) && !countSubtree(children[o], depth + 1, stretch))
      {
        return false;
      }
    }
    return true;
  }

  bool countTrees(Stretch& stretch) const
  {
    for (std::size_t r = stretch.firstRoot; r < stretch.endRoot; ++r)
    {
      startAbove(r, stretch.counts);
      const Handle root = source_.root(roots_[r]);
      if (source_.kind(root) == NodeKind::Leaf)
      {
        stretch.counts.startLeaf(padding_, 0);
      }
      else if (!countSubtree(root, padding_, stretch))
      {
        return false;
      }
    }
    return true;
  }

  std::vector<Stretch> cutTrees(std::size_t first, std::size_t end) const
  {
    std::vector<Stretch> list;
    const bool single = end - first == 1;
    const Handle root = single ? source_.root(roots_[first]) : Handle{};
    if (single && cutLevels_ > 0 && source_.kind(root) == NodeKind::Inner)
    {
      return cutNode(root, padding_, rootOctant(first), first, cutLevels_);
    }
    if (end - first <= runLength_)
    {
      Stretch stretch;
      stretch.firstRoot = first;
      stretch.endRoot = end;
      if (countTrees(stretch))
      {
        list.push_back(std::move(stretch));
        return list;
      }
      if (single)
      {
        return cutNode(root, padding_, rootOctant(first), first, manyCuts);
      }
    }
    const std::size_t middle = first + (end - first) / 2;
    std::vector<Stretch> upper;
    tbb::parallel_invoke([&] { list = cutTrees(first, middle); }, [&] { upper = cutTrees(middle, end); });
    std::move(upper.begin(), upper.end(), std::back_inserter(list));
    return list;
  }

  /// Of an inner node, cut into its children, these likewise, `levels` times at least.
  std::vector<Stretch> cutNode(const Handle& node, int depth, int octant, std::size_t root, int levels) const
  {
    std::vector<Stretch> list(1);
    list[0].node = node;
    list[0].depth = depth;
    list[0].octant = octant;
    list[0].firstRoot = root;
    if (levels == 0)
    {
      list[0].extent = Stretch::Extent::Subtree;
      if (countSubtree(node, depth, list[0]))
      {
        return list;
      }
      list[0].counts = {};
      list[0].masks = {};
      levels = manyCuts;
    }
    list[0].extent = Stretch::Extent::OneNode;
    if (depth == padding_)
    {
      startAbove(root, list[0].counts);
    }
    std::array<Handle, 8> children;
    const ChildMasks masks = classify(node, depth, children, list[0].counts);
    list[0].masks.push_back(masks);
    std::array<std::vector<Stretch>, 8> below;
    tbb::parallel_for(0, 8, [&](int o) {
      if (masks.isInner(o))
      {
        below[o] = cutNode(children[o], depth + 1, o, root, levels - 1);
      }
    });
    for (auto& part : below)
    {
      std::move(part.begin(), part.end(), std::back_inserter(list));
    }
    return list;
  }

  const Source& source_;
  int padding_;
  int maxLevel_;
  std::vector<std::size_t> roots_; // the source's numbers of its trees
  std::size_t runLength_;
  int cutLevels_ = 0; // of every tree
};

} // namespace treeamr::detail

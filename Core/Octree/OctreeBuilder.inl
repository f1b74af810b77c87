// Breadth-first construction: each level is a frontier of the inner nodes' handles, so the only thing held
// beside the result is one level's handles.
#pragma once

#include "Error.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <string>

namespace treeamr
{

/// Appends inner nodes to an octree in breadth-first order. The only writer of Octree's storage.
class OctreeAssembler
{
public:
  struct Masks
  {
    std::uint8_t exists = 0;
    std::uint8_t leaf = 0;
  };

  explicit OctreeAssembler(RootGrid grid)
    : octree_(std::make_shared<Octree>(Octree(std::move(grid))))
  {
  }
  Octree& octree() noexcept { return *octree_; }
  void setRoot(NodeRef root) noexcept { octree_->root_ = root; }
  /// All inner nodes of one depth, in order.
  void append(const std::vector<Masks>& masks);
  void setLeafDepth(int depth) noexcept;
  void countRootLeaf() noexcept { octree_->leafCount_ = 1; }
  void allocateGhosts() { octree_->ghost_.assign(octree_->leafCount_, false); }
  void setGhost(std::uint64_t leaf) { octree_->ghost_[leaf] = true; }
  std::shared_ptr<const Octree> finish();

private:
  std::shared_ptr<Octree> octree_;
  std::uint64_t nextInner_ = 1; // the root is inner node 0
  std::uint64_t nextLeaf_ = 0;
};

namespace detail
{

/// A source's nodes and the padding above its roots as one tree.
template <class Source>
class PaddedSource
{
public:
  struct Handle
  {
    std::array<std::int32_t, 3> padding; // index at its depth; used above the roots only
    typename Source::Handle node;
  };

  PaddedSource(const RootGrid& grid, const Source& source)
    : grid_(grid)
    , source_(source)
  {
  }

  NodeKind root(Handle& handle) const
  {
    handle = {};
    return classify(handle, 0);
  }

  NodeKind child(const Handle& parent, int parentDepth, int octant, Handle& handle) const
  {
    handle = parent;
    if (parentDepth >= grid_.paddingDepth())
    {
      handle.node = source_.child(parent.node, octant);
      return source_.kind(handle.node);
    }
    for (int a = 0; a < 3; ++a)
    {
      handle.padding[a] = 2 * parent.padding[a] + (octant >> a & 1);
    }
    return classify(handle, parentDepth + 1);
  }

private:
  NodeKind classify(Handle& handle, int depth) const
  {
    const int up = grid_.paddingDepth() - depth;
    std::array<Coord, 3> first;
    std::array<Coord, 3> last;
    for (int a = 0; a < 3; ++a)
    {
      first[a] = Coord(handle.padding[a]) << up;
      last[a] = std::min<Coord>(first[a] + (Coord(1) << up), grid_.roots()[a]);
      if (first[a] >= last[a])
      {
        return NodeKind::None;
      }
    }
    if (up == 0)
    {
      return source_.root(first, handle.node) ? source_.kind(handle.node) : NodeKind::None;
    }
    // A block of the padding exists when one of its trees has a cell: no inner node may be empty.
    typename Source::Handle any;
    for (Coord k = first[2]; k < last[2]; ++k)
    {
      for (Coord j = first[1]; j < last[1]; ++j)
      {
        for (Coord i = first[0]; i < last[0]; ++i)
        {
          if (source_.root({ i, j, k }, any) && source_.kind(any) != NodeKind::None)
          {
            return NodeKind::Inner;
          }
        }
      }
    }
    return NodeKind::None;
  }

  const RootGrid& grid_;
  const Source& source_;
};

} // namespace detail

template <class Source>
OctreeAndValues buildOctree(RootGrid grid, const Source& source)
{
  OctreeAssembler assembler(std::move(grid));
  const Octree& octree = assembler.octree();
  const detail::PaddedSource<Source> padded(octree.grid(), source);
  using Handle = typename detail::PaddedSource<Source>::Handle;

  OctreeAndValues result;
  std::vector<std::uint64_t> ghosts;
  std::vector<Handle> frontier(1);
  const NodeKind rootKind = padded.root(frontier[0]);
  if (rootKind == NodeKind::None)
  {
    result.octree = assembler.finish();
    return result;
  }
  assembler.setRoot({ rootKind, 0, 0 });
  if (rootKind == NodeKind::Leaf)
  {
    assembler.countRootLeaf();
    result.values.push_back(source.value(frontier[0].node));
    if (source.ghosts() && source.isGhost(frontier[0].node))
    {
      ghosts.push_back(0);
    }
    frontier.clear();
  }

  std::vector<OctreeAssembler::Masks> masks;
  for (int depth = 0; !frontier.empty(); ++depth)
  {
    if (depth - octree.grid().paddingDepth() >= octree.grid().maxLevel())
    {
      throw Error("octree: cells deeper than level " + std::to_string(octree.grid().maxLevel()) +
        ", the deepest that 64-bit lattice coordinates allow on this root grid");
    }
    masks.assign(frontier.size(), {});
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, frontier.size(), 256), [&](const auto& r) {
      Handle child;
      for (std::size_t i = r.begin(); i < r.end(); ++i)
      {
        for (int o = 0; o < 8; ++o)
        {
          const NodeKind kind = padded.child(frontier[i], depth, o, child);
          masks[i].exists |= static_cast<std::uint8_t>((kind != NodeKind::None) << o);
          masks[i].leaf |= static_cast<std::uint8_t>((kind == NodeKind::Leaf) << o);
        }
      }
    });
    const std::uint64_t firstNode = octree.innerCount();
    const std::uint64_t firstLeaf = octree.leafCount();
    assembler.append(masks);
    if (octree.leafCount() > firstLeaf)
    {
      assembler.setLeafDepth(depth + 1);
    }

    const std::uint64_t nextFirst = octree.innerCount();
    std::uint64_t innerChildren = 0;
    for (const auto& m : masks)
    {
      innerChildren += std::popcount(static_cast<unsigned>(m.exists & ~m.leaf));
    }
    result.values.resize(octree.leafCount());
    std::vector<Handle> next(innerChildren);
    std::vector<std::uint8_t> ghostHere(source.ghosts() ? octree.leafCount() - firstLeaf : 0, 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, frontier.size(), 256), [&](const auto& r) {
      Handle child;
      for (std::size_t i = r.begin(); i < r.end(); ++i)
      {
        const NodeRef node(NodeKind::Inner, depth, firstNode + i);
        for (int o = 0; o < 8; ++o)
        {
          const NodeRef ref = octree.child(node, o);
          if (ref.isNone())
          {
            continue;
          }
          padded.child(frontier[i], depth, o, child);
          if (ref.isInner())
          {
            next[ref.index() - nextFirst] = child;
            continue;
          }
          result.values[ref.index()] = source.value(child.node);
          if (source.ghosts())
          {
            ghostHere[ref.index() - firstLeaf] = source.isGhost(child.node);
          }
        }
      }
    });
    for (std::size_t i = 0; i < ghostHere.size(); ++i)
    {
      if (ghostHere[i])
      {
        ghosts.push_back(firstLeaf + i);
      }
    }
    frontier = std::move(next);
  }
  if (!ghosts.empty())
  {
    assembler.allocateGhosts();
    for (const std::uint64_t leaf : ghosts)
    {
      assembler.setGhost(leaf);
    }
  }
  result.octree = assembler.finish();
  return result;
}

template <class Source>
std::vector<float> gatherLeafValues(const Octree& octree, const Source& source)
{
  const detail::PaddedSource<Source> padded(octree.grid(), source);
  using Handle = typename detail::PaddedSource<Source>::Handle;
  std::vector<float> values(octree.leafCount());
  std::vector<Handle> frontier(1);
  padded.root(frontier[0]);
  if (octree.root().isLeaf())
  {
    values[0] = source.value(frontier[0].node);
  }
  std::uint64_t firstNode = 0;
  for (int depth = 0; firstNode < octree.innerCount(); ++depth)
  {
    const std::uint64_t nextFirst = firstNode + frontier.size();
    std::uint64_t nextEnd = nextFirst;
    for (std::size_t i = frontier.size(); i-- > 0 && nextEnd == nextFirst;)
    {
      for (int o = 0; o < 8; ++o)
      {
        const NodeRef ref = octree.child({ NodeKind::Inner, depth, firstNode + i }, o);
        nextEnd = ref.isInner() ? ref.index() + 1 : nextEnd;
      }
    }
    std::vector<Handle> next(nextEnd - nextFirst);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, frontier.size(), 256), [&](const auto& r) {
      Handle child;
      for (std::size_t i = r.begin(); i < r.end(); ++i)
      {
        for (int o = 0; o < 8; ++o)
        {
          const NodeRef ref = octree.child({ NodeKind::Inner, depth, firstNode + i }, o);
          if (ref.isNone())
          {
            continue;
          }
          padded.child(frontier[i], depth, o, child);
          if (ref.isInner())
          {
            next[ref.index() - nextFirst] = child;
          }
          else
          {
            values[ref.index()] = source.value(child.node);
          }
        }
      }
    });
    firstNode = nextFirst;
    frontier = std::move(next);
  }
  return values;
}

} // namespace treeamr

// The walks of Forest.h between counting and writing.
#pragma once

#include "Octree/Forest.h"

namespace treeamr
{

template <class Source>
OctreeAndValues buildOctree(RootGrid grid, const Source& source)
{
  using Forest = detail::Forest<Source>;
  const Forest forest(grid, source);
  std::vector<typename Forest::Stretch> stretches = forest.stretches();
  std::vector<NodeCounts> counts;
  counts.reserve(stretches.size());
  for (const auto& s : stretches)
  {
    counts.push_back(s.counts);
  }
  OctreeAssembler assembler(std::move(grid), std::move(counts), source.ghosts());
  OctreeAndValues result;
  result.values.resize(assembler.octree().leafCount());
  tbb::parallel_for(std::size_t(0), stretches.size(), [&](std::size_t s) {
    OctreeAssembler::Writer writer(assembler, s);
    forest.write(stretches[s], writer, [&](std::uint64_t leaf, const typename Source::Handle& handle) {
      result.values[leaf] = source.value(handle);
      if (source.ghosts() && source.isGhost(handle))
      {
        writer.markGhost(leaf);
      }
    });
  });
  result.octree = assembler.finish();
  return result;
}

template <class Source, class Visit>
void forEachLeaf(const Octree& octree, const Source& source, const Visit& visit)
{
  using Handle = typename Source::Handle;
  const auto gather = [&](const auto& self, NodeRef node, const Handle& handle, int parallelLevels) -> void {
    if (node.isLeaf())
    {
      visit(node.index(), handle);
      return;
    }
    const auto gatherChild = [&](int o) {
      if (const NodeRef child = octree.child(node, o); !child.isNone())
      {
        self(self, child, source.child(handle, o), parallelLevels - 1);
      }
    };
    if (parallelLevels > 0)
    {
      tbb::parallel_for(0, 8, gatherChild);
      return;
    }
    for (int o = 0; o < 8; ++o)
    {
      gatherChild(o);
    }
  };
  const int padding = octree.grid().paddingDepth();
  tbb::parallel_for(std::size_t(0), source.rootCount(), [&](std::size_t r) {
    const std::array<Coord, 3> place = source.rootPlace(r);
    NodeRef node = octree.root();
    for (int up = padding - 1; up >= 0 && node.isInner(); --up)
    {
      node = octree.child(node, octantAbove(place, up));
    }
    if (!node.isNone())
    {
      gather(gather, node, source.root(r), 3);
    }
  });
}

template <class Source>
LargeVector<float> gatherLeafValues(const Octree& octree, const Source& source)
{
  LargeVector<float> values(octree.leafCount());
  forEachLeaf(octree, source, [&](std::uint64_t leaf, const typename Source::Handle& handle) {
    values[leaf] = source.value(handle);
  });
  return values;
}

} // namespace treeamr

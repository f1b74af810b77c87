// The leaves that a grid counts itself. Private to the module.
#pragma once

#include "HyperTreeGridTopology.h"

#include "Geometry/Octant.h"

namespace treeamr
{

/// Calls visit(place, vertex) for each leaf of a tree that is drawn and no ghost, from a vertex and its place on, also below a
/// depth limit. Places: on any lattice, level 0 at the tree's root. enter(place): of each node on the way, before those in it.
template <class Enter, class Visit>
void forEachOwnLeaf(const HyperTreeGridTopology& topology, const HyperTreeView& tree, vtkIdType vertex,
  const CellId& place, const Enter& enter, const Visit& visit)
{
  if (!topology.exists(tree, vertex) || topology.isGhost(tree, vertex))
  {
    return;
  }
  enter(place);
  if (tree.isLeaf(vertex))
  {
    visit(place, vertex);
    return;
  }
  topology.checkDepth(static_cast<unsigned int>(place.level));
  for (int o = 0; o < 8; ++o)
  {
    const CellId child{ indexOfChild(place.index, o), place.level + 1 };
    forEachOwnLeaf(topology, tree, tree.child(vertex, o), child, enter, visit);
  }
}

/// Of all of a tree.
template <class Visit>
void forEachOwnLeaf(
  const HyperTreeGridTopology& topology, const HyperTreeView& tree, const CellId& root, const Visit& visit)
{
  forEachOwnLeaf(
    topology, tree, 0, root, [](const CellId& /*place*/) {}, visit);
}

} // namespace treeamr

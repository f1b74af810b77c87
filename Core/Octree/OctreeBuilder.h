// Builds an octree from anything that can be asked top-down for its nodes, and from lists of cells.
//
// A Source has
//   using Handle = ...;                                   a trivially copyable name of a node
//   std::size_t rootCount() const;                        how many trees it holds
//   std::array<Coord, 3> rootPlace(std::size_t) const;    a tree's place among the roots, no two alike
//   Handle root(std::size_t) const;                       a tree's root
//   NodeKind kind(const Handle&) const;                   never Inner when no leaf is below
//   Handle child(const Handle&, int octant) const;        of an inner node, children of kind None included
//   float value(const Handle&) const;                     of a leaf
//   bool ghosts() const;                                  whether isGhost() may be true of any leaf
//   bool isGhost(const Handle&) const;                    of a leaf
// and is called from several threads at once. Beside the result a build holds 2 to 4 bytes per inner node.
#pragma once

#include "Octree/Octree.h"

#include <memory>
#include <vector>

namespace treeamr
{

/// One cell of an unsorted list.
struct LeafCell
{
  CellId cell;       // where it is
  float value = 0.f; // finite
};

/// What a Field is made of.
struct OctreeAndValues
{
  std::shared_ptr<const Octree> octree; // never null
  LargeVector<float> values;            // of leaf i
};

/// Builds the topology and gathers the leaves' values on the way. Throws Error.
template <class Source>
OctreeAndValues buildOctree(RootGrid grid, const Source& source);

/// Calls visit(leaf, handle) for each leaf of an octree with its name in a source of the same topology, from several
/// threads.
template <class Source, class Visit>
void forEachLeaf(const Octree& octree, const Source& source, const Visit& visit);

/// The values of another field of the same topology, in the octree's leaf order.
template <class Source>
LargeVector<float> gatherLeafValues(const Octree& octree, const Source& source);

/// From cells in any order; those in Morton order are not sorted again. Throws Error naming the cell when one
/// lies outside the root grid, is deeper than RootGrid::maxLevel(), or overlaps another.
///
/// Beside the cells it needs 8 bytes for each when these lie at most 10 levels below the padded root, 16 for
/// up to 21 levels, else 32; it frees the cells before it needs more.
OctreeAndValues buildOctree(RootGrid grid, std::vector<LeafCell> cells);
/// The same from a LargeVector. A template, so that a list in braces is the former.
template <class Allocator>
OctreeAndValues buildOctree(RootGrid grid, std::vector<LeafCell, Allocator> cells);
extern template OctreeAndValues buildOctree(RootGrid grid, LargeVector<LeafCell> cells);

} // namespace treeamr

#include "Octree/OctreeBuilder.inl"

// Functions that are trilinear in each leaf of a tree, as finite elements have them: free at the corners of leaves, but for
// those that hang on a coarser leaf, where they are what that leaf has there.
#pragma once

#include "Field/Field.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace treeamr::test
{

class CornerFunction
{
public:
  using Vertex = std::array<Coord, 3>; // in half widths of the finest level
  using Point = std::array<double, 3>; // in units of roots

  /// atCorners: at those that do not hang.
  CornerFunction(const std::vector<LeafCell>& cells, std::function<double(const Point&)> atCorners);
  /// The same at random, from -1 to 1.
  CornerFunction(const std::vector<LeafCell>& cells, std::uint32_t seed);

  /// At a vertex that some leaf touches.
  double vertex(const Vertex& v) const;
  /// As in Octant.h.
  std::array<double, 8> corners(const CellId& leaf) const;
  /// At a point of a leaf.
  double value(const CellId& leaf, const Point& p) const;
  /// By how many levels a corner of a leaf hangs on a coarser one; 0: it does not.
  int jumpAt(const CellId& leaf, int corner) const;

  std::shared_ptr<const Field> field(const RootGrid& grid, double offset = 0.) const;

private:
  const CellId& coarsestAround(const Vertex& v) const;

  std::vector<LeafCell> cells_;
  std::function<double(const Point&)> atCorners_;
  int finest_ = 0;
  std::map<std::array<Coord, 4>, CellId> leaves_; // by level and index
  mutable std::map<Vertex, double> known_;
};

/// The leaves of an octree, in their order.
std::vector<CellId> leavesOf(const Octree& octree);

/// A random function on a random tree.
struct CornerCase
{
  RandomTree options;
  std::vector<LeafCell> cells;
  CornerFunction function;
  std::shared_ptr<const Field> field;

  explicit CornerCase(const RandomTree& tree)
    : options(tree)
    , cells(makeRandomTree(tree))
    , function(cells, tree.seed)
    , field(function.field(unitRoots(tree.roots)))
  {
  }
};

} // namespace treeamr::test

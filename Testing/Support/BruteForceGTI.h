// The reconstruction written straight from its definition, with look-ups in a table of cells instead of the
// octree: slow, independent of the code under test, in double precision throughout.
#pragma once

#include "Octree/OctreeBuilder.h"

#include <array>
#include <map>
#include <optional>
#include <vector>

namespace treeamr::test
{

class BruteForceGTI
{
public:
  using Vertex = std::array<Coord, 3>; // in half widths of the finest level
  /// octantRule: Wang et al.'s octant method instead: equal weights, as if all cells were equally far away.
  BruteForceGTI(std::array<int, 3> roots, const std::vector<LeafCell>& cells, bool octantRule = false);

  /// V(v); none where no cell touches v. Sets *gap when a missing cell had a part in it.
  std::optional<double> vertex(const Vertex& v, bool* gap = nullptr) const;
  /// Whether of the cells that V(v) would take values of each has its mirror image along the axis, or both are missing;
  /// false where no cell touches v.
  bool isEven(const Vertex& v, int axis) const;
  /// G(v), as BlockGradients.h defines it; v must touch a cell.
  std::array<double, 3> gradient(const Vertex& v, const RootGrid& grid) const;
  /// The field at a point in units of roots; none outside the cells. On shared planes the upper cell's.
  std::optional<double> value(const std::array<double, 3>& p) const;
  /// The field at a point of the closed box of one leaf, seen from inside that leaf.
  double valueInside(const CellId& leaf, const std::array<double, 3>& p, bool* gap = nullptr) const;

  /// The value of a cell of any level: its own, its mean or that of the leaf that covers it; none without
  /// cells.
  std::optional<double> cellValue(int level, const std::array<Coord, 3>& index) const;
  /// Whether a cell is refined.
  bool isRefined(int level, const std::array<Coord, 3>& index) const;

  /// The leaf around a point in units of roots.
  const CellId* leafAt(const std::array<double, 3>& p) const;

private:
  struct Node
  {
    double sum = 0.;    // value times volume over the leaves below
    double volume = 0.; // covered
    const LeafCell* leaf = nullptr;
  };
  using Key = std::array<Coord, 4>; // level, i, j, k
  const Node* find(int level, const std::array<Coord, 3>& index) const;
  Coord width(int level) const { return Coord(2) << (finest_ - level); }
  /// Level of the coarsest leaf that touches v, beyond the finest when there is none.
  int coarsestAround(const Vertex& v) const;
  /// What a cell of a level gives a vertex that it touches: its value, or the mean of its children there.
  struct Datum
  {
    std::optional<double> value;
    double distance = 0.5; // of its place from the vertex along each axis, in widths of the cell
    bool isWhole = true;   // all of it is there
  };
  Datum datumOf(int level, const std::array<Coord, 3>& index, const Vertex& v) const;

  std::array<int, 3> roots_;
  bool octantRule_;
  int finest_ = 0;
  std::vector<LeafCell> cells_;
  std::map<Key, Node> nodes_;
};

} // namespace treeamr::test

#include "Support/CornerFunction.h"

#include "Geometry/Trilinear.h"
#include "Support/RandomTrees.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <stdexcept>

namespace treeamr::test
{

CornerFunction::CornerFunction(
  const std::vector<LeafCell>& cells, std::function<double(const Point&)> atCorners)
  : cells_(cells)
  , atCorners_(std::move(atCorners))
{
  for (const LeafCell& c : cells_)
  {
    finest_ = std::max(finest_, c.cell.level);
    leaves_[{ c.cell.level, c.cell.index[0], c.cell.index[1], c.cell.index[2] }] = c.cell;
  }
}

CornerFunction::CornerFunction(const std::vector<LeafCell>& cells, std::uint32_t seed)
  : CornerFunction(cells, [random = std::make_shared<std::mt19937>(seed)](const Point&) {
    return std::uniform_real_distribution<double>(-1., 1.)(*random); // called once for each corner
  })
{
}

const CellId& CornerFunction::coarsestAround(const Vertex& v) const
{
  for (int level = 0; level <= finest_; ++level)
  {
    const int widthBits = finest_ - level + 1; // log2 of a cell's half widths of the finest level
    for (int side = 0; side < 8; ++side)
    {
      std::array<Coord, 4> key{ level };
      for (int a = 0; a < 3; ++a)
      {
        key[a + 1] = (v[a] - sideOf(side, a)) >> widthBits;
      }
      if (const auto found = leaves_.find(key); found != leaves_.end())
      {
        return found->second;
      }
    }
  }
  throw std::out_of_range("no leaf touches the vertex");
}

double CornerFunction::vertex(const Vertex& v) const
{
  if (const auto found = known_.find(v); found != known_.end())
  {
    return found->second;
  }
  const CellId& leaf = this->coarsestAround(v);
  const Coord width = Coord(2) << (finest_ - leaf.level);
  std::array<double, 3> place;
  bool isCorner = true;
  for (int a = 0; a < 3; ++a)
  {
    const Coord rest = v[a] - width * leaf.index[a];
    place[a] = static_cast<double>(rest) / static_cast<double>(width);
    isCorner = isCorner && (rest == 0 || rest == width);
  }
  const double unit = std::ldexp(0.5, -finest_); // of roots
  const double value =
    isCorner ? atCorners_({ unit * v[0], unit * v[1], unit * v[2] }) : trilinear(this->corners(leaf), place);
  return known_[v] = value;
}

std::array<double, 8> CornerFunction::corners(const CellId& leaf) const
{
  const Coord width = Coord(2) << (finest_ - leaf.level);
  std::array<double, 8> values;
  for (int c = 0; c < 8; ++c)
  {
    values[c] = this->vertex({ width * (leaf.index[0] + sideOf(c, 0)), width * (leaf.index[1] + sideOf(c, 1)),
      width * (leaf.index[2] + sideOf(c, 2)) });
  }
  return values;
}

double CornerFunction::value(const CellId& leaf, const Point& p) const
{
  std::array<double, 3> place;
  for (int a = 0; a < 3; ++a)
  {
    place[a] = std::ldexp(p[a], leaf.level) - static_cast<double>(leaf.index[a]);
  }
  return trilinear(this->corners(leaf), place);
}

int CornerFunction::jumpAt(const CellId& leaf, int corner) const
{
  Vertex v;
  for (int a = 0; a < 3; ++a)
  {
    v[a] = (leaf.index[a] + sideOf(corner, a)) << (finest_ - leaf.level + 1);
  }
  const CellId& coarsest = this->coarsestAround(v);
  bool isCorner = true;
  for (int a = 0; a < 3; ++a)
  {
    isCorner = isCorner && (v[a] & ((Coord(2) << (finest_ - coarsest.level)) - 1)) == 0;
  }
  return isCorner ? 0 : leaf.level - coarsest.level;
}

std::vector<CellId> leavesOf(const Octree& octree)
{
  std::vector<CellId> leaves(octree.leafCount());
  TreePath root(octree);
  forEachNode(root, [&](const TreePath& path) {
    if (path.node().isLeaf())
    {
      leaves[path.node().index()] = { path.index(), path.depth() - octree.grid().paddingDepth() };
    }
  });
  return leaves;
}

std::shared_ptr<const Field> CornerFunction::field(const RootGrid& grid, double offset) const
{
  const std::shared_ptr<const Octree> octree = buildOctree(grid, cells_).octree;
  std::vector<std::array<float, 8>> corners;
  for (const CellId& leaf : leavesOf(*octree))
  {
    const std::array<double, 8> values = this->corners(leaf);
    std::array<float, 8>& rounded = corners.emplace_back();
    std::transform(values.begin(), values.end(), rounded.begin(),
      [offset](double v) { return static_cast<float>(v - offset); });
  }
  return std::make_shared<const Field>(Field::ofCorners(
    octree, [&](std::uint64_t leaf) { return corners[leaf]; }, offset));
}

} // namespace treeamr::test

#include "Interpolation/BlockGradients.h"

#include "Interpolation/GTIWeights.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace treeamr
{

namespace
{

constexpr std::array<int, 3> cellStride{ 1, 6, 36 };
constexpr std::array<int, 3> pointStride{ 1, 9, 81 };

int pointIndex(const std::array<int, 3>& place) noexcept
{
  return place[0] + pointStride[1] * place[1] + pointStride[2] * place[2];
}

/// The axes along which a vertex is between cells, as a mask: between the cells p / 2 and p / 2 + 1 when its place p is
/// even, in the middle of cell (p + 1) / 2 otherwise.
unsigned axesOf(const std::array<int, 3>& place) noexcept
{
  return static_cast<unsigned>((place[0] & 1) | (place[1] & 1) << 1 | (place[2] & 1) << 2) ^ 7u;
}

/// The first of the cells around a vertex.
int firstCell(const std::array<int, 3>& place) noexcept
{
  return (place[0] + 1) / 2 + cellStride[1] * ((place[1] + 1) / 2) + cellStride[2] * ((place[2] + 1) / 2);
}

/// Corner `part` of those along the axes of a mask, as a mask of sides.
constexpr unsigned sidesOf(unsigned axes, int part)
{
  unsigned sides = 0;
  for (int a = 0; a < 3; ++a)
  {
    if (axes >> a & 1)
    {
      sides |= static_cast<unsigned>(part & 1) << a;
      part >>= 1;
    }
  }
  return sides;
}

/// From the first of the cells around a vertex to that at some sides.
constexpr int cellStep(unsigned sides)
{
  return cornerOffset(static_cast<int>(sides), cellStride);
}

/// The same for all slots between cells along some axes.
template <unsigned Axes>
constexpr std::array<int, 1 << std::popcount(Axes)> cellSteps()
{
  std::array<int, 1 << std::popcount(Axes)> steps{};
  for (int s = 0; s < static_cast<int>(steps.size()); ++s)
  {
    steps[s] = cellStep(sidesOf(Axes, s));
  }
  return steps;
}

/// Of a cell at some sides of a vertex between cells along some axes, the child that touches it, at the same sides along
/// the other axes.
constexpr int touchingChild(unsigned axes, unsigned sides)
{
  return static_cast<int>((sides ^ axes) & 7u);
}

/// Of a mask of sides on which a cell gives a value: along which axes each of them has its mirror image. A bit each.
std::uint8_t evenAxes(unsigned sides) noexcept
{
  constexpr std::array<unsigned, 3> lower{ 0x55, 0x33, 0x0f };
  unsigned axes = 0;
  for (int a = 0; a < 3; ++a)
  {
    axes |= static_cast<unsigned>((sides & lower[a]) == (sides >> (1 << a) & lower[a])) << a;
  }
  return static_cast<std::uint8_t>(axes);
}

/// What the cells around a vertex give to its value.
template <int Dimensions>
class WeightedCells
{
public:
  void add(int slot, double value, bool isRefined) noexcept
  {
    data_[slot] = value;
    present_ |= 1u << slot;
    refined_ |= static_cast<unsigned>(isRefined) << slot;
  }
  double value() const noexcept
  {
    const double* weights = gtiWeightsOf<Dimensions>(refined_);
    double sum = 0.;
    double total = 0.;
    for (unsigned rest = present_; rest != 0; rest &= rest - 1)
    {
      const int slot = std::countr_zero(rest);
      sum += weights[slot] * data_[slot];
      total += weights[slot];
    }
    return present_ == (1u << (1 << Dimensions)) - 1 ? sum : sum / total;
  }

private:
  std::array<double, 1 << Dimensions> data_;
  unsigned present_ = 0;
  unsigned refined_ = 0;
};

} // namespace

GradientEvaluator::GradientEvaluator(const Field& field)
  : field_(field)
  , octree_(field.octree())
  , leafDepth_(Octree::maxDepth + 1)
  , path_(octree_)
  , levels_(std::make_unique_for_overwrite<Level[]>(octree_.innerDepths() + 1))
{
  const RootGrid& grid = octree_.grid();
  const Bounds bounds = grid.bounds();
  for (int a = 0; a < 3 && grid.isUniform(); ++a)
  {
    uniformWidth_[a] = (bounds.max[a] - bounds.min[a]) / grid.roots()[a];
  }
}

double GradientEvaluator::rootWidth(int axis, Coord root) const noexcept
{
  if (uniformWidth_[axis] != 0.)
  {
    return uniformWidth_[axis];
  }
  const RootGrid& grid = octree_.grid();
  root = std::clamp<Coord>(root, 0, grid.roots()[axis] - 1);
  return grid.worldPlane(axis, root + 1, 0) - grid.worldPlane(axis, root, 0);
}

void GradientEvaluator::moveTo(const BlockPath& path, int leafDepth) noexcept
{
  if (leafDepth != leafDepth_)
  {
    leafDepth_ = leafDepth;
    for (int depth = 0; depth <= octree_.innerDepths(); ++depth)
    {
      levels_[depth].node = noNode;
    }
  }
  int common = std::min(path.depth, path_.depth());
  while (path_.around(common)[13].index() != path.node[common])
  {
    --common;
  }
  while (path_.depth() > common)
  {
    path_.ascend();
  }
  while (path_.depth() < path.depth)
  {
    path_.descend(path.octant[path_.depth()]);
  }
}

/// The cells in and around the path's node at a depth.
void GradientEvaluator::gather(int depth, Level& level) const noexcept
{
  const Neighbourhood& around = path_.around(depth);
  const CellKind ofInner = depth + 1 >= leafDepth_ ? OfThisSize : Refined;
  for (int entry = 0; entry < 27; ++entry)
  {
    const NodeRef node = around[entry];
    const int first = 2 * (entry % 3) + cellStride[1] * 2 * (entry / 3 % 3) + cellStride[2] * 2 * (entry / 9);
    if (!node.isInner())
    {
      for (int o = 0; o < 8; ++o)
      {
        const int cell = first + cornerOffset(o, cellStride);
        level.kind[cell] = node.isLeaf() ? Coarse : Missing;
        level.cellValue[cell] = 0.;
      }
      continue;
    }
    const Octree::Children children = octree_.children(node.index());
    for (int o = 0; o < 8; ++o)
    {
      const int cell = first + cornerOffset(o, cellStride);
      const NodeRef child = children.node(o, depth + 1);
      level.kind[cell] = child.isNone() ? Missing : child.isInner() ? ofInner : OfThisSize;
      level.inner[cell] = child.index();
      level.cellValue[cell] = child.isNone() ? 0. : field_.value(child);
    }
  }
}

/// Relative to the first vertex, so that no digits are lost far from the origin.
void GradientEvaluator::measure(int depth, Level& level) const noexcept
{
  const int ofVertices = depth + 2 - octree_.grid().paddingDepth(); // level of their lattice
  for (int a = 0; a < 3; ++a)
  {
    level.at[a][0] = 0.;
    for (int i = 1; i < pointsPerEdge && ofVertices >= 0; ++i)
    {
      const Coord interval = 4 * path_.index(depth)[a] + i - 3;
      level.at[a][i] =
        level.at[a][i - 1] + std::ldexp(this->rootWidth(a, interval >> ofVertices), -ofVertices);
    }
  }
}

/// Of the path's node at a depth.
GradientEvaluator::Level& GradientEvaluator::levelAt(int depth) noexcept
{
  Level& level = levels_[depth];
  const std::uint64_t node = path_.around(depth)[13].index();
  if (level.node != node)
  {
    level.node = node;
    this->gather(depth, level);
    this->measure(depth, level);
    level.known.reset();
    level.gradientKnown.reset();
  }
  return level;
}

/// The value of a vertex, and of what cells it is.
GradientEvaluator::Point GradientEvaluator::pointAt(int depth, const Place& place) noexcept
{
  Level& level = this->levelAt(depth);
  const int index = pointIndex(place);
  if (level.known[index])
  {
    return level.point[index];
  }
  const int cell = firstCell(place);
  Point& point = level.point[index];
  level.known[index] = true;
  if (this->hangs(level, place))
  {
    return point = this->betweenCoarser(depth, place); // asks coarser levels alone: this one keeps its node
  }
  block::forAxes([&]<unsigned Axes>() noexcept {
    if (Axes == axesOf(place))
    {
      point = this->onLattice<Axes>(depth, level, cell);
    }
  });
  return point;
}

/// Of one that does not hang.
template <unsigned Axes>
GradientEvaluator::Point GradientEvaluator::onLattice(
  int depth, const Level& level, int firstCell) const noexcept
{
  constexpr int dimensions = std::popcount(Axes);
  constexpr int slots = 1 << dimensions;
  constexpr std::array<int, slots> steps = cellSteps<Axes>();
  unsigned kinds = 0;
  bool anyLeaf = false;
  double sum = 0.;
  for (int s = 0; s < slots; ++s)
  {
    const int cell = firstCell + steps[s];
    kinds |= level.kind[cell];
    anyLeaf |= level.kind[cell] == OfThisSize;
    sum += level.cellValue[cell];
  }
  if (kinds == OfThisSize)
  {
    return { sum / slots, true, allAxes };
  }
  if (!anyLeaf)
  {
    std::array<NodeRef, 8> around{};
    for (int side = 0; side < 8; ++side)
    {
      const int cell = firstCell + cellStep(static_cast<unsigned>(side) & Axes);
      if (level.kind[cell] == Refined)
      {
        around[side] = octree_.children(level.inner[cell])
                         .node(touchingChild(Axes, static_cast<unsigned>(side)), depth + 2);
      }
    }
    return this->amidFiner(around);
  }
  WeightedCells<dimensions> cells;
  unsigned sides = 0; // that have a value
  for (int s = 0; s < slots; ++s)
  {
    const int cell = firstCell + steps[s];
    if (level.kind[cell] == OfThisSize)
    {
      cells.add(s, level.cellValue[cell], false);
      for (int c = 0; c < 8 / slots; ++c)
      {
        sides |= 1u << (sidesOf(Axes, s) | sidesOf(~Axes, c));
      }
    }
    else if (level.kind[cell] == Refined)
    {
      const Octree::Children children = octree_.children(level.inner[cell]);
      double value = 0.;
      int count = 0;
      for (int c = 0; c < 8 / slots; ++c)
      {
        const unsigned side = sidesOf(Axes, s) | sidesOf(~Axes, c);
        const NodeRef child = children.node(touchingChild(Axes, side), depth + 2);
        if (!child.isNone())
        {
          value += field_.value(child);
          sides |= 1u << side;
          ++count;
        }
      }
      if (count != 0)
      {
        cells.add(s, value / count, true);
      }
    }
  }
  return { cells.value(), true, evenAxes(sides) };
}

/// A vertex that only finer leaves touch: a corner of theirs, at the level of the largest. around: the nodes of one
/// level at its sides.
GradientEvaluator::Point GradientEvaluator::amidFiner(std::array<NodeRef, 8> around) const noexcept
{
  const auto isLeaf = [&](NodeRef node) {
    return node.isLeaf() || (node.isInner() && node.depth() >= leafDepth_);
  };
  while (std::none_of(around.begin(), around.end(), isLeaf))
  {
    bool any = false;
    for (int side = 0; side < 8; ++side)
    {
      if (around[side].isInner())
      {
        any = true;
        around[side] = octree_.child(around[side], 7 - side);
      }
    }
    if (!any)
    {
      return { 0., false, 0 };
    }
  }
  WeightedCells<3> cells;
  unsigned sides = 0; // that have a value
  for (int side = 0; side < 8; ++side)
  {
    const NodeRef node = around[side];
    const bool isRefined = node.isInner() && !isLeaf(node);
    const NodeRef data = isRefined ? octree_.child(node, 7 - side) : node;
    if (!data.isNone())
    {
      cells.add(side, field_.value(data), isRefined);
      sides |= 1u << side;
    }
  }
  return { cells.value(), true, evenAxes(sides) };
}

/// Calls f(place) for the vertices of the next coarser level that one lies halfway between, and returns their number.
template <class F>
int GradientEvaluator::forCoarser(int depth, const Place& place, const F& f) noexcept
{
  const int octant = octantAbove(path_.index(depth), 0);
  int count = 0;
  for (int corner = 0; corner < 8; ++corner)
  {
    Place coarser;
    bool isOne = true;
    for (int a = 0; a < 3; ++a)
    {
      const int twice = place[a] + 2 + 4 * sideOf(octant, a); // from the first vertex of the coarser level
      coarser[a] = (twice + sideOf(corner, a)) / 2;
      isOne = isOne && (twice % 2 != 0 || sideOf(corner, a) == 0);
    }
    if (isOne)
    {
      f(coarser);
      ++count;
    }
  }
  return count;
}

/// One of the coarser vertices may hang, too.
GradientEvaluator::Point GradientEvaluator::betweenCoarser(int depth, const Place& place) noexcept
{
  Point sum{ 0., true, allAxes };
  const int count = this->forCoarser(depth, place, [&](const Place& coarser) {
    const Point point = this->pointAt(depth - 1, coarser);
    sum.value += point.value;
    sum.evenAxes &= point.evenAxes;
  });
  sum.value /= count;
  return sum;
}

/// Of a vertex of the node itself.
Vec3 GradientEvaluator::gradientAt(int depth, const Place& place) noexcept
{
  Level& level = this->levelAt(depth);
  const int index = block::vertexIndex(place[0] - 2, place[1] - 2, place[2] - 2);
  if (!level.gradientKnown[index])
  {
    Vec3 gradient{};
    if (this->hangs(level, place))
    {
      const int count = this->forCoarser(depth, place, [&](const Place& coarser) {
        const Vec3 one = this->gradientAt(depth - 1, coarser);
        for (int a = 0; a < 3; ++a)
        {
          gradient[a] += one[a];
        }
      });
      for (double& slope : gradient)
      {
        slope /= count;
      }
    }
    else
    {
      for (int a = 0; a < 3; ++a)
      {
        gradient[a] = this->slopeAt(depth, a, place);
      }
    }
    level.gradient[index] = gradient;
    level.gradientKnown[index] = true;
  }
  return level.gradient[index];
}

bool GradientEvaluator::hangs(const Level& level, const Place& place) const noexcept
{
  const unsigned axes = axesOf(place);
  const int first = firstCell(place);
  unsigned kinds = 0;
  for (unsigned sides = axes;; sides = (sides - 1) & axes)
  {
    kinds |= level.kind[first + cellStep(sides)];
    if (sides == 0)
    {
      return kinds & Coarse;
    }
  }
}

double GradientEvaluator::slopeAt(int depth, int axis, const Place& place) noexcept
{
  const auto pointAlong = [&](int step) {
    Place along = place;
    along[axis] += step;
    return this->pointAt(depth, along);
  };
  const auto slope = [&](int low, int high) {
    const auto& at = levels_[depth].at[axis];
    return (pointAlong(high).value - pointAlong(low).value) /
      (at[place[axis] + high] - at[place[axis] + low]);
  };
  const auto isEven = [&](int step) { return pointAlong(step).evenAxes >> axis & 1; };
  if (isEven(-2) && isEven(2))
  {
    return slope(-2, 2);
  }
  const auto isThere = [&](int step) { return pointAlong(step).isThere; };
  const auto outermost = [&](const auto& counts) {
    std::array<int, 2> steps{ -2, 2 };
    while (steps[0] < steps[1] && !counts(steps[0]))
    {
      ++steps[0];
    }
    while (steps[0] < steps[1] && !counts(steps[1]))
    {
      --steps[1];
    }
    return steps;
  };
  const std::array<int, 2> even = outermost(isEven);
  // A cell touches the vertex, and so two of the points.
  const auto [low, high] = even[0] < even[1] ? even : outermost(isThere);
  return slope(low, high);
}

void GradientEvaluator::compute(
  const BlockPath& path, BlockCells cells, std::uint64_t octants, BlockGradients& gradients) noexcept
{
  this->moveTo(path, cells == BlockCells::Means ? path.depth + 1 : Octree::maxDepth + 1);
  std::bitset<block::vertexCount> wanted;
  for (; octants != 0; octants &= octants - 1)
  {
    const int octant = std::countr_zero(octants);
    for (int corner = 0; corner < 8; ++corner)
    {
      wanted.set(block::vertexIndex(octant & 3, octant >> 2 & 3, octant >> 4) +
        cornerOffset(corner, block::vertexStride));
    }
  }
  for (int v = 0; v < block::vertexCount; ++v)
  {
    if (wanted[v])
    {
      gradients[v] = this->gradientAt(path.depth, { v % 5 + 2, v / 5 % 5 + 2, v / 25 + 2 });
    }
  }
}

} // namespace treeamr

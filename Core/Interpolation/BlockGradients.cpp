#include "Interpolation/BlockGradients.h"

#include "Interpolation/GTIWeights.h"
#include "Octree/Coverage.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>

namespace treeamr
{

namespace
{

constexpr std::array<int, 3> cellStride{ 1, 6, 36 };
constexpr std::array<int, 3> pointStride{ 1, 9, 81 };

/// Of a point of the lattice: where it is, and the cells around it.
struct PointPlace
{
  std::array<std::uint8_t, 3> at;
  std::uint8_t axes;      // mask of those along which it is between cells
  std::uint8_t firstCell; // around it
  std::uint8_t firstBit;  // that one's in the mask of its layer
  std::uint8_t firstLayer;
};

/// Along an axis, point p is between the cells p / 2 and p / 2 + 1 when p is even, else in the middle of cell
/// (p + 1) / 2.
constexpr std::array<PointPlace, 729> pointPlaces = [] {
  std::array<PointPlace, 729> places{};
  for (int p = 0; p < 729; ++p)
  {
    const std::array<int, 3> at{ p % 9, p / 9 % 9, p / 81 };
    int cell = 0;
    int axes = 0;
    for (int a = 0; a < 3; ++a)
    {
      places[p].at[a] = static_cast<std::uint8_t>(at[a]);
      axes |= (at[a] % 2 == 0) << a;
      cell += cellStride[a] * ((at[a] + 1) / 2);
    }
    places[p].axes = static_cast<std::uint8_t>(axes);
    places[p].firstCell = static_cast<std::uint8_t>(cell);
    places[p].firstBit = static_cast<std::uint8_t>(cell % 36);
    places[p].firstLayer = static_cast<std::uint8_t>(cell / 36);
  }
  return places;
}();

/// Whether any of the cells around a point is in a mask.
template <class CellMask>
bool touches(const CellMask& mask, const PointPlace& place) noexcept
{
  constexpr std::array<std::uint64_t, 4> inLayer{ 0b1, 0b11, 0b1000001, 0b11000011 };
  const std::uint64_t cells =
    mask[place.firstLayer] | ((place.axes & 4) != 0 ? mask[place.firstLayer + 1] : 0);
  return (cells >> place.firstBit & inLayer[place.axes & 3]) != 0;
}

/// Along an axis from 6 cells to 9 points, of `Inner` numbers each. between: of two cells.
template <int Inner, class Number, class Between>
void cellsToPoints(const Number* cells, Number* points, const Between& between) noexcept
{
  for (int p = 0; p < 9; ++p)
  {
    const Number* first = cells + Inner * ((p + 1) / 2);
    for (int i = 0; i < Inner; ++i)
    {
      points[Inner * p + i] = p % 2 == 1 ? first[i] : between(first[i], first[i + Inner]);
    }
  }
}

/// The same along all axes.
template <class Number, class Between>
void cellsToPoints(
  const std::array<Number, 216>& cells, std::array<Number, 729>& points, const Between& between) noexcept
{
  std::array<Number, 9 * 36> alongZ;
  std::array<Number, 81 * 6> alongZY;
  cellsToPoints<36>(cells.data(), alongZ.data(), between);
  for (int z = 0; z < 9; ++z)
  {
    cellsToPoints<6>(alongZ.data() + 36 * z, alongZY.data() + 54 * z, between);
  }
  for (int row = 0; row < 81; ++row)
  {
    cellsToPoints<1>(alongZY.data() + 6 * row, points.data() + 9 * row, between);
  }
}

constexpr int pointOfVertex(int vertex)
{
  return vertex % 5 + 2 + pointStride[1] * (vertex / 5 % 5 + 2) + pointStride[2] * (vertex / 25 + 2);
}

constexpr int vertexOfPoint(int point)
{
  return point % 9 - 2 + 5 * (point / 9 % 9 - 2) + 25 * (point / 81 - 2);
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
  , hasAllCells_(hasAllCells(octree_))
  , leafDepth_(Octree::maxDepth + 1)
  , corners_(field.corners() ? std::make_optional<CornerGradients>(field) : std::nullopt)
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

void GradientEvaluator::setLeafDepth(int leafDepth) noexcept
{
  if (leafDepth != leafDepth_)
  {
    leafDepth_ = leafDepth;
    for (int depth = 0; depth <= octree_.innerDepths(); ++depth)
    {
      levels_[depth].node = noNode;
    }
  }
}

void GradientEvaluator::moveTo(const BlockPath& path) noexcept
{
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
  const bool takesInner = depth + 1 >= leafDepth_;
  const float* leaves = field_.leafValues().data();
  level.coarse = level.special = {};
  level.isComplete = hasAllCells_;
  for (int entry = 0; entry < 27; ++entry)
  {
    const NodeRef node = around[entry];
    const int z = entry / 9;
    const int firstBit = 2 * (entry % 3) + cellStride[1] * 2 * (entry / 3 % 3);
    const int first = firstBit + cellStride[2] * 2 * z;
    const auto add = [&](CellMask& mask, unsigned octants) {
      const auto layer = [&](unsigned four) {
        return static_cast<std::uint64_t>((four & 3) | (four & 12) << 4) << firstBit;
      };
      mask[2 * z] |= layer(octants & 15);
      mask[2 * z + 1] |= layer(octants >> 4);
    };
    if (!node.isInner())
    {
      add(level.special, 0xff);
      add(level.coarse, node.isLeaf() ? 0xff : 0);
      level.isComplete = level.isComplete && node.isLeaf();
      for (int o = 0; o < 8; ++o)
      {
        level.cellValue[first + cornerOffset(o, cellStride)] = 0.;
        level.inner[first + cornerOffset(o, cellStride)] = noNode;
      }
      continue;
    }
    const Octree::Children children = octree_.children(node.index());
    if (children.allLeaves())
    {
      for (int o = 0; o < 8; ++o)
      {
        level.cellValue[first + cornerOffset(o, cellStride)] = leaves[children.firstLeaf + o];
      }
      continue;
    }
    add(level.special, 0xff & ~(takesInner ? children.exists : children.leaf));
    for (int o = 0; o < 8; ++o)
    {
      const int cell = first + cornerOffset(o, cellStride);
      const NodeRef child = children.node(o, depth + 1);
      level.inner[cell] = child.isInner() ? child.index() : noNode;
      level.cellValue[cell] = child.isNone() ? 0. : field_.relative(child);
    }
  }
  // The node's own children are the cells 2 and 3 along each axis.
  constexpr std::uint64_t own = std::uint64_t(0b1100001100) << 2 * cellStride[1];
  level.drawn = {};
  for (const int z : { 2, 3 })
  {
    level.drawn[z] = own & ~level.special[z];
  }
}

/// Relative to the first point, so that no digits are lost far from the origin.
void GradientEvaluator::measure(int depth, Level& level) const noexcept
{
  const int ofVertices = depth + 2 - octree_.grid().paddingDepth(); // level of their lattice
  const double perRoot = std::ldexp(1., -std::max(ofVertices, 0));
  for (int a = 0; a < 3; ++a)
  {
    level.at[a][0] = 0.;
    for (int i = 1; i < pointsPerEdge && ofVertices >= 0; ++i)
    {
      const Coord interval = 4 * path_.index(depth)[a] + i - 3;
      level.at[a][i] = level.at[a][i - 1] + perRoot * this->rootWidth(a, interval >> ofVertices);
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
    level.vertices = nullptr;
    this->gather(depth, level);
    this->measure(depth, level);
    this->meanCells(level);
    level.hasSpecial = std::ranges::any_of(level.special, [](std::uint64_t mask) { return mask != 0; });
    level.gradientKnown.reset();
  }
  return level;
}

/// The values of the points that no special cell touches: of leaves of one size all around.
void GradientEvaluator::meanCells(Level& level) const noexcept
{
  cellsToPoints(level.cellValue, level.value, [](double a, double b) { return 0.5 * (a + b); });
  constexpr std::uint8_t regular = isKnown | isThere | isEven;
  std::array<std::uint8_t, cellCount> cells;
  for (int cell = 0; cell < cellCount; ++cell)
  {
    cells[cell] = (level.special[cell / 36] >> cell % 36 & 1) != 0 ? std::uint8_t(unknown) : regular;
  }
  cellsToPoints(cells, level.state, [](std::uint8_t a, std::uint8_t b) -> std::uint8_t { return a & b; });
}

/// Calls f<axes>() for a mask that is known when the program runs, and returns what it does.
template <class F>
auto withAxes(unsigned axes, const F& f) noexcept
{
  switch (axes)
  {
    case 0:
      return f.template operator()<0>();
    case 1:
      return f.template operator()<1>();
    case 2:
      return f.template operator()<2>();
    case 3:
      return f.template operator()<3>();
    case 4:
      return f.template operator()<4>();
    case 5:
      return f.template operator()<5>();
    case 6:
      return f.template operator()<6>();
    default:
      return f.template operator()<7>();
  }
}

/// Of a point of the path's node at a depth, whose level it is.
GradientEvaluator::Value GradientEvaluator::valueAt(int depth, Level& level, int point) noexcept
{
  return level.state[point] != unknown ? Value{ level.value[point], level.state[point] }
                                       : this->valueBesideSpecial(depth, level, point);
}

GradientEvaluator::Value GradientEvaluator::valueBesideSpecial(int depth, Level& level, int point) noexcept
{
  const PointPlace& place = pointPlaces[point];
  Value found;
  if (touches(level.coarse, place))
  {
    found = this->betweenCoarser(depth, point); // which leaves this level as it is
  }
  else if (level.vertices && touches(level.drawn, place))
  {
    return { (*level.vertices)[vertexOfPoint(point)],
      isKnown | isThere | isEven }; // rounded otherwise: not kept
  }
  else
  {
    found = withAxes(place.axes,
      [&]<unsigned Axes>() noexcept { return this->onLattice<Axes>(depth, level, place.firstCell); });
  }
  level.value[point] = found.value;
  level.state[point] = found.state;
  return found;
}

/// Of one that does not hang.
template <unsigned Axes>
GradientEvaluator::Value GradientEvaluator::onLattice(
  int depth, const Level& level, int firstCell) const noexcept
{
  constexpr int dimensions = std::popcount(Axes);
  constexpr int slots = 1 << dimensions;
  constexpr std::array<int, slots> steps = cellSteps<Axes>();
  const auto isSpecial = [&](int cell) { return level.special[cell / 36] >> cell % 36 & 1; };
  if (std::all_of(steps.begin(), steps.end(), [&](int step) { return isSpecial(firstCell + step); }))
  {
    std::array<NodeRef, 8> around{};
    for (int side = 0; side < 8; ++side)
    {
      const std::uint64_t inner = level.inner[firstCell + cellStep(static_cast<unsigned>(side) & Axes)];
      if (inner != noNode)
      {
        around[side] =
          octree_.children(inner).node(touchingChild(Axes, static_cast<unsigned>(side)), depth + 2);
      }
    }
    return this->amidFiner(around);
  }
  WeightedCells<dimensions> cells;
  unsigned sides = 0; // that have a value
  for (int s = 0; s < slots; ++s)
  {
    const int cell = firstCell + steps[s];
    if (!isSpecial(cell))
    {
      cells.add(s, level.cellValue[cell], false);
      for (int c = 0; c < 8 / slots; ++c)
      {
        sides |= 1u << (sidesOf(Axes, s) | sidesOf(~Axes, c));
      }
    }
    else if (level.inner[cell] != noNode)
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
          value += field_.relative(child);
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
  return { cells.value(), static_cast<std::uint8_t>(isKnown | isThere | evenAxes(sides)) };
}

/// A point that only finer leaves touch: a corner of theirs, at the level of the largest. around: the nodes of one
/// level at its sides.
GradientEvaluator::Value GradientEvaluator::amidFiner(std::array<NodeRef, 8> around) const noexcept
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
      return { 0., isKnown };
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
      cells.add(side, field_.relative(data), isRefined);
      sides |= 1u << side;
    }
  }
  return { cells.value(), static_cast<std::uint8_t>(isKnown | isThere | evenAxes(sides)) };
}

/// Calls f(point) for those of the next coarser level that a point lies halfway between, and returns their number.
template <class F>
int GradientEvaluator::forCoarser(int depth, int point, const F& f) noexcept
{
  const int octant = octantAbove(path_.index(depth), 0);
  const PointPlace& place = pointPlaces[point];
  int first = 0;
  unsigned halfway = 0; // mask of axes
  for (int a = 0; a < 3; ++a)
  {
    const int twice = place.at[a] + 2 + 4 * sideOf(octant, a); // from the first point of the coarser level
    first += pointStride[a] * (twice / 2);
    halfway |= static_cast<unsigned>(twice & 1) << a;
  }
  for (unsigned sides = halfway;; sides = (sides - 1) & halfway)
  {
    f(first + cornerOffset(static_cast<int>(sides), pointStride));
    if (sides == 0)
    {
      return 1 << std::popcount(halfway);
    }
  }
}

/// One of the coarser points may hang, too.
GradientEvaluator::Value GradientEvaluator::betweenCoarser(int depth, int point) noexcept
{
  Level& coarser = this->levelAt(depth - 1);
  Value sum{ 0., isKnown | isThere | isEven };
  const int count = this->forCoarser(depth, point, [&](int p) {
    const Value one = this->valueAt(depth - 1, coarser, p);
    sum.value += one.value;
    sum.state &= one.state | isThere;
  });
  sum.value /= count;
  return sum;
}

/// At a point that is a vertex of the node itself.
Vec3 GradientEvaluator::gradientAt(int depth, Level& level, int point) noexcept
{
  const int vertex = vertexOfPoint(point);
  if (level.gradientKnown[vertex])
  {
    return level.gradient[vertex];
  }
  Vec3 gradient{};
  if (touches(level.coarse, pointPlaces[point]))
  {
    Level& coarser = this->levelAt(depth - 1);
    const int count = this->forCoarser(depth, point, [&](int p) {
      const Vec3 one = this->gradientAt(depth - 1, coarser, p);
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
      gradient[a] = this->slopeAt(depth, level, a, point);
    }
  }
  level.gradient[vertex] = gradient;
  level.gradientKnown[vertex] = true;
  return gradient;
}

double GradientEvaluator::slopeAt(int depth, Level& level, int axis, int point) noexcept
{
  const Value low = this->valueAt(depth, level, point - 2 * pointStride[axis]);
  const Value high = this->valueAt(depth, level, point + 2 * pointStride[axis]);
  if ((low.state & high.state) >> axis & 1)
  {
    const double* at = level.at[axis].data() + pointPlaces[point].at[axis];
    return (high.value - low.value) / (at[2] - at[-2]);
  }
  return this->slopeBesideMissing(depth, level, axis, point);
}

double GradientEvaluator::slopeBesideMissing(int depth, Level& level, int axis, int point) noexcept
{
  std::array<Value, 5> along;
  for (int i = 0; i < 5; ++i)
  {
    along[i] = this->valueAt(depth, level, point + (i - 2) * pointStride[axis]);
  }
  const auto outermost = [&](const auto& counts) {
    const auto low = std::find_if(along.begin(), along.end(), counts);
    const auto high = std::find_if(along.rbegin(), along.rend(), counts);
    return std::pair(static_cast<int>(low - along.begin()), 4 - static_cast<int>(high - along.rbegin()));
  };
  auto [low, high] = outermost([axis](const Value& v) { return v.state >> axis & 1; });
  if (low >= high)
  {
    std::tie(low, high) = outermost([](const Value& v) { return (v.state & isThere) != 0; });
  }
  // Of a vertex that a cell touches there are two of the points.
  const double* at = level.at[axis].data() + pointPlaces[point].at[axis] - 2;
  return low < high ? (along[high].value - along[low].value) / (at[high] - at[low]) : 0.;
}

/// Many of the path's node: the slopes of all at once, and those anew that are none between two even points.
void GradientEvaluator::computeMany(
  int depth, Level& level, const BlockVertices& vertices, BlockGradients& gradients) noexcept
{
  std::array<std::int16_t, block::vertexCount> others; // points of vertices
  int otherCount = 0;
  if (level.hasSpecial)
  {
    forEachVertex(vertices, [&](int vertex) {
      const int point = pointOfVertex(vertex);
      bool isOther = touches(level.coarse, pointPlaces[point]);
      for (int a = 0; a < 3 && !isOther; ++a)
      {
        const Value low = this->valueAt(depth, level, point - 2 * pointStride[a]);
        const Value high = this->valueAt(depth, level, point + 2 * pointStride[a]);
        isOther = (low.state & high.state & 1 << a) == 0;
      }
      others[otherCount] = static_cast<std::int16_t>(point);
      otherCount += isOther;
    });
  }
  std::array<std::array<double, block::verticesPerEdge>, 3> width;
  for (int a = 0; a < 3; ++a)
  {
    for (int i = 0; i < block::verticesPerEdge; ++i)
    {
      width[a][i] = level.at[a][i + 4] - level.at[a][i];
    }
  }
  for (int z = 0; z < block::verticesPerEdge; ++z)
  {
    for (int y = 0; y < block::verticesPerEdge; ++y)
    {
      const double* value = level.value.data() + 2 + pointStride[1] * (y + 2) + pointStride[2] * (z + 2);
      Vec3* row = gradients.data() + block::vertexStride[1] * y + block::vertexStride[2] * z;
      const auto rise = [value](int x, int axis) {
        return value[x + 2 * pointStride[axis]] - value[x - 2 * pointStride[axis]];
      };
      for (int x = 0; x < block::verticesPerEdge; ++x)
      {
        row[x] = { rise(x, 0) / width[0][x], rise(x, 1) / width[1][y], rise(x, 2) / width[2][z] };
      }
    }
  }
  std::for_each_n(others.begin(), otherCount,
    [&](int point) { gradients[vertexOfPoint(point)] = this->gradientAt(depth, level, point); });
}

void GradientEvaluator::compute(const BlockPath& path, BlockCells cells, const BlockVertices& vertices,
  BlockGradients& gradients, const Values* values) noexcept
{
  if (corners_ && cells == BlockCells::Leaves)
  {
    this->computeFromCorners(path, vertices, gradients);
    return;
  }
  this->setLeafDepth(cells == BlockCells::Means ? path.depth + 1 : Octree::maxDepth + 1);
  this->moveTo(path);
  Level& level = this->levelAt(path.depth);
  level.vertices = level.isComplete ? values : nullptr;
  int count = 0;
  for (const std::uint32_t mask : vertices)
  {
    count += std::popcount(mask);
  }
  constexpr int many = 27;
  if (count >= many && !level.vertices)
  {
    this->computeMany(path.depth, level, vertices, gradients);
  }
  else
  {
    forEachVertex(vertices,
      [&](int vertex) { gradients[vertex] = this->gradientAt(path.depth, level, pointOfVertex(vertex)); });
  }
  level.vertices = nullptr; // the caller's
}

/// Between those at the leaves' corners.
void GradientEvaluator::computeFromCorners(
  const BlockPath& path, const BlockVertices& vertices, BlockGradients& gradients) noexcept
{
  const bool isOnlyLeaf = octree_.root().isLeaf();
  if (!isOnlyLeaf)
  {
    this->moveTo(path);
  }
  forEachVertex(vertices, [&](int v) {
    const std::array<int, 3> at{ v % 5, v / 5 % 5, v / 25 };
    int low = 0;
    unsigned halfway = 0; // mask of axes
    for (int a = 0; a < 3; ++a)
    {
      low += familyStride[a] * (at[a] / 2);
      halfway |= static_cast<unsigned>(at[a] & 1) << a;
    }
    Vec3 sum{};
    const int count = forSides(low, halfway, [&](int vertex) {
      const Vec3 one = isOnlyLeaf ? corners_->inOnlyLeaf(vertex) : corners_->at(path_, vertex);
      for (int a = 0; a < 3; ++a)
      {
        sum[a] += one[a];
      }
    });
    gradients[v] = { sum[0] / count, sum[1] / count, sum[2] / count };
  });
}

BlockVertices verticesOfOctants(std::uint64_t octants) noexcept
{
  BlockVertices vertices{};
  for (; octants != 0; octants &= octants - 1)
  {
    const int octant = std::countr_zero(octants);
    const std::uint32_t square = 0b1100011u << ((octant & 3) + block::verticesPerEdge * (octant >> 2 & 3));
    vertices[octant >> 4] |= square;
    vertices[(octant >> 4) + 1] |= square;
  }
  return vertices;
}

} // namespace treeamr

#include "Interpolation/BlockValues.h"

#include "Interpolation/BlockKernel.h"
#include "Interpolation/GTIWeights.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace treeamr
{

using namespace block;

namespace
{

/// A vertex between leaves and refined nodes of one level.
template <unsigned Axes, class Level>
double onLattice(const Level& level, int place) noexcept
{
  constexpr int count = 1 << std::popcount(Axes);
  constexpr int children = 8 / count;
  const double* values = level.childValue.data() + childBefore(Axes, place);
  const double* weights = gtiWeightsOf<std::popcount(Axes)>(aroundVertex<Axes>(level.refined >> place));
  double sum = 0.;
  for (int s = 0; s < count; ++s)
  {
    double data = 0.;
    for (int c = 0; c < children; ++c)
    {
      data += values[stepAlong(Axes, s) + stepAlong(~Axes, c)];
    }
    sum += weights[s] * (data / children);
  }
  return sum;
}

/// The same where cells may be missing: a place without one takes no part and counts as unrefined.
template <unsigned Axes, class Level>
double onSparseLattice(const Level& level, int place) noexcept
{
  constexpr int count = 1 << std::popcount(Axes);
  std::array<double, count> data{};
  const unsigned refinedAround = aroundVertex<Axes>(level.refined >> place);
  unsigned present = 0;
  unsigned refined = 0;
  for (int s = 0; s < count; ++s)
  {
    int touching = 0;
    for (int c = 0; c < 8 / count; ++c)
    {
      const int child = childBefore(Axes, place) + stepAlong(Axes, s) + stepAlong(~Axes, c);
      if (!(level.childNone[child >> 6] >> (child & 63) & 1))
      {
        data[s] += level.childValue[child];
        ++touching;
      }
    }
    if (touching != 0)
    {
      data[s] /= touching;
      present |= 1u << s;
      refined |= refinedAround & 1u << s;
    }
  }
  const double* weights = gtiWeightsOf<std::popcount(Axes)>(refined);
  double sum = 0.;
  double total = 0.;
  for (int s = 0; s < count; ++s)
  {
    if (present >> s & 1)
    {
      sum += weights[s] * data[s];
      total += weights[s];
    }
  }
  return present == (1u << count) - 1 ? sum : sum / total;
}

/// A vertex that hangs between those of the next coarser level: halfway along the axes that are not in the mask.
template <unsigned Axes>
double halfway(const double* coarser) noexcept
{
  constexpr int count = 8 >> std::popcount(Axes);
  double sum = 0.;
  for (int corner = 0; corner < count; ++corner)
  {
    const int step = stepAlong(~Axes, corner);
    sum += coarser[vertexIndex(step & 1, step >> 3 & 1, step >> 6)];
  }
  return sum / count;
}

} // namespace

/// The root as the only child of what is above it.
void BlockEvaluator::startAboveRoot() noexcept
{
  Level& level = levels_[0];
  level.refined = std::uint64_t(octree_.root().isInner()) << placeIndex(1, 1, 1);
  open(nullptr, 0, level);
  level.none = level.missing = ~level.refined;
  level.coarse = level.filled = 0;
  level.value = {};
}

/// What a level's places are, from the children of its parent's.
void BlockEvaluator::gather(const BlockPath& path, int depth, Level& level) noexcept
{
  Level& parent = levelAt(path, depth - 1);
  fill(parent, ~std::uint64_t(0));
  const int octant = depth == 0 ? 0 : path.octant[depth - 1];
  level.node = path.node[depth];
  const std::uint64_t leaves = entriesOf(~(parent.refined | parent.none), octant);
  level.coarse = placesOf(leaves);
  level.none = level.missing = placesOf(entriesOf(parent.none, octant)) | placesOf(parent.childNone, octant);
  level.deep = (leaves & entriesOf(parent.coarse, octant)) != 0;
  level.hanging = verticesTouching(level.coarse);
  level.known = {};
  level.filled = 0;
  const int first = firstPlace(octant);
  for (int row = 0; row < 16; ++row)
  {
    const double* from = parent.childValue.data() + first + childIndex(0, row & 3, row >> 2);
    for (int x = 0; x < 4; ++x)
    {
      level.value[4 * row + x] = from[x];
    }
  }
  level.refined = &level == &byMeans_ ? 0 : placesOf(parent.childInner, octant);
  open(&parent, octant, level);
}

/// Finds the children of refined places, and announces that their values will be asked for.
void BlockEvaluator::open(const Level* parent, int octant, Level& level) const noexcept
{
  const float* leaves = field_.leafValues().data();
  const float* means = field_.innerMeans().data();
  std::uint64_t mixed = 0;
  forEachPlace(level.refined, [&](int place) {
    std::uint64_t inner = 0;
    if (parent)
    {
      const int child = firstPlace(octant) + childIndex(place & 3, place >> 2 & 3, place >> 4);
      const int above = placeIndex(child >> 1 & 3, child >> 4 & 3, child >> 7);
      inner = parent->children[above].innerIndex((child & 1) | (child >> 2 & 2) | (child >> 4 & 4));
    }
    const Octree::Children children = octree_.children(inner);
    // Member by member: copied as a whole, its masks would be read back wider than they were just written.
    Octree::Children& kept = level.children[place];
    kept.exists = children.exists;
    kept.leaf = children.leaf;
    kept.firstInner = children.firstInner;
    kept.firstLeaf = children.firstLeaf;
    mixed |= static_cast<std::uint64_t>(!children.allLeaves()) << place;
    prefetch(leaves + children.firstLeaf);
    prefetch(children.allLeaves() ? leaves + children.firstLeaf + 7 : means + children.firstInner);
  });
  level.mixed = mixed;
}

/// The children of some of a level's places.
void BlockEvaluator::fill(Level& level, std::uint64_t places) const noexcept
{
  if (level.filled == 0)
  {
    level.childInner = level.childNone = {};
  }
  places &= ~level.filled;
  level.filled |= places;
  const float* leaves = field_.leafValues().data();
  const float* means = field_.innerMeans().data();
  const std::array<double, 2> base{ field_.meanBase(), 0. }; // of a mean, of a leaf
  forEachPlace(places & ~level.refined, [&](int place) {
    double* values = level.childValue.data() + firstChild(place);
    for (int o = 0; o < 8; ++o)
    {
      values[stepAlong(7, o)] = level.value[place];
    }
  });
  forEachPlace(places & level.none, [&](int place) { addChildren(level.childNone, place, 0xff); });
  forEachPlace(places & level.refined & ~level.mixed, [&](int place) {
    const float* leaf = leaves + level.children[place].firstLeaf;
    double* values = level.childValue.data() + firstChild(place);
    for (int o = 0; o < 8; ++o)
    {
      values[stepAlong(7, o)] = leaf[o];
    }
  });
  forEachPlace(places & level.mixed, [&](int place) {
    const Octree::Children& children = level.children[place];
    double* values = level.childValue.data() + firstChild(place);
    addChildren(level.childInner, place, children.inner());
    octree_.prefetchChildren(children.firstInner);
    const float* leaf = leaves + children.firstLeaf;
    const float* mean = means + children.firstInner;
    if (children.exists == 0xff)
    {
      // Leaves or not is as good as random: without branches.
      for (int o = 0; o < 8; ++o)
      {
        const std::ptrdiff_t isLeaf = children.leaf >> o & 1;
        values[stepAlong(7, o)] = base[isLeaf] + *(isLeaf != 0 ? leaf : mean);
        leaf += isLeaf;
        mean += 1 - isLeaf;
      }
      return;
    }
    for (int o = 0; o < 8; ++o)
    {
      const unsigned bit = 1u << o;
      values[stepAlong(7, o)] = children.leaf & bit ? *leaf++
        : children.exists & bit                     ? base[0] + *mean++
                                                    : 0.;
    }
    addChildren(level.childNone, place, 0xff & ~children.exists);
    const unsigned wanted = tables.childrenOfPlace[place];
    level.missing |= static_cast<std::uint64_t>((wanted & ~children.exists) != 0) << place;
  });
}

/// Of the path's node at a depth.
BlockEvaluator::Level& BlockEvaluator::levelAt(const BlockPath& path, int depth) noexcept
{
  Level& level = levels_[1 + depth];
  if (depth >= 0 && level.node != path.node[depth])
  {
    gather(path, depth, level);
  }
  return level;
}

/// The level with these vertices known.
BlockEvaluator::Level& BlockEvaluator::withSpecial(
  const BlockPath& path, int depth, const VertexMask& vertices) noexcept
{
  Level& level = levelAt(path, depth);
  const VertexMask wanted = without(vertices, level.known);
  if (!isEmpty(wanted))
  {
    // Recursion reaches coarser levels only: this one keeps its node.
    computeSpecial(path, depth, level, wanted, level.special.data());
    add(level.known, wanted);
  }
  return level;
}

/// Vertices on a face or edge of a coarser leaf lie between the vertices of that leaf's level around them. All
/// of these are vertices of the path's node of that level, because that node touches them.
void BlockEvaluator::computeSpecial(
  const BlockPath& path, int depth, Level& level, const VertexMask& wanted, double* out) noexcept
{
  const VertexMask hanging = both(wanted, level.hanging);
  if (!isEmpty(hanging))
  {
    if (!level.deep)
    {
      const int octant = path.octant[depth - 1];
      const Level& parent = levelAt(path, depth - 1);
      const VertexMask besideLeaves = verticesTouching(~(parent.refined | parent.none));
      const Level& coarser = withSpecial(path, depth - 1, both(besideLeaves, tables.ofChild[octant]));
      const double* values = coarser.special.data() +
        vertexIndex(2 * sideOf(octant, 0), 2 * sideOf(octant, 1), 2 * sideOf(octant, 2));
      forAxes([&]<unsigned Axes>() noexcept {
        if constexpr (Axes != 0) // the middle of a child hangs on nothing
        {
          forEachPlace(hanging[Axes], [&](int place) {
            out[vertexOf(Axes, place)] =
              halfway<Axes>(values + tables.halfVertex[place] - middleVertex(Axes));
          });
        }
      });
    }
    else
    {
      forAxes([&]<unsigned Axes>() noexcept {
        forEachPlace(hanging[Axes],
          [&](int place) { out[vertexOf(Axes, place)] = hangingDeep(path, depth, level, Axes, place); });
      });
    }
  }
  const VertexMask lattice = without(wanted, level.hanging);
  if (isEmpty(lattice))
  {
    return;
  }
  fill(level, withNeighbours(level.refined | level.none));
  if (level.missing == 0)
  {
    forAxes([&]<unsigned Axes>() noexcept {
      forEachPlace(
        lattice[Axes], [&](int place) { out[vertexOf(Axes, place)] = onLattice<Axes>(level, place); });
    });
    return;
  }
  forAxes([&]<unsigned Axes>() noexcept {
    forEachPlace(lattice[Axes], [&](int place) {
      const bool complete = aroundVertex<Axes>(level.missing >> place) == 0;
      out[vertexOf(Axes, place)] =
        complete ? onLattice<Axes>(level, place) : onSparseLattice<Axes>(level, place);
    });
  });
}

/// Of the coarser leaf at a place.
int BlockEvaluator::leafDepth(const BlockPath& path, int depth, int place) noexcept
{
  for (;;)
  {
    const int entry = placeIndex(((place & 3) + 1) / 2, ((place >> 2 & 3) + 1) / 2, ((place >> 4) + 1) / 2);
    place = entry + firstEntry(path.octant[depth - 1]);
    if (!(levelAt(path, depth - 1).coarse >> place & 1))
    {
      return depth;
    }
    --depth;
  }
}

/// Where leaves may be larger than the node itself.
double BlockEvaluator::hangingDeep(
  const BlockPath& path, int depth, const Level& level, unsigned axes, int place) noexcept
{
  std::uint64_t around = 1;
  for (int a = 0; a < 3; ++a)
  {
    around |= axes >> a & 1 ? around << (1 << 2 * a) : 0;
  }
  int coarsest = depth;
  forEachPlace(level.coarse & around << place,
    [&](int coarse) { coarsest = std::min(coarsest, leafDepth(path, depth, coarse)); });
  const int up = depth + 1 - coarsest;
  const int vertex = vertexOf(axes, place);
  const std::array<int, 3> at{ vertex % 5, vertex / 5 % 5, vertex / 25 };
  std::array<int, 3> first{};
  std::array<double, 3> fraction{};
  unsigned hangs = 0; // mask of axes
  for (int a = 0; a < 3; ++a)
  {
    // In half widths of the children, then of the children of the coarsest leaf's parent; from its corner.
    Coord position = 0;
    for (int d = coarsest - 1; d < depth; ++d)
    {
      position = 2 * position + (path.octant[d] >> a & 1);
    }
    position = 4 * position + at[a];
    const Coord floor = position >> up;
    const Coord rest = position - (floor << up);
    first[a] = static_cast<int>(floor);
    fraction[a] = static_cast<double>(rest) / static_cast<double>(Coord(1) << up);
    hangs |= static_cast<unsigned>(rest != 0) << a;
  }
  double sum = 0.;
  for (unsigned corner = 0; corner < 8; ++corner)
  {
    if ((corner & ~hangs) != 0)
    {
      continue;
    }
    double weight = 1.;
    std::array<int, 3> v = first;
    unsigned between = 0;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = corner >> a & 1;
      weight *= upper ? fraction[a] : 1. - fraction[a];
      v[a] += upper ? 1 : 0;
      between |= static_cast<unsigned>(v[a] % 2 == 0) << a;
    }
    VertexMask one{};
    one[between] = std::uint64_t(1) << placeIndex((v[0] + 1) / 2, (v[1] + 1) / 2, (v[2] + 1) / 2);
    sum += weight * withSpecial(path, coarsest - 1, one).special[vertexIndex(v[0], v[1], v[2])];
  }
  return sum;
}

/// From a node's corners, and means of these between them.
void BlockEvaluator::evaluateCorners(const BlockPath& path) noexcept
{
  drawn_ = octree_.root().isLeaf() ? 1 : octree_.children(path.node[path.depth]).leaf;
  const CornerValues::Family family = familyOf(*corners_, octree_, path);
  for (int i = 0; i < 27; ++i)
  {
    const int vertex = vertexIndex(2 * (i % 3), 2 * (i / 3 % 3), 2 * (i / 9));
    values_[vertex] = family.has(i) ? family[i] : 0.;
  }
  const auto between = [&](int axis, int from) {
    for (const int middle : { from + vertexStride[axis], from + 3 * vertexStride[axis] })
    {
      values_[middle] = 0.5 * (values_[middle - vertexStride[axis]] + values_[middle + vertexStride[axis]]);
    }
  };
  for (int i = 0; i < 9; ++i)
  {
    between(0, vertexIndex(0, 2 * (i % 3), 2 * (i / 3)));
  }
  for (int i = 0; i < 15; ++i)
  {
    between(1, vertexIndex(i % 5, 0, 2 * (i / 5)));
  }
  for (int i = 0; i < 25; ++i)
  {
    between(2, i);
  }
}

void BlockEvaluator::evaluate(const BlockPath& path, BlockCells cells) noexcept
{
  if (corners_ && cells == BlockCells::Leaves)
  {
    this->evaluateCorners(path);
    return;
  }
  const int depth = path.depth;
  const Octree::Children own = octree_.children(path.node[depth]);
  Level* level = &byMeans_;
  if (cells == BlockCells::Leaves)
  {
    drawn_ = own.leaf;
    level = &levelAt(path, depth);
  }
  else
  {
    drawn_ = own.exists;
    gather(path, depth, byMeans_);
  }
  meansBetween(level->value, values_);
  if ((level->refined | level->coarse | level->none) == 0)
  {
    return;
  }
  const VertexMask special = verticesTouching(level->refined | level->coarse | level->none);
  computeSpecial(path, depth, *level, both(special, verticesOf(drawn_)), values_.data());
}

Range BlockEvaluator::bounds(const BlockPath& path) noexcept
{
  if (corners_)
  {
    BlockValues block;
    compute(path, BlockCells::Leaves, block);
    return block.range;
  }
  Level& level = levelAt(path, path.depth);
  if (level.deep)
  {
    // Vertices may depend on cells that are not around the node.
    BlockValues block;
    compute(path, BlockCells::Leaves, block);
    return block.range;
  }
  if ((level.refined | level.coarse | level.none) == 0)
  {
    meansBetween(level.value, values_);
    std::array<float, vertexCount> rounded;
    return roundValues(values_, rounded);
  }
  fill(level, level.refined);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto add = [&](double value) {
    low = value < low ? value : low;
    high = value > high ? value : high;
  };
  // Of refined ones the means: vertices of the node's own level see these.
  forEachPlace(~level.none, [&](int place) { add(level.value[place]); });
  forEachPlace(level.refined, [&](int place) {
    const double* values = level.childValue.data() + firstChild(place);
    unsigned touching = tables.childrenOfPlace[place] & level.children[place].exists;
    for (; touching != 0; touching &= touching - 1)
    {
      add(values[stepAlong(7, std::countr_zero(touching))]);
    }
  });
  return { static_cast<float>(low), static_cast<float>(high) };
}

namespace
{

/// The middle of a drawn child stands in for what is not drawn, so that the hull is that of the rest.
template <class T>
void fillUndrawn(std::array<T, vertexCount>& values, unsigned drawn) noexcept
{
  const int octant = std::countr_zero(drawn);
  const T value =
    values[vertexIndex(1 + 2 * sideOf(octant, 0), 1 + 2 * sideOf(octant, 1), 1 + 2 * sideOf(octant, 2))];
  const VertexMask others = without(verticesOf(0xff), verticesOf(drawn));
  forAxes([&]<unsigned Axes>() noexcept {
    forEachPlace(others[Axes], [&](int place) { values[vertexOf(Axes, place)] = value; });
  });
}

} // namespace

void BlockEvaluator::compute(const BlockPath& path, BlockCells cells, BlockValues& block) noexcept
{
  evaluate(path, cells);
  block.range = roundValues(values_, block.values);
  if (drawn_ != 0xff)
  {
    fillUndrawn(block.values, drawn_);
    block.range = hull(block.values);
  }
}

void BlockEvaluator::computeUnrounded(
  const BlockPath& path, BlockCells cells, std::array<double, vertexCount>& values) noexcept
{
  evaluate(path, cells);
  std::copy_n(values_.begin(), values.size(), values.begin());
  if (drawn_ != 0xff)
  {
    fillUndrawn(values, drawn_);
  }
}

} // namespace treeamr

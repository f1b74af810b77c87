#include "Interpolation/BlockValues.h"

#include "Interpolation/BlockKernel.h"
#include "Interpolation/GTIWeights.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace treeamr
{

namespace
{

constexpr void add(BlockVertexMask& mask, int v)
{
  mask[v >> 6] |= std::uint64_t(1) << (v & 63);
}

constexpr void add(BlockVertexMask& mask, const BlockVertexMask& more)
{
  mask[0] |= more[0];
  mask[1] |= more[1];
}

constexpr BlockVertexMask without(const BlockVertexMask& mask, const BlockVertexMask& others)
{
  return { mask[0] & ~others[0], mask[1] & ~others[1] };
}

constexpr BlockVertexMask both(const BlockVertexMask& a, const BlockVertexMask& b)
{
  return { a[0] & b[0], a[1] & b[1] };
}

template <class F>
void forEachVertex(const BlockVertexMask& mask, const F& f)
{
  for (int word = 0; word < 2; ++word)
  {
    for (std::uint64_t rest = mask[word]; rest != 0; rest &= rest - 1)
    {
      f(64 * word + std::countr_zero(rest));
    }
  }
}

/// Places of a level: see BlockEvaluator::Level.
constexpr int placeIndex(int x, int y, int z)
{
  return x + 4 * y + 16 * z;
}

/// Their children.
constexpr int childIndex(int x, int y, int z)
{
  return x + 8 * y + 64 * z;
}

/// Along each axis place 0 is the upper child of the lower neighbour, 1 and 2 are the children of the node itself,
/// 3 is the lower child of the upper neighbour. Vertex v lies between the children v + 1 and v + 2 of places.
struct BlockVertex
{
  std::uint8_t place = 0;   // first of those around it,
  std::uint64_t places = 0; // mask of all
  std::uint16_t child = 0;  // first of the eight around it
  std::uint8_t coarser =
    0; // on the lattice of the next coarser level, from the node's lower corner: the first of
       // the one, two or four that it lies between
};

struct BlockTables
{
  std::array<BlockVertex, 125> vertex{};
  std::array<BlockVertexMask, 8> verticesOfAxes{}; // those that lie between places along these axes alone
  std::array<std::uint8_t, 64> childrenOfPlace{};  // that touch any vertex
  // Vertices of a plane that touch places of its first two rows, and of the other two, by their mask.
  std::array<std::array<std::uint32_t, 256>, 2> verticesOfRows{};
};

constexpr BlockTables makeTables()
{
  BlockTables t{};
  for (int v = 0; v < 125; ++v)
  {
    const std::array<int, 3> at{ v % 5, v / 5 % 5, v / 25 };
    BlockVertex& b = t.vertex[v];
    unsigned axes = 0;
    for (int a = 0; a < 3; ++a)
    {
      axes |= static_cast<unsigned>(at[a] % 2 == 0) << a;
    }
    add(t.verticesOfAxes[axes], v);
    b.place = static_cast<std::uint8_t>(placeIndex((at[0] + 1) / 2, (at[1] + 1) / 2, (at[2] + 1) / 2));
    b.child = static_cast<std::uint16_t>(childIndex(at[0] + 1, at[1] + 1, at[2] + 1));
    b.coarser = static_cast<std::uint8_t>(at[0] / 2 + 5 * (at[1] / 2) + 25 * (at[2] / 2));
    for (int corner = 0; corner < 8; ++corner)
    {
      const std::array<int, 3> child{ at[0] + 1 + (corner & 1), at[1] + 1 + (corner >> 1 & 1),
        at[2] + 1 + (corner >> 2) };
      const int place = placeIndex(child[0] / 2, child[1] / 2, child[2] / 2);
      b.places |= std::uint64_t(1) << place;
      t.childrenOfPlace[place] |=
        static_cast<std::uint8_t>(1u << ((child[0] & 1) | (child[1] & 1) << 1 | (child[2] & 1) << 2));
    }
  }
  for (unsigned rows = 0; rows < 256; ++rows)
  {
    for (int v = 0; v < 25; ++v)
    {
      for (int half = 0; half < 2; ++half)
      {
        // In the middle of a plane of places.
        const std::uint64_t touched = t.vertex[v + 25].places >> 16 & 0xffff;
        const bool touches = (touched >> 8 * half & rows) != 0;
        t.verticesOfRows[half][rows] |= static_cast<std::uint32_t>(touches) << v;
      }
    }
  }
  return t;
}

constexpr BlockTables tables = makeTables();

void prefetch(const float* address) noexcept
{
#if defined(__GNUC__)
  __builtin_prefetch(address);
#else
  static_cast<void>(address);
#endif
}

/// Calls f<axes>().
template <class F>
void forAxes(unsigned axes, const F& f) noexcept
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

BlockVertexMask verticesTouching(std::uint64_t places) noexcept
{
  std::array<std::uint64_t, 4> plane;
  for (int z = 0; z < 4; ++z)
  {
    plane[z] = tables.verticesOfRows[0][places >> 16 * z & 0xff] |
      tables.verticesOfRows[1][places >> (16 * z + 8) & 0xff];
  }
  const std::uint64_t middle = plane[1] | plane[2];
  return { (plane[0] | plane[1]) | plane[1] << 25 | middle << 50,
    middle >> 14 | plane[2] << 11 | (plane[2] | plane[3]) << 36 };
}

/// Of a node's children.
BlockVertexMask verticesOf(unsigned children) noexcept
{
  const std::uint64_t places = (children & 3) | (children & 12) << 2 |
    static_cast<std::uint64_t>((children & 48) | (children & 192) << 2) << 12;
  return verticesTouching(places << placeIndex(1, 1, 1));
}

/// The places and those that share a vertex of the block with one.
std::uint64_t withNeighbours(std::uint64_t places) noexcept
{
  constexpr std::uint64_t lowerX = 0x7777777777777777;
  constexpr std::uint64_t lowerY = 0x0fff0fff0fff0fff;
  places |= (places & lowerX) << 1 | (places >> 1 & lowerX);
  places |= (places & lowerY) << 4 | (places >> 4 & lowerY);
  return places | places << 16 | places >> 16;
}

/// A child's place 0 as a place of its parent's level: its neighbourhood's first entry.
constexpr int firstEntry(int octant)
{
  return placeIndex(octant & 1, octant >> 1 & 1, octant >> 2);
}

/// The 3 x 3 x 3 places that are the neighbourhood of a child.
std::uint64_t entriesOf(std::uint64_t places, int octant) noexcept
{
  return places >> firstEntry(octant) & 0x077707770777;
}

/// The places of a node's level that the entries of its neighbourhood cover.
std::uint64_t placesOf(std::uint64_t entries) noexcept
{
  const std::uint64_t x = (entries & 0x033303330333) | (entries & 0x066606660666) << 1;
  const std::uint64_t xy = (x & 0x00ff00ff00ff) | (x & 0x0ff00ff00ff0) << 4;
  return (xy & 0xffffffff) | (xy & 0xffffffff0000) << 16;
}

/// Vertices of the node itself that touch entries of its neighbourhood, on the lattice of its parent's level, counted
/// from the node's lower corner.
std::uint64_t nodeVerticesOf(std::uint64_t entries) noexcept
{
  std::uint64_t middle = entries & 0x022202220222;
  entries |= middle << 1 | middle >> 1;
  middle = entries & 0x00f000f000f0;
  entries |= middle << 4 | middle >> 4;
  middle = entries & 0xffff0000;
  entries |= middle << 16 | middle >> 16;
  const std::uint64_t rows =
    (entries & 0x000700070007) | (entries & 0x007000700070) << 1 | (entries & 0x070007000700) << 2;
  return (rows & 0xffff) | (rows & 0xffff0000) << 9 | (rows & 0xffff00000000) << 18;
}

/// First of the children of a level's places that are the places of a child's level.
constexpr int firstPlace(int octant)
{
  return childIndex(1 + 2 * (octant & 1), 1 + 2 * (octant >> 1 & 1), 1 + 2 * (octant >> 2));
}

/// From masks of a level's children those of a child's places.
std::uint64_t placesOf(const std::array<std::uint64_t, 8>& children, int octant) noexcept
{
  const int first = firstPlace(octant);
  std::uint64_t places = 0;
  for (int z = 0; z < 4; ++z)
  {
    std::uint64_t rows = children[(first >> 6) + z] >> (first & 63) & 0x0f0f0f0f;
    rows = (rows | rows >> 4) & 0x00ff00ff;
    places |= ((rows | rows >> 8) & 0xffff) << 16 * z;
  }
  return places;
}

/// First child of a place.
constexpr int firstChild(int place)
{
  return childIndex(2 * (place & 3), 2 * (place >> 2 & 3), 2 * (place >> 4));
}

/// Adds a mask of a place's children to those of a level.
void addChildren(std::array<std::uint64_t, 8>& masks, int place, unsigned children) noexcept
{
  const int first = firstChild(place);
  const auto rows = [&](std::uint64_t four) { return ((four & 3) | (four & 12) << 6) << (first & 63); };
  masks[first >> 6] |= rows(children & 15);
  masks[(first >> 6) + 1] |= rows(children >> 4);
}

/// Of the cells around a vertex, in their order, from a mask of slots that starts at the first of them.
template <unsigned Axes>
unsigned aroundVertex(std::uint64_t slots) noexcept
{
  if constexpr (Axes == 0)
  {
    return slots & 1;
  }
  else
  {
    // The highest axis joins two halves that lie 1, 4 or 16 slots apart.
    constexpr int axis = std::bit_width(Axes) - 1;
    constexpr unsigned rest = Axes & ~(1u << axis);
    return aroundVertex<rest>(slots) |
      aroundVertex<rest>(slots >> (1 << 2 * axis)) << (1 << std::popcount(rest));
  }
}

template <unsigned Axes>
const double* weightsOf(unsigned refined) noexcept
{
  constexpr int dimensions = std::popcount(Axes);
  static constexpr double one = 1.;
  if constexpr (dimensions == 0)
  {
    return &one;
  }
  else if constexpr (dimensions == 1)
  {
    return gtiWeights1[refined].data();
  }
  else if constexpr (dimensions == 2)
  {
    return gtiWeights2[refined].data();
  }
  else
  {
    return gtiWeights3[refined].data();
  }
}

/// Corner `part` of those along the axes of a mask, as a step among a level's children.
constexpr int stepAlong(unsigned axes, int part)
{
  int step = 0;
  for (int a = 0; a < 3; ++a)
  {
    if (axes >> a & 1)
    {
      step += (part & 1) << 3 * a;
      part >>= 1;
    }
  }
  return step;
}

/// A vertex between leaves and refined nodes of one level.
template <unsigned Axes, class Level>
double onLattice(const Level& level, const BlockVertex& b) noexcept
{
  constexpr int count = 1 << std::popcount(Axes);
  constexpr int children = 8 / count;
  const double* values = level.childValue.data() + b.child;
  const double* weights = weightsOf<Axes>(aroundVertex<Axes>(level.refined >> b.place));
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
double onSparseLattice(const Level& level, const BlockVertex& b) noexcept
{
  constexpr int count = 1 << std::popcount(Axes);
  std::array<double, count> data{};
  const unsigned refinedAround = aroundVertex<Axes>(level.refined >> b.place);
  unsigned present = 0;
  unsigned refined = 0;
  for (int s = 0; s < count; ++s)
  {
    int touching = 0;
    for (int c = 0; c < 8 / count; ++c)
    {
      const int child = b.child + stepAlong(Axes, s) + stepAlong(~Axes, c);
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
  const double* weights = weightsOf<Axes>(refined);
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
    sum += coarser[(step & 1) + 5 * (step >> 3 & 1) + 25 * (step >> 6)];
  }
  return sum / count;
}

template <unsigned Axes, class Level>
double latticeValue(const Level& level, const BlockVertex& b) noexcept
{
  return (b.places & level.missing) == 0 ? onLattice<Axes>(level, b) : onSparseLattice<Axes>(level, b);
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
  level.leavesAround = entriesOf(~(parent.refined | parent.none), octant);
  level.coarse = placesOf(level.leavesAround);
  level.none = level.missing = placesOf(entriesOf(parent.none, octant)) | placesOf(parent.childNone, octant);
  level.deep = (level.leavesAround & entriesOf(parent.coarse, octant)) != 0;
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
  for (std::uint64_t rest = level.refined; rest != 0; rest &= rest - 1)
  {
    const int place = std::countr_zero(rest);
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
  }
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
  for (std::uint64_t rest = places & ~level.refined; rest != 0; rest &= rest - 1)
  {
    const int place = std::countr_zero(rest);
    double* values = level.childValue.data() + firstChild(place);
    for (int o = 0; o < 8; ++o)
    {
      values[stepAlong(7, o)] = level.value[place];
    }
  }
  for (std::uint64_t rest = places & level.none; rest != 0; rest &= rest - 1)
  {
    addChildren(level.childNone, std::countr_zero(rest), 0xff);
  }
  for (std::uint64_t rest = places & level.refined & ~level.mixed; rest != 0; rest &= rest - 1)
  {
    const int place = std::countr_zero(rest);
    const float* leaf = leaves + level.children[place].firstLeaf;
    double* values = level.childValue.data() + firstChild(place);
    for (int o = 0; o < 8; ++o)
    {
      values[stepAlong(7, o)] = leaf[o];
    }
  }
  for (std::uint64_t rest = places & level.mixed; rest != 0; rest &= rest - 1)
  {
    const int place = std::countr_zero(rest);
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
        values[stepAlong(7, o)] = *(isLeaf != 0 ? leaf : mean);
        leaf += isLeaf;
        mean += 1 - isLeaf;
      }
      continue;
    }
    for (int o = 0; o < 8; ++o)
    {
      const unsigned bit = 1u << o;
      values[stepAlong(7, o)] = children.leaf & bit ? *leaf++ : children.exists & bit ? *mean++ : 0.f;
    }
    addChildren(level.childNone, place, 0xff & ~children.exists);
    const unsigned wanted = tables.childrenOfPlace[place];
    level.missing |= static_cast<std::uint64_t>((wanted & ~children.exists) != 0) << place;
  }
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
  const BlockPath& path, int depth, const BlockVertexMask& vertices) noexcept
{
  Level& level = levelAt(path, depth);
  const BlockVertexMask wanted = without(vertices, level.known);
  if ((wanted[0] | wanted[1]) != 0)
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
  const BlockPath& path, int depth, Level& level, const BlockVertexMask& wanted, double* out) noexcept
{
  const BlockVertexMask hanging = both(wanted, level.hanging);
  if ((hanging[0] | hanging[1]) != 0)
  {
    if (!level.deep)
    {
      const int octant = path.octant[depth - 1];
      const int corner = 2 * (octant & 1) + 10 * (octant >> 1 & 1) + 50 * (octant >> 2);
      const std::uint64_t around = nodeVerticesOf(level.leavesAround);
      const Level& coarser =
        withSpecial(path, depth - 1, { around << corner, corner == 0 ? 0 : around >> (64 - corner) });
      const double* values = coarser.special.data() + corner;
      // The middle of a child hangs on nothing.
      for (unsigned axes = 1; axes < 8; ++axes)
      {
        forAxes(axes, [&]<unsigned Axes>() noexcept {
          forEachVertex(both(hanging, tables.verticesOfAxes[Axes]),
            [&](int vertex) { out[vertex] = halfway<Axes>(values + tables.vertex[vertex].coarser); });
        });
      }
    }
    else
    {
      forEachVertex(hanging, [&](int vertex) { out[vertex] = hangingDeep(path, depth, level, vertex); });
    }
  }
  const BlockVertexMask lattice = without(wanted, level.hanging);
  if ((lattice[0] | lattice[1]) == 0)
  {
    return;
  }
  fill(level, withNeighbours(level.refined | level.none));
  for (unsigned axes = 0; axes < 8; ++axes)
  {
    forAxes(axes, [&]<unsigned Axes>() noexcept {
      const BlockVertexMask vertices = both(lattice, tables.verticesOfAxes[Axes]);
      if (level.missing == 0)
      {
        forEachVertex(
          vertices, [&](int vertex) { out[vertex] = onLattice<Axes>(level, tables.vertex[vertex]); });
      }
      else
      {
        forEachVertex(
          vertices, [&](int vertex) { out[vertex] = latticeValue<Axes>(level, tables.vertex[vertex]); });
      }
    });
  }
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
double BlockEvaluator::hangingDeep(const BlockPath& path, int depth, const Level& level, int vertex) noexcept
{
  int coarsest = depth;
  for (std::uint64_t rest = tables.vertex[vertex].places & level.coarse; rest != 0; rest &= rest - 1)
  {
    coarsest = std::min(coarsest, leafDepth(path, depth, std::countr_zero(rest)));
  }
  const int up = depth + 1 - coarsest;
  const std::array<int, 3> at{ vertex % 5, vertex / 5 % 5, vertex / 25 };
  constexpr std::array<int, 3> stride{ 1, 5, 25 };
  int base = 0;
  int hangs = 0;
  std::array<int, 3> strideOf{};
  std::array<double, 3> fraction{};
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
    base += stride[a] * static_cast<int>(floor);
    const Coord rest = position - (floor << up);
    if (rest != 0)
    {
      fraction[hangs] = static_cast<double>(rest) / static_cast<double>(Coord(1) << up);
      strideOf[hangs++] = stride[a];
    }
  }
  double sum = 0.;
  for (int corner = 0; corner < 1 << hangs; ++corner)
  {
    double weight = 1.;
    int v = base;
    for (int d = 0; d < hangs; ++d)
    {
      const bool upper = corner >> d & 1;
      weight *= upper ? fraction[d] : 1. - fraction[d];
      v += upper ? strideOf[d] : 0;
    }
    BlockVertexMask one{};
    add(one, v);
    sum += weight * withSpecial(path, coarsest - 1, one).special[v];
  }
  return sum;
}

void BlockEvaluator::evaluate(const BlockPath& path, BlockCells cells) noexcept
{
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
  const BlockVertexMask special = verticesTouching(level->refined | level->coarse | level->none);
  computeSpecial(path, depth, *level, both(special, verticesOf(drawn_)), values_.data());
}

Range BlockEvaluator::bounds(const BlockPath& path) noexcept
{
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
    std::array<float, 125> rounded;
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
  for (std::uint64_t rest = ~level.none; rest != 0; rest &= rest - 1)
  {
    add(level.value[std::countr_zero(rest)]);
  }
  for (std::uint64_t rest = level.refined; rest != 0; rest &= rest - 1)
  {
    const int place = std::countr_zero(rest);
    const double* values = level.childValue.data() + firstChild(place);
    unsigned touching = tables.childrenOfPlace[place] & level.children[place].exists;
    for (; touching != 0; touching &= touching - 1)
    {
      add(values[stepAlong(7, std::countr_zero(touching))]);
    }
  }
  return { static_cast<float>(low), static_cast<float>(high) };
}

void BlockEvaluator::compute(const BlockPath& path, BlockCells cells, BlockValues& block) noexcept
{
  evaluate(path, cells);
  block.range = roundValues(values_, block.values);
  if (drawn_ != 0xff)
  {
    // The middle of a drawn child stands in for what is not drawn, so that the hull is that of the rest.
    const int octant = std::countr_zero(drawn_);
    const float drawn = block.values[31 + 2 * (octant & 1) + 10 * (octant >> 1 & 1) + 50 * (octant >> 2)];
    const BlockVertexMask all{ ~std::uint64_t(0), (std::uint64_t(1) << (125 - 64)) - 1 };
    forEachVertex(without(all, verticesOf(drawn_)), [&](int vertex) { block.values[vertex] = drawn; });
    block.range = hull(block.values);
  }
}

} // namespace treeamr

#include "Interpolation/BlockValues.h"

#include "Interpolation/GTIWeights.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

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

/// The cells around a vertex.
struct BlockVertex
{
  unsigned axes = 0;                      // mask of those along which it lies between cells
  std::array<std::uint8_t, 8> slot{};     // as many as 2^axes
  std::array<std::uint8_t, 8> touching{}; // their children that touch it, should they be refined
  std::array<std::uint16_t, 8> child{};   // the same as slot * 8 + octant, slot by slot: always eight
  std::uint64_t slots = 0;                // mask
  // On the lattice of the next coarser level it is the mean of one, two or four vertices: these, counted from the
  // node's lower corner, the first again where there are fewer, with weight 0.
  std::array<std::uint8_t, 4> coarser{};
  std::array<double, 4> coarserWeight{};
};

/// The slots that a node of the neighbourhood covers, and which of its children they are.
struct BlockEntry
{
  std::uint8_t count = 0;
  std::array<std::uint8_t, 8> slot{};
  std::array<std::uint8_t, 8> octant{};
  std::uint64_t slots = 0; // mask
};

struct BlockTables
{
  std::array<BlockVertex, 125> vertex{};
  std::array<BlockVertexMask, 8> verticesOfAxes{}; // those that lie between cells along these axes alone
  std::array<BlockVertexMask, 64> verticesOfSlot{};
  std::array<std::uint8_t, 64> childrenOfSlot{}; // that touch any vertex
  std::array<BlockVertexMask, 8> verticesOfChild{};
  std::array<BlockEntry, 27> entry{};
  // By a child's octant: the slots of the node's own children's size that are its neighbourhood.
  std::array<std::array<std::uint8_t, 27>, 8> slotOfEntry{};
  std::array<std::uint64_t, 64> slotsBeside{}; // that share a vertex of the block with a slot
  // Vertices of the node itself that touch an entry, on the lattice of its parent's children, counted from the
  // node's lower corner: all in the first word.
  std::array<std::uint64_t, 27> nodeVerticesOfEntry{};
};

constexpr int slotIndex(int x, int y, int z)
{
  return x + 4 * y + 16 * z;
}

/// The slot of a node's child: along each axis slot 0 is the upper child of the lower neighbour, 1 and 2 are
/// the children of the node itself, 3 is the lower child of the upper neighbour.
constexpr BlockTables makeTables()
{
  BlockTables t{};
  for (int v = 0; v < 125; ++v)
  {
    const std::array<int, 3> at{ v % 5, v / 5 % 5, v / 25 };
    BlockVertex& b = t.vertex[v];
    std::array<int, 3> axes{};
    int dimensions = 0;
    for (int a = 0; a < 3; ++a)
    {
      if (at[a] % 2 == 0)
      {
        axes[dimensions++] = a;
        b.axes |= 1u << a;
      }
    }
    int children = 0;
    int coarserCount = 0;
    for (int corner = 0; corner < 8; ++corner)
    {
      bool distinct = true;
      int coarser = 0;
      for (int a = 2; a >= 0; --a)
      {
        const int upper = corner >> a & 1;
        distinct = distinct && (upper == 0 || at[a] % 2 != 0);
        coarser = 5 * coarser + at[a] / 2 + upper;
      }
      // The middle of a child hangs on nothing.
      if (distinct && coarserCount < 4)
      {
        b.coarser[coarserCount++] = static_cast<std::uint8_t>(coarser);
      }
    }
    for (int i = 0; i < 4; ++i)
    {
      b.coarserWeight[i] = i < coarserCount ? 1. / coarserCount : 0.;
      b.coarser[i] = i < coarserCount ? b.coarser[i] : b.coarser[0];
    }
    add(t.verticesOfAxes[b.axes], v);
    for (int s = 0; s < 1 << dimensions; ++s)
    {
      std::array<int, 3> place{ (at[0] + 1) / 2, (at[1] + 1) / 2, (at[2] + 1) / 2 };
      std::array<int, 3> side{ -1, -1, -1 };
      for (int d = 0; d < dimensions; ++d)
      {
        side[axes[d]] = s >> d & 1;
        place[axes[d]] = at[axes[d]] / 2 + side[axes[d]];
      }
      const int slot = slotIndex(place[0], place[1], place[2]);
      b.slot[s] = static_cast<std::uint8_t>(slot);
      b.slots |= std::uint64_t(1) << slot;
      add(t.verticesOfSlot[slot], v);
      for (int o = 0; o < 8; ++o)
      {
        bool touches = true;
        for (int a = 0; a < 3; ++a)
        {
          touches = touches && (side[a] < 0 || (o >> a & 1) != side[a]);
        }
        if (touches)
        {
          b.touching[s] |= static_cast<std::uint8_t>(1u << o);
          t.childrenOfSlot[slot] |= static_cast<std::uint8_t>(1u << o);
          b.child[children++] = static_cast<std::uint16_t>(8 * slot + o);
        }
      }
    }
  }
  for (const BlockVertex& b : t.vertex)
  {
    for (int s = 0; s < 1 << std::popcount(b.axes); ++s)
    {
      t.slotsBeside[b.slot[s]] |= b.slots;
    }
  }
  for (int slot = 0; slot < 64; ++slot)
  {
    const std::array<int, 3> at{ slot & 3, slot >> 2 & 3, slot >> 4 };
    BlockEntry& e = t.entry[(at[0] + 1) / 2 + 3 * ((at[1] + 1) / 2) + 9 * ((at[2] + 1) / 2)];
    e.octant[e.count] = static_cast<std::uint8_t>((~at[0] & 1) | (~at[1] & 1) << 1 | (~at[2] & 1) << 2);
    e.slot[e.count++] = static_cast<std::uint8_t>(slot);
    e.slots |= std::uint64_t(1) << slot;
  }
  for (int o = 0; o < 8; ++o)
  {
    for (int e = 0; e < 27; ++e)
    {
      t.slotOfEntry[o][e] =
        static_cast<std::uint8_t>(slotIndex((o & 1) + e % 3, (o >> 1 & 1) + e / 3 % 3, (o >> 2) + e / 9));
    }
  }
  for (int e = 0; e < 27; ++e)
  {
    const std::array<int, 3> entry{ e % 3, e / 3 % 3, e / 9 };
    for (int v = 0; v < 27; ++v)
    {
      const std::array<int, 3> at{ v % 3, v / 3 % 3, v / 9 };
      bool touches = true;
      for (int a = 0; a < 3; ++a)
      {
        touches = touches && (entry[a] == 1 || at[a] == entry[a]);
      }
      t.nodeVerticesOfEntry[e] |= static_cast<std::uint64_t>(touches) << (at[0] + 5 * at[1] + 25 * at[2]);
    }
  }
  for (int o = 0; o < 8; ++o)
  {
    t.verticesOfChild[o] = t.verticesOfSlot[slotIndex(1 + (o & 1), 1 + (o >> 1 & 1), 1 + (o >> 2))];
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

BlockVertexMask verticesOf(unsigned children) noexcept
{
  BlockVertexMask mask{};
  for (; children != 0; children &= children - 1)
  {
    add(mask, tables.verticesOfChild[std::countr_zero(children)]);
  }
  return mask;
}

BlockVertexMask verticesTouching(std::uint64_t slots) noexcept
{
  BlockVertexMask mask{};
  for (; slots != 0; slots &= slots - 1)
  {
    add(mask, tables.verticesOfSlot[std::countr_zero(slots)]);
  }
  return mask;
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

/// A vertex between leaves and refined nodes of one level. Leaves have eight equal children here.
template <unsigned Axes, class Level>
double onLattice(const Level& level, const BlockVertex& b) noexcept
{
  constexpr int count = 1 << std::popcount(Axes);
  constexpr int children = 8 / count;
  const double* values = level.childValue[0].data();
  const double* weights = weightsOf<Axes>(aroundVertex<Axes>(level.refined >> b.slot[0]));
  double sum = 0.;
  for (int s = 0; s < count; ++s)
  {
    double data = 0.;
    for (int c = 0; c < children; ++c)
    {
      data += values[b.child[children * s + c]];
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
  unsigned present = 0;
  unsigned refined = 0;
  for (int s = 0; s < count; ++s)
  {
    const int slot = b.slot[s];
    const unsigned touching = b.touching[s] & level.childExists[slot];
    if (touching == 0)
    {
      continue;
    }
    for (unsigned rest = touching; rest != 0; rest &= rest - 1)
    {
      data[s] += level.childValue[slot][std::countr_zero(rest)];
    }
    data[s] /= std::popcount(touching);
    present |= 1u << s;
    refined |= static_cast<unsigned>(level.refined >> slot & 1) << s;
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

std::array<float, 125> rounded(const std::array<double, 125>& values) noexcept
{
  std::array<float, 125> floats;
  for (int i = 0; i < 125; ++i)
  {
    floats[i] = static_cast<float>(values[i]);
  }
  return floats;
}

/// In sixteen interleaved parts, which compilers vectorise; the last overlaps the one before.
Range hull(const std::array<float, 125>& values) noexcept
{
  constexpr int width = 16;
  std::array<float, width> low;
  std::array<float, width> high;
  std::copy_n(values.end() - width, width, low.begin());
  high = low;
  for (int part = 0; part + width <= 125; part += width)
  {
    for (int i = 0; i < width; ++i)
    {
      const float v = values[part + i];
      low[i] = v < low[i] ? v : low[i];
      high[i] = v > high[i] ? v : high[i];
    }
  }
  return { *std::min_element(low.begin(), low.end()), *std::max_element(high.begin(), high.end()) };
}

template <unsigned Axes, class Level>
double latticeValue(const Level& level, const BlockVertex& b) noexcept
{
  return (b.slots & level.missing) == 0 ? onLattice<Axes>(level, b) : onSparseLattice<Axes>(level, b);
}

} // namespace

void BlockEvaluator::gather(
  const BlockPath& path, int depth, const Level* parent, Level& level) const noexcept
{
  const bool byMeans = &level == &byMeans_;
  const float* leaves = field_.leafValues().data();
  level.node = path.node[depth];
  level.refined = level.coarse = level.none = 0;
  level.coarseEntries = 0;
  level.coarsest = depth;
  level.known = {};
  level.hasChildValues = level.hasLeaves = false;
  const auto gatherLeaf = [&](const BlockEntry& part, std::size_t entry, int leafDepth, double value) {
    level.coarse |= part.slots;
    level.coarseEntries |= 1u << entry;
    level.coarsest = std::min(level.coarsest, leafDepth);
    for (int i = 0; i < part.count; ++i)
    {
      level.value[part.slot[i]] = value;
      level.depth[part.slot[i]] = static_cast<std::uint8_t>(leafDepth);
    }
  };
  const auto gatherInner = [&]<std::size_t Entry>(const Octree::Children& children) {
    constexpr BlockEntry part = tables.entry[Entry];
    if (children.allLeaves())
    {
      const float* values = leaves + children.firstLeaf;
      for (int i = 0; i < part.count; ++i)
      {
        level.value[part.slot[i]] = values[part.octant[i]];
      }
      return;
    }
    for (int i = 0; i < part.count; ++i)
    {
      const int slot = part.slot[i];
      const int octant = part.octant[i];
      const unsigned bit = 1u << octant;
      if (children.leaf & bit)
      {
        level.value[slot] = leaves[children.leafIndex(octant)];
        continue;
      }
      level.value[slot] = 0.;
      if (!(children.exists & bit))
      {
        level.none |= std::uint64_t(1) << slot;
        continue;
      }
      const std::uint64_t inner = children.innerIndex(octant);
      level.value[slot] = field_.value({ NodeKind::Inner, 0, inner });
      if (!byMeans)
      {
        level.refined |= std::uint64_t(1) << slot;
        level.children[slot] = octree_.children(inner);
        prefetch(leaves + level.children[slot].firstLeaf);
      }
    }
  };
  const auto gatherEntry = [&]<std::size_t Entry>() {
    constexpr BlockEntry part = tables.entry[Entry];
    const int slot = parent ? tables.slotOfEntry[path.octant[depth - 1]][Entry] : -1;
    if (parent ? (parent->refined >> slot & 1) != 0 : Entry == 13)
    {
      gatherInner.template operator()<Entry>(parent ? parent->children[slot] : octree_.children(level.node));
    }
    else if (!parent || (parent->none >> slot & 1))
    {
      level.none |= part.slots;
      for (int i = 0; i < part.count; ++i)
      {
        level.value[part.slot[i]] = 0.;
      }
    }
    else
    {
      gatherLeaf(part, Entry, parent->coarse >> slot & 1 ? parent->depth[slot] : depth, parent->value[slot]);
    }
  };
  // Unrolled: which places an entry covers is known to the compiler.
  [&]<std::size_t... Entry>(std::index_sequence<Entry...>)
  {
    (gatherEntry.template operator()<Entry>(), ...);
  }
  (std::make_index_sequence<27>());
  level.missing = level.none;
  level.hanging = verticesTouching(level.coarse);
}

/// Of the refined cells, what their vertices see of them.
void BlockEvaluator::gatherChildValues(Level& level) const noexcept
{
  if (level.hasChildValues)
  {
    return;
  }
  const float* leaves = field_.leafValues().data();
  for (std::uint64_t slots = level.refined; slots != 0; slots &= slots - 1)
  {
    const int slot = std::countr_zero(slots);
    const Octree::Children& children = level.children[slot];
    std::array<double, 8>& values = level.childValue[slot];
    level.childExists[slot] = static_cast<std::uint8_t>(children.exists);
    if (children.allLeaves())
    {
      for (int o = 0; o < 8; ++o)
      {
        values[o] = leaves[children.firstLeaf + o];
      }
      continue;
    }
    const unsigned wanted = tables.childrenOfSlot[slot];
    level.missing |= static_cast<std::uint64_t>((wanted & ~children.exists) != 0) << slot;
    for (unsigned rest = wanted & children.exists; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      values[octant] = children.leaf >> octant & 1
        ? leaves[children.leafIndex(octant)]
        : field_.value({ NodeKind::Inner, 0, children.innerIndex(octant) });
    }
  }
  level.hasChildValues = true;
}

/// Leaves beside refined cells as if they had children, so that vertices need not ask which is which.
void BlockEvaluator::fillLeaves(Level& level) const noexcept
{
  if (level.hasLeaves)
  {
    return;
  }
  std::uint64_t beside = level.missing != 0 ? ~std::uint64_t(0) : 0;
  for (std::uint64_t slots = level.refined; slots != 0; slots &= slots - 1)
  {
    beside |= tables.slotsBeside[std::countr_zero(slots)];
  }
  for (std::uint64_t slots = beside & ~level.refined; slots != 0; slots &= slots - 1)
  {
    const int slot = std::countr_zero(slots);
    level.childExists[slot] = level.none >> slot & 1 ? 0 : 0xff;
    level.childValue[slot].fill(level.value[slot]);
  }
  level.hasLeaves = true;
}

/// Of the path's node at a depth.
BlockEvaluator::Level& BlockEvaluator::levelAt(const BlockPath& path, int depth) noexcept
{
  Level& level = levels_[depth];
  if (level.node != path.node[depth])
  {
    gather(path, depth, depth == 0 ? nullptr : &levelAt(path, depth - 1), level);
  }
  return level;
}

/// As if all 64 were leaves of one size: means along one axis after the other.
void BlockEvaluator::uniformValues(const Level& level) noexcept
{
  std::array<double, 5 * 16> x;  // x, slots of y and z
  std::array<double, 25 * 4> xy; // x, y, slots of z
  for (int row = 0; row < 16; ++row)
  {
    const double* s = level.value.data() + 4 * row;
    double* v = x.data() + 5 * row;
    v[0] = 0.5 * (s[0] + s[1]);
    v[1] = s[1];
    v[2] = 0.5 * (s[1] + s[2]);
    v[3] = s[2];
    v[4] = 0.5 * (s[2] + s[3]);
  }
  const auto expand = [](const double* s, double* v, int width) {
    for (int i = 0; i < width; ++i)
    {
      v[i] = 0.5 * (s[i] + s[width + i]);
      v[width + i] = s[width + i];
      v[2 * width + i] = 0.5 * (s[width + i] + s[2 * width + i]);
      v[3 * width + i] = s[2 * width + i];
      v[4 * width + i] = 0.5 * (s[2 * width + i] + s[3 * width + i]);
    }
  };
  for (int plane = 0; plane < 4; ++plane)
  {
    expand(x.data() + 20 * plane, xy.data() + 25 * plane, 5);
  }
  expand(xy.data(), values_.data(), 25);
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
    if (level.coarsest == depth)
    {
      const int octant = path.octant[depth - 1];
      const int corner = 2 * (octant & 1) + 10 * (octant >> 1 & 1) + 50 * (octant >> 2);
      std::uint64_t around = 0;
      for (std::uint32_t rest = level.coarseEntries; rest != 0; rest &= rest - 1)
      {
        around |= tables.nodeVerticesOfEntry[std::countr_zero(rest)];
      }
      const Level& coarser =
        withSpecial(path, depth - 1, { around << corner, corner == 0 ? 0 : around >> (64 - corner) });
      const double* values = coarser.special.data() + corner;
      forEachVertex(hanging, [&](int vertex) {
        const BlockVertex& b = tables.vertex[vertex];
        double sum = b.coarserWeight[0] * values[b.coarser[0]];
        for (int i = 1; i < 4; ++i)
        {
          sum += b.coarserWeight[i] * values[b.coarser[i]];
        }
        out[vertex] = sum;
      });
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
  gatherChildValues(level);
  fillLeaves(level);
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

/// Where leaves may be larger than the node itself.
double BlockEvaluator::hangingDeep(const BlockPath& path, int depth, const Level& level, int vertex) noexcept
{
  int coarsest = depth;
  for (std::uint64_t slots = tables.vertex[vertex].slots & level.coarse; slots != 0; slots &= slots - 1)
  {
    coarsest = std::min<int>(coarsest, level.depth[std::countr_zero(slots)]);
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
    gather(path, depth, depth == 0 ? nullptr : &levelAt(path, depth - 1), byMeans_);
  }
  uniformValues(*level);
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
  if (level.coarsest < path.depth)
  {
    // Vertices may depend on cells that are not around the node.
    BlockValues block;
    compute(path, BlockCells::Leaves, block);
    return block.range;
  }
  if ((level.refined | level.coarse | level.none) == 0)
  {
    uniformValues(level);
    return hull(rounded(values_));
  }
  gatherChildValues(level);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto add = [&](double value) {
    low = value < low ? value : low;
    high = value > high ? value : high;
  };
  // Of refined ones the means: vertices of the node's own level see these.
  for (std::uint64_t slots = ~level.none; slots != 0; slots &= slots - 1)
  {
    add(level.value[std::countr_zero(slots)]);
  }
  for (std::uint64_t slots = level.refined; slots != 0; slots &= slots - 1)
  {
    const int slot = std::countr_zero(slots);
    unsigned touching = tables.childrenOfSlot[slot] & level.childExists[slot];
    for (; touching != 0; touching &= touching - 1)
    {
      add(level.childValue[slot][std::countr_zero(touching)]);
    }
  }
  return { static_cast<float>(low), static_cast<float>(high) };
}

namespace
{

/// The middle of a drawn child stands in for what is not drawn, so that the hull is that of the rest.
template <class T>
void fillUndrawn(std::array<T, 125>& values, unsigned drawn) noexcept
{
  if (drawn != 0xff)
  {
    const int octant = std::countr_zero(drawn);
    const T value = values[31 + 2 * (octant & 1) + 10 * (octant >> 1 & 1) + 50 * (octant >> 2)];
    const BlockVertexMask all{ ~std::uint64_t(0), (std::uint64_t(1) << (125 - 64)) - 1 };
    forEachVertex(without(all, verticesOf(drawn)), [&](int vertex) { values[vertex] = value; });
  }
}

} // namespace

void BlockEvaluator::compute(const BlockPath& path, BlockCells cells, BlockValues& block) noexcept
{
  evaluate(path, cells);
  block.values = rounded(values_);
  fillUndrawn(block.values, drawn_);
  block.range = hull(block.values);
}

void BlockEvaluator::computeUnrounded(const BlockPath& path, std::array<double, 125>& values) noexcept
{
  evaluate(path, BlockCells::Leaves);
  values = values_;
  fillUndrawn(values, drawn_);
}

} // namespace treeamr

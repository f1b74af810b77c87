#include "Interpolation/BlockValues.h"

#include "Interpolation/GTIWeights.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace treeamr
{

namespace
{

/// Bit v: vertex v of a block.
struct VertexMask
{
  std::array<std::uint64_t, 2> bits{};

  constexpr void set(int v) { bits[v >> 6] |= std::uint64_t(1) << (v & 63); }
  constexpr VertexMask& operator|=(const VertexMask& other)
  {
    bits[0] |= other.bits[0];
    bits[1] |= other.bits[1];
    return *this;
  }
};

/// The cells around a vertex.
struct BlockVertex
{
  std::uint8_t dimensions = 0;           // axes along which it lies between cells
  std::array<std::uint8_t, 8> slot{};    // 2^dimensions of them
  std::array<std::uint8_t, 8> touching{}; // their children that touch it, should they be refined
  std::uint64_t slots = 0;               // mask
};

struct BlockTables
{
  std::array<BlockVertex, 125> vertex{};
  std::array<VertexMask, 64> verticesOfSlot{};
  std::array<VertexMask, 8> verticesOfChild{};
  std::array<std::uint64_t, 27> slotsOfEntry{}; // of a neighbourhood
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
    for (int a = 0; a < 3; ++a)
    {
      if (at[a] % 2 == 0)
      {
        axes[b.dimensions++] = a;
      }
    }
    for (int s = 0; s < 1 << b.dimensions; ++s)
    {
      std::array<int, 3> place{ (at[0] + 1) / 2, (at[1] + 1) / 2, (at[2] + 1) / 2 };
      std::array<int, 3> side{ -1, -1, -1 };
      for (int d = 0; d < b.dimensions; ++d)
      {
        side[axes[d]] = s >> d & 1;
        place[axes[d]] = at[axes[d]] / 2 + side[axes[d]];
      }
      const int slot = slotIndex(place[0], place[1], place[2]);
      b.slot[s] = static_cast<std::uint8_t>(slot);
      b.slots |= std::uint64_t(1) << slot;
      t.verticesOfSlot[slot].set(v);
      for (int o = 0; o < 8; ++o)
      {
        bool touches = true;
        for (int a = 0; a < 3; ++a)
        {
          touches = touches && (side[a] < 0 || (o >> a & 1) != side[a]);
        }
        b.touching[s] |= static_cast<std::uint8_t>(touches << o);
      }
    }
  }
  for (int slot = 0; slot < 64; ++slot)
  {
    const std::array<int, 3> at{ slot & 3, slot >> 2 & 3, slot >> 4 };
    t.slotsOfEntry[(at[0] + 1) / 2 + 3 * ((at[1] + 1) / 2) + 9 * ((at[2] + 1) / 2)] |= std::uint64_t(1)
      << slot;
  }
  for (int o = 0; o < 8; ++o)
  {
    t.verticesOfChild[o] = t.verticesOfSlot[slotIndex(1 + (o & 1), 1 + (o >> 1 & 1), 1 + (o >> 2))];
  }
  return t;
}

constexpr BlockTables tables = makeTables();

constexpr int octantOfSlot(int slot)
{
  return (~slot & 1) | (~slot >> 2 & 1) << 1 | (~slot >> 4 & 1) << 2;
}

template <class F>
void forEachBit(std::uint64_t bits, const F& f)
{
  for (; bits != 0; bits &= bits - 1)
  {
    f(std::countr_zero(bits));
  }
}

VertexMask verticesOf(unsigned children) noexcept
{
  VertexMask mask;
  forEachBit(children, [&](int octant) { mask |= tables.verticesOfChild[octant]; });
  return mask;
}

const double* weightsOf(int dimensions, unsigned refined) noexcept
{
  static constexpr double one = 1.;
  switch (dimensions)
  {
    case 0:
      return &one;
    case 1:
      return gtiWeights1[refined].data();
    case 2:
      return gtiWeights2[refined].data();
    default:
      return gtiWeights3[refined].data();
  }
}

} // namespace

void BlockEvaluator::gatherSlots(const TreePath& path) noexcept
{
  const int depth = path.depth();
  const Neighbourhood& around = path.around(depth);
  const Octree::Children own = octree_.children(path.node().index());
  drawn_ = own.leaf != 0 ? own.leaf : own.exists;
  // Without leaf children, whatever is refined stands for itself by its mean.
  const bool byMeans = own.leaf == 0;
  const std::vector<float>& leaves = field_.leafValues();
  refined_ = coarse_ = missing_ = 0;
  deepJump_ = false;
  for (int e = 0; e < 27; ++e)
  {
    const NodeRef node = around[e];
    const std::uint64_t slots = tables.slotsOfEntry[e];
    if (!node.isInner())
    {
      (node.isLeaf() ? coarse_ : missing_) |= slots;
      deepJump_ = deepJump_ || (node.isLeaf() && node.depth() < depth);
      continue;
    }
    const Octree::Children children = octree_.children(node.index());
    forEachBit(slots, [&](int slot) {
      const int octant = octantOfSlot(slot);
      const unsigned bit = 1u << octant;
      if (children.leaf & bit)
      {
        slot_[slot] = leaves[children.leafIndex(octant)];
      }
      else if (!(children.exists & bit))
      {
        missing_ |= std::uint64_t(1) << slot;
      }
      else
      {
        inner_[slot] = children.innerIndex(octant);
        if (byMeans)
        {
          slot_[slot] = field_.value({ NodeKind::Inner, depth + 1, inner_[slot] });
        }
        else
        {
          refined_ |= std::uint64_t(1) << slot;
        }
      }
    });
  }
  forEachBit(refined_ | coarse_ | missing_, [&](int slot) { slot_[slot] = 0.; });
}

/// As if all 64 were leaves of one size: means along one axis after the other.
void BlockEvaluator::uniformValues() noexcept
{
  std::array<double, 5 * 16> x;  // x, slots of y and z
  std::array<double, 25 * 4> xy; // x, y, slots of z
  for (int row = 0; row < 16; ++row)
  {
    const double* s = slot_.data() + 4 * row;
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

double BlockEvaluator::onLattice(int vertex) const noexcept
{
  const BlockVertex& b = tables.vertex[vertex];
  const int count = 1 << b.dimensions;
  std::array<double, 8> data;
  unsigned present = 0;
  unsigned refined = 0;
  for (int s = 0; s < count; ++s)
  {
    const int slot = b.slot[s];
    if (missing_ >> slot & 1)
    {
      continue;
    }
    if (!(refined_ >> slot & 1))
    {
      data[s] = slot_[slot];
      present |= 1u << s;
      continue;
    }
    const Octree::Children children = octree_.children(inner_[slot]);
    const unsigned touching = b.touching[s] & children.exists;
    if (touching == 0)
    {
      continue;
    }
    double sum = 0.;
    int summands = 0;
    for (unsigned rest = touching; rest != 0; rest &= rest - 1)
    {
      const int octant = std::countr_zero(rest);
      sum += children.leaf >> octant & 1
        ? field_.leafValues()[children.leafIndex(octant)]
        : field_.value({ NodeKind::Inner, 0, children.innerIndex(octant) });
      ++summands;
    }
    data[s] = sum / summands;
    present |= 1u << s;
    refined |= 1u << s;
  }
  const double* weights = weightsOf(b.dimensions, refined);
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

/// On the face or edge of a leaf of the node's size: from the vertices of the node itself.
double BlockEvaluator::hanging(const TreePath& path, int vertex) noexcept
{
  const int depth = path.depth();
  const std::array<int, 3> at{ vertex % 5, vertex / 5 % 5, vertex / 25 };
  constexpr std::array<int, 3> stride{ 1, 3, 9 };
  int base = 0;
  int hangs = 0;
  std::array<int, 3> strideOf{};
  for (int a = 0; a < 3; ++a)
  {
    base += stride[a] * (at[a] / 2);
    if (at[a] % 2 != 0)
    {
      strideOf[hangs++] = stride[a];
    }
  }
  double sum = 0.;
  for (int corner = 0; corner < 1 << hangs; ++corner)
  {
    int v = base;
    for (int d = 0; d < hangs; ++d)
    {
      v += corner >> d & 1 ? strideOf[d] : 0;
    }
    sum += memo_.get(
      depth, path.node(), v, [&]() noexcept { return latticeVertex(path, depth, v, field_, memo_); });
  }
  return sum / (1 << hangs);
}

void BlockEvaluator::correctValues(const TreePath& path) noexcept
{
  VertexMask special;
  forEachBit(refined_ | coarse_ | missing_, [&](int slot) { special |= tables.verticesOfSlot[slot]; });
  const VertexMask wanted = verticesOf(drawn_);
  for (int word = 0; word < 2; ++word)
  {
    forEachBit(special.bits[word] & wanted.bits[word], [&](int bit) {
      const int vertex = 64 * word + bit;
      values_[vertex] =
        (tables.vertex[vertex].slots & coarse_) != 0 ? hanging(path, vertex) : onLattice(vertex);
    });
  }
}

/// The general way, for level jumps of more than one.
void BlockEvaluator::leafByLeaf(TreePath& path) noexcept
{
  forEachBit(drawn_, [&](int octant) {
    path.descend(octant);
    const int corner = 2 * (octant & 1) + 10 * (octant >> 1 & 1) + 50 * (octant >> 2);
    for (int v = 0; v < 27; ++v)
    {
      values_[corner + v % 3 + 5 * (v / 3 % 3) + 25 * (v / 9)] =
        latticeVertex(path, path.depth(), v, field_, memo_);
    }
    path.ascend();
  });
}

void BlockEvaluator::evaluate(TreePath& path) noexcept
{
  gatherSlots(path);
  if (deepJump_)
  {
    leafByLeaf(path);
    return;
  }
  uniformValues();
  if ((refined_ | coarse_ | missing_) != 0)
  {
    correctValues(path);
  }
}

Range BlockEvaluator::rangeOfDrawn() const noexcept
{
  if (drawn_ == 0xff)
  {
    // Plane by plane, which compilers vectorise.
    std::array<double, 25> low;
    std::array<double, 25> high;
    std::copy_n(values_.begin(), 25, low.begin());
    std::copy_n(values_.begin(), 25, high.begin());
    for (int plane = 1; plane < 5; ++plane)
    {
      for (int i = 0; i < 25; ++i)
      {
        const double v = values_[25 * plane + i];
        low[i] = v < low[i] ? v : low[i];
        high[i] = v > high[i] ? v : high[i];
      }
    }
    return { static_cast<float>(*std::min_element(low.begin(), low.end())),
      static_cast<float>(*std::max_element(high.begin(), high.end())) };
  }
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const VertexMask wanted = verticesOf(drawn_);
  for (int word = 0; word < 2; ++word)
  {
    forEachBit(wanted.bits[word], [&](int bit) {
      low = std::min(low, values_[64 * word + bit]);
      high = std::max(high, values_[64 * word + bit]);
    });
  }
  return { static_cast<float>(low), static_cast<float>(high) };
}

Range BlockEvaluator::hull(TreePath& path) noexcept
{
  evaluate(path);
  return rangeOfDrawn();
}

void BlockEvaluator::compute(TreePath& path, BlockValues& block) noexcept
{
  evaluate(path);
  block.range = rangeOfDrawn();
  if (drawn_ == 0xff)
  {
    std::copy(values_.begin(), values_.end(), block.values.begin());
    return;
  }
  block.values.fill(block.range.min);
  const VertexMask wanted = verticesOf(drawn_);
  for (int word = 0; word < 2; ++word)
  {
    forEachBit(wanted.bits[word], [&](int bit) {
      block.values[64 * word + bit] = static_cast<float>(values_[64 * word + bit]);
    });
  }
}

} // namespace treeamr

// V(v) of Generalized Trilinear Interpolation for any level jump and missing cells. The paper (section 5)
// shows the 2:1 case; larger jumps follow from two statements that depend on the vertex and the tree alone:
// the coarsest leaf that touches a vertex decides the level at which it is evaluated, and a vertex that hangs
// on a coarser face or edge is interpolated from that level's vertices.
#include "Interpolation/VertexValues.h"

#include "Interpolation/GTIWeights.h"

#include <algorithm>
#include <bit>

namespace treeamr
{

namespace
{

/// One of the cells around a vertex: its place in a neighbourhood and, should it be refined, its children
/// that touch the vertex.
struct Slot
{
  std::uint8_t entry;
  std::uint8_t children; // mask of octants
};

struct VertexSlots
{
  std::uint8_t dimensions; // axes along which the vertex separates slots
  std::uint32_t entries;   // mask of the slots' places in a neighbourhood
  std::array<Slot, 8> slot;
};

constexpr std::array<VertexSlots, 27> makeVertexSlots()
{
  std::array<VertexSlots, 27> table{};
  for (int v = 0; v < 27; ++v)
  {
    const std::array<int, 3> at{ v % 3, v / 3 % 3, v / 9 };
    VertexSlots& t = table[v];
    std::array<int, 3> axes{};
    for (int a = 0; a < 3; ++a)
    {
      if (at[a] != 1)
      {
        axes[t.dimensions++] = a;
      }
    }
    for (int s = 0; s < 1 << t.dimensions; ++s)
    {
      std::array<int, 3> entry{ 1, 1, 1 };
      std::array<int, 3> side{ -1, -1, -1 };
      for (int d = 0; d < t.dimensions; ++d)
      {
        side[axes[d]] = s >> d & 1;
        entry[axes[d]] = (at[axes[d]] == 0 ? 0 : 1) + side[axes[d]];
      }
      t.slot[s].entry = static_cast<std::uint8_t>(entry[0] + 3 * entry[1] + 9 * entry[2]);
      t.entries |= 1u << t.slot[s].entry;
      for (int o = 0; o < 8; ++o)
      {
        bool touches = true;
        for (int a = 0; a < 3; ++a)
        {
          // The slot on the lower side touches the vertex with its upper children, and the other way round.
          touches = touches && (side[a] < 0 || (o >> a & 1) != side[a]);
        }
        t.slot[s].children |= static_cast<std::uint8_t>(touches << o);
      }
    }
  }
  return table;
}

constexpr std::array<VertexSlots, 27> vertexSlots = makeVertexSlots();

template <VertexRule Rule>
class Evaluator
{
public:
  Evaluator(const TreePath& path, const Field& field, VertexMemo& memo) noexcept
    : path_(path)
    , field_(field)
    , memo_(memo)
  {
  }

  /// The vertex of the path's node at `depth`; some leaf of that depth or coarser touches it.
  double value(int depth, int vertex) const noexcept
  {
    const VertexSlots& slots = vertexSlots[vertex];
    const Neighbourhood& around = path_.around(depth);
    int coarsest = depth;
    for (int s = 0; s < 1 << slots.dimensions; ++s)
    {
      const NodeRef node = around[slots.slot[s].entry];
      coarsest = node.isLeaf() ? std::min(coarsest, node.depth()) : coarsest;
    }
    return coarsest == depth ? onLattice(around, slots) : fromCoarser(depth, vertex, coarsest);
  }

  /// A vertex between leaves and refined nodes of one level, given by the slots of a neighbourhood.
  double onLattice(const Neighbourhood& around, const VertexSlots& slots) const noexcept;

private:
  /// Interpolates between the vertices of a coarser level around this one, all of them vertices of the
  /// path's node at that depth, because that node touches this vertex.
  double fromCoarser(int depth, int vertex, int coarser) const noexcept
  {
    const int up = depth - coarser;
    const std::array<int, 3> at{ vertex % 3, vertex / 3 % 3, vertex / 9 };
    constexpr std::array<int, 3> stride{ 1, 3, 9 };
    int base = 0;
    std::array<double, 3> fraction{};
    std::array<int, 3> strideOf{};
    int hanging = 0;
    for (int a = 0; a < 3; ++a)
    {
      const Coord position = 2 * path_.index(depth)[a] + at[a]; // in half widths
      const Coord floor = position >> up;
      base += stride[a] * static_cast<int>(floor - 2 * path_.index(coarser)[a]);
      const Coord rest = position - (floor << up);
      if (rest != 0)
      {
        fraction[hanging] = static_cast<double>(rest) / static_cast<double>(Coord(1) << up);
        strideOf[hanging++] = stride[a];
      }
    }
    double sum = 0.;
    for (int corner = 0; corner < 1 << hanging; ++corner)
    {
      double weight = 1.;
      int v = base;
      for (int d = 0; d < hanging; ++d)
      {
        const bool upper = corner >> d & 1;
        weight *= upper ? fraction[d] : 1. - fraction[d];
        v += upper ? strideOf[d] : 0;
      }
      sum += weight *
        memo_.get(coarser, path_.around(coarser)[13], v, [&]() noexcept { return value(coarser, v); });
    }
    return sum;
  }

  /// False when no cell of the slot touches the vertex.
  bool slotValue(NodeRef node, unsigned touching, double& value) const noexcept
  {
    if (node.isLeaf())
    {
      value = field_.relative(node);
      return true;
    }
    double sum = 0.;
    int count = 0;
    for (; touching != 0; touching &= touching - 1)
    {
      const NodeRef child = path_.octree().child(node, std::countr_zero(touching));
      if (!child.isNone())
      {
        sum += field_.relative(child);
        ++count;
      }
    }
    value = sum / count;
    return count != 0;
  }

  static const double* weightsOf(int dimensions, unsigned refined) noexcept
  {
    if constexpr (Rule == VertexRule::Octant)
    {
      refined = 0; // as if all were at one distance: equal weights
    }
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

  const TreePath& path_;
  const Field& field_;
  VertexMemo& memo_;
};

template <VertexRule Rule>
double Evaluator<Rule>::onLattice(const Neighbourhood& around, const VertexSlots& slots) const noexcept
{
  const int count = 1 << slots.dimensions;
  std::array<double, 8> data;
  unsigned present = 0;
  unsigned refined = 0;
  for (int s = 0; s < count; ++s)
  {
    const NodeRef node = around[slots.slot[s].entry];
    const bool has = !node.isNone() && slotValue(node, slots.slot[s].children, data[s]);
    present |= static_cast<unsigned>(has) << s;
    refined |= static_cast<unsigned>(has && node.isInner()) << s;
  }
  const double* weights = weightsOf(slots.dimensions, refined);
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

/// Where all 27 cells are leaves of one level every vertex is a mean, and a mean of means along one axis
/// after the other. In double precision the sums are exact for values of like size, so a neighbour that takes
/// the general way gets the same bits.
VertexValues uniformValues(std::array<double, 27> v) noexcept
{
  for (int stride = 1; stride < 27; stride *= 3)
  {
    for (int i = 0; i < 27; ++i)
    {
      if (i / stride % 3 == 1)
      {
        v[i - stride] = 0.5 * (v[i - stride] + v[i]);
        v[i + stride] = 0.5 * (v[i + stride] + v[i]);
      }
    }
  }
  VertexValues values;
  std::copy(v.begin(), v.end(), values.begin());
  return values;
}

/// The cells around a leaf, and its vertices from them.
template <VertexRule Rule>
class LeafVertices
{
public:
  /// entries: mask of those of the neighbourhood that the vertices to be asked for touch.
  LeafVertices(const TreePath& path, const Field& field, VertexMemo& memo, std::uint32_t entries) noexcept
    : around_(path.around(path.depth()))
    , depth_(path.depth())
    , evaluator_(path, field, memo)
    , entries_(entries)
  {
    for (; entries != 0; entries &= entries - 1)
    {
      const int e = std::countr_zero(entries);
      const NodeRef node = around_[e];
      cells_[e] = node.isLeaf() ? field.relative(node) : 0.;
      sameLevel_ |= static_cast<std::uint32_t>(node.isLeaf() && node.depth() == depth_) << e;
      coarser_ |= static_cast<std::uint32_t>(node.isLeaf() && node.depth() < depth_) << e;
    }
  }

  /// Whether all of the cells are leaves of the leaf's level.
  bool isUniform() const noexcept { return sameLevel_ == entries_; }
  const std::array<double, 27>& cells() const noexcept { return cells_; }

  float operator()(int vertex) const noexcept
  {
    const VertexSlots& slots = vertexSlots[vertex];
    if ((slots.entries & ~sameLevel_) != 0)
    {
      return static_cast<float>((slots.entries & coarser_) != 0 ? evaluator_.value(depth_, vertex)
                                                                : evaluator_.onLattice(around_, slots));
    }
    double sum = 0.;
    for (int s = 0; s < 1 << slots.dimensions; ++s)
    {
      sum += cells_[slots.slot[s].entry];
    }
    return static_cast<float>(sum / (1 << slots.dimensions));
  }

private:
  const Neighbourhood& around_;
  int depth_;
  Evaluator<Rule> evaluator_;
  std::uint32_t entries_;
  std::array<double, 27> cells_;
  std::uint32_t sameLevel_ = 0; // mask of leaves of this level
  std::uint32_t coarser_ = 0;   // and of coarser ones
};

/// The cells around one octant: 2 x 2 x 2 of the neighbourhood, as mask of entries by the octant.
constexpr std::array<std::uint32_t, 8> entriesOfOctant = [] {
  std::array<std::uint32_t, 8> masks{};
  for (int octant = 0; octant < 8; ++octant)
  {
    for (int c = 0; c < 8; ++c)
    {
      masks[octant] |= 1u << (cornerOffset(octant, leafVertexStride) + cornerOffset(c, leafVertexStride));
    }
  }
  return masks;
}();

} // namespace

template <VertexRule Rule>
VertexValues vertexValues(const TreePath& path, const Field& field, VertexMemo& memo) noexcept
{
  const LeafVertices<Rule> vertices(path, field, memo, (1u << 27) - 1);
  if (vertices.isUniform())
  {
    return uniformValues(vertices.cells());
  }
  VertexValues values;
  for (int v = 0; v < 27; ++v)
  {
    values[v] = vertices(v);
  }
  return values;
}

Corners octantCorners(const TreePath& path, const Field& field, VertexMemo& memo, int octant) noexcept
{
  // Entries of the neighbourhood and vertices of the leaf count alike.
  const int first = cornerOffset(octant, leafVertexStride);
  const LeafVertices<VertexRule::GTI> vertices(path, field, memo, entriesOfOctant[octant]);
  if (!vertices.isUniform())
  {
    Corners corners;
    for (int c = 0; c < 8; ++c)
    {
      corners[c] = vertices(first + cornerOffset(c, leafVertexStride));
    }
    return corners;
  }
  // As uniformValues().
  Corners corners = cornersOf(vertices.cells().data() + first, leafVertexStride);
  for (int a = 0; a < 3; ++a)
  {
    for (int c = 0; c < 8; ++c)
    {
      if (sideOf(c, a) == sideOf(octant, a)) // away from the leaf's centre
      {
        corners[c] = 0.5 * (corners[c] + corners[c ^ 1 << a]);
      }
    }
  }
  for (double& corner : corners)
  {
    corner = static_cast<float>(corner);
  }
  return corners;
}

template VertexValues vertexValues<VertexRule::GTI>(const TreePath&, const Field&, VertexMemo&) noexcept;
template VertexValues vertexValues<VertexRule::Octant>(const TreePath&, const Field&, VertexMemo&) noexcept;

} // namespace treeamr

#include "PaperPrimitives.h"

#include "Error.h"
#include "Interpolation/BlockValues.h"
#include "Interpolation/VertexValues.h"
#include "Octree/TreePath.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <string>

namespace treeamr::bench
{

namespace
{

/// Corner or octant o of a cube of a lattice of n points per axis.
constexpr int cornerOffset(int o, int n)
{
  return (o & 1) + n * (o >> 1 & 1) + n * n * (o >> 2);
}

/// The eight corners of a unit cube of a lattice of N points per axis, from the offset of the lowest.
template <int N, std::size_t Size>
std::array<float, 8> cubeValues(const std::array<float, Size>& lattice, int base) noexcept
{
  std::array<float, 8> values;
  for (int c = 0; c < 8; ++c)
  {
    values[c] = lattice[base + cornerOffset(c, N)];
  }
  return values;
}

bool contains(Range range, float isovalue) noexcept
{
  return range.min <= isovalue && isovalue <= range.max;
}

bool isActive(const std::array<float, 8>& values, float isovalue) noexcept
{
  unsigned low = 0; // counts, which vectorise
  unsigned high = 0;
  for (const float v : values)
  {
    low += v <= isovalue;
    high += v >= isovalue;
  }
  return low != 0 && high != 0;
}

/// Places 4 x 4 x 4 of the size of an inner node's children, in and around it; x + 4 y + 16 z.
struct Slots
{
  std::uint64_t drawn = 0; // mask of those with a drawn leaf of just that size
  std::array<float, 64> value;
};

/// The slots that a node of the neighbourhood covers, and which of its children they are.
struct SlotsOfEntry
{
  int count = 0;
  std::array<std::uint8_t, 8> slot{};
  std::array<std::uint8_t, 8> octant{};
};

/// Along each axis slot 0 is the upper child of the lower neighbour, 1 and 2 are the children of the node itself,
/// 3 is the lower child of the upper neighbour.
constexpr std::array<SlotsOfEntry, 27> slotsOfEntries = [] {
  std::array<SlotsOfEntry, 27> table{};
  for (int slot = 0; slot < 64; ++slot)
  {
    const std::array<int, 3> at{ slot & 3, slot >> 2 & 3, slot >> 4 };
    SlotsOfEntry& e = table[(at[0] + 1) / 2 + 3 * ((at[1] + 1) / 2) + 9 * ((at[2] + 1) / 2)];
    e.octant[e.count] = static_cast<std::uint8_t>((~at[0] & 1) | (~at[1] & 1) << 1 | (~at[2] & 1) << 2);
    e.slot[e.count++] = static_cast<std::uint8_t>(slot);
  }
  return table;
}();

constexpr std::uint64_t cubeOfSlots = [] {
  std::uint64_t mask = 0;
  for (int c = 0; c < 8; ++c)
  {
    mask |= std::uint64_t(1) << cornerOffset(c, 4);
  }
  return mask;
}();

Slots gatherSlots(const TreePath& path, const Field& field) noexcept
{
  const Octree& octree = field.octree();
  const Neighbourhood& around = path.around(path.depth());
  Slots slots;
  for (int entry = 0; entry < 27; ++entry)
  {
    if (!around[entry].isInner())
    {
      continue;
    }
    const Octree::Children children = octree.children(around[entry].index());
    const SlotsOfEntry& part = slotsOfEntries[entry];
    for (int i = 0; i < part.count; ++i)
    {
      if (children.leaf >> part.octant[i] & 1)
      {
        const std::uint64_t leaf = children.leafIndex(part.octant[i]);
        slots.value[part.slot[i]] = field.leafValues()[leaf];
        slots.drawn |= static_cast<std::uint64_t>(!octree.isGhost(leaf)) << part.slot[i];
      }
    }
  }
  return slots;
}

class Extractor
{
public:
  Extractor(const Field& field, float isovalue)
    : field_(field)
    , ranges_(field.nodeRanges())
    , octree_(field.octree())
    , isovalue_(isovalue)
    , padding_(octree_.grid().paddingDepth())
    , serialDepth_(padding_ + octree_.leafLevels() - 3)
    , states_([&field] { return State(field); })
  {
  }

  Primitives primitives(Extraction extraction)
  {
    const auto leaves = [this](TreePath& at, State& state, bool dualCells) {
      forEachLeaf(at, [&] { addLeaf(at, dualCells, state); });
    };
    switch (extraction)
    {
      case Extraction::Naive:
        walk(Nodes::All, [&](TreePath& at, State& state) { leaves(at, state, false); });
        break;
      case Extraction::DualCells:
        walk(Nodes::All, [&](TreePath& at, State& state) { leaves(at, state, true); });
        break;
      case Extraction::Filtered:
        walk(Nodes::MayHoldIsovalue, [&](TreePath& at, State& state) { addBlock(at, state); });
    }
    return joined();
  }

  std::uint64_t activeCells()
  {
    walk(Nodes::MayHoldIsovalue, [&](TreePath& at, State& state) {
      forEachLeaf(at, [&] {
        // All octants share the middle: where the hull of them holds the isovalue, one of them does.
        state.activeCells += !octree_.isGhost(at.node().index()) &&
          contains(hull(vertexValues<VertexRule::GTI>(at, field_, state.memo)), isovalue_);
      });
    });
    return std::accumulate(states_.begin(), states_.end(), std::uint64_t(0),
      [](std::uint64_t sum, const State& state) { return sum + state.activeCells; });
  }

private:
  struct State
  {
    explicit State(const Field& field)
      : evaluator(field)
    {
    }
    void add(
      const std::array<Coord, 3>& index, int level, Primitive::Kind kind, const std::array<float, 8>& values)
    {
      found.primitives.push_back(
        { { static_cast<std::uint32_t>(index[0]), static_cast<std::uint32_t>(index[1]),
            static_cast<std::uint32_t>(index[2]) },
          static_cast<std::uint8_t>(level), kind });
      found.values.push_back(values);
    }

    BlockEvaluator evaluator;
    VertexMemo memo;
    Primitives found;
    std::uint64_t activeCells = 0;
  };

  enum class Nodes
  {
    All,
    MayHoldIsovalue // by their ranges
  };

  /// Calls visit(place, state) at the inner nodes with leaves among their children, and at a root that is a leaf.
  template <class Visit>
  void walk(Nodes nodes, const Visit& visit)
  {
    TreePath at(octree_);
    if (at.node().isLeaf())
    {
      visit(at, states_.local());
    }
    else if (at.node().isInner())
    {
      walkInner(at, field_.range(), nodes, visit);
    }
  }

  template <class Visit>
  void walkInner(TreePath& at, Range parent, Nodes nodes, const Visit& visit)
  {
    const Range range = ranges_.of(at.node().index(), parent);
    if (nodes == Nodes::MayHoldIsovalue && !contains(range, isovalue_))
    {
      return;
    }
    const Octree::Children children = octree_.children(at.node().index());
    if (children.leaf != 0)
    {
      visit(at, states_.local());
    }
    const auto walkChild = [&](TreePath& own, int octant) {
      own.descend(octant);
      walkInner(own, range, nodes, visit);
      own.ascend();
    };
    if (at.depth() >= serialDepth_)
    {
      for (unsigned rest = children.inner(); rest != 0; rest &= rest - 1)
      {
        walkChild(at, std::countr_zero(rest));
      }
      return;
    }
    tbb::parallel_for(0, 8, [&](int octant) {
      if (children.inner() >> octant & 1)
      {
        TreePath own(at);
        walkChild(own, octant);
      }
    });
  }

  /// Calls visit() with the path at each leaf among a node's children, or at the node itself if it is one.
  template <class Visit>
  void forEachLeaf(TreePath& at, const Visit& visit) const
  {
    if (at.node().isLeaf())
    {
      visit();
      return;
    }
    for (unsigned rest = octree_.children(at.node().index()).leaf; rest != 0; rest &= rest - 1)
    {
      at.descend(std::countr_zero(rest));
      visit();
      at.ascend();
    }
  }

  /// Algorithm 1.
  void addLeaf(const TreePath& path, bool dualCells, State& state) const
  {
    if (octree_.isGhost(path.node().index()))
    {
      return;
    }
    const Neighbourhood& around = path.around(path.depth());
    std::uint32_t sameLevel = 0; // mask of the neighbourhood
    for (int e = 0; dualCells && e < 27; ++e)
    {
      const bool same =
        around[e].isLeaf() && around[e].depth() == path.depth() && !octree_.isGhost(around[e].index());
      sameLevel |= static_cast<std::uint32_t>(same) << e;
    }
    unsigned octants = 0; // mask of those outside dual cells
    for (int o = 0; o < 8; ++o)
    {
      std::uint32_t corners = 0;
      for (int c = 0; c < 8; ++c)
      {
        corners |= 1u << (cornerOffset(o, 3) + cornerOffset(c, 3));
      }
      octants |= static_cast<unsigned>((sameLevel & corners) != corners) << o;
    }
    const int level = path.depth() - padding_ + 1;
    const auto latticeIndex = [&](int o) {
      std::array<Coord, 3> index;
      for (int a = 0; a < 3; ++a)
      {
        index[a] = 2 * path.index()[a] + (o >> a & 1);
      }
      return index;
    };
    if (!(octants >> 7 & 1))
    {
      std::array<float, 8> values;
      for (int c = 0; c < 8; ++c)
      {
        values[c] = field_.value(around[13 + cornerOffset(c, 3)]);
      }
      if (isActive(values, isovalue_))
      {
        state.add(latticeIndex(7), level, Primitive::Kind::DualCell, values);
      }
    }
    if (octants == 0)
    {
      return;
    }
    const VertexValues vertices = vertexValues<VertexRule::GTI>(path, field_, state.memo);
    for (; octants != 0; octants &= octants - 1)
    {
      const int o = std::countr_zero(octants);
      const std::array<float, 8> values = cubeValues<3>(vertices, cornerOffset(o, 3));
      if (isActive(values, isovalue_))
      {
        state.add(latticeIndex(o), level, Primitive::Kind::Octant, values);
      }
    }
  }

  /// The same of all leaves among a node's children at once.
  void addBlock(const TreePath& at, State& state) const
  {
    if (at.node().isLeaf())
    {
      addLeaf(at, true, state);
      return;
    }
    const Slots slots = gatherSlots(at, field_);
    const int level = at.depth() - padding_ + 2;
    const auto latticeIndex = [&](int x, int y, int z) { // in half cells from the node's corner
      const std::array<Coord, 3>& index = at.index();
      return std::array<Coord, 3>{ 4 * index[0] + x, 4 * index[1] + y, 4 * index[2] + z };
    };
    std::uint32_t dualCells = 0; // mask of the places 3 x 3 x 3 that reach into the node
    for (int p = 0; p < 27; ++p)
    {
      const int x = p % 3;
      const int y = p / 3 % 3;
      const int z = p / 9;
      const int slot = x + 4 * y + 16 * z;
      if ((slots.drawn >> slot & cubeOfSlots) != cubeOfSlots)
      {
        continue;
      }
      dualCells |= 1u << p;
      const std::array<float, 8> values = cubeValues<4>(slots.value, slot);
      if (isActive(values, isovalue_) && isOurs(x, y, z, values))
      {
        state.add(latticeIndex(2 * x - 1, 2 * y - 1, 2 * z - 1), level, Primitive::Kind::DualCell, values);
      }
    }
    std::array<std::uint8_t, 64> octants; // child and octant: those outside dual cells
    int count = 0;
    for (int child = 0; child < 8; ++child)
    {
      if (!(slots.drawn >>
              (cornerOffset(1, 4) + cornerOffset(2, 4) + cornerOffset(4, 4) + cornerOffset(child, 4)) &
            1))
      {
        continue;
      }
      for (int o = 0; o < 8; ++o)
      {
        if (!(dualCells >> (cornerOffset(child, 3) + cornerOffset(o, 3)) & 1))
        {
          octants[count++] = static_cast<std::uint8_t>(8 * child + o);
        }
      }
    }
    if (count == 0)
    {
      return;
    }
    BlockValues block;
    state.evaluator.compute(BlockPath(at), BlockCells::Leaves, block);
    for (int i = 0; i < count; ++i)
    {
      const int child = octants[i] >> 3;
      const int o = octants[i] & 7;
      const std::array<float, 8> values =
        cubeValues<5>(block.values, 2 * cornerOffset(child, 5) + cornerOffset(o, 5));
      if (isActive(values, isovalue_))
      {
        state.add(latticeIndex(2 * (child & 1) + (o & 1), 2 * (child >> 1 & 1) + (o >> 1 & 1),
                    2 * (child >> 2) + (o >> 2)),
          level, Primitive::Kind::Octant, values);
      }
    }
  }

  /// Whether the node of an active dual cell's place is the one to take it: that of its first active octant, which
  /// is visited for sure.
  bool isOurs(int x, int y, int z, const std::array<float, 8>& corners) const noexcept
  {
    if (x == 1 && y == 1 && z == 1)
    {
      return true; // wholly inside
    }
    const std::array<float, 27> vertices = dualCellVertices(corners);
    int o = 0;
    while (!isActive(cubeValues<3>(vertices, cornerOffset(o, 3)), isovalue_))
    {
      ++o; // one is: they share the middle
    }
    const auto inside = [](int slot) { return slot == 1 || slot == 2; };
    return inside(x + (o & 1)) && inside(y + (o >> 1 & 1)) && inside(z + (o >> 2));
  }

  Primitives joined()
  {
    std::vector<Primitives*> parts;
    std::size_t count = 0;
    for (State& state : states_)
    {
      parts.push_back(&state.found);
      count += state.found.primitives.size();
    }
    if (parts.size() == 1)
    {
      return std::move(parts[0][0]);
    }
    Primitives all;
    all.primitives.reserve(count);
    all.values.reserve(count);
    for (Primitives* part : parts)
    {
      all.primitives.insert(all.primitives.end(), part->primitives.begin(), part->primitives.end());
      all.values.insert(all.values.end(), part->values.begin(), part->values.end());
      *part = {};
    }
    return all;
  }

  const Field& field_;
  const NodeRanges& ranges_;
  const Octree& octree_;
  float isovalue_;
  int padding_;
  int serialDepth_;
  // Whose kept values name their nodes: a thread that waits in one subtree may work in another.
  tbb::enumerable_thread_specific<State> states_;
};

} // namespace

Primitives extractPrimitives(const Field& field, float isovalue, Extraction extraction)
{
  // Twice as many half cells as cells, and the padded root's 2^32 of them must not be exceeded.
  const int depth = field.octree().grid().paddingDepth() + field.octree().leafLevels();
  if (depth > 31)
  {
    throw Error("paper primitives: cells at depth " + std::to_string(depth) + ", allowed are 31");
  }
  return Extractor(field, isovalue).primitives(extraction);
}

std::uint64_t countActiveCells(const Field& field, float isovalue)
{
  return Extractor(field, isovalue).activeCells();
}

std::array<float, 27> dualCellVertices(const std::array<float, 8>& corners) noexcept
{
  // In the order of axes in which a cell's own vertices are found, so that the bits are the same.
  std::array<double, 27> v;
  for (int c = 0; c < 8; ++c)
  {
    v[2 * cornerOffset(c, 3)] = corners[c];
  }
  for (int z = 0; z < 3; z += 2)
  {
    for (int y = 0; y < 3; y += 2)
    {
      const int i = 3 * y + 9 * z;
      v[i + 1] = 0.5 * (v[i] + v[i + 2]);
    }
    for (int x = 0; x < 3; ++x)
    {
      const int i = x + 9 * z;
      v[i + 3] = 0.5 * (v[i] + v[i + 6]);
    }
  }
  std::array<float, 27> vertices;
  for (int i = 0; i < 9; ++i)
  {
    v[i + 9] = 0.5 * (v[i] + v[i + 18]);
  }
  std::copy(v.begin(), v.end(), vertices.begin());
  return vertices;
}

} // namespace treeamr::bench

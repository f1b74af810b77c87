// Building from lists in any order and from sources, in parallel, by brute force and against each other.
#include "Octree/OctreeBuilder.h"
#include "Error.h"
#include "Field/Field.h"
#include "Octree/MortonKey.h"
#include "Octree/RadixSort.h"
#include "Support/ListSource.h"
#include "Support/ProceduralTree.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

RootGrid unitRoots(const std::array<int, 3>& roots)
{
  return RootGrid::uniform(roots, { 0., 0., 0. }, { 1., 1., 1. });
}

/// A value that tells cells apart.
float label(const CellId& c)
{
  std::uint64_t h = static_cast<std::uint64_t>(c.level);
  for (const Coord i : c.index)
  {
    h = (h ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15;
    h ^= h >> 29;
  }
  return static_cast<float>(h >> 40);
}

/// Octants from the padded root down to the cell.
std::string pathOf(const std::array<Coord, 3>& index, int depth)
{
  std::string path;
  for (int up = depth - 1; up >= 0; --up)
  {
    path +=
      static_cast<char>('0' + ((index[0] >> up & 1) | (index[1] >> up & 1) << 1 | (index[2] >> up & 1) << 2));
  }
  return path;
}

/// Every leaf is a labelled cell, and `count` of them, all different by the walk's nature, are all.
void expectLabelled(const OctreeAndValues& built, std::size_t count)
{
  ASSERT_EQ(built.octree->leafCount(), count);
  ASSERT_EQ(built.values.size(), count);
  std::size_t seen = 0;
  std::size_t wrong = 0;
  TreePath root(*built.octree);
  forEachNode(root, [&](const TreePath& p) {
    if (p.node().isLeaf())
    {
      ++seen;
      wrong += built.values[p.node().index()] !=
        label({ p.index(), p.depth() - built.octree->grid().paddingDepth() });
    }
  });
  EXPECT_EQ(seen, count);
  EXPECT_EQ(wrong, 0u);
}

void expectEqual(const Octree& a, const Octree& b)
{
  ASSERT_EQ(a.innerCount(), b.innerCount());
  ASSERT_EQ(a.leafCount(), b.leafCount());
  EXPECT_EQ(a.innerDepths(), b.innerDepths());
  EXPECT_EQ(a.leafLevels(), b.leafLevels());
  EXPECT_EQ(a.root(), b.root());
  EXPECT_EQ(a.byteSize(), b.byteSize());
  for (std::uint64_t n = 0; n < a.innerCount(); ++n)
  {
    for (int o = 0; o < 8; ++o)
    {
      ASSERT_EQ(a.child({ NodeKind::Inner, 0, n }, o), b.child({ NodeKind::Inner, 0, n }, o));
    }
  }
}

/// Cells of a tree refined everywhere to `level`, then along the diagonal to `deepest`.
std::vector<LeafCell> cellsAlongDiagonal(int level, int deepest)
{
  std::vector<LeafCell> cells;
  const Coord n = Coord(1) << level;
  const auto add = [&](const CellId& c) { cells.push_back({ c, label(c) }); };
  for (Coord k = 0; k < n; ++k)
  {
    for (Coord j = 0; j < n; ++j)
    {
      for (Coord i = 0; i < n; ++i)
      {
        CellId corner{ { i, j, k }, level };
        if (i != j || j != k || i % 8 != 5)
        {
          add(corner);
          continue;
        }
        for (; corner.level < deepest; ++corner.level)
        {
          for (auto& x : corner.index)
          {
            x = 2 * x + 1;
          }
          for (int o = 0; o < 7; ++o)
          {
            add({ { corner.index[0] - 1 + (o & 1), corner.index[1] - 1 + (o >> 1 & 1),
                    corner.index[2] - 1 + (o >> 2) },
              corner.level + 1 });
          }
        }
        add(corner);
      }
    }
  }
  return cells;
}

/// 9 x 9 x 9 roots, all leaves but one that is refined evenly, except at one corner.
struct OneLargeTree
{
  using Handle = CellId;
  int level;

  static std::size_t rootCount() { return 729; }
  static std::array<Coord, 3> rootPlace(std::size_t i)
  {
    const auto r = static_cast<Coord>(i);
    return { r % 9, r / 9 % 9, r / 81 };
  }
  static CellId root(std::size_t i) { return { rootPlace(i), 0 }; }
  NodeKind kind(const CellId& c) const
  {
    const bool refined = c.level < level && c.index[0] >> c.level == 4 && c.index[1] >> c.level == 5 &&
      c.index[2] >> c.level == 6;
    return refined ? NodeKind::Inner : NodeKind::Leaf;
  }
  static CellId child(const CellId& c, int o)
  {
    return { { 2 * c.index[0] + (o & 1), 2 * c.index[1] + (o >> 1 & 1), 2 * c.index[2] + (o >> 2) },
      c.level + 1 };
  }
  static float value(const CellId& c) { return label(c); }
  static bool ghosts() { return false; }
  static bool isGhost(const CellId&) { return false; }
};

template <class Keys>
void expectMortonOrder(int maxDepth)
{
  std::mt19937_64 random(11);
  const Keys keys(maxDepth);
  struct Cell
  {
    std::array<Coord, 3> index;
    int depth;
  };
  std::vector<Cell> cells;
  for (int i = 0; i < 400; ++i)
  {
    const int depth = static_cast<int>(random() % (maxDepth + 1));
    Cell c{ {}, depth };
    // Few different high bits: long common paths.
    for (auto& x : c.index)
    {
      x = static_cast<Coord>((random() & random() & random()) & ((std::uint64_t(1) << depth) - 1));
    }
    cells.push_back(c);
  }
  for (const Cell& a : cells)
  {
    const std::string p = pathOf(a.index, a.depth);
    const auto key = keys.key(a.index, a.depth);
    ASSERT_EQ(keys.depth(key), a.depth);
    for (int d = 1; d <= a.depth; ++d)
    {
      ASSERT_EQ(keys.octant(key, d), p[d - 1] - '0');
      const int up = a.depth - d;
      ASSERT_EQ(
        keys.index(key, d), (std::array<Coord, 3>{ a.index[0] >> up, a.index[1] >> up, a.index[2] >> up }));
    }
    ASSERT_EQ(keys.index(key, 0), (std::array<Coord, 3>{}));
    for (const Cell& b : cells)
    {
      const std::string q = pathOf(b.index, b.depth);
      const auto other = keys.key(b.index, b.depth);
      const auto common = std::mismatch(p.begin(), p.end(), q.begin(), q.end()).first - p.begin();
      const auto shorter = static_cast<std::ptrdiff_t>(std::min(p.size(), q.size()));
      if (common < shorter)
      {
        ASSERT_EQ(key < other, p < q);
        ASSERT_EQ(keys.commonDepth(key, other), common);
      }
      else
      {
        ASSERT_GE(keys.commonDepth(key, other), shorter);
        ASSERT_EQ(key == other, p.size() == q.size());
      }
    }
  }
}

} // namespace

TEST(MortonKeys, OrderCellsByTheirPaths)
{
  for (const int depth : { 0, 1, 7, 10 })
  {
    expectMortonOrder<MortonKeys<std::uint32_t>>(depth);
  }
  for (const int depth : { 3, 11, 20, 21 })
  {
    expectMortonOrder<MortonKeys<std::uint64_t>>(depth);
  }
  for (const int depth : { 1, 20, 21, 22, 41, 42, 43, 60 })
  {
    expectMortonOrder<MortonKeys<WideKey>>(depth);
  }
}

TEST(RadixSort, EqualsStdSort)
{
  struct Record
  {
    std::uint64_t key;
    std::uint32_t payload;
  };
  std::mt19937_64 random(2);
  const std::vector<std::function<std::uint64_t()>> distributions{
    [&] { return random(); },
    [&] { return random() % 3; },
    [&] { return random() & 0xfffff; },
    [&] { return random() & 0x3ffffffff; },
    [&] { return std::uint64_t(7) << 40; },
    [&] { return random() >> (random() % 64); },
    [&] { return random() % 64 == 0 ? random() : random() % 1000 + (std::uint64_t(1) << 63); },
    [&] { return (random() & 0xff) << 56 | (random() & 0xff); },
  };
  for (const auto& next : distributions)
  {
    for (const std::size_t count : { 0, 1, 24, 25, 1000, 70000, 400000 })
    {
      std::vector<Record> records(count);
      std::uint64_t check = 0; // of what belongs together
      for (Record& r : records)
      {
        r.key = next();
        r.payload = static_cast<std::uint32_t>(random());
        check += (r.key ^ r.payload) * (r.payload | 1u);
      }
      std::vector<std::uint64_t> expected(count);
      std::transform(records.begin(), records.end(), expected.begin(), [](const Record& r) { return r.key; });
      std::sort(expected.begin(), expected.end());
      std::vector<Record> scratch(count);
      RadixSort<Record>::sort(records.data(), scratch.data(), count);
      for (std::size_t i = 0; i < count; ++i)
      {
        ASSERT_EQ(records[i].key, expected[i]);
        check -= (records[i].key ^ records[i].payload) * (records[i].payload | 1u);
      }
      EXPECT_EQ(check, 0u);
    }
  }
}

TEST(OctreeBuilder, TakesCellsInAnyOrder)
{
  // Keys of 32, 64 and 189 bits; enough cells for many stretches and for sorting in parallel.
  for (const int deepest : { 10, 16, 40 })
  {
    const auto cells = cellsAlongDiagonal(6, deepest);
    ASSERT_GT(cells.size(), std::size_t(1) << 17);
    const auto asListed = buildOctree(unitRoots({ 1, 1, 1 }), cells);
    expectLabelled(asListed, cells.size());
    EXPECT_EQ(asListed.octree->leafLevels(), deepest);

    auto shuffled = cells;
    std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));
    const auto fromShuffled = buildOctree(unitRoots({ 1, 1, 1 }), std::move(shuffled));
    expectEqual(*fromShuffled.octree, *asListed.octree);
    EXPECT_EQ(fromShuffled.values, asListed.values);

    auto inOrder = cells;
    std::sort(inOrder.begin(), inOrder.end(), [](const LeafCell& a, const LeafCell& b) {
      return pathOf(a.cell.index, a.cell.level) < pathOf(b.cell.index, b.cell.level);
    });
    const auto fromOrder = buildOctree(unitRoots({ 1, 1, 1 }), std::move(inOrder));
    expectEqual(*fromOrder.octree, *asListed.octree);
    EXPECT_EQ(fromOrder.values, asListed.values);
  }
}

TEST(OctreeBuilder, FindsAnyOverlap)
{
  for (const int deepest : { 9, 16, 40 })
  {
    const auto cells = cellsAlongDiagonal(5, deepest);
    const CellId small = cells[cells.size() / 2].cell;
    std::vector<CellId> overlapping{ small, { {}, 0 }, { { 1, 1, 1 }, 1 }, { { 31, 31, 31 }, 5 } };
    overlapping.push_back(
      { { small.index[0] * 2, small.index[1] * 2 + 1, small.index[2] * 2 }, small.level + 1 });
    for (const CellId& extra : overlapping)
    {
      auto list = cells;
      list.insert(list.begin() + 100, { extra, 0.f });
      EXPECT_THROW(buildOctree(unitRoots({ 1, 1, 1 }), std::move(list)), Error);
    }
  }
  try
  {
    buildOctree(unitRoots({ 3, 1, 1 }),
      std::vector<LeafCell>{ { { { 9, 2, 3 }, 2 }, 0.f }, { { { 4, 1, 1 }, 1 }, 0.f } });
    FAIL();
  }
  catch (const Error& error)
  {
    EXPECT_STREQ(error.what(), "octree: cell (9, 2, 3) of level 2 overlaps cell (4, 1, 1) of level 1");
  }
}

TEST(OctreeBuilder, SourcesAndListsMakeTheSameOctree)
{
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const auto expected = buildOctree(unitRoots(options.roots), cells);
    ListSource source(options.roots, cells);
    const auto built = buildOctree(unitRoots(options.roots), source);
    expectEqual(*built.octree, *expected.octree);
    EXPECT_EQ(built.values, expected.values);
    EXPECT_EQ(gatherLeafValues(*built.octree, source), expected.values);
    EXPECT_FALSE(built.octree->hasGhosts());

    source.ghostsBelow = 0.f; // half of the leaves
    const auto withGhosts = buildOctree(unitRoots(options.roots), source);
    for (std::uint64_t leaf = 0; leaf < withGhosts.octree->leafCount(); ++leaf)
    {
      EXPECT_EQ(withGhosts.octree->isGhost(leaf), withGhosts.values[leaf] < 0.f);
    }
    const std::function<bool(NodeRef)> expectGhostsBelow = [&](NodeRef node) {
      if (!node.isInner())
      {
        return node.isLeaf() && withGhosts.octree->isGhost(node.index());
      }
      bool found = false;
      for (int octant = 0; octant < 8; ++octant)
      {
        found = expectGhostsBelow(withGhosts.octree->child(node, octant)) || found;
      }
      EXPECT_EQ(withGhosts.octree->hasGhostsBelow(node.index()), found && withGhosts.octree->hasGhosts());
      return found;
    };
    expectGhostsBelow(withGhosts.octree->root());
  }
}

TEST(OctreeBuilder, CutsALargeTreeAmongSmallOnes)
{
  // More inner nodes than one stretch takes.
  const OneLargeTree source{ 7 };
  const auto built = buildOctree(unitRoots({ 9, 9, 9 }), source);
  expectLabelled(built, 728 + (std::size_t(1) << 21));
  EXPECT_EQ(gatherLeafValues(*built.octree, source), built.values);
}

TEST(OctreeBuilder, ProceduralTreeIsRefinedTowardsItsSheet)
{
  const ProceduralTree source(6, 2.5);
  const auto built = buildOctree(unitRoots({ 1, 1, 1 }), source);
  EXPECT_GT(built.octree->leafCount(), 40000u);
  TreePath root(*built.octree);
  forEachNode(root, [&](const TreePath& p) {
    ProceduralTree::Handle h{ {}, p.depth() };
    std::copy(p.index().begin(), p.index().end(), h.index.begin());
    const double height = std::abs(ProceduralTree::heightAboveSheet(ProceduralTree::centre(h)));
    EXPECT_EQ(p.node().isInner(), p.depth() < 6 && height < std::ldexp(2.5, -p.depth()));
    if (p.node().isLeaf())
    {
      EXPECT_EQ(built.values[p.node().index()], ProceduralTree::value(h));
    }
  });
}

TEST(OctreeBuilder, RejectsBadSources)
{
  struct Bottomless : OneLargeTree
  {
    NodeKind kind(const CellId& c) const
    {
      const Coord last = (Coord(9) << c.level) - 1;
      return c.level == 0 || (c.index[0] == last && c.index[1] == last) ? NodeKind::Inner : NodeKind::Leaf;
    }
  };
  struct Hollow : OneLargeTree
  {
    NodeKind kind(const CellId& c) const { return c.level < 2 ? NodeKind::Inner : NodeKind::None; }
  };
  EXPECT_THROW(buildOctree(unitRoots({ 9, 9, 9 }), Bottomless()), Error);
  EXPECT_THROW(buildOctree(unitRoots({ 9, 9, 9 }), Hollow()), Error);
}

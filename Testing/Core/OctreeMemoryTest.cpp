// Bytes per cell: what is kept, and what a build holds at most. Counts everything this program allocates.
#include "Octree/Field.h"
#include "Octree/OctreeBuilder.h"
#include "Support/ProceduralTree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <random>

namespace
{

std::atomic<std::size_t> allocated{ 0 };
std::atomic<std::size_t> highest{ 0 };
constexpr std::size_t headerSize = 16; // keeps the alignment

} // namespace

void* operator new(std::size_t size)
{
  auto* const header = static_cast<std::size_t*>(std::malloc(size + headerSize));
  if (!header)
  {
    throw std::bad_alloc();
  }
  *header = size;
  const std::size_t now = allocated += size;
  for (std::size_t before = highest; before < now && !highest.compare_exchange_weak(before, now);)
  {
  }
  return reinterpret_cast<char*>(header) + headerSize;
}

void operator delete(void* pointer) noexcept
{
  if (pointer)
  {
    auto* const header = reinterpret_cast<std::size_t*>(static_cast<char*>(pointer) - headerSize);
    allocated -= *header;
    std::free(header);
  }
}

void operator delete(void* pointer, std::size_t /*size*/) noexcept
{
  operator delete(pointer);
}

using namespace treeamr;
using namespace treeamr::test;

namespace
{

RootGrid unitCube()
{
  return RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. });
}

/// The procedural tree's cells in random order, `below` levels down in the corner of the cube.
std::vector<LeafCell> cellsOf(const ProceduralTree& tree, int below)
{
  std::vector<LeafCell> cells;
  const auto add = [&](const auto& self, const ProceduralTree::Handle& node) -> void {
    if (tree.kind(node) == NodeKind::Leaf)
    {
      cells.push_back({ { { node.index[0], node.index[1], node.index[2] }, node.level + below },
        ProceduralTree::value(node) });
      return;
    }
    for (int o = 0; o < 8; ++o)
    {
      self(self, ProceduralTree::child(node, o));
    }
  };
  add(add, ProceduralTree::root(0));
  std::shuffle(cells.begin(), cells.end(), std::mt19937(1));
  cells.shrink_to_fit();
  return cells;
}

constexpr int deepest = 7;
const ProceduralTree tree(deepest, 3.);

} // namespace

TEST(OctreeMemory, FieldsCostSixAndFiveBytesACell)
{
  const std::size_t before = allocated;
  auto built = buildOctree(unitCube(), tree);
  Field first(built.octree, std::move(built.values));
  first.computeNodeRanges();
  const auto cells = static_cast<double>(first.octree().leafCount());
  const std::size_t withOne = allocated;
  Field second(built.octree, gatherLeafValues(first.octree(), tree));
  second.computeNodeRanges();
  const std::size_t withTwo = allocated;
  EXPECT_GT(cells, 200000.);
  EXPECT_LE(static_cast<double>(withOne - before), 5.8 * cells);
  EXPECT_LE(static_cast<double>(withTwo - withOne), 4.9 * cells);
  // What the objects say of themselves, except for their own few hundred bytes.
  EXPECT_NEAR(static_cast<double>(withOne - before),
    static_cast<double>(first.octree().byteSize() + first.byteSize()), 2000.);
  EXPECT_NEAR(static_cast<double>(withTwo - withOne), static_cast<double>(second.byteSize()), 2000.);
}

TEST(OctreeMemory, BuildsFromAListWithinThreeTimesTheResult)
{
  for (const int below : { 0, 10 }) // keys of 32 and 64 bits
  {
    auto cells = cellsOf(tree, below);
    const std::size_t before = allocated;
    highest = before;
    auto built = buildOctree(unitCube(), std::move(cells));
    Field field(built.octree, std::move(built.values));
    field.computeNodeRanges();
    const std::size_t result = field.octree().byteSize() + field.byteSize();
    EXPECT_LE(highest - before, 3 * result) << "keys down to level " << deepest + below;
  }
}

TEST(OctreeMemory, BuildsFromASourceWithATenthOnTop)
{
  const std::size_t before = allocated;
  highest = before;
  const auto built = buildOctree(unitCube(), tree);
  const std::size_t result = built.octree->byteSize() + built.values.capacity() * sizeof(float);
  const std::size_t stretches = std::size_t(512) * 4096; // counts, masks of offsets
  EXPECT_LE(highest - before, result + result / 10 + stretches);
}

// Bytes per cell: what is kept, and what a build holds at most. Counts everything this program allocates.
#include "Field/Field.h"
#include "Octree/OctreeBuilder.h"
#include "Support/AllocationCounter.h"
#include "Support/ProceduralTree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

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
  const std::size_t before = allocatedBytes;
  auto built = buildOctree(unitCube(), tree);
  Field first(built.octree, std::move(built.values));
  first.nodeRanges();
  const auto cells = static_cast<double>(first.octree().leafCount());
  const std::size_t withOne = allocatedBytes;
  Field second(built.octree, gatherLeafValues(first.octree(), tree));
  second.nodeRanges();
  const std::size_t withTwo = allocatedBytes;
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
    std::optional<Field> field;
    const std::size_t peak = peakBytes([&] {
      auto built = buildOctree(unitCube(), std::move(cells));
      field.emplace(built.octree, std::move(built.values));
      field->nodeRanges();
    });
    EXPECT_LE(peak, 3 * (field->octree().byteSize() + field->byteSize()));
  }
}

TEST(OctreeMemory, BuildsFromASourceWithATenthOnTop)
{
  OctreeAndValues built;
  const std::size_t peak = peakBytes([&] { built = buildOctree(unitCube(), tree); });
  const std::size_t result = built.octree->byteSize() + built.values.capacity() * sizeof(float);
  const std::size_t stretches = std::size_t(512) * 4096; // what is counted for each
  EXPECT_LE(peak, result + result / 10 + stretches);
}

TEST(OctreeMemory, MeansOfAWholeTreeNeedNothingElse)
{
  auto built = buildOctree(unitCube(), tree);
  const std::size_t inner = built.octree->innerCount();
  std::optional<Field> field;
  const std::size_t peak = peakBytes([&] { field.emplace(built.octree, std::move(built.values)); });
  EXPECT_LE(peak, inner * sizeof(float) + 10000);
}

// Grids from leaves, complete or with gaps, against what the leaves say.
#include "HyperTreeGridBuilder.h"
#include "Error.h"
#include "Geometry/Octant.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridNonOrientedCursor.h"
#include "vtkNew.h"
#include "vtkUnsignedCharArray.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <map>
#include <random>
#include <tuple>
#include <vector>

using namespace treeamr;

namespace
{

struct Payload
{
  double real;
  std::int32_t number;
};
const std::vector<PayloadField> fields{ { "real", PayloadType::Float64, 1, offsetof(Payload, real) },
  { "number", PayloadType::Int32, 1, offsetof(Payload, number) } };

struct Cell
{
  TreeLeaf leaf;
  Payload payload;
};

const TreeLattice twoTrees({ { { 0., 1., 3., 4. }, { 0., 1. }, { 0., 1. } } }, { { 2, 0, 0 }, { 0, 0, 0 } });

/// In Morton order, some of them left out.
void addCells(std::int32_t tree, int level, const std::array<Coord, 3>& index, double missing,
  std::mt19937& random, std::vector<Cell>& cells)
{
  std::uniform_real_distribution<double> unit(0., 1.);
  if (level < 5 && (level == 0 || unit(random) < 0.5))
  {
    for (int o = 0; o < 8; ++o)
    {
      addCells(tree, level + 1, indexOfChild(index, o), missing, random, cells);
    }
  }
  else if (!(unit(random) < missing))
  {
    Cell cell{ { tree, {}, level, cells.size(), nullptr },
      { unit(random), static_cast<std::int32_t>(random() % 1000) } };
    for (int a = 0; a < 3; ++a)
    {
      cell.leaf.index[a] = static_cast<std::uint32_t>(index[a]);
    }
    cells.push_back(cell);
  }
}

std::vector<std::uint64_t> countNodes(const std::vector<Cell>& cells, int trees)
{
  std::vector<NodeCounter> counters(trees);
  for (const Cell& cell : cells)
  {
    counters[cell.leaf.tree].add(cell.leaf);
  }
  std::vector<std::uint64_t> counts;
  for (const NodeCounter& counter : counters)
  {
    counts.push_back(counter.count());
  }
  return counts;
}

void build(vtkHyperTreeGrid* grid, const std::vector<Cell>& cells, const std::vector<std::uint64_t>& counts,
  std::uint64_t blockLeaves)
{
  HyperTreeGridBuilder builder(grid, twoTrees, counts, "cells");
  for (const PayloadField& field : fields)
  {
    builder.addArray(makeFiller(field, builder.nodeCount()));
  }
  builder.addArray(std::make_unique<LevelFiller>(builder.nodeCount()));
  builder.addArray(std::make_unique<TreeIdFiller>(builder.nodeCount()));
  builder.build(cells.size(), blockLeaves, [&](std::uint64_t begin, std::uint64_t end, LeafBlock& block) {
    block.leaves.clear();
    for (std::uint64_t i = begin; i < end; ++i)
    {
      block.leaves.push_back(cells[i].leaf);
      block.leaves.back().payload = reinterpret_cast<const std::byte*>(&cells[i].payload);
    }
  });
}

using Place = std::tuple<int, int, std::array<std::uint32_t, 3>>;

struct Sum
{
  double mean = 0.; // of what is below, children weighted alike
  int number = 0;   // of the first cell below
  bool hasCells = false;
};

/// Compares a node and all below with the cells.
class Comparison
{
public:
  Comparison(vtkHyperTreeGrid* grid, const std::vector<Cell>& cells)
    : grid_(grid)
  {
    for (const Cell& cell : cells)
    {
      cells_[{ cell.leaf.tree, cell.leaf.level, cell.leaf.index }] = cell.payload;
    }
  }
  Sum visit(
    vtkHyperTreeGridNonOrientedCursor* at, std::int32_t tree, const std::array<std::uint32_t, 3>& index)
  {
    const vtkIdType id = at->GetGlobalNodeIndex();
    const auto level = static_cast<int>(at->GetLevel());
    Sum sum;
    if (at->IsLeaf())
    {
      const auto cell = cells_.find({ tree, level, index });
      EXPECT_EQ(static_cast<bool>(at->IsMasked()), cell == cells_.end());
      if (cell == cells_.end())
      {
        return sum;
      }
      ++found_;
      sum = { cell->second.real, cell->second.number, true };
    }
    else
    {
      EXPECT_FALSE(at->IsMasked());
      int present = 0;
      for (unsigned char o = 0; o < 8; ++o)
      {
        at->ToChild(o);
        const Sum child = visit(
          at, tree, { 2 * index[0] + (o & 1u), 2 * index[1] + (o >> 1 & 1u), 2 * index[2] + (o >> 2 & 1u) });
        at->ToParent();
        if (child.hasCells)
        {
          sum.number = present == 0 ? child.number : sum.number;
          sum.mean += child.mean;
          ++present;
        }
      }
      EXPECT_GT(present, 0) << "subdivided for nothing";
      sum.mean /= present;
      sum.hasCells = true;
    }
    vtkCellData* const data = grid_->GetCellData();
    EXPECT_EQ(data->GetArray("real")->GetComponent(id, 0), sum.mean);
    EXPECT_EQ(data->GetArray("number")->GetComponent(id, 0), sum.number);
    EXPECT_EQ(data->GetArray("level")->GetComponent(id, 0), level);
    EXPECT_EQ(data->GetArray("treeid")->GetComponent(id, 0), tree);
    return sum;
  }
  std::size_t found() const { return found_; }

private:
  vtkHyperTreeGrid* grid_;
  std::map<Place, Payload> cells_;
  std::size_t found_ = 0;
};

std::string messageOf(
  const std::vector<Cell>& cells, const std::vector<std::uint64_t>& counts, std::uint64_t blockLeaves = 2)
{
  vtkNew<vtkHyperTreeGrid> grid;
  try
  {
    build(grid, cells, counts, blockLeaves);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return {};
}

} // namespace

TEST(HyperTreeGridBuilder, HasEachLeafAtItsPlaceAndMasksTheRest)
{
  std::mt19937 random(1);
  for (const auto& [missing, blockLeaves] :
    { std::pair<double, std::uint64_t>{ 0., 1 }, { 0., 3 }, { 0., 100 }, { 0., 100000 }, { 0.2, 1 },
      { 0.2, 7 }, { 0.2, 100000 }, { 0.9, 1 }, { 0.9, 2 }, { 0.9, 10 } })
  {
    for (const int trees : { 1, 2 })
    {
      SCOPED_TRACE(std::to_string(blockLeaves) + " cells at a time");
      std::vector<Cell> cells;
      for (int tree = 0; tree < trees; ++tree)
      {
        addCells(tree, 0, {}, missing, random, cells);
      }
      const std::vector<std::uint64_t> counts = countNodes(cells, 2);
      vtkNew<vtkHyperTreeGrid> grid;
      build(grid, cells, counts, blockLeaves);
      EXPECT_EQ(grid->HasMask(), missing > 0.);
      EXPECT_EQ(grid->GetNumberOfNonEmptyTrees(), trees);
      EXPECT_EQ(test::countVertices(grid), static_cast<vtkIdType>(counts[0] + counts[1]));
      EXPECT_STREQ(grid->GetCellData()->GetScalars()->GetName(), "real");
      Comparison comparison(grid, cells);
      for (int tree = 0; tree < trees; ++tree)
      {
        vtkIdType index = 0;
        grid->GetIndexFromLevelZeroCoordinates(index, tree == 0 ? 2 : 0, 0, 0);
        vtkNew<vtkHyperTreeGridNonOrientedCursor> cursor;
        grid->InitializeNonOrientedCursor(cursor, index);
        comparison.visit(cursor, tree, {});
      }
      EXPECT_EQ(comparison.found(), cells.size());
      EXPECT_GT(cells.size(), 100u);
    }
  }
}

TEST(HyperTreeGridBuilder, CompleteTreesHaveANodeForEachLeafAndOneForEachSeven)
{
  std::mt19937 random(2);
  std::vector<Cell> cells;
  addCells(0, 0, {}, 0., random, cells);
  EXPECT_EQ(countNodes(cells, 2), (std::vector<std::uint64_t>{ cells.size() + (cells.size() - 1) / 7, 0 }));
}

TEST(HyperTreeGridBuilder, CellsThatFitNotAreErrors)
{
  const auto leaf = [](std::int32_t tree, int level, std::uint32_t x) {
    return Cell{ { tree, { x, 0, 0 }, level, 0, nullptr }, { 1., 1 } };
  };
  EXPECT_EQ(messageOf({ leaf(0, 1, 0), leaf(0, 1, 1) }, { 9, 0 }), "");
  for (const auto& [cells, counts, part] :
    { std::tuple<std::vector<Cell>, std::vector<std::uint64_t>, const char*>{
        { leaf(0, 1, 1), leaf(0, 1, 0) }, { 9, 0 },
        "cells: tree 0: the cell of level 1 at (0, 0, 0), allowed are" },
      { { leaf(0, 1, 0), leaf(0, 1, 0) }, { 9, 0 }, "disjoint" },
      { { leaf(0, 1, 0), leaf(0, 2, 1) }, { 17, 0 }, "disjoint" },
      { { leaf(0, 2, 0), leaf(0, 1, 0) }, { 17, 0 }, "disjoint" },
      { { leaf(0, 0, 0), leaf(0, 1, 0) }, { 9, 0 }, "disjoint" }, { { leaf(0, 1, 2) }, { 9, 0 }, "disjoint" },
      { { leaf(0, 32, 0) }, { 1000, 0 }, "level 31" },
      { { leaf(1, 0, 0), leaf(0, 0, 0) }, { 0, 1 }, "trees in the order" },
      { { leaf(2, 0, 0) }, { 1, 1 }, "up to 1" },
      { { leaf(0, 1, 0) }, { 1, 0 }, "more nodes, allowed are the 1 that were told" },
      { { leaf(0, 1, 0) }, { 17, 0 }, "9 nodes, allowed are the 17" },
      { { leaf(0, 0, 0) }, { 1, 1 }, "tree 1: no cell, allowed are cells of the 1 nodes that were told" },
      { { leaf(1, 0, 0) }, { 1, 1 }, "tree 0: no cell" },
      { { leaf(0, 1, 0) }, { std::uint64_t(1) << 32, 0 }, "the most of a vtkHyperTree" } })
  {
    for (const std::uint64_t blockLeaves : { 1, 2, 3 })
    {
      const std::string message = messageOf(cells, counts, blockLeaves);
      EXPECT_NE(message.find(part), std::string::npos) << message << ", should say " << part;
    }
  }
}

TEST(HyperTreeGridBuilder, ErrorsAreThoseOfTheFirstBlockThatHasOne)
{
  std::mt19937 random(3);
  std::vector<Cell> cells;
  addCells(0, 0, {}, 0., random, cells);
  const std::vector<std::uint64_t> counts = countNodes(cells, 2);
  for (int i = 0; i < 20; ++i)
  {
    vtkNew<vtkHyperTreeGrid> grid;
    HyperTreeGridBuilder builder(grid, twoTrees, counts, "cells");
    try
    {
      builder.build(cells.size(), 5, [&](std::uint64_t begin, std::uint64_t end, LeafBlock& block) {
        if (begin >= 30)
        {
          throw Error("the block from " + std::to_string(begin) + " on");
        }
        block.leaves.clear();
        std::transform(cells.begin() + begin, cells.begin() + end, std::back_inserter(block.leaves),
          [](const Cell& cell) { return cell.leaf; });
      });
      ADD_FAILURE() << "no error";
    }
    catch (const Error& error)
    {
      EXPECT_STREQ(error.what(), "the block from 30 on");
    }
  }
}

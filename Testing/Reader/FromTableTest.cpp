// Tables of random trees' cells become grids of these cells, in any order and of columns of any type; rows that are no cells
// of a lattice are errors that say which.
#include "vtkTreeAMRFromTable.h"

#include "Support/GridMakers.h"
#include "Support/HyperTreeGrids.h"
#include "Support/RandomTrees.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIntArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"
#include "vtkTable.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr std::array<const char*, 4> columnNames{ "level", "i", "j", "k" };

vtkSmartPointer<vtkDataArray> makeColumn(const char* name, int type)
{
  const auto column = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(type));
  column->SetName(name);
  return column;
}

/// With the row's number ("row", int) and twice and thrice that ("pair", double).
vtkSmartPointer<vtkTable> makeTable(const std::vector<CellId>& cells, int type = VTK_INT, int firstRow = 0)
{
  const auto table = vtkSmartPointer<vtkTable>::New();
  for (std::size_t c = 0; c < columnNames.size(); ++c)
  {
    const auto column = makeColumn(columnNames[c], type);
    for (const CellId& cell : cells)
    {
      column->InsertNextTuple1(c == 0 ? cell.level : static_cast<double>(cell.index[c - 1]));
    }
    table->AddColumn(column);
  }
  const auto row = makeColumn("row", VTK_INT);
  const auto pair = makeColumn("pair", VTK_DOUBLE);
  pair->SetNumberOfComponents(2);
  for (std::size_t i = 0; i < cells.size(); ++i)
  {
    const double number = firstRow + static_cast<double>(i);
    row->InsertNextTuple1(number);
    pair->InsertNextTuple2(2. * number, 3. * number);
  }
  table->AddColumn(row);
  table->AddColumn(pair);
  return table;
}

void setPlace(vtkTable* table, vtkIdType row, int column, double value)
{
  vtkDataArray::SafeDownCast(table->GetColumnByName(columnNames[column]))->SetComponent(row, 0, value);
}

/// Bounds of each cell, by row.
using CellBounds = std::map<int, std::array<double, 6>>;

CellBounds boundsOf(
  const std::vector<CellId>& cells, const std::array<double, 3>& origin, const std::array<double, 3>& spacing)
{
  CellBounds bounds;
  for (std::size_t i = 0; i < cells.size(); ++i)
  {
    for (int a = 0; a < 3; ++a)
    {
      const auto index = static_cast<double>(cells[i].index[a]);
      bounds[static_cast<int>(i)][2 * a] = origin[a] + spacing[a] * std::ldexp(index, -cells[i].level);
      bounds[static_cast<int>(i)][2 * a + 1] =
        origin[a] + spacing[a] * std::ldexp(index + 1., -cells[i].level);
    }
  }
  return bounds;
}

void expectCells(vtkHyperTreeGrid* grid, CellBounds expected)
{
  forEachLeaf(grid, [&](const double* bounds, vtkIdType id) {
    vtkCellData* const data = grid->GetCellData();
    const int row = static_cast<int>(data->GetArray("row")->GetComponent(id, 0));
    ASSERT_EQ(expected.count(row), 1u) << row;
    for (int b = 0; b < 6; ++b)
    {
      EXPECT_NEAR(bounds[b], expected[row][b], 1e-12) << row;
    }
    EXPECT_EQ(data->GetArray("pair")->GetComponent(id, 0), 2. * row);
    EXPECT_EQ(data->GetArray("pair")->GetComponent(id, 1), 3. * row);
    expected.erase(row);
  });
  EXPECT_TRUE(expected.empty());
}

std::vector<CellId> cellsOf(const RandomTree& tree)
{
  std::vector<CellId> cells;
  for (const LeafCell& leaf : makeRandomTree(tree))
  {
    cells.push_back(leaf.cell);
  }
  std::mt19937 random(tree.seed);
  std::ranges::shuffle(cells, random);
  return cells;
}

std::string errorOfTable(vtkDataObject* table)
{
  return errorOf<vtkTreeAMRFromTable>(table);
}

const std::vector<CellId> twoCells{ { { 0, 0, 0 }, 0 }, { { 2, 1, 1 }, 1 } };

} // namespace

TEST(FromTable, RandomTreesOfAllTypes)
{
  int seed = 1;
  for (const int type : { VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_INT, VTK_LONG_LONG, VTK_FLOAT, VTK_DOUBLE })
  {
    for (const double missing : { 0., 0.3 })
    {
      const std::vector<CellId> cells =
        cellsOf({ static_cast<std::uint32_t>(++seed), { 2, 1, 3 }, 5, 0.5, missing, false });
      vtkNew<vtkTreeAMRFromTable> filter;
      filter->SetInputData(makeTable(cells, type));
      filter->SetOrigin(-3., 0.5, 10.);
      filter->SetSpacing(0.25, 1., 2.);
      filter->SetRoots(2, 1, 3);
      filter->Update();
      vtkHyperTreeGrid* const grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
      expectCells(grid, boundsOf(cells, { -3., 0.5, 10. }, { 0.25, 1., 2. }));
      EXPECT_EQ(grid->GetCellData()->GetNumberOfArrays(), 2);
      EXPECT_STREQ(grid->GetCellData()->GetScalars()->GetName(), "row");
      EXPECT_EQ(grid->GetCellData()->GetArray("row")->GetDataType(), VTK_INT);
    }
  }
}

TEST(FromTable, RootsAreAsManyAsCellsNeed)
{
  const MadeGrid result = makeGridBy<vtkTreeAMRFromTable>(makeTable(twoCells));
  EXPECT_EQ(latticeBounds(result.grid), (std::array<double, 6>{ 0., 2., 0., 1., 0., 1. }));
  expectCells(result.grid, boundsOf(twoCells, { 0., 0., 0. }, { 1., 1., 1. }));
  EXPECT_TRUE(result.warnings.empty());
}

TEST(FromTable, DeepCells)
{
  const std::vector<CellId> cells{ { { (Coord(1) << 31) - 1, 0, 7 }, 31 }, { { 1, 1, 1 }, 1 } };
  const MadeGrid result = makeGridBy<vtkTreeAMRFromTable>(makeTable(cells, VTK_LONG_LONG));
  EXPECT_TRUE(result.errors.empty());
  expectCells(result.grid, boundsOf(cells, { 0., 0., 0. }, { 1., 1., 1. }));
}

TEST(FromTable, TablesOfACollectionAreOneGrid)
{
  const std::vector<CellId> cells = cellsOf({ 7, { 2, 2, 1 }, 4, 0.5, 0., false });
  const auto middle = cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, makeTable({ cells.begin(), middle }));
  blocks->SetBlock(1, makeTable({ middle, cells.end() }, VTK_DOUBLE, static_cast<int>(cells.size() / 2)));
  const MadeGrid result = makeGridBy<vtkTreeAMRFromTable>(blocks);
  EXPECT_TRUE(result.errors.empty());
  expectCells(result.grid, boundsOf(cells, { 0., 0., 0. }, { 1., 1., 1. }));
}

TEST(FromTable, FirstOfDuplicatesCounts)
{
  std::vector<CellId> cells = cellsOf({ 9, { 1, 1, 1 }, 3, 0.6, 0., false });
  const auto expected = boundsOf(cells, { 0., 0., 0. }, { 1., 1., 1. });
  const std::vector<CellId> once = cells;
  cells.insert(cells.end(), once.begin(), once.begin() + 5);
  expectCells(makeGridBy<vtkTreeAMRFromTable>(makeTable(cells)).grid, expected);
}

TEST(FromTable, ColumnsOfTextAreLeftOutAndLevelsStandIn)
{
  const auto table = makeTable(twoCells);
  vtkNew<vtkStringArray> text;
  text->SetName("text");
  text->SetNumberOfValues(2);
  table->AddColumn(text);
  MadeGrid result = makeGridBy<vtkTreeAMRFromTable>(table);
  ASSERT_EQ(result.warnings.size(), 1u);
  expectIn(result.warnings[0], "left out: column 'text' has no numbers.");
  table->RemoveColumnByName("text");
  table->RemoveColumnByName("row");
  table->RemoveColumnByName("pair");
  result = makeGridBy<vtkTreeAMRFromTable>(table);
  ASSERT_EQ(result.grid->GetCellData()->GetNumberOfArrays(), 1);
  forEachLeaf(result.grid, [&](const double* bounds, vtkIdType id) {
    EXPECT_EQ(result.grid->GetCellData()->GetArray("level")->GetComponent(id, 0), bounds[1] > 1. ? 1. : 0.);
  });
}

TEST(FromTable, OtherNamesOfColumns)
{
  const auto table = makeTable(twoCells);
  for (const char* name : columnNames)
  {
    table->GetColumnByName(name)->SetName((std::string("my ") + name).c_str());
  }
  vtkNew<vtkTreeAMRFromTable> filter;
  filter->SetInputData(table);
  filter->SetLevelColumn("my level");
  filter->SetIColumn("my i");
  filter->SetJColumn("my j");
  filter->SetKColumn("my k");
  filter->Update();
  expectCells(vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0)),
    boundsOf(twoCells, { 0., 0., 0. }, { 1., 1., 1. }));
}

TEST(FromTable, RowsThatAreNoCellsAreNamed)
{
  const auto withPlace = [](vtkIdType row, int column, double value) {
    const auto table = makeTable(twoCells, VTK_DOUBLE);
    setPlace(table, row, column, value);
    return errorOfTable(table);
  };
  expectIn(
    withPlace(1, 0, 1.5), "row 1, level 1.5 at (2, 1, 1); allowed are whole numbers, levels from 0 to 31");
  expectIn(withPlace(1, 0, 32.), "row 1, level 32 at");
  expectIn(withPlace(0, 0, -1.), "row 0, level -1 at");
  expectIn(withPlace(0, 0, std::nan("")), "row 0, level nan at");
  expectIn(withPlace(1, 2, -1.), "row 1, level 1 at (2, -1, 1)");
  expectIn(withPlace(1, 3, 0.5), "row 1, level 1 at (2, 1, 0.5)");
  expectIn(withPlace(1, 1, 1. / 0.), "row 1, level 1 at (inf, 1, 1)");
  expectIn(withPlace(1, 1, 4e6), "row 1, level 1 at (4000000, 1, 1)");
  expectIn(
    withPlace(1, 1, 1.), "cells overlap: row 0, level 0 at (0, 0, 0), and row 1, level 1 at (1, 1, 1)");

  vtkNew<vtkTreeAMRFromTable> filter;
  const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
  filter->SetInputData(makeTable(twoCells));
  filter->SetRoots(1, 1, 1);
  filter->Update();
  ASSERT_EQ(errors.messages().size(), 1u);
  expectIn(errors.messages()[0], "row 1, level 1 at (2, 1, 1); allowed");
  expectIn(errors.messages()[0], "below 2^level times 1, 1 and 1 roots");
}

TEST(FromTable, ColumnsAndLatticesThatFitNotAreNamed)
{
  const auto table = makeTable(twoCells);
  table->RemoveColumnByName("j");
  vtkNew<vtkStringArray> text;
  text->SetName("J");
  text->SetNumberOfValues(2);
  table->AddColumn(text);
  expectIn(errorOfTable(table),
    "no column 'j' of one number a row, for the cells' indices along y; there are 'level', 'i', 'k', 'row', "
    "'pair', 'J' of "
    "text");

  const auto errorWith = [](const std::function<void(vtkTreeAMRFromTable*)>& set) {
    vtkNew<vtkTreeAMRFromTable> filter;
    const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
    filter->SetInputData(makeTable(twoCells));
    set(filter);
    filter->Update();
    EXPECT_EQ(errors.messages().size(), 1u);
    return errors.messages().empty() ? "" : errors.messages()[0];
  };
  expectIn(errorWith([](vtkTreeAMRFromTable* f) { f->SetSpacing(1., 0., 1.); }), "along y Origin 0");
  expectIn(
    errorWith([](vtkTreeAMRFromTable* f) { f->SetSpacing(1., 1., std::nan("")); }), "along z Origin 0");
  expectIn(errorWith([](vtkTreeAMRFromTable* f) { f->SetOrigin(1. / 0., 1., 1.); }), "along x Origin inf");
  expectIn(errorWith([](vtkTreeAMRFromTable* f) { f->SetRoots(1, -1, 1); }), "Roots -1");
  expectIn(
    errorWith([](vtkTreeAMRFromTable* f) { f->SetOrigin(1e30, 0., 0.); }), "finite and strictly increasing");
}

TEST(FromTable, NoRowsAreNoCells)
{
  vtkNew<vtkTable> table;
  const MadeGrid result = makeGridBy<vtkTreeAMRFromTable>(table);
  EXPECT_TRUE(result.errors.empty());
  EXPECT_EQ(result.grid->GetNumberOfLeaves(), 0);
}

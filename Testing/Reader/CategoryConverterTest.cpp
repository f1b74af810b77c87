// Arrays converted to categories against an independent walk with VTK's cursors.
#include "CategoryNumbers.h"
#include "HyperTreeGridConverter.h"

#include "Error.h"
#include "Support/HyperTreeGrids.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkTypeInt64Array.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// The cells with their values in place of the numbers of these.
std::vector<DrawnCell> cellsOf(const Categories& categories)
{
  std::vector<DrawnCell> cells = drawnCells(categories.numbers);
  for (DrawnCell& cell : cells)
  {
    const auto number = static_cast<vtkIdType>(cell.value);
    EXPECT_LT(number, categories.values->GetNumberOfTuples());
    cell.value = categories.values->GetComponent(number, 0);
  }
  return cells;
}

void expectAscending(vtkDataArray* values)
{
  for (vtkIdType i = 1; i < values->GetNumberOfTuples(); ++i)
  {
    EXPECT_LT(values->GetComponent(i - 1, 0), values->GetComponent(i, 0));
  }
}

bool contains(const DrawnCell& outer, const DrawnCell& inner)
{
  bool all = true;
  for (int a = 0; a < 3; ++a)
  {
    all = all && outer.bounds[a] <= inner.bounds[a] && inner.bounds[3 + a] <= outer.bounds[3 + a];
  }
  return all;
}

double volumeOf(const DrawnCell& cell)
{
  double volume = 1.;
  for (int a = 0; a < 3; ++a)
  {
    volume *= cell.bounds[3 + a] - cell.bounds[a];
  }
  return volume;
}

/// An array over all vertices of a grid with values of its own.
template <class Array, class Value>
void addArray(vtkHyperTreeGrid* grid, const char* name, const Value& valueOf)
{
  vtkNew<Array> array;
  array->SetName(name);
  for (vtkIdType i = 0; i < grid->GetGlobalNodeIndexMax() + 1; ++i)
  {
    array->InsertNextValue(valueOf(i));
  }
  grid->GetCellData()->AddArray(array);
}

} // namespace

TEST(CategoryConverter, EachCellHasItsOwnValue)
{
  for (const RandomHyperTreeGrid& options :
    { RandomHyperTreeGrid{}, RandomHyperTreeGrid{ .seed = 3, .missingTrees = 0.3, .masked = 0.2 },
      RandomHyperTreeGrid{ .seed = 4, .ghosts = 0.2, .notFinite = 0.1, .explicitIndices = true },
      RandomHyperTreeGrid{ .seed = 5, .uniform = true, .transposedRoots = true } })
  {
    const auto grid = makeGrid(options);
    addArray<vtkIntArray>(grid, "id", [](vtkIdType i) { return static_cast<int>(i * 7 % 5) - 2; });
    for (const ArraySelection& selection : { ArraySelection{ "id" }, ArraySelection{ "count" },
           ArraySelection{ "scalar" }, ArraySelection{ "vector", 1 }, ArraySelection{ "vector" } })
    {
      const auto categories = acquireCategories(grid, selection);
      expectAscending(categories->values);
      const auto expected = drawnCells(grid, selection.name, selection.component);
      const auto found = cellsOf(*categories);
      ASSERT_EQ(found.size(), expected.size()) << selection.name;
      for (std::size_t i = 0; i < found.size(); ++i)
      {
        EXPECT_EQ(found[i].bounds, expected[i].bounds) << selection.name;
        EXPECT_EQ(found[i].value, expected[i].value) << selection.name;
        EXPECT_EQ(found[i].ghost, expected[i].ghost) << selection.name;
      }
    }
    EXPECT_EQ(acquireCategories(grid, { "id" })->values->GetNumberOfTuples(), 5);
    EXPECT_EQ(acquireCategories(grid, { "id" })->values->GetDataType(), VTK_INT);
    EXPECT_EQ(acquireCategories(grid, { "vector", 1 })->values->GetDataType(), VTK_FLOAT);
    EXPECT_EQ(acquireCategories(grid, { "vector" })->values->GetDataType(), VTK_DOUBLE);
  }
}

TEST(CategoryConverter, IdsBeyondFloatStayApart)
{
  const auto grid = makeGrid({ .seed = 6 });
  constexpr vtkTypeInt64 ids[]{ 16777216, 16777217, 16777218, (vtkTypeInt64(1) << 53) - 1,
    vtkTypeInt64(1) << 53, -16777217 };
  addArray<vtkTypeInt64Array>(grid, "id", [&](vtkIdType i) { return ids[i % std::size(ids)]; });
  const auto categories = acquireCategories(grid, { "id" });
  ASSERT_EQ(categories->values->GetNumberOfTuples(), static_cast<vtkIdType>(std::size(ids)));
  auto* const values = vtkAOSDataArrayTemplate<vtkTypeInt64>::FastDownCast(categories->values);
  ASSERT_TRUE(values);
  for (const vtkTypeInt64 id : ids)
  {
    EXPECT_GE(values->LookupTypedValue(id), 0) << id;
  }
  const auto expected = drawnCells(grid, "id");
  const auto found = cellsOf(*categories);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
  {
    EXPECT_EQ(found[i].value, expected[i].value);
  }
}

TEST(CategoryConverter, BitsAreTwoCategories)
{
  const auto grid = makeGrid({ .seed = 7 });
  addArray<vtkBitArray>(grid, "bit", [](vtkIdType i) { return static_cast<int>(i % 3 == 0); });
  const auto categories = acquireCategories(grid, { "bit" });
  EXPECT_EQ(categories->values->GetDataType(), VTK_UNSIGNED_CHAR);
  EXPECT_EQ(categories->values->GetNumberOfTuples(), 2);
  EXPECT_EQ(categories->numbers.range().max, 1.f);
}

TEST(CategoryConverter, AtTheDepthLimitTheLargestVolumeDecides)
{
  const RandomHyperTreeGrid options{ .seed = 8, .refine = 0.7, .masked = 0.1 };
  const auto grid = makeGrid(options);
  const auto id = [](vtkIdType i) { return static_cast<int>(i * i % 4); };
  addArray<vtkIntArray>(grid, "id", id);
  const auto all = drawnCells(grid, "id");
  for (const unsigned int limit : { 0u, 1u, 2u })
  {
    grid->SetDepthLimiter(limit);
    std::size_t merged = 0;
    for (const DrawnCell& cell : cellsOf(*acquireCategories(grid, { "id" })))
    {
      std::map<double, double> volumes; // by value
      for (const DrawnCell& leaf : all)
      {
        if (contains(cell, leaf))
        {
          volumes[leaf.value] += volumeOf(leaf);
        }
      }
      merged += volumes.size() > 1;
      ASSERT_TRUE(volumes.count(cell.value));
      for (const auto& [value, volume] : volumes)
      {
        EXPECT_LE(volume, volumes[cell.value] * (1. + 1e-12)) << value;
      }
    }
    EXPECT_GT(merged, 3u);
  }
}

TEST(CategoryConverter, SharesTheOctreeAndIsMadeOnce)
{
  const auto grid = makeGrid({ .seed = 9 });
  const auto field = acquireField(grid, { "count" });
  const auto categories = acquireCategories(grid, { "count" });
  EXPECT_EQ(&field->octree(), &categories->numbers.octree());
  EXPECT_EQ(acquireCategories(grid, { "count" }), categories);
  auto* const count = vtkIntArray::SafeDownCast(grid->GetCellData()->GetArray("count"));
  count->FillValue(3);
  count->Modified();
  EXPECT_EQ(acquireCategories(grid, { "count" })->values->GetNumberOfTuples(), 1);
}

TEST(CategoryConverter, UnfitArraysAreErrors)
{
  const auto grid = makeGrid({ .seed = 10 });
  EXPECT_THROW(acquireCategories(nullptr, { "id" }), Error);
  EXPECT_THROW(acquireCategories(grid, { "missing" }), Error);
  EXPECT_THROW(acquireCategories(grid, { "vector", 3 }), Error);
  addArray<vtkDoubleArray>(
    grid, "nothing", [](vtkIdType) { return std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_THROW(acquireCategories(grid, { "nothing" }), Error);
}

TEST(CategoryConverter, NoMoreValuesThanAllowed)
{
  constexpr int most = 10000;
  DistinctValues values(most);
  for (int i = 0; i < 5 * most; ++i)
  {
    values.add(static_cast<double>(i * 7919 % most));
  }
  ASSERT_EQ(values.sort().size(), static_cast<std::size_t>(most));
  EXPECT_EQ(values.sort().back(), most - 1.);
  DistinctValues more(most);
  more.add(0.5);
  EXPECT_THROW(
    {
      more.add(values);
      more.sort();
    },
    Error);
}

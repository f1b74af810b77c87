// Grids of a collection as one: pieces that share trees by masks, mirrored halves, and what cannot be merged.
#include "Support/GridMakers.h"
#include "Support/HyperTreeGrids.h"

#include "CornerArrays.h"
#include "HyperTreeGridConverter.h"
#include "MergedGrid.h"
#include "vtkTreeAMRContourFilter.h"
#include "vtkTreeAMRMergeGrids.h"
#include "vtkTreeAMRProbeFilter.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridAxisReflection.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Grid = vtkSmartPointer<vtkHyperTreeGrid>;

vtkSmartPointer<vtkMultiBlockDataSet> collectionOf(const std::vector<Grid>& grids)
{
  const auto collection = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const Grid& grid : grids)
  {
    collection->SetBlock(collection->GetNumberOfBlocks(), grid);
  }
  return collection;
}

MadeGrid merge(const std::vector<Grid>& grids)
{
  return makeGridBy<vtkTreeAMRMergeGrids>(collectionOf(grids));
}

/// A copy in which leaves are masked unless isKept(bounds).
template <class IsKept>
Grid pieceOf(vtkHyperTreeGrid* grid, const IsKept& isKept)
{
  const auto piece = Grid::New();
  piece->DeepCopy(grid);
  vtkNew<vtkBitArray> mask;
  mask->SetNumberOfTuples(countVertices(grid));
  for (vtkIdType i = 0; i < mask->GetNumberOfTuples(); ++i)
  {
    mask->SetValue(
      i, grid->GetMask() && grid->GetMask()->GetNumberOfTuples() > i && grid->GetMask()->GetValue(i));
  }
  forEachLeaf(grid, [&](const double* bounds, vtkIdType id) {
    if (!isKept(bounds))
    {
      mask->SetValue(id, 1);
    }
  });
  piece->SetMask(mask);
  return piece;
}

/// Of a cell, the same in all copies.
std::size_t pieceNumber(const double* bounds, std::size_t count)
{
  std::uint64_t hash = 17;
  for (int i = 0; i < 6; ++i)
  {
    std::uint64_t bits;
    std::memcpy(&bits, bounds + i, sizeof(bits));
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 31;
  }
  return hash % count;
}

void expectSame(const std::vector<DrawnCell>& found, const std::vector<DrawnCell>& expected)
{
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
  {
    ASSERT_EQ(found[i].bounds, expected[i].bounds) << i;
    ASSERT_EQ(found[i].value, expected[i].value) << i;
  }
}

} // namespace

TEST(MergeGrids, PiecesThatShareTreesAreTheWhole)
{
  std::vector<RandomHyperTreeGrid> all(5);
  all[1] = { .seed = 2, .missingTrees = 0.3, .masked = 0.1 };
  all[2] = { .seed = 3, .transposedRoots = true };
  all[3] = { .seed = 4, .explicitIndices = true };
  all[4] = { .seed = 5, .depthLimit = 3 };
  for (const RandomHyperTreeGrid& options : all)
  {
    SCOPED_TRACE(options.seed);
    const auto whole = makeGrid(options);
    std::vector<Grid> pieces;
    for (std::size_t p = 0; p < 3; ++p)
    {
      pieces.push_back(pieceOf(whole, [p](const double* bounds) { return pieceNumber(bounds, 3) == p; }));
    }
    const MadeGrid made = merge(pieces);
    EXPECT_TRUE(made.errors.empty()) << made.errors[0];
    EXPECT_TRUE(made.warnings.empty());
    expectSame(drawnCells(made.grid, "scalar"), drawnCells(whole, "scalar"));
    expectSame(drawnCells(made.grid, "vector", 2), drawnCells(whole, "vector", 2));
    EXPECT_EQ(made.grid->GetCellData()->GetArray("count")->GetDataType(), VTK_INT);
    // What is reconstructed is that of the whole.
    const auto merged = acquireField(made.grid, { "scalar" });
    const auto field = acquireField(whole, { "scalar" });
    EXPECT_EQ(merged->octree().leafCount(), field->octree().leafCount());
    EXPECT_EQ(merged->range().min, field->range().min);
    EXPECT_EQ(merged->range().max, field->range().max);
  }
}

TEST(MergeGrids, HalvesOfAMirroredDomain)
{
  const auto half = makeGrid({ .seed = 6 });
  vtkDoubleArray* const corners = vtkDoubleArray::New();
  corners->SetName("corners");
  markAsCorners(*corners);
  corners->SetNumberOfTuples(countVertices(half));
  forEachLeaf(half, [&](const double* b, vtkIdType id) {
    for (int c = 0; c < 8; ++c)
    {
      corners->SetComponent(id, c, b[c & 1] + 10. * b[2 + (c >> 1 & 1)] + 100. * b[4 + (c >> 2)]);
    }
  });
  half->GetCellData()->AddArray(corners);
  corners->Delete();
  vtkNew<vtkHyperTreeGridAxisReflection> reflection;
  reflection->SetInputData(half);
  reflection->SetPlaneToXMax();
  reflection->Update();
  const Grid other = vtkHyperTreeGrid::SafeDownCast(reflection->GetOutputDataObject(0));
  const MadeGrid made = merge({ half, other });
  EXPECT_TRUE(made.errors.empty()) << made.errors[0];
  std::vector<DrawnCell> expected = drawnCells(half, "scalar");
  const std::vector<DrawnCell> mirrored = drawnCells(other, "scalar");
  expected.insert(expected.end(), mirrored.begin(), mirrored.end());
  std::ranges::sort(expected, {}, &DrawnCell::bounds);
  expectSame(drawnCells(made.grid, "scalar"), expected);

  double bounds[6];
  half->GetBounds(bounds);
  vtkDataArray* const merged = made.grid->GetCellData()->GetArray("corners");
  EXPECT_TRUE(isAtCorners(*merged));
  forEachLeaf(made.grid, [&](const double* b, vtkIdType id) {
    for (int c = 0; c < 8; ++c)
    {
      const double x = b[c & 1];
      // VTK's reflection leaves components as they were: they belong to the corners that the cell had.
      const double before = x > bounds[1] ? 2. * bounds[1] - x : x;
      EXPECT_DOUBLE_EQ(
        merged->GetComponent(id, c), before + 10. * b[2 + (c >> 1 & 1)] + 100. * b[4 + (c >> 2)]);
    }
  });
}

TEST(MergeGrids, OfCellsAtOnePlaceTheFirstCounts)
{
  const auto grid = makeGrid({ .seed = 7 });
  const auto copy = Grid::New();
  copy->DeepCopy(grid);
  copy->GetCellData()->GetArray("scalar")->Fill(5.);
  expectSame(drawnCells(merge({ grid, copy }).grid, "scalar"), drawnCells(grid, "scalar"));
  for (const DrawnCell& cell : drawnCells(merge({ copy, grid }).grid, "scalar"))
  {
    ASSERT_EQ(cell.value, 5.);
  }
}

TEST(MergeGrids, OneGridIsItself)
{
  const auto grid = makeGrid({ .seed = 8 });
  const auto empty = Grid::New();
  const MadeGrid made = merge({ empty, grid });
  EXPECT_EQ(made.grid->GetCellData()->GetArray("scalar"), grid->GetCellData()->GetArray("scalar"));
  EXPECT_TRUE(merge({ empty }).errors.empty());
  const auto named = gridsWithTrees(collectionOf({ empty, grid }));
  ASSERT_EQ(named.size(), 1u);
  EXPECT_EQ(named[0].flatIndex, 2u); // the collection itself is 0
  EXPECT_EQ(makeGridBy<vtkTreeAMRMergeGrids>(grid).grid->GetNumberOfLeaves(), grid->GetNumberOfLeaves());
}

TEST(MergeGrids, WhatCannotBeMergedIsNamed)
{
  const auto grid = makeGrid({ .seed = 9, .levels = 2 });
  const auto without = Grid::New();
  without->DeepCopy(grid);
  without->GetCellData()->RemoveArray("count");
  const MadeGrid made = merge({ grid, without });
  ASSERT_EQ(made.warnings.size(), 1u);
  expectIn(made.warnings[0], "cell array 'count' is not in block 2");
  EXPECT_EQ(made.grid->GetCellData()->GetArray("count"), nullptr);

  const auto withPoints = collectionOf({ grid });
  withPoints->SetBlock(1, randomPoints({ 0., 1., 0., 1., 0., 1. }, 5));
  const MadeGrid beside = makeGridBy<vtkTreeAMRMergeGrids>(withPoints);
  EXPECT_EQ(beside.grid->GetNumberOfLeaves(), grid->GetNumberOfLeaves());
  ASSERT_EQ(beside.warnings.size(), 1u);
  expectIn(beside.warnings[0], "left out: block 2 is a vtkPolyData");

  const auto finer = makeUniformlyRefinedGrid(3);
  const auto coarser = makeUniformlyRefinedGrid(2);
  expectIn(errorOf<vtkTreeAMRMergeGrids>(collectionOf({ finer, coarser })),
    "block 1 and block 2: cells of different levels overlap at (0, 0, 0)");

  const auto shifted = Grid::New();
  shifted->DeepCopy(finer);
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->InsertNextValue(0.5);
  coordinates->InsertNextValue(1.5);
  shifted->SetXCoordinates(coordinates);
  expectIn(errorOf<vtkTreeAMRMergeGrids>(collectionOf({ finer, shifted })),
    "block 1: roots from 0.000000 to 1.000000 along x span 2 of the lattice that all grids form, allowed 1");
}

// As the whole: without gaps between the pieces.
TEST(MergeGrids, ContourAndProbeTakeACollectionAsOne)
{
  const auto whole = makeGrid({ .seed = 10 });
  std::vector<Grid> pieces;
  for (std::size_t p = 0; p < 2; ++p)
  {
    pieces.push_back(pieceOf(whole, [p](const double* bounds) { return pieceNumber(bounds, 2) == p; }));
  }
  std::vector<vtkSmartPointer<vtkPolyData>> contours;
  std::vector<vtkSmartPointer<vtkDataArray>> values;
  const auto points = randomPoints({ 0., 3., 0., 3., 0., 3. }, 500);
  const auto collection = collectionOf(pieces);
  for (vtkDataObject* const input : std::initializer_list<vtkDataObject*>{ whole, collection })
  {
    vtkNew<vtkTreeAMRContourFilter> contour;
    contour->SetInputDataObject(input);
    contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
    contour->SetValue(0, 0.2);
    const MessageCatcher warnings(contour, vtkCommand::WarningEvent);
    contour->Update();
    EXPECT_TRUE(warnings.messages().empty());
    contours.emplace_back(contour->GetOutput());
    vtkNew<vtkTreeAMRProbeFilter> probe;
    probe->SetInputData(points);
    probe->SetInputDataObject(1, input);
    probe->Update();
    values.emplace_back(probe->GetOutput()->GetPointData()->GetArray("scalar"));
  }
  ASSERT_GT(contours[0]->GetNumberOfPolys(), 100);
  EXPECT_EQ(contours[1]->GetNumberOfPolys(), contours[0]->GetNumberOfPolys());
  EXPECT_EQ(contours[1]->GetNumberOfPoints(), contours[0]->GetNumberOfPoints());
  ASSERT_TRUE(values[0] && values[1]);
  for (vtkIdType i = 0; i < 500; ++i)
  {
    ASSERT_EQ(values[1]->GetComponent(i, 0), values[0]->GetComponent(i, 0));
  }
}

TEST(MergeGrids, OfGridsThatAreNoOneContourAndProbeSaySo)
{
  const auto one = makeUniformlyRefinedGrid(3);
  const auto other = Grid::New();
  other->DeepCopy(one);
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->InsertNextValue(0.5);
  coordinates->InsertNextValue(1.5);
  other->SetXCoordinates(coordinates);
  const auto collection = collectionOf({ one, other });
  vtkNew<vtkTreeAMRContourFilter> contour;
  contour->SetInputDataObject(collection);
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
  contour->SetValue(0, 100.5);
  const MessageCatcher warnings(contour, vtkCommand::WarningEvent);
  contour->Update();
  contour->SetValue(0, 101.5);
  contour->Update();
  ASSERT_EQ(warnings.messages().size(), 1u); // once
  expectIn(warnings.messages()[0],
    "contoured one by one, with gaps between them, for they cannot be made one: block 1");
  vtkNew<vtkTreeAMRContourFilter> single;
  single->SetInputData(one);
  single->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
  single->SetValue(0, 101.5);
  single->Update();
  EXPECT_GT(single->GetOutput()->GetNumberOfPolys(), 0);
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPolys(), 2 * single->GetOutput()->GetNumberOfPolys());

  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(randomPoints({ 0., 1., 0., 1., 0., 1. }, 5));
  probe->SetInputDataObject(1, collection);
  const MessageCatcher errors(probe, vtkCommand::ErrorEvent);
  probe->Update();
  ASSERT_GE(errors.messages().size(), 1u);
  expectIn(
    errors.messages()[0], "probe: the grids of Source, a vtkMultiBlockDataSet, cannot be made one: block 1");
}

// Forests of two dimensions, written by libp4est, as grids in a plane: each cell against libp4est's own bounds.
#include "Support/PlanarForest.h"
#include "Support/ForestBytes.h"
#include "Support/HyperTreeGrids.h"

#include "Error.h"
#include "HyperTreeGridConverter.h"
#include "vtkTreeAMRP4estReader.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridToUnstructuredGrid.h"
#include "vtkNew.h"
#include "vtkUnstructuredGrid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

using namespace treeamr::test;

namespace
{

class PlanarForestTest : public ::testing::Test
{
protected:
  vtkHyperTreeGrid* read(const PlanarForest& forest, bool withPayload = true)
  {
    forest.save(path_, withPayload);
    reader_->SetFileName(path_.c_str());
    reader_->SetPayload(withPayload ? "double value" : "");
    reader_->GenerateLevelOn();
    reader_->Modified();
    reader_->Update();
    return reader_->GetHyperTreeGridOutput();
  }
  std::string errorOf(const PlanarForest& forest)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    EXPECT_EQ(read(forest)->GetNumberOfNonEmptyTrees(), 0);
    EXPECT_EQ(errors.messages().size(), 1u);
    return errors.messages().empty() ? "" : errors.messages()[0];
  }
  /// As VTK's own filter draws them.
  static void expectCells(vtkHyperTreeGrid* grid, const std::vector<PlanarForest::Quadrant>& quadrants)
  {
    vtkNew<vtkHyperTreeGridToUnstructuredGrid> filter;
    filter->SetInputData(grid);
    filter->Update();
    vtkUnstructuredGrid* const cells = vtkUnstructuredGrid::SafeDownCast(filter->GetOutput());
    ASSERT_EQ(cells->GetNumberOfCells(), static_cast<vtkIdType>(quadrants.size()));
    std::map<std::array<double, 3>, vtkIdType> byLowCorner;
    for (vtkIdType cell = 0; cell < cells->GetNumberOfCells(); ++cell)
    {
      const double* const bounds = cells->GetCell(cell)->GetBounds();
      byLowCorner[{ bounds[0], bounds[2], bounds[4] }] = cell;
    }
    for (const PlanarForest::Quadrant& quadrant : quadrants)
    {
      const auto& [a, b] = quadrant.corners;
      const std::array<double, 3> low{ std::min(a[0], b[0]), std::min(a[1], b[1]), a[2] };
      const auto found = byLowCorner.find(low);
      ASSERT_NE(found, byLowCorner.end()) << low[0] << ' ' << low[1] << ' ' << low[2];
      const vtkIdType cell = found->second;
      EXPECT_EQ(cells->GetCell(cell)->GetBounds()[1], std::max(a[0], b[0]));
      EXPECT_EQ(cells->GetCell(cell)->GetBounds()[3], std::max(a[1], b[1]));
      const auto component = [&](const char* name) {
        return cells->GetCellData()->GetArray(name)->GetComponent(cell, 0);
      };
      EXPECT_EQ(component("value"), quadrant.value);
      EXPECT_EQ(component("level"), quadrant.level);
      EXPECT_EQ(component("treeid"), quadrant.tree);
    }
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("forest.p4est");
  vtkNew<vtkTreeAMRP4estReader> reader_;
};

} // namespace

TEST_F(PlanarForestTest, BricksAreGridsInAPlane)
{
  PlanarForest forest = PlanarForest::brick(3, 2);
  forest.refineAtRandom(5, 2);
  forest.moveCorners([](int, int, const PlanarForest::Point& p) {
    return PlanarForest::Point{ 2. * p[0] - 1., 0.5 * p[1], 7. };
  });
  ASSERT_GT(forest.quadrants().size(), 30u);
  vtkHyperTreeGrid* const grid = read(forest);
  expectCells(grid, forest.quadrants());
  EXPECT_STREQ(grid->GetCellData()->GetScalars()->GetName(), "value");
  // A coarse cell has the mean of its four children.
  vtkDataArray* const values = grid->GetCellData()->GetArray("value");
  vtkHyperTreeGrid::vtkHyperTreeGridIterator trees;
  grid->InitializeTreeIterator(trees);
  int coarse = 0;
  while (vtkHyperTree* const tree = trees.GetNextTree())
  {
    for (vtkIdType v = 0; v < tree->GetNumberOfVertices(); ++v)
    {
      if (!tree->IsLeaf(v))
      {
        double sum = 0.;
        for (int child = 0; child < 4; ++child)
        {
          sum += values->GetComponent(tree->GetGlobalIndexFromLocal(tree->GetElderChildIndex(v) + child), 0);
        }
        EXPECT_DOUBLE_EQ(values->GetComponent(tree->GetGlobalIndexFromLocal(v), 0), sum / 4.);
        ++coarse;
      }
    }
  }
  EXPECT_GT(coarse, 5);

  EXPECT_EQ(read(forest, false)->GetCellData()->GetNumberOfArrays(), 2); // level and treeid
}

TEST_F(PlanarForestTest, TreesMayBeTurnedAndReflected)
{
  // Corners of a unit square, counted from another one and in another direction.
  constexpr std::array<std::array<int, 4>, 8> orders{ { { 0, 1, 2, 3 }, { 1, 0, 3, 2 }, { 2, 3, 0, 1 },
    { 3, 2, 1, 0 }, { 0, 2, 1, 3 }, { 1, 3, 0, 2 }, { 2, 0, 3, 1 }, { 3, 1, 2, 0 } } };
  PlanarForest forest = PlanarForest::brick(8, 1);
  forest.refineAtRandom(4, 2);
  forest.moveCorners([&](int tree, int corner, const PlanarForest::Point&) {
    const int at = orders[tree][corner];
    return PlanarForest::Point{ tree + static_cast<double>(at & 1), static_cast<double>(at >> 1), 0. };
  });
  expectCells(read(forest), forest.quadrants());
}

TEST_F(PlanarForestTest, FirstPieceHasAll)
{
  PlanarForest forest = PlanarForest::brick(3, 2);
  forest.refineAtRandom(3, 2);
  expectCells(read(forest), forest.quadrants());
  EXPECT_TRUE(reader_->UpdatePiece(1, 2, 0));
  EXPECT_EQ(reader_->GetHyperTreeGridOutput()->GetNumberOfNonEmptyTrees(), 0);
  EXPECT_TRUE(reader_->UpdatePiece(0, 2, 0));
  expectCells(reader_->GetHyperTreeGridOutput(), forest.quadrants());
}

TEST_F(PlanarForestTest, WithoutVerticesAreLaidOut)
{
  PlanarForest forest = PlanarForest::brick(2, 3);
  forest.refineAtRandom(4, 2);
  const auto quadrants = forest.quadrants();
  forest.dropVertices();
  expectCells(read(forest), quadrants);
  reader_->SetOrigin(1., 2., 3.);
  reader_->SetSpacing(4., 5., 6.);
  double bounds[6];
  read(forest)->GetBounds(bounds);
  EXPECT_EQ(std::vector<double>(bounds, bounds + 6), (std::vector<double>{ 1., 9., 2., 17., 3., 3. }));
}

TEST_F(PlanarForestTest, OthersAreRefused)
{
  for (const char* name : { "star", "disk", "moebius", "pillow", "cubed" })
  {
    EXPECT_NE(errorOf(PlanarForest::named(name)).find("tree "), std::string::npos) << name;
  }
  PlanarForest tilted = PlanarForest::brick(2, 1);
  tilted.moveCorners([](int, int, const PlanarForest::Point& p) {
    return PlanarForest::Point{ p[0], p[1], p[0] };
  });
  EXPECT_NE(errorOf(tilted).find("tree 0"), std::string::npos);
  PlanarForest torn = PlanarForest::brick(2, 1); // the second tree at another height
  torn.moveCorners([](int tree, int, const PlanarForest::Point& p) {
    return PlanarForest::Point{ p[0], p[1], static_cast<double>(tree) };
  });
  EXPECT_NE(errorOf(torn).find("tree 1"), std::string::npos);
}

TEST_F(PlanarForestTest, CannotBeRayTraced)
{
  PlanarForest forest = PlanarForest::brick(1, 1);
  forest.refineAtRandom(2, 1);
  try
  {
    treeamr::acquireField(read(forest), { "value" });
    FAIL();
  }
  catch (const treeamr::Error& e)
  {
    EXPECT_NE(std::string(e.what()).find("dimension"), std::string::npos) << e.what();
  }
}

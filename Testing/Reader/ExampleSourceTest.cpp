// The example data: sizes, values, 2:1 balance by brute force, and refused properties.
#include "vtkTreeAMRExampleSource.h"

#include "ExampleFields.h"
#include "HyperTreeGridConverter.h"

#include "Error.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

std::array<double, 3> centreOf(const DrawnCell& cell)
{
  return { 0.5 * (cell.bounds[0] + cell.bounds[3]), 0.5 * (cell.bounds[1] + cell.bounds[4]),
    0.5 * (cell.bounds[2] + cell.bounds[5]) };
}

double widthOf(const DrawnCell& cell)
{
  return cell.bounds[3] - cell.bounds[0];
}

/// Every coarse vertex has the mean of its children.
void expectMeans(vtkHyperTreeGrid* grid, const char* name)
{
  vtkDataArray* values = grid->GetCellData()->GetArray(name);
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  while (vtkHyperTree* tree = iterator.GetNextTree())
  {
    for (vtkIdType v = 0; v < tree->GetNumberOfVertices(); ++v)
    {
      if (tree->IsLeaf(v))
      {
        continue;
      }
      double sum = 0.;
      for (int o = 0; o < 8; ++o)
      {
        sum += values->GetTuple1(
          tree->GetGlobalIndexFromLocal(tree->GetElderChildIndex(static_cast<unsigned int>(v)) + o));
      }
      ASSERT_NEAR(values->GetTuple1(tree->GetGlobalIndexFromLocal(v)), sum / 8., 1e-12 * std::abs(sum));
    }
  }
}

/// The leaves of the unit cube by place and level.
class LeafMap
{
public:
  explicit LeafMap(const std::vector<DrawnCell>& cells)
  {
    for (const DrawnCell& cell : cells)
    {
      const int level = std::ilogb(1. / widthOf(cell));
      const auto scale = static_cast<double>(1 << level);
      leaves_[{ level, std::lround(cell.bounds[0] * scale), std::lround(cell.bounds[1] * scale),
        std::lround(cell.bounds[2] * scale) }] = true;
    }
  }

  /// Whether the leaves around each leaf are at most one level coarser, which is 2:1 balance seen from the
  /// finer side.
  bool isBalanced() const
  {
    for (const auto& [key, unused] : leaves_)
    {
      const auto [level, i, j, k] = key;
      const long end = 1L << level;
      for (long n = 0; n < 27; ++n)
      {
        const std::array<long, 3> p = { i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1 };
        const bool inside =
          *std::min_element(p.begin(), p.end()) >= 0 && *std::max_element(p.begin(), p.end()) < end;
        if (inside && !exists(level, p) && !leaves_.count({ level - 1, p[0] >> 1, p[1] >> 1, p[2] >> 1 }))
        {
          return false;
        }
      }
    }
    return true;
  }

  /// Whether a place is a leaf or refined; a refined one has some leaf at its corner.
  bool exists(int level, const std::array<long, 3>& p) const
  {
    for (int deeper = 0; deeper <= 12 - level; ++deeper)
    {
      if (leaves_.count({ level + deeper, p[0] << deeper, p[1] << deeper, p[2] << deeper }))
      {
        return true;
      }
    }
    return false;
  }

private:
  std::map<std::tuple<int, long, long, long>, bool> leaves_;
};

} // namespace

TEST(ExampleSource, SyntheticIsThePapers)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  source->Update();
  vtkHyperTreeGrid* grid = source->GetHyperTreeGridOutput();
  ASSERT_NE(grid->GetCellData()->GetScalars(), nullptr);
  EXPECT_STREQ(grid->GetCellData()->GetScalars()->GetName(), "xyz");
  const std::vector<DrawnCell> cells = drawnCells(grid, "xyz");
  EXPECT_EQ(cells.size(), 288u);
  double volume = 0.;
  for (const DrawnCell& cell : cells)
  {
    const auto [x, y, z] = centreOf(cell);
    EXPECT_EQ(widthOf(cell), x > 2. ? 0.5 : 1.);
    EXPECT_EQ(cell.value, x * y * z);
    volume += std::pow(widthOf(cell), 3.);
  }
  EXPECT_EQ(volume, 64.);
  expectMeans(grid, "xyz");
  EXPECT_EQ(acquireField(grid, { "xyz" })->octree().leafCount(), 288u);
}

namespace
{

/// With the defaults: the leaves that p8est_balance has for the same criterion, and their values.
template <class FieldFunction>
void expectLeavesOfTheBalancedForest(
  vtkTreeAMRExampleSource* source, const char* name, const FieldFunction& field, std::size_t leaves)
{
  source->Update();
  vtkHyperTreeGrid* grid = source->GetHyperTreeGridOutput();
  ASSERT_NE(grid->GetCellData()->GetScalars(), nullptr);
  EXPECT_STREQ(grid->GetCellData()->GetScalars()->GetName(), name);
  const std::vector<DrawnCell> cells = drawnCells(grid, name);
  ASSERT_EQ(cells.size(), leaves);
  double volume = 0.;
  for (const DrawnCell& cell : cells)
  {
    const auto [x, y, z] = centreOf(cell);
    ASSERT_EQ(cell.value, field(x, y, z));
    ASSERT_GE(widthOf(cell), 1. / 128.);
    ASSERT_LE(widthOf(cell), 1. / 16.);
    volume += std::pow(widthOf(cell), 3.);
  }
  EXPECT_EQ(volume, 1.);
  EXPECT_TRUE(LeafMap(cells).isBalanced());
  expectMeans(grid, name);
}

} // namespace

TEST(ExampleSource, MandelbulbHasTheLeavesOfTheBalancedForest)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToMandelbulb();
  expectLeavesOfTheBalancedForest(source, "mandelbulb", mandelbulb, 305096);
}

TEST(ExampleSource, ASheetByDefault)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  expectLeavesOfTheBalancedForest(source, "sheet", SaturatedSheet(), 617296);
}

TEST(ExampleSource, RefinesWhatTheThresholdAsksFor)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToMandelbulb();
  source->SetMinimumLevel(1);
  source->SetMaximumLevel(5);
  source->SetRefinementThreshold(0.3);
  source->Update();
  const LeafMap leaves(drawnCells(source->GetHyperTreeGridOutput(), "mandelbulb"));
  EXPECT_TRUE(leaves.isBalanced());
  int refined = 0;
  int kept = 0;
  const std::function<void(int, std::array<long, 3>)> visit = [&](int level, std::array<long, 3> p) {
    ASSERT_TRUE(leaves.exists(level, p));
    const double width = std::ldexp(1., -level);
    const bool refine = level < 1 ||
      (level < 5 && rangeOverProbes(mandelbulb, { p[0] * width, p[1] * width, p[2] * width }, width) > 0.3);
    refined += refine;
    kept += !refine && level < 5;
    for (long o = 0; refine && o < 8; ++o)
    {
      visit(level + 1, { 2 * p[0] + (o & 1), 2 * p[1] + (o >> 1 & 1), 2 * p[2] + (o >> 2) });
    }
  };
  visit(0, { 0, 0, 0 });
  EXPECT_GT(refined, 100);
  EXPECT_GT(kept, 100);
}

TEST(ExampleSource, TakesTheSmallestAndUniformLevels)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToMandelbulb();
  source->SetMinimumLevel(0);
  source->SetMaximumLevel(0);
  source->Update();
  EXPECT_EQ(countVertices(source->GetHyperTreeGridOutput()), 1);
  EXPECT_EQ(
    source->GetHyperTreeGridOutput()->GetCellData()->GetArray(0)->GetTuple1(0), mandelbulb(0.5, 0.5, 0.5));
  source->SetMaximumLevel(3);
  source->SetMinimumLevel(3);
  source->Update();
  EXPECT_EQ(source->GetHyperTreeGridOutput()->GetNumberOfLeaves(), 512);
  source->SetMinimumLevel(0);
  source->SetRefinementThreshold(2.); // more than the whole range
  source->Update();
  EXPECT_EQ(source->GetHyperTreeGridOutput()->GetNumberOfLeaves(), 1);
}

TEST(ExampleSource, LeavesOtherPiecesEmpty)
{
  for (const int dataset : { vtkTreeAMRExampleSource::SYNTHETIC, vtkTreeAMRExampleSource::MANDELBULB,
         vtkTreeAMRExampleSource::SHEET })
  {
    vtkNew<vtkTreeAMRExampleSource> source;
    source->SetDataset(dataset);
    source->UpdatePiece(1, 2, 0);
    EXPECT_EQ(countVertices(source->GetHyperTreeGridOutput()), 0);
    EXPECT_EQ(source->GetHyperTreeGridOutput()->GetCellData()->GetNumberOfArrays(), 1);
    source->UpdatePiece(0, 2, 0);
    EXPECT_GT(countVertices(source->GetHyperTreeGridOutput()), 0);
  }
}

TEST(ExampleSource, RefusesPropertiesOutOfRange)
{
  const auto expectError = [](const auto& change, const std::string& part) {
    vtkNew<vtkTreeAMRExampleSource> source;
    source->SetMinimumLevel(1);
    source->SetMaximumLevel(2);
    source->Update();
    const MessageCatcher errors(source, vtkCommand::ErrorEvent);
    const MessageCatcher pipeline(source->GetExecutive(), vtkCommand::ErrorEvent);
    change(source.Get());
    source->Update();
    ASSERT_EQ(errors.messages().size(), 1u) << part;
    EXPECT_NE(errors.messages()[0].find(part), std::string::npos) << errors.messages()[0];
    EXPECT_EQ(countVertices(source->GetHyperTreeGridOutput()), 0);
    EXPECT_EQ(source->GetHyperTreeGridOutput()->GetCellData()->GetNumberOfArrays(), 0);
  };
  using Source = vtkTreeAMRExampleSource*;
  expectError([](Source s) { s->SetDataset(3); }, "Dataset is 3");
  expectError(
    [](Source s) { s->SetMinimumLevel(3); }, "MinimumLevel is 3, allowed is 0 to MaximumLevel, which is 2");
  expectError([](Source s) { s->SetMinimumLevel(-1); }, "MinimumLevel is -1");
  expectError([](Source s) { s->SetMaximumLevel(13); }, "MaximumLevel is 13, allowed is 0 to 12");
  expectError([](Source s) { s->SetMaximumLevel(-1); }, "MaximumLevel is -1");
  expectError([](Source s) { s->SetRefinementThreshold(-0.1); }, "RefinementThreshold is -0.1");
  expectError([](Source s) { s->SetRefinementThreshold(std::nan("")); }, "RefinementThreshold is nan");
  expectError([](Source s) { s->SetRefinementThreshold(HUGE_VAL); }, "RefinementThreshold is inf");
  expectError(
    [](Source s) {
      s->SetMaximumLevel(12);
      s->SetMinimumLevel(12);
    },
    "more than 268435456 cells");
}

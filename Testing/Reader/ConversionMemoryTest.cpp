// What a conversion holds beside its result.
#include "HyperTreeGridConverter.h"

#include "Support/AllocationCounter.h"
#include "Support/HyperTreeGrids.h"

#include "vtkHyperTreeGrid.h"

#include <gtest/gtest.h>

using namespace treeamr;
using namespace treeamr::test;

TEST(ConversionMemory, NoListOfCellsBesideTheField)
{
  const auto grid = makeUniformlyRefinedGrid(6);
  std::shared_ptr<const Field> first;
  const std::size_t peak = peakBytes([&] { first = acquireField(grid, { "scalar" }); });
  const double cells = 262144.;
  ASSERT_EQ(static_cast<double>(first->octree().leafCount()), cells);
  const std::size_t result = first->octree().byteSize() + first->byteSize();
  const std::size_t stretches = std::size_t(512) * 4096; // what is counted for each
  EXPECT_LE(static_cast<double>(peak), static_cast<double>(result + stretches) + 0.6 * cells);

  vtkHyperTreeGrid* const sameGrid = grid;
  std::size_t ranges = 0;
  const std::size_t more =
    peakBytes([&] { ranges = acquireField(sameGrid, { "scalar" })->nodeRanges().byteSize(); });
  EXPECT_LE(static_cast<double>(more), static_cast<double>(ranges) + 1.5 * cells) << "no second field";
}

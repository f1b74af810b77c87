// What reading a forest holds beside the grid.
#include "vtkTreeAMRP4estReader.h"

#include "Support/AllocationCounter.h"
#include "Support/ForestBytes.h"
#include "Support/ForestWriter.h"

#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

using namespace treeamr::test;

TEST(ReadingMemory, BlocksOfQuadrantsAreAllThereIsBesideTheGrid)
{
  const TemporaryFolder folder;
  const std::string path = folder.file("forest.p8est");
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) { return q.level < 7; });
  forest.save(path);
  vtkNew<vtkTreeAMRP4estReader> reader;
  reader->SetFileName(path.c_str());
  const std::size_t peak = peakBytes([&] { tbb::task_arena(2).execute([&] { reader->Update(); }); });
  vtkHyperTreeGrid* const grid = reader->GetHyperTreeGridOutput();
  ASSERT_EQ(grid->GetNumberOfLeaves(), 1 << 21);
  // The tree's vector of 9.6 MB would take 25 MB when it doubles.
  EXPECT_LE(peak, 1024 * grid->GetActualMemorySize() + (std::size_t(6) << 20));
}

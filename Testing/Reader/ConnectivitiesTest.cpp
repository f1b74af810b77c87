// All connectivities that libp4est knows by name, saved from 1, 2 and 4 processes, with data and without: each cell against
// the bounds and the value that libp4est has, or refused with the tree that fits no lattice.
#include "Support/ForestBytes.h"
#include "Support/HyperTreeGrids.h"

#include "vtkTreeAMRP4estReader.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridToUnstructuredGrid.h"
#include "vtkNew.h"
#include "vtkUnstructuredGrid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>

using namespace treeamr::test;

namespace
{

struct Quadrant
{
  double tree;
  double value;
  std::array<std::array<double, 3>, 2> corners;
};
static_assert(sizeof(Quadrant) == 8 * sizeof(double));

/// By low and high corner.
using Cells = std::map<std::array<double, 6>, Quadrant>;

Cells cellsOf(const std::string& path, int ranks)
{
  Cells cells;
  for (int rank = 0; rank < ranks; ++rank)
  {
    std::ifstream file(path + "." + std::to_string(rank), std::ios::binary);
    Quadrant quadrant{};
    while (file.read(reinterpret_cast<char*>(&quadrant), sizeof(quadrant)))
    {
      std::array<double, 6> bounds{};
      for (int a = 0; a < 3; ++a)
      {
        std::tie(bounds[2 * a], bounds[2 * a + 1]) =
          std::minmax(quadrant.corners[0][a], quadrant.corners[1][a]);
      }
      cells[bounds] = quadrant;
    }
  }
  return cells;
}

void expectCells(vtkHyperTreeGrid* grid, const Cells& expected, bool withPayload)
{
  vtkNew<vtkHyperTreeGridToUnstructuredGrid> filter;
  filter->SetInputData(grid);
  filter->Update();
  auto* const cells = vtkUnstructuredGrid::SafeDownCast(filter->GetOutput());
  ASSERT_EQ(cells->GetNumberOfCells(), static_cast<vtkIdType>(expected.size()));
  for (vtkIdType cell = 0; cell < cells->GetNumberOfCells(); ++cell)
  {
    std::array<double, 6> bounds{};
    cells->GetCellBounds(cell, bounds.data());
    const auto found = expected.find(bounds);
    ASSERT_NE(found, expected.end()) << bounds[0] << ' ' << bounds[2] << ' ' << bounds[4];
    EXPECT_EQ(cells->GetCellData()->GetArray("treeid")->GetComponent(cell, 0), found->second.tree);
    if (withPayload)
    {
      EXPECT_EQ(cells->GetCellData()->GetArray("value")->GetComponent(cell, 0), found->second.value);
    }
  }
}

} // namespace

TEST(Connectivities, OfAllNamesSavedByAnyNumberOfProcesses)
{
  const std::vector<std::string> boxes{ "brick235", "periodic", "rotwrap", "twocubes", "twowrap", "unit" };
  const std::vector<std::string> others{ "rotcubes", "shell", "sphere" };
  std::string names;
  for (const auto& list : { boxes, others })
  {
    for (const std::string& name : list)
    {
      names += " " + name;
    }
  }
  for (const int ranks : { 1, 2, 4 })
  {
    const TemporaryFolder folder;
    const std::string command = std::string(TREEAMR_SAVE_CONNECTIVITIES) + " -np " + std::to_string(ranks) +
      " " + TREEAMR_SAVE_CONNECTIVITIES_PROGRAM + " " + folder.file("") + names;
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    for (const bool withPayload : { true, false })
    {
      const auto read = [&](vtkTreeAMRP4estReader* reader, const std::string& name) {
        reader->SetFileName((folder.file(name) + (withPayload ? ".p8est" : "-bare.p8est")).c_str());
        reader->SetPayload(withPayload ? "double value" : "");
        reader->GenerateLevelOn();
        reader->Update();
      };
      for (const std::string& name : boxes)
      {
        SCOPED_TRACE(name + " from " + std::to_string(ranks));
        vtkNew<vtkTreeAMRP4estReader> reader;
        read(reader, name);
        const Cells cells = cellsOf(folder.file(name), ranks);
        EXPECT_GT(cells.size(), 7u);
        expectCells(reader->GetHyperTreeGridOutput(), cells, withPayload);
      }
      for (const std::string& name : others)
      {
        SCOPED_TRACE(name + " from " + std::to_string(ranks));
        vtkNew<vtkTreeAMRP4estReader> reader;
        const MessageCatcher errors(reader, vtkCommand::ErrorEvent);
        read(reader, name);
        ASSERT_EQ(errors.messages().size(), 1u);
        EXPECT_NE(errors.messages()[0].find(": tree "), std::string::npos) << errors.messages()[0];
        EXPECT_EQ(reader->GetHyperTreeGridOutput()->GetNumberOfNonEmptyTrees(), 0);
      }
    }
  }
}

// Pieces of forests' files: each holds what its box needs and no process holds all.
#include "ForestReaderFixture.h"

#include "Forest/ForestPiece.h"
#include "Forest/P4estTreeLattice.h"
#include "GridPartition.h"
#include "HyperTreeGridConverter.h"
#include "Support/FieldVertices.h"

#include "vtkDataSetAttributes.h"
#include "vtkUnsignedCharArray.h"

#include <numeric>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using ForestPieceTest = ForestReaderFixture;

vtkSmartPointer<vtkHyperTreeGrid> pieceOf(const std::string& path, const char* payload, int piece, int pieces)
{
  vtkNew<vtkTreeAMRP4estReader> reader;
  const MessageCatcher errors(reader, vtkCommand::ErrorEvent);
  reader->SetFileName(path.c_str());
  reader->SetPayload(payload);
  reader->UpdatePiece(piece, pieces, 0);
  EXPECT_TRUE(errors.messages().empty()) << errors.messages()[0];
  return reader->GetHyperTreeGridOutput();
}

std::map<std::string, double> ownValues(vtkHyperTreeGrid* grid, const char* array)
{
  std::map<std::string, double> values;
  vtkUnsignedCharArray* const ghosts = grid->GetGhostCells();
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    const vtkIdType index = cursor->GetGlobalNodeIndex();
    if (cursor->IsMasked() || (ghosts && ghosts->GetValue(index) != 0))
    {
      return;
    }
    double bounds[6];
    cursor->GetBounds(bounds);
    std::string place;
    for (const double bound : bounds)
    {
      place += std::to_string(bound) + " ";
    }
    EXPECT_TRUE(values.emplace(place, grid->GetCellData()->GetArray(array)->GetTuple1(index)).second);
  });
  return values;
}

} // namespace

TEST_F(ForestPieceTest, EveryCellIsCountedOnceAndFieldsAreThoseOfTheWholeForest)
{
  auto cube = ForestWriter::unitCube();
  auto brick = ForestWriter::brick({ 3, 2, 1 });
  auto turned = turnedWall();
  cube.refine([](const ForestQuadrant& q) { return q.level < 3; });
  refineAtRandom(cube, 6, 3);
  refineAtRandom(brick, 5, 2);
  brick.balance(Balance::Full);
  refineAtRandom(turned, 5, 2);
  for (ForestWriter* forest : { &cube, &brick, &turned })
  {
    fillWithStates(*forest);
    const std::string path = folder_.file("forest.p8est");
    forest->save(path);
    const auto whole = pieceOf(path, stateText, 0, 1);
    EXPECT_FALSE(partitionOf(*whole));
    const auto all = ownValues(whole, "rho");
    const auto field = acquireField(whole, { "rho", 0 });
    for (const int pieces : { 2, 3, 5, 8 })
    {
      std::map<std::string, double> found;
      VertexDifferences differences;
      std::size_t held = 0;
      for (int piece = 0; piece < pieces; ++piece)
      {
        const auto grid = pieceOf(path, stateText, piece, pieces);
        const auto partition = partitionOf(*grid);
        ASSERT_TRUE(partition);
        EXPECT_EQ(partition->own, piece);
        EXPECT_EQ(static_cast<int>(partition->boxes.size()), pieces);
        const auto own = ownValues(grid, "rho");
        found.insert(own.begin(), own.end());
        if (countVertices(grid) == 0)
        {
          continue;
        }
        const auto part = acquireField(grid, { "rho", 0 });
        held += part->octree().leafCount();
        EXPECT_FALSE(part->octree().hasGhosts());
        differences.compare(*field, *part, partition->box());
      }
      EXPECT_EQ(found, all);
      EXPECT_EQ(differences.missing, 0u);
      EXPECT_EQ(differences.values, 0u) << "of " << differences.compared;
      EXPECT_EQ(differences.gradients, 0u) << "of " << differences.compared;
      EXPECT_LE(held, pieces * all.size());
    }
  }
}

TEST_F(ForestPieceTest, MorePiecesThanCellsLeaveSomeEmpty)
{
  auto forest = ForestWriter::unitCube();
  fillWithStates(forest);
  const std::string path = folder_.file("forest.p8est");
  forest.save(path);
  std::size_t cells = 0;
  for (int piece = 0; piece < 5; ++piece)
  {
    cells += ownValues(pieceOf(path, stateText, piece, 5), "rho").size();
  }
  EXPECT_EQ(cells, 1u);
}

TEST_F(ForestPieceTest, HoldsLittleMoreThanItsShare)
{
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) { return q.level < 6; });
  const std::string path = folder_.file("forest.p8est");
  forest.save(path);
  const P4estForestFile file(path);
  const TreeLattice lattice = p4estTreeLattice(file);
  for (const auto& [pieces, most] : { std::pair(2, 32 + 4), std::pair(8, 32 + 4) })
  {
    for (int piece = 0; piece < pieces; ++piece)
    {
      const ForestPiece part(file, lattice, piece, pieces);
      const std::uint64_t across = pieces == 2 ? 64 : static_cast<std::uint64_t>(most);
      EXPECT_LE(part.leafCount(), static_cast<std::uint64_t>(most) * across * across);
      EXPECT_GE(part.leafCount(), file.quadrantCount() / static_cast<std::uint64_t>(pieces));
      const auto nodes = part.nodeCounts();
      EXPECT_GT(nodes[0], part.leafCount());
    }
  }
}

// Too many cells for each to be counted, most of them in one corner.
TEST_F(ForestPieceTest, BoxesOfLargeForestsHoldAboutAsManyCells)
{
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) {
    const bool isNear = std::ranges::all_of(q.index, [&](std::uint32_t i) { return i < (3u << q.level) / 4; });
    return q.level < 5 || (q.level < 7 && isNear);
  });
  const std::string path = folder_.file("forest.p8est");
  forest.save(path);
  const P4estForestFile file(path);
  ASSERT_GT(file.quadrantCount(), std::uint64_t(3) << 18);
  const TreeLattice lattice = p4estTreeLattice(file);
  constexpr int pieces = 8;
  const ForestPiece first(file, lattice, 0, pieces);
  std::array<std::uint64_t, pieces> counts{};
  file.visitQuadrants([&](const TreeLeaf& leaf) {
    const CellId cell = lattice.cellOf(leaf.tree, leaf.index, leaf.level);
    const auto owner = std::ranges::find_if(first.boxes(), [&](const LatticeBox& box) { return box.owns(cell); });
    ++counts[static_cast<std::size_t>(owner - first.boxes().begin())];
  });
  EXPECT_LE(
    static_cast<double>(*std::ranges::max_element(counts)), 1.08 * static_cast<double>(file.quadrantCount()) / pieces);
}

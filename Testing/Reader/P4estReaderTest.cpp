// The reader's hyper tree grids against the forests of libp4est they were saved from, cell by cell.
#include "ForestReaderFixture.h"

#include "ExampleFields.h"

#include "vtkHyperTreeGridGeometry.h"
#include "vtkHyperTreeGridToUnstructuredGrid.h"
#include "vtkPolyData.h"
#include "vtkUnstructuredGrid.h"

#include <bit>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using P4estReaderTest = ForestReaderFixture;

/// Faces of leaves without a tree behind them: of the lattice's cells, which are unit cubes here.
vtkIdType countOuterFaces(const ForestWriter& forest)
{
  const std::vector<ForestQuadrant> quadrants = forest.quadrants();
  std::map<std::array<int, 3>, int> trees;
  const auto placeOf = [](const ForestWriter::Point& p) {
    return std::array{ int(std::floor(p[0])), int(std::floor(p[1])), int(std::floor(p[2])) };
  };
  for (const ForestQuadrant& q : quadrants)
  {
    trees[placeOf(forest.bounds(q)[0])] = q.tree;
  }
  vtkIdType faces = 0;
  for (const ForestQuadrant& q : quadrants)
  {
    for (int face = 0; face < 6; ++face)
    {
      const auto axis = static_cast<std::size_t>(face / 2);
      const bool upper = face % 2;
      std::array<int, 3> behind = placeOf(forest.bounds(q)[0]);
      behind[axis] += upper ? 1 : -1;
      const std::uint32_t atSide = upper ? (1u << q.level) - 1 : 0;
      faces += q.index[axis] == atSide && !trees.contains(behind);
    }
  }
  return faces;
}

TEST_F(P4estReaderTest, OneCell)
{
  auto forest = ForestWriter::unitCube();
  this->expectReadsAs(forest);
  EXPECT_EQ(countVertices(reader_->GetHyperTreeGridOutput()), 1);
}

TEST_F(P4estReaderTest, UnitCubeUnbalancedAndBalanced)
{
  for (const int balance : { -1, 0, 1, 2 })
  {
    auto forest = ForestWriter::unitCube();
    forest.refine([](const ForestQuadrant& q) { return q.level < 2; });
    refineAtRandom(forest, 6, 3);
    if (balance >= 0)
    {
      forest.balance(static_cast<Balance>(balance));
    }
    this->expectReadsAs(forest);
  }
}

TEST_F(P4estReaderTest, Bricks)
{
  for (const bool periodic : { false, true })
  {
    for (const std::array<int, 3> trees :
      { std::array{ 1, 1, 1 }, std::array{ 2, 1, 1 }, std::array{ 3, 2, 5 }, std::array{ 7, 1, 3 } })
    {
      auto forest = ForestWriter::brick(trees, { periodic, periodic, false });
      refineAtRandom(forest, 4, 3);
      this->expectReadsAs(forest);
      const unsigned int* const cells = reader_->GetHyperTreeGridOutput()->GetCellDims();
      EXPECT_EQ((std::array{ int(cells[0]), int(cells[1]), int(cells[2]) }), trees);
    }
  }
}

TEST_F(P4estReaderTest, StretchedBrick)
{
  auto forest = ForestWriter::brick({ 4, 2, 2 });
  forest.moveVertices([](const ForestWriter::Point& p) {
    return ForestWriter::Point{ p[0] * p[0] - 5., 0.1 * p[1], 1e3 + 7. * p[2] };
  });
  refineAtRandom(forest, 4, 2);
  this->expectReadsAs(forest);
}

TEST_F(P4estReaderTest, DeepestLevelTowardsACorner)
{
  auto forest = ForestWriter::brick({ 1, 2, 1 });
  forest.refine([](const ForestQuadrant& q) {
    const std::uint32_t last = (1u << q.level) - 1;
    return q.level < ForestWriter::maxLevel && q.index == std::array{ last, last, last };
  });
  this->expectReadsAs(forest);
  EXPECT_EQ(reader_->GetHyperTreeGridOutput()->GetNumberOfLevels(),
    static_cast<unsigned int>(ForestWriter::maxLevel) + 1);
}

// ParaView's own filters see the same cells: also beside places without a tree.
TEST_F(P4estReaderTest, FiltersOfVtk)
{
  ForestWriter::Corners box;
  const auto boxAt = [&](double x, double y, double z) {
    for (int c = 0; c < 8; ++c)
    {
      box[c] = { x + (c & 1), y + (c >> 1 & 1), z + (c >> 2) };
    }
    return box;
  };
  const std::string path = folder_.file("forest.p8est");
  for (ForestWriter forest :
    { ForestWriter::unitCube(), ForestWriter::brick({ 3, 2, 2 }, { true, true, true }),
      ForestWriter::separateTrees({ boxAt(2, 0, 0), boxAt(0, 0, 0), boxAt(1, 1, 0), boxAt(1, 1, 1) }) })
  {
    forest.refine([](const ForestQuadrant& q) { return q.level < 1; });
    refineAtRandom(forest, 4, 3);
    fillWithStates(forest);
    forest.save(path);
    this->read(path, stateText, false);

    vtkNew<vtkHyperTreeGridGeometry> surface;
    surface->SetInputConnection(reader_->GetOutputPort());
    surface->Update();
    EXPECT_EQ(surface->GetPolyDataOutput()->GetNumberOfCells(), countOuterFaces(forest));

    vtkNew<vtkHyperTreeGridToUnstructuredGrid> cells;
    cells->SetInputConnection(reader_->GetOutputPort());
    cells->Update();
    vtkUnstructuredGrid* const hexahedra = cells->GetUnstructuredGridOutput();
    ASSERT_EQ(hexahedra->GetNumberOfCells(), forest.quadrantCount());
    std::map<std::array<double, 3>, double> byCorner;
    for (const ForestQuadrant& q : forest.quadrants())
    {
      byCorner[forest.bounds(q)[0]] = stateOf(q).rho;
    }
    for (vtkIdType i = 0; i < hexahedra->GetNumberOfCells(); ++i)
    {
      double bounds[6];
      hexahedra->GetCellBounds(i, bounds);
      const auto found = byCorner.find({ bounds[0], bounds[2], bounds[4] });
      ASSERT_NE(found, byCorner.end());
      ASSERT_EQ(hexahedra->GetCellData()->GetArray("rho")->GetTuple1(i), found->second);
    }
  }
}

using Box = std::array<double, 6>;

/// Where the forest's leaves are, and their values. toGrid: from the space of its vertices, box to box.
std::map<Box, double> leavesOf(
  const ForestWriter& forest, const std::function<ForestWriter::Point(const ForestWriter::Point&)>& toGrid)
{
  std::map<Box, double> leaves;
  for (const ForestQuadrant& q : forest.quadrants())
  {
    const std::array<ForestWriter::Point, 2> corners = forest.bounds(q);
    const ForestWriter::Point a = toGrid(corners[0]);
    const ForestWriter::Point b = toGrid(corners[1]);
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box[2 * axis] = std::min(a[axis], b[axis]);
      box[2 * axis + 1] = std::max(a[axis], b[axis]);
    }
    leaves[box] = stateOf(q).rho;
  }
  return leaves;
}

void expectBoxes(vtkHyperTreeGrid* grid, const std::map<Box, double>& expected)
{
  std::size_t count = 0;
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    Box box;
    cursor->GetBounds(box.data());
    const auto found = expected.find(box);
    ASSERT_TRUE(found != expected.end()) << box[0] << ' ' << box[2] << ' ' << box[4];
    ASSERT_EQ(grid->GetCellData()->GetArray("rho")->GetTuple1(cursor->GetGlobalNodeIndex()), found->second);
    ++count;
  });
  EXPECT_EQ(count, expected.size());
}

ForestWriter turnedRow()
{
  std::vector<ForestWriter::Corners> trees = turnedCubes(true);
  for (std::size_t i = 0; i < trees.size(); ++i)
  {
    move(trees[i], { static_cast<double>(i), 0., 0. });
  }
  return ForestWriter::separateTrees(trees);
}

TEST_F(P4estReaderTest, TreesAreTurnedAsTheirVerticesAre)
{
  ForestWriter reflected = ForestWriter::brick({ 2, 3, 1 });
  reflected.moveVertices([](const ForestWriter::Point& p) {
    return ForestWriter::Point{ p[1], -2. * p[2], 0.5 * p[0] };
  });
  for (ForestWriter forest :
    { turnedRow(), turnedWall(), ForestWriter::named("twowrap"), ForestWriter::named("rotwrap"), reflected })
  {
    refineAnyhow(forest);
    const std::string path = folder_.file("turned.p8est");
    forest.save(path);
    expectBoxes(this->read(path, stateText, false), leavesOf(forest, [](const auto& p) { return p; }));
  }
}

// The first tree's axes are the grid's.
TEST_F(P4estReaderTest, TreesWithoutVerticesAreLaidOutFromFaceToFace)
{
  reader_->SetOrigin(-8., 0.5, 4.);
  reader_->SetSpacing(1., 0.25, 2.);
  for (ForestWriter forest :
    { ForestWriter::brick({ 3, 2, 4 }), ForestWriter::brick({ 3, 2, 4 }, { true, true, true }), turnedWall(),
      ForestWriter::named("twocubes") })
  {
    refineAnyhow(forest);
    const ForestWriter::Point first = forest.bounds({})[0];
    std::array<ForestWriter::Point, 3> axes;
    for (std::size_t a = 0; a < 3; ++a)
    {
      ForestQuadrant next;
      next.index[a] = 1;
      axes[a] = forest.bounds(next)[0];
    }
    const auto inFirst = [&](const ForestWriter::Point& p) {
      ForestWriter::Point at{};
      for (std::size_t a = 0; a < 3; ++a)
      {
        for (std::size_t w = 0; w < 3; ++w)
        {
          at[a] += (p[w] - first[w]) * (axes[a][w] - first[w]);
        }
      }
      return at;
    };
    ForestWriter::Point least{};
    for (const ForestQuadrant& q : forest.quadrants())
    {
      for (const ForestWriter::Point& corner : forest.bounds(q))
      {
        std::ranges::transform(
          least, inFirst(corner), least.begin(), [](double a, double b) { return std::min(a, b); });
      }
    }
    const auto toGrid = [&](const ForestWriter::Point& p) {
      const ForestWriter::Point at = inFirst(p);
      return ForestWriter::Point{ -8. + (at[0] - least[0]), 0.5 + 0.25 * (at[1] - least[1]),
        4. + 2. * (at[2] - least[2]) };
    };
    const std::map<Box, double> expected = leavesOf(forest, toGrid);
    forest.dropVertices();
    const std::string path = folder_.file("topology.p8est");
    forest.save(path);
    expectBoxes(this->read(path, stateText, false), expected);
  }
}

TEST_F(P4estReaderTest, OtherFiles)
{
  this->expectError(folder_.file("nothing.p8est"), "", "no such file");
  this->expectError(folder_.file(""), "", "a directory");
  this->expectError("", "", "FileName is not set");
  EXPECT_EQ(reader_->CanReadFile(nullptr), 0);
  EXPECT_EQ(reader_->CanReadFile(folder_.file("nothing.p8est").c_str()), 0);
  EXPECT_EQ(reader_->CanReadFile(folder_.file("").c_str()), 0);

  const std::string path = folder_.file("other.p8est");
  writeBytes(path, {});
  this->expectError(path, "", "begins with");
  EXPECT_EQ(reader_->CanReadFile(path.c_str()), 0);

  ForestWriter::named("rotcubes").save(path);
  this->expectError(path, "", "an axis-aligned box");
  ForestWriter sphere = ForestWriter::named("sphere");
  sphere.dropVertices();
  sphere.save(path);
  this->expectError(path, "", "turned against where other faces put it");
}

TEST_F(P4estReaderTest, SpoiltFiles)
{
  const std::string path = folder_.file("spoilt.p8est");
  smallBrick().save(path);
  const Bytes bytes = readBytes(path);
  std::mt19937_64 random(3);
  const MessageCatcher failures(reader_->GetExecutive(), vtkCommand::ErrorEvent);
  reader_->SetFileName(path.c_str());
  reader_->SetPayload("float value[3]");
  int errorCount = 0;
  for (int i = 0; i < 500; ++i)
  {
    Bytes spoilt = bytes;
    spoilt[random() % bytes.size()] ^= std::byte(1 << random() % 8);
    if (i % 10 == 0)
    {
      spoilt.resize(random() % bytes.size());
    }
    writeBytes(path, spoilt);
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    reader_->Modified();
    reader_->Update();
    ASSERT_LE(errors.messages().size(), 1u);
    errorCount += static_cast<int>(errors.messages().size());
    if (!errors.messages().empty())
    {
      this->expectEmpty();
    }
  }
  EXPECT_GT(errorCount, 200);
}

// The demo's data, with the number of cells the field, the criterion and the balance are known to give.
TEST_F(P4estReaderTest, Mandelbulb)
{
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) {
    const double width = std::ldexp(1., -q.level);
    return q.level < 4 ||
      (q.level < 7 &&
        rangeOverProbes(mandelbulb, { q.index[0] * width, q.index[1] * width, q.index[2] * width }, width) >
          0.05);
  });
  forest.balance(Balance::Full);
  ASSERT_EQ(forest.quadrantCount(), 305096);
  forest.setPayload(sizeof(double), [](const ForestQuadrant& q, std::byte* payload) {
    const double width = std::ldexp(1., -q.level);
    const double value =
      mandelbulb((q.index[0] + 0.5) * width, (q.index[1] + 0.5) * width, (q.index[2] + 0.5) * width);
    std::memcpy(payload, &value, sizeof(value));
  });
  const std::string path = folder_.file("mandelbulb.p8est");
  forest.save(path);
  vtkHyperTreeGrid* const grid = this->read(path, "double field", false);
  EXPECT_EQ(countVertices(grid), 305096 + 305095 / 7);
  vtkDataArray* const field = grid->GetCellData()->GetArray("field");
  vtkIdType leaves = 0;
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    double centre[3];
    cursor->GetPoint(centre);
    ASSERT_EQ(field->GetTuple1(cursor->GetGlobalNodeIndex()), mandelbulb(centre[0], centre[1], centre[2]));
    ++leaves;
  });
  EXPECT_EQ(leaves, 305096);
}

} // namespace

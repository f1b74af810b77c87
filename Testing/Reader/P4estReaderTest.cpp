// The reader's hyper tree grids against the forests of libp4est they were saved from, cell by cell.
#include "vtkTreeAMRP4estReader.h"

#include "ExampleFields.h"

#include "Support/ExampleForests.h"
#include "Support/ForestBytes.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkErrorCode.h"
#include "vtkExecutive.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridGeometry.h"
#include "vtkHyperTreeGridNonOrientedGeometryCursor.h"
#include "vtkHyperTreeGridToUnstructuredGrid.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkUnstructuredGrid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// What a simulation might keep in its quadrants.
struct State
{
  double rho;
  float velocity[3];
  int rank;
  unsigned char flags[2];
  long long id;
};
constexpr const char* stateText =
  "double rho; float velocity[3]; int rank; unsigned char flags[2]; long long id";

State stateOf(const ForestQuadrant& q)
{
  const std::uint64_t h = hashOf(q);
  const auto part = [&](int i) { return static_cast<float>(h >> i & 255) / 16.f; };
  State state{};
  state.rho = std::ldexp(static_cast<double>(h >> 11), -53);
  std::ranges::generate(state.velocity, [&, i = 0]() mutable { return part(8 * i++); });
  state.rank = static_cast<int>(h);
  state.flags[0] = static_cast<unsigned char>(h >> 40);
  state.flags[1] = static_cast<unsigned char>(h >> 48);
  state.id = static_cast<long long>(h);
  return state;
}

void fillWithStates(ForestWriter& forest)
{
  forest.setPayload(sizeof(State), [](const ForestQuadrant& q, std::byte* payload) {
    const State state = stateOf(q);
    std::memcpy(payload, &state, sizeof(state));
  });
}

using Visit = std::function<void(vtkHyperTreeGridNonOrientedGeometryCursor*)>;

void visitLeaves(vtkHyperTreeGridNonOrientedGeometryCursor* cursor, const Visit& visit)
{
  if (cursor->IsLeaf())
  {
    visit(cursor);
    return;
  }
  for (unsigned char child = 0; child < 8; ++child)
  {
    cursor->ToChild(child);
    visitLeaves(cursor, visit);
    cursor->ToParent();
  }
}

/// All leaves by VTK's own cursor.
void visitLeaves(vtkHyperTreeGrid* grid, const Visit& visit)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
  vtkIdType index;
  while (iterator.GetNextTree(index))
  {
    grid->InitializeNonOrientedGeometryCursor(cursor, index);
    visitLeaves(cursor, visit);
  }
}

/// Coarse vertices with their children's first global index; children of a vertex follow each other.
void visitCoarse(vtkHyperTreeGrid* grid, const std::function<void(vtkIdType, vtkIdType)>& visit)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
  grid->InitializeTreeIterator(iterator);
  while (vtkHyperTree* tree = iterator.GetNextTree())
  {
    for (vtkIdType vertex = 0; vertex < tree->GetNumberOfVertices(); ++vertex)
    {
      if (!tree->IsLeaf(vertex))
      {
        visit(tree->GetGlobalIndexFromLocal(vertex),
          tree->GetGlobalIndexFromLocal(tree->GetElderChildIndex(static_cast<unsigned int>(vertex))));
      }
    }
  }
}

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

class P4estReaderTest : public ::testing::Test
{
protected:
  /// Reads without a message.
  vtkHyperTreeGrid* read(const std::string& path, const char* payload, bool generateLevel)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetPayload(payload);
    reader_->SetGenerateLevel(generateLevel);
    reader_->Modified(); // the file may be another under the same name
    reader_->Update();
    EXPECT_TRUE(errors.messages().empty()) << errors.messages()[0];
    EXPECT_TRUE(warnings.messages().empty()) << warnings.messages()[0];
    EXPECT_EQ(reader_->GetErrorCode(), vtkErrorCode::NoError);
    return reader_->GetHyperTreeGridOutput();
  }

  /// Reads without a Payload and returns the one warning.
  std::string warningOf(const std::string& path)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetPayload("");
    reader_->SetGenerateLevel(false);
    reader_->Modified();
    reader_->Update();
    EXPECT_TRUE(errors.messages().empty()) << errors.messages()[0];
    EXPECT_EQ(warnings.messages().size(), 1u);
    return warnings.messages().empty() ? "" : warnings.messages()[0];
  }

  std::vector<std::string> arraysRead()
  {
    vtkCellData* const data = reader_->GetHyperTreeGridOutput()->GetCellData();
    std::vector<std::string> names;
    for (int i = 0; i < data->GetNumberOfArrays(); ++i)
    {
      names.emplace_back(data->GetArrayName(i));
    }
    return names;
  }

  /// Reading fails with a message that has this part, and leaves nothing.
  void expectError(const std::string& path, const char* payload, const std::string& part)
  {
    const MessageCatcher errors(reader_, vtkCommand::ErrorEvent);
    const MessageCatcher failures(reader_->GetExecutive(), vtkCommand::ErrorEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetPayload(payload);
    reader_->Modified();
    // A failed pipeline of one process would let the filters of others wait.
    EXPECT_TRUE(reader_->UpdatePiece(0, 1, 0));
    EXPECT_TRUE(failures.messages().empty());
    EXPECT_NE(reader_->GetErrorCode(), vtkErrorCode::NoError);
    ASSERT_EQ(errors.messages().size(), 1u) << part;
    EXPECT_NE(errors.messages()[0].find(part), std::string::npos)
      << errors.messages()[0] << "should say " << part;
    expectEmpty();
  }

  void expectEmpty()
  {
    vtkHyperTreeGrid* const grid = reader_->GetHyperTreeGridOutput();
    EXPECT_EQ(countVertices(grid), 0);
    EXPECT_EQ(grid->GetCellData()->GetNumberOfArrays(), 0);
  }

  /// Everything about a forest of State.
  void expectReadsAs(ForestWriter& forest)
  {
    fillWithStates(forest);
    const std::string path = folder_.file("forest.p8est");
    forest.save(path);
    vtkHyperTreeGrid* const grid = this->read(path, stateText, true);
    this->expectLeaves(grid, forest);
    this->expectCoarse(grid);
  }

  void expectLeaves(vtkHyperTreeGrid* grid, const ForestWriter& forest)
  {
    std::map<int, std::vector<ForestQuadrant>> trees;
    for (const ForestQuadrant& q : forest.quadrants())
    {
      trees[q.tree].push_back(q);
    }
    vtkCellData* const data = grid->GetCellData();
    std::map<int, std::size_t> visited;
    visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
      const vtkIdType id = cursor->GetGlobalNodeIndex();
      const int tree = static_cast<int>(data->GetArray("treeid")->GetTuple1(id));
      ASSERT_LT(visited[tree], trees[tree].size());
      const ForestQuadrant& q = trees[tree][visited[tree]++];
      ASSERT_EQ(cursor->GetLevel(), static_cast<unsigned int>(q.level));
      ASSERT_EQ(data->GetArray("level")->GetTuple1(id), q.level);

      double bounds[6];
      cursor->GetBounds(bounds);
      const std::array<ForestWriter::Point, 2> expected = forest.bounds(q);
      for (int a = 0; a < 3; ++a)
      {
        const double width = expected[1][a] - expected[0][a];
        const double rounding = 1e-15 * (std::abs(expected[0][a]) + std::abs(expected[1][a]));
        ASSERT_NEAR(bounds[2 * a], expected[0][a], rounding) << q.level;
        ASSERT_NEAR(bounds[2 * a + 1] - bounds[2 * a], width, rounding);
      }

      const State state = stateOf(q);
      ASSERT_EQ(data->GetArray("rho")->GetTuple1(id), state.rho);
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_EQ(data->GetArray("velocity")->GetComponent(id, c), state.velocity[c]);
      }
      ASSERT_EQ(data->GetArray("rank")->GetTuple1(id), state.rank);
      ASSERT_EQ(data->GetArray("flags")->GetComponent(id, 0), state.flags[0]);
      ASSERT_EQ(data->GetArray("flags")->GetComponent(id, 1), state.flags[1]);
      ASSERT_EQ(data->GetArray("id")->GetVariantValue(id).ToLongLong(), state.id);
    });
    for (const auto& [tree, quadrants] : trees)
    {
      EXPECT_EQ(visited[tree], quadrants.size()) << "tree " << tree;
    }
  }

  void expectCoarse(vtkHyperTreeGrid* grid)
  {
    vtkCellData* const data = grid->GetCellData();
    visitCoarse(grid, [&](vtkIdType node, vtkIdType child) {
      for (const auto& [name, components] : { std::pair("rho", 1), std::pair("velocity", 3) })
      {
        for (int c = 0; c < components; ++c)
        {
          double mean = 0.;
          for (int i = 0; i < 8; ++i)
          {
            mean += data->GetArray(name)->GetComponent(child + i, c) / 8.;
          }
          ASSERT_NEAR(data->GetArray(name)->GetComponent(node, c), mean, 1e-6);
        }
      }
      ASSERT_EQ(data->GetArray("id")->GetVariantValue(node).ToLongLong(),
        data->GetArray("id")->GetVariantValue(child).ToLongLong());
      ASSERT_EQ(
        data->GetArray("flags")->GetComponent(node, 1), data->GetArray("flags")->GetComponent(child, 1));
      ASSERT_EQ(data->GetArray("level")->GetTuple1(node), data->GetArray("level")->GetTuple1(child) - 1);
      ASSERT_EQ(data->GetArray("treeid")->GetTuple1(node), data->GetArray("treeid")->GetTuple1(child));
    });
  }

  TemporaryFolder folder_;
  vtkNew<vtkTreeAMRP4estReader> reader_;
};

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

/// Of the unit cube: all 48 turned and reflected ones, or the turned ones alone.
std::vector<ForestWriter::Corners> turnedCubes(bool reflectedToo)
{
  std::vector<ForestWriter::Corners> cubes;
  std::array<std::size_t, 3> axes{ 0, 1, 2 };
  do
  {
    const bool isEven = (axes[0] < axes[1]) == ((axes[1] < axes[2]) == (axes[0] < axes[2]));
    for (int flips = 0; flips < 8; ++flips)
    {
      if (!reflectedToo && (std::popcount(static_cast<unsigned>(flips)) % 2 == 0) != isEven)
      {
        continue;
      }
      ForestWriter::Corners& corners = cubes.emplace_back();
      for (int c = 0; c < 8; ++c)
      {
        for (std::size_t a = 0; a < 3; ++a)
        {
          corners[static_cast<std::size_t>(c)][axes[a]] = (c ^ flips) >> a & 1;
        }
      }
    }
  }
  while (std::ranges::next_permutation(axes).found);
  return cubes;
}

void move(ForestWriter::Corners& corners, const ForestWriter::Point& by)
{
  for (ForestWriter::Point& corner : corners)
  {
    std::ranges::transform(corner, by, corner.begin(), std::plus());
  }
}

/// A wall of three by two by two trees with one left out, each turned in any way.
ForestWriter turnedWall()
{
  const std::vector<ForestWriter::Corners> cubes = turnedCubes(false);
  EXPECT_EQ(cubes.size(), 24u);
  std::mt19937 random(5);
  std::vector<ForestWriter::Corners> trees;
  for (int i = 0; i < 11; ++i)
  {
    trees.push_back(cubes[random() % cubes.size()]);
    move(trees.back(),
      { static_cast<double>(i % 3), static_cast<double>(i / 3 % 2), static_cast<double>(i / 6) });
  }
  return ForestWriter::joinedTrees(trees);
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

void refineAnyhow(ForestWriter& forest)
{
  forest.refine([](const ForestQuadrant& q) { return q.level < 1 || (q.level < 4 && hashOf(q) % 5 == 0); });
  fillWithStates(forest);
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

TEST_F(P4estReaderTest, ArraysAreOfThePayloadsTypes)
{
  ForestWriter forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) { return q.level < 1; });
  fillWithHashes(forest, 1 + 1 + 2 + 2 + 2 + 4 + 4 + 8 + 8 + 4 + 4 + 8);
  const std::string path = folder_.file("types.p8est");
  forest.save(path);
  vtkHyperTreeGrid* const grid = this->read(path,
    "int8 a; uint8 b; int16 c; uint16 d; pad[2]; int32 e; uint32 f; int64 g; uint64 h; float i; pad[4]; "
    "double j",
    false);
  const std::vector<std::pair<const char*, int>> expected = { { "a", VTK_TYPE_INT8 }, { "b", VTK_TYPE_UINT8 },
    { "c", VTK_TYPE_INT16 }, { "d", VTK_TYPE_UINT16 }, { "e", VTK_TYPE_INT32 }, { "f", VTK_TYPE_UINT32 },
    { "g", VTK_TYPE_INT64 }, { "h", VTK_TYPE_UINT64 }, { "i", VTK_FLOAT }, { "j", VTK_DOUBLE } };
  ASSERT_EQ(grid->GetCellData()->GetNumberOfArrays(), static_cast<int>(expected.size()));
  for (int i = 0; i < grid->GetCellData()->GetNumberOfArrays(); ++i)
  {
    vtkDataArray* const array = grid->GetCellData()->GetArray(i);
    EXPECT_STREQ(array->GetName(), expected[i].first);
    EXPECT_EQ(array->GetDataType(), expected[i].second);
    EXPECT_EQ(array->GetNumberOfTuples(), 9);
    EXPECT_STRNE(array->GetClassName(), "vtkAOSDataArrayTemplate");
  }
}

TEST_F(P4estReaderTest, ArraysOfFilesBesideTheForest)
{
  ForestWriter forest = ForestWriter::brick({ 2, 1, 1 });
  refineAnyhow(forest);
  const std::string path = folder_.file("step.p8est");
  forest.save(path);
  std::ofstream raw(folder_.file("step_hash.raw"), std::ios::binary);
  for (const ForestQuadrant& q : forest.quadrants())
  {
    const std::array<std::uint64_t, 2> values{ hashOf(q), hashOf(q) / 3 };
    raw.write(reinterpret_cast<const char*>(values.data()), sizeof(values));
  }
  raw.close();
  reader_->SetQuadrantArrays("uint64 hash[2] = {}_hash.raw");
  vtkHyperTreeGrid* const grid = this->read(path, stateText, true);
  expectLeaves(grid, forest);
  vtkDataArray* const hashes = grid->GetCellData()->GetArray("hash");
  ASSERT_NE(hashes, nullptr);
  EXPECT_EQ(hashes->GetDataType(), VTK_TYPE_UINT64);
  std::size_t count = 0;
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    const vtkIdType id = cursor->GetGlobalNodeIndex();
    const auto hash =
      static_cast<std::uint64_t>(grid->GetCellData()->GetArray("id")->GetVariantValue(id).ToLongLong());
    ASSERT_EQ(hashes->GetVariantValue(2 * id).ToUnsignedLongLong(), hash);
    ASSERT_EQ(hashes->GetVariantValue(2 * id + 1).ToUnsignedLongLong(), hash / 3);
    ++count;
  });
  EXPECT_EQ(count, static_cast<std::size_t>(forest.quadrantCount()));
  this->expectError(path, "double hash; pad[32]", "which is in the payload, too");
  reader_->SetQuadrantArrays("nothing.npy");
  this->expectError(path, stateText, "nothing.npy: no such file");
}

TEST_F(P4estReaderTest, WithoutPayload)
{
  ForestWriter forest = smallBrick();
  const std::string path = folder_.file("bare.p8est");
  forest.save(path, false);
  vtkHyperTreeGrid* const grid = this->read(path, nullptr, false);
  EXPECT_EQ(grid->GetCellData()->GetNumberOfArrays(), 2);
  EXPECT_EQ(grid->GetCellData()->GetArray("level")->GetDataType(), VTK_UNSIGNED_CHAR);
  EXPECT_EQ(grid->GetCellData()->GetArray("treeid")->GetDataType(), VTK_INT);
  std::vector<std::array<int, 2>> expected;
  std::vector<std::array<int, 2>> found;
  for (const ForestQuadrant& q : forest.quadrants())
  {
    expected.push_back({ q.tree, q.level });
  }
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    const vtkIdType id = cursor->GetGlobalNodeIndex();
    found.push_back({ static_cast<int>(grid->GetCellData()->GetArray("treeid")->GetTuple1(id)),
      static_cast<int>(cursor->GetLevel()) });
  });
  std::ranges::sort(expected);
  std::ranges::sort(found);
  EXPECT_EQ(expected, found);

  this->expectError(path, "double rho", "payload \"double rho\" takes 8 bytes, allowed the 0 bytes");
}

// 8 bytes are taken for a double when they look like one, anything else is left out; a warning says either.
TEST_F(P4estReaderTest, PayloadsWithoutALayout)
{
  const std::string path = folder_.file("unknown.p8est");
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) { return q.level < 2; });
  const auto valueOf = [](const ForestQuadrant& q) { return std::sin(double(hashOf(q) % 1000)); };
  forest.setPayload(8, [&](const ForestQuadrant& q, std::byte* payload) {
    const double value = valueOf(q);
    std::memcpy(payload, &value, sizeof(value));
  });
  forest.save(path);
  std::string warning = this->warningOf(path);
  EXPECT_NE(warning.find(path + ": the 8 bytes of each quadrant are read as \"double value\""), warning.npos)
    << warning;
  EXPECT_NE(warning.find("set Payload"), warning.npos) << warning;
  EXPECT_EQ(this->arraysRead(), std::vector<std::string>{ "value" });
  std::vector<double> expected;
  std::vector<double> found;
  for (const ForestQuadrant& q : forest.quadrants())
  {
    expected.push_back(valueOf(q));
  }
  vtkHyperTreeGrid* const grid = reader_->GetHyperTreeGridOutput();
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    found.push_back(grid->GetCellData()->GetArray("value")->GetTuple1(cursor->GetGlobalNodeIndex()));
  });
  std::ranges::sort(expected);
  std::ranges::sort(found);
  EXPECT_EQ(expected, found);
  this->read(path, "", true); // it is not said again
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "value", "level", "treeid" }));
  EXPECT_EQ(this->read(path, "unsigned level, treeid", true)->GetCellData()->GetArray("level")->GetDataType(),
    VTK_UNSIGNED_INT); // the payload keeps its names

  forest.setPayload(8, [](const ForestQuadrant& q, std::byte* payload) {
    const auto id = static_cast<std::int64_t>(hashOf(q) % 1000);
    std::memcpy(payload, &id, sizeof(id));
  });
  forest.save(path);
  warning = this->warningOf(path);
  EXPECT_NE(warning.find(path + ": the 8 bytes of each quadrant are left out"), warning.npos) << warning;
  EXPECT_NE(warning.find("\"long value\""), warning.npos) << warning;
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "level", "treeid" }));

  for (const auto& [bytes, example] : { std::pair(24, "double value[3]"), std::pair(12, "float value[3]"),
         std::pair(5, "char value[5]"), std::pair(4, "float value"), std::pair(1, "char value") })
  {
    fillWithHashes(forest, static_cast<std::size_t>(bytes));
    forest.save(path);
    warning = this->warningOf(path);
    for (const std::string& part : { path, "the " + std::to_string(bytes) + " bytes",
           std::string("set Payload"), '"' + std::string(example) + '"' })
    {
      EXPECT_NE(warning.find(part), warning.npos) << warning;
    }
    EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "level", "treeid" }));
  }
}

// A sample stands for a large forest: it may not miss what only a part of it says.
TEST_F(P4estReaderTest, LargeForestWithoutALayout)
{
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) { return q.level < 6; });
  ASSERT_GT(forest.quadrantCount(), 200000);
  forest.setPayload(8, [](const ForestQuadrant& q, std::byte* payload) {
    const std::int64_t id = q.index[2] < 32 ? 0 : std::bit_cast<std::int64_t>(1. + q.index[0]);
    std::memcpy(payload, &id, sizeof(id));
  });
  const std::string path = folder_.file("large.p8est");
  forest.save(path);
  this->warningOf(path);
  EXPECT_EQ(this->arraysRead(), std::vector<std::string>{ "value" });
}

TEST_F(P4estReaderTest, ReadsTheSelectedArrays)
{
  const std::string path = folder_.file("states.p8est");
  ForestWriter forest = ForestWriter::brick({ 2, 1, 1 });
  refineAtRandom(forest, 3, 2);
  fillWithStates(forest);
  forest.save(path);
  using Names = std::vector<std::string>;
  const Names all = { "rho", "velocity", "rank", "flags", "id", "level", "treeid" };

  reader_->SetFileName(path.c_str());
  reader_->SetPayload(stateText);
  reader_->SetGenerateLevel(true);
  reader_->UpdateInformation();
  Names offered;
  for (int i = 0; i < reader_->GetNumberOfCellArrays(); ++i)
  {
    offered.emplace_back(reader_->GetCellArrayName(i));
    EXPECT_EQ(reader_->GetCellArrayStatus(reader_->GetCellArrayName(i)), 1);
  }
  EXPECT_EQ(offered, all);

  reader_->SetCellArrayStatus("rho", 0);
  reader_->SetCellArrayStatus("level", 0);
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), (Names{ "velocity", "rank", "flags", "id", "treeid" }));
  reader_->GetCellDataArraySelection()->DisableAllArrays();
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), Names{});
  EXPECT_EQ(countVertices(reader_->GetHyperTreeGridOutput()) > 0, true);
  reader_->GetCellDataArraySelection()->EnableArray("id");
  reader_->GetCellDataArraySelection()->EnableArray("level");
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), (Names{ "id", "level" }));
  vtkHyperTreeGrid* const grid = reader_->GetHyperTreeGridOutput();
  std::map<std::int64_t, int> levels;
  for (const ForestQuadrant& q : forest.quadrants())
  {
    levels[stateOf(q).id] = q.level;
  }
  vtkIdType leaves = 0;
  visitLeaves(grid, [&](vtkHyperTreeGridNonOrientedGeometryCursor* cursor) {
    const vtkIdType node = cursor->GetGlobalNodeIndex();
    const auto id = grid->GetCellData()->GetArray("id")->GetVariantValue(node).ToLongLong();
    ASSERT_EQ(levels.at(id), grid->GetCellData()->GetArray("level")->GetTuple1(node));
    ++leaves;
  });
  EXPECT_EQ(leaves, forest.quadrantCount());
}

// A state tells which arrays to read before it tells the payload that has them.
TEST_F(P4estReaderTest, SelectionBeforeThePayload)
{
  const std::string path = folder_.file("forest.p8est");
  smallBrick().save(path);
  reader_->SetFileName(path.c_str());
  reader_->UpdateInformation(); // level and treeid are all there is
  for (const auto& [name, status] : { std::pair("level", 0), std::pair("treeid", 0), std::pair("b", 1) })
  {
    reader_->SetCellArrayStatus(name, status);
  }
  reader_->SetPayload("float a; float b; float c");
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), std::vector<std::string>{ "b" });

  // Without a choice all that comes is read.
  reader_->GetCellDataArraySelection()->EnableAllArrays();
  reader_->SetPayload("float a; float b; int d");
  reader_->SetGenerateLevel(true);
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "a", "b", "d", "level", "treeid" }));
}

// As a Python state does for an empty list: it turns off what there is without a payload, then come the arrays.
TEST_F(P4estReaderTest, AllArraysOffStayOffWithAnotherPayload)
{
  const std::string path = folder_.file("forest.p8est");
  smallBrick().save(path);
  reader_->SetFileName(path.c_str());
  reader_->UpdateInformation();
  reader_->GetCellDataArraySelection()->DisableAllArrays();
  reader_->SetPayload("float a; float b; float c");
  reader_->SetGenerateLevel(true);
  for (int i = 0; i < 2; ++i)
  {
    reader_->Modified();
    reader_->Update();
    EXPECT_EQ(this->arraysRead(), std::vector<std::string>{});
    EXPECT_EQ(reader_->GetNumberOfCellArrays(), 5);
  }
  reader_->GetCellDataArraySelection()->EnableArray("b");
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), std::vector<std::string>{ "b" });

  // What is turned off before the reader has told of anything leaves the others on.
  const auto fresh = vtkSmartPointer<vtkTreeAMRP4estReader>::New();
  fresh->SetFileName(path.c_str());
  fresh->SetPayload("float a; float b; float c");
  fresh->SetCellArrayStatus("a", 0);
  fresh->Update();
  EXPECT_EQ(fresh->GetHyperTreeGridOutput()->GetCellData()->GetNumberOfArrays(), 2);
}

TEST_F(P4estReaderTest, UnknownSelectedArraysAreAWarning)
{
  const std::string path = folder_.file("forest.p8est");
  smallBrick().save(path);
  const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
  reader_->SetFileName(path.c_str());
  reader_->SetPayload("float a; float b; float c");
  for (const auto& [name, status] : { std::pair("a", 0), std::pair("b", 0), std::pair("rho", 1) })
  {
    reader_->SetCellArrayStatus(name, status);
  }
  reader_->UpdateInformation();
  reader_->Update();
  ASSERT_EQ(warnings.messages().size(), 1u);
  EXPECT_NE(
    warnings.messages()[0].find(path + R"(: "rho" to be read, allowed are "a", "b", "c")"), std::string::npos)
    << warnings.messages()[0];
  reader_->SetCellArrayStatus("b", 1);
  reader_->Update();
  EXPECT_EQ(warnings.messages().size(), 1u);
}

TEST_F(P4estReaderTest, FirstArrayIsTheActiveScalars)
{
  const std::string path = folder_.file("forest.p8est");
  ForestWriter forest = ForestWriter::brick({ 3, 2, 2 });
  forest.save(path);
  const auto activeName = [](vtkHyperTreeGrid* grid) {
    vtkDataArray* const scalars = grid->GetCellData()->GetScalars();
    return std::string(scalars ? scalars->GetName() : "(none)");
  };
  EXPECT_EQ(activeName(this->read(path, "", false)), "level");
  fillWithHashes(forest, 12);
  forest.save(path);
  EXPECT_EQ(activeName(this->read(path, "float u[2]; int n", true)), "u");
  reader_->SetCellArrayStatus("u", 0);
  EXPECT_EQ(activeName(this->read(path, "float u[2]; int n", true)), "n");
  reader_->GetCellDataArraySelection()->DisableAllArrays();
  EXPECT_EQ(activeName(this->read(path, "float u[2]; int n", true)), "(none)");
}

TEST_F(P4estReaderTest, WrongPayloads)
{
  const std::string path = folder_.file("forest.p8est");
  smallBrick().save(path);
  this->expectError(
    path, "double rho", path + ": payload \"double rho\" takes 8 bytes, allowed the 12 bytes");
  this->expectError(path, "double rho; int i", "takes 16 bytes, allowed the 12 bytes");
  this->expectError(path, "dooble rho", "position 1: \"dooble\"");
  EXPECT_GT(countVertices(this->read(path, "float rho[3]", false)), 0); // and recovers
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

TEST_F(P4estReaderTest, FirstPieceHasAll)
{
  const std::string path = folder_.file("forest.p8est");
  ForestWriter forest = smallBrick();
  forest.save(path);
  reader_->SetFileName(path.c_str());
  reader_->SetPayload("float value[3]");
  EXPECT_TRUE(reader_->UpdatePiece(1, 2, 0));
  this->expectEmpty();
  EXPECT_TRUE(reader_->UpdatePiece(0, 2, 0));
  vtkIdType leaves = 0;
  visitLeaves(reader_->GetHyperTreeGridOutput(), [&](auto*) { ++leaves; });
  EXPECT_EQ(leaves, forest.quadrantCount());
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

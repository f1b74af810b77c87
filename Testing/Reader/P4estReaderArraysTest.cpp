// The arrays that the forests' reader makes: of payloads with and without a layout, and of files beside the forest; which of
// them are read.
#include "ForestReaderFixture.h"

#include "vtkDataArraySelection.h"

#include <bit>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using P4estReaderArraysTest = ForestReaderFixture;

TEST_F(P4estReaderArraysTest, ArraysAreOfThePayloadsTypes)
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

TEST_F(P4estReaderArraysTest, ArraysOfFilesBesideTheForest)
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

// As they are; that GenerateLevel adds nothing is said, once.
TEST_F(P4estReaderArraysTest, ArraysWithTheNamesOfLevelAndTree)
{
  ForestWriter forest = smallBrick();
  fillWithHashes(forest, 8);
  const std::string path = folder_.file("own.p8est");
  forest.save(path);
  const auto expectSaid = [&](const char* payload, const char* names) {
    const MessageCatcher warnings(reader_, vtkCommand::WarningEvent);
    reader_->SetFileName(path.c_str());
    reader_->SetGenerateLevel(true);
    reader_->SetPayload(payload);
    for (int i = 0; i < 2; ++i)
    {
      reader_->Modified();
      reader_->Update();
    }
    ASSERT_EQ(warnings.messages().size(), 1u) << names;
    EXPECT_NE(warnings.messages()[0].find(path + ": GenerateLevel without effect on " + names + ":"),
      std::string::npos)
      << warnings.messages()[0];
    vtkDataArray* const level = reader_->GetHyperTreeGridOutput()->GetCellData()->GetArray("level");
    EXPECT_EQ(level->GetDataType(), VTK_UNSIGNED_INT);
  };
  expectSaid("unsigned level, other", "\"level\"");
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "level", "other", "treeid" }));
  expectSaid("unsigned level, treeid", "\"level\", \"treeid\"");
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "level", "treeid" }));
  this->read(path, "unsigned level, treeid", false);
}

TEST_F(P4estReaderArraysTest, WithoutPayload)
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
TEST_F(P4estReaderArraysTest, PayloadsWithoutALayout)
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
TEST_F(P4estReaderArraysTest, LargeForestWithoutALayout)
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

TEST_F(P4estReaderArraysTest, ReadsTheSelectedArrays)
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
TEST_F(P4estReaderArraysTest, SelectionBeforeThePayload)
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
TEST_F(P4estReaderArraysTest, ChosenArraysComeBackWithTheirPayload)
{
  const std::string path = folder_.file("forest.p8est");
  smallBrick().save(path);
  reader_->SetFileName(path.c_str());
  reader_->SetGenerateLevel(true);
  reader_->SetPayload("float a[2]; int b");
  reader_->UpdateInformation();
  reader_->SetCellArrayStatus("b", 0);
  reader_->SetCellArrayStatus("treeid", 0);
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "a", "level" }));
  reader_->SetPayload("float c; float d; float e");
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), std::vector<std::string>{ "level" });
  reader_->SetPayload("float a[2]; int b");
  reader_->Update();
  EXPECT_EQ(this->arraysRead(), (std::vector<std::string>{ "a", "level" }));
}

TEST_F(P4estReaderArraysTest, AllArraysOffStayOffWithAnotherPayload)
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

TEST_F(P4estReaderArraysTest, UnknownSelectedArraysAreAWarning)
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

TEST_F(P4estReaderArraysTest, FirstArrayIsTheActiveScalars)
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

TEST_F(P4estReaderArraysTest, WrongPayloads)
{
  const std::string path = folder_.file("forest.p8est");
  smallBrick().save(path);
  this->expectError(
    path, "double rho", path + ": payload \"double rho\" takes 8 bytes, allowed the 12 bytes");
  this->expectError(path, "double rho; int i", "takes 16 bytes, allowed the 12 bytes");
  this->expectError(path, "dooble rho", "position 1: \"dooble\"");
  EXPECT_GT(countVertices(this->read(path, "float rho[3]", false)), 0); // and recovers
}

} // namespace

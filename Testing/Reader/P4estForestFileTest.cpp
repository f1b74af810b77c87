// Forests written by libp4est, read back leaf by leaf; and the errors of files that are none.
#include "Forest/P4estForestFile.h"
#include "Error.h"
#include "Forest/P4estTreeLattice.h"
#include "Support/ExampleForests.h"
#include "Support/ForestBytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

std::vector<ForestQuadrant> readAll(const P4estForestFile& file)
{
  std::vector<ForestQuadrant> all;
  file.visitQuadrants([&](const TreeLeaf& q) {
    all.push_back(
      { q.tree, q.index, q.level, std::vector<std::byte>(q.payload, q.payload + file.payloadSize()) });
  });
  return all;
}

void expectSame(const std::vector<ForestQuadrant>& expected, const std::vector<ForestQuadrant>& found)
{
  ASSERT_EQ(expected.size(), found.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
  {
    ASSERT_EQ(expected[i].tree, found[i].tree) << "quadrant " << i;
    ASSERT_EQ(expected[i].level, found[i].level) << "quadrant " << i;
    ASSERT_EQ(expected[i].index, found[i].index) << "quadrant " << i;
    ASSERT_EQ(expected[i].payload, found[i].payload) << "quadrant " << i;
  }
}

std::string errorOf(const std::string& path)
{
  try
  {
    const P4estForestFile file(path);
    file.visitQuadrants([](const TreeLeaf&) {});
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "no error";
}

void expectError(const std::string& path, const std::string& part)
{
  const std::string found = errorOf(path);
  EXPECT_NE(found.find(path + ": "), std::string::npos) << found;
  EXPECT_NE(found.find(part), std::string::npos) << found << "\nshould say " << part;
}

class P4estForestFileTest : public ::testing::Test
{
protected:
  void expectReadsAs(const ForestWriter& forest, bool withPayload = true)
  {
    const std::string path = folder_.file("forest.p8est");
    forest.save(path, withPayload);
    const P4estForestFile file(path);
    std::vector<ForestQuadrant> expected = forest.quadrants();
    if (!withPayload)
    {
      std::ranges::for_each(expected, [](ForestQuadrant& q) { q.payload.clear(); });
    }
    EXPECT_EQ(file.quadrantCount(), expected.size());
    EXPECT_EQ(file.payloadSize(), expected[0].payload.size());
    expectSame(expected, readAll(file));
    for (std::int32_t tree = 0; tree < file.treeCount(); ++tree)
    {
      const auto ofTree = [&](const ForestQuadrant& q) { return q.tree == tree; };
      EXPECT_EQ(
        file.quadrantCount(tree), static_cast<std::uint64_t>(std::ranges::count_if(expected, ofTree)));
    }
  }

  TemporaryFolder folder_;
};

TEST_F(P4estForestFileTest, OneCell)
{
  expectReadsAs(ForestWriter::unitCube());
}

TEST_F(P4estForestFileTest, UnitCubeUnbalancedAndBalanced)
{
  for (const int balance : { -1, 0, 1, 2 })
  {
    auto forest = ForestWriter::unitCube();
    refineAtRandom(forest, 7, 3);
    forest.refine([](const ForestQuadrant& q) { return q.level < 1; });
    refineAtRandom(forest, 7, 3);
    const std::int64_t unbalanced = forest.quadrantCount();
    if (balance >= 0)
    {
      forest.balance(static_cast<Balance>(balance));
      EXPECT_GT(forest.quadrantCount(), unbalanced); // else this tests nothing
    }
    fillWithHashes(forest, 8);
    expectReadsAs(forest);
    expectReadsAs(forest, false);
  }
}

TEST_F(P4estForestFileTest, Bricks)
{
  for (const bool periodic : { false, true })
  {
    for (const std::array<int, 3> trees :
      { std::array{ 1, 1, 1 }, std::array{ 2, 1, 1 }, std::array{ 3, 2, 5 }, std::array{ 7, 1, 3 } })
    {
      auto forest = ForestWriter::brick(trees, { periodic, false, periodic });
      refineAtRandom(forest, 4, 3);
      fillWithHashes(forest, 5);
      expectReadsAs(forest);
    }
  }
}

TEST_F(P4estForestFileTest, OtherConnectivities)
{
  for (const char* name : { "periodic", "rotcubes", "rotwrap", "shell", "sphere", "twocubes" })
  {
    auto forest = ForestWriter::named(name);
    refineAtRandom(forest, 3, 3);
    expectReadsAs(forest);
  }
  expectReadsAs(ForestWriter::withoutVertices());
}

TEST_F(P4estForestFileTest, PayloadsOfAnySize)
{
  // The last ones do not fit a block of the reader once.
  for (const std::size_t bytes : { 1u, 3u, 8u, 32u, 1000u, (1u << 20) - 16u, 1u << 20, 3u << 20 })
  {
    auto forest = ForestWriter::unitCube();
    forest.refine([](const ForestQuadrant& q) { return q.level < 1; });
    fillWithHashes(forest, bytes);
    expectReadsAs(forest);
  }
}

TEST_F(P4estForestFileTest, MoreThanABlock)
{
  auto forest = ForestWriter::unitCube();
  forest.refine([](const ForestQuadrant& q) { return q.level < 6; });
  fillWithHashes(forest, 7);
  expectReadsAs(forest);
}

TEST_F(P4estForestFileTest, DeepestLevelTowardsACorner)
{
  for (const bool far : { false, true })
  {
    auto forest = ForestWriter::brick({ 2, 1, 1 });
    forest.refine([=](const ForestQuadrant& q) {
      const std::uint32_t corner = far ? (1u << q.level) - 1 : 0;
      return q.level < ForestWriter::maxLevel && q.index == std::array{ corner, corner, corner };
    });
    fillWithHashes(forest, 8);
    EXPECT_EQ(forest.quadrantCount(), 2 * (1 + 7 * ForestWriter::maxLevel));
    expectReadsAs(forest);
  }
}

// p4est since 2.3 counts 2^30 coordinates per tree instead of 2^19 and saves the same otherwise.
TEST_F(P4estForestFileTest, CoordinatesOfNewerVersions)
{
  ForestWriter forest = smallBrick();
  const std::string path = folder_.file("new.p8est");
  forest.save(path);
  Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  for (std::size_t record = s.quadrants; record < s.end; record += s.recordBytes)
  {
    for (int a = 0; a < 3; ++a)
    {
      const std::size_t at = record + 4 * static_cast<std::size_t>(a);
      putAt(bytes, at, getAt<std::int32_t>(bytes, at) << (29 - ForestWriter::maxLevel));
    }
  }
  writeBytes(path, bytes);
  expectSame(forest.quadrants(), readAll(P4estForestFile(path)));
}

TEST_F(P4estForestFileTest, DeepestLevelOfNewerVersions)
{
  const std::string path = folder_.file("deep.p8est");
  ForestWriter::unitCube().save(path);
  std::vector<RawQuadrant> raw = { { 0, 0, 0, 29 } };
  std::vector<ForestQuadrant> expected = { { 0, { 0, 0, 0 }, 29, {} } };
  for (int level = 29; level > 0; --level)
  {
    for (std::uint32_t child = 1; child < 8; ++child)
    {
      const std::array<std::uint32_t, 3> index = { child & 1, child >> 1 & 1, child >> 2 };
      raw.push_back({ static_cast<std::int32_t>(index[0] << (30 - level)),
        static_cast<std::int32_t>(index[1] << (30 - level)),
        static_cast<std::int32_t>(index[2] << (30 - level)), level });
      expected.push_back({ 0, index, level, {} });
    }
  }
  writeBytes(path, withQuadrants(readBytes(path), { raw.size() }, { raw.size() }, raw));
  expectSame(expected, readAll(P4estForestFile(path)));
}

TEST_F(P4estForestFileTest, SeveralRanksAttributesAndTrailingBytes)
{
  auto forest = ForestWriter::brick({ 2, 1, 1 });
  forest.setTreeAttributes(13);
  forest.refine([](const ForestQuadrant& q) { return q.tree == 1 && q.level < 1; });
  const std::string path = folder_.file("forest.p8est");
  forest.save(path);
  const Bytes saved = readBytes(path);
  std::vector<RawQuadrant> raw;
  for (const ForestQuadrant& q : forest.quadrants())
  {
    const int shift = ForestWriter::maxLevel + 1 - q.level;
    raw.push_back(
      { static_cast<std::int32_t>(q.index[0] << shift), static_cast<std::int32_t>(q.index[1] << shift),
        static_cast<std::int32_t>(q.index[2] << shift), q.level });
  }
  ASSERT_EQ(saved, withQuadrants(saved, { 9 }, { 1, 9 }, raw));
  Bytes parallel = withQuadrants(saved, { 0, 4, 4, 9, 9 }, { 1, 9 }, raw);
  append(parallel, 1.);
  writeBytes(path, parallel);
  expectSame(forest.quadrants(), readAll(P4estForestFile(path)));

  writeBytes(path, withQuadrants(saved, { 4, 3, 9 }, { 1, 9 }, raw));
  expectError(path, "partition, rank 1: ends at quadrant 3, allowed at least 4");
  writeBytes(path, withQuadrants(saved, { 8 }, { 1, 9 }, raw));
  expectError(path, "tree 1: ends at quadrant 9, allowed 8..8");
}

TEST_F(P4estForestFileTest, VerticesOfTheConnectivity)
{
  const std::string path = folder_.file("brick.p8est");
  auto forest = ForestWriter::brick({ 2, 2, 1 });
  forest.save(path);
  const P4estForestFile file(path);
  ASSERT_EQ(file.connectivity().vertices.size(), 18u);
  ASSERT_EQ(file.connectivity().treeVertices.size(), 4u);
  const TreeLattice lattice = p4estTreeLattice(file);
  for (int tree = 0; tree < 4; ++tree)
  {
    for (int corner = 0; corner < 8; ++corner)
    {
      const std::array<double, 3> vertex =
        file.connectivity().vertices[file.connectivity().treeVertices[tree][corner]];
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_EQ(vertex[a], lattice.planes()[a][lattice.place(tree)[a] + (corner >> a & 1)]);
      }
    }
  }
}

TEST_F(P4estForestFileTest, ErrorsNameTheQuadrant)
{
  const std::string path = folder_.file("named.p8est");
  auto forest = ForestWriter::brick({ 2, 2, 1 });
  forest.refine([](const ForestQuadrant& q) { return q.level < 2; });
  forest.save(path);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  const auto record = [&](std::size_t tree, std::size_t quadrant) {
    return s.quadrants + (64 * tree + quadrant) * s.recordBytes;
  };
  const auto expectWith = [&](std::size_t at, std::int32_t value, const std::string& message) {
    Bytes spoilt = bytes;
    putAt(spoilt, at, value);
    writeBytes(path, spoilt);
    expectError(path, message);
  };
  const std::string deepest = std::to_string(ForestWriter::maxLevel);
  const auto coordinate = [](int index) { // of level 2
    return std::to_string(index << (ForestWriter::maxLevel - 1));
  };
  expectWith(record(3, 17) + 12, 77, "tree 3, quadrant 17: level 77, allowed 0.." + deepest);
  expectWith(record(3, 17) + 12, -1, "tree 3, quadrant 17: level -1, allowed 0.." + deepest);
  expectWith(record(3, 17) + 12, 1,
    "tree 3, quadrant 17: level 1 at (" + coordinate(1) + ", " + coordinate(2) + ", 0), allowed 2.." +
      deepest);
  expectWith(record(2, 63), 0,
    "tree 2, quadrant 63: at (0, " + coordinate(3) + ", " + coordinate(3) + ") of level 2, allowed (" +
      coordinate(3) + ", " + coordinate(3) + ", " + coordinate(3) + ")");
  expectWith(record(2, 63) + 12, 3, "tree 2: its 64 quadrants end before the tree is full");
  expectWith(record(1, 56) + 12, 1, "tree 1, quadrant 57: at");
  expectWith(record(1, 56) + 12, 1, "the tree is full");
  expectWith(record(0, 1), 5, "tree 0: quadrant 0 at (0, 0, 0) of level 2, quadrant 1 at (5, 0, 0)");
}

TEST_F(P4estForestFileTest, ErrorsNameTheSection)
{
  const std::string path = folder_.file("section.p8est");
  smallBrick().save(path);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  const auto expectWith = [&](std::size_t at, auto value, const std::string& message) {
    Bytes spoilt = bytes;
    putAt(spoilt, at, value);
    writeBytes(path, spoilt);
    expectError(path, message);
  };
  const std::size_t vertices = getAt<std::uint64_t>(bytes, s.connectivityCounts + 16);
  const std::size_t treeToEdge = s.connectivityBody + 24 * vertices;
  const std::size_t treeToVertex = treeToEdge + 48 * 12;
  const std::size_t treeToTree = treeToVertex + 2 * 32 * 12;
  expectWith(s.connectivityCounts, std::uint64_t(0x3000008), "format 0x3000008, allowed 0x3000009");
  expectWith(s.connectivityCounts, std::uint64_t(0x0900000300000000), "the other byte order");
  expectWith(s.connectivityCounts + 8, std::uint64_t(8), "size of an index 8, allowed 4");
  expectWith(s.connectivityCounts + 24, std::uint64_t(0), "0 trees, allowed 1..2147483647");
  expectWith(treeToEdge + 8, std::int32_t(-2), "tree_to_edge, entry 2: -2, allowed -1..");
  expectWith(treeToVertex + 4 * 8 * 5, std::int32_t(36), "tree 5, corner 0: vertex 36, allowed 0..35");
  expectWith(treeToTree + 4 * 3, std::int32_t(12), "tree_to_tree, entry 3: 12, allowed 0..11");
  expectWith(treeToTree + 24 * 12, std::int8_t(24), "tree_to_face, entry 0: 24, allowed 0..23");
  expectWith(treeToTree + 30 * 12, std::int32_t(1), "ett_offset, entry 0: 1, allowed 0..0");
  expectWith(s.connectivityEnd - 1, std::int8_t(8), "corner_to_corner, entry 15: 8, allowed 0..7");
  expectWith(s.forestHeader + 8, std::uint64_t(8), "size of a coordinate 8, allowed 4");
  expectWith(s.forestHeader + 16, std::uint64_t(32), "size of a quadrant 32, allowed 24 or 20");
  expectWith(s.forestHeader + 32, std::uint64_t(0), "payload flag 0 with 12 bytes per quadrant");
  expectWith(s.forestHeader + 24, std::uint64_t(13), "quadrants: ");
  expectWith(s.treeEnds, std::uint64_t(0), "tree 0: ends at quadrant 0, allowed 1..");
  expectWith(s.treeEnds, std::uint64_t(3), "tree 0: 3 quadrants, allowed 1 and a multiple of 7");
}

TEST_F(P4estForestFileTest, OtherFiles)
{
  expectError(folder_.file("nothing.p8est"), "no such file");
  expectError(folder_.file(""), "a directory");
  EXPECT_FALSE(P4estForestFile::hasMagic(folder_.file("nothing.p8est")));
  EXPECT_FALSE(P4estForestFile::hasMagic(folder_.file("")));

  const std::string path = folder_.file("other");
  writeBytes(path, {});
  expectError(path, "begins with \"\", allowed \"p8est");
  EXPECT_FALSE(P4estForestFile::hasMagic(path));

  std::ofstream(path) << "# vtk DataFile Version 3.0\n";
  expectError(path, "begins with \"# vtk Da\", allowed \"p8est");
  EXPECT_FALSE(P4estForestFile::hasMagic(path));

  ForestWriter::named("twocubes").saveConnectivity(path);
  expectError(path, "a connectivity only");
  EXPECT_TRUE(P4estForestFile::hasMagic(path));

  ForestWriter::unitCube().save(path);
  EXPECT_TRUE(P4estForestFile::hasMagic(path));
}

} // namespace

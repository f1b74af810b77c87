// Lattices of trees from connectivities of libp4est, and the trees that fit none.
#include "Forest/P4estTreeLattice.h"
#include "Error.h"
#include "Support/ForestBytes.h"
#include "Support/ForestWriter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Point = ForestWriter::Point;
using Planes = std::array<std::vector<double>, 3>;

ForestWriter::Corners boxCorners(const Point& min, const Point& max)
{
  ForestWriter::Corners corners;
  for (int c = 0; c < 8; ++c)
  {
    corners[c] = { c & 1 ? max[0] : min[0], c & 2 ? max[1] : min[1], c & 4 ? max[2] : min[2] };
  }
  return corners;
}

class P4estTreeLatticeTest : public ::testing::Test
{
protected:
  TreeLattice latticeOf(const ForestWriter& forest)
  {
    forest.save(folder_.file("forest.p8est"));
    return p4estTreeLattice(P4estForestFile(folder_.file("forest.p8est")));
  }

  void expectError(const ForestWriter& forest, const std::string& part)
  {
    try
    {
      latticeOf(forest);
      ADD_FAILURE() << "no error, should say " << part;
    }
    catch (const Error& error)
    {
      const std::string found = error.what();
      EXPECT_EQ(found.find(folder_.file("forest.p8est") + ": "), 0u) << found;
      EXPECT_NE(found.find(part), std::string::npos) << found << "\nshould say " << part;
    }
  }

  TemporaryFolder folder_;
};

TEST_F(P4estTreeLatticeTest, UnitCube)
{
  const TreeLattice lattice = latticeOf(ForestWriter::unitCube());
  EXPECT_EQ(lattice.planes(), (Planes{ { { 0., 1. }, { 0., 1. }, { 0., 1. } } }));
  EXPECT_EQ(lattice.place(0), (std::array{ 0, 0, 0 }));
}

TEST_F(P4estTreeLatticeTest, BricksPeriodicOrNot)
{
  for (const bool periodic : { false, true })
  {
    const TreeLattice lattice = latticeOf(ForestWriter::brick({ 3, 2, 5 }, { periodic, periodic, periodic }));
    EXPECT_EQ(
      lattice.planes(), (Planes{ { { 0., 1., 2., 3. }, { 0., 1., 2. }, { 0., 1., 2., 3., 4., 5. } } }));
    std::set<std::array<int, 3>> places;
    for (int tree = 0; tree < 30; ++tree)
    {
      places.insert(lattice.place(tree));
    }
    EXPECT_EQ(places.size(), 30u);
    EXPECT_EQ(*places.begin(), (std::array{ 0, 0, 0 }));
    EXPECT_EQ(*places.rbegin(), (std::array{ 2, 1, 4 }));
  }
}

TEST_F(P4estTreeLatticeTest, ScaledShiftedAndStretched)
{
  auto forest = ForestWriter::brick({ 4, 1, 2 });
  forest.moveVertices([](const Point& p) {
    return Point{ p[0] * p[0], 0.1 * p[1] - 7., 1e6 + 1e-3 * p[2] };
  });
  const TreeLattice lattice = latticeOf(forest);
  EXPECT_EQ(lattice.planes()[0], (std::vector{ 0., 1., 4., 9., 16. }));
  EXPECT_EQ(lattice.planes()[1], (std::vector{ -7., 0.1 - 7. }));
  EXPECT_EQ(lattice.planes()[2], (std::vector{ 1e6, 1e6 + 1e-3, 1e6 + 2e-3 }));
}

TEST_F(P4estTreeLatticeTest, TreesLeftOut)
{
  const TreeLattice lattice = latticeOf(
    ForestWriter::separateTrees({ boxCorners({ 2, 0, 0 }, { 3, 1, 1 }), boxCorners({ 0, 0, 0 }, { 1, 1, 1 }),
      boxCorners({ 2, 1, 0 }, { 3, 2, 1 }), boxCorners({ 7, 1, 0 }, { 8, 2, 1 }) }));
  EXPECT_EQ(lattice.planes()[0], (std::vector{ 0., 1., 2., 3., 7., 8. }));
  EXPECT_EQ(lattice.place(0), (std::array{ 2, 0, 0 }));
  EXPECT_EQ(lattice.place(1), (std::array{ 0, 0, 0 }));
  EXPECT_EQ(lattice.place(2), (std::array{ 2, 1, 0 }));
  EXPECT_EQ(lattice.place(3), (std::array{ 4, 1, 0 }));
}

// Vertices computed tree by tree differ in their last bits; those of one plane must become one.
TEST_F(P4estTreeLatticeTest, RoundedVertices)
{
  std::vector<ForestWriter::Corners> trees;
  for (int i = 0; i < 10; ++i)
  {
    const double min = 1e3 + 0.1 * i;
    trees.push_back(boxCorners({ min, 0., 0. }, { min + 0.1, 0.1, 0.1 }));
  }
  bool someDiffer = false;
  for (int i = 0; i < 9; ++i)
  {
    someDiffer |= trees[i][7][0] != trees[i + 1][0][0];
  }
  ASSERT_TRUE(someDiffer); // else this tests nothing
  const TreeLattice lattice = latticeOf(ForestWriter::separateTrees(trees));
  EXPECT_EQ(lattice.planes()[0].size(), 11u);
  for (int i = 0; i < 10; ++i)
  {
    EXPECT_EQ(lattice.place(i), (std::array{ i, 0, 0 }));
  }
}

// A difference of the finest quadrant's width is rounding, a larger one is a gap between the trees.
TEST_F(P4estTreeLatticeTest, ToleranceAtItsBoundary)
{
  const double finest = std::ldexp(1., -P4estForestFile::maxLevel);
  const auto twoTrees = [](double gap) {
    return ForestWriter::separateTrees(
      { boxCorners({ -1., 0., 0. }, { 0., 1., 1. }), boxCorners({ gap, 0., 0. }, { 1. + gap, 1., 1. }) });
  };
  EXPECT_EQ(latticeOf(twoTrees(0.75 * finest)).planes()[0].size(), 3u);
  EXPECT_EQ(latticeOf(twoTrees(1.25 * finest)).planes()[0].size(), 4u);

  auto corners = boxCorners({ 0., 0., 0. }, { 1., 1., 1. });
  corners[5][1] = 0.75 * finest;
  EXPECT_NO_THROW(latticeOf(ForestWriter::separateTrees({ corners })));
  corners[5][1] = 1.25 * finest;
  expectError(ForestWriter::separateTrees({ corners }), "tree 0: corner 5 at (1, ");
}

// How the trees are glued at the sides of the domain says nothing of where they are.
TEST_F(P4estTreeLatticeTest, OtherConnectivities)
{
  for (const char* name : { "periodic", "rotwrap" })
  {
    EXPECT_EQ(
      latticeOf(ForestWriter::named(name)).planes(), (Planes{ { { 0., 1. }, { 0., 1. }, { 0., 1. } } }));
  }
  EXPECT_EQ(latticeOf(ForestWriter::named("twocubes")).planes()[0], (std::vector{ 0., 1., 2. }));
}

TEST_F(P4estTreeLatticeTest, TurnedAndReflectedTrees)
{
  EXPECT_EQ(latticeOf(ForestWriter::named("twowrap")).treeCount(), 2);
  auto forest = ForestWriter::brick({ 2, 1, 1 });
  forest.moveVertices([](const Point& p) { return Point{ -p[0], p[2], p[1] }; });
  const TreeLattice lattice = latticeOf(forest);
  EXPECT_EQ(lattice.planes(), (Planes{ { { -2., -1., -0. }, { 0., 1. }, { 0., 1. } } }));
  EXPECT_EQ(lattice.place(0), (std::array{ 1, 0, 0 }));
  EXPECT_EQ(lattice.orientation(1), (TreeOrientation{ 1, 0, 5, 4, 3, 2, 7, 6 }));
}

TEST_F(P4estTreeLatticeTest, CurvedTrees)
{
  for (const char* name : { "rotcubes", "shell", "sphere" })
  {
    try
    {
      latticeOf(ForestWriter::named(name));
      ADD_FAILURE() << name << " is no lattice";
    }
    catch (const Error& error)
    {
      EXPECT_NE(std::string(error.what()).find(": tree "), std::string::npos) << error.what();
    }
  }
  auto corners = boxCorners({ 0., 0., 0. }, { 1., 1., 1. });
  const auto expectOrderError = [&] {
    expectError(
      ForestWriter::separateTrees({ corners }), "tree 0: its corners are those of a box in another order");
  };
  std::swap(corners[3], corners[5]);
  expectOrderError();
  for (int c = 0; c < 8; ++c) // four corners, each twice
  {
    const int at = (c & 1 ? 3 : 0) ^ (c & 2 ? 4 : 0);
    corners[c] = { static_cast<double>(at & 1), static_cast<double>(at >> 1 & 1),
      static_cast<double>(at >> 2) };
  }
  expectOrderError();
}

TEST_F(P4estTreeLatticeTest, WithoutVertices)
{
  const TreeLattice one = latticeOf(ForestWriter::withoutVertices());
  EXPECT_EQ(one.planes(), (Planes{ { { 0., 1. }, { 0., 1. }, { 0., 1. } } }));
  for (const bool periodic : { false, true })
  {
    auto forest = ForestWriter::brick({ 3, 2, 5 }, { periodic, periodic, periodic });
    const TreeLattice expected = latticeOf(forest);
    forest.dropVertices();
    const TreeLattice lattice = latticeOf(forest);
    EXPECT_EQ(lattice.planes(), expected.planes());
    for (int tree = 0; tree < 30; ++tree)
    {
      EXPECT_EQ(lattice.place(tree), expected.place(tree));
      EXPECT_EQ(lattice.orientation(tree), alongAxes);
    }
  }
  for (const char* name : { "rotcubes", "rotwrap", "shell", "sphere" })
  {
    auto forest = ForestWriter::named(name);
    forest.dropVertices();
    expectError(forest, "turned against where other faces put it");
  }
  auto wrapped = ForestWriter::named("twowrap"); // twice joined, the second time around the whole
  wrapped.dropVertices();
  EXPECT_EQ(latticeOf(wrapped).treeCount(), 2);
  auto unconnected = ForestWriter::separateTrees(
    { boxCorners({ 0., 0., 0. }, { 1., 1., 1. }), boxCorners({ 1., 0., 0. }, { 2., 1., 1. }) });
  unconnected.dropVertices();
  expectError(unconnected, "tree 1: no vertices, and no face joins it with tree 0");
}

TEST_F(P4estTreeLatticeTest, BoxesWithoutVertices)
{
  const std::string path = folder_.file("forest.p8est");
  ForestWriter::withoutVertices().save(path);
  const P4estForestFile file(path);
  const TreeLattice lattice = p4estTreeLattice(file, { { 1., -2., 0. }, { 0.5, 3., 1e-3 } });
  EXPECT_EQ(lattice.planes(), (Planes{ { { 1., 1.5 }, { -2., 1. }, { 0., 1e-3 } } }));
  for (const double bad : { 0., -1., std::numeric_limits<double>::quiet_NaN(), 1e-20 })
  {
    EXPECT_THROW((p4estTreeLattice(file, { { 1., 1., 1. }, { 1., 1., bad } })), Error);
  }
}

TEST_F(P4estTreeLatticeTest, TreesThatFitNoLattice)
{
  const auto unit = boxCorners({ 0., 0., 0. }, { 1., 1., 1. });
  expectError(ForestWriter::separateTrees({ unit, boxCorners({ 1., 0., 0. }, { 2., 1., 1. }), unit }),
    "tree 2: at the place of tree 0, allowed one of its own");
  expectError(ForestWriter::separateTrees({ unit, boxCorners({ 1., 0., 0. }, { 3., 2., 1. }) }),
    "tree 1: from 0 to 2 along y spans 2 cells of the lattice that all trees form, allowed 1");
  expectError(ForestWriter::separateTrees({ unit, boxCorners({ .5, 0., 0. }, { 1.5, 1., 1. }) }),
    "tree 0: from 0 to 1 along x spans 2 cells");
  expectError(ForestWriter::separateTrees({ unit, boxCorners({ 1., 0., 0. }, { 2., 1., 0. }) }),
    "tree 1: from 0 to 0 along z");

  for (const double bad :
    { std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300 })
  {
    for (int corner = 0; corner < 8; ++corner)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        auto corners = unit;
        corners[corner][axis] = bad;
        expectError(
          ForestWriter::separateTrees({ boxCorners({ 1., 0., 0. }, { 2., 1., 1. }), corners }), ": tree ");
      }
    }
  }
}

// Trees along the diagonal make a lattice of their number cubed; vtkHyperTreeGrid counts its places in 32
// bits.
TEST_F(P4estTreeLatticeTest, LatticeTooLargeForAGrid)
{
  std::vector<ForestWriter::Corners> trees;
  for (int i = 0; i < 1626; ++i)
  {
    const double d = i;
    trees.push_back(boxCorners({ d, d, d }, { d + 1., d + 1., d + 1. }));
  }
  expectError(
    ForestWriter::separateTrees(trees), "a lattice of 1626 x 1626 x 1626 trees, allowed 4294967295 places");
  trees.pop_back();
  EXPECT_EQ(latticeOf(ForestWriter::separateTrees(trees)).place(1624), (std::array{ 1624, 1624, 1624 }));
}

} // namespace

// How far corners may be off, at the boundary, and what says how far neighbours are apart.
#include "Forest/BoxLattice.h"

#include "Error.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace treeamr;

namespace
{

/// Of a level in the unit cube that begins at x, x, x.
AxisBox cellAt(int level, Coord index, double x = 0.)
{
  const double width = std::ldexp(1., -level);
  const double low = x + static_cast<double>(index) * width;
  return { { low, low, low }, { low + width, low + width, low + width } };
}

/// Largest fraction of a width, in steps of a 1024th, by which one coordinate of the cell may be off, inwards.
double slackOf(const BoxLattice& lattice, const AxisBox& box)
{
  for (int step = 0; step < 1024; ++step)
  {
    CornerCoordinates corners = cornersOf(box);
    corners[1][2] -= (step + 1) / 1024. * box.width(1);
    if (!lattice.place(corners))
    {
      return step / 1024.;
    }
  }
  return 1.;
}

constexpr double doubles = 0x1p-53;
constexpr double floats = 0x1p-24;

} // namespace

TEST(BoxLattice, CornersMayBeOffByAPartOfTheWidthButBySixDigitsAtMost)
{
  BoxSizes sizes;
  for (const int level : { 0, 5, 12 })
  {
    sizes.add(cellAt(level, 1));
  }
  const BoxLattice lattice(sizes, doubles);
  // The largest coordinate is 2: 2e-5.
  EXPECT_NEAR(slackOf(lattice, cellAt(5, 1)), 2e-5 * 32., 1. / 1024.);
  EXPECT_EQ(slackOf(lattice, cellAt(12, 1)), 1. / 64.);
}

TEST(BoxLattice, CornersMayBeOffByRoundingButByAQuarterAtMost)
{
  const std::array<double, 3> expected{ 1. / 64., 8. * 0x1p-24 * 2. * 0x1p17, 1. / 4. };
  const std::array<int, 3> levels{ 12, 17, 20 };
  BoxSizes sizes;
  for (const int level : { 0, 12, 17, 20 })
  {
    sizes.add(cellAt(level, 1));
  }
  const BoxLattice lattice(sizes, floats);
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(slackOf(lattice, cellAt(levels[i], 1)), expected[i]) << levels[i];
  }
}

TEST(BoxLattice, RoundedWidthsDoNotAddUp)
{
  // 1,000 boxes of 0.1, as float has them: the last one lies 1.5e-6 off if each begins where the one before ends.
  BoxSizes sizes;
  const auto box = [](int i) {
    const auto low = static_cast<double>(static_cast<float>(i * 0.1));
    const auto high = static_cast<double>(static_cast<float>((i + 1) * 0.1));
    return AxisBox{ { low, 0., 0. }, { high, 1., 1. } };
  };
  for (int i = 0; i < 1000; ++i)
  {
    sizes.add(box(i));
  }
  const BoxLattice lattice(sizes, floats);
  EXPECT_EQ(lattice.roots(), (std::array<int, 3>{ 1000, 1, 1 }));
  for (int i = 0; i < 1000; ++i)
  {
    const auto place = lattice.place(cornersOf(box(i)));
    ASSERT_TRUE(place);
    EXPECT_EQ(place->index[0], i);
    EXPECT_NEAR(lattice.planes()[0][i], i * 0.1, 1e-8 * i);
  }
}

TEST(BoxLattice, NotEveryLatticeIsMade)
{
  BoxSizes sizes;
  sizes.add(cellAt(0, 0));
  sizes.add(cellAt(0, BoxLattice::maxRoots - 1));
  EXPECT_EQ(BoxLattice(sizes, doubles).roots(), (std::array<int, 3>{ 1, 1, 1 }));
  sizes.add(cellAt(0, BoxLattice::maxRoots));
  EXPECT_THROW(BoxLattice(sizes, doubles), Error);
  sizes.add({ { 0., 0., 0. }, { 1e-300, 1., 1. } });
  EXPECT_THROW(BoxLattice(sizes, doubles), Error);
}

TEST(BoxLattice, NeighboursDistanceIsTheMostFrequentOne)
{
  EXPECT_EQ(distanceOfNeighbours({ 3., 1., 2., 1., 4., 1.0001, 8. }, 0.9), 1.);
  EXPECT_EQ(distanceOfNeighbours({ 1., 1., 1.001 }, 0.9), 0.);
  EXPECT_EQ(distanceOfNeighbours({}, 0.9), 0.);
}

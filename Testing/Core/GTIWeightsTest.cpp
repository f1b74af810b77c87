#include "Interpolation/GTIWeights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

using namespace treeamr;

namespace
{

/// Position of a slot's data point along an axis, in widths of the unrefined cell.
double coordinate(unsigned mask, int slot, int axis)
{
  return (slot >> axis & 1 ? 1. : -1.) * (mask >> slot & 1 ? 0.25 : 0.5);
}

template <int D>
void checkTable(const GTIWeightTable<D>& table)
{
  for (unsigned mask = 0; mask < table.size(); ++mask)
  {
    const auto& w = table[mask];
    for (int basis = 0; basis < 1 << D; ++basis)
    {
      double moment = 0.;
      for (int s = 0; s < 1 << D; ++s)
      {
        double phi = 1.;
        for (int a = 0; a < D; ++a)
        {
          phi *= basis >> a & 1 ? coordinate(mask, s, a) : 1.;
        }
        moment += w[s] * phi;
      }
      EXPECT_NEAR(moment, basis == 0 ? 1. : 0., 1e-14) << "mask " << mask << " basis " << basis;
    }
    for (const double x : w)
    {
      EXPECT_GT(x, 0.) << "mask " << mask;
    }
  }
}

} // namespace

TEST(GTIWeights, SolveTheirEquationAndArePositive)
{
  checkTable<1>(gtiWeights1);
  checkTable<2>(gtiWeights2);
  checkTable<3>(gtiWeights3);
}

TEST(GTIWeights, EqualThePapersTwoDimensionalCase4)
{
  // Equation 5: A, B and C unrefined, D refined.
  const auto& w = gtiWeights2[0b1000];
  EXPECT_NEAR(w[0], 2. / 9., 1e-15);
  EXPECT_NEAR(w[1], 1. / 6., 1e-15);
  EXPECT_NEAR(w[2], 1. / 6., 1e-15);
  EXPECT_NEAR(w[3], 4. / 9., 1e-15);
}

TEST(GTIWeights, HaveTwentyOneDistinctSetsIn3D)
{
  std::set<std::vector<long>> sets;
  for (unsigned mask = 0; mask < 256; ++mask)
  {
    std::vector<long> sorted;
    for (const double x : gtiWeights3[mask])
    {
      sorted.push_back(std::lround(x * 1e9));
    }
    std::sort(sorted.begin(), sorted.end());
    sets.insert(sorted);
  }
  EXPECT_EQ(sets.size(), 21u);
  // The case that the paper's released code cannot reach.
  bool found = false;
  for (const auto& s : sets)
  {
    found = found || std::count(s.begin(), s.end(), std::lround(14. / 89. * 1e9)) > 0;
  }
  EXPECT_TRUE(found);
}

// The vectorised parts of block values, against plain loops on every instruction set.
#include "Interpolation/BlockKernel.h"
#include "Support/Targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Not of single precision, of both signs.
template <std::size_t Size>
std::array<double, Size> randomValues(int seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1., 3.);
  std::array<double, Size> values;
  std::generate(values.begin(), values.end(), [&] { return value(random); });
  return values;
}

} // namespace

TEST(BlockKernel, MeansLieBetweenAndInTheMiddleOfPlaces)
{
  const auto places = randomValues<72>(1);
  forEachTarget([&](const char* target) {
    std::array<double, 128> values;
    meansBetween(places, values);
    for (int v = 0; v < 125; ++v)
    {
      const std::array<int, 3> at{ v % 5, v / 5 % 5, v / 25 };
      std::array<int, 3> stride{ 1, 4, 16 };
      int first = 0;
      for (int a = 0; a < 3; ++a)
      {
        first += (at[a] + 1) / 2 * stride[a];
        stride[a] = at[a] % 2 == 0 ? stride[a] : 0;
      }
      const auto x = [&](int i) { return 0.5 * (places[i] + places[i + stride[0]]); };
      const auto xy = [&](int i) { return 0.5 * (x(i) + x(i + stride[1])); };
      ASSERT_EQ(values[v], 0.5 * (xy(first) + xy(first + stride[2]))) << "vertex " << v << " on " << target;
    }
  });
}

TEST(BlockKernel, RoundsToNearestAndFindsTheHull)
{
  auto values = randomValues<128>(2);
  // Neither what has no meaning nor where the ends are may matter.
  values[125] = values[126] = values[127] = std::numeric_limits<double>::quiet_NaN();
  for (const int end : { 0, 1, 62, 109, 110, 123, 124 })
  {
    values[end] = -5. - end;
    values[124 - end] = end == 62 ? values[end] : 5. + end;
    std::array<float, 125> expected;
    std::transform(
      values.begin(), values.begin() + 125, expected.begin(), [](double v) { return static_cast<float>(v); });
    const auto [low, high] = std::minmax_element(expected.begin(), expected.end());
    forEachTarget([&](const char* target) {
      std::array<float, 125> rounded;
      const Range range = roundValues(values, rounded);
      EXPECT_EQ(rounded, expected) << target;
      EXPECT_EQ(range.min, *low) << target;
      EXPECT_EQ(range.max, *high) << target;
      const Range again = hull(rounded);
      EXPECT_EQ(again.min, *low) << target;
      EXPECT_EQ(again.max, *high) << target;
    });
  }
}

TEST(BlockKernel, StepsAreTheNearestOfTheHull)
{
  const auto doubles = randomValues<128>(3);
  std::array<float, 125> values;
  const Range range = roundValues(doubles, values);
  constexpr float last = 65535.f;
  std::array<std::uint16_t, 128> first;
  quantise(values, range, last, first);
  const double step = (static_cast<double>(range.max) - range.min) / last;
  for (int v = 0; v < 125; ++v)
  {
    // Single precision errs by less than a fiftieth of a step here.
    EXPECT_NEAR(range.min + first[v] * step, values[v], 0.52 * step) << "vertex " << v;
  }
  EXPECT_EQ(*std::min_element(first.begin(), first.begin() + 125), 0);
  EXPECT_EQ(*std::max_element(first.begin(), first.end()), 65535);
  forEachTarget([&](const char* target) {
    std::array<std::uint16_t, 128> steps;
    quantise(values, range, last, steps);
    EXPECT_EQ(steps, first) << target;
    values.fill(2.5f);
    quantise(values, { 2.5f, 2.5f }, last, steps);
    EXPECT_EQ(steps, (std::array<std::uint16_t, 128>{})) << target;
    roundValues(doubles, values);
  });
}

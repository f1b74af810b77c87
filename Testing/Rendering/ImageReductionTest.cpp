// How the pixels of reduced images lie, and the choice of the distance between rays from times that a model
// gives.
#include "ImageReduction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using treeamr::ImageReduction;
using treeamr::SampleDistanceControl;

TEST(ImageReductionTest, sizes)
{
  const ImageReduction full(61, 44, 1.);
  EXPECT_TRUE(full.isFull());
  EXPECT_EQ(full.width(), 61);
  EXPECT_EQ(full.height(), 44);
  const ImageReduction third(61, 44, 3.);
  EXPECT_FALSE(third.isFull());
  EXPECT_EQ(third.width(), 21);
  EXPECT_EQ(third.height(), 15);
  EXPECT_EQ(third.fullWidth(), 61);
  EXPECT_EQ(third.fullHeight(), 44);
  const ImageReduction least(61, 44, 100.);
  EXPECT_EQ(least.width(), 1);
  EXPECT_EQ(least.height(), 1);
  EXPECT_TRUE(ImageReduction(1, 1, 100.).isFull());
}

TEST(ImageReductionTest, samplesThePixelsOfTheCentres)
{
  for (const double distance : { 1., 1.5, 2., 3., 7. })
  {
    for (const auto& [width, height] : { std::pair(12, 9), std::pair(13, 1), std::pair(1, 8) })
    {
      std::vector<float> full;
      for (int i = 0; i < width * height; ++i)
      {
        full.push_back(static_cast<float>(i));
      }
      const ImageReduction reduction(width, height, distance);
      const std::vector<float> reduced = reduction.sample(full);
      ASSERT_EQ(reduced.size(), static_cast<std::size_t>(reduction.width()) * reduction.height());
      for (int y = 0; y < reduction.height(); ++y)
      {
        for (int x = 0; x < reduction.width(); ++x)
        {
          // The one pixel whose square [i, i + 1) holds the centre, in units that make it whole.
          int column = 0;
          while (2 * (column + 1) * reduction.width() <= (2 * x + 1) * width)
          {
            ++column;
          }
          int row = 0;
          while (2 * (row + 1) * reduction.height() <= (2 * y + 1) * height)
          {
            ++row;
          }
          EXPECT_EQ(reduced[y * reduction.width() + x], row * width + column);
        }
      }
    }
  }
}

namespace
{

/// Frames of a scene whose time is fixed + full / distance^2.
class Motion
{
public:
  Motion(double fixed, double full)
    : fixed_(fixed)
    , full_(full)
  {
  }
  /// The distances of that many frames; `noise` changes the time of every other one by a factor.
  std::vector<double> run(int frames, double allowed, double noise = 1.)
  {
    std::vector<double> distances;
    for (int i = 0; i < frames; ++i)
    {
      const double distance = control.choose(allowed, 1., 10.);
      distances.push_back(distance);
      control.record(distance, time(distance) * (i % 2 == 0 ? noise : 1. / noise), true);
    }
    return distances;
  }
  double time(double distance) const { return fixed_ + full_ / (distance * distance); }

  SampleDistanceControl control;

private:
  double fixed_;
  double full_;
};

} // namespace

TEST(SampleDistanceControlTest, startsInTheMiddle)
{
  SampleDistanceControl control;
  EXPECT_EQ(control.choose(0.1, 1., 10.), 5.);
  EXPECT_EQ(SampleDistanceControl().choose(0.1, 6., 10.), 6.);
  EXPECT_EQ(SampleDistanceControl().choose(0.1, 6., 2.), 6.) << "the minimum wins";
}

TEST(SampleDistanceControlTest, goesByTheStillFrame)
{
  SampleDistanceControl control;
  control.record(1., 0.9, false);
  EXPECT_DOUBLE_EQ(control.choose(0.1, 1., 10.), 3.);
  // Not after an interactive one.
  control.record(3., 0.1, true);
  control.record(1., 40., false);
  EXPECT_DOUBLE_EQ(control.choose(0.1, 1., 10.), 3.);
}

TEST(SampleDistanceControlTest, reachesTheAllowedTime)
{
  for (const double fixed : { 0., 0.02, 0.06 })
  {
    for (const double full : { 0.2, 0.9, 3. })
    {
      Motion motion(fixed, full);
      const double last = motion.run(40, 0.1).back();
      // Changes below a tenth of the distance are left out: a fifth of the time, and a little more.
      EXPECT_LT(motion.time(last), 0.1 * 1.25) << fixed << " " << full;
      EXPECT_GT(motion.time(last), 0.1 / 1.25) << fixed << " " << full;
    }
  }
}

// Of three processes one has measured a slow draft, one a fast one, one nothing but a still frame.
TEST(SampleDistanceControlTest, processesThatAgreeDrawAsTheSlowest)
{
  std::array<SampleDistanceControl, 3> controls;
  controls[0].record(2., 0.5, true);
  controls[1].record(2., 0.1, true);
  controls[2].record(1., 90., false);
  std::array<double, 3> largest{};
  for (SampleDistanceControl control : controls) // copies: a round to collect the numbers
  {
    control.agree([&](std::array<double, 3>& numbers) {
      std::ranges::transform(
        numbers, largest, largest.begin(), [](double a, double b) { return std::max(a, b); });
    });
  }
  SampleDistanceControl slowest;
  slowest.record(2., 0.5, true);
  const double expected = slowest.choose(0.05, 1., 100.);
  for (SampleDistanceControl& control : controls)
  {
    control.agree([&](std::array<double, 3>& numbers) { numbers = largest; });
    EXPECT_EQ(control.choose(0.05, 1., 100.), expected);
  }
}

TEST(SampleDistanceControlTest, doesNotOscillate)
{
  for (const double fixed : { 0., 0.02, 0.09, 0.5 })
  {
    for (const double full : { 0.01, 0.2, 0.9, 30. })
    {
      Motion motion(fixed, full);
      const std::vector<double> distances = motion.run(60, 0.1);
      const bool monotonous = std::is_sorted(distances.begin() + 1, distances.end()) ||
        std::is_sorted(distances.rbegin(), distances.rend() - 1);
      EXPECT_TRUE(monotonous) << fixed << " " << full;
      EXPECT_EQ(distances[59], distances[45]);
    }
  }
}

TEST(SampleDistanceControlTest, isNotMovedByNoise)
{
  Motion motion(0.01, 0.9);
  const double quiet = motion.run(30, 0.1).back();
  const std::vector<double> noisy = motion.run(30, 0.1, 1.15);
  EXPECT_EQ(noisy, std::vector<double>(30, quiet));
}

TEST(SampleDistanceControlTest, followsTheAllowedTimeAtOnce)
{
  Motion motion(0., 0.9);
  motion.run(30, 0.1);
  EXPECT_LT(motion.run(1, 0.9).back(), 1.2);
  EXPECT_EQ(motion.run(1, 1e6).back(), 1.) << "exactly, not within the tenth";
  EXPECT_EQ(motion.run(1, 0.).back(), 10.);
}

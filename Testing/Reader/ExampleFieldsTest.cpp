// The sheet against a sum over all blobs, and the criterion of refinement.
#include "ExampleFields.h"

#include <gtest/gtest.h>

#include <random>

using namespace treeamr;

namespace
{

struct Blob
{
  double x, y, z, sigma, height;
};

double sheetHeight(double x, double z)
{
  return 0.5 + 0.08 * std::sin(9. * x + 2. * std::sin(5. * z));
}

std::vector<Blob> makeBlobs()
{
  std::uint64_t state = 1;
  const auto random = [&] {
    state += 0x9e3779b97f4a7c15;
    std::uint64_t z = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return std::ldexp(static_cast<double>((z ^ (z >> 31)) >> 11), -53);
  };
  std::vector<Blob> blobs(120);
  for (Blob& b : blobs)
  {
    b.x = random();
    b.z = random();
    b.y = sheetHeight(b.x, b.z);
    b.y += 0.3 * random();
    b.y -= 0.3 * (1. - random());
    b.sigma = 1. / (125. - 118.75 * random());
    b.height = 0.3 + 0.7 * random();
  }
  return blobs;
}

double sheetByBruteForce(const std::vector<Blob>& blobs, double x, double y, double z)
{
  const auto gauss = [](double distance, double sigma) {
    return std::exp(-distance * distance / (2. * sigma * sigma));
  };
  double sum =
    gauss(y - sheetHeight(x, z), 0.025) * 0.6 * (0.6 + 0.4 * std::sin(40. * x) * std::sin(31. * z));
  for (const Blob& b : blobs)
  {
    sum += b.height * gauss(std::hypot(x - b.x, y - b.y, z - b.z), b.sigma);
  }
  return sum;
}

} // namespace

TEST(Sheet, BlobsHaveTheStatedSizes)
{
  for (const Blob& b : makeBlobs())
  {
    EXPECT_TRUE(b.sigma >= 0.008 && b.sigma <= 0.16) << b.sigma;
    EXPECT_TRUE(b.height >= 0.3 && b.height <= 1.) << b.height;
  }
}

TEST(Sheet, IsTheSumOfTheSheetAndAllBlobs)
{
  const Sheet sheet;
  const std::vector<Blob> blobs = makeBlobs();
  // What is left out of each of them beyond 6 sigma.
  const double tolerance = 121. * std::exp(-18.);
  const auto expectSame = [&](double x, double y, double z) {
    ASSERT_NEAR(sheet(x, y, z), sheetByBruteForce(blobs, x, y, z), tolerance) << x << ' ' << y << ' ' << z;
  };
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> coordinate(0., 1.);
  for (int i = 0; i < 20000; ++i)
  {
    expectSame(coordinate(engine), coordinate(engine), coordinate(engine));
  }
  for (const Blob& b : blobs)
  {
    expectSame(b.x, b.y, b.z);
    expectSame(b.x + 5.9 * b.sigma, b.y, b.z);
    expectSame(b.x, b.y - 3. * b.sigma, b.z - 3. * b.sigma);
  }
  for (int corner = 0; corner < 8; ++corner)
  {
    expectSame(corner & 1, corner >> 1 & 1, corner >> 2);
  }
}

TEST(RangeOverProbes, IsTakenAtTheCentresOfTheThirds)
{
  const auto linear = [](double x, double y, double z) { return x + 10. * y - 100. * z; };
  EXPECT_NEAR(rangeOverProbes(linear, { 0.25, 0.5, 0.125 }, 0.375), 111. * 0.25, 1e-12);
}

// What programs keep in 8 bytes, and whether it passes for a double.
#include "Forest/PayloadGuess.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

using treeamr::DoubleGuess;

namespace
{

/// Of `cells` payloads made by `make`, which gets the cell's number.
template <class Make>
std::string objectionTo(int cells, const Make& make)
{
  DoubleGuess guess;
  for (int i = 0; i < cells; ++i)
  {
    const auto payload = make(i);
    static_assert(sizeof(payload) == 8);
    std::byte bytes[9]; // not aligned
    std::memcpy(bytes + 1, &payload, 8);
    guess.add(bytes + 1);
  }
  return guess.objection();
}

#define EXPECT_OBJECTION(part, objection) EXPECT_NE((objection).find(part), std::string::npos) << (objection)

TEST(PayloadGuessTest, DoublesPass)
{
  for (const double scale : { 1., -1e-12, 1e30 })
  {
    EXPECT_EQ(objectionTo(1000, [=](int i) { return scale * std::sin(0.1 * i); }), "") << scale;
  }
  EXPECT_EQ(objectionTo(2, [](int i) { return double(i); }), "") << "a mask of 0 and 1";
  EXPECT_EQ(objectionTo(1000, [](int i) { return 0.1 * i; }), "");
  EXPECT_EQ(objectionTo(1000, [](int i) { return double(0.1f * float(i)); }), "") << "once floats";
  EXPECT_EQ(objectionTo(1000, [](int i) { return 0.125 * (i % 8); }), "") << "short numbers";
  EXPECT_EQ(objectionTo(1000, [](int i) { return std::exp(-double(i)); }), "") << "ends in denormals and 0";
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> density(0., 5.);
  EXPECT_EQ(objectionTo(1000, [&](int) { return density(random); }), "");
}

TEST(PayloadGuessTest, IntegersAndPointersDoNot)
{
  using Int = std::int64_t;
  EXPECT_OBJECTION("are all 0", objectionTo(9, [](int) { return Int(0); }));
  EXPECT_OBJECTION("single precision does not hold", objectionTo(1000, [](int i) { return Int(i); }));
  EXPECT_OBJECTION("single precision does not hold", objectionTo(1000, [](int i) { return Int(i) << 40; }));
  EXPECT_OBJECTION("not finite in 500 of 1000", objectionTo(1000, [](int i) { return Int(i) - 500; }));
  EXPECT_OBJECTION(
    "single precision does not hold", objectionTo(9, [](int i) { return Int(0x7ffd12345670) + 48 * i; }));
  EXPECT_OBJECTION("single precision does not hold",
    objectionTo(9, [](int i) { return Int(1700000000000000000) + 1000003 * i; })); // nanoseconds since 1970
  std::mt19937_64 random(2);
  EXPECT_NE(objectionTo(1000, [&](int) { return random(); }), "") << "hashes";
}

TEST(PayloadGuessTest, PairsDoNot)
{
  using Ints = std::array<std::int32_t, 2>;
  using Floats = std::array<float, 2>;
  struct Mixed
  {
    std::int32_t rank;
    float rho;
  };
  EXPECT_OBJECTION("single precision does not hold", objectionTo(1000, [](int i) {
    return Ints{ i, i % 7 };
  }));
  EXPECT_OBJECTION("not finite", objectionTo(1000, [](int i) { return Ints{ i, -i }; }));
  EXPECT_OBJECTION("single precision does not hold", objectionTo(1000, [](int i) {
    return Ints{ 3, 1000000 + i };
  }));
  for (const float scale : { 1.f, -1e-6f, 1e9f })
  {
    EXPECT_NE(objectionTo(1000,
                [=](int i) {
                  return Floats{ scale * std::sin(0.1f * float(i)), scale * std::cos(0.1f * float(i)) };
                }),
      "")
      << scale;
  }
  EXPECT_OBJECTION("the first of them a float", objectionTo(1000, [](int i) {
    return Floats{ 0.1f + float(i), 300.f / float(1 + i) };
  }));
  EXPECT_OBJECTION("the first of them an integer", objectionTo(1000, [](int i) {
    return Mixed{ i % 64, 300.f / float(1 + i) };
  }));
}

TEST(PayloadGuessTest, DoublesInDoubtDoNot)
{
  EXPECT_OBJECTION("all have one exponent, as 42", objectionTo(9, [](int) { return 42.; }));
  EXPECT_OBJECTION("all have one exponent, as 1.89", objectionTo(90, [](int i) { return 1. + 0.01 * i; }));
  EXPECT_OBJECTION("are all 0", objectionTo(9, [](int) { return 0.; }));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_OBJECTION("are not finite in 1 of 100 cells",
    objectionTo(100, [=](int i) { return i == 50 ? nan : std::sin(double(i)); }));
  EXPECT_OBJECTION("go up to 1.79769e+308, which single precision does not hold",
    objectionTo(100, [](int i) { return i == 50 ? std::numeric_limits<double>::max() : 0.1 * i; }));
}

} // namespace

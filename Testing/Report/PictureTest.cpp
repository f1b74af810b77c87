// The report's comparison of pictures against the definitions.
#include "Picture.h"

#include "Error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace treeamr;
using namespace treeamr::report;

namespace
{

Image randomImage(int width, int height, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-0.2f, 1.2f);
  Image image(width, height);
  std::generate(image.rgba.begin(), image.rgba.end(), [&] { return uniform(random); });
  return image;
}

double luminanceAt(const Image& image, int x, int y)
{
  const float* rgba = image.rgba.data() + 4 * (y * image.width + x);
  return 0.2126 * std::clamp(rgba[0], 0.f, 1.f) + 0.7152 * std::clamp(rgba[1], 0.f, 1.f) +
    0.0722 * std::clamp(rgba[2], 0.f, 1.f);
}

/// Each window's sums about its own means.
double similarityByDefinition(const Image& a, const Image& b)
{
  double total = 0.;
  int windows = 0;
  for (int y = 5; y + 5 < a.height; ++y)
  {
    for (int x = 5; x + 5 < a.width; ++x)
    {
      const auto sum = [&](const auto& term) {
        double weights = 0.;
        double terms = 0.;
        for (int j = -5; j <= 5; ++j)
        {
          for (int i = -5; i <= 5; ++i)
          {
            const double weight = std::exp(-(i * i + j * j) / (2. * 1.5 * 1.5));
            weights += weight;
            terms += weight * term(luminanceAt(a, x + i, y + j), luminanceAt(b, x + i, y + j));
          }
        }
        return terms / weights;
      };
      const double ma = sum([](double u, double) { return u; });
      const double mb = sum([](double, double v) { return v; });
      const double aa = sum([&](double u, double) { return (u - ma) * (u - ma); });
      const double bb = sum([&](double, double v) { return (v - mb) * (v - mb); });
      const double ab = sum([&](double u, double v) { return (u - ma) * (v - mb); });
      total += (2. * ma * mb + 1e-4) / (ma * ma + mb * mb + 1e-4) * (2. * ab + 9e-4) / (aa + bb + 9e-4);
      ++windows;
    }
  }
  return total / windows;
}

} // namespace

TEST(Picture, SimilarityIsThatOfTheDefinition)
{
  const Image a = randomImage(23, 17, 1);
  Image b = randomImage(23, 17, 2);
  EXPECT_NEAR(structuralSimilarity(a, b), similarityByDefinition(a, b), 1e-12);
  std::transform(a.rgba.begin(), a.rgba.end(), b.rgba.begin(), b.rgba.begin(),
    [](float u, float v) { return 0.8f * u + 0.2f * v; });
  const double close = structuralSimilarity(a, b);
  EXPECT_NEAR(close, similarityByDefinition(a, b), 1e-12);
  EXPECT_GT(close, 0.9);
  EXPECT_LT(close, 0.999);
}

TEST(Picture, EqualPicturesAreAlikeAndConstantOnesByTheirMeans)
{
  const Image a = randomImage(11, 12, 3);
  EXPECT_NEAR(structuralSimilarity(a, a), 1., 1e-12);
  Image dark(11, 11);
  Image bright(11, 11);
  std::fill(dark.rgba.begin(), dark.rgba.end(), 0.25f);
  std::fill(bright.rgba.begin(), bright.rgba.end(), 0.75f);
  EXPECT_NEAR(structuralSimilarity(dark, bright), (2. * 0.1875 + 1e-4) / (0.625 + 1e-4), 1e-9);
}

TEST(Picture, SizesThatDoNotFitAreErrors)
{
  EXPECT_THROW(structuralSimilarity(Image(11, 12), Image(12, 11)), Error);
  EXPECT_THROW(structuralSimilarity(Image(10, 20), Image(10, 20)), Error);
}

TEST(Picture, MagnifiedPlanesStayPlanesBetweenTheOutermostCentres)
{
  // Over [0, 1] in both directions.
  const auto plane = [](double x, double y, int c) { return 0.25 * x - 0.5 * y + 0.125 * c; };
  constexpr int width = 7;
  constexpr int height = 4;
  Image small(width, height);
  for (int i = 0; i < width * height * 4; ++i)
  {
    small.rgba[i] =
      static_cast<float>(plane((i / 4 % width + 0.5) / width, (i / 4 / width + 0.5) / height, i % 4));
  }
  const Image large = magnify(small, 10, 9);
  ASSERT_EQ(large.width, 10);
  ASSERT_EQ(large.height, 9);
  const auto inside = [](double at, int pixels) { return std::clamp(at, 0.5 / pixels, 1. - 0.5 / pixels); };
  for (int i = 0; i < 10 * 9 * 4; ++i)
  {
    const double x = inside((i / 4 % 10 + 0.5) / 10, width);
    const double y = inside((i / 4 / 10 + 0.5) / 9, height);
    EXPECT_NEAR(large.rgba[i], plane(x, y, i % 4), 1e-6) << i;
  }
  EXPECT_EQ(magnify(small, width, height).rgba, small.rgba);
}

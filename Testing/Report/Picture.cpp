#include "Picture.h"

#include "Error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace treeamr::report
{

namespace
{

constexpr int windowWidth = 11;

/// One value per pixel, lower left first.
struct Plane
{
  int width;
  int height;
  std::vector<double> values;
};

Plane luminance(const Image& image)
{
  constexpr std::array weights{ 0.2126, 0.7152, 0.0722 }; // ITU-R BT.709
  Plane plane{ image.width, image.height, std::vector<double>(image.rgba.size() / 4) };
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
  {
    plane.values[i / 4] +=
      i % 4 < 3 ? weights[i % 4] * std::clamp(static_cast<double>(image.rgba[i]), 0., 1.) : 0.;
  }
  return plane;
}

Plane product(const Plane& a, const Plane& b)
{
  Plane result = a;
  std::transform(
    a.values.begin(), a.values.end(), b.values.begin(), result.values.begin(), std::multiplies<>());
  return result;
}

/// The window's weighted means along rows, of the transpose: applied twice they are those of the picture.
Plane blurRowsAndTranspose(const Plane& plane)
{
  std::array<double, windowWidth> weights;
  double sum = 0.;
  for (int i = 0; i < windowWidth; ++i)
  {
    constexpr double sigma = 1.5;
    const double distance = (i - windowWidth / 2) / sigma;
    weights[i] = std::exp(-0.5 * distance * distance);
    sum += weights[i];
  }
  const int length = plane.width - windowWidth + 1;
  Plane result{ plane.height, length, std::vector<double>(static_cast<std::size_t>(plane.height) * length) };
  for (int y = 0; y < plane.height; ++y)
  {
    const double* row = plane.values.data() + static_cast<std::size_t>(y) * plane.width;
    for (int x = 0; x < length; ++x)
    {
      double mean = 0.;
      for (int i = 0; i < windowWidth; ++i)
      {
        mean += weights[i] * row[x + i];
      }
      result.values[static_cast<std::size_t>(x) * plane.height + y] = mean / sum;
    }
  }
  return result;
}

Plane windowMeans(const Plane& plane)
{
  return blurRowsAndTranspose(blurRowsAndTranspose(plane));
}

} // namespace

double structuralSimilarity(const Image& a, const Image& b)
{
  if (a.width != b.width || a.height != b.height || std::min(a.width, a.height) < windowWidth)
  {
    const auto size = [](const Image& i) {
      return std::to_string(i.width) + " x " + std::to_string(i.height);
    };
    throw Error("structural similarity: pictures of " + size(a) + " and " + size(b) +
      " pixels, allowed are equal sizes from 11 x 11");
  }
  constexpr double c1 = 0.01 * 0.01;
  constexpr double c2 = 0.03 * 0.03;
  const Plane planeA = luminance(a);
  const Plane planeB = luminance(b);
  const Plane meanA = windowMeans(planeA);
  const Plane meanB = windowMeans(planeB);
  const Plane squareA = windowMeans(product(planeA, planeA));
  const Plane squareB = windowMeans(product(planeB, planeB));
  const Plane productAB = windowMeans(product(planeA, planeB));
  double sum = 0.;
  for (std::size_t i = 0; i < meanA.values.size(); ++i)
  {
    const double ma = meanA.values[i];
    const double mb = meanB.values[i];
    const double variances = squareA.values[i] - ma * ma + squareB.values[i] - mb * mb;
    const double covariance = productAB.values[i] - ma * mb;
    sum += (2. * ma * mb + c1) * (2. * covariance + c2) / ((ma * ma + mb * mb + c1) * (variances + c2));
  }
  return sum / static_cast<double>(meanA.values.size());
}

Image magnify(const Image& image, int width, int height)
{
  /// Between which pixels along an axis, and where.
  struct Place
  {
    std::size_t low;
    std::size_t high;
    float f;
  };
  const auto places = [](int from, int to) {
    std::vector<Place> all;
    for (int i = 0; i < to; ++i)
    {
      const double at = (i + 0.5) * from / to - 0.5;
      const auto low = static_cast<int>(std::floor(at));
      all.push_back({ static_cast<std::size_t>(std::clamp(low, 0, from - 1)),
        static_cast<std::size_t>(std::clamp(low + 1, 0, from - 1)), static_cast<float>(at - low) });
    }
    return all;
  };
  const std::vector<Place> columns = places(image.width, width);
  Image result(width, height);
  float* out = result.rgba.data();
  for (const Place& y : places(image.height, height))
  {
    const float* low = image.rgba.data() + 4 * y.low * image.width;
    const float* high = image.rgba.data() + 4 * y.high * image.width;
    for (const Place& x : columns)
    {
      for (int c = 0; c < 4; ++c)
      {
        const auto along = [&](const float* row) {
          return std::lerp(row[4 * x.low + c], row[4 * x.high + c], x.f);
        };
        *out++ = std::lerp(along(low), along(high), y.f);
      }
    }
  }
  return result;
}

} // namespace treeamr::report

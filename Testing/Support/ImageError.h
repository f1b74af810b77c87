// How far pictures are apart.
#pragma once

#include "Geometry/Image.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeamr::test
{

/// Root mean square over the first channels of all pixels.
inline double rmse(const Image& a, const Image& b, std::size_t channels = 4)
{
  double sum = 0.;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    sum += i % 4 < channels ? std::pow(static_cast<double>(a.rgba[i]) - b.rgba[i], 2) : 0.;
  }
  return std::sqrt(sum * 4. / static_cast<double>(channels * a.rgba.size()));
}

/// Of a channel; NaN where one is.
inline float largestDifference(const Image& a, const Image& b)
{
  float largest = 0.f;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    const float difference = std::abs(a.rgba[i] - b.rgba[i]);
    largest = difference <= largest ? largest : difference;
  }
  return largest;
}

/// Over the channels of the pixels that b has.
inline double meanDifference(const Image& a, const Image& b)
{
  double sum = 0.;
  int drawn = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4)
  {
    for (std::size_t c = i; c < i + 4 && b.rgba[i + 3] > 0.f; ++c, ++drawn)
    {
      sum += std::abs(a.rgba[c] - b.rgba[c]);
    }
  }
  return sum / std::max(drawn, 1);
}

/// The part of pixels of which a channel differs by more, or is not a number: rays along edges of cells belong to either side.
inline double partThatDiffers(const Image& a, const Image& b, float tolerance)
{
  int count = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4)
  {
    bool differs = false;
    for (std::size_t c = i; c < i + 4; ++c)
    {
      differs = differs || !(std::abs(a.rgba[c] - b.rgba[c]) <= tolerance);
    }
    count += differs;
  }
  return count / static_cast<double>(a.width * a.height);
}

} // namespace treeamr::test

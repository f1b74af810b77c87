// How far pictures are apart.
#pragma once

#include "Geometry/Image.h"

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

} // namespace treeamr::test

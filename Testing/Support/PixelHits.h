// Translucent surfaces for volumes, pixel by pixel.
#pragma once

#include "Geometry/RayStops.h"

#include <cstddef>
#include <vector>

namespace treeamr::test
{

struct PixelHits
{
  std::vector<std::size_t> first{ 0 };
  std::vector<TranslucentHit> hits;

  void add(double t, const std::array<float, 4>& rgba) { hits.push_back({ t, rgba }); }
  /// The hits that follow are the next one's.
  void endPixel() { first.push_back(hits.size()); }
  /// Refers to this.
  RayStops stops(const float* beginDepth = nullptr, const float* endDepth = nullptr) const
  {
    return { beginDepth, endDepth, {}, TranslucentHits{ first, hits } };
  }
};

} // namespace treeamr::test

// What the renderers fill.
#pragma once

#include "LargeArray.h"

#include <cstddef>

namespace treeamr
{

/// width x height pixels, lower left first; RGBA, colour premultiplied with alpha.
struct Image
{
  /// Transparent black.
  Image(int w, int h)
    : width(w)
    , height(h)
    , rgba(4 * static_cast<std::size_t>(w) * h, 0.f)
  {
  }
  int width;               // in pixels
  int height;              // in pixels
  LargeVector<float> rgba; // 4 * width * height, linear, 0 to 1
};

} // namespace treeamr

// Axis-aligned boxes.
#pragma once

#include "Geometry/Vec3.h"

namespace treeamr
{

/// From the lowest to the highest corner, faces included.
struct Bounds
{
  Vec3 min{}; // x, y, z
  Vec3 max{}; // not below min
};

/// Its length.
inline double diagonalOf(const Bounds& box) noexcept
{
  const Vec3 d{ box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2] };
  return std::sqrt(dot(d, d));
}

} // namespace treeamr

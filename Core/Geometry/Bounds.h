// Axis-aligned boxes.
#pragma once

#include "Geometry/Vec3.h"

namespace treeamr
{

struct Bounds
{
  Vec3 min{};
  Vec3 max{};
};

} // namespace treeamr

// The part of a ray inside an axis-aligned box.
#pragma once

#include "Geometry/Bounds.h"
#include "Geometry/Camera.h"

#include <cmath>

namespace treeamr
{

/// A ray with its reciprocal direction. Slab planes shared by two boxes give both the same bits.
struct SlabRay
{
  Vec3 origin;
  Vec3 direction;
  Vec3 inverse;

  SlabRay() noexcept = default;
  explicit SlabRay(const Ray& ray) noexcept
    : origin(ray.origin)
    , direction(ray.direction)
    , inverse{ 1. / ray.direction[0], 1. / ray.direction[1], 1. / ray.direction[2] }
  {
  }

  /// False for rays that run parallel to the axis' planes, as far as numbers can tell.
  bool crosses(int axis) const noexcept { return std::isfinite(inverse[axis]); }
  double planeAt(int axis, double plane) const noexcept { return (plane - origin[axis]) * inverse[axis]; }

  /// A ray that runs in a face belongs to the side above it; in the domain's upper face it is moved to that below.
  void enterUpperFaces(const Bounds& domain) noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      if (origin[a] == domain.max[a] && !crosses(a))
      {
        origin[a] = std::nextafter(domain.max[a], domain.min[a]);
      }
    }
  }

  /// Narrows [t0, t1] to the box; false when nothing is left. A ray parallel to a face belongs to the box
  /// whose half-open side [min, max) it runs in, so of two neighbours exactly one has it.
  bool clip(const Vec3& boxMin, const Vec3& boxMax, double& t0, double& t1) const noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      if (!crosses(a))
      {
        if (!(origin[a] >= boxMin[a] && origin[a] < boxMax[a]))
        {
          return false;
        }
        continue;
      }
      const double u = planeAt(a, boxMin[a]);
      const double v = planeAt(a, boxMax[a]);
      const double in = u < v ? u : v;
      const double out = u < v ? v : u;
      t0 = in > t0 ? in : t0;
      t1 = out < t1 ? out : t1;
    }
    return t0 < t1;
  }
};

} // namespace treeamr

// The coordinates that the rays of isosurfaces are traced in, and their way there.
#pragma once

#include "Geometry/RayBox.h"
#include "Octree/RootGrid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeamr
{

/// The part of a ray that may meet a surface.
struct RayPart
{
  SlabRay ray; // in TraceSpace
  double tEnter;
  double tLeave;
  double rounding; // bound of the error of a place along the ray

  /// The error by the largest coordinate that the way to a place goes through.
  static constexpr double roundingOfReach = 0x1p-50;
};

/// The coordinates that rays are traced in. On a uniform root grid they count roots: planes of cells are exact
/// numbers there, wherever and however large the domain is. Other root grids bend rays, so it is the world's.
class TraceSpace
{
public:
  /// Of rays in the unit cube coordinate and direction are no longer, in sum: Embree may abort.
  static constexpr float aroundUnitCube = 4.f;

  explicit TraceSpace(const RootGrid& grid)
    : grid_(grid)
    , origin_(grid.bounds().min)
    , uniform_(grid.isUniform())
  {
    const Bounds bounds = grid.bounds();
    for (int a = 0; a < 3; ++a)
    {
      origin_[a] = uniform_ ? bounds.min[a] : 0.;
      width_[a] = uniform_ ? (bounds.max[a] - bounds.min[a]) / grid.roots()[a] : 1.;
      perWidth_[a] = 1. / width_[a];
      domain_.min[a] = uniform_ ? 0. : bounds.min[a];
      domain_.max[a] = uniform_ ? grid.roots()[a] : bounds.max[a];
      perExtent_[a] = 1. / (domain_.max[a] - domain_.min[a]);
    }
  }

  const Bounds& domain() const noexcept { return domain_; }
  /// The world's place of its origin, and the world length of a unit along an axis.
  double origin(int axis) const noexcept { return origin_[axis]; }
  double width(int axis) const noexcept { return width_[axis]; }
  double perWidth(int axis) const noexcept { return perWidth_[axis]; }
  /// Of the domain.
  double perExtent(int axis) const noexcept { return perExtent_[axis]; }
  /// The same t at the same places.
  Ray ray(const Ray& world) const noexcept
  {
    Ray r;
    for (int a = 0; a < 3; ++a)
    {
      r.origin[a] = (world.origin[a] - origin_[a]) * perWidth_[a];
      r.direction[a] = world.direction[a] * perWidth_[a];
    }
    return r;
  }
  /// The part of a world's ray in [tMin, tMax] that is in the domain; false when it misses it.
  bool start(const Ray& world, double tMin, double tMax, RayPart& part) const noexcept
  {
    part.ray = SlabRay(ray(world));
    part.tEnter = tMin;
    part.tLeave = tMax;
    part.ray.enterUpperFaces(domain_);
    if (!part.ray.clip(domain_.min, domain_.max, part.tEnter, part.tLeave))
    {
      return false;
    }
    part.rounding = 0.;
    for (int a = 0; a < 3; ++a)
    {
      const double reach = std::abs(part.ray.origin[a]) + part.tLeave * std::abs(part.ray.direction[a]);
      part.rounding = std::max(part.rounding, RayPart::roundingOfReach * reach);
    }
    return true;
  }
  /// The part where the domain is a unit cube: from `origin` to origin + direction. False for NaN and from so far away
  /// that no digits are left.
  bool toUnitCube(
    const RayPart& part, std::array<float, 3>& origin, std::array<float, 3>& direction) const noexcept
  {
    bool isAround = true;
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = static_cast<float>(
        (part.ray.origin[a] + part.tEnter * part.ray.direction[a] - domain_.min[a]) * perExtent_[a]);
      direction[a] = static_cast<float>(part.ray.direction[a] * (part.tLeave - part.tEnter) * perExtent_[a]);
      isAround = isAround && std::abs(origin[a]) + std::abs(direction[a]) <= aroundUnitCube;
    }
    return isAround;
  }

  /// Planes `index` to index + 4 of a level.
  void planes(int axis, Coord index, int level, std::array<double, 5>& planes) const noexcept
  {
    if (!uniform_)
    {
      grid_.worldPlanes(axis, index, level, 5, planes.data());
      return;
    }
    const double part = 1. / static_cast<double>(Coord(1) << level);
    for (int i = 0; i < 5; ++i)
    {
      planes[i] = std::min(static_cast<double>(index + i) * part, domain_.max[axis]);
    }
  }
  int paddingDepth() const noexcept { return grid_.paddingDepth(); }
  bool isUniform() const noexcept { return uniform_; }

private:
  const RootGrid& grid_;
  Vec3 origin_;
  Vec3 width_;
  Vec3 perWidth_;
  Vec3 perExtent_;
  Bounds domain_;
  bool uniform_;
};

} // namespace treeamr

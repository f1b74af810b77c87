// Embree's hierarchy over the blocks of a surface. It works in single precision, sees the domain as a unit cube and rays
// that start where they enter it, and only selects candidates: boxes are widened by its rounding, and hits are found and
// compared by BlockIntersection, so the surface is exact at any depth of the tree and any distance from the origin.
#pragma once

#include "Surface/BlockIntersection.h"

#include <cstddef>
#include <memory>

namespace treeamr
{

/// Queries are safe from several threads. They throw what BlockIntersection throws.
class SurfaceHierarchy
{
public:
  /// As many blocks are too many.
  static constexpr std::size_t blockLimit = RayHits::noBlock;
  /// Throws Error when Embree fails. Of no blocks it is none, as is every ray then.
  explicit SurfaceHierarchy(const BlockIntersection& intersection);
  ~SurfaceHierarchy();
  SurfaceHierarchy(const SurfaceHierarchy&) = delete;
  SurfaceHierarchy& operator=(const SurfaceHierarchy&) = delete;

  /// Call while no thread queries. Builds again, over the extents that rays have narrowed since, each time that these
  /// have become twice as many: until then frames visit more blocks than they need to. Throws Error when Embree fails;
  /// then there is none.
  void update();
  std::size_t byteSize() const noexcept;
  /// Of wall time, to build it.
  double seconds() const noexcept;

  /// Whether there is none: then rays of tiles must not ask.
  bool isEmpty() const noexcept;
  /// Takes a ray, or all rays of a tile, through the blocks on their ways.
  void intersect(const RayPart& part, RayHits& hits) const;
  void intersect(RayTile& tile) const;
  /// The same until there is any hit. One by one: packets of spread rays visit the blocks of all of them.
  void occluded(const RayPart& part, RayHits& hits) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace treeamr

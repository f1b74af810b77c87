// The leaf that a point lies in.
#pragma once

#include "Interpolation/BlockValues.h"

#include <array>

namespace treeamr
{

/// Of one octree, for one thread. The way down starts where it parts from that to the last point.
class LeafFinder
{
public:
  explicit LeafFinder(const Octree& octree) noexcept;

  struct Leaf
  {
    int depth = 0; // 0: the only cell of the octree
    std::array<Coord, 3> index{};
    Vec3 place{}; // of the point in it, 0 to 1 along each axis
  };
  /// The leaf whose closed box holds a point: between cells the upper one, or the lower one where that is missing.
  /// False, and `leaf` of no meaning, where there is none or pWorld is not finite.
  bool find(const Vec3& pWorld, Leaf& leaf) noexcept;

  /// To the inner node above the leaf that was found last, which must have one.
  const BlockPath& pathToParent() const noexcept { return path_; }

private:
  bool descendTo(const std::array<Coord, 3>& finest, Leaf& leaf) noexcept;

  const Octree& octree_;
  int finestDepth_;
  double perRoot_; // finest cells
  BlockPath path_;
  std::array<Coord, 3> index_{}; // of the path's last node
};

} // namespace treeamr

// The vertex gradients of blocks of leaves (BlockGradients.h) of a field that is given at the corners of leaves.
//
// In a leaf the gradient is the trilinear interpolant of those at its corners. With L the coarsest level of the leaves
// that touch a corner v:
// - If v hangs on a leaf of level L, G(v) is interpolated between that leaf's corners around it.
// - Otherwise it is, axis by axis, the difference of the field h(L) below and above v over their distance in the world;
//   from v itself on a side where no leaf is, or none between that touches the other end.
// It depends on v and the tree alone, so it is continuous; of the second order for smooth fields inside the domain, of the
// first where levels meet or cells are missing, and exact for trilinear fields.
#pragma once

#include "Field/CornerValues.h"
#include "Geometry/Vec3.h"
#include "Octree/TreePath.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

namespace treeamr
{

/// Of one field, which must live as long, for one thread.
class CornerGradients
{
public:
  /// At the 27 corners of a node's children.
  using OfNode = std::array<Vec3, 27>;

  explicit CornerGradients(const Field& field);

  /// At a corner of a leaf among the children of the node at the path's end.
  Vec3 at(const TreePath& path, int vertex) noexcept { return this->gradient(path, path.depth(), vertex); }
  /// In an octree whose root is a leaf, at vertices from 0 to 1 along each axis.
  Vec3 inOnlyLeaf(int vertex) const noexcept;

private:
  /// What is known of the path's node at a depth.
  struct Level
  {
    std::uint64_t node = ~std::uint64_t(0);
    std::uint32_t known; // mask of vertices
    OfNode gradient;
  };

  Vec3 gradient(const TreePath& path, int depth, int vertex) noexcept;
  Vec3 compute(const TreePath& path, int depth, const CornerPlace& at) noexcept;
  double slope(const TreePath& path, int depth, int axis, const CornerPlace& at) const noexcept;
  std::optional<double> valueAt(const TreePath& path, int depth, const CornerPlace& at) const noexcept;
  std::optional<double> valueBeside(
    const TreePath& path, int depth, int axis, int side, const CornerPlace& at) const noexcept;
  std::optional<double> valueIn(
    const TreePath& path, int depth, const std::array<int, 3>& cell, int corner) const noexcept;
  double width(int axis, Coord index, int depth) const noexcept;

  const CornerValues& corners_;
  const Octree& octree_;
  std::unique_ptr<Level[]> levels_; // by depth
};

} // namespace treeamr

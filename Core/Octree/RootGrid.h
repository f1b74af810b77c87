// The lattice of root trees and the map between lattice and world coordinates.
//
// A cell of level l has integer coordinates (i, j, k) on a lattice of N * 2^l cells per axis, N root trees
// wide. World coordinates are piecewise linear in the lattice coordinate along each axis, with the kinks on
// the planes between roots: anisotropic and non-uniform rectilinear root grids need nothing else.
#pragma once

#include "Geometry/Bounds.h"
#include "Geometry/Octant.h"

#include <array>
#include <vector>

namespace treeamr
{

/// A cell: its level (0 = a root) and its index on that level's lattice.
struct CellId
{
  std::array<Coord, 3> index{}; // x, y, z, from 0 on
  int level = 0;                // 0 to RootGrid::maxLevel()
};

/// Where the trees of an octree are, in the world. Never changes.
class RootGrid
{
public:
  /// planes[a] holds the N_a + 1 strictly increasing, finite world coordinates of the root planes of axis a.
  /// Throws Error otherwise.
  explicit RootGrid(std::array<std::vector<double>, 3> planes);
  /// roots[0] x roots[1] x roots[2] equal boxes of the given size. Throws Error for numbers of roots and sizes
  /// that no planes could have.
  static RootGrid uniform(
    std::array<int, 3> roots, std::array<double, 3> origin, std::array<double, 3> rootSize);

  /// Along each axis.
  const std::array<int, 3>& roots() const noexcept { return roots_; }
  /// Whether the roots are equal boxes, to the rounding of their planes.
  bool isUniform() const noexcept;
  /// The roots are the cells of this depth of the padded octree: the smallest p with 2^p >= max(roots).
  int paddingDepth() const noexcept { return paddingDepth_; }
  /// Deepest level whose vertices still have 64-bit lattice coordinates.
  int maxLevel() const noexcept { return 60 - paddingDepth_; }

  /// World coordinate of plane `index` of the lattice of `level` (>= 0). Planes shared by cells of different
  /// levels get the same bits.
  double worldPlane(int axis, Coord index, int level) const noexcept;
  /// `count` planes from `first` on; those beyond the domain are its last.
  void worldPlanes(int axis, Coord first, int level, int count, double* planes) const noexcept;
  /// Planes of a node at an octree depth; above the roots they are clamped to the domain.
  double nodePlane(int axis, Coord index, int depth) const noexcept;
  /// By these planes.
  Bounds nodeBounds(const std::array<Coord, 3>& index, int depth) const noexcept;
  /// Lattice coordinate in units of roots, in [0, N]; NaN outside the closed domain.
  double latticeCoordinate(int axis, double world) const noexcept;
  /// Of all roots.
  Bounds bounds() const noexcept;

private:
  std::array<int, 3> roots_{};
  int paddingDepth_ = 0;
  std::array<std::vector<double>, 3> planes_;
};

} // namespace treeamr

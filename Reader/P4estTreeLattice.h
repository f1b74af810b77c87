// Where the trees of a p4est connectivity sit on one rectilinear lattice, as one vtkHyperTreeGrid needs them.
//
// Each tree must be an axis-aligned box in identity orientation (its axes point along x, y and z) between
// neighbouring planes of the lattice that the boxes of all trees form. Unit cube and brick connectivities are
// such, periodic or not, scaled or stretched along an axis, with trees left out; rotated, twisted and curved
// ones are not.
#pragma once

#include "P4estForestFile.h"

#include <array>
#include <cstdint>
#include <vector>

namespace treeamr
{

class P4estTreeLattice
{
public:
  /// Throws Error naming the file, the tree that does not fit, what was found and what is allowed.
  explicit P4estTreeLattice(const P4estForestFile& file);

  /// World coordinates of the planes per axis, strictly increasing.
  const std::array<std::vector<double>, 3>& planes() const noexcept { return planes_; }
  /// The tree lies between planes()[a][place[a]] and the next.
  const std::array<int, 3>& place(std::int32_t tree) const noexcept { return places_[tree]; }

private:
  using Point = std::array<double, 3>;

  void findTolerances(const P4estForestFile& file);
  void checkBox(const P4estForestFile& file, std::int32_t tree) const;
  void findPlanes(const P4estForestFile& file, int axis);
  void checkPlaces(const P4estForestFile& file) const;

  Point tolerances_{}; // coordinates that differ by less are the same plane
  std::array<std::vector<double>, 3> planes_;
  std::vector<std::array<int, 3>> places_; // per tree
};

} // namespace treeamr

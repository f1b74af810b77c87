// Where the trees of a forest sit on one rectilinear lattice, as one vtkHyperTreeGrid needs them.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace treeamr
{

class TreeLattice
{
public:
  /// planes: world coordinates per axis, strictly increasing. places: of each tree, no two at one.
  TreeLattice(std::array<std::vector<double>, 3> planes, std::vector<std::array<int, 3>> places)
    : planes_(std::move(planes))
    , places_(std::move(places))
  {
  }

  const std::array<std::vector<double>, 3>& planes() const noexcept { return planes_; }
  /// The tree lies between planes()[a][place[a]] and the next.
  const std::array<int, 3>& place(std::int32_t tree) const noexcept { return places_[tree]; }
  std::int32_t treeCount() const noexcept { return static_cast<std::int32_t>(places_.size()); }

private:
  std::array<std::vector<double>, 3> planes_;
  std::vector<std::array<int, 3>> places_;
};

} // namespace treeamr

// Where the trees of a forest sit on one rectilinear lattice, as one vtkHyperTreeGrid needs them.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace treeamr
{

/// At which corner of its box on the lattice each corner, and so each child, of a tree is: bit a is the side along axis
/// a. Any turn or reflection.
using TreeOrientation = std::array<std::uint8_t, 8>;
constexpr TreeOrientation alongAxes{ 0, 1, 2, 3, 4, 5, 6, 7 };

/// Whether each axis of the tree is one of the lattice, in either direction.
constexpr bool isOrientation(const TreeOrientation& corners) noexcept
{
  const int x = corners[1] ^ corners[0];
  const int y = corners[2] ^ corners[0];
  const int z = corners[4] ^ corners[0];
  bool fits = (x | y | z) == 7 && x * y * z == 8; // 1, 2 and 4 in any order
  for (int c = 0; c < 8; ++c)
  {
    fits = fits && corners[c] == (corners[0] ^ (c & 1 ? x : 0) ^ (c & 2 ? y : 0) ^ (c & 4 ? z : 0));
  }
  return fits;
}

class TreeLattice
{
public:
  /// planes: world coordinates per axis, strictly increasing. places: of each tree, no two at one. orientations: of each
  /// tree, or none: all are along the axes.
  TreeLattice(std::array<std::vector<double>, 3> planes, std::vector<std::array<int, 3>> places,
    std::vector<TreeOrientation> orientations = {})
    : planes_(std::move(planes))
    , places_(std::move(places))
    , orientations_(std::move(orientations))
  {
  }

  const std::array<std::vector<double>, 3>& planes() const noexcept { return planes_; }
  /// The tree lies between planes()[a][place[a]] and the next.
  const std::array<int, 3>& place(std::int32_t tree) const noexcept { return places_[tree]; }
  const TreeOrientation& orientation(std::int32_t tree) const noexcept
  {
    return orientations_.empty() ? alongAxes : orientations_[tree];
  }
  std::int32_t treeCount() const noexcept { return static_cast<std::int32_t>(places_.size()); }

private:
  std::array<std::vector<double>, 3> planes_;
  std::vector<std::array<int, 3>> places_;
  std::vector<TreeOrientation> orientations_;
};

} // namespace treeamr

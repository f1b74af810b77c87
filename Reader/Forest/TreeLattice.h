// Where the trees of a forest sit on one rectilinear lattice, as one vtkHyperTreeGrid needs them.
#pragma once

#include "Error.h"
#include "Octree/RootGrid.h"

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
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

/// vtkHyperTreeGrid multiplies the numbers of its roots in 32 bits. Throws Error that begins with the source's name.
inline void checkRootCount(const std::array<std::vector<double>, 3>& planes, const std::string& source)
{
  constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
  std::uint64_t product = 1;
  bool fits = true;
  std::string text;
  for (const std::vector<double>& ofAxis : planes)
  {
    const std::uint64_t roots = ofAxis.size() > 1 ? ofAxis.size() - 1 : 1;
    fits = fits && roots <= most / product;
    product *= fits ? roots : 1;
    text += (text.empty() ? "" : " x ") + std::to_string(roots);
  }
  if (!fits)
  {
    throw Error(source + (source.empty() ? "" : ": ") + "a lattice of " + text + " trees, allowed " +
      std::to_string(most) + " places");
  }
}

class TreeLattice
{
public:
  /// planes: world coordinates per axis, strictly increasing; of a grid in a plane across z a single one there. places: of each tree, no two at one. orientations: of each
  /// tree, or none: all are along the axes.
  TreeLattice(std::array<std::vector<double>, 3> planes, std::vector<std::array<int, 3>> places,
    std::vector<TreeOrientation> orientations = {})
    : planes_(std::move(planes))
    , places_(std::move(places))
    , orientations_(std::move(orientations))
  {
  }

  const std::array<std::vector<double>, 3>& planes() const noexcept { return planes_; }
  int dimension() const noexcept { return planes_[2].size() == 1 ? 2 : 3; }
  /// The tree lies between planes()[a][place[a]] and the next.
  const std::array<int, 3>& place(std::int32_t tree) const noexcept { return places_[tree]; }
  const TreeOrientation& orientation(std::int32_t tree) const noexcept
  {
    return orientations_.empty() ? alongAxes : orientations_[tree];
  }
  std::int32_t treeCount() const noexcept { return static_cast<std::int32_t>(places_.size()); }
  /// Of a node of a tree, at its index along the tree's own axes, in three dimensions.
  CellId cellOf(std::int32_t tree, const std::array<std::uint32_t, 3>& index, int level) const noexcept
  {
    const TreeOrientation& corners = orientation(tree);
    const Coord last = (Coord(1) << level) - 1;
    CellId cell{ {}, level };
    for (int a = 0; a < 3; ++a)
    {
      const int axis =
        std::countr_zero(static_cast<unsigned>(corners[1u << a] ^ corners[0])); // of the lattice
      const Coord along = corners[0] >> axis & 1 ? last - Coord(index[a]) : Coord(index[a]);
      cell.index[axis] = (Coord(place(tree)[axis]) << level) + along;
    }
    return cell;
  }

private:
  std::array<std::vector<double>, 3> planes_;
  std::vector<std::array<int, 3>> places_;
  std::vector<TreeOrientation> orientations_;
};

} // namespace treeamr

#include "Forest/P4estTreeLattice.h"

#include "Error.h"
#include "Forest/P4estTreeLayout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace treeamr
{

namespace
{

using Point = std::array<double, 3>;

/// Corner 0 is at the minimum of all of the tree's own axes, corner 7 at the maximum.
Point corner(const P4estForestFile& file, std::int32_t tree, int corner)
{
  return file.connectivity().vertices[file.connectivity().treeVertices[tree][corner]];
}

template <class... Parts>
[[noreturn]] void fail(const P4estForestFile& file, const Parts&... parts)
{
  std::ostringstream message;
  message.precision(std::numeric_limits<double>::max_digits10);
  message << file.path() << ": ";
  (message << ... << parts);
  throw Error(message.str());
}

/// One tree a place.
void checkPlaces(const P4estForestFile& file, const std::array<std::vector<double>, 3>& planes,
  const std::vector<std::array<int, 3>>& places)
{
  std::array<std::uint64_t, 3> cells;
  for (int axis = 0; axis < 3; ++axis)
  {
    cells[axis] = planes[axis].size() - 1;
  }
  std::vector<std::pair<std::uint64_t, std::int32_t>> taken(places.size());
  for (std::int32_t tree = 0; tree < file.treeCount(); ++tree)
  {
    const std::array<int, 3>& p = places[tree];
    taken[tree] = { p[0] + cells[0] * (p[1] + cells[1] * p[2]), tree };
  }
  std::ranges::sort(taken);
  const auto twice =
    std::ranges::adjacent_find(taken, [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != taken.end())
  {
    fail(
      file, "tree ", twice[1].second, ": at the place of tree ", twice[0].second, ", allowed one of its own");
  }
}

TreeLattice makeLattice(const P4estForestFile& file, std::array<std::vector<double>, 3> planes,
  std::vector<std::array<int, 3>> places, std::vector<TreeOrientation> orientations)
{
  checkRootCount(planes, file.path());
  checkPlaces(file, planes, places);
  if (file.dimension() == 2)
  {
    const auto other =
      std::ranges::find_if(places, [&](const std::array<int, 3>& place) { return place[2] != places[0][2]; });
    if (other != places.end())
    {
      fail(file, "tree ", other - places.begin(), ": at z = ", planes[2][(*other)[2]],
        ", allowed that of tree 0, ", planes[2][places[0][2]], ": rectangles in one plane");
    }
    planes[2].resize(1); // without that over the trees' own
  }
  return { std::move(planes), std::move(places), std::move(orientations) };
}

class LatticeFinder
{
public:
  explicit LatticeFinder(const P4estForestFile& file)
    : file_(file)
    , places_(file.treeCount())
  {
    findTolerances();
    for (std::int32_t tree = 0; tree < file.treeCount(); ++tree)
    {
      checkBox(tree);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      findPlanes(axis);
    }
  }
  TreeLattice take()
  {
    return makeLattice(file_, std::move(planes_), std::move(places_), std::move(orientations_));
  }

private:
  void findTolerances();
  void checkBox(std::int32_t tree);
  void findPlanes(int axis);
  /// The least and the largest coordinate of a tree.
  std::array<double, 2> extent(std::int32_t tree, int axis) const;

  const P4estForestFile& file_;
  Point tolerances_{}; // coordinates that differ by less are the same plane
  std::array<std::vector<double>, 3> planes_;
  std::vector<std::array<int, 3>> places_;    // of each tree
  std::vector<TreeOrientation> orientations_; // none while all are along the axes
};

std::array<double, 2> LatticeFinder::extent(std::int32_t tree, int axis) const
{
  std::array<double, 2> extent{ std::numeric_limits<double>::infinity(),
    -std::numeric_limits<double>::infinity() };
  for (int c = 0; c < 8; ++c)
  {
    const double coordinate = corner(file_, tree, c)[axis];
    if (std::isnan(coordinate))
    {
      return { coordinate, coordinate };
    }
    extent = { std::min(extent[0], coordinate), std::max(extent[1], coordinate) };
  }
  return extent;
}

/// Below the width of the finest quadrant of any p4est a difference shows in no cell; and vertices are the
/// results of a few operations, each of which rounds.
void LatticeFinder::findTolerances()
{
  constexpr double roundings = 4.;
  for (int axis = 0; axis < 3; ++axis)
  {
    double edge = std::numeric_limits<double>::infinity();
    double magnitude = 0.;
    for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
    {
      const auto [min, max] = extent(tree, axis);
      if (!std::isfinite(min) || !std::isfinite(max) || min >= max)
      {
        fail(file_, "tree ", tree, ": from ", min, " to ", max, " along ", "xyz"[axis],
          ", allowed an axis-aligned box");
      }
      edge = std::min(edge, max - min);
      magnitude = std::max({ magnitude, std::abs(min), std::abs(max) });
    }
    tolerances_[axis] = std::max(std::ldexp(edge, -P4estForestFile::maxLevel),
      roundings * std::numeric_limits<double>::epsilon() * magnitude);
  }
}

void LatticeFinder::checkBox(std::int32_t tree)
{
  std::array<std::array<double, 2>, 3> box;
  for (int axis = 0; axis < 3; ++axis)
  {
    box[axis] = extent(tree, axis);
  }
  TreeOrientation orientation{};
  for (int c = 0; c < 8; ++c)
  {
    const Point found = corner(file_, tree, c);
    for (int axis = 0; axis < 3; ++axis)
    {
      const bool isUpper = found[axis] - box[axis][0] > box[axis][1] - found[axis];
      orientation[c] |= static_cast<std::uint8_t>(isUpper << axis);
      if (!(std::abs(found[axis] - box[axis][isUpper]) <= tolerances_[axis]))
      {
        fail(file_, "tree ", tree, ": corner ", c, " at (", found[0], ", ", found[1], ", ", found[2], "), ",
          "xyz"[axis], " allowed ", box[axis][0], " or ", box[axis][1], ": an axis-aligned box");
      }
    }
  }
  if (!isOrientation(orientation))
  {
    fail(file_, "tree ", tree,
      ": its corners are those of a box in another order, allowed orders by a turn or a reflection");
  }
  if (orientation != alongAxes || !orientations_.empty())
  {
    orientations_.resize(places_.size(), alongAxes);
    orientations_[tree] = orientation;
  }
}

void LatticeFinder::findPlanes(int axis)
{
  std::vector<double>& planes = planes_[axis];
  planes.reserve(2 * places_.size());
  for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
  {
    const auto [min, max] = extent(tree, axis);
    planes.push_back(min);
    planes.push_back(max);
  }
  std::ranges::sort(planes);
  // The first of equal ones stays; std::unique compares with the one that stayed.
  const auto same = [&](double a, double b) { return b - a <= tolerances_[axis]; };
  planes.erase(std::unique(planes.begin(), planes.end(), same), planes.end());

  const auto planeOf = [&](double coordinate) {
    return static_cast<int>(std::ranges::upper_bound(planes, coordinate) - planes.begin()) - 1;
  };
  for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
  {
    const auto [min, max] = extent(tree, axis);
    places_[tree][axis] = planeOf(min);
    if (planeOf(max) != planeOf(min) + 1)
    {
      fail(file_, "tree ", tree, ": from ", min, " to ", max, " along ", "xyz"[axis], " spans ",
        planeOf(max) - planeOf(min), " cells of the lattice that all trees form, allowed 1");
    }
  }
}

TreeLattice latticeOfBoxes(const P4estForestFile& file, const UnitBoxes& boxes)
{
  TreeLayout layout = layOutTrees(file);
  std::array<std::vector<double>, 3> planes;
  for (int axis = 0; axis < 3; ++axis)
  {
    const double spacing = boxes.spacing[axis];
    const double origin = boxes.origin[axis];
    if (!(spacing > 0.) || !std::isfinite(spacing) || !std::isfinite(origin))
    {
      fail(file, "trees without vertices along ", "xyz"[axis], " from ", origin, ", each ", spacing,
        " wide, allowed a finite origin and a positive spacing");
    }
    for (int i = 0; i <= layout.size[axis]; ++i)
    {
      planes[axis].push_back(origin + i * spacing);
      if (i > 0 && !(planes[axis][i] > planes[axis][i - 1]))
      {
        fail(file, "trees without vertices along ", "xyz"[axis], " from ", origin, ", each ", spacing,
          " wide, allowed widths that double can tell from the origin");
      }
    }
  }
  return makeLattice(file, std::move(planes), std::move(layout.places), std::move(layout.orientations));
}

} // namespace

TreeLattice p4estTreeLattice(const P4estForestFile& file, const UnitBoxes& boxes)
{
  return file.connectivity().vertices.empty() ? latticeOfBoxes(file, boxes) : LatticeFinder(file).take();
}

} // namespace treeamr

#include "Forest/P4estTreeLattice.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace treeamr
{

namespace
{

using Point = std::array<double, 3>;

/// Corner 0 is at the minimum of all axes, corner 7 at the maximum.
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

class LatticeFinder
{
public:
  explicit LatticeFinder(const P4estForestFile& file)
    : file_(file)
    , places_(file.treeCount())
  {
    if (file.connectivity().vertices.empty())
    {
      fail(file, "the connectivity has no vertices, allowed one whose vertices say where the trees are");
    }
    findTolerances();
    for (std::int32_t tree = 0; tree < file.treeCount(); ++tree)
    {
      checkBox(tree);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      findPlanes(axis);
    }
    checkPlaces();
  }
  TreeLattice take() { return { std::move(planes_), std::move(places_) }; }

private:
  void findTolerances();
  void checkBox(std::int32_t tree) const;
  void findPlanes(int axis);
  void checkPlaces() const;

  const P4estForestFile& file_;
  Point tolerances_{}; // coordinates that differ by less are the same plane
  std::array<std::vector<double>, 3> planes_;
  std::vector<std::array<int, 3>> places_; // of each tree
};

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
      const double min = corner(file_, tree, 0)[axis];
      const double max = corner(file_, tree, 7)[axis];
      if (!std::isfinite(min) || !std::isfinite(max) || min >= max)
      {
        fail(file_, "tree ", tree, ": from ", min, " to ", max, " along ", "xyz"[axis],
          ", allowed an axis-aligned box in identity orientation");
      }
      edge = std::min(edge, max - min);
      magnitude = std::max({ magnitude, std::abs(min), std::abs(max) });
    }
    tolerances_[axis] = std::max(std::ldexp(edge, -P4estForestFile::maxLevel),
      roundings * std::numeric_limits<double>::epsilon() * magnitude);
  }
}

void LatticeFinder::checkBox(std::int32_t tree) const
{
  const std::array<Point, 2> box = { corner(file_, tree, 0), corner(file_, tree, 7) };
  for (int c = 1; c < 7; ++c)
  {
    const Point found = corner(file_, tree, c);
    const Point allowed = { box[c & 1][0], box[c >> 1 & 1][1], box[c >> 2][2] };
    for (int axis = 0; axis < 3; ++axis)
    {
      if (!(std::abs(found[axis] - allowed[axis]) <= tolerances_[axis]))
      {
        fail(file_, "tree ", tree, ": corner ", c, " at (", found[0], ", ", found[1], ", ", found[2],
          "), allowed (", allowed[0], ", ", allowed[1], ", ", allowed[2],
          "): an axis-aligned box in identity orientation");
      }
    }
  }
}

void LatticeFinder::findPlanes(int axis)
{
  std::vector<double>& planes = planes_[axis];
  planes.reserve(2 * places_.size());
  for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
  {
    planes.push_back(corner(file_, tree, 0)[axis]);
    planes.push_back(corner(file_, tree, 7)[axis]);
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
    const double min = corner(file_, tree, 0)[axis];
    const double max = corner(file_, tree, 7)[axis];
    places_[tree][axis] = planeOf(min);
    if (planeOf(max) != planeOf(min) + 1)
    {
      fail(file_, "tree ", tree, ": from ", min, " to ", max, " along ", "xyz"[axis], " spans ",
        planeOf(max) - planeOf(min), " cells of the lattice that all trees form, allowed 1");
    }
  }
}

/// One tree a place; and vtkHyperTreeGrid multiplies the numbers of places in 32 bits.
void LatticeFinder::checkPlaces() const
{
  std::array<std::uint64_t, 3> cells;
  for (int axis = 0; axis < 3; ++axis)
  {
    cells[axis] = planes_[axis].size() - 1;
  }
  constexpr std::uint64_t maxPlaces = std::numeric_limits<std::uint32_t>::max();
  if (cells[0] * cells[1] > maxPlaces || cells[0] * cells[1] * cells[2] > maxPlaces)
  {
    fail(file_, "a lattice of ", cells[0], " x ", cells[1], " x ", cells[2], " trees, allowed ", maxPlaces,
      " places");
  }
  std::vector<std::pair<std::uint64_t, std::int32_t>> taken(places_.size());
  for (std::int32_t tree = 0; tree < file_.treeCount(); ++tree)
  {
    const std::array<int, 3>& p = places_[tree];
    taken[tree] = { p[0] + cells[0] * (p[1] + cells[1] * p[2]), tree };
  }
  std::ranges::sort(taken);
  const auto twice =
    std::ranges::adjacent_find(taken, [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != taken.end())
  {
    fail(file_, "tree ", twice[1].second, ": at the place of tree ", twice[0].second,
      ", allowed one of its own");
  }
}

} // namespace

TreeLattice p4estTreeLattice(const P4estForestFile& file)
{
  return LatticeFinder(file).take();
}

} // namespace treeamr

#include "Octree/RootGrid.h"

#include "Error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace treeamr
{

namespace
{
constexpr int maxRootsPerAxis = 1 << 24;
}

RootGrid::RootGrid(std::array<std::vector<double>, 3> planes)
  : planes_(std::move(planes))
{
  int widest = 1;
  for (int a = 0; a < 3; ++a)
  {
    const auto& p = planes_[a];
    const std::string axis(1, "xyz"[a]);
    if (p.size() < 2 || p.size() - 1 > static_cast<std::size_t>(maxRootsPerAxis))
    {
      throw Error("root grid: " + std::to_string(p.size()) + " coordinates along " + axis +
        ", allowed are 2 to " + std::to_string(maxRootsPerAxis + 1));
    }
    for (std::size_t i = 0; i < p.size(); ++i)
    {
      if (!std::isfinite(p[i]) || (i > 0 && !(p[i] > p[i - 1])) || !std::isfinite(p[i] - p[0]))
      {
        throw Error("root grid: coordinate " + std::to_string(i) + " along " + axis + " is " +
          std::to_string(p[i]) + "; coordinates must be finite and strictly increasing");
      }
    }
    roots_[a] = static_cast<int>(p.size()) - 1;
    widest = std::max(widest, roots_[a]);
  }
  while ((1 << paddingDepth_) < widest)
  {
    ++paddingDepth_;
  }
}

RootGrid RootGrid::uniform(
  std::array<int, 3> roots, std::array<double, 3> origin, std::array<double, 3> rootSize)
{
  for (int a = 0; a < 3; ++a)
  {
    if (roots[a] < 1 || roots[a] > maxRootsPerAxis)
    {
      throw Error("root grid: " + std::to_string(roots[a]) + " roots along " + "xyz"[a] +
        ", allowed are 1 to " + std::to_string(maxRootsPerAxis));
    }
  }
  std::array<std::vector<double>, 3> planes;
  for (int a = 0; a < 3; ++a)
  {
    planes[a].reserve(static_cast<std::size_t>(roots[a]) + 1);
    for (int i = 0; i <= roots[a]; ++i)
    {
      planes[a].push_back(origin[a] + i * rootSize[a]);
    }
  }
  return RootGrid(std::move(planes));
}

bool RootGrid::isUniform() const noexcept
{
  for (const std::vector<double>& p : planes_)
  {
    const auto roots = static_cast<double>(p.size() - 1);
    const double rounding = 4. * std::numeric_limits<double>::epsilon() *
      std::max({ std::abs(p.front()), std::abs(p.back()), p.back() - p.front() });
    for (std::size_t i = 1; i + 1 < p.size(); ++i)
    {
      const double even = p.front() + static_cast<double>(i) / roots * (p.back() - p.front());
      if (!(std::abs(p[i] - even) <= rounding))
      {
        return false;
      }
    }
  }
  return true;
}

double RootGrid::worldPlane(int axis, Coord index, int level) const noexcept
{
  const auto& p = planes_[axis];
  const Coord last = roots_[axis];
  const Coord root = std::min(index >> level, last);
  const Coord rest = index - (root << level);
  if (rest == 0)
  {
    return p[root];
  }
  const double fraction = static_cast<double>(rest) / static_cast<double>(Coord(1) << level);
  return p[root] + fraction * (p[root + 1] - p[root]);
}

void RootGrid::worldPlanes(int axis, Coord first, int level, int count, double* planes) const noexcept
{
  const auto& p = planes_[axis];
  const Coord last = roots_[axis];
  const Coord perRoot = Coord(1) << level;
  const double part = 1. / static_cast<double>(perRoot); // exact, as its product with a plane's rest is
  Coord root = first >> level;
  Coord rest = first - (root << level);
  for (int i = 0; i < count; ++i)
  {
    planes[i] = root >= last ? p[last]
      : rest == 0            ? p[root]
                             : p[root] + static_cast<double>(rest) * part * (p[root + 1] - p[root]);
    if (++rest == perRoot)
    {
      rest = 0;
      ++root;
    }
  }
}

double RootGrid::nodePlane(int axis, Coord index, int depth) const noexcept
{
  if (depth >= paddingDepth_)
  {
    return worldPlane(axis, index, depth - paddingDepth_);
  }
  const Coord root = std::min<Coord>(index << (paddingDepth_ - depth), roots_[axis]);
  return planes_[axis][root];
}

Bounds RootGrid::nodeBounds(const std::array<Coord, 3>& index, int depth) const noexcept
{
  Bounds b;
  for (int a = 0; a < 3; ++a)
  {
    b.min[a] = nodePlane(a, index[a], depth);
    b.max[a] = nodePlane(a, index[a] + 1, depth);
  }
  return b;
}

double RootGrid::latticeCoordinate(int axis, double world) const noexcept
{
  const auto& p = planes_[axis];
  if (!(world >= p.front() && world <= p.back()))
  {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto upper = std::upper_bound(p.begin(), p.end() - 1, world);
  const auto i = upper - p.begin() - 1;
  return static_cast<double>(i) + (world - p[i]) / (p[i + 1] - p[i]);
}

Bounds RootGrid::bounds() const noexcept
{
  Bounds b;
  for (int a = 0; a < 3; ++a)
  {
    b.min[a] = planes_[a].front();
    b.max[a] = planes_[a].back();
  }
  return b;
}

} // namespace treeamr

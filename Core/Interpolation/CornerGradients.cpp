#include "Interpolation/CornerGradients.h"

#include <cmath>

namespace treeamr
{

CornerGradients::CornerGradients(const Field& field)
  : corners_(*field.corners())
  , octree_(field.octree())
  , levels_(std::make_unique<Level[]>(octree_.innerDepths() + 1))
{
}

/// Of a child of the nodes of a depth.
double CornerGradients::width(int axis, Coord index, int depth) const noexcept
{
  // Not between planes, which may have lost digits far from the origin.
  const RootGrid& grid = octree_.grid();
  const int level = depth + 1 - grid.paddingDepth();
  const Coord root = index >> level;
  return std::ldexp(grid.worldPlane(axis, root + 1, 0) - grid.worldPlane(axis, root, 0), -level);
}

Vec3 CornerGradients::inOnlyLeaf(int vertex) const noexcept
{
  const CornerValues::Family family = corners_.onlyLeaf();
  const CornerPlace at = placeOfCorner(vertex);
  Vec3 gradient;
  for (int a = 0; a < 3; ++a)
  {
    const int low = vertex - at[a] * familyStride[a];
    gradient[a] = (static_cast<double>(family[low + familyStride[a]]) - family[low]) / this->width(a, 0, -1);
  }
  return gradient;
}

Vec3 CornerGradients::gradient(const TreePath& path, int depth, int vertex) noexcept
{
  Level& level = levels_[depth];
  const std::uint64_t node = path.around(depth)[13].index();
  if (level.node != node)
  {
    level.node = node;
    level.known = 0;
  }
  if (!(level.known >> vertex & 1))
  {
    // Recursion reaches coarser levels only: this one keeps its node.
    level.gradient[vertex] = this->compute(path, depth, placeOfCorner(vertex));
    level.known |= 1u << vertex;
  }
  return level.gradient[vertex];
}

Vec3 CornerGradients::compute(const TreePath& path, int depth, const CornerPlace& at) noexcept
{
  Vec3 gradient{};
  if (!touchesCoarser(path, depth, at))
  {
    for (int a = 0; a < 3; ++a)
    {
      gradient[a] = this->slope(path, depth, a, at);
    }
    return gradient;
  }
  const int count = forCoarserCorners(path, depth, at, [&](int vertex) {
    const Vec3 one = this->gradient(path, depth - 1, vertex);
    for (int a = 0; a < 3; ++a)
    {
      gradient[a] += one[a];
    }
  });
  for (double& slope : gradient)
  {
    slope /= count;
  }
  return gradient;
}

double CornerGradients::slope(const TreePath& path, int depth, int axis, const CornerPlace& at) const noexcept
{
  std::optional<double> low = this->valueBeside(path, depth, axis, 0, at);
  std::optional<double> high = this->valueBeside(path, depth, axis, 1, at);
  const Coord index = 2 * path.index(depth)[axis] + at[axis];
  const double below = low ? this->width(axis, index - 1, depth) : 0.;
  const double above = high ? this->width(axis, index, depth) : 0.;
  low = low ? low : this->valueAt(path, depth, at);
  high = high ? high : this->valueAt(path, depth, at);
  return low && high ? (*high - *low) / (below + above) : 0.;
}

std::optional<double> CornerGradients::valueAt(
  const TreePath& path, int depth, const CornerPlace& at) const noexcept
{
  std::optional<double> value;
  for (int side = 0; side < 8 && !value; ++side)
  {
    value = this->valueIn(path, depth, cellBeside(at, side), 7 - side);
  }
  return value;
}

/// One width of a child away, along an axis, from the first of the cells there that touch both.
std::optional<double> CornerGradients::valueBeside(
  const TreePath& path, int depth, int axis, int side, const CornerPlace& at) const noexcept
{
  std::optional<double> value;
  for (int cell = 0; cell < 8 && !value; ++cell)
  {
    if (sideOf(cell, axis) == side)
    {
      value = this->valueIn(path, depth, cellBeside(at, cell), (7 - cell) ^ 1 << axis);
    }
  }
  return value;
}

/// At a corner of a cell of the children's size, which no coarser leaf covers, of the leaf that touches it from inside.
std::optional<double> CornerGradients::valueIn(
  const TreePath& path, int depth, const std::array<int, 3>& cell, int corner) const noexcept
{
  const ChildPlace place(cell);
  NodeRef parent = path.around(depth)[place.entry];
  if (!parent.isInner())
  {
    return {};
  }
  CornerValues::Family family = corners_.family(path, depth, place.entry);
  int octant = place.octant;
  NodeRef node = octree_.child(parent, octant);
  while (node.isInner())
  {
    family = corners_.family(node.depth(), node.index(), parent.index(), octant);
    octant = corner;
    parent = node;
    node = octree_.child(node, corner);
  }
  return node.isLeaf() ? std::make_optional<double>(
                           family[cornerOffset(octant, familyStride) + cornerOffset(corner, familyStride)])
                       : std::nullopt;
}

} // namespace treeamr

#include "Contour/DualCells.h"

#include "Interpolation/VertexValues.h"

#include <cmath>

namespace treeamr
{

namespace
{

/// Whether the planes at both sides of a lattice plane of a depth lie equally far away, but for rounding.
bool isEvenAt(const RootGrid& grid, int axis, Coord index, int depth) noexcept
{
  const int level = depth - grid.paddingDepth();
  const Coord root = index >> level;
  if ((root << level) != index || root <= 0 || root >= grid.roots()[axis])
  {
    return true;
  }
  const double plane = grid.worldPlane(axis, root, 0);
  const double below = plane - grid.worldPlane(axis, root - 1, 0);
  const double above = grid.worldPlane(axis, root + 1, 0) - plane;
  return std::abs(above - below) <= 1e-9 * below;
}

} // namespace

void DualCells::find(const TreePath& path, const Field& field)
{
  gatherBlocks(path, field);
  mark(field.octree().grid(), path);
}

void DualCells::gatherBlocks(const TreePath& path, const Field& field)
{
  const Octree& octree = field.octree();
  plain_ = 0;
  const Neighbourhood& around = path.around(path.depth());
  for (int e = 0; e < 27; ++e)
  {
    if (!around[e].isInner())
    {
      continue;
    }
    const Octree::Children children = octree.children(around[e].index());
    bool plain = children.allLeaves();
    for (int o = 0; plain && o < 8; ++o)
    {
      plain = !octree.isGhost(children.firstLeaf + o);
      const std::array<int, 3> cell{ 2 * (e % 3) + sideOf(o, 0) - 1, 2 * (e / 3 % 3) + sideOf(o, 1) - 1,
        2 * (e / 9) + sideOf(o, 2) - 1 }; // from the first of the four
      const auto isNear = [](int c) { return c >= 0 && c < 4; };
      if (isNear(cell[0]) && isNear(cell[1]) && isNear(cell[2]))
      {
        leafValues_[cell[0] + 4 * cell[1] + 16 * cell[2]] = field.leafValues()[children.firstLeaf + o];
      }
    }
    plain_ |= static_cast<std::uint32_t>(plain) << e;
  }
}

void DualCells::mark(const RootGrid& grid, const TreePath& path) noexcept
{
  std::array<unsigned, 3> even{}; // vertices' coordinates, a bit each
  for (int a = 0; a < 3; ++a)
  {
    for (int i = 0; i < 5; ++i)
    {
      even[a] |= static_cast<unsigned>(isEvenAt(grid, a, 2 * path.index()[a] + i - 1, path.depth() + 1)) << i;
    }
  }
  for (int z = 0; z < 5; ++z)
  {
    for (int y = 0; y < 5; ++y)
    {
      // Rows of the blocks on either side of the vertices.
      const auto row = [&](int i, int j) { return plain_ >> (3 * i + 9 * j) & 7; };
      const int y0 = y / 2;
      const int y1 = (y + 1) / 2;
      const unsigned blocks = row(y0, z / 2) & row(y1, z / 2) & row(y0, (z + 1) / 2) & row(y1, (z + 1) / 2);
      const unsigned both = blocks & blocks >> 1;
      const unsigned xs =
        (blocks & 1) | (both & 1) << 1 | (blocks & 2) << 1 | (both & 2) << 2 | (blocks & 4) << 2;
      const bool isEven = (even[1] >> y & 1) && (even[2] >> z & 1);
      has_[y + 5 * z] = isEven ? static_cast<std::uint8_t>(xs & even[0]) : 0;
    }
  }
}

std::array<float, 8> DualCells::values(const std::array<int, 3>& vertex) const noexcept
{
  constexpr std::array<int, 3> leafStride{ 1, 4, 16 };
  const int first = vertex[0] + leafStride[1] * vertex[1] + leafStride[2] * vertex[2];
  std::array<float, 8> values;
  for (int c = 0; c < 8; ++c)
  {
    values[c] = leafValues_[first + cornerOffset(c, leafStride)];
  }
  return values;
}

bool ownsDualCell(
  const std::array<int, 3>& vertex, const std::array<float, 8>& values, double isovalue) noexcept
{
  std::array<double, 27> v;
  for (int i = 0; i < 8; ++i)
  {
    v[2 * cornerOffset(i, leafVertexStride)] = values[i];
  }
  for (const int i : { 0, 6, 18, 24 })
  {
    v[i + 1] = 0.5 * (v[i] + v[i + 2]);
  }
  for (const int i : { 0, 1, 2, 18, 19, 20 })
  {
    v[i + 3] = 0.5 * (v[i] + v[i + 6]);
  }
  for (int i = 0; i < 9; ++i)
  {
    v[i + 9] = 0.5 * (v[i] + v[i + 18]);
  }
  unsigned inside = 0;
  for (int i = 0; i < 27; ++i)
  {
    inside |= static_cast<unsigned>(static_cast<float>(v[i]) >= isovalue) << i;
  }
  for (int o = 0; o < 8; ++o)
  {
    constexpr unsigned corners = 1 | 1 << 1 | 1 << 3 | 1 << 4 | 1 << 9 | 1 << 10 | 1 << 12 | 1 << 13;
    const unsigned mine = inside >> cornerOffset(o, leafVertexStride) & corners;
    if (mine != 0 && mine != corners)
    {
      const auto isOwn = [&](int a) { return ((vertex[a] - 1 + sideOf(o, a)) & ~1) == 0; };
      return isOwn(0) && isOwn(1) && isOwn(2);
    }
  }
  return false;
}

} // namespace treeamr

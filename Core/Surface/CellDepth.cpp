#include "Surface/CellDepth.h"

#include <algorithm>
#include <cmath>

namespace treeamr
{

namespace
{

double worldLength(const Matrix4& worldFromData, const Vec3& v) noexcept
{
  double squared = 0.;
  for (int r = 0; r < 3; ++r)
  {
    const double* row = worldFromData.data() + 4 * r;
    squared += std::pow(row[0] * v[0] + row[1] * v[1] + row[2] * v[2], 2);
  }
  return std::sqrt(squared);
}

double widestRoot(const RootGrid& grid, const Matrix4& worldFromData) noexcept
{
  double width = 0.;
  for (int a = 0; a < 3; ++a)
  {
    double edge = 0.;
    for (int i = 0; i < grid.roots()[a]; ++i)
    {
      edge = std::max(edge, grid.worldPlane(a, i + 1, 0) - grid.worldPlane(a, i, 0));
    }
    Vec3 along{};
    along[a] = edge;
    width = std::max(width, worldLength(worldFromData, along));
  }
  return width;
}

/// Where the domain is nearest.
double pixelWidth(const Camera& camera, const Bounds& domain) noexcept
{
  const auto length = [&](const Vec3& v) { return worldLength(camera.worldFromData(), v); };
  if (camera.isPerspective())
  {
    Vec3 toNearest;
    for (int a = 0; a < 3; ++a)
    {
      toNearest[a] = std::clamp(camera.eye()[a], domain.min[a], domain.max[a]) - camera.eye()[a];
    }
    const PixelFan fan = camera.fan();
    return length(toNearest) * std::min(length(fan.perX), length(fan.perY));
  }
  const Vec3 first = camera.ray(0, 0).origin;
  const auto lengthOfStep = [&](int x, int y) {
    const Vec3 next = camera.ray(x, y).origin;
    return length({ next[0] - first[0], next[1] - first[1], next[2] - first[2] });
  };
  return std::min(lengthOfStep(1, 0), lengthOfStep(0, 1));
}

} // namespace

int cellDepthFor(const Octree& octree, const Camera& camera, double pixels)
{
  const int leaves = octree.leafLevels() - 1;
  const double width = widestRoot(octree.grid(), camera.worldFromData());
  const double most = pixels * pixelWidth(camera, octree.grid().bounds());
  int depth = 0;
  while (depth < leaves && !(std::ldexp(width, -depth) <= most))
  {
    ++depth;
  }
  return depth;
}

} // namespace treeamr

#include "Support/ExactCells.h"

#include <algorithm>
#include <cmath>

namespace treeamr::test
{

std::vector<CellPart> partsOfRay(
  const RootGrid& grid, const std::vector<LeafCell>& cells, const Camera& camera, int x, int y)
{
  const Ray ray = camera.ray(x, y);
  std::vector<CellPart> parts;
  for (const LeafCell& leaf : cells)
  {
    const Bounds box = grid.nodeBounds(leaf.cell.index, grid.paddingDepth() + leaf.cell.level);
    double begin = camera.tFromDepth(ray, 0.);
    double end = camera.tFromDepth(ray, 1.);
    for (int a = 0; a < 3; ++a)
    {
      const double low = (box.min[a] - ray.origin[a]) / ray.direction[a];
      const double high = (box.max[a] - ray.origin[a]) / ray.direction[a];
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
    if (begin < end)
    {
      parts.push_back({ begin, end, leaf.value });
    }
  }
  std::sort(
    parts.begin(), parts.end(), [](const CellPart& a, const CellPart& b) { return a.begin < b.begin; });
  return parts;
}

std::array<double, 4> lightOf(
  const std::vector<CellPart>& parts, const std::function<TransferFunction::Entry(float)>& entryOf)
{
  double passes = 1.;
  std::array<double, 4> light{};
  for (const CellPart& part : parts)
  {
    const TransferFunction::Entry entry = entryOf(part.value);
    const double held = -std::expm1(-entry.extinction * (part.end - part.begin));
    const std::array<double, 4> emitted{ entry.r, entry.g, entry.b, 1. };
    for (int c = 0; c < 4; ++c)
    {
      light[c] += passes * held * emitted[c];
    }
    passes *= 1. - held;
  }
  return light;
}

} // namespace treeamr::test

#include "Interpolation/GradientCache.h"

#include "Geometry/Bounds.h"

#include <algorithm>
#include <cmath>
#include <new>

namespace treeamr
{

BlockGradientRecord::BlockGradientRecord(
  const BlockGradients& gradients, const BlockVertices& vertices, double scale) noexcept
{
  // By axis; none of vertices that were not asked for.
  std::array<std::array<double, block::vertexCount>, 3> slopes{};
  forEachVertex(vertices, [&](int v) {
    for (int a = 0; a < 3; ++a)
    {
      const double slope = gradients[v][a] * scale;
      slopes[a][v] = std::isfinite(slope) ? slope : 0.;
    }
  });
  double largest = 0.;
  for (const auto& ofAxis : slopes)
  {
    for (const double slope : ofAxis)
    {
      largest = std::max(largest, std::abs(slope));
    }
  }
  length = static_cast<float>(largest / most);
  const double perLength = largest > 0. ? most / largest : 0.;
  for (int a = 0; a < 3; ++a)
  {
    steps[a].fill(static_cast<std::uint16_t>(zero));
    for (int v = 0; v < block::vertexCount; ++v)
    {
      // Rounded: what is cut off is positive.
      steps[a][v] = static_cast<std::uint16_t>(static_cast<int>(slopes[a][v] * perLength + (zero + 0.5)));
    }
  }
}

const BlockGradientRecord* GradientCache::keep(
  std::uint64_t inner, BlockCells cells, const BlockGradientRecord& record)
{
  const auto [chunk, index] = store_.keep(inner, cells,
    [&](Chunk& into, std::uint32_t at) { new (&into.records[at]) BlockGradientRecord(record); });
  return chunk ? &chunk->records[index] : nullptr;
}

double GradientCache::scaleOf(const Field& field) noexcept
{
  const double width = static_cast<double>(field.range().max) - field.range().min;
  return width > 0. ? diagonalOf(field.octree().grid().bounds()) / width : 0.;
}

} // namespace treeamr

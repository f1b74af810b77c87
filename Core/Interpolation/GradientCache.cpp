#include "Interpolation/GradientCache.h"

#include "Geometry/Bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>

namespace treeamr
{

BlockGradientRecord::BlockGradientRecord(
  const BlockGradients& gradients, const BlockVertices& vertices, double scale) noexcept
{
  const auto forAll = [&](const auto& f) {
    for (int z = 0; z < block::verticesPerEdge; ++z)
    {
      for (std::uint32_t rest = vertices[z]; rest != 0; rest &= rest - 1)
      {
        f(static_cast<std::size_t>(std::countr_zero(rest) + block::vertexStride[2] * z));
      }
    }
  };
  const auto scaled = [&](std::size_t v, int axis) {
    const double slope = gradients[v][axis] * scale;
    return std::isfinite(slope) ? slope : 0.;
  };
  double largest = 0.;
  forAll([&](std::size_t v) {
    for (int a = 0; a < 3; ++a)
    {
      largest = std::max(largest, std::abs(scaled(v, a)));
    }
  });
  length = static_cast<float>(largest / most);
  const double perLength = largest > 0. ? most / largest : 0.;
  for (auto& ofAxis : steps)
  {
    ofAxis.fill(static_cast<std::uint16_t>(zero));
  }
  forAll([&](std::size_t v) {
    for (int a = 0; a < 3; ++a)
    {
      steps[a][v] = static_cast<std::uint16_t>(zero + std::nearbyint(scaled(v, a) * perLength));
    }
  });
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

#include "Interpolation/GradientCache.h"

#include "Geometry/Bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
  const auto length = static_cast<float>(largest / most);
  const double perLength = largest > 0. ? most / largest : 0.;
  for (int a = 0; a < 3; ++a)
  {
    steps[a].fill(0);
    for (int v = 0; v < block::vertexCount; ++v)
    {
      // Rounded: what is cut off is positive.
      constexpr int up = most + 1;
      steps[a][v] =
        static_cast<std::int16_t>(static_cast<int>(slopes[a][v] * perLength + (up + 0.5)) - up);
    }
  }
  std::memcpy(&steps[0][block::vertexCount + 1], &length, sizeof(length));
  findLeast();
}

/// Between vertices a gradient is nowhere shorter than along any one direction the shortest of the vertices'.
void BlockGradientRecord::findLeast() noexcept
{
  std::array<std::uint8_t, 8> least{};
  for (int child = 0; child < 8; ++child)
  {
    const int first = 2 * (child & 1) + 10 * (child >> 1 & 1) + 50 * (child >> 2);
    const auto forVertices = [&](const auto& f) {
      for (int v = 0; v < 27; ++v)
      {
        f(first + v % 3 + 5 * (v / 3 % 3) + 25 * (v / 9));
      }
    };
    std::array<float, 3> mean{};
    forVertices([&](int v) {
      for (int a = 0; a < 3; ++a)
      {
        mean[a] += steps[a][v];
      }
    });
    const float length = std::sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]);
    float shortest = length > 0.f ? std::numeric_limits<float>::max() : 0.f;
    forVertices([&](int v) {
      const float along = mean[0] * steps[0][v] + mean[1] * steps[1][v] + mean[2] * steps[2][v];
      shortest = std::min(shortest, along / length);
    });
    constexpr float rounding = 0.999f; // far more than what sums and samples lose
    const float parts = length > 0.f ? rounding * leastParts / most * std::max(shortest, 0.f) : 0.f;
    least[child] = static_cast<std::uint8_t>(parts); // 3^(1/2) leastParts at most
  }
  std::memcpy(&steps[1][block::vertexCount], least.data(), 6);
  std::memcpy(&steps[2][block::vertexCount], least.data() + 6, 2);
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

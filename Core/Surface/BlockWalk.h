// A ray through the octants of a block of leaves, and the field along it.
#pragma once

#include "Geometry/Trilinear.h"
#include "Surface/CubicRoot.h"
#include "Surface/SurfaceBlocks.h"
#include "Surface/SurfaceGradients.h"
#include "Surface/TraceSpace.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace treeamr
{

/// The planes of a block's octants.
struct BlockPlanes
{
  std::array<std::array<double, 5>, 3> at;
  std::array<std::array<double, 4>, 3> inverseWidth; // of the octants between them
  bool isUniform; // then widths are powers of 2 and planes multiples of them

  BlockPlanes() noexcept = default;
  BlockPlanes(const TraceSpace& space, const SurfaceBlock& block) noexcept
    : isUniform(space.isUniform())
  {
    const int level = block.depth() + 2 - space.paddingDepth();
    const auto perUnit = static_cast<double>(Coord(1) << level);
    for (int a = 0; a < 3; ++a)
    {
      space.planes(a, 4 * block.index(a), level, at[a]);
      for (int i = 0; i < 4; ++i)
      {
        inverseWidth[a][i] = space.isUniform() ? perUnit : 1. / (at[a][i + 1] - at[a][i]);
      }
    }
  }
};

/// The part of a ray in an octant.
struct OctantCrossing
{
  int octant; // x + 4 y + 16 z
  double t0;
  double t1;
  Vec3 from; // places at t0 and t1, 0 to 1 in the octant
  Vec3 to;

  OctantCrossing(
    const BlockPlanes& planes, const SlabRay& ray, int octantOfBlock, double tIn, double tOut) noexcept
    : octant(octantOfBlock)
    , t0(tIn)
    , t1(tOut)
  {
    for (int a = 0; a < 3; ++a)
    {
      const int cell = octant >> 2 * a & 3;
      const double inverse = planes.inverseWidth[a][cell];
      const double origin = ray.origin[a] - planes.at[a][cell];
      from[a] = std::clamp((origin + t0 * ray.direction[a]) * inverse, 0., 1.);
      to[a] = std::clamp((origin + t1 * ray.direction[a]) * inverse, 0., 1.);
    }
  }
  /// The place a part s of the way from t0 to t1.
  Vec3 place(double s) const noexcept
  {
    return { from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1]),
      from[2] + s * (to[2] - from[2]) };
  }
};

/// Calls visit(crossing) for the active octants along [t0, t1] of the ray, near to far, until it returns false or
/// a crossing would start beyond `limit`, which visit() may lower. Octants that share a face, of one block or of
/// two, get the same t for it, so that no part of the ray is lost between them.
template <class Visit>
void walkBlock(const BlockPlanes& planes, std::uint64_t active, const SlabRay& ray, double t0, double t1,
  const double& limit, const Visit& visit)
{
  // By axis; indexed by constants below, so that they stay in registers.
  std::array<std::array<double, 5>, 3> planeT; // in the order that the ray crosses the planes
  std::array<double, 3> next;                  // of them
  std::array<int, 3> passed;                   // octants
  std::array<int, 3> cell{};
  std::array<int, 3> step; // of the cell; 0: the ray stays in it
  for (int a = 0; a < 3; ++a)
  {
    const auto& p = planes.at[a];
    if (!ray.crosses(a))
    {
      // Of two neighbours exactly one has a ray that runs in their face.
      if (!(ray.origin[a] >= p[0] && ray.origin[a] < p[4]))
      {
        return;
      }
      step[a] = 0;
      cell[a] = (ray.origin[a] >= p[1]) + (ray.origin[a] >= p[2]) + (ray.origin[a] >= p[3]);
      continue;
    }
    const bool up = ray.direction[a] > 0.;
    step[a] = up ? 1 : -1;
    for (int i = 0; i < 5; ++i)
    {
      planeT[a][i] = ray.planeAt(a, p[up ? i : 4 - i]);
    }
    t0 = std::max(t0, planeT[a][0]);
    t1 = std::min(t1, planeT[a][4]);
  }
  if (!(t0 < t1 && t0 <= limit))
  {
    return;
  }
  for (int a = 0; a < 3; ++a)
  {
    if (step[a] == 0)
    {
      next[a] = std::numeric_limits<double>::infinity();
      passed[a] = 0;
      continue;
    }
    passed[a] = (planeT[a][1] <= t0) + (planeT[a][2] <= t0) + (planeT[a][3] <= t0);
    cell[a] = step[a] > 0 ? passed[a] : 3 - passed[a];
    next[a] = planeT[a][passed[a] + 1];
  }
  const auto advance = [&](int a) {
    cell[a] += step[a];
    next[a] = planeT[a][++passed[a] + 1];
  };
  for (;;)
  {
    const double tOut = std::min({ next[0], next[1], next[2], t1 });
    const int octant = cell[0] | cell[1] << 2 | cell[2] << 4;
    if (active >> octant & 1 && t0 < tOut)
    {
      const OctantCrossing crossing(planes, ray, octant, t0, tOut);
      if (!visit(crossing))
      {
        return;
      }
    }
    if (tOut >= t1 || tOut > limit)
    {
      return;
    }
    t0 = std::max(t0, tOut);
    if (next[0] == tOut)
    {
      advance(0);
    }
    else if (next[1] == tOut)
    {
      advance(1);
    }
    else
    {
      advance(2);
    }
  }
}

/// The field less the isovalue on the crossing, over s in [0, 1].
inline Cubic alongCrossing(
  const SurfaceRecord& record, double isovalue, const OctantCrossing& crossing) noexcept
{
  const double* v = record.values.data() + firstVertex(crossing.octant);
  const Vec3& from = crossing.from;
  const Vec3& to = crossing.to;
  // Interpolating along x, y and z in turn multiplies by one linear polynomial each.
  std::array<std::array<double, 2>, 4> x;
  for (int i = 0; i < 4; ++i)
  {
    const double* low = v + 5 * (i & 1) + 25 * (i >> 1);
    const double difference = low[1] - low[0];
    x[i] = { (low[0] - isovalue) + from[0] * difference, (to[0] - from[0]) * difference };
  }
  std::array<std::array<double, 3>, 2> y;
  const double dy = to[1] - from[1];
  for (int i = 0; i < 2; ++i)
  {
    const auto& low = x[2 * i];
    const std::array<double, 2> d{ x[2 * i + 1][0] - low[0], x[2 * i + 1][1] - low[1] };
    y[i] = { low[0] + from[1] * d[0], low[1] + from[1] * d[1] + dy * d[0], dy * d[1] };
  }
  const double dz = to[2] - from[2];
  const std::array<double, 3> d{ y[1][0] - y[0][0], y[1][1] - y[0][1], y[1][2] - y[0][2] };
  return { y[0][0] + from[2] * d[0], y[0][1] + from[2] * d[1] + dz * d[0],
    y[0][2] + from[2] * d[2] + dz * d[1], dz * d[2] };
}

/// The field less the isovalue where a ray enters or leaves an octant, 0 where it may be: from the vertices of the seam
/// alone, as the neighbour sees them. Where vertices differ by many orders of magnitude, the cubic of the crossing has
/// the digits of the largest only. placeError: bound of the place's, in octants. rounding: of values, as in SurfaceBlocks.
inline double onSeam(const SurfaceRecord& record, double isovalue, int octant, const Vec3& place,
  double placeError, double rounding) noexcept
{
  std::array<std::array<double, 2>, 3> weights;
  for (int a = 0; a < 3; ++a)
  {
    const double within = 4. * placeError;
    const double f = place[a] <= within ? 0. : place[a] >= 1. - within ? 1. : place[a];
    weights[a] = { 1. - f, f };
  }
  const double* v = record.values.data() + firstVertex(octant);
  double value = 0.;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (int c = 0; c < 8; ++c)
  {
    const double weight = weights[0][c & 1] * weights[1][c >> 1 & 1] * weights[2][c >> 2];
    if (weight != 0.)
    {
      const double vertex = v[(c & 1) + 5 * (c >> 1 & 1) + 25 * (c >> 2)];
      value += weight * (vertex - isovalue);
      low = std::min(low, vertex);
      high = std::max(high, vertex);
    }
  }
  const double tolerance = rounding * std::max(std::abs(low), std::abs(high)) + placeError * (high - low);
  return std::abs(value) <= tolerance ? 0. : value;
}

/// Of the field at a place in an octant, per unit of the planes.
inline Vec3 gradientAt(
  const SurfaceRecord& record, const BlockPlanes& planes, int octant, const Vec3& place) noexcept
{
  Vec3 gradient;
  for (int a = 0; a < 3; ++a)
  {
    gradient[a] = slopeAlong(a, record.values.data() + firstVertex(octant), block::vertexStride, place) *
      planes.inverseWidth[a][octant >> 2 * a & 3];
  }
  return gradient;
}

/// Between the vertex gradients: continuous across all levels. 0 where that is.
inline Vec3 normalAt(const GradientRecord& record, int octant, const Vec3& place) noexcept
{
  Vec3 gradient;
  for (int a = 0; a < 3; ++a)
  {
    Corners corners;
    for (int c = 0; c < 8; ++c)
    {
      corners[c] = record.vertices[firstVertex(octant) + cornerOffset(c, block::vertexStride)][a];
    }
    gradient[a] = trilinear(corners, place);
  }
  return normalized(gradient);
}

} // namespace treeamr

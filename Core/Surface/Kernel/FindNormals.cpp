// The gradients and normals at many hits: gradientAt() and normalAt() for vectors of them.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/FindNormals.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include <utility>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

HWY_INLINE Doubles along(Doubles low, Doubles high, Doubles part)
{
  return hn::Add(low, hn::Mul(part, hn::Sub(high, low)));
}

void FindNormals(const Vec3& width, HitPlaces& hits)
{
  const Tag d;
  for (int i = 0; i < hits.count; i += lanes)
  {
    Vectors3 place;
    for (int a = 0; a < 3; ++a)
    {
      place[a] = hn::Load(d, &hits.place[a][i]);
    }
    for (int a = 0; a < 3; ++a)
    {
      const auto at = [&](int edge) { return hn::Load(d, &hits.difference[a][edge][i]); };
      const Doubles atB = place[(a + 1) % 3];
      const Doubles difference =
        along(along(at(0), at(1), atB), along(at(2), at(3), atB), place[(a + 2) % 3]);
      const Doubles slope = hn::Mul(difference, hn::Load(d, &hits.inverseWidth[a][i]));
      hn::Store(hn::Div(slope, set(width[a])), d, &hits.gradient[a][i]);
    }
    Vectors3 normal{ hn::Zero(d), hn::Zero(d), hn::Zero(d) };
    if (hits.withNormals)
    {
      for (int a = 0; a < 3; ++a)
      {
        const auto onEdge = [&](int edge) {
          return along(hn::Load(d, &hits.vertexGradient[a][2 * edge][i]),
            hn::Load(d, &hits.vertexGradient[a][2 * edge + 1][i]), place[0]);
        };
        normal[a] =
          along(along(onEdge(0), onEdge(1), place[1]), along(onEdge(2), onEdge(3), place[1]), place[2]);
      }
      normal = normalizedVectors(normal);
    }
    for (int a = 0; a < 3; ++a)
    {
      hn::Store(normal[a], d, &hits.normal[a][i]);
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(FindNormals);

void findNormals(const Vec3& width, HitPlaces& hits) noexcept
{
  HWY_DYNAMIC_DISPATCH(FindNormals)(width, hits);
}

void HitPlaces::addNormal(const GradientRecord& record, int octant) noexcept
{
  // Unrolled: with offsets that the compiler knows it takes a third of the instructions.
  const int first = firstVertex(octant);
  const auto take = [&]<int Corner>() {
    constexpr int offset = cornerOffset(Corner, block::vertexStride);
    vertexGradient[0][Corner][count] = record.at(first + offset, 0);
    vertexGradient[1][Corner][count] = record.at(first + offset, 1);
    vertexGradient[2][Corner][count] = record.at(first + offset, 2);
  };
  [&]<int... Corner>(std::integer_sequence<int, Corner...>)
  {
    (take.template operator()<Corner>(), ...);
  }
  (std::make_integer_sequence<int, 8>());
}

void HitPlaces::add(
  const SurfaceRecord& record, const BlockPlanes& planes, int octant, const Vec3& at) noexcept
{
  const double* v = record.values.data() + firstVertex(octant);
  for (int a = 0; a < 3; ++a)
  {
    const int step = block::vertexStride[a];
    const int b = block::vertexStride[(a + 1) % 3];
    const int c = block::vertexStride[(a + 2) % 3];
    difference[a][0][count] = v[step] - v[0];
    difference[a][1][count] = v[step + b] - v[b];
    difference[a][2][count] = v[step + c] - v[c];
    difference[a][3][count] = v[step + b + c] - v[b + c];
    inverseWidth[a][count] = planes.inverseWidth[a][octant >> 2 * a & 3];
    place[a][count] = at[a];
  }
  ++count;
}

} // namespace treeamr
#endif

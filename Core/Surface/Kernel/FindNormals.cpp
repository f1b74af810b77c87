// The gradients of the field at many hits: gradientsAt() for vectors of them.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/FindNormals.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include "Surface/SurfaceFrame.h"

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

void FindNormals(const Vec3& width, HitPlaces& hits)
{
  const Tag d;
  for (int i = 0; i < hits.count; i += lanes)
  {
    std::array<Doubles, 3> place;
    for (int a = 0; a < 3; ++a)
    {
      place[a] = hn::Load(d, &hits.place[a][i]);
    }
    std::array<Doubles, 3> exact;
    std::array<Doubles, 3> smooth;
    for (int a = 0; a < 3; ++a)
    {
      const Doubles atB = place[(a + 1) % 3];
      const Doubles atC = place[(a + 2) % 3];
      const auto slope = [&](int half) {
        const auto at = [&](int edge) { return hn::Load(d, &hits.difference[a][half][edge][i]); };
        const Doubles low = hn::Add(at(0), hn::Mul(atB, hn::Sub(at(1), at(0))));
        const Doubles high = hn::Add(at(2), hn::Mul(atB, hn::Sub(at(3), at(2))));
        const Doubles difference = hn::Add(low, hn::Mul(atC, hn::Sub(high, low)));
        return hn::Mul(difference, hn::Load(d, &hits.inverseWidth[a][half][i]));
      };
      const Doubles lower = slope(0);
      const Doubles upper = slope(1);
      const Mask isUpper = hn::Ne(hn::Load(d, &hits.half[a][i]), hn::Zero(d));
      const Doubles perWidth = set(width[a]);
      exact[a] = hn::Div(hn::IfThenElse(isUpper, upper, lower), perWidth);
      smooth[a] =
        hn::Div(hn::Add(lower, hn::Mul(hn::Load(d, &hits.fromLower[a][i]), hn::Sub(upper, lower))), perWidth);
    }
    const Doubles along = hn::Add(
      hn::Add(hn::Mul(smooth[0], exact[0]), hn::Mul(smooth[1], exact[1])), hn::Mul(smooth[2], exact[2]));
    const Mask isSmooth = hn::Gt(along, hn::Zero(d));
    std::array<Doubles, 3> direction;
    for (int a = 0; a < 3; ++a)
    {
      hn::Store(exact[a], d, &hits.gradient[a][i]);
      direction[a] = hn::IfThenElse(isSmooth, smooth[a], exact[a]);
    }
    const std::array<Doubles, 3> normal = normalizedVectors(direction);
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

void HitPlaces::add(const SurfaceRecord& record, const BlockPlanes& planes, const Bounds& domain, int octant,
  const Vec3& at) noexcept
{
  constexpr std::array<int, 3> stride{ 1, 5, 25 };
  for (int a = 0; a < 3; ++a)
  {
    const int b = stride[(a + 1) % 3];
    const int c = stride[(a + 2) % 3];
    const int ofLeaf = octant >> 2 * a & 1;
    const int cell = (octant >> 2 * a & 3) - ofLeaf;
    const double* v = record.values.data() + firstVertex(octant) - ofLeaf * stride[a];
    for (int h = 0; h < 2; ++h, v += stride[a])
    {
      difference[a][h][0][count] = v[stride[a]] - v[0];
      difference[a][h][1][count] = v[stride[a] + b] - v[b];
      difference[a][h][2][count] = v[stride[a] + c] - v[c];
      difference[a][h][3][count] = v[stride[a] + b + c] - v[b + c];
      inverseWidth[a][h][count] = planes.inverseWidth[a][cell + h];
    }
    const bool isFirst = planes.at[a][cell] == domain.min[a];
    const bool isLast = planes.at[a][cell + 2] == domain.max[a];
    half[a][count] = ofLeaf;
    fromLower[a][count] = isFirst ? 1. : isLast ? 0. : 0.5 * (ofLeaf + at[a]);
    place[a][count] = at[a];
  }
  ++count;
}

} // namespace treeamr
#endif

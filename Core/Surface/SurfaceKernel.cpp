#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/SurfaceKernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/SurfaceKernel.h"

#include <hwy/highway.h>

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using IntTag = hn::RebindToSigned<Tag>;
using BitsTag = hn::RebindToUnsigned<Tag>;
using Doubles = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;

HWY_INLINE Doubles set(double x)
{
  return hn::Set(Tag(), x);
}

/// Of four (or five) numbers the one that an index of whole numbers from 0 names.
HWY_INLINE Doubles pick(Mask is1, Mask is2, Mask is3, Doubles v0, Doubles v1, Doubles v2, Doubles v3)
{
  return hn::IfThenElse(is3, v3, hn::IfThenElse(is2, v2, hn::IfThenElse(is1, v1, v0)));
}

/// The state of a vector of rays along one axis.
struct Axis
{
  Doubles origin;
  Doubles direction;
  std::array<Doubles, 5> planeT; // in the order that the ray crosses the planes
  Doubles next;                  // of them
  Doubles passed;                // octants
  Doubles cell;
  Doubles step; // of the cell; 0: the ray stays in it

  HWY_INLINE void findNext()
  {
    next = pick(hn::Eq(passed, set(1.)), hn::Eq(passed, set(2.)), hn::Eq(passed, set(3.)), planeT[1],
      planeT[2], planeT[3], planeT[4]);
  }
  HWY_INLINE void advance(Mask rays)
  {
    cell = hn::Add(cell, hn::IfThenElseZero(rays, step));
    passed = hn::Add(passed, hn::IfThenElseZero(rays, set(1.)));
    const Doubles before = next;
    findNext();
    next = hn::IfThenElse(rays, next, before);
  }
};

HWY_INLINE Doubles countTrue(Mask a, Mask b, Mask c)
{
  const Doubles one = set(1.);
  return hn::Add(hn::IfThenElseZero(a, one), hn::Add(hn::IfThenElseZero(b, one), hn::IfThenElseZero(c, one)));
}

/// The bits of alongCrossing(): x, y and z in turn multiply by one linear polynomial each.
struct CornerValues
{
  std::array<Doubles, 8> at;

  HWY_INLINE std::array<Doubles, 4> along(
    Doubles isovalue, const std::array<Doubles, 3>& from, const std::array<Doubles, 3>& part) const
  {
    std::array<std::array<Doubles, 2>, 4> x;
    for (int i = 0; i < 4; ++i)
    {
      const Doubles difference = hn::Sub(at[2 * i + 1], at[2 * i]);
      x[i][0] = hn::Add(hn::Sub(at[2 * i], isovalue), hn::Mul(from[0], difference));
      x[i][1] = hn::Mul(part[0], difference);
    }
    std::array<std::array<Doubles, 3>, 2> y;
    for (int i = 0; i < 2; ++i)
    {
      const Doubles d0 = hn::Sub(x[2 * i + 1][0], x[2 * i][0]);
      const Doubles d1 = hn::Sub(x[2 * i + 1][1], x[2 * i][1]);
      y[i][0] = hn::Add(x[2 * i][0], hn::Mul(from[1], d0));
      y[i][1] = hn::Add(hn::Add(x[2 * i][1], hn::Mul(from[1], d1)), hn::Mul(part[1], d0));
      y[i][2] = hn::Mul(part[1], d1);
    }
    std::array<Doubles, 3> d;
    for (int i = 0; i < 3; ++i)
    {
      d[i] = hn::Sub(y[1][i], y[0][i]);
    }
    return { hn::Add(y[0][0], hn::Mul(from[2], d[0])),
      hn::Add(hn::Add(y[0][1], hn::Mul(from[2], d[1])), hn::Mul(part[2], d[0])),
      hn::Add(hn::Add(y[0][2], hn::Mul(from[2], d[2])), hn::Mul(part[2], d[1])), hn::Mul(part[2], d[2]) };
  }
};

/// False only where a cubic has no root that visitRoots() would visit: it lies in the hull of its Bernstein
/// coefficients.
HWY_INLINE Mask mayVanish(const std::array<Doubles, 4>& c, Doubles tolerance)
{
  const Doubles third = set(1. / 3.);
  const Doubles last = hn::Add(hn::Add(hn::Add(c[3], c[2]), c[1]), c[0]);
  const Doubles b1 = hn::Add(c[0], hn::Mul(c[1], third));
  const Doubles b2 = hn::Add(c[0], hn::Mul(hn::Add(hn::Add(c[1], c[1]), c[2]), third));
  const Doubles low = hn::Min(hn::Min(c[0], b1), hn::Min(b2, last));
  const Doubles high = hn::Max(hn::Max(c[0], b1), hn::Max(b2, last));
  return hn::Not(hn::Or(hn::Gt(low, tolerance), hn::Lt(high, hn::Neg(tolerance))));
}

void CrossBlock(const SurfaceRecord& record, const BlockPlanes& planes, std::span<const double> isovalues,
  const SlabRays& rays, int first, int count, OctantCandidates& found)
{
  const Tag d;
  const IntTag di;
  const BitsTag du;
  constexpr int lanes = hn::MaxLanes(Tag());
  const Doubles infinity = set(std::numeric_limits<double>::infinity());
  const double perWidth =
    std::max({ planes.inverseWidth[0][0], planes.inverseWidth[1][0], planes.inverseWidth[2][0] });
  found.count = 0;
  for (int begin = first; begin < first + count; begin += lanes)
  {
    std::array<Axis, 3> axes;
    Doubles t0 = hn::LoadU(d, &rays.enter[begin]);
    Doubles t1 = hn::LoadU(d, &rays.leave[begin]);
    const Doubles limit = hn::LoadU(d, &rays.limit[begin]);
    std::array<Mask, 3> up;
    std::array<Mask, 3> crosses;
    std::array<Doubles, 3> inverse;
    for (int a = 0; a < 3; ++a)
    {
      Axis& axis = axes[a];
      const auto& p = planes.at[a];
      axis.origin = hn::LoadU(d, &rays.origin[a][begin]);
      axis.direction = hn::LoadU(d, &rays.direction[a][begin]);
      inverse[a] = hn::LoadU(d, &rays.inverse[a][begin]);
      up[a] = hn::Gt(axis.direction, hn::Zero(d));
      crosses[a] = hn::Lt(hn::Abs(inverse[a]), infinity);
      const Doubles low = hn::Mul(hn::Sub(set(p[0]), axis.origin), inverse[a]);
      const Doubles high = hn::Mul(hn::Sub(set(p[4]), axis.origin), inverse[a]);
      // Of two neighbours exactly one has a ray that runs in their face.
      const Mask inside = hn::And(hn::Ge(axis.origin, set(p[0])), hn::Lt(axis.origin, set(p[4])));
      axis.planeT[0] = hn::IfThenElse(
        crosses[a], hn::IfThenElse(up[a], low, high), hn::IfThenElse(inside, hn::Neg(infinity), infinity));
      axis.planeT[4] = hn::IfThenElse(crosses[a], hn::IfThenElse(up[a], high, low), infinity);
      t0 = hn::Max(t0, axis.planeT[0]);
      t1 = hn::Min(t1, axis.planeT[4]);
    }
    Mask alive =
      hn::And(hn::And(hn::Lt(t0, t1), hn::Le(t0, limit)), hn::FirstN(d, std::size_t(first + count - begin)));
    if (hn::AllFalse(d, alive))
    {
      continue;
    }
    const Doubles tolerance = hn::Add(set(record.tolerance),
      hn::Mul(hn::Mul(set(record.width()), hn::LoadU(d, &rays.rounding[begin])), set(perWidth)));
    for (int a = 0; a < 3; ++a)
    {
      Axis& axis = axes[a];
      const auto& p = planes.at[a];
      const auto planeAt = [&](int i) { return hn::Mul(hn::Sub(set(p[i]), axis.origin), inverse[a]); };
      const Doubles low = planeAt(1);
      const Doubles middle = planeAt(2);
      const Doubles high = planeAt(3);
      axis.planeT[1] = hn::IfThenElse(crosses[a], hn::IfThenElse(up[a], low, high), infinity);
      axis.planeT[2] = hn::IfThenElse(crosses[a], middle, infinity);
      axis.planeT[3] = hn::IfThenElse(crosses[a], hn::IfThenElse(up[a], high, low), infinity);
      axis.passed =
        countTrue(hn::Le(axis.planeT[1], t0), hn::Le(axis.planeT[2], t0), hn::Le(axis.planeT[3], t0));
      const Doubles stays = countTrue(
        hn::Ge(axis.origin, set(p[1])), hn::Ge(axis.origin, set(p[2])), hn::Ge(axis.origin, set(p[3])));
      axis.step = hn::IfThenElseZero(crosses[a], hn::IfThenElse(up[a], set(1.), set(-1.)));
      axis.cell =
        hn::IfThenElse(crosses[a], hn::IfThenElse(up[a], axis.passed, hn::Sub(set(3.), axis.passed)), stays);
      axis.findNext();
    }
    const auto rayCode = hn::ShiftLeft<32>(hn::Iota(di, begin));
    for (;;)
    {
      const Doubles tOut = hn::Min(hn::Min(axes[0].next, axes[1].next), hn::Min(axes[2].next, t1));
      const auto octant = hn::ConvertTo(
        di, hn::Add(axes[0].cell, hn::Add(hn::Mul(set(4.), axes[1].cell), hn::Mul(set(16.), axes[2].cell))));
      const auto bit = hn::And(hn::Shr(hn::Set(du, record.active), hn::BitCast(du, octant)), hn::Set(du, 1));
      const Mask crossed = hn::And(
        hn::And(alive, hn::Lt(t0, tOut)), hn::MaskFromVec(hn::BitCast(d, hn::Sub(hn::Zero(du), bit))));
      if (!hn::AllFalse(d, crossed))
      {
        std::array<Doubles, 3> from;
        std::array<Doubles, 3> part;
        for (int a = 0; a < 3; ++a)
        {
          const Axis& axis = axes[a];
          const auto& p = planes.at[a];
          const auto& w = planes.inverseWidth[a];
          const Mask is1 = hn::Eq(axis.cell, set(1.));
          const Mask is2 = hn::Eq(axis.cell, set(2.));
          const Mask is3 = hn::Eq(axis.cell, set(3.));
          const Doubles plane = pick(is1, is2, is3, set(p[0]), set(p[1]), set(p[2]), set(p[3]));
          const Doubles perOctant = pick(is1, is2, is3, set(w[0]), set(w[1]), set(w[2]), set(w[3]));
          const Doubles origin = hn::Sub(axis.origin, plane);
          const auto place = [&](Doubles t) {
            const Doubles x = hn::Mul(hn::Add(origin, hn::Mul(t, axis.direction)), perOctant);
            return hn::Min(hn::Max(x, hn::Zero(d)), set(1.));
          };
          from[a] = place(t0);
          part[a] = hn::Sub(place(tOut), from[a]);
        }
        // Rays that are through the block have left it.
        const Doubles place =
          hn::Add(axes[0].cell, hn::Add(hn::Mul(set(5.), axes[1].cell), hn::Mul(set(25.), axes[2].cell)));
        const auto vertex = hn::ConvertTo(di, hn::IfThenElseZero(crossed, place));
        CornerValues values;
        for (int corner = 0; corner < 8; ++corner)
        {
          const int offset = (corner & 1) + 5 * (corner >> 1 & 1) + 25 * (corner >> 2);
          values.at[corner] = hn::GatherIndex(d, record.values.data() + offset, vertex);
        }
        for (std::size_t surface = 0; surface < isovalues.size(); ++surface)
        {
          const std::array<Doubles, 4> cubic = values.along(set(isovalues[surface]), from, part);
          const Mask keep = hn::And(crossed, mayVanish(cubic, tolerance));
          if (hn::AllFalse(d, keep))
          {
            continue;
          }
          const int at = found.count;
          hn::CompressStore(t0, keep, d, &found.t0[at]);
          hn::CompressStore(tOut, keep, d, &found.t1[at]);
          for (int i = 0; i < 4; ++i)
          {
            hn::CompressStore(cubic[i], keep, d, &found.cubic[i][at]);
          }
          hn::CompressStore(tolerance, keep, d, &found.tolerance[at]);
          const auto code =
            hn::Or(rayCode, hn::Or(octant, hn::Set(di, static_cast<std::int64_t>(surface << 6))));
          found.count +=
            static_cast<int>(hn::CompressStore(code, hn::RebindMask(di, keep), di, &found.code[at]));
        }
      }
      alive = hn::And(alive, hn::And(hn::Lt(tOut, t1), hn::Le(tOut, limit)));
      if (hn::AllFalse(d, alive))
      {
        break;
      }
      t0 = hn::Max(t0, tOut);
      const Mask x = hn::Eq(axes[0].next, tOut);
      const Mask y = hn::AndNot(x, hn::Eq(axes[1].next, tOut));
      axes[0].advance(x);
      axes[1].advance(y);
      axes[2].advance(hn::Not(hn::Or(x, y)));
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(CrossBlock);

void crossBlock(const SurfaceRecord& record, const BlockPlanes& planes, std::span<const double> isovalues,
  const SlabRays& rays, int first, int count, OctantCandidates& found) noexcept
{
  HWY_DYNAMIC_DISPATCH(CrossBlock)(record, planes, isovalues, rays, first, count, found);
}

} // namespace treeamr
#endif

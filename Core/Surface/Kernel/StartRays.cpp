// The rays of packets of pixels, and their way into the domain: Camera::ray(), TraceSpace::start() and
// TraceSpace::toUnitCube() for vectors of them.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/StartRays.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include <array>
#include <cmath>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// The sum of three products and the offset, in this order.
HWY_INLINE Doubles affine(const double* m, Doubles x, Doubles y, Doubles z, Doubles offset)
{
  const Doubles sum = hn::Add(hn::Mul(set(m[0]), x), hn::Mul(set(m[1]), y));
  return hn::Add(hn::Add(sum, hn::Mul(set(m[2]), z)), offset);
}

/// Camera::ray() through places x, y from -1 to 1 in the image.
HWY_INLINE void cast(const Camera& camera, Doubles x, Doubles y, Vectors3& origin, Vectors3& direction)
{
  const Matrix4& m = camera.dataFromClip();
  const auto inPlane = [&](int row) {
    return hn::Add(hn::Add(hn::Mul(set(m[row]), x), hn::Mul(set(m[row + 1]), y)), set(m[row + 3]));
  };
  if (camera.isPerspective())
  {
    const Doubles w = inPlane(12);
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = set(camera.eye()[a]);
      direction[a] = hn::Mul(set(camera.forward()), hn::Sub(inPlane(4 * a), hn::Mul(origin[a], w)));
    }
  }
  else
  {
    const Doubles near = set(-1.);
    const Doubles w = affine(&m[12], x, y, near, set(m[15]));
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = hn::Div(affine(&m[4 * a], x, y, near, set(m[4 * a + 3])), w);
      direction[a] = set(m[4 * a + 2] / m[15]);
    }
  }
  Doubles squared = hn::Zero(Tag());
  for (int r = 0; r < 3; ++r)
  {
    const double* row = &camera.worldFromData()[4 * r];
    const Doubles along =
      hn::Add(hn::Add(hn::Mul(set(row[0]), direction[0]), hn::Mul(set(row[1]), direction[1])),
        hn::Mul(set(row[2]), direction[2]));
    squared = hn::Add(squared, hn::Mul(along, along));
  }
  const Doubles scale = hn::Div(set(1.), hn::Sqrt(squared));
  for (Doubles& component : direction)
  {
    component = hn::Mul(component, scale);
  }
}

/// Camera::tFromDepth() of the plane at z from -1 to 1 in clip space.
HWY_INLINE Doubles planeT(const Camera& camera, double z, const Vectors3& origin, const Vectors3& direction)
{
  const Matrix4& m = camera.clipFromData();
  Doubles atOrigin = set(m[11] - z * m[15]);
  Doubles along = hn::Zero(Tag());
  for (int a = 0; a < 3; ++a)
  {
    const Doubles normal = set(m[8 + a] - z * m[12 + a]);
    atOrigin = hn::Add(atOrigin, hn::Mul(normal, origin[a]));
    along = hn::Add(along, hn::Mul(normal, direction[a]));
  }
  return hn::Div(hn::Neg(atOrigin), along);
}

void CastRays(const Camera& camera, bool isCut, int x, int y, PixelRays& rays)
{
  const Tag d;
  for (int i = 0; i < PixelRays::most; i += lanes)
  {
    HWY_ALIGN double column[lanes];
    HWY_ALIGN double row[lanes];
    for (int lane = 0; lane < lanes; ++lane)
    {
      column[lane] = x + (i + lane) % PixelRays::edge;
      row[lane] = y + (i + lane) / PixelRays::edge;
    }
    const auto fromEdge = [&](const double* pixel, int size) {
      const Doubles middle = hn::Add(hn::Load(d, pixel), set(0.5));
      return hn::Sub(hn::Div(hn::Mul(set(2.), middle), set(size)), set(1.));
    };
    Vectors3 origin;
    Vectors3 direction;
    cast(camera, fromEdge(column, camera.width()), fromEdge(row, camera.height()), origin, direction);
    for (int a = 0; a < 3; ++a)
    {
      hn::Store(origin[a], d, &rays.origin[a][i]);
      hn::Store(direction[a], d, &rays.direction[a][i]);
    }
    hn::Store(isCut ? planeT(camera, -1., origin, direction) : hn::Zero(d), d, &rays.begin[i]);
    hn::Store(isCut ? planeT(camera, 1., origin, direction) : set(std::numeric_limits<double>::infinity()), d,
      &rays.end[i]);
  }
}

/// A vector of the parts of rays.
struct Parts
{
  Vectors3 origin;
  Vectors3 direction;
  Vectors3 inverse;
  Doubles enter;
  Doubles leave;
  Doubles rounding;
  Mask enters; // those that do

  HWY_INLINE Parts(const TraceSpace& space, const PixelRays& rays, int i)
  {
    const Tag d;
    const Bounds& domain = space.domain();
    enter = hn::Load(d, &rays.begin[i]);
    leave = hn::Load(d, &rays.end[i]);
    enters = hn::Eq(hn::Zero(d), hn::Zero(d));
    for (int a = 0; a < 3; ++a)
    {
      const Doubles low = set(domain.min[a]);
      const Doubles high = set(domain.max[a]);
      const Doubles perWidth = set(space.perWidth(a));
      origin[a] = hn::Mul(hn::Sub(hn::Load(d, &rays.origin[a][i]), set(space.origin(a))), perWidth);
      direction[a] = hn::Mul(hn::Load(d, &rays.direction[a][i]), perWidth);
      inverse[a] = hn::Div(set(1.), direction[a]);
      const Mask crosses = hn::Lt(hn::Abs(inverse[a]), set(std::numeric_limits<double>::infinity()));
      origin[a] = hn::IfThenElse(hn::AndNot(crosses, hn::Eq(origin[a], high)),
        set(std::nextafter(domain.max[a], domain.min[a])), origin[a]);

      const Doubles u = hn::Mul(hn::Sub(low, origin[a]), inverse[a]);
      const Doubles v = hn::Mul(hn::Sub(high, origin[a]), inverse[a]);
      const Mask ascends = hn::Lt(u, v);
      const Doubles in = hn::IfThenElse(ascends, u, v);
      const Doubles out = hn::IfThenElse(ascends, v, u);
      enter = hn::IfThenElse(hn::And(crosses, hn::Gt(in, enter)), in, enter);
      leave = hn::IfThenElse(hn::And(crosses, hn::Lt(out, leave)), out, leave);
      enters = hn::And(enters, hn::Or(crosses, hn::And(hn::Ge(origin[a], low), hn::Lt(origin[a], high))));
    }
    enters = hn::And(enters, hn::Lt(enter, leave));
    rounding = hn::Zero(d);
    for (int a = 0; a < 3; ++a)
    {
      const Doubles reach = hn::Add(hn::Abs(origin[a]), hn::Mul(leave, hn::Abs(direction[a])));
      const Doubles ofAxis = hn::Mul(set(RayPart::roundingOfReach), reach);
      rounding = hn::IfThenElse(hn::Lt(rounding, ofAxis), ofAxis, rounding);
    }
  }
};

std::uint32_t StartRays(
  const TraceSpace& space, const PixelRays& rays, std::uint32_t wanted, int count, SlabRays& found)
{
  const Tag d;
  const hn::Rebind<float, Tag> df;
  std::uint32_t started = 0;
  for (int i = 0; i < PixelRays::most; i += lanes)
  {
    const Parts parts(space, rays, i);
    const std::array<std::uint8_t, 8> bits{ static_cast<std::uint8_t>(wanted >> i & ((1u << lanes) - 1)) };
    Mask starts = hn::And(parts.enters, hn::LoadMaskBits(d, bits.data()));
    std::array<hn::Vec<hn::Rebind<float, Tag>>, 3> unitOrigin;
    std::array<hn::Vec<hn::Rebind<float, Tag>>, 3> unitDirection;
    for (int a = 0; a < 3; ++a)
    {
      const Doubles at = hn::Add(parts.origin[a], hn::Mul(parts.enter, parts.direction[a]));
      const Doubles length = hn::Sub(parts.leave, parts.enter);
      const Doubles perExtent = set(space.perExtent(a));
      unitOrigin[a] = hn::DemoteTo(df, hn::Mul(hn::Sub(at, set(space.domain().min[a])), perExtent));
      unitDirection[a] = hn::DemoteTo(df, hn::Mul(hn::Mul(parts.direction[a], length), perExtent));
      const auto reach = hn::Add(hn::Abs(unitOrigin[a]), hn::Abs(unitDirection[a]));
      starts = hn::And(starts, hn::Le(hn::PromoteTo(d, reach), set(TraceSpace::aroundUnitCube)));
    }
    const Packing packing(starts);
    for (int a = 0; a < 3; ++a)
    {
      packing.store(parts.origin[a], &found.origin[a][count]);
      packing.store(parts.direction[a], &found.direction[a][count]);
      packing.store(parts.inverse[a], &found.inverse[a][count]);
      packing.store(hn::PromoteTo(d, unitOrigin[a]), &found.unitOrigin[a][count]);
      packing.store(hn::PromoteTo(d, unitDirection[a]), &found.unitDirection[a][count]);
    }
    packing.store(parts.enter, &found.enter[count]);
    packing.store(parts.leave, &found.leave[count]);
    packing.store(parts.rounding, &found.rounding[count]);
    count += packing.count();
    started |= packing.bits() << i;
  }
  return started;
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(CastRays);
HWY_EXPORT(StartRays);

void castRays(const Camera& camera, bool isCut, int x, int y, PixelRays& rays) noexcept
{
  HWY_DYNAMIC_DISPATCH(CastRays)(camera, isCut, x, y, rays);
}

std::uint32_t startRays(
  const TraceSpace& space, const PixelRays& rays, std::uint32_t wanted, int count, SlabRays& found) noexcept
{
  return HWY_DYNAMIC_DISPATCH(StartRays)(space, rays, wanted, count, found);
}

} // namespace treeamr
#endif

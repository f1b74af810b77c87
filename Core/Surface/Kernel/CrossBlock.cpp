// Rays through the octants of a block, and the field along them: walkBlock() and alongCrossing() for many rays.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/CrossBlock.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include <algorithm>
#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// The state of a vector of rays along one axis: the planes between octants that are still ahead of them, in the order
/// that they cross them. Beyond the last one the block ends.
struct Axis
{
  Doubles next;
  Doubles second;
  Doubles third;
  Integers step; // of the octant, behind each; 0: the ray stays in its layer of octants

  HWY_INLINE void advance(Mask rays)
  {
    next = hn::IfThenElse(rays, second, next);
    second = hn::IfThenElse(rays, third, second);
    third = hn::IfThenElse(rays, set(std::numeric_limits<double>::infinity()), third);
  }
  HWY_INLINE Integers stepOf(Mask rays) const
  {
    return hn::IfThenElseZero(hn::RebindMask(IntTag(), rays), step);
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

  /// Rounded less often, where that is faster: for what bounds it.
  HWY_INLINE std::array<Doubles, 4> nearlyAlong(
    const std::array<Doubles, 3>& from, const std::array<Doubles, 3>& part) const
  {
    std::array<std::array<Doubles, 2>, 4> x;
    for (int i = 0; i < 4; ++i)
    {
      const Doubles difference = hn::Sub(at[2 * i + 1], at[2 * i]);
      x[i] = { hn::MulAdd(from[0], difference, at[2 * i]), hn::Mul(part[0], difference) };
    }
    std::array<std::array<Doubles, 3>, 2> y;
    for (int i = 0; i < 2; ++i)
    {
      const Doubles d0 = hn::Sub(x[2 * i + 1][0], x[2 * i][0]);
      const Doubles d1 = hn::Sub(x[2 * i + 1][1], x[2 * i][1]);
      y[i] = { hn::MulAdd(from[1], d0, x[2 * i][0]),
        hn::MulAdd(part[1], d0, hn::MulAdd(from[1], d1, x[2 * i][1])), hn::Mul(part[1], d1) };
    }
    std::array<Doubles, 3> d;
    for (int i = 0; i < 3; ++i)
    {
      d[i] = hn::Sub(y[1][i], y[0][i]);
    }
    return { hn::MulAdd(from[2], d[0], y[0][0]),
      hn::MulAdd(part[2], d[0], hn::MulAdd(from[2], d[1], y[0][1])),
      hn::MulAdd(part[2], d[1], hn::MulAdd(from[2], d[2], y[0][2])), hn::Mul(part[2], d[2]) };
  }

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

/// Of the Bernstein coefficients of a cubic, in which it lies on [0, 1].
struct Hull
{
  Doubles low;
  Doubles high;

  Hull() = default;
  HWY_INLINE explicit Hull(const std::array<Doubles, 4>& c)
  {
    const Doubles third = set(1. / 3.);
    const Doubles last = hn::Add(hn::Add(hn::Add(c[3], c[2]), c[1]), c[0]);
    const Doubles b1 = hn::Add(c[0], hn::Mul(c[1], third));
    const Doubles b2 = hn::Add(c[0], hn::Mul(hn::Add(hn::Add(c[1], c[1]), c[2]), third));
    low = hn::Min(hn::Min(c[0], b1), hn::Min(b2, last));
    high = hn::Max(hn::Max(c[0], b1), hn::Max(b2, last));
  }
  /// False where the value is outside by more than the tolerance: then visitRoots() finds nothing.
  HWY_INLINE Mask has(Doubles value, Doubles tolerance) const
  {
    return hn::Not(
      hn::Or(hn::Gt(hn::Sub(low, value), tolerance), hn::Lt(hn::Sub(high, value), hn::Neg(tolerance))));
  }
};

/// Parts of rays in active octants: what the walk finds, in the order of each ray.
struct Crossings
{
  using Component = std::array<double, OctantCandidates::mostRays * OctantCandidates::mostOctants + 8>;
  int count = 0;
  alignas(64) Component t0;
  alignas(64) Component t1;
  alignas(64) std::array<std::int64_t, std::tuple_size_v<Component>> code; // ray << 32 | octant

  HWY_INLINE void add(Mask rays, Doubles begin, Doubles end, Integers codes)
  {
    const Packing packing(rays);
    packing.store(begin, &t0[count]);
    packing.store(end, &t1[count]);
    packing.store(codes, &code[count]);
    count += packing.count();
  }
};

/// A vector of rays and the planes across an axis.
struct Slab
{
  Doubles origin;
  Doubles inverse;
  Mask up;
  Mask crosses;

  HWY_INLINE Slab(Doubles rayOrigin, Doubles rayInverse)
    : origin(rayOrigin)
    , inverse(rayInverse)
    , up(hn::Gt(inverse, hn::Zero(Tag())))
    , crosses(hn::Lt(hn::Abs(inverse), set(std::numeric_limits<double>::infinity())))
  {
  }
  HWY_INLINE Doubles planeAt(Doubles plane) const { return hn::Mul(hn::Sub(plane, origin), inverse); }
};

/// The planes that narrow a block.
struct Narrowed
{
  Vectors3 lower;
  Vectors3 upper;

  HWY_INLINE explicit Narrowed(const CrossedBlock& block)
  {
    for (int a = 0; a < 3; ++a)
    {
      // Beyond the octants that may be active there is nothing to find.
      lower[a] = set(block.planes.at[a][block.first[a]]);
      upper[a] = set(block.planes.at[a][block.end[a]]);
    }
  }

  /// Adds those of a packet's rays.
  HWY_INLINE void enter(const SlabRays& rays, int first, std::uint32_t wanted, BlockEntries& entries) const
  {
    const Tag d;
    const IntTag di;
    const Doubles infinity = set(std::numeric_limits<double>::infinity());
    for (int i = 0; i < PixelRays::most; i += lanes)
    {
      const std::array<std::uint8_t, 8> bits{ static_cast<std::uint8_t>(wanted >> i & ((1u << lanes) - 1)) };
      const int begin = first + i;
      Doubles t0 = hn::LoadU(d, &rays.enter[begin]);
      Doubles t1 = hn::LoadU(d, &rays.leave[begin]);
      for (int a = 0; a < 3; ++a)
      {
        const Slab slab(hn::LoadU(d, &rays.origin[a][begin]), hn::LoadU(d, &rays.inverse[a][begin]));
        const Doubles low = slab.planeAt(lower[a]);
        const Doubles high = slab.planeAt(upper[a]);
        // Of two neighbours exactly one has a ray that runs in their face.
        const Mask inside = hn::And(hn::Ge(slab.origin, lower[a]), hn::Lt(slab.origin, upper[a]));
        const Doubles in = hn::IfThenElse(slab.crosses, hn::IfThenElse(slab.up, low, high),
          hn::IfThenElse(inside, hn::Neg(infinity), infinity));
        t0 = hn::Max(t0, in);
        t1 = hn::Min(t1, hn::IfThenElse(slab.crosses, hn::IfThenElse(slab.up, high, low), infinity));
      }
      const Mask enters = hn::And(hn::Lt(t0, t1), hn::Le(t0, hn::LoadU(d, &rays.limit[begin])));
      const Packing packing(hn::And(enters, hn::LoadMaskBits(d, bits.data())));
      packing.store(t0, &entries.t0[entries.count]);
      packing.store(t1, &entries.t1[entries.count]);
      // Iota(di, begin) would be put together in memory.
      packing.store(hn::Add(hn::Iota(di, 0), hn::Set(di, begin)), &entries.ray[entries.count]);
      entries.count += packing.count();
    }
  }
};

void EnterBlock(
  const CrossedBlock& block, const SlabRays& rays, int first, std::uint32_t wanted, BlockEntries& entries)
{
  Narrowed(block).enter(rays, first, wanted, entries);
}

std::uint32_t EnterBlockByPackets(
  const CrossedBlock& block, const SlabRays& rays, int count, std::uint32_t packets, BlockEntries& entries)
{
  constexpr int packet = PixelRays::most;
  const Narrowed narrowed(block);
  for (; packets != 0 && entries.hasRoom(); packets &= packets - 1)
  {
    const int first = packet * std::countr_zero(packets);
    narrowed.enter(rays, first, (1u << std::min(packet, count - first)) - 1, entries);
  }
  return packets;
}

/// walkBlock() for a vector of rays from the i-th on, on from where they enter.
HWY_INLINE void walk(
  const CrossedBlock& block, const SlabRays& rays, const BlockEntries& entries, int i, Crossings& found)
{
  const Tag d;
  const IntTag di;
  const BitsTag du;
  const Doubles infinity = set(std::numeric_limits<double>::infinity());
  std::array<Axis, 3> axes;
  Doubles t0 = hn::Load(d, &entries.t0[i]);
  const Doubles t1 = hn::Load(d, &entries.t1[i]);
  Mask alive = hn::FirstN(d, static_cast<std::size_t>(entries.count - i));
  // Beyond the last ray there may be anything.
  const Integers ray = hn::And(hn::Load(di, &entries.ray[i]), hn::Set(di, SlabRays::most - 1));
  const Doubles limit = hn::GatherIndex(d, rays.limit.data(), ray);
  Doubles first = hn::Zero(d); // octant
  for (int a = 0; a < 3; ++a)
  {
    Axis& axis = axes[a];
    const auto& p = block.planes.at[a];
    const double octants = 1 << 2 * a; // from one layer to the next
    const Slab slab(
      hn::GatherIndex(d, rays.origin[a].data(), ray), hn::GatherIndex(d, rays.inverse[a].data(), ray));
    const Doubles low = slab.planeAt(set(p[1]));
    const Doubles middle = slab.planeAt(set(p[2]));
    const Doubles high = slab.planeAt(set(p[3]));
    const std::array<Doubles, 3> planeT{ hn::IfThenElse(
                                           slab.crosses, hn::IfThenElse(slab.up, low, high), infinity),
      hn::IfThenElse(slab.crosses, middle, infinity),
      hn::IfThenElse(slab.crosses, hn::IfThenElse(slab.up, high, low), infinity) };
    // Each only where the one before is.
    const std::array<Mask, 3> isPassed{ hn::Le(planeT[0], t0), hn::Le(planeT[1], t0), hn::Le(planeT[2], t0) };
    axis.next = hn::IfThenElse(isPassed[2], infinity,
      hn::IfThenElse(isPassed[1], planeT[2], hn::IfThenElse(isPassed[0], planeT[1], planeT[0])));
    axis.second = hn::IfThenElse(isPassed[1], infinity, hn::IfThenElse(isPassed[0], planeT[2], planeT[1]));
    axis.third = hn::IfThenElse(isPassed[0], infinity, planeT[2]);
    const Doubles passed = countTrue(isPassed[0], isPassed[1], isPassed[2]);
    const Doubles stays = countTrue(
      hn::Ge(slab.origin, set(p[1])), hn::Ge(slab.origin, set(p[2])), hn::Ge(slab.origin, set(p[3])));
    const Doubles cell =
      hn::IfThenElse(slab.crosses, hn::IfThenElse(slab.up, passed, hn::Sub(set(3.), passed)), stays);
    first = hn::Add(first, hn::Mul(set(octants), cell));
    axis.step = hn::ConvertTo(
      di, hn::IfThenElseZero(slab.crosses, hn::IfThenElse(slab.up, set(octants), set(-octants))));
  }
  Integers octant = hn::ConvertTo(di, first);
  const auto rayCode = hn::ShiftLeft<32>(ray);
  const auto active = hn::Set(du, block.record->active);
  const auto low6 = hn::Set(di, 63);
  for (;;)
  {
    const Doubles tOut = hn::Min(hn::Min(axes[0].next, axes[1].next), hn::Min(axes[2].next, t1));
    // Of the octants of rays that are through the block only the bits of a number count.
    const Integers inBlock = hn::And(octant, low6);
    const auto isActive = hn::TestBit(hn::Shr(active, hn::BitCast(du, inBlock)), hn::Set(du, 1));
    found.add(hn::And(hn::And(alive, hn::Lt(t0, tOut)), hn::RebindMask(d, isActive)), t0, tOut,
      hn::Or(rayCode, inBlock));
    alive = hn::And(alive, hn::And(hn::Lt(tOut, t1), hn::Le(tOut, limit)));
    if (hn::AllFalse(d, alive))
    {
      return;
    }
    t0 = hn::Max(t0, tOut);
    const Mask x = hn::Eq(axes[0].next, tOut);
    const Mask y = hn::AndNot(x, hn::Eq(axes[1].next, tOut));
    const Mask z = hn::Not(hn::Or(x, y));
    axes[0].advance(x);
    axes[1].advance(y);
    axes[2].advance(z);
    octant = hn::Add(hn::Add(octant, axes[0].stepOf(x)), hn::Add(axes[1].stepOf(y), axes[2].stepOf(z)));
  }
}

/// A vector of crossings, as OctantCrossing: the octants' first vertices, and the places in them.
struct Places
{
  Integers vertex;
  std::array<Doubles, 3> from;
  std::array<Doubles, 3> part; // from there to the end

  HWY_INLINE Places(
    const BlockPlanes& planes, const SlabRays& rays, Integers ray, Integers octant, Doubles t0, Doubles t1)
  {
    const Tag d;
    const IntTag di;
    const Integers y = hn::ShiftRight<2>(octant);
    const Integers z = hn::ShiftRight<4>(octant);
    // x + 5 y + 25 z of x + 4 y + 16 z.
    vertex = hn::Add(hn::Add(octant, y), hn::Add(z, hn::ShiftLeft<2>(z)));
    const std::array<Integers, 3> cells{ hn::And(octant, hn::Set(di, 3)), hn::And(y, hn::Set(di, 3)), z };
    for (int a = 0; a < 3; ++a)
    {
      const auto& inverse = planes.inverseWidth[a];
      Doubles plane;
      Doubles perOctant;
      if (planes.isUniform) // then all of these are numbers without rounding
      {
        plane = hn::Add(set(planes.at[a][0]), hn::Mul(hn::ConvertTo(d, cells[a]), set(1. / inverse[0])));
        perOctant = set(inverse[0]);
      }
      else
      {
        plane = hn::GatherIndex(d, planes.at[a].data(), cells[a]);
        perOctant = hn::GatherIndex(d, inverse.data(), cells[a]);
      }
      const Doubles origin = hn::Sub(hn::GatherIndex(d, rays.origin[a].data(), ray), plane);
      const Doubles direction = hn::GatherIndex(d, rays.direction[a].data(), ray);
      const auto place = [&](Doubles t) {
        const Doubles x = hn::Mul(hn::Add(origin, hn::Mul(t, direction)), perOctant);
        return hn::Min(hn::Max(x, hn::Zero(d)), set(1.));
      };
      from[a] = place(t0);
      part[a] = hn::Sub(place(t1), from[a]);
    }
  }
};

void CrossBlock(std::span<const double> isovalues, int firstIsovalue, const SlabRays& rays,
  const BlockEntries& entries, OctantCandidates& found)
{
  const Tag d;
  const IntTag di;
  const CrossedBlock& block = found.last();
  const SurfaceRecord& record = *block.record;
  const BlockPlanes& planes = block.planes;
  Crossings crossings;
  for (int i = 0; i < entries.count; i += lanes)
  {
    walk(block, rays, entries, i, crossings);
  }
  const Doubles perWidth =
    set(std::max({ planes.inverseWidth[0][0], planes.inverseWidth[1][0], planes.inverseWidth[2][0] }));
  // Beyond the last crossing there may be anything.
  const auto all = hn::Set(di, (static_cast<std::int64_t>(SlabRays::most - 1) << 32) | 63);
  const auto blockCode =
    hn::Set(di, static_cast<std::int64_t>(found.blockCount - 1) << OctantCandidates::blockShift);
  for (int i = 0; i < crossings.count; i += lanes)
  {
    const Mask valid = hn::FirstN(d, static_cast<std::size_t>(crossings.count - i));
    const Doubles t0 = hn::LoadU(d, &crossings.t0[i]);
    const Doubles t1 = hn::LoadU(d, &crossings.t1[i]);
    const Integers code = hn::And(hn::LoadU(di, &crossings.code[i]), all);
    const Integers ray = hn::ShiftRight<32>(code);
    const Integers octant = hn::And(code, hn::Set(di, 63));
    const Places places(planes, rays, ray, octant, t0, t1);
    const Doubles rounding = hn::GatherIndex(d, rays.rounding.data(), ray);
    const Doubles tolerance =
      hn::Add(set(record.tolerance), hn::Mul(hn::Mul(set(record.width()), rounding), perWidth));
    CornerValues values;
    for (int corner = 0; corner < 8; ++corner)
    {
      const int offset = (corner & 1) + 5 * (corner >> 1 & 1) + 25 * (corner >> 2);
      values.at[corner] = hn::GatherIndex(d, record.values.data() + offset, places.vertex);
    }
    Hull hull{};
    if (isovalues.size() > 1)
    {
      hull = Hull(values.nearlyAlong(places.from, places.part));
    }
    for (std::size_t surface = 0; surface < isovalues.size(); ++surface)
    {
      const Doubles isovalue = set(isovalues[surface]);
      // That of the field alone has been rounded otherwise, by less than the tolerance.
      if (isovalues.size() > 1 &&
        hn::AllFalse(d, hn::And(valid, hull.has(isovalue, hn::Mul(set(4.), tolerance)))))
      {
        continue;
      }
      const std::array<Doubles, 4> cubic = values.along(isovalue, places.from, places.part);
      const Mask keep = hn::And(valid, Hull(cubic).has(hn::Zero(d), tolerance));
      if (hn::AllFalse(d, keep))
      {
        continue;
      }
      const int at = found.count;
      const Packing packing(keep);
      packing.store(t0, &found.t0[at]);
      packing.store(t1, &found.t1[at]);
      for (int c = 0; c < 4; ++c)
      {
        packing.store(cubic[c], &found.cubic[c][at]);
      }
      for (int a = 0; a < 3; ++a)
      {
        packing.store(places.from[a], &found.from[a][at]);
        packing.store(places.part[a], &found.part[a][at]);
      }
      packing.store(tolerance, &found.tolerance[at]);
      const auto number = static_cast<std::int64_t>(firstIsovalue + surface);
      const Integers codes =
        hn::Or(hn::Or(code, blockCode), hn::Set(di, number << OctantCandidates::isovalueShift));
      packing.store(codes, &found.code[at]);
      found.count += packing.count();
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(EnterBlock);
HWY_EXPORT(EnterBlockByPackets);
HWY_EXPORT(CrossBlock);

void enterBlock(const CrossedBlock& block, const SlabRays& rays, int first, std::uint32_t wanted,
  BlockEntries& entries) noexcept
{
  HWY_DYNAMIC_DISPATCH(EnterBlock)(block, rays, first, wanted, entries);
}

std::uint32_t enterBlockByPackets(const CrossedBlock& block, const SlabRays& rays, int count,
  std::uint32_t packets, BlockEntries& entries) noexcept
{
  return HWY_DYNAMIC_DISPATCH(EnterBlockByPackets)(block, rays, count, packets, entries);
}

void crossBlock(std::span<const double> isovalues, int firstIsovalue, const SlabRays& rays,
  const BlockEntries& entries, OctantCandidates& found) noexcept
{
  HWY_DYNAMIC_DISPATCH(CrossBlock)(isovalues, firstIsovalue, rays, entries, found);
}

} // namespace treeamr
#endif

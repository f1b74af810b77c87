// The blocks that a tile's rays come to: its beam down the hierarchy of their boxes.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/FindBlocks.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/BlockBoxes.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

constexpr int packets = SlabRays::most / PixelRays::most;

/// Beams of some rays each, side by side: after t, which counts from the nearest start of all rays, those of a beam are
/// between low + t slow and high + t fast. Where the domain is a unit cube.
template <int count>
struct Beams
{
  using Component = std::array<double, count>;
  alignas(64) std::array<Component, 3> low;
  alignas(64) std::array<Component, 3> high;
  alignas(64) std::array<Component, 3> perSlow; // 1 / slow
  alignas(64) std::array<Component, 3> perFast;
};

/// 1 / speed, for a speed that is changed a little to the given side where it is as good as none.
double reciprocal(double speed, double side)
{
  constexpr double least = 1e-300;
  return 1. / (std::abs(speed) < least ? side * least : speed);
}

/// Sets the beams of the packets, and the one of all; returns the t that no ray goes beyond.
double setBeams(
  const TraceSpace& space, const SlabRays& rays, int count, Beams<packets>& ofPackets, Beams<1>& ofAll)
{
  const Tag d;
  double start = rays.enter[0];
  double end = rays.leave[0];
  for (int i = 1; i < count; ++i)
  {
    start = std::min(start, rays.enter[i]);
    end = std::max(end, rays.leave[i]);
  }
  const Doubles infinity = set(std::numeric_limits<double>::infinity());
  for (int a = 0; a < 3; ++a)
  {
    std::array<double, 4> all{ hn::GetLane(infinity), -hn::GetLane(infinity), hn::GetLane(infinity),
      -hn::GetLane(infinity) };
    for (int p = 0; PixelRays::most * p < count; ++p)
    {
      Doubles low = infinity;
      Doubles high = hn::Neg(infinity);
      Doubles slow = infinity;
      Doubles fast = hn::Neg(infinity);
      for (int i = PixelRays::most * p; i < PixelRays::most * (p + 1) && i < count; i += lanes)
      {
        const Mask valid = hn::FirstN(d, static_cast<std::size_t>(count - i));
        const Doubles direction = hn::Load(d, &rays.direction[a][i]);
        const Doubles place =
          hn::Mul(hn::Sub(hn::Add(hn::Load(d, &rays.origin[a][i]), hn::Mul(set(start), direction)),
                    set(space.domain().min[a])),
            set(space.perExtent(a)));
        // Several times what the place is rounded by, here and where the ray is crossed with a block.
        const Doubles error = hn::Mul(hn::Load(d, &rays.rounding[i]), set(4. * space.perExtent(a)));
        const Doubles speed = hn::Mul(direction, set(space.perExtent(a)));
        low = hn::Min(low, hn::IfThenElse(valid, hn::Sub(place, error), infinity));
        high = hn::Max(high, hn::IfThenElse(valid, hn::Add(place, error), hn::Neg(infinity)));
        slow = hn::Min(slow, hn::IfThenElse(valid, speed, infinity));
        fast = hn::Max(fast, hn::IfThenElse(valid, speed, hn::Neg(infinity)));
      }
      const std::array<double, 4> own{ hn::GetLane(hn::MinOfLanes(d, low)),
        hn::GetLane(hn::MaxOfLanes(d, high)), hn::GetLane(hn::MinOfLanes(d, slow)),
        hn::GetLane(hn::MaxOfLanes(d, fast)) };
      ofPackets.low[a][p] = own[0];
      ofPackets.high[a][p] = own[1];
      ofPackets.perSlow[a][p] = reciprocal(own[2], -1.);
      ofPackets.perFast[a][p] = reciprocal(own[3], 1.);
      all = { std::min(all[0], own[0]), std::max(all[1], own[1]), std::min(all[2], own[2]),
        std::max(all[3], own[3]) };
    }
    ofAll.low[a][0] = all[0];
    ofAll.high[a][0] = all[1];
    ofAll.perSlow[a][0] = reciprocal(all[2], -1.);
    ofAll.perFast[a][0] = reciprocal(all[3], 1.);
  }
  return (end - start) * (1. + 0x1p-40);
}

/// Of vectors of beams and boxes the part [in, out] of t in which they may meet.
struct Meeting
{
  Doubles in;
  Doubles out;

  HWY_INLINE explicit Meeting(double length)
    : in(hn::Zero(Tag()))
    , out(set(length))
  {
  }
  /// With the beams' bounds and the boxes' along an axis.
  HWY_INLINE void narrow(
    Doubles low, Doubles high, Doubles perSlow, Doubles perFast, Doubles boxLow, Doubles boxHigh)
  {
    const Tag d;
    const Doubles infinity = set(std::numeric_limits<double>::infinity());
    // low + t slow <= boxHigh
    const Doubles toHigh = hn::Mul(hn::Sub(boxHigh, low), perSlow);
    const Mask rises = hn::Gt(perSlow, hn::Zero(d));
    out = hn::Min(out, hn::IfThenElse(rises, toHigh, infinity));
    in = hn::Max(in, hn::IfThenElse(rises, hn::Zero(d), toHigh));
    // high + t fast >= boxLow
    const Doubles toLow = hn::Mul(hn::Sub(boxLow, high), perFast);
    const Mask falls = hn::Lt(perFast, hn::Zero(d));
    out = hn::Min(out, hn::IfThenElse(falls, toLow, infinity));
    in = hn::Max(in, hn::IfThenElse(falls, hn::Zero(d), toLow));
  }
  HWY_INLINE std::uint32_t bits() const
  {
    std::array<std::uint8_t, 8> bytes{};
    hn::StoreMaskBits(Tag(), hn::Le(in, out), bytes.data());
    return bytes[0];
  }
};

class Search
{
public:
  Search(const TraceSpace& space, const BoxLevels& levels, const SlabRays& rays, int count,
    std::vector<MetBlock>& found)
    : levels_(levels)
    , found_(found)
    , existing_((1u << (count + PixelRays::most - 1) / PixelRays::most) - 1)
  {
    length_ = setBeams(space, rays, count, ofPackets_, ofAll_);
    for (int a = 0; a < 3; ++a)
    {
      along_[a] = static_cast<float>(rays.direction[a][0] / space.perExtent(a));
    }
  }

  void descend(std::size_t level, std::size_t group) const
  {
    const BoxGroup& boxes = levels_[level][group];
    for (std::uint32_t met = this->meetsAll(boxes); met != 0; met &= met - 1)
    {
      const int k = std::countr_zero(met);
      const std::size_t box = BoxGroup::size * group + k;
      if (level != 0)
      {
        this->descend(level - 1, box);
      }
      else if (const std::uint32_t packets = this->packetsThatMeet(boxes, k))
      {
        found_.emplace_back(static_cast<std::uint32_t>(box), packets, this->depthOf(boxes, k));
      }
    }
  }

private:
  /// Bits of the boxes that the beam of all rays meets.
  std::uint32_t meetsAll(const BoxGroup& boxes) const
  {
    const Tag d;
    const hn::Rebind<float, Tag> df;
    std::uint32_t met = 0;
    for (int i = 0; i < BoxGroup::size; i += lanes)
    {
      Meeting meeting(length_);
      for (int a = 0; a < 3; ++a)
      {
        meeting.narrow(set(ofAll_.low[a][0]), set(ofAll_.high[a][0]), set(ofAll_.perSlow[a][0]),
          set(ofAll_.perFast[a][0]), hn::PromoteTo(d, hn::Load(df, &boxes.low[a][i])),
          hn::PromoteTo(d, hn::Load(df, &boxes.high[a][i])));
      }
      met |= meeting.bits() << i;
    }
    return met;
  }
  /// Bits of the packets that meet the k-th.
  std::uint32_t packetsThatMeet(const BoxGroup& boxes, int k) const
  {
    const Tag d;
    std::uint32_t met = 0;
    for (int i = 0; i < packets; i += lanes)
    {
      Meeting meeting(length_);
      for (int a = 0; a < 3; ++a)
      {
        meeting.narrow(hn::Load(d, &ofPackets_.low[a][i]), hn::Load(d, &ofPackets_.high[a][i]),
          hn::Load(d, &ofPackets_.perSlow[a][i]), hn::Load(d, &ofPackets_.perFast[a][i]),
          set(boxes.low[a][k]), set(boxes.high[a][k]));
      }
      met |= meeting.bits() << i;
    }
    return met & existing_;
  }

  /// That of the middle, on the first ray.
  float depthOf(const BoxGroup& boxes, int k) const
  {
    float depth = 0.f;
    for (int a = 0; a < 3; ++a)
    {
      depth += (boxes.low[a][k] + boxes.high[a][k]) * along_[a];
    }
    return depth;
  }

  const BoxLevels& levels_;
  std::vector<MetBlock>& found_;
  std::array<float, 3> along_; // the first ray, where the domain is a unit cube
  std::uint32_t existing_;     // bits of packets that have rays
  Beams<packets> ofPackets_{};
  Beams<1> ofAll_{};
  double length_;
};

void FindBlocks(const TraceSpace& space, const BoxLevels& levels, const SlabRays& rays, int count,
  std::vector<MetBlock>& found)
{
  Search(space, levels, rays, count, found).descend(levels.size() - 1, 0);
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(FindBlocks);

void findBlocks(const TraceSpace& space, const BoxLevels& levels, const SlabRays& rays, int count,
  std::vector<MetBlock>& found)
{
  if (count > 0 && !levels.empty() && !levels[0].empty())
  {
    HWY_DYNAMIC_DISPATCH(FindBlocks)(space, levels, rays, count, found);
  }
}

} // namespace treeamr
#endif

// What rays make of values, unlike light of any order: the largest or the smallest one, or sums. Compiled once for each
// instruction set, as Highway wants it.
//
// An extreme is exact: in each octant the field is a cubic along the ray, whose turning points are known. An octant
// whose vertices are below what a ray has costs one look at them, nodes and blocks nothing.
#if defined(TREEAMR_VOLUMEBLENDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMEBLENDS_INL_H
#undef TREEAMR_VOLUMEBLENDS_INL_H
#else
#define TREEAMR_VOLUMEBLENDS_INL_H
#endif

#include "Volume/Kernel/NodeQueue.h"
#include "Volume/Kernel/VolumeCubics-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeRays-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

template <class Real, VolumeLoop Loop>
class RayBlends;

/// A node that rays of a tile have still to visit.
template <class Real>
struct WaitingNode
{
  std::uint64_t node;
  Range range;
  Box<Real> box;
  std::array<Coord, 3> index;
  int depth;
  GroupMask active;
  Real most; // places
  Real least;
};

/// A block's values, and for each octant the largest one of its vertices, or the smallest where places fall: most octants
/// need no more than one look at that.
template <class Values>
class BoundedValues : public Values
{
  using Element = typename Values::Element;

public:
  BoundedValues(const Element* values, bool isFalling)
    : Values{ values }
    , mostOf_{ isFalling ? this->template bound<true>(values) : this->template bound<false>(values) }
  {
  }

  /// Of the octants whose lowest vertices these are.
  template <class Index>
  HWY_INLINE auto mostOf(Index vertex) const
  {
    return mostOf_.at(vertex);
  }

private:
  static constexpr int count = 128;

  template <bool IsFalling>
  const Element* bound(const Element* values)
  {
    const hn::CappedTag<Element, 32> d;
    std::copy_n(values, count, bounds_);
    for (const int next : { 1, 5, 25 }) // along x, y, z
    {
      for (int i = 0; i < count; i += hn::Lanes(d))
      {
        const auto own = hn::Load(d, bounds_ + i);
        const auto other = hn::LoadU(d, bounds_ + i + next);
        hn::Store(IsFalling ? hn::Min(own, other) : hn::Max(own, other), d, bounds_ + i);
      }
    }
    return bounds_;
  }

  HWY_ALIGN Element bounds_[count + 32] = {};
  Values mostOf_;
};

/// The largest places so far.
template <class Real>
class RayBlends<Real, VolumeLoop::Extreme>
{
public:
  explicit RayBlends(const VolumeKernelScene& scene)
    : scene_(scene)
    , limit_(scene.settings.skipEmpty ? this->mostOf(scene.field.range()) : -nothing)
  {
  }

  void start() noexcept { std::fill_n(most_, tileRays, nothing); }
  /// With what rays have (showBlend()).
  void start(const Real* places, const Real* areThere) noexcept
  {
    for (int ray = 0; ray < tileRays; ++ray)
    {
      most_[ray] = areThere[ray] != 0 ? places[ray] : nothing;
    }
  }

  NodeQueue<WaitingNode<Real>>& queue() noexcept { return queue_; }

  /// Of groups those that have rays which have less than a place.
  GroupMask open(GroupMask active, Real place) const
  {
    const RealTag<Real> d;
    const Reals<Real> most = hn::Set(d, scene_.settings.skipEmpty ? place : -nothing);
    GroupMask groups = active;
    for (; active != 0; active &= active - 1)
    {
      const int group = std::countr_zero(active);
      Mask<Real> any = hn::Lt(hn::Load(d, most_ + group * groupRays), most);
      for (int ray = lanes<Real>; ray < groupRays; ray += lanes<Real>)
      {
        any = hn::Or(any, hn::Lt(hn::Load(d, most_ + group * groupRays + ray), most));
      }
      groups &= ~(static_cast<GroupMask>(hn::AllFalse(d, any)) << group);
    }
    return groups;
  }
  ///@{
  /// Places of a range.
  Real mostOf(const Range& range) const noexcept { return std::max(placeOf(range.min), placeOf(range.max)); }
  Real leastOf(const Range& range) const noexcept { return std::min(placeOf(range.min), placeOf(range.max)); }
  ///@}

  /// Whether rays from `ray` on have less than a place.
  HWY_INLINE Mask<Real> areOpen(int ray, Real place) const
  {
    const RealTag<Real> d;
    return hn::Lt(hn::Load(d, most_ + ray), hn::Set(d, scene_.settings.skipEmpty ? place : -nothing));
  }

  /// Takes the rays from `ray` on that are open through a span; the number of vectors of octants.
  template <class Values>
  HWY_INLINE std::uint64_t take(const Span<Real>& span, Mask<Real> open, const BoundedValues<Values>& values,
    const ToTable<Real>& toTable, const Lattice<Real>& lattice, int ray, Reals<Real>& samples)
  {
    const RealTag<Real> d;
    Reals<Real> most = hn::Load(d, most_ + ray);
    const Reals<Real> one = hn::Set(d, Real(1));
    // The bounds of all octants first: what waits for each of them in turn takes longer.
    Octant octants[OctantWalk<Real>::most];
    OctantWalk<Real> walk(span, lattice);
    int count = 0;
    for (Reals<Real> begin = hn::Zero(d); count < OctantWalk<Real>::most; ++count)
    {
      const Mask<Real> active = hn::And(open, hn::Lt(begin, one));
      if (hn::AllFalse(d, active))
      {
        break;
      }
      samples = hn::Add(samples, hn::IfThenElseZero(active, one));
      const Reals<Real> end = hn::Min(walk.end(), one);
      const Reals<Real> bound = inTable(toTable, values.mostOf(walk.vertex()));
      octants[count] = { begin, end, hn::IfThenElse(active, bound, hn::Set(d, nothing)) };
      walk.goOn();
      begin = end;
    }
    for (const Octant& octant : std::span(octants, count))
    {
      const Mask<Real> isMore = hn::Lt(most, octant.bound);
      if (!hn::AllFalse(d, isMore))
      {
        const Reals<Real> largest = largestIn(octant, span, values, toTable, lattice, most);
        most = hn::IfThenElse(isMore, hn::Min(largest, octant.bound), most);
      }
    }
    hn::Store(most, d, most_ + ray);
    return static_cast<std::uint64_t>(count);
  }

  /// Takes some rays from `ray` on through a constant.
  HWY_INLINE void take(Mask<Real> taken, Reals<Real> place, int ray)
  {
    const RealTag<Real> d;
    const Reals<Real> most = hn::Load(d, most_ + ray);
    hn::Store(hn::IfThenElse(taken, hn::Max(most, place), most), d, most_ + ray);
  }

  /// Whether rays from `ray` on have the most that there is.
  Mask<Real> areDone(int ray) const
  {
    const RealTag<Real> d;
    return hn::Ge(hn::Load(d, most_ + ray), hn::Set(d, limit_));
  }

  /// Colour times opacity, and opacity.
  std::array<Real, 4> result(int ray, bool /*crosses*/)
  {
    if (most_[ray] != last_) // many have the most that there is
    {
      last_ = most_[ray];
      const std::array<double, 4> color = colorOfExtreme(scene_, last_);
      std::copy(color.begin(), color.end(), result_.begin());
    }
    return last_ == nothing ? std::array<Real, 4>{} : result_;
  }
  /// As showBlend() takes it.
  std::array<Real, 4> unfinished(int ray, bool /*crosses*/) const
  {
    return most_[ray] == nothing ? std::array<Real, 4>{} : std::array<Real, 4>{ most_[ray], 1, 0, 0 };
  }

private:
  struct Octant
  {
    Reals<Real> begin; // of the span
    Reals<Real> end;
    Reals<Real> bound; // of places
  };

  /// What rays meet in an octant, unless that is less than `most`.
  template <class Values>
  static HWY_INLINE Reals<Real> largestIn(const Octant& octant, const Span<Real>& span, const Values& values,
    const ToTable<Real>& toTable, const Lattice<Real>& lattice, Reals<Real> most)
  {
    const RealTag<Real> d;
    const Spot<Real> middle = locate(span, hn::Mul(hn::Add(octant.begin, octant.end), half<Real>()), lattice);
    Reals<Real> lower[4];
    Reals<Real> upper[4];
    values.pairs(middle.vertex, lower, upper);
    const Reals<Real> halfWay = hn::Mul(hn::Mul(hn::Sub(octant.end, octant.begin), half<Real>()), span.step);
    const Reals<Real> way[3] = { hn::Mul(halfWay, span.slope[0]), hn::Mul(halfWay, span.slope[1]),
      hn::Mul(halfWay, span.slope[2]) };
    const CenteredCubic<Real> cubic(middle.f, way, lower, upper, toTable);
    const Reals<Real> ofEnds = hn::Max(hn::Max(cubic.begin(), cubic.end()), most);
    const Mask<Real> mayTurn = hn::Lt(ofEnds, cubic.mostInside());
    return hn::AllFalse(d, mayTurn) ? ofEnds : cubic.largestTurn(mayTurn, ofEnds);
  }

  static constexpr Real nothing = -std::numeric_limits<Real>::infinity();

  Real placeOf(float value) const noexcept
  {
    return static_cast<Real>((value - scene_.placeOrigin) * scene_.perValue);
  }

  const VolumeKernelScene& scene_;
  NodeQueue<WaitingNode<Real>> queue_;
  Real limit_; // of places; infinite where nothing is skipped
  HWY_ALIGN Real most_[tileRays];
  Real last_ = nothing; // place of which there is a result
  std::array<Real, 4> result_{};
};

/// Integrals of opacity times place so far, and the lengths that count.
template <class Real>
class RayBlends<Real, VolumeLoop::Sum>
{
public:
  explicit RayBlends(const VolumeKernelScene& scene)
    : scene_(scene)
    , entries_(&scene.table.entries.data()->r)
  {
    // Places are of the field, the table's entries of the function.
    const double perPlace = scene.perValue > 0. ? 1. / scene.perValue : 0.;
    const double perValue = scene.transferFunction.scale() * scene.table.perEntry;
    constexpr double far = 0x1p100;
    perEntry_ = static_cast<Real>(std::clamp(perPlace * perValue, -far, far));
    firstEntry_ =
      static_cast<Real>(std::clamp((scene.placeOrigin - scene.transferFunction.min()) * perValue, -far, far));
    const auto placeOf = [&](float value) {
      // Of a field of one value all others are far from its place.
      const double difference = value - scene.placeOrigin;
      const double place = scene.perValue > 0. || difference == 0. ? difference * scene.perValue
                                                                   : std::copysign(far, difference);
      return static_cast<Real>(std::clamp(place, -far, far));
    };
    const bool isAverage = scene.settings.blend == VolumeBlend::Average;
    firstCounted_ = isAverage ? placeOf(scene.settings.averageRange.min) : static_cast<Real>(-far);
    lastCounted_ = isAverage ? placeOf(scene.settings.averageRange.max) : static_cast<Real>(far);
  }

  void start() noexcept
  {
    std::fill_n(sum_, tileRays, Real(0));
    std::fill_n(length_, tileRays, Real(0));
  }
  /// With what rays have (showBlend()).
  void start(const Real* sums, const Real* lengths) noexcept
  {
    std::copy_n(sums, tileRays, sum_);
    std::copy_n(lengths, tileRays, length_);
  }

  /// Takes the rays from `ray` on through the steps of a span, the most of any ray: in each the field is taken for
  /// linear, so that a part of it counts where it leaves the range.
  template <class Values>
  HWY_INLINE void take(const Span<Real>& span, Real mostSteps, const Values& values,
    const ToTable<Real>& toTable, const Lattice<Real>& lattice, int ray)
  {
    const RealTag<Real> d;
    const Reals<Real> zero = hn::Zero(d);
    const Reals<Real> one = hn::Set(d, Real(1));
    const Reals<Real> unit = hn::Set(d, depthOfUnit());
    const Reals<Real> first = hn::Set(d, firstCounted_);
    const Reals<Real> last = hn::Set(d, lastCounted_);
    Reals<Real> sum = zero;
    Reals<Real> count = zero;
    Reals<Real> begin[1];
    Reals<Real> ends[1] = { zero };
    sample(span, ends, values, toTable, lattice, begin);
    for (Real i = 0; i < mostSteps; ++i)
    {
      Reals<Real> end[1];
      ends[0] = hn::Set(d, i + 1);
      sample(span, ends, values, toTable, lattice, end);
      const Reals<Real> from = hn::Min(hn::Max(begin[0], first), last);
      const Reals<Real> to = hn::Min(hn::Max(end[0], first), last);
      const Reals<Real> rise = hn::Abs(hn::Sub(end[0], begin[0]));
      const Mask<Real> isFlat = hn::Eq(rise, zero);
      const Reals<Real> inRange = hn::IfThenElse(isFlat, hn::IfThenElseZero(hn::Eq(from, begin[0]), one),
        hn::Div(hn::Abs(hn::Sub(to, from)), hn::IfThenElse(isFlat, one, rise)));
      const Reals<Real> part = hn::IfThenElseZero(hn::Lt(hn::Set(d, i), span.samples), inRange);
      const Reals<Real> place = hn::Mul(hn::Add(from, to), half<Real>());
      const Reals<Real> entry = mulAdd(place, hn::Set(d, perEntry_), hn::Set(d, firstEntry_));
      const Reals<Real> inside = hn::Min(hn::Max(entry, zero), hn::Set(d, Real(scene_.table.last)));
      const Reals<Real> extinction = gather<Real>(entries_ + 3, hn::ShiftLeft<2>(nearest<Real>(inside)));
      const Reals<Real> opacity = heldBack(hn::Neg(hn::Mul(extinction, unit)));
      sum = mulAdd(part, hn::Mul(opacity, place), sum);
      count = hn::Add(count, part);
      begin[0] = end[0];
    }
    hn::Store(mulAdd(sum, span.depthPerExtinction, hn::Load(d, sum_ + ray)), d, sum_ + ray);
    hn::Store(mulAdd(count, span.depthPerExtinction, hn::Load(d, length_ + ray)), d, length_ + ray);
  }

  /// Takes some rays from `ray` on through a constant, whose extinction the table has, over lengths.
  HWY_INLINE void take(
    Mask<Real> taken, Reals<Real> place, Reals<Real> extinction, Reals<Real> lengths, int ray)
  {
    const RealTag<Real> d;
    const Mask<Real> isCounted = hn::And(
      taken, hn::And(hn::Ge(place, hn::Set(d, firstCounted_)), hn::Le(place, hn::Set(d, lastCounted_))));
    const Reals<Real> count = hn::IfThenElseZero(isCounted, lengths);
    const Reals<Real> opacity = heldBack(hn::Neg(hn::Mul(extinction, hn::Set(d, depthOfUnit()))));
    hn::Store(mulAdd(count, hn::Mul(opacity, place), hn::Load(d, sum_ + ray)), d, sum_ + ray);
    hn::Store(hn::Add(count, hn::Load(d, length_ + ray)), d, length_ + ray);
  }

  /// crosses: whether any of the ray is in the domain.
  std::array<Real, 4> result(int ray, bool crosses) const
  {
    const std::array<double, 4> color = colorOfSum(scene_, sum_[ray], length_[ray], crosses);
    std::array<Real, 4> result;
    std::copy(color.begin(), color.end(), result.begin());
    return result;
  }
  /// As showBlend() takes it.
  std::array<Real, 4> unfinished(int ray, bool crosses) const
  {
    return { sum_[ray], length_[ray], static_cast<Real>(crosses), 0 };
  }

private:
  Real depthOfUnit() const noexcept { return static_cast<Real>(scene_.unitDepth); }

  const VolumeKernelScene& scene_;
  const float* entries_;
  Real perEntry_; // entries for a place
  Real firstEntry_;
  Real firstCounted_;
  Real lastCounted_;
  HWY_ALIGN Real sum_[tileRays];
  HWY_ALIGN Real length_[tileRays];
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

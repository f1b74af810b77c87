// The intervals stage of the volume kernel: a tile's rays through a block, from stop to stop, in steps of what the loop
// makes of them. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMEINTERVALS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMEINTERVALS_INL_H
#undef TREEAMR_VOLUMEINTERVALS_INL_H
#else
#define TREEAMR_VOLUMEINTERVALS_INL_H
#endif

#include "Volume/Kernel/PackedRays-inl.h"
#include "Volume/Kernel/SampleCopies-inl.h"
#include "Volume/Kernel/VolumeBlocks-inl.h"
#include "Volume/Kernel/VolumeIntegrals-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeRays-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

// Of the loops that need them: see VolumeLight-inl.h and VolumeBlends-inl.h.
template <class Real>
class LightOnRays;
template <class Real>
class GradientSource;
template <class Real>
class MixtureSource;
template <class Values>
class BoundedValues;
template <class Real, VolumeLoop Loop>
class RayBlends;
/// Of all others.
struct Nothing
{
  explicit Nothing(const VolumeKernelScene& /*scene*/) {}
};
struct NoMixture : Nothing // empty members of one type would not share their place
{
  using Nothing::Nothing;
};

/// See TileRays.
template <class Real, RayOrigins Origins, VolumeLoop Loop>
class TileIntervals : public TileRays<Real, Origins>
{
  using Rays = TileRays<Real, Origins>;

public:
  static constexpr bool isLit = Loop == VolumeLoop::Lit;
  static constexpr bool isExtreme = Loop == VolumeLoop::Extreme;
  static constexpr bool isSum = Loop == VolumeLoop::Sum;
  static constexpr bool isComposite = !isExtreme && !isSum;

  explicit TileIntervals(const VolumeKernelScene& scene)
    : Rays(scene)
    , gradients_(scene)
    , mixture_(scene)
    , blends_(scene)
    , scene_(scene)
    , table_(&scene.table.entries.data()->r)
    , samplesPerCell_(static_cast<Real>(scene.settings.samplesPerCell))
    , integralLimits_{ integralTolerance / samplesPerCell_,
      static_cast<Real>(scene.settings.leastTransmittance) }
  {
  }

  /// Takes the rays of groups through a box of a block.
  void integrate(
    const Block<Real>& block, const Box<Real>& box, const Lattice<Real>& lattice, GroupMask active)
  {
    if constexpr (isExtreme)
    {
      active = blends_.open(active, block.toTable.last);
      if (active == 0)
      {
        return;
      }
    }
    if constexpr (Block<Real>::samplesSteps)
    {
      if (!block.exact)
      {
        integrate(valuesOf<QuantisedValues>(block.steps, block), block, box, lattice, active);
        return;
      }
    }
    integrate(valuesOf<ExactValues<Real>>(block.exact, block), block, box, lattice, active);
  }

  /// Makes colours of what rays of groups have, where that is not light.
  void resolve(GroupMask groups)
  {
    const RealTag<Real> d;
    const Box<Real> domain = toKernel(scene_.field.octree().grid().bounds());
    for (; groups != 0; groups &= groups - 1)
    {
      const int first = std::countr_zero(groups) * groupRays;
      for (int ray = first; ray < first + groupRays; ray += lanes<Real>)
      {
        Mask<Real> crosses = hn::FirstN(d, 0);
        for (int part = 0; part < parts_; ++part)
        {
          Reals<Real> begin = hn::Load(d, begin_[part] + ray);
          Reals<Real> end = hn::Load(d, end_[part] + ray);
          enterBox(domain, ray, begin, end);
          crosses = hn::Or(crosses, hn::Lt(begin, end));
        }
        std::uint8_t bits[(lanes<Real> + 7) / 8] = {};
        hn::StoreMaskBits(d, crosses, bits);
        for (int i = 0; i < lanes<Real>; ++i)
        {
          const bool isIn = bits[i / 8] >> i % 8 & 1;
          if (scene_.goesOn && opacity_[ray + i] > 0) // another process has shown it
          {
            continue;
          }
          const std::array<Real, 4> rgba = scene_.goesOn
            ? blends_.unfinished(ray + i, isIn || blue_[ray + i] > 0)
            : blends_.result(ray + i, isIn);
          red_[ray + i] = rgba[0];
          green_[ray + i] = rgba[1];
          blue_[ray + i] = rgba[2];
          opacity_[ray + i] = rgba[3];
        }
      }
    }
  }

  Box<Real> toKernel(const Bounds& bounds) const noexcept
  {
    Box<Real> box;
    for (int a = 0; a < 3; ++a)
    {
      box.min[a] = Rays::toKernel(a, bounds.min[a]);
      box.max[a] = Rays::toKernel(a, bounds.max[a]);
    }
    return box;
  }

  /// Adds the samples that lanes have counted.
  void countSamples() noexcept
  {
    statistics_.samples = std::accumulate(samples_, samples_ + lanes<Real>, statistics_.samples);
    std::fill_n(samples_, lanes<Real>, 0);
  }

  /// One for each of these lanes.
  HWY_INLINE void countSamplesOf(Mask<Real> lanes)
  {
    const RealTag<Real> d;
    const IntTag<Real> di;
    const Reals<Real> ones = hn::IfThenElseZero(lanes, hn::Set(d, Real(1)));
    hn::Store(hn::Add(hn::Load(di, samples_), truncated<Real>(ones)), di, samples_);
  }

  [[no_unique_address]] std::conditional_t<isLit, GradientSource<Real>, Nothing> gradients_;
  [[no_unique_address]] std::conditional_t<isLit, MixtureSource<Real>, NoMixture> mixture_;
  std::conditional_t<isComposite, Nothing, RayBlends<Real, Loop>> blends_;
  VolumeStatistics statistics_;

protected:
  using Rays::begin_;
  using Rays::blue_;
  using Rays::crossHits;
  using Rays::direction_;
  using Rays::end_;
  using Rays::enterBox;
  using Rays::finished;
  using Rays::green_;
  using Rays::hasHits_;
  using Rays::lengthPerT_;
  using Rays::nextHitT_;
  using Rays::opacity_;
  using Rays::opaque_;
  using Rays::origin_;
  using Rays::packed;
  using Rays::parts_;
  using Rays::red_;
  using Rays::startAtReference;

  template <class Values>
  static HWY_INLINE auto valuesOf(
    const typename Values::Element* values, [[maybe_unused]] const Block<Real>& block)
  {
    if constexpr (isExtreme)
    {
      return BoundedValues<Values>(values, block.toTable.scale < 0);
    }
    else
    {
      return Values{ values };
    }
  }

  template <class Values>
  void integrate(const Values& values, const Block<Real>& block, const Box<Real>& box,
    const Lattice<Real>& lattice, GroupMask active)
  {
    // Exact values are few: a loop without stops for them would cost more to compile than it saves.
    constexpr bool isFrequent =
      std::is_same_v<Values, QuantisedValues> && (Loop == VolumeLoop::Plain || (isLit && startAtReference));
    if constexpr (isFrequent)
    {
      if (!hasHits_ && !(isLit && block.preIntegrate))
      {
        for (int part = 0; part < parts_; ++part)
        {
          block.preIntegrate ? integrateWithoutStops<!isLit>(values, block, box, lattice, active, part)
                             : integrateWithoutStops<false>(values, block, box, lattice, active, part);
        }
        return;
      }
    }
    for (; active != 0; active &= active - 1)
    {
      const int group = std::countr_zero(active);
      for (int ray = group * groupRays; ray < (group + 1) * groupRays; ray += lanes<Real>)
      {
        if constexpr (isComposite)
        {
          block.preIntegrate ? integrateFromStopToStop<true>(values, block, box, lattice, ray)
                             : integrateFromStopToStop<false>(values, block, box, lattice, ray);
        }
        else
        {
          integrateFromStopToStop<false>(values, block, box, lattice, ray);
        }
      }
    }
  }

  /// A part of rays without hits.
  template <bool PreIntegrated, class Values>
  HWY_INLINE void integrateWithoutStops(const Values& values, const Block<Real>& block, const Box<Real>& box,
    const Lattice<Real>& lattice, GroupMask active, int part)
  {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
    if constexpr (std::is_same_v<Real, float>)
    {
      if ((active & (active - 1)) != 0)
      {
        integratePacked<PreIntegrated>(values, block, box, lattice, active, part);
        return;
      }
    }
#endif
    const RealTag<Real> d;
    for (; active != 0; active &= active - 1)
    {
      const int first = std::countr_zero(active) * groupRays;
      for (int ray = first; ray < first + groupRays; ray += lanes<Real>)
      {
        Reals<Real> begin = hn::Load(d, begin_[part] + ray);
        Reals<Real> end = hn::Load(d, end_[part] + ray);
        enterBox(box, ray, begin, end);
        integrateVector<PreIntegrated>(values, block, lattice, ray, begin, end);
      }
    }
  }

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  /// The same, where groups of which few rays cross the box share a vector.
  template <bool PreIntegrated, class Values>
  HWY_INLINE void integratePacked(const Values& values, const Block<Real>& block, const Box<Real>& box,
    const Lattice<Real>& lattice, GroupMask active, int part)
  {
    const RealTag<Real> d;
    PackedRays rays;
    const Reals<Real> zero = hn::Zero(d);
    Reals<Real> begins = zero;
    Reals<Real> ends = zero;
    Reals<Real> origins[3] = { zero, zero, zero };
    Reals<Real> directions[3] = { zero, zero, zero };
    Reals<Real> lengths = zero;
    Reals<Real> reds = zero;
    Reals<Real> greens = zero;
    Reals<Real> blues = zero;
    Reals<Real> opacities = zero;
    const auto forAll = [&](const auto& use) {
      for (int a = 0; a < 3; ++a)
      {
        use(directions[a], direction_[a]);
        if (!startAtReference)
        {
          use(origins[a], origin_[a]);
        }
      }
      use(lengths, lengthPerT_);
      use(reds, red_);
      use(greens, green_);
      use(blues, blue_);
      use(opacities, opacity_);
    };
    const auto integrateThem = [&] {
      forAll([&](Reals<Real> numbers, Real* ofRays) { hn::Store(numbers, d, ofRays + packed); });
      hn::Store(ends, d, end_[0] + packed);
      integrateVector<PreIntegrated>(values, block, lattice, packed, begins, ends);
      rays.unpack(packed, red_, green_, blue_, opacity_);
      const Mask<Real> done = hn::Eq(hn::Load(d, end_[0] + packed), hn::Set(d, finished));
      if (!hn::AllFalse(d, done))
      {
        for (int p = 0; p < parts_; ++p)
        {
          rays.finish(done, finished, end_[p]);
        }
      }
      rays.clear();
      begins = ends = zero;
    };
    for (; active != 0; active &= active - 1)
    {
      const int ray = std::countr_zero(active) * groupRays;
      Reals<Real> begin = hn::Load(d, begin_[part] + ray);
      Reals<Real> end = hn::Load(d, end_[part] + ray);
      enterBox(box, ray, begin, end);
      const Mask<Real> crosses = hn::Lt(begin, end);
      const int count = static_cast<int>(hn::CountTrue(d, crosses));
      const bool isAlone = rays.count() == 0 && (active & (active - 1)) == 0;
      if (isAlone || 4 * count > 3 * lanes<Real>)
      {
        integrateVector<PreIntegrated>(values, block, lattice, ray, begin, end);
        continue;
      }
      if (count == 0)
      {
        continue;
      }
      if (rays.count() + count > lanes<Real>)
      {
        integrateThem();
      }
      rays.add(ray, crosses, count);
      begins = rays.with(begins, begin);
      ends = rays.with(ends, end);
      forAll([&](Reals<Real>& numbers, const Real* ofRays) {
        numbers = rays.with(numbers, hn::Load(d, ofRays + ray));
      });
    }
    if (rays.count() > 0)
    {
      integrateThem();
    }
  }
#endif

  template <bool PreIntegrated, class Values>
  HWY_NOINLINE void integrateVector(const Values& values, const Block<Real>& block,
    const Lattice<Real>& lattice, int ray, Reals<Real> begin, Reals<Real> end)
  {
    integratePart<PreIntegrated>(values, block, lattice, ray, begin, end);
  }

  /// The same, from stop to stop.
  template <bool PreIntegrated, class Values>
  HWY_NOINLINE void integrateFromStopToStop(const Values& values, const Block<Real>& block,
    const Box<Real>& box, const Lattice<Real>& lattice, int ray)
  {
    const RealTag<Real> d;
    for (int part = 0; part < parts_; ++part)
    {
      Reals<Real> begin = hn::Load(d, begin_[part] + ray);
      Reals<Real> end = hn::Load(d, end_[part] + ray);
      enterBox(box, ray, begin, end);
      do
      {
        const Reals<Real> stop = hasHits_ ? hn::Min(end, hn::Load(d, nextHitT_ + ray)) : end;
        integratePart<PreIntegrated>(values, block, lattice, ray, begin, stop);
      }
      while (hasHits_ && crossHits(part, ray, begin, end));
    }
  }

  /// Takes the rays from `ray` on from begin to end in a block: by midpoint samples, or by the transfer function's
  /// integrals over what the field covers in each step.
  template <bool PreIntegrated, class Values>
  HWY_INLINE void integratePart(const Values& values, const Block<Real>& block, const Lattice<Real>& lattice,
    int ray, Reals<Real> begin, Reals<Real> end)
  {
    const RealTag<Real> d;
    Mask<Real> crosses = hn::Lt(begin, end);
    if constexpr (isExtreme)
    {
      crosses = hn::And(crosses, blends_.areOpen(ray, block.toTable.last));
    }
    if (hn::AllFalse(d, crosses))
    {
      return;
    }
    ++statistics_.intervals;
    const Reals<Real> length = hn::IfThenElseZero(crosses, hn::Sub(end, begin));
    Span<Real> span;
    Reals<Real> squared = hn::Zero(d);
    for (int a = 0; a < 3; ++a)
    {
      const Reals<Real> direction = hn::Load(d, direction_[a] + ray);
      const Reals<Real> scale = hn::Set(d, lattice.scale[a]);
      Reals<Real> corner = hn::Set(d, -lattice.min[a]);
      if (!startAtReference)
      {
        corner = hn::Add(corner, hn::Load(d, origin_[a] + ray));
      }
      span.start[a] = hn::Mul(mulAdd(begin, direction, corner), scale);
      span.slope[a] = hn::Mul(direction, scale);
      squared = mulAdd(span.slope[a], span.slope[a], squared);
    }
    if constexpr (isExtreme)
    {
      takeExtremes(values, block, lattice, ray, crosses, length, span);
      return;
    }
    takeSteps<PreIntegrated>(values, block, lattice, ray, begin, crosses, length, squared, span);
  }

  /// squared: of the span's slope in the lattice.
  template <bool PreIntegrated, class Values>
  HWY_INLINE void takeSteps(const Values& values, const Block<Real>& block, const Lattice<Real>& lattice,
    int ray, Reals<Real> begin, Mask<Real> crosses, Reals<Real> length, Reals<Real> squared, Span<Real>& span)
  {
    const RealTag<Real> d;
    const Reals<Real> opacity = hn::Load(d, opacity_ + ray);
    const Reals<Real> transmittance = hn::Sub(hn::Set(d, Real(1)), opacity);
    const Reals<Real> lengthPerT = hn::Load(d, lengthPerT_ + ray);
    // Squares: of the way in widths of a leaf, and of what the variation of optical depth on it asks for.
    const Reals<Real> widths = hn::Mul(hn::Mul(squared, hn::Set(d, Real(0.25))), hn::Mul(length, length));
    const Reals<Real> variation = hn::Mul(hn::Mul(length, lengthPerT),
      hn::Mul(
        transmittance, hn::Set(d, samplesPerRootVariation * samplesPerRootVariation * block.variation)));
    const Reals<Real> wanted =
      hn::Mul(hn::Min(widths, variation), hn::Set(d, samplesPerCell_ * samplesPerCell_));
    const Real mostSamples = chooseSteps<Real>(hn::IfThenElseZero(crosses, wanted), length, span);
    span.depthPerExtinction = depthPerExtinction(span.step, lengthPerT);
    span.samples = hn::IfThenElseZero(crosses, span.samples);
    const IntTag<Real> di;
    hn::Store(hn::Add(hn::Load(di, samples_), nearest<Real>(span.samples)), di, samples_);

    if constexpr (isSum)
    {
      statistics_.steps += static_cast<std::uint64_t>(mostSamples);
      blends_.take(span, mostSamples, values, block.toTable, lattice, ray);
      return;
    }
    auto lighting = lightingOf(begin, ray);
    Light<Real> light{ transmittance, opacity, hn::Load(d, red_ + ray), hn::Load(d, green_ + ray),
      hn::Load(d, blue_ + ray) };
    if constexpr (PreIntegrated)
    {
      const std::uint64_t steps = takeIntegrals(
        *scene_.table.integrals, span, integralLimits_, values, block.toTable, lattice, lighting, light);
      statistics_.steps += steps;
      statistics_.litSteps += steps;
    }
    else
    {
      takeAllPoints(span, mostSamples, values, block.toTable, lattice, lighting, crosses, light);
    }
    finishSteps(light, crosses, ray);
  }

  /// crosses: the rays. lighting: may be spread.
  template <class Values, class Lighting>
  HWY_INLINE void takeAllPoints(const Span<Real>& span, Real mostSamples, const Values& values,
    const ToTable<Real>& toTable, const Lattice<Real>& lattice, Lighting& lighting,
    [[maybe_unused]] Mask<Real> crosses, Light<Real>& light)
  {
    Real i = 0;
    if constexpr (isLit && hasSampleCopies<Real>)
    {
      SampleCopies<Real> copies(crosses, mostSamples);
      if (copies.count() > 1 && lighting.mayBeCopied())
      {
        copies.sort(crosses);
        const Span<Real> spread = copies(span);
        lighting.spread(copies);
        for (; i < mostSamples; i += static_cast<Real>(copies.count()))
        {
          ++statistics_.steps;
          statistics_.litSteps +=
            takeCopies(table_, spread, copies, crosses, i, values, toTable, lattice, lighting, light);
        }
        return;
      }
    }
    statistics_.steps += static_cast<std::uint64_t>(mostSamples);
    for (; i + 1 < mostSamples; i += 2)
    {
      statistics_.litSteps += takePoints<2>(table_, span, i, values, toTable, lattice, lighting, light);
    }
    if (i < mostSamples)
    {
      statistics_.litSteps += takePoints<1>(table_, span, i, values, toTable, lattice, lighting, light);
    }
  }

  /// Keeps what rays from `ray` on have, and ends those that have no light left, or have met what there is of a slice.
  HWY_INLINE void finishSteps(const Light<Real>& light, Mask<Real> crosses, int ray)
  {
    const RealTag<Real> d;
    hn::Store(light.opacity, d, opacity_ + ray);
    hn::Store(light.red, d, red_ + ray);
    hn::Store(light.green, d, green_ + ray);
    hn::Store(light.blue, d, blue_ + ray);
    const Mask<Real> isOpaque = hn::Gt(light.opacity, hn::Set(d, opaque_));
    finishWhere(isLit && scene_.features.slicesFaces ? hn::Or(isOpaque, crosses) : isOpaque, ray);
  }

  /// Of steps of t: a slice counts as the unit distance.
  HWY_INLINE Reals<Real> depthPerExtinction(Reals<Real> step, Reals<Real> lengthPerT) const
  {
    if (isLit && scene_.features.slices)
    {
      return hn::Set(RealTag<Real>(), static_cast<Real>(scene_.unitDepth));
    }
    return hn::Mul(step, lengthPerT);
  }

  /// Ends rays from `ray` on.
  HWY_INLINE void finishWhere(Mask<Real> done, int ray)
  {
    const RealTag<Real> d;
    int part = 0;
    do
    {
      Real* ends = end_[part] + ray;
      hn::Store(hn::IfThenElse(done, hn::Set(d, finished), hn::Load(d, ends)), d, ends);
    }
    while (++part < parts_);
  }

  template <class Values>
  HWY_INLINE void takeExtremes(const Values& values, const Block<Real>& block, const Lattice<Real>& lattice,
    int ray, Mask<Real> crosses, Reals<Real> length, Span<Real>& span)
  {
    const RealTag<Real> d;
    const IntTag<Real> di;
    span.step = length;
    Reals<Real> samples = hn::Zero(d);
    statistics_.steps += blends_.take(span, crosses, values, block.toTable, lattice, ray, samples);
    hn::Store(hn::Add(hn::Load(di, samples_), nearest<Real>(samples)), di, samples_);
    finishWhere(blends_.areDone(ray), ray);
  }

  /// Of the rays from `ray` on, from `begin` on.
  HWY_INLINE auto lightingOf([[maybe_unused]] Reals<Real> begin, [[maybe_unused]] int ray) const
  {
    if constexpr (isLit)
    {
      const RealTag<Real> d;
      Reals<Real> start[3];
      Reals<Real> direction[3];
      for (int a = 0; a < 3; ++a)
      {
        direction[a] = hn::Load(d, direction_[a] + ray);
        start[a] = mulAdd(begin, direction[a], hn::Load(d, origin_[a] + ray));
      }
      return LightOnRays<Real>(*scene_.illumination, gradients_.block(), mixture_.blocks(), start, direction);
    }
    else
    {
      return Unlit();
    }
  }

private:
  const VolumeKernelScene& scene_;
  const float* table_;
  Real samplesPerCell_;
  IntegralLimits<Real> integralLimits_;
  /// By lane: summing a vector up at each interval takes longer.
  HWY_ALIGN std::int32_t samples_[lanes<Real>] = {};
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

// The constants stage of the volume kernel: a tile's rays through cells that show one value each, of categories or
// where nothing is reconstructed. Compiled once for each instruction set, as Highway wants it.
//
// Nothing is sampled: a ray is cut where it passes from cell to cell. As with values in between, a node whose children
// are all drawn is met by its rays once: its three middle planes cut them into four parts at most.
#if defined(TREEAMR_VOLUMECONSTANTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMECONSTANTS_INL_H
#undef TREEAMR_VOLUMECONSTANTS_INL_H
#else
#define TREEAMR_VOLUMECONSTANTS_INL_H
#endif

#include "Volume/Kernel/VolumeIntervals-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeRays-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// What a node's children show, by octant.
template <class Real>
struct Constants
{
  TransferFunction::Entry entries[8]; // as the table has them
  HWY_ALIGN Real places[8]; // of loops that sample values, and of tables that gradients are looked up in
  Real most;                // of these
};

/// Of one thread.
template <class Real, VolumeLoop Loop>
class ConstantSource
{
public:
  explicit ConstantSource(const VolumeKernelScene& scene)
    : scene_(scene)
  {
  }

  /// Makes those of some of the children at a depth. False when nothing of them is visible.
  bool prepare(const Octree::Children& children, unsigned which, int depth) noexcept
  {
    bool isVisible = !scene_.settings.skipEmpty;
    constants_.most = -std::numeric_limits<Real>::infinity();
    for (; which != 0; which &= which - 1)
    {
      const int octant = std::countr_zero(which);
      isVisible = make(octant, children.node(octant, depth)) || isVisible;
    }
    return isVisible;
  }
  /// That of a tree without inner nodes, as of octant 0.
  bool prepareRoot() noexcept
  {
    constants_.most = -std::numeric_limits<Real>::infinity();
    return make(0, scene_.field.octree().root()) || !scene_.settings.skipEmpty;
  }

  const Constants<Real>& constants() const noexcept { return constants_; }

private:
  bool make(int octant, NodeRef node) noexcept
  {
    const auto value = static_cast<float>(scene_.field.relative(node));
    TransferFunction::Entry& entry = constants_.entries[octant];
    entry = scene_.table.at(scene_.transferFunction, value);
    if constexpr (samplesValues(Loop))
    {
      const auto place = static_cast<Real>((value - scene_.placeOrigin) * scene_.perValue);
      constants_.places[octant] = place;
      constants_.most = std::max(constants_.most, place);
    }
    if (scene_.mixture)
    {
      mix(node, entry);
      if (scene_.readsGradients()) // the table is looked up at samples
      {
        constants_.places[octant] =
          static_cast<Real>(scene_.transferFunction.position(value) * scene_.table.perEntry);
      }
    }
    return Loop == VolumeLoop::Extreme || scene_.settings.blend == VolumeBlend::Average ||
      entry.extinction > 0.f;
  }

  /// As LightOnRays does, but without light.
  void mix(NodeRef node, TransferFunction::Entry& entry) const noexcept
  {
    const KernelMixture& mixture = *scene_.mixture;
    if (mixture.table)
    {
      if (!mixture.table->byGradient)
      {
        entry =
          mixture.table->function.at(scene_.field.relative(node), mixture.parts[0]->field.relative(node));
      }
      return;
    }
    const auto entryOf = [&](std::size_t part) {
      const VolumeKernelScene& scene = *mixture.parts[part];
      return scene.table.at(scene.transferFunction, static_cast<float>(scene.field.relative(node)));
    };
    const TransferFunction::Entry first = entryOf(0);
    switch (mixture.mixing)
    {
      case VolumeMixing::Colors:
        entry = { first.r, first.g, first.b, entry.extinction };
        break;
      case VolumeMixing::Channels:
        entry = { first.r, entryOf(1).g, entryOf(2).b, entry.extinction };
        break;
      case VolumeMixing::Independent:
      {
        double squares = 0.;
        double weighted = 0.;
        std::array<double, 3> emitted{};
        for (std::size_t i = 0; i < mixture.parts.size(); ++i)
        {
          const float weight = mixture.weights[i];
          const TransferFunction::Entry own = weight > 0.f ? entryOf(i) : TransferFunction::Entry{};
          const double weightedOwn = static_cast<double>(weight) * own.extinction;
          squares += std::pow(static_cast<double>(own.extinction), 2);
          weighted += weightedOwn;
          emitted[0] += weightedOwn * own.r;
          emitted[1] += weightedOwn * own.g;
          emitted[2] += weightedOwn * own.b;
        }
        const double extinction = weighted > 0. ? squares / weighted : 0.;
        const auto color = [&](int c) {
          return extinction > 0. ? static_cast<float>(emitted[c] / extinction) : 0.f;
        };
        entry = { color(0), color(1), color(2), static_cast<float>(extinction) };
        break;
      }
      case VolumeMixing::Table:
        break;
    }
  }

  const VolumeKernelScene& scene_;
  Constants<Real> constants_{};
};

/// See TileRays.
template <class Real, RayOrigins Origins, VolumeLoop Loop>
class TileConstants : public TileIntervals<Real, Origins, Loop>
{
  using Rays = TileRays<Real, Origins>;
  using Intervals = TileIntervals<Real, Origins, Loop>;

public:
  using Intervals::Intervals;
  using Intervals::isComposite;
  using Intervals::isExtreme;
  using Intervals::isLit;

  /// Takes the rays of groups through a node's children, or what a box has of them. middle: where the children meet.
  HWY_NOINLINE void integrateConstants(const Constants<Real>& constants, const Box<Real>& box,
    const std::array<Real, 3>& middle, GroupMask active)
  {
    const RealTag<Real> d;
    if constexpr (isExtreme)
    {
      active = blends_.open(active, constants.most);
    }
    for (; active != 0; active &= active - 1)
    {
      const int first = std::countr_zero(active) * groupRays;
      for (int ray = first; ray < first + groupRays; ray += lanes<Real>)
      {
        for (int part = 0; part < parts_; ++part)
        {
          Reals<Real> begin = hn::Load(d, begin_[part] + ray);
          Reals<Real> end = hn::Load(d, end_[part] + ray);
          enterBox(box, ray, begin, end);
          do
          {
            const Reals<Real> stop = hasHits_ ? hn::Min(end, hn::Load(d, nextHitT_ + ray)) : end;
            takeConstants(constants, middle, ray, begin, stop);
          }
          while (hasHits_ && crossHits(part, ray, begin, end));
        }
      }
    }
  }

protected:
  using Intervals::blends_;
  using Intervals::countSamplesOf;
  using Intervals::depthPerExtinction;
  using Intervals::finishSteps;
  using Intervals::finishWhere;
  using Intervals::lightingOf;
  using Intervals::statistics_;
  using Rays::begin_;
  using Rays::blue_;
  using Rays::crossHits;
  using Rays::end_;
  using Rays::enterBox;
  using Rays::green_;
  using Rays::hasHits_;
  using Rays::inverse_;
  using Rays::lengthPerT_;
  using Rays::nextHitT_;
  using Rays::opacity_;
  using Rays::opaque_;
  using Rays::parts_;
  using Rays::planeT;
  using Rays::red_;

private:
  /// A way through one child, of some rays.
  struct Part
  {
    Mask<Real> taken;
    Reals<Real> begin;
    Reals<Real> end;
    Ints<Real> octant;
    Ints<Real> centre; // of the child, among the vertices of the node
  };

  /// Takes the rays from `ray` on from begin to end.
  HWY_INLINE void takeConstants(const Constants<Real>& constants, const std::array<Real, 3>& middle, int ray,
    Reals<Real> begin, Reals<Real> end)
  {
    const RealTag<Real> d;
    const Mask<Real> crosses = hn::Lt(begin, end);
    if (hn::AllFalse(d, crosses))
    {
      return;
    }
    ++statistics_.intervals;
    end = hn::IfThenElse(crosses, end, begin);
    Reals<Real> planes[3]; // t
    Mask<Real> falls[3];
    Reals<Real> ends[4];
    for (int a = 0; a < 3; ++a)
    {
      planes[a] = planeT(a, ray, middle[a]);
      falls[a] = hn::Lt(hn::Load(d, inverse_[a] + ray), hn::Zero(d));
      ends[a] = hn::Min(hn::Max(planes[a], begin), end);
    }
    ends[3] = end;
    sort(ends[0], ends[1]);
    sort(ends[1], ends[2]);
    sort(ends[0], ends[1]);
    const auto lighting = lightingOf(begin, ray);
    Light<Real> light{ {}, hn::Load(d, opacity_ + ray), hn::Load(d, red_ + ray), hn::Load(d, green_ + ray),
      hn::Load(d, blue_ + ray) };
    light.transmittance = hn::Sub(hn::Set(d, Real(1)), light.opacity);
    Part part;
    part.begin = begin;
    for (const Reals<Real>& partEnd : ends)
    {
      part.end = partEnd;
      part.taken = hn::Lt(part.begin, part.end);
      if (!hn::AllFalse(d, part.taken))
      {
        findChild(planes, falls, part);
        countSamplesOf(part.taken);
        ++statistics_.steps;
        take(constants, part, begin, ray, lighting, light);
      }
      part.begin = part.end;
    }
    if constexpr (isComposite)
    {
      finishSteps(light, crosses, ray);
    }
    if constexpr (isExtreme)
    {
      finishWhere(blends_.areDone(ray), ray);
    }
  }

  static HWY_INLINE void sort(Reals<Real>& a, Reals<Real>& b)
  {
    const Reals<Real> less = hn::Min(a, b);
    b = hn::Max(a, b);
    a = less;
  }

  /// Rays pass a plane towards its upper side, or fall to the lower one.
  static HWY_INLINE void findChild(const Reals<Real> (&planes)[3], const Mask<Real> (&falls)[3], Part& part)
  {
    const RealTag<Real> d;
    Reals<Real> octant = hn::Zero(d);
    Reals<Real> centre = hn::Set(d, Real(block::vertexIndex(1, 1, 1)));
    for (int a = 0; a < 3; ++a)
    {
      constexpr Real toOtherSide[3] = { block::vertexIndex(2, 0, 0), block::vertexIndex(0, 2, 0),
        block::vertexIndex(0, 0, 2) };
      const Mask<Real> isUpper = hn::Xor(hn::Ge(part.begin, planes[a]), falls[a]);
      octant = hn::Add(octant, hn::IfThenElseZero(isUpper, hn::Set(d, Real(1 << a))));
      centre = hn::Add(centre, hn::IfThenElseZero(isUpper, hn::Set(d, toOtherSide[a])));
    }
    part.octant = truncated<Real>(octant);
    part.centre = truncated<Real>(centre);
  }

  template <class Lighting>
  HWY_INLINE void take(const Constants<Real>& constants, const Part& part, Reals<Real> begin, int ray,
    const Lighting& lighting, Light<Real>& light)
  {
    const RealTag<Real> d;
    const float* const entries = &constants.entries[0].r;
    const Ints<Real> entry = hn::ShiftLeft<2>(part.octant); // of four floats
    if constexpr (!isComposite)
    {
      const Reals<Real> place = hn::GatherIndex(d, constants.places, asWideAsLanes<Real>(part.octant));
      if constexpr (isExtreme)
      {
        blends_.take(part.taken, place, ray);
      }
      else
      {
        blends_.take(part.taken, place, gather<Real>(entries + 3, entry),
          hn::Mul(hn::Sub(part.end, part.begin), hn::Load(d, lengthPerT_ + ray)), ray);
      }
      return;
    }
    Reals<Real> terms[4];
    gatherFours<Real>(entries, entry, terms);
    Reals<Real> extinction = hn::IfThenElseZero(part.taken, terms[3]);
    if (hn::AllFalse(d, hn::Gt(extinction, hn::Zero(d))))
    {
      return;
    }
    ++statistics_.litSteps;
    Reals<Real> color[3] = { terms[0], terms[1], terms[2] };
    if constexpr (isLit)
    {
      const Reals<Real> middle = hn::Mul(hn::Add(part.begin, part.end), hn::Set(d, Real(0.5)));
      const Spot<Real> spot{ part.centre, { hn::Zero(d), hn::Zero(d), hn::Zero(d) } };
      const bool readsTable = lighting.readsTable();
      const auto effect = lighting.at(spot, hn::Sub(middle, begin),
        readsTable ? hn::GatherIndex(d, constants.places, asWideAsLanes<Real>(part.octant)) : hn::Zero(d),
        extinction);
      extinction = readsTable ? hn::IfThenElseZero(hn::Gt(extinction, hn::Zero(d)), effect.opacity)
                              : hn::Mul(extinction, effect.opacity);
      lighting.shade(effect, hn::Set(d, Real(1)), color);
    }
    const Reals<Real> depth =
      depthPerExtinction(hn::Sub(part.end, part.begin), hn::Load(d, lengthPerT_ + ray));
    const Reals<Real> weight = hn::Mul(light.transmittance, heldBack(hn::Neg(hn::Mul(extinction, depth))));
    light.add(color, weight);
  }
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

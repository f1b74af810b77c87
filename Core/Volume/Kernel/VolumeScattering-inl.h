// Light that a volume scatters, dimmed by what is on its way. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMESCATTERING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMESCATTERING_INL_H
#undef TREEAMR_VOLUMESCATTERING_INL_H
#else
#define TREEAMR_VOLUMESCATTERING_INL_H
#endif

#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// Where in a lattice of nodes.
template <class Real>
struct LatticePlace
{
  Ints<Real> node; // the lowest of its cell
  Reals<Real> f[3];
};

/// By which colours are multiplied, of all lights.
template <class Real>
struct ScatteredLight
{
  Reals<Real> times[3];
  LatticePlace<Real> place;
};

/// On some rays through a block.
template <class Real>
class ScatteringOnRays
{
public:
  /// start: of the rays, in kernel coordinates.
  HWY_INLINE void start(
    const KernelScattering& scene, const Reals<Real> (&start)[3], const Reals<Real> (&direction)[3])
  {
    const RealTag<Real> d;
    scene_ = &scene;
    for (int a = 0; a < 3; ++a)
    {
      const Reals<Real> scale = hn::Set(d, static_cast<Real>(scene.cellsPerUnit[a]));
      start_[a] = mulAdd(scale, start[a], hn::Set(d, static_cast<Real>(scene.reference[a])));
      slope_[a] = hn::Mul(scale, direction[a]);
    }
  }

  /// Of no light yet, where rays are after a part of t.
  HWY_INLINE ScatteredLight<Real> at(Reals<Real> along) const
  {
    const RealTag<Real> d;
    const IntTag<Real> di;
    ScatteredLight<Real> scattered;
    for (Reals<Real>& times : scattered.times)
    {
      times = hn::Zero(d);
    }
    LatticePlace<Real>& place = scattered.place;
    place.node = hn::Zero(di);
    for (int a = 2; a >= 0; --a)
    {
      const auto last = static_cast<Real>(scene_->nodes[a] - 1);
      const Reals<Real> at =
        hn::Min(hn::ZeroIfNegative(mulAdd(along, slope_[a], start_[a])), hn::Set(d, last));
      const Reals<Real> cell = hn::Min(hn::Floor(at), hn::Set(d, last - 1));
      place.f[a] = hn::Sub(at, cell);
      place.node = hn::Add(hn::Mul(place.node, hn::Set(di, scene_->nodes[a])), truncated<Real>(cell));
    }
    return scattered;
  }

  /// arrives: where nothing dims the light; cosine: of the angle by which what the eye gets of it is turned.
  HWY_INLINE void add(const KernelLight& light, Reals<Real> arrives, Reals<Real> cosine,
    ScatteredLight<Real>& scattered) const
  {
    const RealTag<Real> d;
    Reals<Real> comes = arrives;
    if (light.transmittance)
    {
      comes = hn::Mul(comes, this->between(light.transmittance, scattered.place));
    }
    if (scene_->anisotropy != 0.)
    {
      comes = hn::Mul(comes, this->phase(cosine));
    }
    for (int c = 0; c < 3; ++c)
    {
      scattered.times[c] =
        mulAdd(comes, hn::Set(d, static_cast<Real>(light.diffuse[c])), scattered.times[c]);
    }
  }

  /// Of the light, that is scattered.
  HWY_INLINE Reals<Real> part(Reals<Real> extinction) const
  {
    const RealTag<Real> d;
    const double blending = scene_->blending;
    if (blending >= 1.)
    {
      return hn::Set(d, Real(1));
    }
    const Reals<Real> opacity =
      heldBack(hn::Mul(extinction, hn::Set(d, static_cast<Real>(-scene_->depthPerExtinction))));
    const Reals<Real> falls = hn::Sub(hn::Set(d, Real(1)),
      heldBack(hn::Mul(opacity, hn::Set(d, static_cast<Real>(-2. * std::numbers::log2e * blending)))));
    return blending < 0.5 ? hn::Mul(hn::Set(d, static_cast<Real>(2. * blending)), falls)
                          : mulAdd(hn::Set(d, static_cast<Real>(2. - 2. * blending)), falls,
                              hn::Set(d, static_cast<Real>(2. * blending - 1.)));
  }

private:
  HWY_INLINE Reals<Real> between(const float* nodes, const LatticePlace<Real>& place) const
  {
    const std::ptrdiff_t row = scene_->nodes[0];
    const std::ptrdiff_t slice = row * scene_->nodes[1];
    const auto inRow = [&](const float* first) {
      return lerp(place.f[0], gather<Real>(first, place.node), gather<Real>(first + 1, place.node));
    };
    const auto inSlice = [&](const float* first) {
      return lerp(place.f[1], inRow(first), inRow(first + row));
    };
    return lerp(place.f[2], inSlice(nodes), inSlice(nodes + slice));
  }

  /// Henyey and Greenstein's, 1 in the mean.
  HWY_INLINE Reals<Real> phase(Reals<Real> cosine) const
  {
    const RealTag<Real> d;
    const double g = scene_->anisotropy;
    const Reals<Real> squared = mulAdd(
      cosine, hn::Set(d, static_cast<Real>(-2. * g)), hn::Set(d, static_cast<Real>(1. + g * g)));
    return hn::Div(hn::Set(d, static_cast<Real>(1. - g * g)), hn::Mul(squared, hn::Sqrt(squared)));
  }

  const KernelScattering* scene_ = nullptr;
  Reals<Real> start_[3]; // in cells of the lattice
  Reals<Real> slope_[3];
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

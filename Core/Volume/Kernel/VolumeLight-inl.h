// The light stage of the volume kernel: what the field's gradient at a sample does to its colour and its extinction,
// and the colour that another field gives it. Compiled once for each instruction set, as Highway wants it.
//
// Shading is VTK's: Phong's model with the gradient as normal, on both sides of a level of the field. Normals are
// interpolated in the octant from vertex gradients, as values are: both are continuous across levels.
#if defined(TREEAMR_VOLUMELIGHT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMELIGHT_INL_H
#undef TREEAMR_VOLUMELIGHT_INL_H
#else
#define TREEAMR_VOLUMELIGHT_INL_H
#endif

#include "Volume/Kernel/SampleCopies-inl.h"
#include "Volume/Kernel/VolumeBlocks-inl.h"
#include "Volume/Kernel/VolumeGradients-inl.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeMixture-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"
#include "Volume/Kernel/VolumeScattering-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <type_traits>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// The logarithm to base 2 of positive numbers, to the digits of single precision. (Cephes' polynomial.)
template <class Real>
HWY_INLINE Reals<Real> logarithm(Reals<Real> x)
{
  using Limits = std::numeric_limits<Real>;
  const RealTag<Real> d;
  const hn::RebindToUnsigned<RealTag<Real>> du;
  constexpr int mantissa = Limits::digits - 1;
  // Where one is a number's last bit, its lowest bits are whole numbers.
  const Reals<Real> wholes = hn::Set(d, Real(1) / Limits::epsilon());
  const auto bits = hn::BitCast(du, x);
  Reals<Real> exponent =
    hn::Sub(hn::BitCast(d, hn::Or(hn::ShiftRight<mantissa>(bits), hn::BitCast(du, wholes))), wholes);
  exponent = hn::Sub(exponent, hn::Set(d, Real(Limits::max_exponent - 2)));
  const auto ofHalf = hn::BitCast(du, hn::Set(d, Real(0.5)));
  const auto fraction = hn::BitCast(du, hn::Set(d, Real(1) - Limits::epsilon() / 2));
  Reals<Real> m = hn::BitCast(d, hn::Or(hn::And(bits, hn::Xor(fraction, ofHalf)), ofHalf));
  const Mask<Real> isLow = hn::Lt(m, hn::Set(d, Real(std::numbers::sqrt2 / 2)));
  exponent = hn::Sub(exponent, hn::IfThenElseZero(isLow, hn::Set(d, Real(1))));
  m = hn::Sub(hn::IfThenElse(isLow, hn::Add(m, m), m), hn::Set(d, Real(1)));
  Reals<Real> p = hn::Set(d, Real(7.0376836292e-2));
  for (const double c : { -1.1514610310e-1, 1.1676998740e-1, -1.2420140846e-1, 1.4249322787e-1,
         -1.6668057665e-1, 2.0000714765e-1, -2.4999993993e-1, 3.3333331174e-1 })
  {
    p = mulAdd(p, m, hn::Set(d, static_cast<Real>(c)));
  }
  const Reals<Real> squared = hn::Mul(m, m);
  const Reals<Real> natural =
    hn::Add(m, mulAdd(hn::Mul(p, m), squared, hn::Mul(squared, hn::Set(d, Real(-0.5)))));
  return mulAdd(natural, hn::Set(d, Real(std::numbers::log2e)), exponent);
}

/// Of numbers in [0, 1]; 0 of 0 whatever the power, as VTK has it.
template <class Real>
HWY_INLINE Reals<Real> power(Reals<Real> x, const Falloff& falloff)
{
  const RealTag<Real> d;
  const Reals<Real> one = hn::Set(d, Real(1));
  if (falloff.whole >= 0)
  {
    const Mask<Real> isMore = hn::Gt(x, hn::Set(d, static_cast<Real>(falloff.least)));
    Reals<Real> square = hn::IfThenElseZero(isMore, hn::Min(x, one));
    Reals<Real> result = hn::IfThenElseZero(isMore, one);
    for (auto rest = static_cast<unsigned>(falloff.whole); rest != 0; rest >>= 1)
    {
      result = (rest & 1) != 0 ? hn::Mul(result, square) : result;
      square = hn::Mul(square, square);
    }
    return result;
  }
  const Mask<Real> isPositive = hn::Gt(x, hn::Set(d, std::numeric_limits<Real>::min()));
  const Reals<Real> depth = hn::Mul(hn::Set(d, static_cast<Real>(falloff.exponent)),
    logarithm<Real>(hn::IfThenElse(isPositive, hn::Min(x, one), one)));
  return hn::IfThenElseZero(isPositive, hn::Sub(one, heldBack(hn::Min(depth, hn::Zero(d)))));
}

template <class Real>
using Reals3 = Reals<Real>[3];

template <class Real>
HWY_INLINE Reals<Real> dotted(const Reals3<Real>& a, const Reals3<Real>& b)
{
  return mulAdd(a[0], b[0], mulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
}

/// To unit length, 0 where there is none; the squares of lengths before.
template <class Real>
HWY_INLINE Reals<Real> normalize(Reals3<Real>& v)
{
  const RealTag<Real> d;
  const Reals<Real> squared = dotted<Real>(v, v);
  const Mask<Real> isLong = hn::Gt(squared, hn::Set(d, std::numeric_limits<Real>::min()));
  const Reals<Real> inverse = hn::IfThenElseZero(
    isLong, hn::Div(hn::Set(d, Real(1)), hn::Sqrt(hn::IfThenElse(isLong, squared, hn::Set(d, Real(1))))));
  for (Reals<Real>& component : v)
  {
    component = hn::Mul(component, inverse);
  }
  return squared;
}

/// On some rays through a block.
template <class Real>
class LightOnRays
{
public:
  static constexpr bool isLit = true;
  using Effect = LightEffect<Real>;

  /// start: of the rays, in kernel coordinates.
  HWY_INLINE LightOnRays(const VolumeIllumination& scene, const GradientBlock<Real>& gradients,
    const MixedBlocks<Real>& mixed, const Reals3<Real>& start, const Reals3<Real>& direction)
    : scene_(scene)
    , mixed_(mixed)
    , gradients_(gradients)
  {
    const RealTag<Real> d;
    const VolumeIllumination* lit = mixed.lights[0] ? mixed.lights[0] : &scene; // all in the same coordinates
    for (int part = 1; part < 4 && mixed.lights[part] && !lit->needsPoints; ++part)
    {
      lit = mixed.lights[part];
    }
    if (!lit->shades)
    {
      return;
    }
    for (int r = 0; r < 3; ++r)
    {
      const auto row = [&](const Reals3<Real>& v, Reals<Real> sum) {
        for (int a = 0; a < 3; ++a)
        {
          sum = mulAdd(hn::Set(d, static_cast<Real>(lit->viewFromKernel[r][a])), v[a], sum);
        }
        return sum;
      };
      sight_[r] = slope_[r] = row(direction, hn::Zero(d));
      start_[r] =
        lit->needsPoints ? row(start, hn::Set(d, static_cast<Real>(lit->viewFromKernel[r][3]))) : slope_[r];
    }
    normalize<Real>(sight_);
    if (scene.scattering)
    {
      scattering_.start(*scene.scattering, start, direction);
    }
  }

  /// Whether samples of several places may be in its lanes: what others know of its rays is not packed.
  HWY_INLINE bool mayBeCopied() const { return mixed_.isNone() && !scene_.scattering; }
  HWY_INLINE void spread(const SampleCopies<Real>& copies)
  {
    if (scene_.shades)
    {
      copies.spread(sight_);
    }
    if (scene_.needsPoints)
    {
      copies.spread(start_);
      copies.spread(slope_);
    }
  }

  ///@{
  /// See MixtureOnRays; whether effects have the extinctions.
  HWY_INLINE bool isOfMany() const { return mixed_.isOfMany(); }
  HWY_INLINE bool readsTable() const { return mixed_.readsTable(); }
  HWY_INLINE bool makesExtinction() const { return mixed_.isOfMany() || mixed_.readsTable(); }
  ///@}

  /// At spots that rays reach after a part of t. place: of the value there, for tables; extinction: as the table's entries
  /// have it.
  HWY_INLINE Effect at(
    const Spot<Real>& spot, Reals<Real> along, Reals<Real> place, Reals<Real> extinction) const
  {
    const RealTag<Real> d;
    Effect effect;
    effect.opacity = hn::Set(d, Real(1));
    const bool readsTable = mixed_.readsTable();
    if (!mixed_.isNone() && !readsTable)
    {
      mixed_.mix(
        spot,
        [&](int part, Reals3<Real>& color) {
          Reals<Real> gradient[3];
          gradientAt(mixed_.gradients(part), spot, gradient);
          Effect own;
          this->reflect(mixed_.light(part), gradient, along, hn::Zero(d), own);
          for (int c = 0; c < 3; ++c)
          {
            color[c] =
              hn::Min(hn::ZeroIfNegative(mulAdd(own.times[c], color[c], own.plus[c])), hn::Set(d, Real(1)));
          }
        },
        effect);
    }
    if (!scene_.usesGradients)
    {
      if (readsTable)
      {
        mixed_.lookUp(place, hn::Zero(d), spot, effect);
      }
      return effect;
    }
    if (gradients_.ofLong != 0 && this->areOfLong(spot, extinction))
    {
      effect.opacity = hn::Set(d, static_cast<Real>(scene_.ofLong));
      return effect;
    }
    Reals<Real> gradient[3];
    gradientAt(gradients_, spot, gradient);
    if (readsTable)
    {
      mixed_.lookUp(place,
        hn::Mul(hn::Sqrt(dotted<Real>(gradient, gradient)), hn::Set(d, gradients_.stepLength)), spot, effect);
    }
    else if (scene_.gradientOpacity)
    {
      const Reals<Real> length = hn::Sqrt(dotted<Real>(gradient, gradient));
      const Reals<Real> place = hn::Min(hn::Mul(length, hn::Set(d, gradients_.entriesPerStep)),
        hn::Set(d, static_cast<Real>(scene_.lastEntry)));
      const Reals<Real> entry =
        hn::Min(hn::Floor(place), hn::Set(d, static_cast<Real>(scene_.lastEntry - 1.)));
      Reals<Real> own;
      Reals<Real> next;
      gatherPairs<Real>(scene_.gradientOpacity, truncated<Real>(entry), own, next);
      effect.opacity = lerp(hn::Sub(place, entry), own, next);
    }
    if (scene_.shades)
    {
      this->reflect(scene_, gradient, along, extinction, effect);
    }
    return effect;
  }

  /// Colours, which have been multiplied by `whole`.
  HWY_INLINE void shade(const Effect& effect, Reals<Real> whole, Reals3<Real>& color) const
  {
    for (int c = 0; c < 3 && !mixed_.isNone(); ++c)
    {
      color[c] = hn::Mul(effect.color[c], whole);
    }
    if (scene_.shades)
    {
      for (int c = 0; c < 3; ++c)
      {
        const Reals<Real> lit = mulAdd(effect.times[c], color[c], hn::Mul(effect.plus[c], whole));
        color[c] = hn::Min(hn::ZeroIfNegative(lit), whole);
      }
    }
  }

private:
  /// Whether all that is seen has the opacity of long gradients.
  HWY_INLINE bool areOfLong(const Spot<Real>& spot, Reals<Real> extinction) const
  {
    const RealTag<Real> d;
    constexpr unsigned all = 0xff;
    return gradients_.ofLong == all ||
      hn::AllTrue(d, hn::Or(areIn(gradients_.ofLong, spot), hn::Le(extinction, hn::Zero(d))));
  }

  /// Shines on a unit normal.
  HWY_INLINE void reflect(const VolumeIllumination& scene, const Reals3<Real>& gradient, Reals<Real> along,
    Reals<Real> extinction, Effect& effect) const
  {
    const RealTag<Real> d;
    Reals<Real> normal[3];
    for (int r = 0; r < 3; ++r)
    {
      normal[r] = hn::Zero(d);
      for (int a = 0; a < 3; ++a)
      {
        normal[r] =
          mulAdd(hn::Set(d, static_cast<Real>(scene.normalFromGradient[r][a])), gradient[a], normal[r]);
      }
    }
    normalize<Real>(normal);
    Reals<Real> point[3] = { start_[0], start_[1], start_[2] };
    Reals<Real> sight[3] = { sight_[0], sight_[1], sight_[2] };
    if (scene.needsPoints)
    {
      for (int a = 0; a < 3; ++a)
      {
        point[a] = mulAdd(along, slope_[a], start_[a]);
      }
      if (!scene.seesAlongRays)
      {
        std::copy_n(point, 3, sight);
        normalize<Real>(sight);
      }
    }
    const Reals<Real> towards = dotted<Real>(normal, sight);
    for (int c = 0; c < 3; ++c)
    {
      effect.times[c] = hn::Set(d, static_cast<Real>(scene.ambient));
      effect.plus[c] = hn::Set(d, static_cast<Real>(scene.ambientLight[c]));
    }
    ScatteredLight<Real> scattered;
    if (scene.scattering)
    {
      scattered = scattering_.at(along);
    }
    for (const KernelLight& light : scene.lights)
    {
      Reals<Real> travels[3] = { sight[0], sight[1], sight[2] };
      Reals<Real> arrives = hn::Set(d, Real(1));
      if (!light.isAtEye)
      {
        arrives = this->incoming(light, point, travels);
      }
      if (scene.scattering)
      {
        scattering_.add(light, arrives, hn::Neg(dotted<Real>(travels, sight)), scattered);
      }
      const Reals<Real> cosine = dotted<Real>(normal, travels);
      const Reals<Real> facing = scene.twoSided ? hn::Abs(cosine) : hn::ZeroIfNegative(cosine);
      const Reals<Real> falls = hn::Mul(arrives, facing);
      for (int c = 0; c < 3; ++c)
      {
        effect.times[c] = mulAdd(falls, hn::Set(d, static_cast<Real>(light.diffuse[c])), effect.times[c]);
      }
      if (!scene.shines)
      {
        continue;
      }
      // What is mirrored on the normal, towards the eye.
      const Reals<Real> closeness =
        hn::Sub(hn::Mul(hn::Add(cosine, cosine), towards), dotted<Real>(travels, sight));
      const Reals<Real> highlight = hn::IfThenElseZero(hn::Gt(facing, hn::Zero(d)),
        hn::Mul(arrives, power<Real>(hn::ZeroIfNegative(closeness), scene.ofHighlights)));
      for (int c = 0; c < 3; ++c)
      {
        effect.plus[c] = mulAdd(highlight, hn::Set(d, static_cast<Real>(light.specular[c])), effect.plus[c]);
      }
    }
    if (scene.scattering)
    {
      const Reals<Real> part = scattering_.part(extinction);
      for (int c = 0; c < 3; ++c)
      {
        effect.times[c] = lerp(part, effect.times[c], scattered.times[c]);
        effect.plus[c] = lerp(part, effect.plus[c], hn::Set(d, static_cast<Real>(scene.ambientLight[c])));
      }
    }
  }

  /// How a light travels at points, and how much of it arrives.
  HWY_INLINE Reals<Real> incoming(
    const KernelLight& light, const Reals3<Real>& point, Reals3<Real>& travels) const
  {
    const RealTag<Real> d;
    const auto set = [d](double v) { return hn::Set(d, static_cast<Real>(v)); };
    for (int a = 0; a < 3; ++a)
    {
      travels[a] = light.isPositional ? hn::Sub(point[a], set(light.position[a])) : set(light.direction[a]);
    }
    if (!light.isPositional)
    {
      return set(1.);
    }
    const Reals<Real> distance = hn::Sqrt(normalize<Real>(travels));
    Reals<Real> arrives = hn::Div(set(1.),
      mulAdd(distance, mulAdd(distance, set(light.attenuation[2]), set(light.attenuation[1])),
        set(light.attenuation[0])));
    if (light.isCone)
    {
      const Reals<Real> direction[3] = { set(light.direction[0]), set(light.direction[1]),
        set(light.direction[2]) };
      const Reals<Real> cosine = dotted<Real>(travels, direction);
      arrives = hn::IfThenElseZero(hn::Ge(cosine, set(light.coneCosine)),
        hn::Mul(arrives, power<Real>(hn::ZeroIfNegative(cosine), light.inCone)));
    }
    return arrives;
  }

  const VolumeIllumination& scene_;
  MixtureOnRays<Real> mixed_;
  const GradientBlock<Real>& gradients_;
  Reals<Real> start_[3]; // in the lights' coordinates
  Reals<Real> slope_[3];
  Reals<Real> sight_[3]; // the way that rays go
  ScatteringOnRays<Real> scattering_;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

// The light of many hits: SurfaceFrame::shadingNormal() and shade() for vectors of them.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/LightHits.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

HWY_INLINE Vectors3 select(Mask mask, const Vectors3& yes, const Vectors3& no)
{
  return { hn::IfThenElse(mask, yes[0], no[0]), hn::IfThenElse(mask, yes[1], no[1]),
    hn::IfThenElse(mask, yes[2], no[2]) };
}

HWY_INLINE Mask isZero(const Vectors3& v)
{
  const Doubles zero = hn::Zero(Tag());
  return hn::And(hn::And(hn::Eq(v[0], zero), hn::Eq(v[1], zero)), hn::Eq(v[2], zero));
}

HWY_INLINE Vectors3 negatedWhere(Mask mask, const Vectors3& v)
{
  return select(mask, { hn::Neg(v[0]), hn::Neg(v[1]), hn::Neg(v[2]) }, v);
}

/// Gradients in the world.
HWY_INLINE Vectors3 inWorld(const SurfaceFrame& frame, const Vectors3& gradient)
{
  return { dotVectors(setVectors(frame.cofactors()[0]), gradient),
    dotVectors(setVectors(frame.cofactors()[1]), gradient),
    dotVectors(setVectors(frame.cofactors()[2]), gradient) };
}

/// SurfaceFrame::worldNormal() towards the eye.
HWY_INLINE Vectors3 worldNormals(const SurfaceFrame& frame, const Vectors3& gradient, const Vectors3& toEye)
{
  const Vectors3 n = normalizedVectors(inWorld(frame, gradient));
  return select(isZero(n), toEye, negatedWhere(hn::Lt(dotVectors(n, toEye), hn::Zero(Tag())), n));
}

/// Whether gradients of unit length point away from the eye. Most say so without their length: where the sum is many
/// times what it may be rounded by, with and without it.
HWY_INLINE Mask areAway(const Vectors3& gradient, const Vectors3& toEye)
{
  const Tag d;
  const auto absolute = [](const Vectors3& v) {
    return Vectors3{ hn::Abs(v[0]), hn::Abs(v[1]), hn::Abs(v[2]) };
  };
  const Doubles towards = dotVectors(gradient, toEye);
  const Doubles most = dotVectors(absolute(gradient), absolute(toEye));
  const Mask isSure = hn::And(hn::Gt(hn::Abs(towards), hn::Mul(set(0x1p-48), most)),
    hn::And(hn::Gt(most, set(1e-140)), hn::Lt(dotVectors(gradient, gradient), set(1e300))));
  return hn::Lt(
    hn::AllTrue(d, isSure) ? towards : dotVectors(normalizedVectors(gradient), toEye), hn::Zero(d));
}

/// SurfaceFrame::shadingNormal().
HWY_INLINE Vectors3 shadingNormals(
  const SurfaceFrame& frame, const Vectors3& gradient, const Vectors3& normal, const Vectors3& toEye)
{
  const Tag d;
  const Vectors3 up = inWorld(frame, gradient);
  const Mask isAway = areAway(up, toEye);
  const Vectors3 n = negatedWhere(isAway, normalizedVectors(inWorld(frame, normal)));
  const Doubles towards = dotVectors(n, toEye);
  const Mask isSeen = hn::Gt(towards, hn::Zero(d));
  if (hn::AllTrue(d, isSeen))
  {
    return n;
  }
  const Vectors3 unitUp = normalizedVectors(up);
  const Vectors3 side = select(isZero(unitUp), toEye, negatedWhere(isAway, unitUp));
  Vectors3 across;
  for (int a = 0; a < 3; ++a)
  {
    // Of the others nothing that takes the slow way.
    across[a] = hn::IfThenElse(isSeen, n[a], hn::Sub(n[a], hn::Mul(towards, toEye[a])));
  }
  across = normalizedVectors(across);
  return select(isSeen, n, select(isZero(across), side, across));
}

void LightHits(const SurfaceFrame& frame, std::span<const Light> lights, bool flat, HitsToLight& hits)
{
  const Tag d;
  const hn::Rebind<float, Tag> df;
  for (int i = 0; i < hits.count; i += lanes)
  {
    const Mask valid = hn::FirstN(d, static_cast<std::size_t>(hits.count - i));
    const auto load = [&](const std::array<HitsToLight::Component, 3>& from) {
      const auto at = [&](int a) { return hn::IfThenElse(valid, hn::Load(d, &from[a][i]), set(1.)); };
      return Vectors3{ at(0), at(1), at(2) };
    };
    const auto promoted = [&](const std::array<HitsToLight::FloatComponent, 3>& from) {
      const auto at = [&](int a) {
        return hn::IfThenElse(valid, hn::PromoteTo(d, hn::Load(df, &from[a][i])), set(1.));
      };
      return Vectors3{ at(0), at(1), at(2) };
    };
    const Vectors3 eye = load(hits.toEye);
    const Vectors3 gradient = load(hits.gradient);
    const Vectors3 normal =
      flat ? worldNormals(frame, gradient, eye) : shadingNormals(frame, gradient, promoted(hits.normal), eye);
    const Vectors3 diffuse = promoted(hits.diffuse);
    Vectors3 sum = promoted(hits.ambient);
    for (const Light& light : lights)
    {
      const Doubles cosine = hn::Neg(dotVectors(normal, setVectors(light.direction)));
      const Mask isLit = hn::Gt(cosine, hn::Zero(d));
      for (int c = 0; c < 3; ++c)
      {
        const Doubles reflected = hn::Mul(hn::Mul(set(light.color[c]), cosine), diffuse[c]);
        sum[c] = hn::IfThenElse(isLit, hn::Add(sum[c], reflected), sum[c]);
      }
    }
    for (int c = 0; c < 3; ++c)
    {
      const Doubles low = hn::IfThenElse(hn::Lt(sum[c], hn::Zero(d)), hn::Zero(d), sum[c]);
      const Doubles both = hn::IfThenElse(hn::Lt(set(1.), low), set(1.), low);
      hn::Store(hn::DemoteTo(df, both), df, &hits.rgb[c][i]);
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(LightHits);

void lightHits(
  const SurfaceFrame& frame, std::span<const Light> lights, bool flat, HitsToLight& hits) noexcept
{
  HWY_DYNAMIC_DISPATCH(LightHits)(frame, lights, flat, hits);
}

} // namespace treeamr
#endif

// Few rays of a vector that want several samples each of a block, in lanes side by side: what light costs, it costs for
// all lanes. Compiled once for each instruction set, as Highway wants it.
//
// Each lane counts as it does without: pictures are the same, to the bit.
#if defined(TREEAMR_SAMPLECOPIES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_SAMPLECOPIES_INL_H
#undef TREEAMR_SAMPLECOPIES_INL_H
#else
#define TREEAMR_SAMPLECOPIES_INL_H
#endif

#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// Whether rays may have several samples side by side: narrow vectors are full as they are, and have no instruction that
/// sorts lanes.
template <class Real>
constexpr bool hasSampleCopies = lanes<Real> >= 8 && std::is_same_v<Real, float>;

/// Where samples of some of a vector's rays are put: `copies` times all of these rays, one sample after the other.
template <class Real>
class SampleCopies
{
  using Indices = decltype(hn::IndicesFromVec(RealTag<Real>(), hn::Zero(IntTag<Real>())));

public:
  /// Of rays that want up to so many samples.
  HWY_INLINE SampleCopies(Mask<Real> rays, Real mostSamples)
  {
    std::uint8_t bits[(lanes<Real> + 7) / 8] = {};
    hn::StoreMaskBits(RealTag<Real>(), rays, bits);
    for (int i = 0; i < lanes<Real> / 8; ++i)
    {
      mask_ |= static_cast<unsigned>(bits[i]) << 8 * i;
    }
    const auto count = static_cast<unsigned>(std::popcount(mask_));
    constexpr int mostCopies = 4;
    while (copies_ < mostCopies && static_cast<Real>(copies_) < mostSamples &&
      2 * copies_ * count <= static_cast<unsigned>(lanes<Real>))
    {
      copies_ *= 2;
    }
  }

  /// 1: nothing is gained.
  int count() const { return copies_; }

  /// Finds the lanes; once there are copies.
  HWY_INLINE void sort(Mask<Real> rays)
  {
    const IntTag<Real> di;
    const Ints<Real> lane = hn::Iota(di, 0);
    const int each = lanes<Real> / copies_;
    const Ints<Real> chosen = hn::Compress(lane, hn::RebindMask(di, rays));
    const auto inCopy = hn::IndicesFromVec(di, hn::And(lane, hn::Set(di, each - 1)));
    order_ = hn::IndicesFromVec(RealTag<Real>(), hn::TableLookupLanes(chosen, inCopy));
    HWY_ALIGN std::uint8_t before[lanes<Real>];
    unsigned count = 0;
    for (int i = 0; i < lanes<Real>; i += 8)
    {
      const std::uint64_t ranks = ranksOf(mask_ >> i & 0xff) + count * everyByte;
      std::memcpy(before + i, &ranks, sizeof(ranks));
      count += static_cast<unsigned>(std::popcount(mask_ >> i & 0xff));
    }
    rank_ = hn::PromoteTo(di, hn::Load(hn::Rebind<std::uint8_t, RealTag<Real>>(), before));
    each_ = each;
  }

  /// Lanes of rays where these have been put.
  HWY_INLINE Reals<Real> operator()(Reals<Real> v) const { return hn::TableLookupLanes(v, order_); }
  HWY_INLINE void spread(Reals<Real> (&v)[3]) const
  {
    for (Reals<Real>& component : v)
    {
      component = (*this)(component);
    }
  }
  HWY_INLINE Span<Real> operator()(const Span<Real>& span) const
  {
    Span<Real> result = span;
    this->spread(result.start);
    this->spread(result.slope);
    result.step = (*this)(span.step);
    result.depthPerExtinction = (*this)(span.depthPerExtinction);
    result.samples = (*this)(span.samples);
    return result;
  }
  /// Of which copy lanes are.
  HWY_INLINE Reals<Real> copy() const
  {
    const RealTag<Real> d;
    return hn::Floor(hn::Mul(hn::Iota(d, 0), hn::Set(d, 1 / static_cast<Real>(each_))));
  }
  /// Where a copy's lanes have been put; rays without are anywhere.
  HWY_INLINE Indices back(int copy) const
  {
    const IntTag<Real> di;
    return hn::IndicesFromVec(
      RealTag<Real>(), hn::And(hn::Add(rank_, hn::Set(di, copy * each_)), hn::Set(di, lanes<Real> - 1)));
  }

private:
  static constexpr std::uint64_t everyByte = 0x0101010101010101;

  /// By byte, how many of a byte's lower bits are set.
  static std::uint64_t ranksOf(std::uint64_t mask)
  {
    const std::uint64_t own = mask * everyByte & 0x8040201008040201; // of each byte its bit
    const std::uint64_t ones = (own + 0x7f7f7f7f7f7f7f7f) >> 7 & everyByte;
    return ones * everyByte << 8;
  }

  unsigned mask_ = 0;
  int copies_ = 1;
  int each_ = 0; // lanes
  Indices order_;
  Ints<Real> rank_;
};

/// As takePoints(), of rays with copies, all of them from sample i on. span and lighting: spread over the copies.
template <class Real, class Values, class Lighting>
HWY_INLINE int takeCopies(const float* entries, const Span<Real>& span, const SampleCopies<Real>& copies,
  Mask<Real> rays, Real i, const Values& values, const ToTable<Real>& toTable, const Lattice<Real>& lattice,
  const Lighting& lighting, Light<Real>& light)
{
  const RealTag<Real> d;
  const Reals<Real> before = hn::Add(hn::Set(d, i), copies.copy());
  const Reals<Real> steps = hn::Add(before, hn::Set(d, Real(0.5)));
  const Spot<Real> spots[1] = { locate(span, steps, lattice) };
  Reals<Real> position[1];
  sample(spots, values, toTable, position);
  const Ints<Real> entry = hn::ShiftLeft<2>(nearest<Real>(position[0])); // of four floats
  Reals<Real> row[4];
  gatherFours<Real>(entries, entry, row);
  Reals<Real> extinction = hn::IfThenElseZero(hn::Lt(before, span.samples), row[3]);
  if (hn::AllFalse(d, hn::Gt(extinction, hn::Zero(d))))
  {
    return 0;
  }
  const auto effect = lighting.at(spots[0], hn::Mul(steps, span.step), position[0], extinction);
  extinction = hn::Mul(extinction, effect.opacity);
  const Reals<Real> held = heldBack(hn::Neg(hn::Mul(extinction, span.depthPerExtinction)));
  Reals<Real> color[3] = { row[0], row[1], row[2] };
  lighting.shade(effect, hn::Set(d, Real(1)), color);
  for (int copy = 0; copy < copies.count(); ++copy)
  {
    const auto back = copies.back(copy);
    const Reals<Real> weight =
      hn::Mul(light.transmittance, hn::IfThenElseZero(rays, hn::TableLookupLanes(held, back)));
    const Reals<Real> own[3] = { hn::TableLookupLanes(color[0], back), hn::TableLookupLanes(color[1], back),
      hn::TableLookupLanes(color[2], back) };
    light.add(own, weight);
  }
  return 1;
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

// Lanes of the volume kernel's vectors: as numbers of other kinds, and read from tables. Compiled once for each
// instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMELANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMELANES_INL_H
#undef TREEAMR_VOLUMELANES_INL_H
#else
#define TREEAMR_VOLUMELANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

/// Real: what lanes hold.
template <class Real>
using RealTag = hn::CappedTag<Real, 16>;
template <class Real>
using Reals = hn::Vec<RealTag<Real>>;
template <class Real>
using Mask = hn::Mask<RealTag<Real>>;
/// As many indices as a vector has lanes.
template <class Real>
using IntTag = hn::Rebind<std::int32_t, RealTag<Real>>;
template <class Real>
using Ints = hn::Vec<IntTag<Real>>;

template <class Real>
constexpr int lanes = hn::MaxLanes(RealTag<Real>());

/// Lanes as whole numbers, towards zero. No lane may be out of their range: what Highway does for such lanes, both here and
/// in nearest(), takes four more operations.
template <class Real>
HWY_INLINE Ints<Real> truncated(Reals<Real> v)
{
  if constexpr (std::is_same_v<Real, float>)
  {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
    return Ints<Real>{ _mm512_maskz_cvttps_epi32(0xffff, v.raw) };
#else
    return hn::ConvertTo(IntTag<Real>(), v);
#endif
  }
  else
  {
    return hn::DemoteTo(IntTag<Real>(), v);
  }
}

template <class Real>
HWY_INLINE Ints<Real> nearest(Reals<Real> v)
{
  if constexpr (std::is_same_v<Real, float>)
  {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
    return Ints<Real>{ _mm512_maskz_cvtps_epi32(0xffff, v.raw) };
#else
    return hn::NearestInt(v);
#endif
  }
  else
  {
    return hn::DemoteTo(IntTag<Real>(), hn::Round(v));
  }
}

/// Whole numbers as lanes.
template <class Real>
HWY_INLINE Reals<Real> asReals(Ints<Real> v)
{
  if constexpr (std::is_same_v<Real, float>)
  {
    return hn::ConvertTo(RealTag<Real>(), v);
  }
  else
  {
    return hn::PromoteTo(RealTag<Real>(), v);
  }
}

/// What an index needs to gather lanes.
template <class Real>
HWY_INLINE auto asWideAsLanes(Ints<Real> index)
{
  if constexpr (std::is_same_v<Real, float>)
  {
    return index;
  }
  else
  {
    return hn::PromoteTo(hn::RebindToSigned<RealTag<Real>>(), index);
  }
}

/// Of a table of floats.
template <class Real>
HWY_INLINE Reals<Real> gather(const float* table, Ints<Real> index)
{
  if constexpr (std::is_same_v<Real, float>)
  {
    return hn::GatherIndex(RealTag<Real>(), table, index);
  }
  else
  {
    return hn::PromoteTo(RealTag<Real>(), hn::GatherIndex(hn::Rebind<float, RealTag<Real>>(), table, index));
  }
}

#if HWY_TARGET != HWY_SCALAR
/// Four floats each from table[at[0]], table[at[4]] ... on, as many as a vector has room for.
template <class D>
HWY_INLINE hn::Vec<D> loadFours(D d, const float* table, const std::int32_t* at)
{
  if constexpr (hn::MaxLanes(d) == 4)
  {
    return hn::LoadU(d, table + *at);
  }
  else
  {
    const hn::Half<D> dh;
    return hn::Combine(d, loadFours(dh, table, at + hn::MaxLanes(dh)), loadFours(dh, table, at));
  }
}

template <class D>
HWY_INLINE void gatherFours(D d, const float* table, const std::int32_t* at, hn::Vec<D> (&four)[4])
{
  const hn::RepartitionToWide<D> pairs;
  hn::Vec<D> ofLanes[4]; // each of every fourth lane
  for (int lane = 0; lane < 4; ++lane)
  {
    ofLanes[lane] = loadFours(d, table, at + lane);
  }
  const auto low01 = hn::BitCast(pairs, hn::InterleaveLower(d, ofLanes[0], ofLanes[1]));
  const auto low23 = hn::BitCast(pairs, hn::InterleaveLower(d, ofLanes[2], ofLanes[3]));
  const auto high01 = hn::BitCast(pairs, hn::InterleaveUpper(d, ofLanes[0], ofLanes[1]));
  const auto high23 = hn::BitCast(pairs, hn::InterleaveUpper(d, ofLanes[2], ofLanes[3]));
  four[0] = hn::BitCast(d, hn::InterleaveLower(pairs, low01, low23));
  four[1] = hn::BitCast(d, hn::InterleaveUpper(pairs, low01, low23));
  four[2] = hn::BitCast(d, hn::InterleaveLower(pairs, high01, high23));
  four[3] = hn::BitCast(d, hn::InterleaveUpper(pairs, high01, high23));
}
#endif

/// Of a table of floats four that follow each other, from each lane's index on. A load of all four and a transposition
/// take an eighth of the time of four gathers (Zen 5).
template <class Real>
HWY_INLINE void gatherFours(const float* table, Ints<Real> index, Reals<Real> (&four)[4])
{
#if HWY_TARGET != HWY_SCALAR
  const hn::Rebind<float, RealTag<Real>> d;
  if constexpr (hn::MaxLanes(d) >= 4)
  {
    HWY_ALIGN std::int32_t at[lanes<Real>];
    hn::Store(index, IntTag<Real>(), at);
#ifdef __GNUC__
    // Taken from memory: to take lane by lane out of the register, as the compiler would, is slower.
    asm volatile("" : : "m"(at));
#endif
    if constexpr (std::is_same_v<Real, float>)
    {
      gatherFours(d, table, at, four);
    }
    else
    {
      hn::Vec<decltype(d)> floats[4];
      gatherFours(d, table, at, floats);
      for (int c = 0; c < 4; ++c)
      {
        four[c] = hn::PromoteTo(RealTag<Real>(), floats[c]);
      }
    }
    return;
  }
#endif
  for (int c = 0; c < 4; ++c)
  {
    four[c] = gather<Real>(table + c, index);
  }
}

/// Of a table each element and the next one.
template <class Real>
HWY_INLINE void gatherPairs(const float* table, Ints<Real> index, Reals<Real>& first, Reals<Real>& second)
{
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  if constexpr (std::is_same_v<Real, float>)
  {
    const __m512i none = _mm512_setzero_si512();
    constexpr __mmask8 all = 0xff; // without it compilers warn of their own headers
    const __m512 low = _mm512_castsi512_ps(_mm512_mask_i32gather_epi64(
      none, all, _mm512_maskz_extracti64x4_epi64(all, index.raw, 0), table, sizeof(float)));
    const __m512 high = _mm512_castsi512_ps(_mm512_mask_i32gather_epi64(
      none, all, _mm512_maskz_extracti64x4_epi64(all, index.raw, 1), table, sizeof(float)));
    const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0);
    first = Reals<float>{ _mm512_permutex2var_ps(low, even, high) };
    second = Reals<float>{ _mm512_permutex2var_ps(low, _mm512_add_epi32(even, _mm512_set1_epi32(1)), high) };
    return;
  }
#endif
  first = gather<Real>(table, index);
  second = gather<Real>(table + 1, index);
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

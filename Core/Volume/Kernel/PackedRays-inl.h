// Rays of several groups side by side in one vector: a block is often no larger than a group, and a few lanes of each of
// the groups that meet there would cost as much as all of them. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_PACKEDRAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_PACKEDRAYS_INL_H
#undef TREEAMR_PACKEDRAYS_INL_H
#else
#define TREEAMR_PACKEDRAYS_INL_H
#endif

#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <cstdint>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

// Where one instruction picks lanes of two vectors by index: with compressing and expanding stores packing would take as
// long as it saves.
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
/// Which rays are packed, and which lanes have them.
class PackedRays
{
public:
  int count() const noexcept { return count_; }

  /// Packs `count` rays behind the others, those from `ray` on that are chosen. There must be room for them.
  HWY_INLINE void add(int ray, Mask<float> chosen, int count)
  {
    const __m512i lane = _mm512_load_si512(laneNumbers);
    const auto places = static_cast<__mmask16>(((1u << count) - 1) << count_);
    // Numbers of lanes from 16 on mean those of the second vector.
    from_ = _mm512_mask_expand_epi32(
      lane, places, _mm512_add_epi32(_mm512_maskz_compress_epi32(chosen.raw, lane), _mm512_set1_epi32(16)));
    parts_[size_++] = {
      _mm512_mask_expand_epi32(lane, chosen.raw, _mm512_add_epi32(lane, _mm512_set1_epi32(16 + count_))), ray
    };
    count_ += count;
  }
  /// What packed rays have, with that of the last ones added.
  HWY_INLINE Reals<float> with(Reals<float> packed, Reals<float> added) const
  {
    return Reals<float>{ _mm512_permutex2var_ps(packed.raw, from_, added.raw) };
  }

  /// Takes what packed rays have back to where the rays have it.
  template <class... Arrays>
  HWY_INLINE void unpack(int packed, Arrays*... arrays) const
  {
    const __m512 values[] = { _mm512_load_ps(arrays + packed)... };
    for (int p = 0; p < size_; ++p)
    {
      const __m512i home = parts_[p].home;
      const int ray = parts_[p].ray;
      int i = 0;
      (...,
        _mm512_store_ps(
          arrays + ray, _mm512_permutex2var_ps(_mm512_load_ps(arrays + ray), home, values[i++])));
    }
  }
  /// Lowers the ends of the rays of these lanes.
  HWY_INLINE void finish(Mask<float> done, float finished, float* ends) const
  {
    const RealTag<float> d;
    const __m512 none = _mm512_set1_ps(std::numeric_limits<float>::infinity());
    const __m512 limits = _mm512_mask_blend_ps(done.raw, none, _mm512_set1_ps(finished));
    for (int p = 0; p < size_; ++p)
    {
      float* const end = ends + parts_[p].ray;
      const Reals<float> limit{ _mm512_permutex2var_ps(none, parts_[p].home, limits) };
      hn::Store(hn::Min(hn::Load(d, end), limit), d, end);
    }
  }
  void clear() { size_ = count_ = 0; }

private:
  alignas(64) static constexpr std::int32_t laneNumbers[16] = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13,
    14, 15 };

  /// Rays of one group.
  struct Part
  {
    __m512i home; // by lane of the group, the lane that has its ray: as from_
    int ray;
  };
  __m512i from_; // by lane, that of the rays added last or of the packed ones
  int size_ = 0;
  int count_ = 0;
  Part parts_[16];
};
#endif

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

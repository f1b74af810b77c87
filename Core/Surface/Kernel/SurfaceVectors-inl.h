// Vectors of rays, for the stages of the surface kernel. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_SURFACEVECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_SURFACEVECTORS_INL_H
#undef TREEAMR_SURFACEVECTORS_INL_H
#else
#define TREEAMR_SURFACEVECTORS_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using IntTag = hn::RebindToSigned<Tag>;
using BitsTag = hn::RebindToUnsigned<Tag>;
using Doubles = hn::Vec<Tag>;
using Integers = hn::Vec<IntTag>;
using Mask = hn::Mask<Tag>;

HWY_INLINE Doubles set(double x)
{
  return hn::Set(Tag(), x);
}

constexpr int lanes = hn::MaxLanes(Tag());

/// Of each mask of 8 lanes the lanes that it has, a byte for each, from the lowest on.
inline constexpr std::array<std::uint64_t, 256> lanesOfMasks = [] {
  std::array<std::uint64_t, 256> lanesOf{};
  for (unsigned mask = 0; mask < 256; ++mask)
  {
    int count = 0;
    for (std::uint64_t lane = 0; lane < 8; ++lane)
    {
      if (mask >> lane & 1)
      {
        lanesOf[mask] |= lane << 8 * count++;
      }
    }
  }
  return lanesOf;
}();

/// Brings some lanes of vectors together. hn::CompressStore() does so too, but where that is no instruction, Highway 1.0
/// with GCC copies its tables to the stack at each call: on AVX2 frames took twice as long.
class Packing
{
public:
  HWY_INLINE explicit Packing(Mask kept)
    : kept_(kept)
    , indices_(hn::IndicesFromVec(Tag(), lanesOf(kept, bits_)))
  {
  }
  std::uint32_t bits() const { return bits_; }
  int count() const { return std::popcount(bits_); }
  /// May write a whole vector: beyond the lanes that are kept anything.
  HWY_INLINE void store(Doubles v, double* to) const
  {
    if constexpr (isInstruction)
    {
      hn::CompressStore(v, kept_, Tag(), to);
    }
    else
    {
      hn::StoreU(hn::TableLookupLanes(v, indices_), Tag(), to);
    }
  }
  HWY_INLINE void store(Integers v, std::int64_t* to) const
  {
    if constexpr (isInstruction)
    {
      hn::CompressStore(v, hn::RebindMask(IntTag(), kept_), IntTag(), to);
    }
    else
    {
      hn::StoreU(hn::BitCast(IntTag(), hn::TableLookupLanes(hn::BitCast(Tag(), v), indices_)), IntTag(), to);
    }
  }
  HWY_INLINE void store(Doubles v, float* to) const
  {
    const hn::Rebind<float, Tag> df;
    hn::StoreU(hn::DemoteTo(df, hn::TableLookupLanes(v, indices_)), df, to);
  }

private:
  static constexpr bool isInstruction = HWY_TARGET <= HWY_AVX3;

  static HWY_INLINE Integers lanesOf(Mask kept, std::uint32_t& keptBits)
  {
    const BitsTag du;
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(Tag(), kept, bits.data());
    keptBits = bits[0];
    const auto bytes = hn::Shr(hn::Set(du, lanesOfMasks[keptBits]), hn::ShiftLeft<3>(hn::Iota(du, 0)));
    return hn::BitCast(IntTag(), hn::And(bytes, hn::Set(du, 7)));
  }

  Mask kept_;
  std::uint32_t bits_ = 0;
  decltype(hn::IndicesFromVec(Tag(), Integers())) indices_;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

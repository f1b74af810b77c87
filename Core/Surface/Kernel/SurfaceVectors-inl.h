// Vectors of rays, for the stages of the surface kernel. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_SURFACEVECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_SURFACEVECTORS_INL_H
#undef TREEAMR_SURFACEVECTORS_INL_H
#else
#define TREEAMR_SURFACEVECTORS_INL_H
#endif

#include "Geometry/Vec3.h"

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

using Vectors3 = std::array<Doubles, 3>;

HWY_INLINE Doubles dotVectors(const Vectors3& a, const Vectors3& b)
{
  return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
}

HWY_INLINE Vectors3 setVectors(const Vec3& v)
{
  return { set(v[0]), set(v[1]), set(v[2]) };
}

/// normalized() for vectors of vectors.
HWY_INLINE Vectors3 normalizedVectors(const Vectors3& v)
{
  const Tag d;
  const Doubles square = dotVectors(v, v);
  const Doubles length = hn::Sqrt(square);
  Vectors3 n{ hn::Div(v[0], length), hn::Div(v[1], length), hn::Div(v[2], length) };
  if (!hn::AllTrue(d, hn::And(hn::Gt(square, set(1e-280)), hn::Lt(square, set(1e300)))))
  {
    HWY_ALIGN double from[3][lanes];
    for (int a = 0; a < 3; ++a)
    {
      hn::Store(v[a], d, from[a]);
    }
    for (int lane = 0; lane < lanes; ++lane)
    {
      const Vec3 one = normalized({ from[0][lane], from[1][lane], from[2][lane] });
      for (int a = 0; a < 3; ++a)
      {
        from[a][lane] = one[a];
      }
    }
    for (int a = 0; a < 3; ++a)
    {
      n[a] = hn::Load(d, from[a]);
    }
  }
  return n;
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

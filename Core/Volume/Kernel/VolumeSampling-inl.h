// How the volume kernel samples a block of leaves: vertex values, steps along rays, the transfer function. Compiled
// once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMESAMPLING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMESAMPLING_INL_H
#undef TREEAMR_VOLUMESAMPLING_INL_H
#else
#define TREEAMR_VOLUMESAMPLING_INL_H
#endif

#include "Volume/Kernel/VolumeKernel.h"

#include <hwy/highway.h>

#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 16>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using Mask = hn::Mask<FloatTag>;

constexpr int lanes = hn::MaxLanes(FloatTag());
/// Samples for the square root of the variation of optical depth on a ray's way through a block, before
/// `samplesPerCell` multiplies them: midpoint samples err by a part of the variation over their square.
constexpr float samplesPerRootVariation = 3.f;

struct Box
{
  std::array<float, 3> min;
  std::array<float, 3> max;
};

// Products and sums rounded apart, also where one instruction could do both: so every instruction set gives the
// same picture, to the bit. (Compiled with -ffp-contract=off.)
HWY_INLINE Floats mulAdd(Floats a, Floats b, Floats c)
{
  return hn::Add(hn::Mul(a, b), c);
}
HWY_INLINE Floats negMulAdd(Floats a, Floats b, Floats c)
{
  return hn::Sub(c, hn::Mul(a, b));
}

/// 1 - 2^x for x <= 0, to the digits of the result: what a faint step holds back is not lost beside one.
/// (Cephes' polynomial for single precision, without its range checks.)
HWY_INLINE Floats heldBack(Floats x)
{
  const FloatTag d;
  const IntTag di;
  x = hn::Max(x, hn::Set(d, -126.f));
  const Floats whole = hn::Round(x);
  const Floats f = hn::Sub(x, whole);
  Floats p = hn::Set(d, 1.535336188319500e-4f);
  p = mulAdd(p, f, hn::Set(d, 1.339887440266574e-3f));
  p = mulAdd(p, f, hn::Set(d, 9.618437357674640e-3f));
  p = mulAdd(p, f, hn::Set(d, 5.550332471162809e-2f));
  p = mulAdd(p, f, hn::Set(d, 2.402264791363012e-1f));
  p = mulAdd(p, f, hn::Set(d, 6.931472028550421e-1f));
  p = hn::Mul(p, f); // 2^f - 1
  const Floats power = hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(hn::NearestInt(whole), hn::Set(di, 127))));
  return negMulAdd(power, p, hn::Sub(hn::Set(d, 1.f), power));
}

/// How a block's values become positions in the transfer function's table.
struct ToTable
{
  float scale;
  float offset;
  float first; // hull of the block's positions, inside the table
  float last;
};

/// Vertex values in steps of their hull: those of a BlockRecord.
class QuantisedValues
{
public:
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  /// All in four registers, of which two-source permutes pick: a gather takes as long as several of them.
  explicit HWY_INLINE QuantisedValues(const std::uint16_t* values)
  {
    for (int i = 0; i < 4; ++i)
    {
      words_[i] = _mm512_loadu_si512(values + 32 * i);
    }
  }
#else
  explicit HWY_INLINE QuantisedValues(const std::uint16_t* values)
    : values_(values)
  {
  }
#endif

  /// Of the vertices (x, x + 1) in each of four rows: y and y + 1 at z, then at z + 1.
  HWY_INLINE void pairs(Ints index, Floats (&lower)[4], Floats (&upper)[4]) const
  {
    const FloatTag d;
    const IntTag di;
    constexpr int rows[4] = { 0, 5, 25, 30 };
    for (int r = 0; r < 4; ++r)
    {
      const Ints both = pairs(rows[r], index);
      lower[r] = hn::ConvertTo(d, hn::And(both, hn::Set(di, 0xffff)));
      upper[r] = hn::ConvertTo(
        d, hn::BitCast(di, hn::ShiftRight<16>(hn::BitCast(hn::RebindToUnsigned<FloatTag>(), both))));
    }
  }

private:
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  HWY_INLINE Ints pairs(int row, Ints index) const
  {
    const IntTag di;
    // Six bits of an index choose among two registers, the seventh between these and the other two.
    const Ints both = hn::Add(hn::Or(index, hn::ShiftLeft<16>(index)), hn::Set(di, row | (row + 1) << 16));
    const __m512i low = _mm512_permutex2var_epi16(words_[0], both.raw, words_[1]);
    const __m512i high = _mm512_permutex2var_epi16(words_[2], both.raw, words_[3]);
    return Ints{ _mm512_mask_mov_epi16(low, _mm512_test_epi16_mask(both.raw, _mm512_set1_epi16(64)), high) };
  }

  __m512i words_[4];
#else
  HWY_INLINE Ints pairs(int row, Ints index) const
  {
    const IntTag di;
#if HWY_TARGET == HWY_AVX2
    return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(values_ + row), hn::Add(index, index));
#else
    // Without the instruction, and without its licence to read between the element's boundaries.
    HWY_ALIGN std::int32_t at[lanes];
    HWY_ALIGN std::int32_t both[lanes];
    hn::Store(index, di, at);
    for (int i = 0; i < lanes; ++i)
    {
      std::memcpy(both + i, values_ + row + at[i], sizeof(*both));
    }
    return hn::Load(di, both);
#endif
  }

  const std::uint16_t* values_;
#endif
};

/// Vertex values as they are, where a step of their hull is too coarse.
struct ExactValues
{
  const float* values;

  HWY_INLINE void pairs(Ints index, Floats (&lower)[4], Floats (&upper)[4]) const
  {
    const FloatTag d;
    constexpr int rows[4] = { 0, 5, 25, 30 };
    for (int r = 0; r < 4; ++r)
    {
      lower[r] = hn::GatherIndex(d, values + rows[r], index);
      upper[r] = hn::GatherIndex(d, values + rows[r] + 1, index);
    }
  }
};

/// The lattice of vertices that positions count in, in half widths of a leaf, and the part of it to use.
struct Lattice
{
  /// Of a whole block.
  explicit Lattice(const Box& box)
  {
    for (int a = 0; a < 3; ++a)
    {
      scale[a] = 4.f / (box.max[a] - box.min[a]);
      min[a] = box.min[a];
      first[a] = 0.f;
      last[a] = 3.f;
    }
  }
  /// Of the child in an octant, from its box.
  Lattice(const Box& child, int octant)
  {
    for (int a = 0; a < 3; ++a)
    {
      const float width = child.max[a] - child.min[a];
      const bool upper = octant >> a & 1;
      scale[a] = 2.f / width;
      min[a] = upper ? child.min[a] - width : child.min[a];
      first[a] = upper ? 2.f : 0.f;
      last[a] = upper ? 3.f : 1.f;
    }
  }
  float min[3];
  float scale[3];
  float first[3];
  float last[3];
};

HWY_INLINE Floats lerp(Floats f, Floats a, Floats b)
{
  return mulAdd(f, hn::Sub(b, a), a);
}

/// Where rays run on the lattice, and how far.
struct Span
{
  Floats start[3];
  Floats slope[3]; // per t
  Floats step;     // of t
  Floats depthPerExtinction;
  Floats samples; // 0 for rays that miss the box
};

/// The field after `Count` numbers of steps, as positions in the table. Side by side, because a single chain of
/// loads leaves the processor waiting.
template <int Count, class Values>
HWY_INLINE void sample(const Span& span, const float (&steps)[Count], const Values& values,
  const ToTable& toTable, const Lattice& lattice, Floats (&position)[Count])
{
  const FloatTag d;
  const IntTag di;
  Floats f[Count][3];
  Ints vertex[Count];
  for (int k = 0; k < Count; ++k)
  {
    const Floats along = hn::Mul(hn::Set(d, steps[k]), span.step);
    Floats cell[3];
    for (int a = 0; a < 3; ++a)
    {
      const Floats at = mulAdd(along, span.slope[a], span.start[a]);
      cell[a] = hn::Min(hn::Max(hn::Floor(at), hn::Set(d, lattice.first[a])), hn::Set(d, lattice.last[a]));
      f[k][a] = hn::Sub(at, cell[a]);
    }
    vertex[k] =
      hn::ConvertTo(di, mulAdd(mulAdd(cell[2], hn::Set(d, 5.f), cell[1]), hn::Set(d, 5.f), cell[0]));
  }
  Floats lower[Count][4];
  Floats upper[Count][4];
  for (int k = 0; k < Count; ++k)
  {
    values.pairs(vertex[k], lower[k], upper[k]);
  }
  for (int k = 0; k < Count; ++k)
  {
    const Floats low =
      lerp(f[k][1], lerp(f[k][0], lower[k][0], upper[k][0]), lerp(f[k][0], lower[k][1], upper[k][1]));
    const Floats high =
      lerp(f[k][1], lerp(f[k][0], lower[k][2], upper[k][2]), lerp(f[k][0], lower[k][3], upper[k][3]));
    const Floats value =
      mulAdd(lerp(f[k][2], low, high), hn::Set(d, toTable.scale), hn::Set(d, toTable.offset));
    // Rounding must not leave the hull by which nodes are skipped.
    position[k] = hn::Min(hn::Max(value, hn::Set(d, toTable.first)), hn::Set(d, toTable.last));
  }
}

/// What rays have gathered so far.
struct Light
{
  Floats transmittance;
  Floats opacity; // summed up by itself: one minus the transmittance has no digits for faint things
  Floats red;
  Floats green;
  Floats blue;
};

/// `Count` midpoint samples from step i on; how many of them were lit for any ray. entries: those of KernelTable.
template <int Count, class Values>
HWY_INLINE int takePoints(const float* entries, const Span& span, float i, const Values& values,
  const ToTable& toTable, const Lattice& lattice, Light& light)
{
  const FloatTag d;
  float steps[Count];
  for (int k = 0; k < Count; ++k)
  {
    steps[k] = i + static_cast<float>(k) + 0.5f;
  }
  Floats position[Count];
  sample(span, steps, values, toTable, lattice, position);
  Ints entry[Count];
  Floats extinction[Count];
  Floats any = hn::Zero(d);
  for (int k = 0; k < Count; ++k)
  {
    entry[k] = hn::ShiftLeft<2>(hn::NearestInt(position[k])); // of four floats
    extinction[k] = hn::IfThenElseZero(
      hn::Lt(hn::Set(d, i + static_cast<float>(k)), span.samples), hn::GatherIndex(d, entries + 3, entry[k]));
    any = hn::Max(any, extinction[k]);
  }
  if (hn::AllFalse(d, hn::Gt(any, hn::Zero(d))))
  {
    return 0;
  }
  Floats held[Count];
  for (int k = 0; k < Count; ++k)
  {
    held[k] = heldBack(hn::Neg(hn::Mul(extinction[k], span.depthPerExtinction)));
  }
  for (int k = 0; k < Count; ++k)
  {
    const Floats weight = hn::Mul(light.transmittance, held[k]);
    light.red = mulAdd(weight, hn::GatherIndex(d, entries, entry[k]), light.red);
    light.green = mulAdd(weight, hn::GatherIndex(d, entries + 1, entry[k]), light.green);
    light.blue = mulAdd(weight, hn::GatherIndex(d, entries + 2, entry[k]), light.blue);
    light.opacity = hn::Add(light.opacity, weight);
    light.transmittance = hn::Sub(light.transmittance, weight);
  }
  return Count;
}

/// Mean of extinction and extinction times colour over the table between two positions, at which entry i begins
/// at i: it stands for what is nearest to it. last: number of the last entry.
HWY_INLINE void integral(
  const KernelTable::Integral* integrals, float last, Floats low, Floats high, Floats (&mean)[4])
{
  const FloatTag d;
  const IntTag di;
  constexpr int row = sizeof(KernelTable::Integral) / sizeof(float);
  const Floats perEntry = hn::Div(hn::Set(d, 1.f), hn::Sub(high, low));
  const Floats first = hn::Floor(low);
  const Floats end = hn::Min(hn::Floor(high), hn::Set(d, last));
  const Floats before = hn::Sub(low, first); // parts of entries
  const Floats beyond = hn::Sub(high, end);
  const float* table = integrals->sum;
  const Ints from = hn::Mul(hn::ConvertTo(di, first), hn::Set(di, row));
  const Ints to = hn::Mul(hn::ConvertTo(di, end), hn::Set(di, row));
  for (int c = 0; c < 4; ++c)
  {
    const Floats sum = hn::Sub(hn::GatherIndex(d, table + c, to), hn::GatherIndex(d, table + c, from));
    const Floats rest =
      hn::Sub(hn::GatherIndex(d, table + 4 + c, to), hn::GatherIndex(d, table + 4 + c, from));
    const Floats parts = negMulAdd(before, hn::GatherIndex(d, table + 8 + c, from),
      hn::Mul(beyond, hn::GatherIndex(d, table + 8 + c, to)));
    mean[c] = hn::Mul(hn::Add(hn::Add(sum, rest), parts), perEntry);
  }
}

/// Steps by the transfer function's integrals.
template <class Values>
HWY_INLINE void takeIntegrals(const KernelTable& table, const Span& span, float mostSamples,
  const Values& values, const ToTable& toTable, const Lattice& lattice, Light& light)
{
  const FloatTag d;
  Floats first[1];
  sample(span, { 0.f }, values, toTable, lattice, first);
  Floats before = first[0];
  for (float i = 0.f; i < mostSamples; i += 1.f)
  {
    // Of the change over the step, about the value in its middle: that follows a bent field. Of an entry at
    // least, so that a spike crossed in many steps has no more and no less than its share.
    Floats position[2];
    sample(span, { i + 0.5f, i + 1.f }, values, toTable, lattice, position);
    const Floats half =
      hn::Max(hn::Mul(hn::Abs(hn::Sub(position[1], before)), hn::Set(d, 0.5f)), hn::Set(d, 0.5f));
    before = position[1];
    const Floats middle = hn::Add(position[0], hn::Set(d, 0.5f));
    Floats mean[4];
    // Within the entries around the hull by which nodes are skipped.
    integral(table.integrals.data(), table.last, hn::Max(hn::Sub(middle, half), hn::Set(d, toTable.first)),
      hn::Min(hn::Add(middle, half), hn::Set(d, toTable.last + 1.f)), mean);
    const Floats extinction =
      hn::IfThenElseZero(hn::Lt(hn::Set(d, i), span.samples), hn::ZeroIfNegative(mean[3]));
    const Floats held =
      heldBack(hn::Mul(extinction, hn::Mul(span.depthPerExtinction, hn::Set(d, -1.44269504f))));
    const Floats weight = hn::Mul(light.transmittance, held);
    // None where there is no extinction.
    const Floats perExtinction =
      hn::IfThenElseZero(hn::Gt(extinction, hn::Zero(d)), hn::Div(weight, extinction));
    light.red = mulAdd(perExtinction, mean[0], light.red);
    light.green = mulAdd(perExtinction, mean[1], light.green);
    light.blue = mulAdd(perExtinction, mean[2], light.blue);
    light.opacity = hn::Add(light.opacity, weight);
    light.transmittance = hn::Sub(light.transmittance, weight);
  }
}

/// From the squares of the numbers of samples that rays want; the most of any. Up to four come without root and
/// division, whose wait every interval would begin with.
HWY_INLINE float chooseSteps(Floats wanted, Floats length, Span& span)
{
  const FloatTag d;
  const Floats one = hn::Set(d, 1.f);
  const Mask two = hn::Gt(wanted, one);
  const Mask three = hn::Gt(wanted, hn::Set(d, 4.f));
  const Mask four = hn::Gt(wanted, hn::Set(d, 9.f));
  const Mask more = hn::Gt(wanted, hn::Set(d, 16.f));
  span.samples = hn::IfThenElse(
    four, hn::Set(d, 4.f), hn::IfThenElse(three, hn::Set(d, 3.f), hn::IfThenElse(two, hn::Set(d, 2.f), one)));
  span.step = hn::Mul(length,
    hn::IfThenElse(four, hn::Set(d, 0.25f),
      hn::IfThenElse(three, hn::Set(d, 1.f / 3.f), hn::IfThenElse(two, hn::Set(d, 0.5f), one))));
  if (hn::AllFalse(d, more))
  {
    return hn::AllFalse(d, three) ? (hn::AllFalse(d, two) ? 1.f : 2.f) : (hn::AllFalse(d, four) ? 3.f : 4.f);
  }
  span.samples = hn::IfThenElse(more, hn::Ceil(hn::Sqrt(wanted)), span.samples);
  span.step = hn::IfThenElse(more, hn::Div(length, span.samples), span.step);
  return hn::GetLane(hn::MaxOfLanes(d, span.samples));
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

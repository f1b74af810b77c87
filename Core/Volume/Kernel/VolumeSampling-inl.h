// How the volume kernel samples a block of leaves: vertex values, steps along rays, the transfer function. Compiled
// once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMESAMPLING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMESAMPLING_INL_H
#undef TREEAMR_VOLUMESAMPLING_INL_H
#else
#define TREEAMR_VOLUMESAMPLING_INL_H
#endif

#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeLanes-inl.h"

#include <hwy/highway.h>

#include <cstring>
#include <limits>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// Samples for the square root of the variation of optical depth on a ray's way through a block, before
/// `samplesPerCell` multiplies them: midpoint samples err by a part of the variation over their square.
constexpr float samplesPerRootVariation = 3.f;

template <class Real>
struct Box
{
  std::array<Real, 3> min;
  std::array<Real, 3> max;
};

// Products and sums rounded apart, also where one instruction could do both: so every instruction set gives the
// same picture, to the bit. (Compiled with -ffp-contract=off.)
template <class V>
HWY_INLINE V mulAdd(V a, V b, V c)
{
  return hn::Add(hn::Mul(a, b), c);
}
template <class V>
HWY_INLINE V negMulAdd(V a, V b, V c)
{
  return hn::Sub(c, hn::Mul(a, b));
}

/// 1 - 2^x for x <= 0, to the digits of the result: what a faint step holds back is not lost beside one.
/// (Cephes' polynomial for single precision, without its range checks.)
template <class V>
HWY_INLINE V heldBack(V x)
{
  using Real = hn::TFromV<V>;
  using Limits = std::numeric_limits<Real>;
  const hn::DFromV<V> d;
  const hn::RebindToSigned<hn::DFromV<V>> di;
  x = hn::Max(x, hn::Set(d, Real(Limits::min_exponent - 1)));
  const V whole = hn::Round(x);
  const V f = hn::Sub(x, whole);
  V p = hn::Set(d, Real(1.535336188319500e-4));
  p = mulAdd(p, f, hn::Set(d, Real(1.339887440266574e-3)));
  p = mulAdd(p, f, hn::Set(d, Real(9.618437357674640e-3)));
  p = mulAdd(p, f, hn::Set(d, Real(5.550332471162809e-2)));
  p = mulAdd(p, f, hn::Set(d, Real(2.402264791363012e-1)));
  p = mulAdd(p, f, hn::Set(d, Real(6.931472028550421e-1)));
  p = hn::Mul(p, f); // 2^f - 1
  // Where one is a number's last bit, its lowest bits are whole numbers.
  constexpr int mantissa = Limits::digits - 1;
  const V biased = hn::Add(whole, hn::Set(d, Real(1.5) / Limits::epsilon() + (Limits::max_exponent - 1)));
  const V power = hn::BitCast(d, hn::ShiftLeft<mantissa>(hn::BitCast(di, biased)));
  return negMulAdd(power, p, hn::Sub(hn::Set(d, Real(1)), power));
}

/// How a block's values become positions in the transfer function's table.
template <class Real>
struct ToTable
{
  Real scale;
  Real offset;
  Real first; // hull of the block's positions, inside the table
  Real last;
};

/// Vertex values in steps of their hull: those of a BlockRecord.
class QuantisedValues
{
public:
  using Element = std::uint16_t;

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
  HWY_INLINE void pairs(Ints<float> index, Reals<float> (&lower)[4], Reals<float> (&upper)[4]) const
  {
    const RealTag<float> d;
    const IntTag<float> di;
    constexpr int rows[4] = { 0, 5, 25, 30 };
    for (int r = 0; r < 4; ++r)
    {
      const Ints<float> both = pairs(rows[r], index);
      lower[r] = hn::ConvertTo(d, hn::And(both, hn::Set(di, 0xffff)));
      upper[r] = hn::ConvertTo(
        d, hn::BitCast(di, hn::ShiftRight<16>(hn::BitCast(hn::RebindToUnsigned<RealTag<float>>(), both))));
    }
  }

  /// Of single vertices.
  HWY_INLINE Reals<float> at(Ints<float> index) const
  {
    return hn::ConvertTo(RealTag<float>(), hn::And(pairs(0, index), hn::Set(IntTag<float>(), 0xffff)));
  }

  /// Of one of these rows as they are kept, the vertex at x + 1 in the upper half.
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  HWY_INLINE Ints<float> pairs(int row, Ints<float> index) const
  {
    const IntTag<float> di;
    // Six bits of an index choose among two registers, the seventh between these and the other two.
    const Ints<float> both =
      hn::Add(hn::Or(index, hn::ShiftLeft<16>(index)), hn::Set(di, row | (row + 1) << 16));
    const __m512i low = _mm512_permutex2var_epi16(words_[0], both.raw, words_[1]);
    const __m512i high = _mm512_permutex2var_epi16(words_[2], both.raw, words_[3]);
    return Ints<float>{ _mm512_mask_mov_epi16(
      low, _mm512_test_epi16_mask(both.raw, _mm512_set1_epi16(64)), high) };
  }

private:
  __m512i words_[4];
#else
  HWY_INLINE Ints<float> pairs(int row, Ints<float> index) const
  {
    const IntTag<float> di;
#if HWY_TARGET == HWY_AVX2
    return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(values_ + row), hn::Add(index, index));
#else
    // Without the instruction, and without its licence to read between the element's boundaries.
    HWY_ALIGN std::int32_t at[lanes<float>];
    HWY_ALIGN std::int32_t both[lanes<float>];
    hn::Store(index, di, at);
    for (int i = 0; i < lanes<float>; ++i)
    {
      std::memcpy(both + i, values_ + row + at[i], sizeof(*both));
    }
    return hn::Load(di, both);
#endif
  }

private:
  const std::uint16_t* values_;
#endif
};

/// Vertex values as they are, where a step of their hull is too coarse.
template <class Real>
struct ExactValues
{
  using Element = Real;

  const Real* values;

  HWY_INLINE Reals<Real> at(Ints<Real> index) const
  {
    return hn::GatherIndex(RealTag<Real>(), values, asWideAsLanes<Real>(index));
  }

  HWY_INLINE void pairs(Ints<Real> index, Reals<Real> (&lower)[4], Reals<Real> (&upper)[4]) const
  {
    const RealTag<Real> d;
    constexpr int rows[4] = { 0, 5, 25, 30 };
    const auto wide = asWideAsLanes<Real>(index);
    for (int r = 0; r < 4; ++r)
    {
      lower[r] = hn::GatherIndex(d, values + rows[r], wide);
      upper[r] = hn::GatherIndex(d, values + rows[r] + 1, wide);
    }
  }
};

/// The lattice of vertices that positions count in, in half widths of a leaf, and the part of it to use.
template <class Real>
struct Lattice
{
  /// Of a whole block.
  explicit Lattice(const Box<Real>& box)
  {
    for (int a = 0; a < 3; ++a)
    {
      scale[a] = 4 / (box.max[a] - box.min[a]);
      min[a] = box.min[a];
      first[a] = 0;
      last[a] = 3;
    }
  }
  /// Of the child in an octant, from its box.
  Lattice(const Box<Real>& child, int octant)
  {
    for (int a = 0; a < 3; ++a)
    {
      const Real width = child.max[a] - child.min[a];
      const bool upper = octant >> a & 1;
      scale[a] = 2 / width;
      min[a] = upper ? child.min[a] - width : child.min[a];
      first[a] = upper ? 2 : 0;
      last[a] = upper ? 3 : 1;
    }
  }
  Real min[3];
  Real scale[3];
  Real first[3];
  Real last[3];
};

template <class V>
HWY_INLINE V lerp(V f, V a, V b)
{
  return mulAdd(f, hn::Sub(b, a), a);
}

/// Where rays run on the lattice, and how far.
template <class Real>
struct Span
{
  Reals<Real> start[3];
  Reals<Real> slope[3]; // per t
  Reals<Real> step;     // of t
  Reals<Real> depthPerExtinction;
  Reals<Real> samples; // 0 for rays that miss the box
};

/// Where in an octant rays are: its lowest vertex, and parts of its width.
template <class Real>
struct Spot
{
  Ints<Real> vertex;
  Reals<Real> f[3];
};

/// The octants in which rays are after `steps`, as far as the lattice goes.
template <class Real>
HWY_INLINE Spot<Real> locate(const Span<Real>& span, Reals<Real> steps, const Lattice<Real>& lattice)
{
  const RealTag<Real> d;
  Spot<Real> spot;
  const Reals<Real> along = hn::Mul(steps, span.step);
  Reals<Real> cell[3];
  for (int a = 0; a < 3; ++a)
  {
    const Reals<Real> at = mulAdd(along, span.slope[a], span.start[a]);
    cell[a] = hn::Min(hn::Max(hn::Floor(at), hn::Set(d, lattice.first[a])), hn::Set(d, lattice.last[a]));
    spot.f[a] = hn::Sub(at, cell[a]);
  }
  spot.vertex =
    truncated<Real>(mulAdd(mulAdd(cell[2], hn::Set(d, Real(5)), cell[1]), hn::Set(d, Real(5)), cell[0]));
  return spot;
}

/// Between an octant's vertices, as Values::pairs() gives them.
template <class Real>
HWY_INLINE Reals<Real> between(
  const Reals<Real> (&f)[3], const Reals<Real> (&lower)[4], const Reals<Real> (&upper)[4])
{
  const Reals<Real> low = lerp(f[1], lerp(f[0], lower[0], upper[0]), lerp(f[0], lower[1], upper[1]));
  const Reals<Real> high = lerp(f[1], lerp(f[0], lower[2], upper[2]), lerp(f[0], lower[3], upper[3]));
  return lerp(f[2], low, high);
}

template <class Real>
HWY_INLINE Reals<Real> inTable(const ToTable<Real>& toTable, Reals<Real> value)
{
  const RealTag<Real> d;
  const Reals<Real> position = mulAdd(value, hn::Set(d, toTable.scale), hn::Set(d, toTable.offset));
  // Rounding must not leave the hull by which nodes are skipped.
  return hn::Min(hn::Max(position, hn::Set(d, toTable.first)), hn::Set(d, toTable.last));
}

/// The field at `Count` spots, as positions in the table. Side by side, because a single chain of loads leaves the
/// processor waiting.
template <int Count, class Real, class Values>
HWY_INLINE void sample(const Spot<Real> (&spots)[Count], const Values& values, const ToTable<Real>& toTable,
  Reals<Real> (&position)[Count])
{
  Reals<Real> lower[Count][4];
  Reals<Real> upper[Count][4];
  for (int k = 0; k < Count; ++k)
  {
    values.pairs(spots[k].vertex, lower[k], upper[k]);
  }
  for (int k = 0; k < Count; ++k)
  {
    position[k] = inTable(toTable, between<Real>(spots[k].f, lower[k], upper[k]));
  }
}

/// The same after numbers of steps.
template <int Count, class Real, class Values>
HWY_INLINE void sample(const Span<Real>& span, const Reals<Real> (&steps)[Count], const Values& values,
  const ToTable<Real>& toTable, const Lattice<Real>& lattice, Reals<Real> (&position)[Count])
{
  Spot<Real> spots[Count];
  for (int k = 0; k < Count; ++k)
  {
    spots[k] = locate(span, steps[k], lattice);
  }
  sample(spots, values, toTable, position);
}

/// What rays have gathered so far.
template <class Real>
struct Light
{
  Reals<Real> transmittance;
  Reals<Real> opacity; // summed up by itself: one minus the transmittance has no digits for faint things
  Reals<Real> red;
  Reals<Real> green;
  Reals<Real> blue;

  /// What holds back `weight` of the light and has a colour.
  HWY_INLINE void add(const Reals<Real>* color, Reals<Real> weight)
  {
    red = mulAdd(weight, color[0], red);
    green = mulAdd(weight, color[1], green);
    blue = mulAdd(weight, color[2], blue);
    opacity = hn::Add(opacity, weight);
    transmittance = hn::Sub(transmittance, weight);
  }

  /// Colour and opacity, of some rays.
  HWY_INLINE void add(const Reals<Real> (&terms)[4], Mask<Real> taken)
  {
    red = hn::Add(red, hn::IfThenElseZero(taken, terms[0]));
    green = hn::Add(green, hn::IfThenElseZero(taken, terms[1]));
    blue = hn::Add(blue, hn::IfThenElseZero(taken, terms[2]));
    opacity = hn::Add(opacity, hn::IfThenElseZero(taken, terms[3]));
    transmittance = hn::Sub(transmittance, hn::IfThenElseZero(taken, terms[3]));
  }
};

/// Of samples that show the table's entries as they are: see VolumeLight-inl.h for others.
struct Unlit
{
  static constexpr bool isLit = false;
  struct Effect
  {
  };
};

/// `Count` midpoint samples from step i on; how many of them were lit for any ray. entries: those of VolumeTable.
/// Lighting: Unlit or LightOnRays.
template <int Count, class Real, class Values, class Lighting>
HWY_INLINE int takePoints(const float* entries, const Span<Real>& span, Real i, const Values& values,
  const ToTable<Real>& toTable, const Lattice<Real>& lattice, const Lighting& lighting, Light<Real>& light)
{
  const RealTag<Real> d;
  Spot<Real> spots[Count];
  for (int k = 0; k < Count; ++k)
  {
    spots[k] = locate(span, hn::Set(d, i + static_cast<Real>(k) + Real(0.5)), lattice);
  }
  Reals<Real> position[Count];
  sample(spots, values, toTable, position);
  Reals<Real> entry[Count][4];
  Reals<Real> extinction[Count];
  Reals<Real> any = hn::Zero(d);
  for (int k = 0; k < Count; ++k)
  {
    gatherFours<Real>(entries, hn::ShiftLeft<2>(nearest<Real>(position[k])), entry[k]);
    extinction[k] =
      hn::IfThenElseZero(hn::Lt(hn::Set(d, i + static_cast<Real>(k)), span.samples), entry[k][3]);
    any = hn::Max(any, extinction[k]);
  }
  bool isOfMany = false;
  [[maybe_unused]] bool makesExtinction = false;
  if constexpr (Lighting::isLit)
  {
    isOfMany = lighting.isOfMany();
    makesExtinction = lighting.makesExtinction();
  }
  if (!isOfMany && hn::AllFalse(d, hn::Gt(any, hn::Zero(d))))
  {
    return 0;
  }
  [[maybe_unused]] typename Lighting::Effect effects[Count];
  [[maybe_unused]] bool isSeen[Count];
  Reals<Real> held[Count];
  for (int k = 0; k < Count; ++k)
  {
    if constexpr (Lighting::isLit)
    {
      isSeen[k] = isOfMany || !hn::AllFalse(d, hn::Gt(extinction[k], hn::Zero(d)));
      if (!isSeen[k])
      {
        continue;
      }
      const Reals<Real> steps = hn::Set(d, i + static_cast<Real>(k) + Real(0.5));
      effects[k] = lighting.at(spots[k], hn::Mul(steps, span.step), position[k], extinction[k]);
      const Mask<Real> isTaken = hn::Lt(hn::Set(d, i + static_cast<Real>(k)), span.samples);
      // Whether a ray's sample counts must not depend on its neighbours'.
      const Mask<Real> isCounted = isOfMany ? isTaken : hn::Gt(extinction[k], hn::Zero(d));
      extinction[k] = makesExtinction ? hn::IfThenElseZero(isCounted, effects[k].opacity)
                                      : hn::Mul(extinction[k], effects[k].opacity);
    }
    held[k] = heldBack(hn::Neg(hn::Mul(extinction[k], span.depthPerExtinction)));
  }
  for (int k = 0; k < Count; ++k)
  {
    if (Lighting::isLit && !isSeen[k])
    {
      continue;
    }
    Reals<Real> color[3] = { entry[k][0], entry[k][1], entry[k][2] };
    if constexpr (Lighting::isLit)
    {
      lighting.shade(effects[k], hn::Set(d, Real(1)), color);
    }
    light.add(color, hn::Mul(light.transmittance, held[k]));
  }
  return Count;
}

/// From the squares of the numbers of samples that rays want; the most of any. Up to four come without root and
/// division, whose wait every interval would begin with.
template <class Real>
HWY_INLINE Real chooseSteps(Reals<Real> wanted, Reals<Real> length, Span<Real>& span)
{
  const RealTag<Real> d;
  const Reals<Real> one = hn::Set(d, Real(1));
  const Mask<Real> two = hn::Gt(wanted, one);
  const Mask<Real> three = hn::Gt(wanted, hn::Set(d, Real(4)));
  const Mask<Real> four = hn::Gt(wanted, hn::Set(d, Real(9)));
  const Mask<Real> more = hn::Gt(wanted, hn::Set(d, Real(16)));
  span.samples = hn::IfThenElse(four, hn::Set(d, Real(4)),
    hn::IfThenElse(three, hn::Set(d, Real(3)), hn::IfThenElse(two, hn::Set(d, Real(2)), one)));
  span.step = hn::Mul(length,
    hn::IfThenElse(four, hn::Set(d, Real(0.25)),
      hn::IfThenElse(three, hn::Set(d, Real(1) / 3), hn::IfThenElse(two, hn::Set(d, Real(0.5)), one))));
  if (hn::AllFalse(d, more))
  {
    return hn::AllFalse(d, three) ? (hn::AllFalse(d, two) ? 1 : 2) : (hn::AllFalse(d, four) ? 3 : 4);
  }
  span.samples = hn::IfThenElse(more, hn::Ceil(hn::Sqrt(wanted)), span.samples);
  span.step = hn::IfThenElse(more, hn::Div(length, span.samples), span.step);
  return hn::GetLane(hn::MaxOfLanes(d, span.samples));
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

// Steps of rays by the transfer function's integrals: over all values that the field covers in a step, however the
// function bends or jumps there. Compiled once for each instruction set, as Highway wants it.
//
// A step is compared with its two halves, and cut until these make no difference that is seen. So what is opaque hides
// what lies behind it in the step, and where nothing bends a step is as long as it may be.
#if defined(TREEAMR_VOLUMEINTEGRALS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMEINTEGRALS_INL_H
#undef TREEAMR_VOLUMEINTEGRALS_INL_H
#else
#define TREEAMR_VOLUMEINTEGRALS_INL_H
#endif

#include "Volume/Kernel/IntegralTable.h"
#include "Volume/Kernel/VolumeCubics-inl.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// By which a step may differ from its halves in a channel of the picture, at one sample a cell.
constexpr float integralTolerance = 1.f / 1024.f;
/// Of the light, held back by half a step in whose front something may hide its back.
constexpr float dense = 0.1f;
/// By which the colour of such a step may err.
constexpr float partOfColors = 1.f / 16.f;
/// Of the table.
constexpr float widestStep = 8.f;
/// Halvings of a step at most.
constexpr float shortestStep = 0x1p-14f;

/// Places in the table, their rows, and the function there.
template <class Real>
struct Places
{
  Reals<Real> at;
  Reals<Real> row; // whole numbers
  Reals<Real> term[4];
  Reals<Real> inRow;    // from where the row begins
  Reals<Real> ofRow[4]; // the terms' integrals from there
};

template <class Real>
HWY_INLINE Reals<Real> findRows(const IntegralTable& table, Reals<Real> at)
{
  const RealTag<Real> d;
  const IntTag<Real> di;
  const hn::Rebind<float, RealTag<Real>> df;
  const IntegralTable::Index& index = table.index();
  hn::Vec<decltype(df)> place;
  if constexpr (std::is_same_v<Real, float>)
  {
    place = at;
  }
  else
  {
    place = hn::DemoteTo(df, at);
  }
  place = hn::Min(hn::Max(place, hn::Set(df, index.first)), hn::Set(df, index.last));
  Ints<Real> cell;
  if (index.byBits)
  {
    const Ints<Real> bits = hn::BitCast(di, place);
    const Ints<Real> ordered = hn::Xor(bits, hn::And(hn::BroadcastSignBit(bits), hn::Set(di, 0x7fffffff)));
    cell = hn::Sub(hn::ShiftRightSame(ordered, index.shift), hn::Set(di, index.firstBits));
  }
  else
  {
    cell =
      hn::ConvertTo(di, hn::Mul(hn::Sub(place, hn::Set(df, index.first)), hn::Set(df, index.cellsPerPlace)));
  }
  Reals<Real> row = gather<Real>(index.firstRow.data(), hn::Min(cell, hn::Set(di, index.lastCell)));
  for (int step = (1 << index.halvings) >> 1; step > 0; step >>= 1)
  {
    const Reals<Real> candidate = hn::Add(row, hn::Set(d, static_cast<Real>(step)));
    const Mask<Real> reached = hn::Ge(at, gather<Real>(table.places(), truncated<Real>(candidate)));
    row = hn::IfThenElse(reached, candidate, row);
  }
  return row;
}

constexpr int rowSize = sizeof(IntegralTable::Row) / sizeof(float);

template <class Real>
HWY_INLINE Places<Real> findPlaces(const IntegralTable& table, Reals<Real> at)
{
  const IntTag<Real> di;
  Places<Real> places;
  places.at = at;
  places.row = findRows<Real>(table, at);
  const Ints<Real> row = truncated<Real>(places.row);
  places.inRow = hn::Sub(at, gather<Real>(table.places(), row));
  const Reals<Real> halfInRow = hn::Mul(places.inRow, half<Real>());
  const Ints<Real> index = hn::Mul(row, hn::Set(di, rowSize));
  Reals<Real> own[4];
  Reals<Real> slope[4];
  gatherFours<Real>(table.rows()[0].own, index, own);
  gatherFours<Real>(table.rows()[0].slope, index, slope);
  for (int c = 0; c < 4; ++c)
  {
    places.term[c] = mulAdd(slope[c], places.inRow, own[c]);
    places.ofRow[c] = hn::Mul(halfInRow, hn::Add(places.term[c], own[c]));
  }
  return places;
}

/// Integrals of the terms up to places, in two parts: those of rows, and what is little beside them.
template <class Real>
struct Sums
{
  Reals<Real> sum[4];
  Reals<Real> rest[4];
};

template <class Real>
HWY_INLINE Sums<Real> findSums(const IntegralTable& table, const Places<Real>& places)
{
  const IntTag<Real> di;
  const Ints<Real> index = hn::Mul(truncated<Real>(places.row), hn::Set(di, rowSize));
  Sums<Real> sums;
  Reals<Real> rest[4];
  gatherFours<Real>(table.rows()[0].sum, index, sums.sum);
  gatherFours<Real>(table.rows()[0].rest, index, rest);
  for (int c = 0; c < 4; ++c)
  {
    sums.rest[c] = hn::Add(places.ofRow[c], rest[c]);
  }
  return sums;
}

/// Means over what lies between two places.
template <class Real>
HWY_INLINE void meanByEnds(const Places<Real>& a, const Places<Real>& b, Reals<Real> (&mean)[4])
{
  for (int c = 0; c < 4; ++c)
  {
    mean[c] = hn::Mul(hn::Add(a.term[c], b.term[c]), half<Real>());
  }
}

/// The same of narrow steps from row to row, from the ends of what lies in either: sums from where rows begin would
/// leave their differences no digits.
template <class Real>
HWY_NOINLINE void meanOfNarrow(const IntegralTable& table, const Places<Real>& a, const Places<Real>& b,
  Mask<Real> narrow, Reals<Real> (&mean)[4])
{
  const RealTag<Real> d;
  const IntTag<Real> di;
  const IntegralTable::Row& rows = table.rows()[0];
  const Mask<Real> rises = hn::Le(a.at, b.at);
  const Reals<Real> low = hn::Min(a.at, b.at);
  const Reals<Real> high = hn::Max(a.at, b.at);
  const Ints<Real> lowRow = truncated<Real>(hn::Min(a.row, b.row));
  const Ints<Real> highRow = truncated<Real>(hn::Max(a.row, b.row));
  const Ints<Real> from = hn::Mul(lowRow, hn::Set(di, rowSize));
  const Ints<Real> next = hn::Add(from, hn::Set(di, rowSize));
  const Ints<Real> to = hn::Mul(highRow, hn::Set(di, rowSize));
  const Reals<Real> toEnd =
    hn::Sub(hn::Min(high, gather<Real>(table.places(), hn::Add(lowRow, hn::Set(di, 1)))), low);
  const Reals<Real> inHigh = hn::Sub(high, gather<Real>(table.places(), highRow));
  const Reals<Real> perPlace =
    hn::Div(hn::Set(d, Real(1)), hn::IfThenElse(narrow, hn::Sub(high, low), hn::Set(d, Real(1))));
  for (int c = 0; c < 4; ++c)
  {
    const Reals<Real> ofLow = hn::IfThenElse(rises, a.term[c], b.term[c]);
    const Reals<Real> ofHigh = hn::IfThenElse(rises, b.term[c], a.term[c]);
    const Reals<Real> inLow = mulAdd(hn::Mul(toEnd, half<Real>()), gather<Real>(rows.slope + c, from), ofLow);
    const Reals<Real> begin = hn::Mul(hn::Add(ofHigh, gather<Real>(rows.own + c, to)), half<Real>());
    const Reals<Real> between =
      hn::Add(hn::Sub(gather<Real>(rows.sum + c, to), gather<Real>(rows.sum + c, next)),
        hn::Sub(gather<Real>(rows.rest + c, to), gather<Real>(rows.rest + c, next)));
    const Reals<Real> all = mulAdd(inLow, toEnd, mulAdd(begin, inHigh, between));
    mean[c] = hn::IfThenElse(narrow, hn::Mul(all, perPlace), mean[c]);
  }
}

/// The same where rows may differ. integral: of what lies between; least: rises whose integrals have digits.
template <class Real>
HWY_INLINE void meanByIntegral(const IntegralTable& table, const Places<Real>& a, const Places<Real>& b,
  const Reals<Real> (&integral)[4], Reals<Real> least, Reals<Real> (&mean)[4])
{
  const RealTag<Real> d;
  const Reals<Real> rise = hn::Sub(b.at, a.at);
  const Mask<Real> crosses = hn::Ne(a.row, b.row);
  const Mask<Real> isWide = hn::And(crosses, hn::Gt(hn::Abs(rise), least));
  const Reals<Real> perPlace =
    hn::Div(hn::Set(d, Real(1)), hn::IfThenElse(isWide, rise, hn::Set(d, Real(1))));
  for (int c = 0; c < 4; ++c)
  {
    mean[c] = hn::IfThenElse(isWide, hn::Mul(integral[c], perPlace), mean[c]);
  }
  const Mask<Real> isNarrow = hn::AndNot(isWide, crosses);
  if (!hn::AllFalse(d, isNarrow))
  {
    meanOfNarrow<Real>(table, a, b, isNarrow, mean);
  }
  mean[3] = hn::ZeroIfNegative(mean[3]); // rounding
}

template <class Real>
constexpr Real narrowest = std::is_same_v<Real, float> ? 0x1p-12 : 0x1p-24;

template <class Real>
HWY_INLINE void meanByIntegrals(const IntegralTable& table, const Places<Real>& a, const Sums<Real>& sumsOfA,
  const Places<Real>& b, const Sums<Real>& sumsOfB, Reals<Real> (&mean)[4])
{
  Reals<Real> integral[4];
  for (int c = 0; c < 4; ++c)
  {
    integral[c] = hn::Add(hn::Sub(sumsOfB.sum[c], sumsOfA.sum[c]), hn::Sub(sumsOfB.rest[c], sumsOfA.rest[c]));
  }
  const Reals<Real> least = hn::Mul(hn::Max(a.inRow, b.inRow), hn::Set(RealTag<Real>(), narrowest<Real>));
  meanByIntegral<Real>(table, a, b, integral, least, mean);
}

/// The third from the first two.
template <class Real>
HWY_INLINE void meanOfHalves(const IntegralTable& table, const Places<Real>& begin,
  const Places<Real>& middle, const Places<Real>& end, Reals<Real> (&mean)[3][4])
{
  const Reals<Real> first = hn::Sub(middle.at, begin.at);
  const Reals<Real> second = hn::Sub(end.at, middle.at);
  Reals<Real> integral[4];
  for (int c = 0; c < 4; ++c)
  {
    integral[c] = mulAdd(first, mean[0][c], hn::Mul(second, mean[1][c]));
  }
  const Reals<Real> least =
    hn::Mul(hn::Max(hn::Abs(first), hn::Abs(second)), hn::Set(RealTag<Real>(), narrowest<Real>));
  meanByIntegral<Real>(table, begin, end, integral, least, mean[2]);
}

/// Light that a step adds: red, green, blue, and what it holds back of the light.
template <class Real>
struct Emission
{
  Reals<Real> term[4];
};

/// transmittance: before the step. depth: of a unit of the mean's extinction, in binary orders of magnitude.
template <class Real>
HWY_INLINE Emission<Real> emission(const Reals<Real> (&mean)[4], Reals<Real> depth, Reals<Real> transmittance)
{
  const RealTag<Real> d;
  const Reals<Real> weight = hn::Mul(transmittance, heldBack(hn::Neg(hn::Mul(mean[3], depth))));
  // None where there is no extinction.
  const Reals<Real> perExtinction =
    hn::IfThenElseZero(hn::Gt(mean[3], hn::Zero(d)), hn::Div(weight, mean[3]));
  return { { hn::Mul(perExtinction, mean[0]), hn::Mul(perExtinction, mean[1]),
    hn::Mul(perExtinction, mean[2]), weight } };
}

/// How far colours have changed up to a place.
template <class Real>
HWY_INLINE Reals<Real> colorChange(const IntegralTable& table, const Places<Real>& places)
{
  const RealTag<Real> d;
  const Ints<Real> group = hn::ShiftRightSame(truncated<Real>(places.row), table.sharing());
  const float* const changes = &table.colorChanges()[0].before;
  const Ints<Real> index = hn::Add(group, group);
  // Nothing changes beyond the table, with which rows beside it may share.
  const Reals<Real> inTable =
    hn::Min(hn::Max(places.at, hn::Set(d, Real(table.index().first))), hn::Set(d, Real(table.index().last)));
  const Reals<Real> begin = gather<Real>(table.places(), hn::ShiftLeftSame(group, table.sharing()));
  return mulAdd(gather<Real>(changes + 1, index), hn::Sub(inTable, begin), gather<Real>(changes, index));
}

/// Where in a step the field turns beyond all rows of three of its places, so that none of them tells what the function
/// does there: the first such part of the way, or 1, as where it is not asked for. In an octant the field is a cubic,
/// known from four places: at both ends, in the middle and at a quarter of the way.
template <class Real>
HWY_INLINE Reals<Real> turningPoint(const IntegralTable& table, const Places<Real>& begin,
  Reals<Real> quarter, const Places<Real>& middle, const Places<Real>& end, Mask<Real> asked)
{
  const RealTag<Real> d;
  const Reals<Real> one = hn::Set(d, Real(1));
  const CubicPiece<Real> piece(begin.at, quarter, middle.at, end.at);
  const typename CubicPiece<Real>::Turns turns = piece.turns();
  Reals<Real> first = one;
  for (const Reals<Real> root : turns.at)
  {
    // Of the ends themselves nothing new is known. NaN is no place.
    constexpr Real least = 0.01;
    const Mask<Real> isInside = hn::And(hn::And(asked, turns.areReal),
      hn::And(hn::Gt(root, hn::Set(d, least)), hn::Lt(root, hn::Set(d, 1 - least))));
    if (hn::AllFalse(d, isInside))
    {
      continue;
    }
    const Reals<Real> u = hn::IfThenElseZero(isInside, root);
    const Reals<Real> turn = piece(u);
    const Reals<Real> row = findRows<Real>(table, turn);
    const Mask<Real> isBeyond = hn::Or(hn::Lt(row, hn::Min(hn::Min(begin.row, middle.row), end.row)),
      hn::Gt(row, hn::Max(hn::Max(begin.row, middle.row), end.row)));
    first = hn::IfThenElse(hn::And(isInside, isBeyond), hn::Min(first, u), first);
  }
  return first;
}

/// The light of a step's halves and of its whole: that of its middle, unless nothing is seen there.
template <class Real, class Lighting>
HWY_INLINE void lightMeans(const IntegralTable& table, const Lighting& lighting, const Span<Real>& span,
  Reals<Real> middle, const Lattice<Real>& lattice, Reals<Real> (&mean)[3][4])
{
  const RealTag<Real> d;
  if (hn::AllFalse(d, hn::Gt(hn::Max(mean[0][3], mean[1][3]), hn::Zero(d))))
  {
    return;
  }
  const Reals<Real> extinction =
    hn::Mul(mean[2][3], hn::Set(d, static_cast<Real>(std::numbers::log2e * table.unscale())));
  // Tables of two values have no integrals: no place is asked for.
  const auto effect =
    lighting.at(locate(span, middle, lattice), hn::Mul(middle, span.step), hn::Zero(d), extinction);
  for (auto& terms : mean)
  {
    Reals<Real> color[3] = { terms[0], terms[1], terms[2] };
    lighting.shade(effect, terms[3], color);
    for (int c = 0; c < 3; ++c)
    {
      terms[c] = hn::Mul(color[c], effect.opacity);
    }
    terms[3] = hn::Mul(terms[3], effect.opacity);
  }
}

/// Of steps.
template <class Real>
struct IntegralLimits
{
  Real tolerance; // of what a step adds
  Real leastTransmittance;
};

/// A place that rays have come to. The sums are made where a step leaves its row, and kept for the next.
template <class Real>
struct Reached
{
  Places<Real> places;
  Sums<Real> sums;
  bool hasSums = false;

  HWY_INLINE void moveTo(
    const Places<Real>& after, const Sums<Real>& sumsAfter, bool crossesRows, Mask<Real> taken)
  {
    places.at = hn::IfThenElse(taken, after.at, places.at);
    places.row = hn::IfThenElse(taken, after.row, places.row);
    places.inRow = hn::IfThenElse(taken, after.inRow, places.inRow);
    for (int c = 0; c < 4; ++c)
    {
      places.term[c] = hn::IfThenElse(taken, after.term[c], places.term[c]);
      places.ofRow[c] = hn::IfThenElse(taken, after.ofRow[c], places.ofRow[c]);
    }
    hasSums = crossesRows;
    for (int c = 0; c < 4 && crossesRows; ++c)
    {
      sums.sum[c] = hn::IfThenElse(taken, sumsAfter.sum[c], sums.sum[c]);
      sums.rest[c] = hn::IfThenElse(taken, sumsAfter.rest[c], sums.rest[c]);
    }
  }
};

/// The means of both halves of a step, and of the whole; whether it leaves its row.
template <class Real>
HWY_INLINE bool meansOfStep(const IntegralTable& table, Reached<Real>& before, const Places<Real>& middle,
  const Places<Real>& after, Sums<Real>& sumsAfter, Reals<Real> (&mean)[3][4])
{
  meanByEnds(before.places, middle, mean[0]);
  meanByEnds(middle, after, mean[1]);
  meanByEnds(before.places, after, mean[2]);
  if (hn::AllTrue(
        RealTag<Real>(), hn::And(hn::Eq(before.places.row, middle.row), hn::Eq(middle.row, after.row))))
  {
    return false;
  }
  if (!before.hasSums)
  {
    before.sums = findSums(table, before.places);
  }
  const Sums<Real> sumsInMiddle = findSums(table, middle);
  sumsAfter = findSums(table, after);
  meanByIntegrals<Real>(table, before.places, before.sums, middle, sumsInMiddle, mean[0]);
  meanByIntegrals<Real>(table, middle, sumsInMiddle, after, sumsAfter, mean[1]);
  meanOfHalves<Real>(table, before.places, middle, after, mean);
  return true;
}

/// What holds much light back shows its front: where its colours differ, halves may agree by chance. The larger one of
/// what that may change and another error.
template <class Real>
HWY_INLINE Reals<Real> errorWithFronts(const IntegralTable& table, const Places<Real>& before,
  const Places<Real>& middle, const Places<Real>& after, Reals<Real> first, Reals<Real> second,
  Mask<Real> asked, Reals<Real> error)
{
  const RealTag<Real> d;
  const Mask<Real> isDense = hn::And(asked, hn::Gt(hn::Max(first, second), hn::Set(d, Real(dense))));
  if (hn::AllFalse(d, isDense))
  {
    return error;
  }
  const Reals<Real> inMiddle = colorChange<Real>(table, middle);
  const Reals<Real> front = hn::Mul(first, hn::Abs(hn::Sub(inMiddle, colorChange<Real>(table, before))));
  const Reals<Real> back = hn::Mul(second, hn::Abs(hn::Sub(colorChange<Real>(table, after), inMiddle)));
  return hn::Max(
    error, hn::IfThenElseZero(isDense, hn::Mul(hn::Max(front, back), hn::Set(d, Real(partOfColors)))));
}

/// Of a step that goes far beyond the table little is in it, and three places tell little of that.
template <class Real>
HWY_INLINE Mask<Real> isWide(
  const IntegralTable& table, const Places<Real>& before, const Places<Real>& after)
{
  const RealTag<Real> d;
  const Reals<Real> begin = hn::Set(d, Real(table.index().first));
  const Reals<Real> end = hn::Set(d, Real(table.index().last));
  const Reals<Real> widest = hn::Mul(hn::Set(d, Real(widestStep)), hn::Sub(end, begin));
  const Reals<Real> ahead = hn::Max(before.at, after.at);
  const Reals<Real> behind = hn::Min(before.at, after.at);
  return hn::And(hn::Gt(hn::Sub(ahead, behind), widest), hn::And(hn::Gt(ahead, begin), hn::Lt(behind, end)));
}

/// Takes rays through their samples; how many steps of the vector that took. Lighting: as of takePoints().
template <class Real, class Values, class Lighting>
HWY_INLINE std::uint64_t takeIntegrals(const IntegralTable& table, const Span<Real>& span,
  const IntegralLimits<Real>& limits, const Values& values, const ToTable<Real>& toTable,
  const Lattice<Real>& lattice, const Lighting& lighting, Light<Real>& light)
{
  const RealTag<Real> d;
  const Reals<Real> one = hn::Set(d, Real(1));
  const Reals<Real> depthPerSample =
    hn::Mul(span.depthPerExtinction, hn::Set(d, static_cast<Real>(std::numbers::log2e * table.unscale())));
  const auto placesAt = [&]<int Count>(const Reals<Real>(&parts)[Count], Reals<Real>(&places)[Count]) {
    sample(span, parts, values, toTable, lattice, places);
  };
  Reals<Real> at = hn::Zero(d); // in samples
  Reals<Real> wanted = one;     // size of the next step
  Reals<Real> start[1];
  const Reals<Real> starts[1] = { at };
  placesAt(starts, start);
  Reached<Real> before;
  before.places = findPlaces<Real>(table, start[0]);
  Sums<Real> sumsAfter;
  const ToFaces<Real> toFaces(span);
  for (std::uint64_t steps = 0;; ++steps)
  {
    const Mask<Real> active =
      hn::And(hn::Lt(at, span.samples), hn::Gt(light.transmittance, hn::Set(d, limits.leastTransmittance)));
    if (hn::AllFalse(d, active))
    {
      return steps;
    }
    const Reals<Real> size = hn::Min(hn::Min(wanted, toFaces(at)), hn::Sub(span.samples, at));
    const Reals<Real> halfSize = hn::Mul(size, half<Real>());
    const Reals<Real> ends[2] = { hn::Add(at, halfSize), hn::Add(at, size) };
    Reals<Real> position[2];
    placesAt(ends, position);
    const Places<Real> middle = findPlaces<Real>(table, position[0]);
    const Places<Real> after = findPlaces<Real>(table, position[1]);
    Reals<Real> mean[3][4];
    const bool crossesRows = meansOfStep(table, before, middle, after, sumsAfter, mean);
    if constexpr (Lighting::isLit)
    {
      lightMeans(table, lighting, span, ends[0], lattice, mean);
    }
    const Reals<Real> halfDepth = hn::Mul(halfSize, depthPerSample);
    const Emission<Real> first = emission<Real>(mean[0], halfDepth, light.transmittance);
    const Emission<Real> second =
      emission<Real>(mean[1], halfDepth, hn::Sub(light.transmittance, first.term[3]));
    const Emission<Real> whole = emission<Real>(mean[2], hn::Mul(size, depthPerSample), light.transmittance);
    Reals<Real> both[4];
    Reals<Real> error = hn::Zero(d);
    for (int c = 0; c < 4; ++c)
    {
      both[c] = hn::Add(first.term[c], second.term[c]);
      error = hn::Max(error, hn::Abs(hn::Sub(both[c], whole.term[c])));
    }
    error = errorWithFronts<Real>(
      table, before.places, middle, after, first.term[3], second.term[3], active, error);
    // A little of what would be much where the field is flat: halves show more and more of it.
    const Reals<Real> least =
      hn::Max(hn::Mul(both[3], half<Real>()), hn::Set(d, limits.tolerance * Real(0x1p-10)));
    const Mask<Real> grows = hn::Gt(hn::Sub(both[3], whole.term[3]), least);
    const Mask<Real> agrees = hn::And(active,
      hn::AndNot(hn::Or(grows, isWide<Real>(table, before.places, after)),
        hn::Le(error, hn::Set(d, limits.tolerance))));
    Reals<Real> turn = one;
    if (!hn::AllFalse(d, agrees))
    {
      const Reals<Real> quarters[1] = { mulAdd(size, hn::Set(d, Real(0.25)), at) };
      Reals<Real> quarter[1];
      placesAt(quarters, quarter);
      turn = turningPoint<Real>(table, before.places, quarter[0], middle, after, agrees);
    }
    const Mask<Real> goesOn = hn::Eq(turn, one);
    // Shorter steps would not lead anywhere: a place far along the way has no digits for them.
    const Reals<Real> shortest =
      hn::Max(hn::Set(d, Real(shortestStep)), hn::Mul(at, hn::Set(d, Real(0x1p-20))));
    const Mask<Real> isFine = hn::Or(hn::And(goesOn, agrees), hn::Le(size, shortest));
    const Mask<Real> taken = hn::And(active, isFine);
    light.add(both, taken);
    before.moveTo(after, sumsAfter, crossesRows, taken);
    at = hn::IfThenElse(taken, ends[1], at);
    const Reals<Real> shorter = hn::Max(hn::IfThenElse(goesOn, halfSize, hn::Mul(turn, size)), shortest);
    wanted = hn::IfThenElse(isFine, hn::Min(hn::Add(wanted, wanted), one), shorter);
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif

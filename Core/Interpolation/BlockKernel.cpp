#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Interpolation/BlockKernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Interpolation/BlockKernel.h"

#include <hwy/highway.h>

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

using DoubleTag = hn::CappedTag<double, 8>;
using FloatTag = hn::CappedTag<float, 16>;
using HalfTag = hn::Rebind<float, DoubleTag>;
using Doubles = hn::Vec<DoubleTag>;
using Floats = hn::Vec<FloatTag>;

constexpr int doubles = hn::MaxLanes(DoubleTag());
constexpr int floats = hn::MaxLanes(FloatTag());
constexpr int valueCount = block::vertexCount;
/// Where a row of five takes this room, no vector crosses from one row into the next.
constexpr int rowRoom = 8;

/// Each of the vertices between and in the middle of four cells is the mean of two, if of the same one twice.
alignas(64) constexpr std::int64_t firstCell[rowRoom] = { 0, 1, 1, 2, 2, 0, 0, 0 };
alignas(64) constexpr std::int64_t secondCell[rowRoom] = { 1, 1, 2, 2, 3, 0, 0, 0 };

HWY_INLINE Doubles mean(Doubles a, Doubles b)
{
  return hn::Mul(hn::Set(DoubleTag(), 0.5), hn::Add(a, b));
}

/// Along x.
HWY_INLINE void expandRow(const double* cells, double* vertices)
{
  if constexpr (doubles >= 4)
  {
    const DoubleTag d;
    const Doubles row = hn::LoadU(d, cells);
    for (int x = 0; x < rowRoom; x += doubles)
    {
      const Doubles first = hn::TableLookupLanes(row, hn::SetTableIndices(d, firstCell + x));
      const Doubles second = hn::TableLookupLanes(row, hn::SetTableIndices(d, secondCell + x));
      hn::Store(mean(first, second), d, vertices + x);
    }
  }
  else
  {
    for (int x = 0; x < rowRoom; ++x)
    {
      vertices[x] = 0.5 * (cells[firstCell[x]] + cells[secondCell[x]]);
    }
  }
}

void MeansBetween(const double* places, double* values)
{
  const DoubleTag d;
  HWY_ALIGN double x[4][4][rowRoom]; // z, y
  HWY_ALIGN double xy[4][5][rowRoom];
  for (int row = 0; row < 16; ++row)
  {
    expandRow(places + 4 * row, x[row >> 2][row & 3]);
  }
  for (int z = 0; z < 4; ++z)
  {
    for (int y = 0; y < 5; ++y)
    {
      for (int i = 0; i < rowRoom; i += doubles)
      {
        hn::Store(
          mean(hn::Load(d, x[z][firstCell[y]] + i), hn::Load(d, x[z][secondCell[y]] + i)), d, xy[z][y] + i);
      }
    }
  }
  // In their order: what a row's vectors write beyond it the next one overwrites.
  for (int z = 0; z < 5; ++z)
  {
    for (int y = 0; y < 5; ++y)
    {
      for (int i = 0; i < rowRoom; i += doubles)
      {
        hn::StoreU(mean(hn::Load(d, xy[firstCell[z]][y] + i), hn::Load(d, xy[secondCell[z]][y] + i)), d,
          values + 25 * z + 5 * y + i);
      }
    }
  }
}

/// Calls f(begin) for vectors of so many lanes that cover all values; the last overlaps the one before.
template <int Lanes, class F>
HWY_INLINE void forEachVector(const F& f)
{
  for (int i = 0; i + Lanes <= valueCount; i += Lanes)
  {
    f(i);
  }
  f(valueCount - Lanes);
}

Range Hull(const float* values)
{
  const FloatTag d;
  Floats low = hn::LoadU(d, values);
  Floats high = low;
  forEachVector<floats>([&](int i) {
    const Floats v = hn::LoadU(d, values + i);
    low = hn::Min(low, v);
    high = hn::Max(high, v);
  });
  return { hn::GetLane(hn::MinOfLanes(d, low)), hn::GetLane(hn::MaxOfLanes(d, high)) };
}

Range RoundValues(const double* values, float* rounded)
{
  const DoubleTag d;
  const HalfTag half;
  hn::Vec<HalfTag> low = hn::DemoteTo(half, hn::LoadU(d, values));
  hn::Vec<HalfTag> high = low;
  forEachVector<doubles>([&](int i) {
    const auto v = hn::DemoteTo(half, hn::LoadU(d, values + i));
    hn::StoreU(v, half, rounded + i);
    low = hn::Min(low, v);
    high = hn::Max(high, v);
  });
  return { hn::GetLane(hn::MinOfLanes(half, low)), hn::GetLane(hn::MaxOfLanes(half, high)) };
}

void Quantise(const float* values, Range hull, float last, std::uint16_t* steps)
{
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const hn::Rebind<std::uint16_t, FloatTag> to;
  const float width = hull.max - hull.min;
  // In two factors, of which only a denormal hull's has no number; infinity would make NaN of a difference of zero.
  const Floats perWidth =
    hn::Set(d, width > 0.f ? std::min(1.f / width, std::numeric_limits<float>::max()) : 0.f);
  const Floats min = hn::Set(d, hull.min);
  forEachVector<floats>([&](int i) {
    const Floats part = hn::Mul(hn::Sub(hn::LoadU(d, values + i), min), perWidth);
    const Floats step = hn::Add(hn::Mul(part, hn::Set(d, last)), hn::Set(d, 0.5f));
    hn::StoreU(hn::DemoteTo(to, hn::ConvertTo(di, hn::Min(step, hn::Set(d, last)))), to, steps + i);
  });
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(MeansBetween);
HWY_EXPORT(RoundValues);
HWY_EXPORT(Hull);
HWY_EXPORT(Quantise);

void meansBetween(const std::array<double, 72>& places, std::array<double, 128>& values) noexcept
{
  HWY_DYNAMIC_DISPATCH(MeansBetween)(places.data(), values.data());
}

Range roundValues(
  const std::array<double, 128>& values, std::array<float, block::vertexCount>& rounded) noexcept
{
  return HWY_DYNAMIC_DISPATCH(RoundValues)(values.data(), rounded.data());
}

Range hull(const std::array<float, block::vertexCount>& values) noexcept
{
  return HWY_DYNAMIC_DISPATCH(Hull)(values.data());
}

void quantise(const std::array<float, block::vertexCount>& values, Range hull, float last,
  std::array<std::uint16_t, 128>& steps) noexcept
{
  std::fill(steps.begin() + block::vertexCount, steps.end(), std::uint16_t(0));
  HWY_DYNAMIC_DISPATCH(Quantise)(values.data(), hull, last, steps.data());
}

} // namespace treeamr
#endif

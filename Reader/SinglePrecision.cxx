#include "SinglePrecision.h"

#include "HyperTreeGridSource.h"
#include "HyperTreeGridTopology.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <vector>

namespace treeamr
{

namespace
{

/// Places of the floats in their order, one after the other; both zeros have the same.
std::int64_t placeOf(float value)
{
  const auto bits = std::bit_cast<std::int32_t>(value);
  return bits >= 0 ? bits : std::int64_t(std::numeric_limits<std::int32_t>::min()) - bits;
}

} // namespace

Remark roundedIntegers(vtkDataArray& array)
{
  constexpr double exact = 1 << std::numeric_limits<float>::digits;
  const int type = array.GetDataType();
  if (type == VTK_FLOAT || type == VTK_DOUBLE || array.GetDataTypeSize() < 4)
  {
    return {};
  }
  double largest = 0.;
  for (int c = 0; c < array.GetNumberOfComponents(); ++c)
  {
    const double* range = array.GetRange(c);
    largest = std::max({ largest, std::abs(range[0]), std::abs(range[1]) });
  }
  if (array.GetNumberOfTuples() == 0 || largest <= exact)
  {
    return {};
  }
  const std::string about =
    "hyper tree grid: cell array '" + std::string(array.GetName()) + "' has whole numbers";
  return { about,
    about + " up to " + std::to_string(static_cast<long long>(std::min(largest, 9e18))) +
      "; single precision rounds those beyond " + std::to_string(static_cast<int>(exact)) };
}

Remark mergedDoubles(vtkHyperTreeGrid* grid, const ArraySelection& selection, const Field& field)
{
  constexpr std::int64_t enough = 1024;
  const std::int64_t first = placeOf(field.range().min);
  const std::int64_t steps = placeOf(field.range().max) - first;
  if (steps >= enough || numericCellArray(*grid, selection.name).GetDataType() != VTK_DOUBLE)
  {
    return {};
  }
  const HyperTreeGridTopology topology(grid);
  const CellValues values(*grid, selection, topology.globalIndexEnd());
  // Of each float one of the doubles that it stands for.
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::atomic<double>> seen(static_cast<std::size_t>(steps) + 1);
  std::ranges::for_each(seen, [](std::atomic<double>& value) { value = none; });
  std::atomic<bool> merged{ false };
  struct Extremes
  {
    double min = std::numeric_limits<double>::infinity();
    double max = -std::numeric_limits<double>::infinity();
  };
  tbb::enumerable_thread_specific<Extremes> extremes;
  topology.forEachLeaf([&](vtkIdType index) {
    const double value = values(index);
    if (!values.isFinite(index))
    {
      return;
    }
    Extremes& own = extremes.local();
    own = { std::min(own.min, value), std::max(own.max, value) };
    const std::int64_t place = placeOf(static_cast<float>(value)) - first;
    if (place < 0 || place > steps)
    {
      return; // below the grid's depth limit
    }
    std::atomic<double>& other = seen[static_cast<std::size_t>(place)];
    double known = other.load(std::memory_order_relaxed);
    if (std::isnan(known))
    {
      other.compare_exchange_strong(known, value, std::memory_order_relaxed);
      known = other.load(std::memory_order_relaxed);
    }
    if (known != value)
    {
      merged.store(true, std::memory_order_relaxed);
    }
  });
  if (!merged)
  {
    return {};
  }
  Extremes all;
  extremes.combine_each([&](const Extremes& part) {
    all = { std::min(all.min, part.min), std::max(all.max, part.max) };
  });
  const auto left = std::ranges::count_if(seen, [](const auto& value) { return !std::isnan(value); });
  const std::string about = "hyper tree grid: the values of cell array '" + selection.name + "'";
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::max_digits10);
  text << about << " are from " << all.min << " to " << all.max << "; single precision has " << left
       << (left == 1 ? " number" : " different numbers") << " for them all: subtract a constant from them";
  return { about, text.str() };
}

} // namespace treeamr

#include "LostDigits.h"

#include "vtkDataArray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace treeamr
{

namespace
{

double largestOf(Range range, double offset)
{
  return std::max(std::abs(offset + range.min), std::abs(offset + range.max));
}

/// Of an array's finite values; masked cells' count, too.
Remark valuesBeyondFloats(vtkDataArray& array)
{
  constexpr double most = std::numeric_limits<float>::max();
  for (int c = 0; array.GetDataType() == VTK_DOUBLE && c < array.GetNumberOfComponents(); ++c)
  {
    double range[2];
    array.GetFiniteRange(range, c);
    // Of nothing finite the range is inside out.
    if (range[0] <= range[1] && std::max(-range[0], range[1]) > most)
    {
      const std::string about =
        "hyper tree grid: cell array '" + std::string(array.GetName()) + "' has values";
      std::ostringstream text;
      text << about << " from " << range[0] << " to " << range[1] << "; allowed are those up to " << most
           << ", cells of others are missing: multiply them by a constant";
      return { about, text.str() };
    }
  }
  return {};
}

} // namespace

Remark roundedIntegers(vtkDataArray& array, const Field& field)
{
  constexpr double exact = 1 << std::numeric_limits<float>::digits;
  const int type = array.GetDataType();
  if (type == VTK_FLOAT || type == VTK_DOUBLE || array.GetDataTypeSize() < 4 ||
    (field.offset() != 0. && largestOf(field.range(), 0.) <= exact))
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
  if (field.offset() != 0.)
  {
    std::ostringstream text;
    text << about << " that differ by up to " << static_cast<double>(field.range().max) - field.range().min
         << "; single precision rounds them to a " << static_cast<int>(exact) << "th of that";
    return { about, text.str() };
  }
  return { about,
    about + " up to " + std::to_string(static_cast<long long>(std::min(largest, 9e18))) +
      "; single precision rounds those beyond " + std::to_string(static_cast<int>(exact)) };
}

Remark unsuitableRange(vtkDataArray& array, const Field& field)
{
  const Remark beyond = valuesBeyondFloats(array);
  if (!beyond.text.empty())
  {
    return beyond;
  }
  constexpr double enough = 0x1p19; // of steps, each of which may be half a step wrong
  const double range = static_cast<double>(field.range().max) - field.range().min;
  const double largest = largestOf(field.range(), field.offset());
  const double step =
    std::max<double>(std::nextafter(largest, std::numeric_limits<double>::infinity()) - largest,
      std::numeric_limits<float>::denorm_min());
  if (array.GetDataType() == VTK_FLOAT || range == 0. || range >= enough * step)
  {
    return {};
  }
  const std::string about =
    "hyper tree grid: the values of cell array '" + std::string(array.GetName()) + "'";
  std::ostringstream text;
  text << about << " differ by " << range << " at most, all around ";
  text.precision(std::numeric_limits<double>::max_digits10);
  text << field.offset() + field.range().min << "; ";
  text.precision(6);
  text << "the numbers that isovalues, colours and results count in are " << step
       << " apart there: subtract a constant from the values, or multiply them if they are tiny";
  return { about, text.str() };
}

} // namespace treeamr

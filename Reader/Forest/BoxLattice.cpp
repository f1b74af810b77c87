#include "Forest/BoxLattice.h"

#include "Error.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <sstream>
#include <string>

namespace treeamr
{

namespace
{

constexpr double partOfWidth = 1. / 64.;
constexpr double mostOfWidth = 1. / 4.;
constexpr double sixDigits = 1e-5;
constexpr double roundings = 8.;

/// log2 of a normal ratio above 0, to the nearest.
int nearestLog2(double ratio) noexcept
{
  return static_cast<int>(std::bit_cast<std::uint64_t>(ratio * std::numbers::sqrt2) >> 52) - 1023;
}

/// Whether the corners are the eight of a box between two planes along each axis, with slack. Written for vectors: nothing
/// depends on the corner before.
bool areCornersOf(const CornerCoordinates& corners, const std::array<std::array<double, 2>, 3>& planes,
  const std::array<double, 3>& slack) noexcept
{
  std::array<std::int64_t, 8> octants{};
  std::array<std::int64_t, 8> off{};
  for (int a = 0; a < 3; ++a)
  {
    const double low = planes[a][0];
    const double high = planes[a][1];
    const double middle = low + (high - low) / 2.;
    for (int p = 0; p < 8; ++p)
    {
      const double x = corners[a][p];
      octants[p] |= x > middle ? std::int64_t(1) << a : 0;
      off[p] |= std::abs(x - (x > middle ? high : low)) <= slack[a] ? 0 : 1;
    }
  }
  std::int64_t seen = 0;
  std::int64_t anyOff = 0;
  for (int p = 0; p < 8; ++p)
  {
    seen |= std::int64_t(1) << octants[p];
    anyOff |= off[p];
  }
  return seen == 0xff && anyOff == 0;
}

} // namespace

std::string textOf(const std::array<double, 3>& values)
{
  std::ostringstream text;
  text.precision(10);
  text << '(' << values[0] << ", " << values[1] << ", " << values[2] << ')';
  return text.str();
}

AxisBox boxAround(const CornerCoordinates& corners) noexcept
{
  AxisBox box;
  for (int a = 0; a < 3; ++a)
  {
    double low = corners[a][0];
    double high = low;
    double sum = 0.; // NaN stays
    for (const double x : corners[a])
    {
      low = x < low ? x : low;
      high = x > high ? x : high;
      sum += x;
    }
    const bool isNumber = sum == sum;
    box.low[a] = isNumber ? low : sum;
    box.high[a] = isNumber ? high : sum;
  }
  return box;
}

CornerCoordinates cornersOf(const AxisBox& box) noexcept
{
  CornerCoordinates corners;
  for (int a = 0; a < 3; ++a)
  {
    for (int corner = 0; corner < 8; ++corner)
    {
      corners[a][corner] = sideOf(corner, a) ? box.high[a] : box.low[a];
    }
  }
  return corners;
}

bool isBox(const CornerCoordinates& corners, const AxisBox& around, double rounding) noexcept
{
  std::array<std::array<double, 2>, 3> planes;
  std::array<double, 3> slack;
  for (int a = 0; a < 3; ++a)
  {
    planes[a] = { around.low[a], around.high[a] };
    const double width = around.width(a);
    const double magnitude = std::max(std::abs(around.low[a]), std::abs(around.high[a]));
    if (!(width > 0.) || !(magnitude <= std::numeric_limits<double>::max()))
    {
      return false;
    }
    slack[a] = std::min(mostOfWidth * width, std::max(partOfWidth * width, roundings * rounding * magnitude));
  }
  return areCornersOf(corners, planes, slack);
}

std::uint64_t BoxSizes::binOf(const AxisBox& box) noexcept
{
  // Exponent and two bits: powers of two, rounded up or down, are of one bin or of the next.
  return std::bit_cast<std::uint64_t>(box.width(0)) >> 50;
}

BoxSizes::Size& BoxSizes::find(std::uint64_t bin, const AxisBox& box)
{
  if (last_ < sizes_.size() && sizes_[last_].bin == bin)
  {
    return sizes_[last_];
  }
  last_ = static_cast<std::size_t>(std::ranges::find(sizes_, bin, &Size::bin) - sizes_.begin());
  if (last_ == sizes_.size())
  {
    sizes_.push_back({ bin, 0, {}, box, box });
  }
  return sizes_[last_];
}

void BoxSizes::add(const AxisBox& box, std::uint64_t count)
{
  Size& size = find(binOf(box), box);
  size.count += count;
  if (box.width(0) > size.width[0])
  {
    size.widest = box;
  }
  for (int a = 0; a < 3; ++a)
  {
    size.width[a] = std::max(size.width[a], box.width(a));
    size.bounds.low[a] = std::min(size.bounds.low[a], box.low[a]);
    size.bounds.high[a] = std::max(size.bounds.high[a], box.high[a]);
  }
}

void BoxSizes::add(const BoxSizes& others)
{
  for (const Size& other : others.sizes_)
  {
    Size& size = find(other.bin, other.bounds);
    size.count += other.count;
    if (other.width[0] > size.width[0])
    {
      size.widest = other.widest;
    }
    for (int a = 0; a < 3; ++a)
    {
      size.width[a] = std::max(size.width[a], other.width[a]);
      size.bounds.low[a] = std::min(size.bounds.low[a], other.bounds.low[a]);
      size.bounds.high[a] = std::max(size.bounds.high[a], other.bounds.high[a]);
    }
  }
}

const BoxSizes::Size& BoxSizes::mostFrequent() const
{
  return *std::ranges::max_element(sizes_, {}, &Size::count);
}

std::array<double, 3> BoxSizes::shiftBy(double rounding) const noexcept
{
  std::array<double, 3> shift{};
  for (const Size& size : sizes_)
  {
    for (int a = 0; a < 3; ++a)
    {
      const double largest = std::max(std::abs(size.bounds.low[a]), std::abs(size.bounds.high[a]));
      shift[a] = std::max(shift[a], roundings * rounding * largest);
    }
  }
  return shift;
}

bool fitsBeside(
  const AxisBox& other, const AxisBox& box, const std::array<double, 3>& shift, double scale) noexcept
{
  const int level = nearestLog2(other.width(0) / box.width(0));
  for (int a = 0; a < 3; ++a)
  {
    const double root = other.width(a) / scale;
    const double width = std::ldexp(root, -level);
    const double centre = box.low[a] + box.width(a) / 2.;
    const double corner = other.low[a] + other.width(a) / 2. - root / 2.;
    const double slack = width / 16. + shift[a] * (1. + std::abs(centre - corner) / root);
    const double index = std::floor((centre - corner) / width);
    if (level < 0 || !(std::abs(centre - corner - (index + 0.5) * width) <= slack) ||
      !(std::abs(box.width(a) - scale * width) <= width / 16. + 2. * shift[a]))
    {
      return false;
    }
  }
  return true;
}

double distanceOfNeighbours(std::vector<double> centres, double width)
{
  tbb::parallel_sort(centres.begin(), centres.end());
  std::vector<double> distances;
  for (std::size_t i = 1; i < centres.size(); ++i)
  {
    if (const double distance = centres[i] - centres[i - 1]; distance > width / 2.)
    {
      distances.push_back(distance);
    }
  }
  if (distances.empty())
  {
    return 0.;
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle;
}

BoxLattice::BoxLattice(const BoxSizes& sizes, double rounding, double scale)
  : rounding_(rounding)
  , scale_(scale)
{
  widest_ = std::ranges::max_element(sizes.sizes(), {}, [](const auto& s) { return s.width[0]; })->widest;
  std::vector<int> levels;
  for (const BoxSizes::Size& size : sizes.sizes())
  {
    levels.push_back(nearestLog2(widest_.width(0) / size.width[0]));
  }
  for (int a = 0; a < 3; ++a)
  {
    fitAxis(sizes, levels, a);
  }
  deepest_ = std::min(*std::ranges::max_element(levels), deepestLevel);
  joinRoots(std::accumulate(sizes.sizes().begin(), sizes.sizes().end(), std::uint64_t(0),
    [](std::uint64_t sum, const BoxSizes::Size& size) { return sum + size.count; }));
  for (int a = 0; a < 3; ++a)
  {
    const double root = (planes_[a].back() - planes_[a].front()) / roots_[a];
    low_[a] = planes_[a].front();
    for (int level = 0; level <= deepestLevel; ++level)
    {
      const double width = std::ldexp(root, -level);
      widths_[a][level] = width;
      slack_[a][level] = std::min(mostOfWidth * width,
        std::max(
          std::min(partOfWidth * width, sixDigits * largest_[a]), roundings * rounding_ * largest_[a]));
    }
  }
}

// From the largest boxes to the smallest, each time in whole widths from what is known already: so the error of a width
// counts once, not as often as the boxes lie side by side.
void BoxLattice::fitAxis(const BoxSizes& sizes, const std::vector<int>& levels, int axis)
{
  AxisBox span; // along the axis alone
  double width = 0.;
  std::int64_t low = 0; // of the span, in boxes of `level` from the largest one that lies lowest
  std::int64_t high = 0;
  int level = 0;
  for (int next = 0; next <= deepestLevel; ++next)
  {
    AxisBox here;
    double hereWidth = 0.;
    for (std::size_t s = 0; s < levels.size(); ++s)
    {
      const BoxSizes::Size& size = sizes.sizes()[s];
      if (levels[s] == next)
      {
        const double margin = size.width[axis] * (1. / scale_ - 1.) / 2.;
        const double l = size.bounds.low[axis] - margin;
        const double h = size.bounds.high[axis] + margin;
        here.low[axis] = hereWidth > 0. ? std::min(here.low[axis], l) : l;
        here.high[axis] = hereWidth > 0. ? std::max(here.high[axis], h) : h;
        hereWidth = std::max(hereWidth, size.width[axis] / scale_);
      }
    }
    if (hereWidth == 0.)
    {
      continue;
    }
    if (next == 0)
    {
      span = here;
      width = hereWidth;
    }
    low <<= next - level;
    high <<= next - level;
    width = std::ldexp(width, level - next);
    level = next;
    const auto stepsBetween = [&](double from, double to) {
      const double steps = (to - from) / width;
      if (!(steps <= std::ldexp(double(maxRoots), next)))
      {
        throw Error(std::string("the cells reach over ") + std::to_string(std::ldexp(steps, -next)) +
          " of the largest of them along " + "xyz"[axis] + ", allowed are " + std::to_string(maxRoots));
      }
      return std::llround(steps);
    };
    if (next == 0)
    {
      high = stepsBetween(span.low[axis], span.high[axis]);
    }
    if (here.low[axis] < span.low[axis] - width / 2.)
    {
      low -= stepsBetween(here.low[axis], span.low[axis]);
      span.low[axis] = here.low[axis];
    }
    if (here.high[axis] > span.high[axis] + width / 2.)
    {
      high += stepsBetween(span.high[axis], here.high[axis]);
      span.high[axis] = here.high[axis];
    }
    width = span.width(axis) / static_cast<double>(high - low);
  }
  largest_[axis] = std::max(std::abs(span.low[axis]), std::abs(span.high[axis]));

  const std::int64_t perRoot = std::int64_t(1) << level;
  const std::int64_t first = low >> level;
  const std::int64_t last = -(-high >> level); // rounded up
  if (last - first > maxRoots)
  {
    throw Error(std::string("the cells reach over ") + std::to_string(last - first) +
      " of the largest of them along " + "xyz"[axis] + ", allowed are " + std::to_string(maxRoots));
  }
  roots_[axis] = static_cast<int>(last - first);
  for (std::int64_t plane = first; plane <= last; ++plane)
  {
    const std::int64_t at = plane * perRoot;
    const double part = static_cast<double>(at - low) / static_cast<double>(high - low);
    planes_[axis].push_back(at == high ? span.high[axis] : span.low[axis] + part * span.width(axis));
  }
}

// Eight roots to one as long as there is an even number along each axis, and for less than that where there would be too
// many trees: one that holds one box costs 400 bytes and some microseconds.
void BoxLattice::joinRoots(std::uint64_t boxes)
{
  const auto isEven = [](int n) { return n % 2 == 0; };
  const auto areMany = [&] {
    const double roots = double(roots_[0]) * roots_[1] * roots_[2];
    return std::min(roots, static_cast<double>(boxes)) > double(manyTrees);
  };
  while (deepest_ < deepestLevel && (std::ranges::all_of(roots_, isEven) || areMany()))
  {
    for (int a = 0; a < 3; ++a)
    {
      std::vector<double>& planes = planes_[a];
      if (!isEven(roots_[a]))
      {
        planes.push_back(2. * planes.back() - planes[planes.size() - 2]);
      }
      roots_[a] = static_cast<int>(planes.size() - 1) / 2;
      for (int i = 0; i <= roots_[a]; ++i)
      {
        planes[i] = planes[2 * i];
      }
      planes.resize(roots_[a] + 1);
    }
    ++joined_;
    ++deepest_;
  }
}

std::array<double, 3> BoxLattice::largestWidths() const noexcept
{
  return { widths_[0][joined_], widths_[1][joined_], widths_[2][joined_] };
}

std::optional<CellId> BoxLattice::place(const CornerCoordinates& corners) const noexcept
{
  constexpr double tooDeep = std::uint64_t(1) << (deepestLevel + 1);
  const AxisBox box = boxAround(corners);
  CellId cell;
  cell.level = -1;
  std::array<std::array<double, 2>, 3> planes; // of the cell, or shrunk ones
  std::array<double, 3> slack;
  for (int a = 0; a < 3; ++a)
  {
    const double ratio = widths_[a][0] * scale_ / box.width(a);
    // The largest boxes are roots or below; NaN compares false.
    if (!(ratio > 0.5) || !(ratio < tooDeep))
    {
      return std::nullopt;
    }
    const int level = std::max(nearestLog2(ratio), 0);
    if (level > deepest_ || (cell.level >= 0 && level != cell.level))
    {
      return std::nullopt;
    }
    cell.level = level;
    const double width = widths_[a][level];
    const double middle = (box.low[a] - low_[a] + (box.high[a] - low_[a])) / 2.;
    const double index = std::floor(middle / width);
    const auto end = static_cast<double>(std::int64_t(roots_[a]) << level);
    if (!(index >= 0.) || !(index < end))
    {
      return std::nullopt;
    }
    cell.index[a] = static_cast<Coord>(index);
    const double margin = width * (1. - scale_) / 2.;
    planes[a] = { low_[a] + index * width + margin, low_[a] + (index + 1.) * width - margin };
    slack[a] = slack_[a][level];
  }
  if (!areCornersOf(corners, planes, slack))
  {
    return std::nullopt;
  }
  return cell;
}

} // namespace treeamr

#include "Volume/Kernel/IntegralTable.h"

#include "Field/Emission.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace treeamr
{

namespace
{

using Entry = TransferFunction::Entry;
using Node = TransferFunction::Node;

/// Binary orders of magnitude of places, and of extinctions when products with places must be floats.
constexpr int largest = 60;
/// Of places that only double lanes read: sums of the terms' integrals are floats.
constexpr int largestInDoubles = 90;
/// Finest steps of which the least is kept, too.
constexpr std::size_t group = 16;
/// Of tables of manyNodes.
constexpr int sharingOfMany = 4;
/// Of what unscale() has left: denser than that nothing is told apart.
const double densest = std::ldexp(1., largest);

EmissionTerms termsOf(const Entry& e, double mostExtinction = densest)
{
  const double extinction = std::min<double>(e.extinction, mostExtinction);
  return { extinction * e.r, extinction * e.g, extinction * e.b, extinction };
}

/// Of colours that are both seen.
double colorChange(const Entry& a, const Entry& b)
{
  return a.extinction > 0.f || b.extinction > 0.f
    ? std::max({ std::abs(b.r - a.r), std::abs(b.g - a.g), std::abs(b.b - a.b) })
    : 0.;
}

/// A function's entries as nodes.
std::vector<Node> entriesAsNodes(const TransferFunction& transferFunction)
{
  const std::vector<Entry>& entries = transferFunction.entries();
  std::vector<Node> nodes;
  if (transferFunction.scale() == 0.)
  {
    return { { transferFunction.min(), entries.front(), entries.front() } };
  }
  nodes.reserve(entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    nodes.push_back(
      { transferFunction.min() + static_cast<double>(i) / transferFunction.scale(), entries[i], entries[i] });
  }
  return nodes;
}

constexpr double mostOfFloats = std::numeric_limits<float>::max() / 4.f;

/// The value, of nodes or nearest to them, where places have most digits.
double referenceOf(const std::vector<Node>& nodes)
{
  return std::clamp(0., nodes.front().value, nodes.back().value);
}

/// Of the node farthest from there, binary.
int magnitudeOf(const std::vector<Node>& nodes)
{
  const double reference = referenceOf(nodes);
  const double farthest = std::max(nodes.back().value - reference, reference - nodes.front().value);
  return farthest > 0. ? std::ilogb(farthest) : 0;
}

float toFloat(double x)
{
  return static_cast<float>(std::clamp(x, -mostOfFloats, mostOfFloats));
}

/// Calls add(part of the way, entry) for what is between two entries, until products of colour and extinction, of which
/// each is a line, are lines themselves: the colour errs by `tolerance` of a channel.
template <class Add>
void divide(const Entry& a, const Entry& b, double tolerance, const Add& add)
{
  const double change = std::max({ std::abs(b.r - a.r), std::abs(b.g - a.g), std::abs(b.b - a.b) });
  const double slope = static_cast<double>(b.extinction) - a.extinction;
  // Over a part h of the way it errs by change |slope| h^2 / 2 of the sum of the extinctions where it begins and ends.
  const double bend = change * std::abs(slope);
  if (!(bend > 2. * tolerance * (static_cast<double>(a.extinction) + b.extinction)))
  {
    return;
  }
  const auto width = [&](double part) {
    const double extinction = a.extinction + part * slope;
    return (tolerance * slope + std::sqrt(tolerance * (tolerance * slope * slope + 4. * bend * extinction))) /
      bend;
  };
  for (double part = width(0.); part < 1.; part += width(part))
  {
    add(part, TransferFunction::between(a, b, static_cast<float>(part)));
  }
}

/// The same into as few lines as may be, where these are moved by shiftOfProducts(): they err by change |slope| h^2 over
/// the square of the sum of both extinctions' roots, so these are at equal distances.
template <class Add>
void divideEvenly(const Entry& a, const Entry& b, double tolerance, const Add& add)
{
  const double change = std::max({ std::abs(b.r - a.r), std::abs(b.g - a.g), std::abs(b.b - a.b) });
  const double first = std::sqrt(a.extinction);
  const double last = std::sqrt(b.extinction);
  const double most = std::abs(shiftOfProducts<double>(change, a.extinction, b.extinction));
  // Rounding may not cut what was made to be one line.
  const double count = std::ceil(std::sqrt(most / tolerance) - 1e-3);
  for (double i = 1.; i < count; ++i)
  {
    const double root = std::lerp(first, last, i / count);
    const double part = (root * root - a.extinction) / (static_cast<double>(b.extinction) - a.extinction);
    add(part, TransferFunction::between(a, b, static_cast<float>(part)));
  }
}

/// Moves both entries' colours, so that a line of products errs to either side alike.
void moveProducts(Entry& a, Entry& b)
{
  const float ofChange = shiftOfProducts(1.f, a.extinction, b.extinction);
  for (float Entry::*color : { &Entry::r, &Entry::g, &Entry::b })
  {
    const float shift = shiftInTables(ofChange * (b.*color - a.*color));
    a.*color += shift;
    b.*color += shift;
  }
}

/// The least of every so many.
std::vector<float> leastOf(const std::vector<float>& values, std::size_t count)
{
  std::vector<float> least((values.size() + count - 1) / count, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    least[i / count] = std::min(least[i / count], values[i]);
  }
  return least;
}

/// The largest float up to x and the smallest from it on.
std::array<float, 2> floatsAround(double x)
{
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr double most = std::numeric_limits<float>::max();
  const auto rounded = static_cast<float>(std::clamp(x, -most, most));
  return { rounded > x && rounded > -most ? std::nextafter(rounded, -infinity) : rounded,
    rounded < x && rounded < most ? std::nextafter(rounded, infinity) : rounded };
}

} // namespace

/// Where the function bends or jumps, at a place that a float has.
struct IntegralTable::Station
{
  float place;
  Entry below;
  Entry above;
};

/// Whether slopes between two are no floats: in the lowest decades of more than fifty.
bool IntegralTable::isSteep(const Station& low, const Station& high)
{
  const double width = static_cast<double>(high.place) - low.place;
  if (width >= densest / mostOfFloats)
  {
    return false;
  }
  const EmissionTerms first = termsOf(low.above);
  const EmissionTerms last = termsOf(high.below);
  double change = 0.;
  for (int c = 0; c < 4; ++c)
  {
    change = std::max(change, std::abs(last[c] - first[c]));
  }
  return change > mostOfFloats * width;
}

bool IntegralTable::needsDoubles(const TransferFunction& transferFunction)
{
  const std::vector<Node>& nodes = transferFunction.nodes();
  const int magnitude = nodes.empty() ? 0 : magnitudeOf(nodes);
  if (magnitude <= largest)
  {
    return false;
  }
  const double reference = referenceOf(nodes);
  const double least = std::ldexp(std::numeric_limits<float>::min(), magnitude - largest);
  const double leastInDoubles = std::ldexp(least, largest - largestInDoubles); // below which neither helps
  return std::any_of(nodes.begin(), nodes.end(), [&](const Node& node) {
    const double distance = std::abs(node.value - reference);
    return distance >= leastInDoubles && distance < least;
  });
}

IntegralTable::IntegralTable(
  const TransferFunction& transferFunction, double unit, double mostExtinction, double smallestLeaf)
{
  const bool hasNodes = !transferFunction.nodes().empty();
  const std::vector<Node> ofEntries = hasNodes ? std::vector<Node>() : entriesAsNodes(transferFunction);
  const std::vector<Node>& nodes = hasNodes ? transferFunction.nodes() : ofEntries;
  reference_ = referenceOf(nodes);
  // Places are values unless floats would leave their range: then as large as may be, so that decades fit below.
  const int magnitude = magnitudeOf(nodes);
  const int most = needsDoubles(transferFunction) ? largestInDoubles : largest;
  // No float is between the nodes of a steeper one, and places of all floats stay finite.
  constexpr int steepest = 800;
  scale_ = magnitude > largest ? std::ldexp(1., most - magnitude)
    : magnitude < -largest     ? std::ldexp(1., std::min(-magnitude, steepest))
                               : 1.;
  unscale_ = std::ldexp(1., std::max(0, std::ilogb(mostExtinction) - largest / 2));
  const double mostInSums = mostExtinction / unscale_;

  isOfMany_ = nodes.size() >= manyNodes;
  sharing_ = isOfMany_ ? sharingOfMany : 0;
  const std::vector<Station> stations = makeStations(transferFunction, nodes, unit);
  const auto makeRowsWithIndex = [&] {
    makeRows(stations, mostInSums);
    const Index linear = indexBy(false);
    Index bits = indexBy(true);
    index_ = bits.halvings < linear.halvings ? std::move(bits) : linear;
  };
  const auto makeSteps = [&] { makeFinestSteps(stations, smallestLeaf); };
  if (isOfMany_)
  {
    tbb::parallel_invoke(makeRowsWithIndex, makeSteps);
  }
  else
  {
    makeRowsWithIndex();
    makeSteps();
  }
  places_.insert(places_.end(), std::size_t(1) << index_.halvings, std::numeric_limits<float>::infinity());
  places_.shrink_to_fit();
}

/// Removes those on lines between others, to so much of a channel to either side.
void IntegralTable::thin(std::vector<Station>& stations, double tolerance)
{
  std::size_t count = 0; // that are kept, at the vector's beginning
  EmissionTerms anchor{};
  std::array<double, 4> least{}; // slopes of lines from the last one kept that pass all since close enough
  std::array<double, 4> most{};
  const auto keep = [&](std::size_t i) {
    stations[count] = stations[i];
    anchor = termsOf(stations[count++].above);
  };
  for (std::size_t i = 0; i < stations.size(); ++i)
  {
    const Station& station = stations[i];
    const EmissionTerms terms = termsOf(station.below);
    bool follows = i > 0;
    if (i > 0)
    {
      const double perWidth = 1. / (static_cast<double>(station.place) - stations[count - 1].place);
      for (int c = 0; c < 4; ++c)
      {
        const double slope = (terms[c] - anchor[c]) * perWidth;
        follows &= slope >= least[c] && slope <= most[c];
      }
    }
    if (i > 0 && !follows && stations[i - 1].place > stations[count - 1].place)
    {
      keep(i - 1);
    }
    if (i == 0 || i + 1 == stations.size() || !(station.below == station.above))
    {
      keep(i);
    }
    const float last = stations[count - 1].place;
    if (last == station.place || !follows)
    {
      least.fill(-std::numeric_limits<double>::infinity());
      most.fill(std::numeric_limits<double>::infinity());
    }
    if (last < station.place)
    {
      const double perWidth = 1. / (static_cast<double>(station.place) - last);
      const double error = tolerance * station.below.extinction * perWidth;
      for (int c = 0; c < 4; ++c)
      {
        const double slope = (terms[c] - anchor[c]) * perWidth;
        least[c] = std::max(least[c], slope - error);
        most[c] = std::min(most[c], slope + error);
      }
    }
  }
  stations.resize(count);
}

/// With stairs where lines are too steep, so that what each begins with is close enough up to the next one.
std::vector<IntegralTable::Station> IntegralTable::withStairs(const std::vector<Station>& stations)
{
  constexpr double perChannel = 2048.;
  std::vector<Station> stairs;
  for (std::size_t i = 0; i < stations.size(); ++i)
  {
    stairs.push_back(stations[i]);
    if (i + 1 == stations.size() || !isSteep(stations[i], stations[i + 1]))
    {
      continue;
    }
    const Entry& a = stations[i].above;
    const Entry& b = stations[i + 1].below;
    const auto [low, high] = std::minmax(a.extinction, b.extinction);
    const double change = std::max(colorChange(a, b), (static_cast<double>(high) - low) / high);
    const double count = std::ceil(perChannel * std::min(change, 1.));
    for (double k = 1.; k < count; ++k)
    {
      const Entry entry = TransferFunction::between(a, b, static_cast<float>(k / count));
      const float place = toFloat(std::lerp<double>(stations[i].place, stations[i + 1].place, k / count));
      if (place > stairs.back().place && place < stations[i + 1].place)
      {
        stairs.push_back({ place, entry, entry });
      }
    }
  }
  return stairs;
}

std::vector<IntegralTable::Station> IntegralTable::makeStations(
  const TransferFunction& transferFunction, const std::vector<Node>& nodes, double unit) const
{
  const double tolerance = isOfMany_ ? colorsOfMany : 1. / 2048.;
  std::vector<Station> stations;
  stations.reserve(2 * nodes.size());
  const double scale = unit / unscale_;
  const auto add = [&](double value, const Entry& below, const Entry& above) {
    Station station{ toFloat(placeOf(value)), below, above };
    for (Entry* entry : { &station.below, &station.above })
    {
      entry->extinction = static_cast<float>(std::min<double>(entry->extinction * scale, densest));
    }
    if (!stations.empty() && station.place <= stations.back().place)
    {
      stations.back().above = station.above;
      return;
    }
    stations.push_back(station);
  };
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    const Node& node = nodes[i];
    const auto [low, high] = floatsAround(node.value);
    // No float is between these two: the function is theirs, wherever it bends or jumps in between.
    constexpr double fine = 0x1p12;
    const double spacing = fine * (static_cast<double>(high) - low);
    const bool isFine = (i > 0 && node.value - nodes[i - 1].value < spacing) ||
      (i + 1 < nodes.size() && nodes[i + 1].value - node.value < spacing);
    if (low != high && isFine)
    {
      add(low, transferFunction.at(low), transferFunction.at(low));
      const auto reached = std::lower_bound(nodes.begin(), nodes.end(), static_cast<double>(high),
        [](const Node& n, double value) { return n.value < value; });
      const bool isNode = reached != nodes.end() && reached->value == high;
      add(high, isNode ? reached->below : transferFunction.at(high), transferFunction.at(high));
    }
    else
    {
      add(high, node.below, node.above);
    }
    if (i + 1 < nodes.size())
    {
      const Node& next = nodes[i + 1];
      const auto addBetween = [&](double part, const Entry& entry) {
        add(std::lerp(node.value, next.value, part), entry, entry);
      };
      if (isOfMany_)
      {
        divideEvenly(node.above, next.below, tolerance, addBetween);
      }
      else
      {
        divide(node.above, next.below, tolerance, addBetween);
      }
    }
  }
  for (std::size_t i = 0; isOfMany_ && i + 1 < stations.size(); ++i)
  {
    moveProducts(stations[i].above, stations[i + 1].below);
  }
  thin(stations, tolerance / (isOfMany_ ? 64. : 4.));
  if (std::adjacent_find(stations.begin(), stations.end(), isSteep) != stations.end())
  {
    return withStairs(stations);
  }
  return stations;
}

void IntegralTable::makeRows(const std::vector<Station>& stations, double mostInSums)
{
  const std::size_t count = stations.size();
  rows_.resize(count + 2); // one more, that lanes may read
  variation_.assign(1, 0.);
  places_.reserve(count + 1);
  places_.push_back(stations.front().place);
  colorChanges_.reserve(count + 1);
  const std::size_t shared = std::size_t(1) << sharing_;
  EmissionTerms sum{};
  double colors = 0.;
  double variation = 0.;
  EmissionTerms own = termsOf(stations.front().below);
  EmissionTerms ownInSums = termsOf(stations.front().below, mostInSums);
  for (std::size_t r = 0; r <= count; ++r)
  {
    const bool isInside = r > 0 && r < count;
    const Entry& begin = r > 0 ? stations[r - 1].above : stations.front().below;
    const Entry& end = isInside ? stations[r].below : begin;
    const Entry& next = r < count ? stations[r].above : end;
    const double width = isInside ? static_cast<double>(stations[r].place) - stations[r - 1].place : 0.;
    const EmissionTerms atEnd = termsOf(end);
    const EmissionTerms endInSums = end.extinction > mostInSums ? termsOf(end, mostInSums) : atEnd;
    const EmissionTerms ofNext = termsOf(next);
    const EmissionTerms nextInSums = next.extinction > mostInSums ? termsOf(next, mostInSums) : ofNext;
    Row& row = rows_[r];
    double change = 0.;
    double jump = 0.;
    for (int c = 0; c < 4; ++c)
    {
      row.own[c] = static_cast<float>(own[c]);
      row.slope[c] = width > 0. ? toFloat((atEnd[c] - own[c]) / width) : 0.f;
      row.sum[c] = static_cast<float>(sum[c]);
      row.rest[c] = static_cast<float>(sum[c] - row.sum[c]);
      sum[c] += 0.5 * (ownInSums[c] + endInSums[c]) * width;
      change = std::max(change, std::abs(endInSums[c] - ownInSums[c]));
      jump = std::max(jump, std::abs(nextInSums[c] - endInSums[c]));
    }
    variation += (change + jump) * unscale_;
    if ((r + 1) % shared == 0 || r == count)
    {
      variation_.push_back(variation);
    }
    own = ofNext;
    ownInSums = nextInSums;
    const double ofRow = colorChange(begin, end);
    colorChanges_.push_back({ static_cast<float>(colors), width > 0. ? toFloat(ofRow / width) : 0.f });
    colors += ofRow + (end.extinction > 0.f && next.extinction > 0.f ? colorChange(end, next) : 0.);
    if (r > 0)
    {
      places_.push_back(stations[r - 1].place);
    }
  }
  shareColorChanges();
}

void IntegralTable::shareColorChanges()
{
  if (sharing_ == 0)
  {
    return;
  }
  const std::size_t shared = std::size_t(1) << sharing_;
  std::vector<ColorChange> ofGroups;
  ofGroups.reserve(colorChanges_.size() / shared + 1);
  for (std::size_t r = 0; r < colorChanges_.size(); r += shared)
  {
    const std::size_t end = std::min(r + shared, colorChanges_.size() - 1);
    const double width = static_cast<double>(places_[end]) - places_[r];
    const double change = static_cast<double>(colorChanges_[end].before) - colorChanges_[r].before;
    ofGroups.push_back({ colorChanges_[r].before, width > 0. ? toFloat(change / width) : 0.f });
  }
  colorChanges_ = std::move(ofGroups);
}

std::size_t IntegralTable::bytes() const noexcept
{
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  std::size_t bytes = sizeof(*this) + of(rows_) + of(places_) + of(colorChanges_) + of(variation_) +
    of(finestSteps_) + of(index_.firstRow);
  for (const std::vector<float>& groups : finestOfGroups_)
  {
    bytes += of(groups);
  }
  return bytes;
}

void IntegralTable::makeFinestSteps(const std::vector<Station>& stations, double smallestLeaf)
{
  constexpr double channelSteps = 256.; // rounding errs by half of one
  constexpr double faint = 0.01;        // of extinctions across the domain
  const std::size_t count = stations.size();
  // Of extinctions as a part of them, unless both are so dense that no light passes the smallest leaf.
  const auto change = [&](const Entry& a, const Entry& b) {
    const double low = std::min(a.extinction, b.extinction) * unscale_;
    const double high = std::max(a.extinction, b.extinction) * unscale_;
    return high == 0. ? 0.
                      : std::max<double>({ std::abs(b.r - a.r), std::abs(b.g - a.g), std::abs(b.b - a.b),
                          (high - low) / std::max(high, faint) * std::exp(-low * smallestLeaf) });
  };
  std::vector<float> finest(count + 1, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < count; ++i)
  {
    float& ofRow = finest[i + 1];
    const double inRow = i + 1 < count ? change(stations[i].above, stations[i + 1].below) : 0.;
    if (inRow > 0.)
    {
      ofRow =
        toFloat((static_cast<double>(stations[i + 1].place) - stations[i].place) / (inRow * channelSteps));
    }
    if (change(stations[i].below, stations[i].above) > 1. / channelSteps)
    {
      ofRow = -ofRow;
    }
  }
  finestSteps_ = leastOf(finest, std::size_t(1) << sharing_);
  finestOfGroups_.push_back(leastOf(finestSteps_, group));
  for (std::size_t width = 1; 2 * width <= finestOfGroups_.front().size(); width *= 2)
  {
    const std::vector<float>& half = finestOfGroups_.back();
    std::vector<float> whole(half.size() - width);
    for (std::size_t i = 0; i < whole.size(); ++i)
    {
      whole[i] = std::min(half[i], half[i + width]);
    }
    finestOfGroups_.push_back(std::move(whole));
  }
}

float IntegralTable::finestStep(double firstPlace, double lastPlace) const noexcept
{
  const std::size_t firstRow = rowOf(firstPlace);
  const auto stations = places_.begin() + 1;
  const auto lastRow = std::max(
    firstRow, static_cast<std::size_t>(std::lower_bound(stations, endOfPlaces(), lastPlace) - stations));
  const std::size_t first = firstRow >> sharing_;
  const std::size_t last = lastRow >> sharing_;
  const auto leastFrom = [&](std::size_t from, std::size_t end) {
    const auto begin = finestSteps_.begin();
    return std::accumulate(begin + static_cast<std::ptrdiff_t>(from),
      begin + static_cast<std::ptrdiff_t>(end), std::numeric_limits<float>::infinity(),
      [](float a, float b) { return std::min(a, b); });
  };
  // A jump where the first one begins is before it.
  float least = sharing_ == 0 ? std::abs(finestSteps_[first]) : finestSteps_[first];
  const std::size_t firstGroup = (first + group) / group; // that are whole
  const std::size_t endGroup = (last + 1) / group;
  if (firstGroup < endGroup)
  {
    const std::size_t level = std::bit_width(endGroup - firstGroup) - 1;
    const std::vector<float>& groups = finestOfGroups_[level];
    least = std::min({ least, leastFrom(first + 1, firstGroup * group), groups[firstGroup],
      groups[endGroup - (std::size_t(1) << level)], leastFrom(endGroup * group, last + 1) });
  }
  else
  {
    least = std::min(least, leastFrom(first + 1, last + 1));
  }
  return std::max(least, 0.f);
}

double IntegralTable::meanExtinction(double firstPlace, double lastPlace) const noexcept
{
  struct End
  {
    double own;
    double sum;
  };
  const auto endAt = [this](double place) {
    const std::size_t row = this->rowOf(place);
    const Row& function = rows_[row];
    const double inRow = place - places_[row];
    const double own = function.own[3] + function.slope[3] * inRow;
    return End{ own, static_cast<double>(function.sum[3]) + function.rest[3] + 0.5 * inRow * (function.own[3] + own) };
  };
  const End first = endAt(firstPlace);
  const End last = endAt(lastPlace);
  // Sums of two floats leave their differences fewer digits than places have.
  const double width = lastPlace - firstPlace;
  constexpr double narrowest = 0x1p-24;
  const bool isWide = width > narrowest * std::max(std::abs(firstPlace), std::abs(lastPlace));
  return unscale_ * std::max(isWide ? (last.sum - first.sum) / width : 0.5 * (first.own + last.own), 0.);
}

std::size_t IntegralTable::rowOf(double place) const noexcept
{
  const auto begin = places_.begin() + 1;
  return static_cast<std::size_t>(std::upper_bound(begin, endOfPlaces(), place) - begin);
}

IntegralTable::Index IntegralTable::indexBy(bool bits) const
{
  constexpr std::int32_t cells = 4096;
  const float first = places_[1];
  const float last = places_.back();
  Index index;
  index.byBits = bits;
  index.first = first;
  index.last = last;
  const auto order = [](float place) { return orderedBits(std::bit_cast<std::int32_t>(place)); };
  if (bits)
  {
    const auto width = static_cast<std::uint64_t>(std::int64_t(order(last)) - order(first));
    index.shift = std::max(
      1, static_cast<int>(std::bit_width(width)) - static_cast<int>(std::bit_width(unsigned(cells))) + 1);
    index.firstBits = order(first) >> index.shift;
    index.lastCell = (order(last) >> index.shift) - index.firstBits;
  }
  else
  {
    index.cellsPerPlace = last > first ? static_cast<float>(cells - 1) / (last - first) : 0.f;
    index.lastCell = cells - 1;
  }
  // As the kernel counts them.
  const auto cellOf = [&](float place) {
    const std::int32_t cell = bits ? (order(place) >> index.shift) - index.firstBits
                                   : static_cast<std::int32_t>((place - first) * index.cellsPerPlace);
    return static_cast<std::size_t>(std::min(cell, index.lastCell));
  };
  std::vector<std::int32_t> rows(static_cast<std::size_t>(index.lastCell) + 1, 0); // in each cell
  for (std::size_t r = 1; r + 1 < rows_.size(); ++r)
  {
    ++rows[cellOf(places_[r])];
  }
  index.firstRow.reserve(rows.size());
  std::int32_t before = 0;
  std::int32_t most = 0;
  for (const std::int32_t inCell : rows)
  {
    index.firstRow.push_back(static_cast<float>(before));
    before += inCell;
    most = std::max(most, inCell);
  }
  index.halvings = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(most)));
  return index;
}

} // namespace treeamr

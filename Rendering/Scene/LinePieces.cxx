// A piece is as long as it may be, from where the last one ended on: its ends lie on the curve, and it is moved by half of
// what it errs by to one side. Corners have samples close to both sides, so that samples tell all of the curve.
#include "LinePieces.h"

#include "Field/Emission.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

/// Of a channel, by which a sample may be off the line of its neighbours: a line to it errs by a quarter of that.
constexpr float betweenNeighbours = 1.f / 2048.f;
constexpr float corners = 8e-5f; // what is cut off from them, and rounding
constexpr float tolerance = static_cast<float>(colorsOfMany) - 0.25f * betweenNeighbours - corners;
/// Extinctions less than that are none.
constexpr float nothing = 1e-8f;
constexpr std::size_t gaps = 32; // of samples at first
/// Of a gap between samples: where pieces may end.
constexpr std::size_t steps = 4;

/// The compilers' own vectors.
using Four = float __attribute__((vector_size(16)));

/// From zero on.
struct Span
{
  Four least{};
  Four most{};

  void add(Four value)
  {
    least = value < least ? value : least;
    most = value > most ? value : most;
  }
};

/// -log(1 - opacity), to single precision.
float extinctionOf(double opacity)
{
  const double clear = 1. - opacity;
  // A mantissa around 1 and the power of two, then the series of the area tangent.
  constexpr std::int64_t root = 0x3fe6a09e667f3bcd;
  constexpr int mantissa = 52;
  const auto bits = std::bit_cast<std::int64_t>(clear);
  const std::int64_t power = (bits - root) >> mantissa;
  const auto around1 = std::bit_cast<double>(bits - power * (std::int64_t(1) << mantissa));
  const double z = (1. - around1) / (1. + around1);
  const double square = z * z;
  const double ofMantissa = 2. * z * (1. + square * (1. / 3. + square * (1. / 5. + square * (1. / 7.))));
  return static_cast<float>(ofMantissa - static_cast<double>(power) * 0.6931471805599453);
}

} // namespace

bool LinePieces::canFollow(const ColorCurve& curve, const ColorPart& part)
{
  if (curve.hasJump() || (curve.isLogarithmic() && part.offset + part.end > 2. * (part.offset + part.begin)))
  {
    return false;
  }
  if (!(std::min(part.opacityAtBegin, part.opacityAtEnd) >= 0.) ||
    !(std::max(part.opacityAtBegin, part.opacityAtEnd) < 1.))
  {
    return false;
  }
  constexpr double fewest = 4096.; // floats in it
  const auto largest = static_cast<float>(std::max(std::abs(part.begin), std::abs(part.end)));
  const double spacing =
    static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) - largest;
  return part.end - part.begin > fewest * spacing;
}

const std::vector<LinePiece>& LinePieces::follow(const ColorCurve& curve, const ColorPart& part)
{
  unitDistance_ = part.unitDistance;
  sample(curve, part);
  pieces_.clear();
  const auto valueAt = [&](const Sample& sample) {
    return static_cast<float>(part.begin + sample.place * (part.end - part.begin));
  };
  const std::size_t end = steps * (samples_.size() - 1);
  std::size_t expected = end / 8;
  for (std::size_t first = 0; first < end;)
  {
    Fit fitted;
    const std::size_t last = longest(first, std::min(first + expected, end), fitted);
    expected = last - first;
    const Sample a = at(first);
    const Sample b = at(last);
    pieces_.push_back({ valueAt(a), valueAt(b), entryOf(a, fitted.shift), entryOf(b, fitted.shift) });
    first = last;
  }
  return pieces_;
}

TransferFunction::Entry LinePieces::entryOf(const Sample& sample, const std::array<float, 4>& shift) const
{
  return { sample.color[0] + shift[0], sample.color[1] + shift[1], sample.color[2] + shift[2],
    static_cast<float>(std::min(sample.extinction / unitDistance_, TransferFunction::opaqueExtinction)) };
}

void LinePieces::sample(const ColorCurve& curve, const ColorPart& part)
{
  samples_.clear();
  wanted_.clear();
  for (std::size_t i = 0; i <= gaps; ++i)
  {
    wanted_.push_back(static_cast<float>(i) / gaps);
  }
  // No neighbour tells of what bends beside an end.
  constexpr float beside = 1.f / 128.f;
  wanted_.push_back(beside);
  wanted_.push_back(1.f - beside);
  const double corner = (curve.corner() - part.offset - part.begin) / (part.end - part.begin);
  if (corner > 0. && corner < 1.)
  {
    wanted_.push_back(static_cast<float>(corner));
  }
  wantExtinctions(part);
  std::sort(wanted_.begin() + gaps + 1, wanted_.end());
  std::inplace_merge(wanted_.begin(), wanted_.begin() + gaps + 1, wanted_.end());
  wanted_.erase(std::unique(wanted_.begin(), wanted_.end()), wanted_.end());
  addSamples(curve, part);
  constexpr int rounds = 8;
  for (int round = 0; round < rounds; ++round)
  {
    const bool hasCorners = findCorners(curve, part);
    const bool bends = divideGaps();
    addSamples(curve, part);
    if (!hasCorners && !bends)
    {
      return;
    }
  }
}

/// Wants samples where the light that passes the unit distance is little beside what it is in the next sample.
void LinePieces::wantExtinctions(const ColorPart& part)
{
  const double least = 1. - std::max(part.opacityAtBegin, part.opacityAtEnd);
  const double change = part.opacityAtEnd - part.opacityAtBegin;
  constexpr double ratio = 0.7;
  // From where equal gaps have this ratio on.
  for (double clear = std::abs(change) / (gaps * (1. - ratio)); clear > least; clear *= ratio)
  {
    const double place = (1. - clear - part.opacityAtBegin) / change;
    if (place > 0. && place < 1.)
    {
      wanted_.push_back(static_cast<float>(place));
    }
  }
}

void LinePieces::addSamples(const ColorCurve& curve, const ColorPart& part)
{
  // From the last one on, each to its place.
  std::size_t from = samples_.size();
  std::size_t to = from + wanted_.size();
  samples_.resize(to);
  const double width = part.end - part.begin;
  for (std::size_t left = wanted_.size(); left > 0;)
  {
    const std::size_t count = std::min(ColorCurve::most, left);
    left -= count;
    double values[ColorCurve::most];
    for (std::size_t k = 0; k < count; ++k)
    {
      values[k] = part.offset + (part.begin + wanted_[left + k] * width);
    }
    ColorCurve::Colors colors;
    curve.at(values, count, colors);
    for (std::size_t k = count; k-- > 0;)
    {
      const float place = wanted_[left + k];
      while (from > 0 && samples_[from - 1].place > place)
      {
        samples_[--to] = samples_[--from];
      }
      const double opacity = part.opacityAtBegin + place * (part.opacityAtEnd - part.opacityAtBegin);
      const float extinction = extinctionOf(opacity);
      // The more opaque, the less it is seen: in a quarter of the unit distance as much.
      const float ofItself =
        std::min(extinctionPart_ / std::sqrt(std::sqrt(static_cast<float>(1. - opacity))), 0.25f);
      samples_[--to] = { { colors.channel[0][k], colors.channel[1][k], colors.channel[2][k], 0.f }, place,
        extinction, std::max(ofItself * extinction, nothing), colors.branch[k] };
    }
  }
}

/// Wants samples in the middle of gaps beside samples that are off the line of their neighbours.
bool LinePieces::divideGaps()
{
  wanted_.clear();
  bool wasWanted = false; // in the gap before
  for (std::size_t i = 1; i + 1 < samples_.size(); ++i)
  {
    const Sample& low = samples_[i - 1];
    const Sample& middle = samples_[i];
    const Sample& high = samples_[i + 1];
    const float before = middle.place - low.place;
    const float after = high.place - middle.place;
    const float part = before / (before + after);
    float error = 0.f;
    for (int c = 0; c < 3; ++c)
    {
      error =
        std::max(error, std::abs(low.color[c] + part * (high.color[c] - low.color[c]) - middle.color[c]));
    }
    error = low.branch == middle.branch && middle.branch == high.branch ? error : 0.f;
    // What bends alike is off in a gap as the gap's width squared.
    if (error * before > betweenNeighbours * after && !wasWanted)
    {
      wanted_.push_back(0.5f * (low.place + middle.place));
    }
    wasWanted = error * after > betweenNeighbours * before;
    if (wasWanted)
    {
      wanted_.push_back(0.5f * (middle.place + high.place));
    }
  }
  return !wanted_.empty();
}

/// Adds samples on both sides of corners, close to them; whether there are some.
bool LinePieces::findCorners(const ColorCurve& curve, const ColorPart& part)
{
  constexpr std::size_t parts = 8;
  constexpr int rounds = 3;
  constexpr float narrow = 1.f / 8000.f;
  corners_.clear();
  for (std::size_t i = 0; i + 1 < samples_.size(); ++i)
  {
    const float width = samples_[i + 1].place - samples_[i].place;
    if (samples_[i].branch != samples_[i + 1].branch && width > narrow)
    {
      corners_.push_back({ samples_[i].place, width, samples_[i].branch });
    }
  }
  constexpr std::size_t most = ColorCurve::most / (parts - 1); // at once
  wanted_.clear();
  for (std::size_t begin = 0; begin < corners_.size(); begin += most)
  {
    const std::span<Corner> some =
      std::span(corners_).subspan(begin, std::min(most, corners_.size() - begin));
    for (int round = 0; round < rounds; ++round)
    {
      narrowDown(curve, part, some, parts);
    }
    for (const Corner& corner : some)
    {
      for (const float place : { corner.place, corner.place + corner.width })
      {
        wanted_.push_back(place);
      }
    }
  }
  // Ends that are samples are not wanted twice.
  std::erase_if(wanted_, [this](float place) {
    const auto sample = std::lower_bound(
      samples_.begin(), samples_.end(), place, [](const Sample& s, float value) { return s.place < value; });
    return sample != samples_.end() && sample->place == place;
  });
  wanted_.erase(std::unique(wanted_.begin(), wanted_.end()), wanted_.end());
  addSamples(curve, part);
  return !corners_.empty();
}

/// Makes gaps in which the branch changes so many parts of them.
void LinePieces::narrowDown(
  const ColorCurve& curve, const ColorPart& part, std::span<Corner> corners, std::size_t parts)
{
  const double width = part.end - part.begin;
  double values[ColorCurve::most] = {};
  std::size_t count = 0;
  for (const Corner& corner : corners)
  {
    for (std::size_t k = 1; k < parts; ++k)
    {
      const float place = corner.place + corner.width * (static_cast<float>(k) / static_cast<float>(parts));
      values[count++] = part.offset + (part.begin + place * width);
    }
  }
  ColorCurve::Colors colors;
  curve.at(values, count, colors);
  const std::uint8_t* branch = colors.branch;
  for (Corner& corner : corners)
  {
    const auto* const end = branch + parts - 1;
    const auto* const other = std::find_if(branch, end, [&](std::uint8_t of) { return of != corner.branch; });
    corner.width /= static_cast<float>(parts);
    corner.place += corner.width * static_cast<float>(other - branch);
    branch = end;
  }
}

/// Samples are found between samples, too.
LinePieces::Sample LinePieces::at(std::size_t step) const
{
  const Sample& low = samples_[step / steps];
  if (step % steps == 0)
  {
    return low;
  }
  const Sample& high = samples_[step / steps + 1];
  const float part = static_cast<float>(step % steps) / steps;
  Sample result = low;
  for (int c = 0; c < 4; ++c)
  {
    result.color[c] += part * (high.color[c] - low.color[c]);
  }
  result.place += part * (high.place - low.place);
  result.extinction += part * (high.extinction - low.extinction);
  return result;
}

LinePieces::Fit LinePieces::fit(std::size_t first, std::size_t last) const
{
  const Sample a = at(first);
  const Sample b = at(last);
  Fit result{ false, {} };
  const Four color = std::bit_cast<Four>(a.color);
  const Four change = std::bit_cast<Four>(b.color) - color;
  Four ofTable{};
  for (int c = 0; c < 3; ++c)
  {
    const float ofChannel = change[c];
    ofTable[c] = shiftOfProducts(ofChannel, a.extinction, b.extinction);
    if (!(std::abs(ofTable[c]) <= tolerance))
    {
      return result;
    }
  }
  // How far colours and what products of lines show are off.
  Span lines;
  Span products;
  const float perWidth = 1.f / (b.place - a.place);
  const float slope = b.extinction - a.extinction;
  const float root = std::sqrt(a.extinction);
  const float peak = slope == 0.f ? 0.5f : root / (root + std::sqrt(b.extinction)); // of what products show
  float before = 0.f;
  Four lineBefore{};
  for (std::size_t i = first / steps + 1;; ++i)
  {
    const bool isInside = i * steps < last;
    const Sample& sample = isInside ? samples_[i] : b;
    const float along = isInside ? (sample.place - a.place) * perWidth : 1.f;
    const float extinction = a.extinction + along * slope;
    if (!(std::abs(extinction - sample.extinction) <= sample.error))
    {
      return result;
    }
    const float shown = along * b.extinction / std::max(extinction, std::numeric_limits<float>::min());
    const Four toCurve = color - std::bit_cast<Four>(sample.color);
    const Four line = toCurve + along * change;
    lines.add(line);
    products.add(toCurve + shown * change);
    if (before < peak && peak <= along)
    {
      const float toPeak = (peak - before) / (along - before);
      products.add(lineBefore + toPeak * (line - lineBefore) - 2.f * ofTable);
    }
    if (!isInside)
    {
      break;
    }
    before = along;
    lineBefore = line;
  }
  result.isClose = true;
  for (int c = 0; c < 3; ++c)
  {
    const float moved = shiftInTables(float(ofTable[c]));
    const float from = -tolerance - std::min(lines.least[c], products.least[c] + moved);
    const float to = tolerance - std::max(lines.most[c], products.most[c] + moved);
    result.isClose = result.isClose && from <= to;
    result.shift[c] = 0.5f * (from + to);
  }
  return result;
}

std::size_t LinePieces::longest(std::size_t first, std::size_t expected, Fit& fitted) const
{
  std::size_t close = (first / steps + 1) * steps; // nothing is up to the next sample
  std::size_t far = steps * (samples_.size() - 1) + 1;
  fitted = fit(first, close);
  std::size_t next = std::max(expected, close + 1);
  std::size_t step = steps / 2;
  while (close + 1 < far)
  {
    next = std::clamp(next, close + 1, far - 1);
    const Fit tried = fit(first, next);
    const bool wasOpen = far > steps * (samples_.size() - 1);
    if (tried.isClose)
    {
      fitted = tried;
      close = next;
    }
    else
    {
      far = next;
    }
    // Beside what was expected, farther and farther, until it lies in between.
    const bool isOpen = far > steps * (samples_.size() - 1);
    next = isOpen ? close + step : (close + far) / 2;
    step = isOpen && wasOpen ? 2 * step : step;
  }
  return close;
}

} // namespace treeamr

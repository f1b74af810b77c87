// A piece is as long as it may be, from where the last one ended on: its ends lie on the curve, and it is moved by half of
// what it errs by to one side. Corners have samples close to both sides, so that samples tell all of the curve.
#include "LinePieces.h"

#include "Field/Emission.h"

#include <tbb/parallel_for.h>

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
constexpr std::size_t gaps = 24; // of samples at first
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

/// Of three channels, whatever the sign.
float largestOf(Four color)
{
  return std::max({ std::abs(color[0]), std::abs(color[1]), std::abs(color[2]) });
}

/// -log(clear) of (0, 1], to single precision. Without branches and signed shifts, that loops of it are vectorised.
float extinctionOf(double clear)
{
  // A mantissa around 1 and the power of two, then the series of the area tangent.
  constexpr std::uint64_t root = 0x3fe6a09e667f3bcd;
  constexpr int mantissa = 52;
  constexpr std::uint64_t shift = 2048; // that powers are positive
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(clear) + (shift << mantissa) - root;
  const std::uint64_t power = bits >> mantissa;
  const auto around1 = std::bit_cast<double>((bits & ((std::uint64_t(1) << mantissa) - 1)) + root);
  // An integer as a double's last bits.
  constexpr double whole = 0x1p52;
  const double exponent =
    std::bit_cast<double>(power | std::bit_cast<std::uint64_t>(whole)) - (whole + static_cast<double>(shift));
  const double z = (1. - around1) / (1. + around1);
  const double square = z * z;
  const double ofMantissa = 2. * z * (1. + square * (1. / 3. + square * (1. / 5. + square * (1. / 7.))));
  return static_cast<float>(ofMantissa - exponent * 0.6931471805599453);
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

const std::vector<LinePiece>& LinePieces::follow(const ColorPart& part)
{
  const ColorCurve curve(part.curve, curve_ ? &*curve_ : nullptr);
  curve_ = curve;
  pieces_.clear();
  if (!canFollow(curve, part))
  {
    return pieces_;
  }
  unitDistance_ = part.unitDistance;
  sample(curve, part);
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
  // No neighbour tells of what bends beside an end or a corner.
  constexpr float beside = 1.f / 128.f;
  wanted_.push_back(beside);
  wanted_.push_back(1.f - beside);
  constexpr float nowhere = -1.f;
  corner_ = nowhere;
  const double corner = (curve.corner() - part.offset - part.begin) / (part.end - part.begin);
  if (curve.hasCorner() && corner > 0. && corner < 1.)
  {
    corner_ = static_cast<float>(corner);
    for (const float place : { corner_, corner_ - beside, corner_ + beside })
    {
      if (place > 0.f && place < 1.f)
      {
        wanted_.push_back(place);
      }
    }
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
  const double opacityChange = part.opacityAtEnd - part.opacityAtBegin;
  for (std::size_t left = wanted_.size(); left > 0;)
  {
    const std::size_t count = std::min(ColorCurve::most, left);
    left -= count;
    double values[ColorCurve::most];
    float extinctions[ColorCurve::most];
    float perError[ColorCurve::most];
    for (std::size_t k = 0; k < count; ++k)
    {
      const double place = wanted_[left + k];
      values[k] = part.offset + (part.begin + place * width);
      const double clear = 1. - (part.opacityAtBegin + place * opacityChange);
      extinctions[k] = extinctionOf(clear);
      // The more opaque, the less it is seen: in a quarter of the unit distance as much.
      const float ofItself =
        std::min(extinctionPart_ / std::sqrt(std::sqrt(static_cast<float>(clear))), 0.25f);
      perError[k] = 1.f / std::max(ofItself * extinctions[k], nothing);
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
      samples_[--to] = { { colors.channel[0][k], colors.channel[1][k], colors.channel[2][k], 0.f }, place,
        extinctions[k], perError[k], colors.branch[k] };
    }
  }
}

/// Wants samples in gaps beside samples that are off the line of their neighbours.
bool LinePieces::divideGaps()
{
  const std::size_t count = samples_.size() - 1; // of gaps
  bends_.assign(count + 1, 0.f);
  Four before{}; // the slope in the gap before
  for (std::size_t i = 0; i < count; ++i)
  {
    const Sample& low = samples_[i];
    const Sample& high = samples_[i + 1];
    const Four slope =
      (std::bit_cast<Four>(high.color) - std::bit_cast<Four>(low.color)) / (high.place - low.place);
    if (i > 0 && samples_[i - 1].branch == low.branch && low.branch == high.branch && low.place != corner_)
    {
      bends_[i] = largestOf(slope - before) / (high.place - samples_[i - 1].place);
    }
    before = slope;
  }
  wanted_.clear();
  for (std::size_t i = 0; i < count; ++i)
  {
    // What bends alike is off in a gap as the gap's width squared.
    const float width = samples_[i + 1].place - samples_[i].place;
    const float error = std::max(bends_[i], bends_[i + 1]) * width * width;
    if (error > betweenNeighbours)
    {
      divideGap(i, error);
    }
  }
  return !wanted_.empty();
}

/// Into so many parts that each errs by no more than a line between neighbours may.
void LinePieces::divideGap(std::size_t gap, float error)
{
  constexpr int most = 8;
  constexpr float narrowest = 1.f / 8192.f;
  const float begin = samples_[gap].place;
  const float width = samples_[gap + 1].place - begin;
  // Each errs by the square of its part.
  const auto asked = 1 + static_cast<int>(std::sqrt(error / betweenNeighbours));
  const int parts = std::min({ asked, most, 1 + static_cast<int>(width / narrowest) });
  for (int i = 1; i < parts; ++i)
  {
    wanted_.push_back(begin + width * (static_cast<float>(i) / static_cast<float>(parts)));
  }
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
  const std::int32_t* branch = colors.branch;
  for (Corner& corner : corners)
  {
    const auto* const end = branch + parts - 1;
    const auto* const other = std::find_if(branch, end, [&](std::int32_t of) { return of != corner.branch; });
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
  const Four color = std::bit_cast<Four>(low.color);
  Sample result = low;
  result.color =
    std::bit_cast<std::array<float, 4>>(color + part * (std::bit_cast<Four>(high.color) - color));
  result.place += part * (high.place - low.place);
  result.extinction += part * (high.extinction - low.extinction);
  return result;
}

/// a: the sample at the first step.
LinePieces::Fit LinePieces::fit(const Sample& a, std::size_t first, std::size_t last) const
{
  const Sample b = at(last);
  const Four color = std::bit_cast<Four>(a.color);
  const Four change = std::bit_cast<Four>(b.color) - color;
  const Four ofTable = shiftOfProducts(1.f, a.extinction, b.extinction) * change;
  const float mostOfTable = largestOf(ofTable);
  if (!(mostOfTable <= tolerance))
  {
    return { false, mostOfTable / tolerance, {} };
  }
  // How far colours and what products of lines show are off. Without branches: each goes another way.
  Span lines;
  Span products;
  const float perWidth = 1.f / (b.place - a.place);
  const float slope = b.extinction - a.extinction;
  const auto alongTo = [&](const Sample& sample) { return (sample.place - a.place) * perWidth; };
  const auto offAt = [&](const Sample& sample) {
    return color + alongTo(sample) * change - std::bit_cast<Four>(sample.color);
  };
  const float root = std::sqrt(a.extinction);
  const float peak = slope == 0.f ? 0.5f : root / (root + std::sqrt(b.extinction)); // of what products show
  const Sample* const begin = &samples_[first / steps + 1];
  const Sample* const end = &samples_[(last + steps - 1) / steps];
  const Sample* afterPeak = begin;
  float ofExtinctions = 0.f;
  for (const Sample* sample = begin; sample < end; ++sample)
  {
    const float along = alongTo(*sample);
    afterPeak += along < peak ? 1 : 0;
    const float extinction = a.extinction + along * slope;
    ofExtinctions = std::max(ofExtinctions, std::abs(extinction - sample->extinction) * sample->perError);
    const float shown = along * b.extinction / std::max(extinction, std::numeric_limits<float>::min());
    const Four toCurve = color - std::bit_cast<Four>(sample->color);
    lines.add(toCurve + along * change);
    products.add(toCurve + shown * change);
  }
  if (ofExtinctions > 1.f)
  {
    return { false, ofExtinctions, {} };
  }
  // Of the lines themselves nothing is off at both ends.
  const bool isLast = afterPeak >= end;
  const bool isFirst = afterPeak <= begin;
  const float before = isFirst ? 0.f : alongTo(afterPeak[-1]);
  const float after = isLast ? 1.f : alongTo(*afterPeak);
  const Four offBefore = isFirst ? Four{} : offAt(afterPeak[-1]);
  const Four offAfter = isLast ? Four{} : offAt(*afterPeak);
  if (peak > 0.f)
  {
    const float toPeak = (peak - before) / (after - before);
    products.add(offBefore + toPeak * (offAfter - offBefore) - 2.f * ofTable);
  }
  Four moved{};
  for (int c = 0; c < 3; ++c)
  {
    moved[c] = shiftInTables(float(ofTable[c]));
  }
  lines.add(products.least + moved);
  lines.add(products.most + moved);
  const float ofAllowed = std::max(largestOf(lines.most - lines.least) / (2.f * tolerance), ofExtinctions);
  return { ofAllowed <= 1.f, ofAllowed,
    std::bit_cast<std::array<float, 4>>(-0.5f * (lines.least + lines.most)) };
}

std::size_t LinePieces::longest(std::size_t first, std::size_t expected, Fit& fitted) const
{
  const std::size_t end = steps * (samples_.size() - 1);
  const Sample a = at(first);
  std::size_t close = (first / steps + 1) * steps; // nothing is up to the next sample
  std::size_t far = end + 1;
  bool isFitted = false;
  std::size_t next = expected;
  std::size_t step = steps / 2;
  constexpr int guesses = 4;
  constexpr float enough = 1.25f; // of a step, to go without a try
  for (int tries = 1; close + 1 < far; ++tries)
  {
    next = std::clamp(next, close + 1, far - 1);
    const Fit tried = fit(a, first, next);
    if (tried.isClose)
    {
      fitted = tried;
      isFitted = true;
      close = next;
    }
    else
    {
      far = next;
    }
    constexpr float most = 16.f;
    if (tries <= guesses && tried.ofAllowed < most)
    {
      // Colours are off as lengths squared.
      const auto length = static_cast<float>(next - first);
      const float allowed = length / std::sqrt(std::max(tried.ofAllowed, 1.f / most));
      if (tried.isClose && allowed < length + enough)
      {
        break;
      }
      next = first + static_cast<std::size_t>(allowed);
    }
    else if (far > end)
    {
      next = close + step;
      step *= 2;
    }
    else
    {
      next = (close + far) / 2;
    }
  }
  if (!isFitted)
  {
    fitted = fit(a, first, close);
  }
  return close;
}

FollowedParts::FollowedParts(const std::vector<ColorPart>& parts, double extinctionPart)
  : parts_(parts.size())
  , blocks_((parts.size() + partsOfBlock - 1) / partsOfBlock)
{
  tbb::parallel_for(std::size_t(0), blocks_.size(), [&](std::size_t block) {
    LinePieces linePieces(extinctionPart);
    const std::size_t end = std::min((block + 1) * partsOfBlock, parts.size());
    for (std::size_t i = block * partsOfBlock; i < end; ++i)
    {
      const std::vector<LinePiece>& pieces = linePieces.follow(parts[i]);
      Part& part = parts_[i];
      part.begin = part.end = blocks_[block].size();
      if (!pieces.empty())
      {
        blocks_[block].insert(blocks_[block].end(), pieces.begin(), pieces.end());
        part = { part.begin, blocks_[block].size(), linePieces.first(), linePieces.last() };
      }
    }
  });
}

} // namespace treeamr

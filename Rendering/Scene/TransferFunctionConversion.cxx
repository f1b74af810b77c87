#include "TransferFunctionConversion.h"

#include "Error.h"
#include "Field/Emission.h"
#include "LinePieces.h"
#include "PropertyFunctions.h"

#include "vtkColorTransferFunction.h"
#include "vtkDataArray.h"
#include "vtkPiecewiseFunction.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace treeamr
{

namespace
{

using Entry = TransferFunction::Entry;
using Node = TransferFunction::Node;

constexpr std::size_t manySegments = 128;

/// Between which floats the functions are what they come to at a and b from inside.
std::pair<double, double> insideOf(const PropertyFunctions& functions, double a, double b)
{
  constexpr double beside = 1e-12;
  constexpr double rounding = 4. * std::numeric_limits<double>::epsilon();
  const auto inset = [&](double end) {
    const double size = std::abs(end);
    const double least = beside * (size == 0. ? b - a : std::min(b - a, size));
    return std::min(std::max({ functions.rounding(), rounding * size, least }), 0.25 * (b - a));
  };
  return { a + inset(a), b - inset(b) };
}

/// Calls use(a, b) for the segments of a range between values.
template <class Use>
void forEachSegment(Range dataRange, const std::vector<double>& values, const Use& use)
{
  double at = dataRange.min;
  for (const double value : values)
  {
    if (value > at && value < dataRange.max)
    {
      use(at, value);
      at = value;
    }
  }
  if (at < dataRange.max)
  {
    use(at, dataRange.max);
  }
}

/// By how much of itself a faint extinction may err. What many segments err by is not seen as one colour.
double extinctionPartOf(std::size_t segments)
{
  return segments < manySegments ? 1. / 2048. : 1. / 288.;
}

/// Nodes of the functions between values, close enough for lines.
class NodeList
{
public:
  /// followed: the segments that are curves of colours over lines of opacities, for a table of manyNodes; null for others.
  NodeList(PropertyFunctions& functions, std::size_t segments, const FollowedParts* followed)
    : functions_(functions)
    , part_(extinctionPartOf(segments))
    , followed_(followed)
  {
    constexpr std::size_t most = 16; // of nodes a segment
    nodes_.reserve(followed ? most * segments : 0);
  }

  /// The function's part from a to b.
  void addSegment(double a, double b)
  {
    functions_.choose(b);
    if (followed_ && functions_.isCurveOverLine() && addPieces(a, b))
    {
      return;
    }
    const auto [from, to] = insideOf(functions_, a, b);
    Sample first = functions_.at(from);
    first.value = a;
    Sample last = functions_.at(to);
    last.value = b;
    const Entry atEnd = functions_.at(b).entry;
    begin(a, first.entry, {});
    shownEnd_.reset();
    if (!functions_.areOpacitiesLines())
    {
      const auto follows = [this](const Entry& entry, const Entry& line) { return isClose(entry, line); };
      refine(first, last, middleOf(first, last), follows, [this](const Sample& sample) { add(sample); });
    }
    else
    {
      Sample before = first;
      if (!functions_.areColorsLines())
      {
        refine(first, last, middleOf(first, last), hasColorOf, [&](const Sample& sample) {
          addCurve(before, sample);
          add(sample);
          before = sample;
        });
      }
      addCurve(before, last);
    }
    end_ = last.entry;
    atEnd_ = atEnd;
  }
  /// What holds up to where the first segment begins.
  void beginWith(const Entry& entry) { end_ = atEnd_ = entry; }
  /// What holds from the last segment's end on is what VTK has there.
  std::vector<Node> endAt(double value)
  {
    add({ value, shownEnd_.value_or(isClose(end_, atEnd_) ? atEnd_ : end_), atEnd_ });
    return std::move(nodes_);
  }

private:
  using Sample = PropertyFunctions::Sample;

  /// Adds the next part of those that were followed, from a to b, if it has pieces.
  bool addPieces(double a, double b)
  {
    const std::size_t i = nextFollowed_++;
    const FollowedParts::Part& part = (*followed_)[i];
    bool isFirst = true;
    for (const LinePiece& piece : followed_->piecesOf(i))
    {
      if (isFirst)
      {
        begin(a, part.first, piece.atBegin);
      }
      else
      {
        add({ piece.begin, *shownEnd_, piece.atBegin });
      }
      isFirst = false;
      shownEnd_ = piece.atEnd;
    }
    if (isFirst)
    {
      return false;
    }
    end_ = atEnd_ = part.last;
    atEnd_.extinction =
      TransferFunction::extinctionFromOpacity(functions_.opacityAt(b), functions_.unitDistance());
    return true;
  }

  /// A node between two segments. shown: of the second one's first piece.
  void begin(double value, const Entry& above, const std::optional<Entry>& shown)
  {
    if (isClose(end_, above))
    {
      // An entry that is there alone has no width.
      const Entry& entry = isClose(end_, atEnd_) ? atEnd_ : end_;
      const bool isOfPieces = shownEnd_ || shown; // which begin and end at floats
      add(
        { isOfPieces ? static_cast<float>(value) : value, shownEnd_.value_or(entry), shown.value_or(entry) });
    }
    else
    {
      const double fromEnd = distance(end_, atEnd_);
      const double fromAbove = distance(above, atEnd_);
      // A colour of the one side with the opacity of the other is of neither.
      const bool isOwn = std::min(fromEnd, fromAbove) > 1. / 512.;
      const bool isOfEnd = fromEnd <= fromAbove;
      if (isOwn || !isOfEnd)
      {
        add({ value, shownEnd_.value_or(end_), isOwn ? atEnd_ : shown.value_or(above) });
      }
      if (isOwn || isOfEnd)
      {
        // The next float is the first that is above.
        const auto nearest = static_cast<float>(value);
        add({ nearest > value ? nearest : std::nextafter(nearest, std::numeric_limits<float>::infinity()),
          atEnd_, shown.value_or(above) });
      }
    }
  }

  void add(const Node& node)
  {
    if (!nodes_.empty() && node.value <= nodes_.back().value)
    {
      nodes_.back().above = node.above;
      return;
    }
    // In the middle of a constant.
    const std::size_t count = nodes_.size();
    if (count > 1 && nodes_[count - 2].above == nodes_[count - 1].below &&
      nodes_[count - 1].below == nodes_[count - 1].above && nodes_[count - 1].above == node.below)
    {
      nodes_.pop_back();
    }
    nodes_.push_back(node);
  }

  void add(const Sample& sample) { add(Node{ sample.value, sample.entry, sample.entry }); }

  /// Adds nodes between two samples, between which colour and opacity are lines, until lines follow the extinctions,
  /// -log(1 - opacity).
  void addCurve(const Sample& a, const Sample& b)
  {
    const auto [low, high] = std::minmax(a.opacity, b.opacity);
    const double least = 1. - high;
    const double change = b.opacity - a.opacity;
    std::vector<double> opacities;
    if (low < 0. && high > 0.)
    {
      opacities.push_back(0.);
    }
    // Over a step h a line errs by h^2 / 8 (1 - opacity)^-2 at most.
    double clear = 1. - std::max(low, 0.);
    while (clear > std::numeric_limits<double>::epsilon())
    {
      const double extinction = -std::log(clear);
      const double step = std::sqrt(8. * extinction * partOf(extinction));
      clear = std::min(clear / (1. + step), clear - 1. / 512.);
      if (clear <= least)
      {
        break;
      }
      opacities.push_back(1. - clear);
    }
    if (low < 1. && high > 1.)
    {
      opacities.push_back(1.);
    }
    if (change < 0.)
    {
      std::reverse(opacities.begin(), opacities.end());
    }
    for (const double opacity : opacities)
    {
      const double part = (opacity - a.opacity) / change;
      const auto color = static_cast<float>(part);
      add(Sample{ std::lerp(a.value, b.value, part), opacity,
        { std::lerp(a.entry.r, b.entry.r, color), std::lerp(a.entry.g, b.entry.g, color),
          std::lerp(a.entry.b, b.entry.b, color),
          TransferFunction::extinctionFromOpacity(opacity, functions_.unitDistance()) } });
    }
  }

  /// By how much of itself an extinction may err, per unit distance: the more opaque, the less it is seen: in a
  /// quarter of the unit distance as much, here.
  double partOf(double extinction) const { return std::min(part_ * std::exp(0.25 * extinction), 0.25); }

  Sample middleOf(const Sample& a, const Sample& b)
  {
    // Where values span octaves, so may what happens among them.
    const bool spansOctaves = a.value > 0. && b.value > 2. * a.value;
    return functions_.at(spansOctaves ? std::sqrt(a.value) * std::sqrt(b.value) : 0.5 * (a.value + b.value));
  }

  /// Adds samples between a and b until entries follow the lines between these.
  template <class Follows, class Add>
  void refine(
    const Sample& a, const Sample& b, const Sample& middle, const Follows& follows, const Add& addSample)
  {
    // Two floats, which have nothing in between.
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const auto largest = static_cast<float>(std::max(std::abs(a.value), std::abs(b.value)));
    if (b.value - a.value <= std::nextafter(largest, infinity) - largest)
    {
      return;
    }
    const Sample low = middleOf(a, middle);
    const Sample high = middleOf(middle, b);
    const auto isOnLine = [&](const Sample& sample) {
      const auto part = static_cast<float>((sample.value - a.value) / (b.value - a.value));
      return follows(sample.entry, TransferFunction::between(a.entry, b.entry, part));
    };
    if (isOnLine(low) && isOnLine(middle) && isOnLine(high))
    {
      return;
    }
    refine(a, middle, low, follows, addSample);
    addSample(middle);
    refine(middle, b, high, follows, addSample);
  }

  static bool hasColorOf(const Entry& a, const Entry& b)
  {
    constexpr float channel = 1.f / 1024.f;
    return std::abs(a.r - b.r) <= channel && std::abs(a.g - b.g) <= channel && std::abs(a.b - b.b) <= channel;
  }

  bool isClose(const Entry& a, const Entry& b) const
  {
    constexpr double channel = 1. / 1024.;
    constexpr double nothing = 1e-8; // of opacity
    const double change =
      std::abs(static_cast<double>(a.extinction) - b.extinction) * functions_.unitDistance();
    const double largest = std::max(a.extinction, b.extinction) * functions_.unitDistance();
    const double least = largest - change;
    const double most = std::max(largest * partOf(least), nothing);
    return hasColorOf(a, b) && std::exp(-least) - std::exp(-largest) <= channel && change <= most;
  }

  /// The largest of a channel.
  double distance(const Entry& a, const Entry& b) const
  {
    const double unit = functions_.unitDistance();
    return std::max({ std::abs(static_cast<double>(a.r) - b.r), std::abs(static_cast<double>(a.g) - b.g),
      std::abs(static_cast<double>(a.b) - b.b),
      std::abs(std::exp(-a.extinction * unit) - std::exp(-b.extinction * unit)) });
  }

  PropertyFunctions& functions_;
  double part_;
  const FollowedParts* followed_;
  std::size_t nextFollowed_ = 0;
  std::vector<Node> nodes_;
  Entry end_{};                   // what the segment before came to
  Entry atEnd_{};                 // what it is there
  std::optional<Entry> shownEnd_; // what its last piece came to
};

FollowedParts follow(PropertyFunctions& functions, Range dataRange, const std::vector<double>& values)
{
  std::vector<ColorPart> parts;
  parts.reserve(values.size() + 1);
  functions.restart();
  forEachSegment(dataRange, values, [&](double a, double b) {
    functions.choose(b);
    if (functions.isCurveOverLine())
    {
      const auto [from, to] = insideOf(functions, a, b);
      parts.push_back({ *functions.curveEnds(), a, b, functions.opacityAt(from), functions.opacityAt(to),
        functions.offset(), functions.unitDistance() });
    }
  });
  return { parts, extinctionPartOf(values.size()) };
}

/// values: between which the functions are smooth.
std::vector<Node> makeNodes(PropertyFunctions& functions, Range dataRange, const std::vector<double>& values,
  const FollowedParts* followed)
{
  NodeList nodes(functions, values.size(), followed);
  functions.restart();
  functions.choose(dataRange.min);
  nodes.beginWith(functions.at(dataRange.min).entry);
  forEachSegment(dataRange, values, [&](double a, double b) { nodes.addSegment(a, b); });
  return nodes.endAt(dataRange.max);
}

} // namespace

void checkUnitDistance(vtkVolumeProperty* property, int component)
{
  const double unitDistance = property->GetScalarOpacityUnitDistance(component);
  if (!(unitDistance > 0.) || !std::isfinite(unitDistance))
  {
    throw Error("volume property: scalar opacity unit distance " + std::to_string(unitDistance) +
      ", allowed are positive lengths");
  }
}

TransferFunction convertTransferFunction(
  vtkVolumeProperty* property, Range dataRange, double offset, const PropertyComponent& component)
{
  checkUnitDistance(property, component.unitDistance);
  PropertyFunctions functions(property, dataRange, offset, component);
  const std::vector<double> values = functions.values();
  if (values.size() >= manySegments && functions.haveCurves())
  {
    const FollowedParts followed = follow(functions, dataRange, values);
    std::vector<Node> nodes = makeNodes(functions, dataRange, values, &followed);
    if (nodes.size() >= manyNodes)
    {
      return TransferFunction::ofNodes(std::move(nodes));
    }
  }
  return TransferFunction::ofNodes(makeNodes(functions, dataRange, values, nullptr));
}

bool hasCategories(vtkVolumeProperty* property)
{
  return property->GetColorChannels(0) == 3 && property->GetRGBTransferFunction(0)->GetIndexedLookup();
}

TransferFunction convertCategories(vtkVolumeProperty* property, vtkDataArray* values)
{
  checkUnitDistance(property, 0);
  vtkColorTransferFunction* table = property->GetRGBTransferFunction(0);
  // What a function without nodes maps nothing to.
  std::array<unsigned char, 4> nothing{};
  for (int c = 0; c < 3; ++c)
  {
    nothing[c] = static_cast<unsigned char>(255. * table->GetNanColor()[c] + 0.5);
  }
  std::vector<std::array<unsigned char, 4>> colors(
    static_cast<std::size_t>(values->GetNumberOfTuples()), nothing);
  table->Build();
  table->MapScalarsThroughTable(values, colors.front().data(), VTK_RGBA);
  std::vector<TransferFunction::Entry> entries;
  entries.reserve(colors.size());
  for (const std::array<unsigned char, 4>& rgba : colors)
  {
    const double value = values->GetComponent(static_cast<vtkIdType>(entries.size()), 0);
    entries.push_back({ rgba[0] / 255.f, rgba[1] / 255.f, rgba[2] / 255.f,
      TransferFunction::extinctionFromOpacity(
        property->GetScalarOpacity(0)->GetValue(value), property->GetScalarOpacityUnitDistance(0)) });
  }
  return TransferFunction::ofCategories(std::move(entries));
}

} // namespace treeamr

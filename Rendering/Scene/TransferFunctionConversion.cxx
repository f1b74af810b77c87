#include "TransferFunctionConversion.h"

#include "Error.h"

#include "vtkColorTransferFunction.h"
#include "vtkDataArray.h"
#include "vtkNew.h"
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
using Color = std::array<double, 3>;

/// A midpoint and a sharpness with which VTK draws a line to the next node.
bool isStraight(const double* midpointAndSharpness)
{
  return midpointAndSharpness[0] == 0.5 && midpointAndSharpness[1] == 0.;
}

/// The value, or one of those below all nodes that have a logarithm.
template <class Nodes>
double withLogarithm(double value, bool isLogarithmic, const Nodes& nodes)
{
  return isLogarithmic && !(value > 0.) ? 0.5 * nodes.front()[0] : value;
}

/// A function between neighbouring nodes of it, by VTK's evaluation of a function of these two alone: that of the whole
/// one passes all of its nodes, for each value.
class Opacities
{
public:
  explicit Opacities(vtkPiecewiseFunction* function)
    : function_(function)
  {
    for (int i = 0; i < function_->GetSize(); ++i)
    {
      function_->GetNodeValue(i, nodes_.emplace_back().data());
    }
    segment_->SetUseLogScale(function_->GetUseLogScale() && !nodes_.empty() && nodes_.front()[0] > 0.);
  }

  std::size_t count() const { return nodes_.size(); }
  double node(std::size_t i) const { return nodes_[i][0]; }
  /// From now on for values from node i - 1 to node i, or beyond an end.
  void choose(std::size_t i)
  {
    next_ = i;
    isInside_ = i > 0 && i < nodes_.size();
    isLine_ = !isInside_ || (!segment_->GetUseLogScale() && isStraight(&nodes_[i - 1][2]));
    if (!isLine_)
    {
      segment_->RemoveAllPoints();
      for (const auto& [x, y, midpoint, sharpness] : { nodes_[i - 1], nodes_[i] })
      {
        segment_->AddPoint(x, y, midpoint, sharpness);
      }
    }
  }
  /// Whether these are a line.
  bool isLine() const { return isLine_; }
  double at(double value)
  {
    if (!isInside_)
    {
      return function_->GetValue(withLogarithm(value, segment_->GetUseLogScale(), nodes_));
    }
    if (!isLine_)
    {
      return segment_->GetValue(value);
    }
    const auto& a = nodes_[next_ - 1];
    const auto& b = nodes_[next_];
    return std::lerp(a[1], b[1], std::clamp((value - a[0]) / (b[0] - a[0]), 0., 1.));
  }

private:
  vtkPiecewiseFunction* function_;
  std::vector<std::array<double, 4>> nodes_;
  vtkNew<vtkPiecewiseFunction> segment_;
  std::size_t next_ = 0;
  bool isInside_ = false;
  bool isLine_ = true;
};

/// The same of colours. Of what ParaView shows on surfaces in few colours VTK's volume mappers know nothing: they ask
/// for a table of the function, as here.
class Colors
{
public:
  /// Of values of a part.
  Colors(vtkColorTransferFunction* function, double min, double max)
    : function_(function)
  {
    for (int i = 0; i < function_->GetSize(); ++i)
    {
      function_->GetNodeValue(i, nodes_.emplace_back().data());
    }
    isLogarithmic_ = function_->GetScale() == VTK_CTF_LOG10 && !nodes_.empty() && nodes_.front()[0] > 0.;
    segment_->SetColorSpace(function_->GetColorSpace());
    segment_->SetHSVWrap(function_->GetHSVWrap());
    segment_->SetScale(isLogarithmic_ ? VTK_CTF_LOG10 : VTK_CTF_LINEAR);
    if (function_->GetColorSpace() == VTK_CTF_LAB_CIEDE2000 && nodes_.size() > 1)
    {
      makeTable(min, max);
    }
  }

  std::size_t count() const { return nodes_.size(); }
  double node(std::size_t i) const { return nodes_[i][0]; }
  void choose(std::size_t i)
  {
    next_ = i;
    isInside_ = i > 0 && i < nodes_.size();
    isLine_ = !isInside_ || !table_.empty() ||
      (!isLogarithmic_ && segment_->GetColorSpace() == VTK_CTF_RGB && isStraight(&nodes_[i - 1][4]));
    if (!isLine_)
    {
      segment_->RemoveAllPoints();
      for (const auto& [x, r, g, b, midpoint, sharpness] : { nodes_[i - 1], nodes_[i] })
      {
        segment_->AddRGBPoint(x, r, g, b, midpoint, sharpness);
      }
    }
  }
  bool isLine() const { return isLine_; }
  std::size_t countInTable() const { return table_.size(); }
  /// The value of a table's entry.
  double tableValue(std::size_t i) const
  {
    const double part = static_cast<double>(i) / static_cast<double>(table_.size() - 1);
    return isLogarithmic_ ? first_ * std::pow(last_ / first_, part) : std::lerp(first_, last_, part);
  }
  Color at(double value)
  {
    if (isInside_ && !table_.empty())
    {
      return inTable(value);
    }
    Color color;
    if (isInside_ && isLine_)
    {
      const auto& a = nodes_[next_ - 1];
      const auto& b = nodes_[next_];
      const double part = std::clamp((value - a[0]) / (b[0] - a[0]), 0., 1.);
      for (int c = 0; c < 3; ++c)
      {
        color[c] = std::lerp(a[c + 1], b[c + 1], part);
      }
      return color;
    }
    value = withLogarithm(value, isLogarithmic_, nodes_);
    (isInside_ ? segment_ : function_)->GetTable(value, value, 1, color.data());
    return color;
  }

private:
  /// Each call finds the way between two colours anew, for half a second: one call for all.
  void makeTable(double min, double max)
  {
    constexpr int size = 4096;
    first_ = std::max(min, nodes_.front()[0]);
    last_ = std::min(max, nodes_.back()[0]);
    if (first_ < last_)
    {
      table_.resize(size);
      function_->GetTable(first_, last_, size, table_.front().data());
    }
  }
  Color inTable(double value) const
  {
    const double part = isLogarithmic_ ? std::log(value / first_) / std::log(last_ / first_)
                                       : (value - first_) / (last_ - first_);
    const double place = std::clamp(part, 0., 1.) * static_cast<double>(table_.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(place), table_.size() - 2);
    Color color;
    for (int c = 0; c < 3; ++c)
    {
      color[c] = std::lerp(table_[i][c], table_[i + 1][c], place - static_cast<double>(i));
    }
    return color;
  }

  vtkColorTransferFunction* function_;
  std::vector<std::array<double, 6>> nodes_;
  vtkNew<vtkColorTransferFunction> segment_;
  std::size_t next_ = 0;
  bool isInside_ = false;
  bool isLine_ = true;
  bool isLogarithmic_;
  std::vector<Color> table_; // of CIEDE2000 only, over [first_, last_]
  double first_ = 0.;
  double last_ = 0.;
};

/// All functions of a property, from one value where one of them has a node to the next. Values: less the offset.
class PropertyFunctions
{
public:
  PropertyFunctions(vtkVolumeProperty* property, Range part, double offset, int component)
    : opacities_(property->GetScalarOpacity(0))
    , offset_(offset)
    , unitDistance_(property->GetScalarOpacityUnitDistance(component))
  {
    if (property->GetColorChannels(0) == 1)
    {
      grays_.emplace(property->GetGrayTransferFunction(0));
    }
    else
    {
      colors_.emplace(property->GetRGBTransferFunction(0), offset + part.min, offset + part.max);
    }
  }

  /// Values between which each function is smooth, in order: of nodes, and of a table's entries.
  std::vector<double> values() const
  {
    std::vector<double> values;
    const auto add = [&](const auto& functions) {
      for (std::size_t i = 0; i < functions.count(); ++i)
      {
        values.push_back(functions.node(i) - offset_);
      }
    };
    add(opacities_);
    grays_ ? add(*grays_) : add(*colors_);
    for (std::size_t i = 0; colors_ && i < colors_->countInTable(); ++i)
    {
      values.push_back(colors_->tableValue(i) - offset_);
    }
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
  }

  /// From now on for values up to `end`, from the last node before it on. In the order of ends.
  void choose(double end)
  {
    const auto chooseIn = [&](auto& functions, std::size_t& next) {
      const std::size_t before = next;
      while (next < functions.count() && functions.node(next) - offset_ < end)
      {
        ++next;
      }
      if (next != before)
      {
        functions.choose(next);
      }
    };
    chooseIn(opacities_, nextOpacity_);
    grays_ ? chooseIn(*grays_, nextColor_) : chooseIn(*colors_, nextColor_);
  }

  /// What the functions are at a value.
  struct Sample
  {
    double value;
    double opacity;
    Entry entry;
  };

  Sample at(double relative)
  {
    const double value = offset_ + relative;
    Color color;
    if (grays_)
    {
      color.fill(grays_->at(value));
    }
    else
    {
      color = colors_->at(value);
    }
    const double opacity = opacities_.at(value);
    return { relative, opacity,
      { static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2]),
        TransferFunction::extinctionFromOpacity(opacity, unitDistance_) } };
  }

  bool areColorsLines() const { return grays_ ? grays_->isLine() : colors_->isLine(); }
  /// So that extinctions bend as those of a line do.
  bool areOpacitiesLines() const { return opacities_.isLine(); }
  double unitDistance() const { return unitDistance_; }
  /// By which values must differ for the functions to tell them apart.
  double rounding() const { return 4. * std::numeric_limits<double>::epsilon() * std::abs(offset_); }

private:
  Opacities opacities_;
  std::optional<Opacities> grays_;
  std::optional<Colors> colors_;
  std::size_t nextOpacity_ = 0;
  std::size_t nextColor_ = 0;
  double offset_;
  double unitDistance_;
};

void checkUnitDistance(vtkVolumeProperty* property, int component)
{
  const double unitDistance = property->GetScalarOpacityUnitDistance(component);
  if (!(unitDistance > 0.) || !std::isfinite(unitDistance))
  {
    throw Error("volume property: scalar opacity unit distance " + std::to_string(unitDistance) +
      ", allowed are positive lengths");
  }
}

/// Nodes of the functions between values, close enough for lines.
class NodeList
{
public:
  /// count: of segments.
  NodeList(PropertyFunctions& functions, std::size_t count)
    : functions_(functions)
    // What many segments err by is not seen as one colour.
    , part_(count < 128 ? 1. / 2048. : 1. / 216.)
  {
  }

  /// The function's part from a to b.
  void addSegment(double a, double b)
  {
    functions_.choose(b);
    // What it comes to there, on this side.
    constexpr double beside = 1e-12;
    constexpr double rounding = 4. * std::numeric_limits<double>::epsilon();
    const auto inset = [&](double end) {
      const double size = std::abs(end);
      const double least = beside * (size == 0. ? b - a : std::min(b - a, size));
      return std::min(std::max({ functions_.rounding(), rounding * size, least }), 0.25 * (b - a));
    };
    Sample first = functions_.at(a + inset(a));
    first.value = a;
    Sample last = functions_.at(b - inset(b));
    last.value = b;
    const Entry atEnd = functions_.at(b).entry;
    begin(a, first.entry);
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
    add({ value, isClose(end_, atEnd_) ? atEnd_ : end_, atEnd_ });
    return std::move(nodes_);
  }

private:
  using Sample = PropertyFunctions::Sample;

  /// A node between two segments.
  void begin(double value, const Entry& above)
  {
    if (isClose(end_, above))
    {
      // An entry that is there alone has no width.
      const Entry& entry = isClose(end_, atEnd_) ? atEnd_ : end_;
      add({ value, entry, entry });
    }
    else if (distance(end_, atEnd_) <= distance(above, atEnd_))
    {
      // The next float is the first that is above.
      const auto nearest = static_cast<float>(value);
      add({ nearest > value ? nearest : std::nextafter(nearest, std::numeric_limits<float>::infinity()),
        atEnd_, above });
    }
    else
    {
      add({ value, end_, above });
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
      clear = std::min(clear / (1. + step), clear - 4. * part_);
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
  std::vector<Node> nodes_;
  Entry end_{};   // what the segment before came to
  Entry atEnd_{}; // what it is there
};

} // namespace

TransferFunction convertTransferFunction(
  vtkVolumeProperty* property, Range dataRange, double offset, int component)
{
  checkUnitDistance(property, component);
  PropertyFunctions functions(property, dataRange, offset, component);
  const std::vector<double> values = functions.values();
  NodeList nodes(functions, values.size());
  double at = dataRange.min;
  functions.choose(at);
  nodes.beginWith(functions.at(at).entry);
  for (const double value : values)
  {
    if (value > at && value < dataRange.max)
    {
      nodes.addSegment(at, value);
      at = value;
    }
  }
  if (at < dataRange.max)
  {
    nodes.addSegment(at, dataRange.max);
  }
  return TransferFunction::ofNodes(nodes.endAt(dataRange.max));
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

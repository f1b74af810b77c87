#include "PropertyFunctions.h"

#include "vtkColorTransferFunction.h"
#include "vtkPiecewiseFunction.h"
#include "vtkVolumeProperty.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

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

std::optional<ColorCurve::Space> spaceOf(vtkColorTransferFunction* function)
{
  switch (function->GetColorSpace())
  {
    case VTK_CTF_RGB:
      return ColorCurve::Space::Rgb;
    case VTK_CTF_HSV:
      return function->GetHSVWrap() ? ColorCurve::Space::WrappedHsv : ColorCurve::Space::Hsv;
    case VTK_CTF_LAB:
      return ColorCurve::Space::Lab;
    case VTK_CTF_DIVERGING:
      return ColorCurve::Space::Diverging;
    default:
      return std::nullopt;
  }
}

} // namespace

OpacitySegments::OpacitySegments(vtkPiecewiseFunction* function)
  : function_(function)
{
  for (int i = 0; i < function_->GetSize(); ++i)
  {
    function_->GetNodeValue(i, nodes_.emplace_back().data());
  }
  segment_->SetUseLogScale(function_->GetUseLogScale() && !nodes_.empty() && nodes_.front()[0] > 0.);
}

void OpacitySegments::choose(std::size_t i)
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

double OpacitySegments::at(double value) const
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

double OpacitySegments::atNode(std::size_t i) const
{
  const bool isWithinLine = isInside_ && i + 1 < nodes_.size() && nodes_[i + 1][0] > nodes_[i][0];
  return isWithinLine ? nodes_[i][1] : function_->GetValue(nodes_[i][0]);
}

ColorSegments::ColorSegments(vtkColorTransferFunction* function, double min, double max)
  : function_(function)
  , space_(spaceOf(function))
{
  for (int i = 0; i < function_->GetSize(); ++i)
  {
    function_->GetNodeValue(i, nodes_.emplace_back().data());
  }
  isLogarithmic_ = function_->GetScale() == VTK_CTF_LOG10 && !nodes_.empty() && nodes_.front()[0] > 0.;
  segment_->SetColorSpace(function_->GetColorSpace());
  segment_->SetScale(isLogarithmic_ ? VTK_CTF_LOG10 : VTK_CTF_LINEAR);
  if (function_->GetColorSpace() == VTK_CTF_LAB_CIEDE2000 && nodes_.size() > 1)
  {
    makeTable(min, max);
  }
}

void ColorSegments::choose(std::size_t i)
{
  next_ = i;
  isInside_ = i > 0 && i < nodes_.size();
  isLine_ = !isInside_ || !table_.empty() ||
    (!isLogarithmic_ && space_ == ColorCurve::Space::Rgb && isStraight(&nodes_[i - 1][4]));
  ends_.reset();
  curve_.reset();
  if (isLine_)
  {
    return;
  }
  if (space_)
  {
    ends_ = { *space_, isLogarithmic_, nodes_[i - 1], nodes_[i] };
    return;
  }
  segment_->RemoveAllPoints();
  for (const auto& [x, r, g, b, midpoint, sharpness] : { nodes_[i - 1], nodes_[i] })
  {
    segment_->AddRGBPoint(x, r, g, b, midpoint, sharpness);
  }
}

double ColorSegments::tableValue(std::size_t i) const
{
  const double part = static_cast<double>(i) / static_cast<double>(table_.size() - 1);
  return isLogarithmic_ ? first_ * std::pow(last_ / first_, part) : std::lerp(first_, last_, part);
}

ColorSegments::Color ColorSegments::at(double value) const
{
  if (isInside_ && !table_.empty())
  {
    return inTable(value);
  }
  if (ends_)
  {
    if (!curve_)
    {
      curve_.emplace(*ends_);
    }
    return curve_->at(value);
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
  if (isInside_)
  {
    segment_->GetTable(value, value, 1, color.data());
  }
  else
  {
    function_->GetTable(value, value, 1, color.data());
  }
  return color;
}

/// Each call finds the way between two colours anew, for half a second: one call for all.
void ColorSegments::makeTable(double min, double max)
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

ColorSegments::Color ColorSegments::inTable(double value) const
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

PropertyFunctions::PropertyFunctions(
  vtkVolumeProperty* property, Range part, double offset, const PropertyComponent& component)
  : opacities_(property->GetScalarOpacity(component.functions))
  , offset_(offset)
  , unitDistance_(property->GetScalarOpacityUnitDistance(component.unitDistance))
{
  if (property->GetColorChannels(component.functions) == 1)
  {
    grays_.emplace(property->GetGrayTransferFunction(component.functions));
  }
  else
  {
    colors_.emplace(
      property->GetRGBTransferFunction(component.functions), offset + part.min, offset + part.max);
  }
}

std::vector<double> PropertyFunctions::values() const
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

void PropertyFunctions::choose(double end)
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
  end_ = end;
  chooseIn(opacities_, nextOpacity_);
  grays_ ? chooseIn(*grays_, nextColor_) : chooseIn(*colors_, nextColor_);
}

void PropertyFunctions::restart()
{
  nextOpacity_ = nextColor_ = 0;
  opacities_.choose(0);
  grays_ ? grays_->choose(0) : colors_->choose(0);
}

double PropertyFunctions::valueOf(const OpacitySegments& functions, std::size_t next, double relative) const
{
  const bool isNode = relative == end_ && next < functions.count() && functions.node(next) - offset_ == end_;
  return isNode ? functions.atNode(next) : functions.at(offset_ + relative);
}

PropertyFunctions::Sample PropertyFunctions::at(double relative) const
{
  ColorSegments::Color color;
  if (grays_)
  {
    color.fill(valueOf(*grays_, nextColor_, relative));
  }
  else
  {
    color = colors_->at(offset_ + relative);
  }
  const double opacity = opacityAt(relative);
  return { relative, opacity,
    { static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2]),
      TransferFunction::extinctionFromOpacity(opacity, unitDistance_) } };
}

double PropertyFunctions::rounding() const
{
  return 4. * std::numeric_limits<double>::epsilon() * std::abs(offset_);
}

} // namespace treeamr

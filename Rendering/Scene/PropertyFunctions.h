// The functions of a vtkVolumeProperty as VTK evaluates them, from node to node. Private to the module.
#pragma once

#include "ColorCurve.h"
#include "Field/Field.h"
#include "Field/TransferFunction.h"

#include "vtkNew.h"

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

class vtkColorTransferFunction;
class vtkPiecewiseFunction;
class vtkVolumeProperty;

namespace treeamr
{

/// A function between neighbouring nodes of it, by VTK's evaluation of a function of these two alone: that of the whole
/// one passes all of its nodes, for each value.
class OpacitySegments
{
public:
  explicit OpacitySegments(vtkPiecewiseFunction* function);

  std::size_t count() const { return nodes_.size(); }
  double node(std::size_t i) const { return nodes_[i][0]; }
  /// From now on for values from node i - 1 to node i, or beyond an end.
  void choose(std::size_t i);
  /// Whether these are a line.
  bool isLine() const { return isLine_; }
  double at(double value) const;
  /// At node i, which exists. Of a jump there, as at ends without clamping, VTK's versions take either side.
  double atNode(std::size_t i) const;

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
class ColorSegments
{
public:
  using Color = std::array<double, 3>;

  /// Of values of a part.
  ColorSegments(vtkColorTransferFunction* function, double min, double max);

  std::size_t count() const { return nodes_.size(); }
  double node(std::size_t i) const { return nodes_[i][0]; }
  void choose(std::size_t i);
  bool isLine() const { return isLine_; }
  bool haveCurves() const { return space_ && (isLogarithmic_ || space_ != ColorCurve::Space::Rgb); }
  /// Of the curve of the values chosen, if they have one.
  const ColorCurve::Ends* curveEnds() const { return ends_ ? &*ends_ : nullptr; }
  std::size_t countInTable() const { return table_.size(); }
  /// The value of a table's entry.
  double tableValue(std::size_t i) const;
  Color at(double value) const;

private:
  void makeTable(double min, double max);
  Color inTable(double value) const;

  vtkColorTransferFunction* function_;
  std::vector<ColorNode> nodes_;
  std::optional<ColorCurve::Space> space_; // none of what only VTK evaluates
  std::optional<ColorCurve::Ends> ends_;
  mutable std::optional<ColorCurve> curve_; // once it is asked for
  vtkNew<vtkColorTransferFunction> segment_;
  std::size_t next_ = 0;
  bool isInside_ = false;
  bool isLine_ = true;
  bool isLogarithmic_ = false;
  std::vector<Color> table_; // of CIEDE2000 only, over [first_, last_]
  double first_ = 0.;
  double last_ = 0.;
};

/// Of a property's components.
struct PropertyComponent
{
  int functions = 0;    // whose colours and opacities
  int unitDistance = 0; // whose one these are over
};

/// All functions of a property's component, from one value where one of them has a node to the next. Values: less the offset.
class PropertyFunctions
{
public:
  PropertyFunctions(
    vtkVolumeProperty* property, Range part, double offset, const PropertyComponent& component);

  /// Values between which each function is smooth, in order: of nodes, and of a table's entries.
  std::vector<double> values() const;
  /// From now on for values up to `end`, from the last node before it on. In the order of ends.
  void choose(double end);
  /// From now on for values before all nodes.
  void restart();

  /// What the functions are at a value.
  struct Sample
  {
    double value;
    double opacity;
    TransferFunction::Entry entry;
  };
  /// For the chosen values; at their end itself what VTK has on a node there.
  Sample at(double relative) const;
  double opacityAt(double relative) const { return valueOf(opacities_, nextOpacity_, relative); }

  bool areColorsLines() const { return grays_ ? grays_->isLine() : colors_->isLine(); }
  /// Whether colours are curves anywhere.
  bool haveCurves() const { return colors_ && colors_->haveCurves(); }
  const ColorCurve::Ends* curveEnds() const { return colors_ ? colors_->curveEnds() : nullptr; }
  /// So that extinctions bend as those of a line do.
  bool areOpacitiesLines() const { return opacities_.isLine(); }
  /// Whether colours are a curve and opacities a line.
  bool isCurveOverLine() const { return curveEnds() && areOpacitiesLines(); }
  double unitDistance() const { return unitDistance_; }
  double offset() const { return offset_; }
  /// By which values must differ for the functions to tell them apart.
  double rounding() const;

private:
  double valueOf(const OpacitySegments& functions, std::size_t next, double relative) const;

  OpacitySegments opacities_;
  std::optional<OpacitySegments> grays_;
  std::optional<ColorSegments> colors_;
  std::size_t nextOpacity_ = 0;
  std::size_t nextColor_ = 0;
  double end_ = 0.;
  double offset_;
  double unitDistance_;
};

} // namespace treeamr

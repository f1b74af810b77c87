// Colours between two nodes of a vtkColorTransferFunction as VTK interpolates them, many values at once. Private to the
// module.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace treeamr
{

/// A node as vtkColorTransferFunction::GetNodeValue() has it: value, red, green, blue, midpoint, sharpness.
using ColorNode = std::array<double, 6>;

/// Agrees with VTK to 1e-5 of a channel, in a fiftieth of the time: what depends on the nodes alone is computed once.
class ColorCurve
{
public:
  enum class Space
  {
    Rgb,
    Hsv,
    WrappedHsv,
    Lab,
    Diverging
  };

  /// What makes a curve: values from a to b; isLogarithmic: of positive ones.
  struct Ends
  {
    Space space;
    bool isLogarithmic;
    ColorNode a;
    ColorNode b;
  };

  /// before: null or a curve of the same space, of which what it has of its last node is taken if it is the first here.
  explicit ColorCurve(const Ends& ends, const ColorCurve* before = nullptr);

  /// Values at once at most.
  static constexpr std::size_t most = 64;
  /// Colours of most values.
  struct Colors
  {
    float channel[3][most];
    /// Where these differ, the curve may have a corner in between.
    std::int32_t branch[most];
  };
  /// values: count of them, from a's to b's. Not for NaN.
  void at(const double* values, std::size_t count, Colors& colors) const;
  std::array<double, 3> at(double value) const;
  bool isLogarithmic() const { return isLogarithmic_; }
  bool hasJump() const { return sharpness_ > 0.99; }
  /// Whether the curve has a corner whatever the branch, and the value there.
  bool hasCorner() const { return hasWhite_ || midpoint_ != 0.5 || sharpness_ > 0.; }
  double corner() const { return corner_; }

private:
  void findParts(const double* values, std::size_t count, float* parts) const;
  void compute(const double* values, std::size_t count, Colors& colors) const;
  void computeWithAvx2(const double* values, std::size_t count, Colors& colors) const;

  Space space_ = Space::Rgb;
  bool isLogarithmic_ = false;
  double begin_ = 0.; // or its logarithm
  double perWidth_ = 0.;
  double midpoint_ = 0.5;
  double sharpness_ = 0.;
  double corner_ = 0.;
  bool hasWhite_ = false; // in the middle
  /// Coordinates in the space at both ends of each half; diverging ones meet in white there.
  struct Half
  {
    float first[3];
    float change[3];
  };
  Half halves_[2] = {};
  float color_[2][3] = {}; // of the nodes
  std::array<double, 3> lastColor_{};
  std::array<double, 3> lastCoordinates_{}; // in the space
};

} // namespace treeamr

// Light from a step in which the field is a line, to double precision: what the function does there one part after the
// other, whatever it is.
#pragma once

#include "Field/TransferFunction.h"

#include <array>
#include <vector>

namespace treeamr::test
{

class LineIntegral
{
public:
  /// Not for categories.
  explicit LineIntegral(const TransferFunction& transferFunction);

  /// Of a step of world length `length` from one value to another. color: red, green and blue, premultiplied, and
  /// opacity, which the step adds to.
  void addLight(
    double from, double to, double length, std::array<double, 4>& color, double& transmittance) const;
  /// About its optical depth, whatever the order of the values; for what is opaque a large one.
  double opticalDepth(double from, double to, double length) const;

private:
  using Values = std::array<double, 4>; // red, green, blue, extinction
  struct Node
  {
    double value;
    Values below;
    Values above;
  };

  std::size_t nodesUpTo(double value) const;
  /// Of the extinction, from the first node on.
  double depthUpTo(double value) const;
  /// At a value between nodes `next` - 1 and `next`.
  Values at(double value, std::size_t next) const;
  static void addLine(const Values& from, const Values& to, double length, std::array<double, 4>& color,
    double& transmittance, int depth = 0);

  std::vector<Node> nodes_;
  std::vector<double> depths_; // integrals of the extinction from the first node to each
};

} // namespace treeamr::test

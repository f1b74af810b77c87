// The Mandelbulb field and the refinement criterion of the example data.
//
// The Mandelbulb (White and Nylander, power 8) is z -> z^8 + c in spherical form with theta = acos(z / r) and
// phi = atan2(y, x). With levels 4 to 7 and a threshold of 0.05, and the forest balanced across faces, edges
// and corners, the unit cube has 305,096 cells; with levels 4 to 9 and 0.55 it has 2,636,936.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace treeamr
{

/// The smooth escape time at a point of the unit cube, in [0, 1]; 1 where the orbit is bounded after 12
/// steps.
inline double mandelbulb(double x, double y, double z) noexcept
{
  constexpr int maxSteps = 12;
  constexpr double escapeRadiusSquared = 4.;
  // The cube reaches 1.2 to each side of the origin.
  const std::array<double, 3> c = { 2.4 * (x - 0.5), 2.4 * (y - 0.5), 2.4 * (z - 0.5) };
  std::array<double, 3> p = c;
  for (int step = 0; step <= maxSteps; ++step)
  {
    const double r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    if (r2 > escapeRadiusSquared)
    {
      const double smooth = std::log(std::log(r2) / (2. * std::log(2.))) / std::log(8.);
      return std::clamp((step + 1 - smooth) / maxSteps, 0., 1.);
    }
    // acos(0 / 0) at the origin: the pole's direction does as well as any, since r is zero.
    const double theta = r2 > 0. ? 8. * std::acos(p[2] / std::sqrt(r2)) : 0.;
    const double phi = 8. * std::atan2(p[1], p[0]);
    const double r8 = r2 * r2 * r2 * r2;
    p = { r8 * std::sin(theta) * std::cos(phi) + c[0], r8 * std::sin(theta) * std::sin(phi) + c[1],
      r8 * std::cos(theta) + c[2] };
  }
  return 1.;
}

/// max - min of field(x, y, z) over 3 x 3 x 3 probes of a cubic cell, at the fractions 1/6, 1/2 and 5/6 of
/// its width: the centres of its 27 thirds. A cell is refined when this exceeds the threshold.
template <class Field>
double rangeOverProbes(const Field& field, const std::array<double, 3>& cellMin, double cellWidth)
{
  constexpr std::array<double, 3> fractions = { 1. / 6., 1. / 2., 5. / 6. };
  double min = std::numeric_limits<double>::infinity();
  double max = -min;
  for (const double fz : fractions)
  {
    for (const double fy : fractions)
    {
      for (const double fx : fractions)
      {
        const double value =
          field(cellMin[0] + cellWidth * fx, cellMin[1] + cellWidth * fy, cellMin[2] + cellWidth * fz);
        min = std::min(min, value);
        max = std::max(max, value);
      }
    }
  }
  return max - min;
}

} // namespace treeamr

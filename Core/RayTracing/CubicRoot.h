// The first root of a cubic in [0, 1]: Marmitt et al. 2004, "Fast and accurate ray-voxel intersection
// techniques for iso-surface ray tracing". The extrema split the interval into monotone pieces; the first
// piece whose ends differ in sign holds the root. Instead of the paper's repeated linear interpolation the
// bracket is closed by Newton steps that fall back to bisection, so it cannot diverge.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace treeamr
{

/// c[0] + c[1] s + c[2] s^2 + c[3] s^3
using Cubic = std::array<double, 4>;

inline double evaluate(const Cubic& c, double s) noexcept
{
  return ((c[3] * s + c[2]) * s + c[1]) * s + c[0];
}

/// Closes a bracket [a, b] of a monotone piece with values of different sign at its ends.
inline double closeBracket(const Cubic& c, double a, double b, bool negativeAtA) noexcept
{
  double s = 0.5 * (a + b);
  // Bisection alone would need 53 steps for all digits of [0, 1]; Newton ends much earlier.
  for (int i = 0; i < 64; ++i)
  {
    const double f = evaluate(c, s);
    if (f == 0.)
    {
      return s;
    }
    ((f < 0.) == negativeAtA ? a : b) = s;
    const double slope = (3. * c[3] * s + 2. * c[2]) * s + c[1];
    double next = s - f / slope;
    if (!(next > a && next < b))
    {
      next = 0.5 * (a + b);
    }
    if (next == s || next <= a || next >= b)
    {
      return next;
    }
    s = next;
  }
  return s;
}

/// False when the cubic has no root in [0, 1]. Coefficients must be finite.
inline bool firstRoot(const Cubic& c, double& root) noexcept
{
  std::array<double, 4> knots{ 0., 1., 1., 1. };
  int pieces = 1;
  // Extrema: roots of 3 c3 s^2 + 2 c2 s + c1, by the form without cancellation.
  const double discriminant = c[2] * c[2] - 3. * c[3] * c[1];
  if (discriminant > 0.)
  {
    const double q = -(c[2] + std::copysign(std::sqrt(discriminant), c[2]));
    std::array<double, 2> extrema{ q / (3. * c[3]), c[1] / q };
    if (!(extrema[0] < extrema[1]))
    {
      std::swap(extrema[0], extrema[1]);
    }
    for (const double e : extrema)
    {
      if (e > 0. && e < 1.)
      {
        knots[pieces++] = e;
      }
    }
    knots[pieces] = 1.;
  }
  double before = evaluate(c, 0.);
  for (int i = 0; i < pieces; ++i)
  {
    if (before == 0.)
    {
      root = knots[i];
      return true;
    }
    const double after = evaluate(c, knots[i + 1]);
    if ((before < 0.) != (after < 0.) && after != 0.)
    {
      root = closeBracket(c, knots[i], knots[i + 1], before < 0.);
      return true;
    }
    before = after;
  }
  root = 1.;
  return before == 0.;
}

} // namespace treeamr

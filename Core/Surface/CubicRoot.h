// The roots of a cubic in [0, 1]: Marmitt et al. 2004, "Fast and accurate ray-voxel intersection techniques for
// iso-surface ray tracing". The extrema split the interval into monotone pieces; a piece whose ends differ in
// sign holds one root. Instead of the paper's repeated linear interpolation the bracket is closed by Newton
// steps that fall back to bisection, so it cannot diverge.
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

/// Of a root in [0, 1]: below the last digit that counts.
constexpr double negligibleError = 0x1p-54;
/// Of those below products run out of digits.
constexpr double leastSlope = 0x1p-900;
/// Bisection alone would need 53 for all digits of [0, 1]; Newton ends much earlier.
constexpr int mostSteps = 64;

/// Closes a bracket [a, b] of a monotone piece with values of different sign at its ends.
inline double closeBracket(const Cubic& c, double a, double b, double atA, double atB) noexcept
{
  const bool negativeAtA = atA < 0.;
  double s = a + (b - a) * (atA / (atA - atB));
  if (!(s > a && s < b))
  {
    s = 0.5 * (a + b);
  }
  for (int i = 0; i < mostSteps; ++i)
  {
    const double f = evaluate(c, s);
    if (f == 0.)
    {
      return s;
    }
    ((f < 0.) == negativeAtA ? a : b) = s;
    const double slope = (3. * c[3] * s + 2. * c[2]) * s + c[1];
    const double newton = s - f / slope;
    const bool isNewton = newton > a && newton < b;
    const double next = isNewton ? newton : 0.5 * (a + b);
    // A step of Newton leaves the square of its length times half the ratio of the second derivative to the first.
    const double change = next - s;
    const double steep = std::abs(slope);
    const bool isExact =
      change * change * std::abs(3. * c[3] * s + c[2]) <= negligibleError * steep && steep > leastSlope;
    if ((isNewton && isExact) || next == s || next <= a || next >= b)
    {
      return next;
    }
    s = next;
  }
  return s;
}

/// Calls visit(root) for the roots in [0, 1], ascending, until it returns true, and returns whether it did. first,
/// last: what the values at the ends count as, of the signs that the next pieces of a ray, which have cubics of their
/// own, begin and end with: zero is a root. None where the cubic stays above or below zero by more than `slack`.
/// Coefficients must be finite.
template <class Visit>
bool visitRoots(const Cubic& c, double first, double last, double slack, const Visit& visit)
{
  // The cubic lies in the hull of its Bernstein coefficients.
  const double second = c[0] + c[1] * (1. / 3.);
  const double third = c[0] + (2. * c[1] + c[2]) * (1. / 3.);
  if (std::min({ first, second, third, last }) > slack || std::max({ first, second, third, last }) < -slack)
  {
    return false;
  }
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
  double before = first;
  if (before == 0. && visit(0.))
  {
    return true;
  }
  for (int i = 0; i < pieces; ++i)
  {
    const bool isLast = i + 1 == pieces;
    const double after = isLast ? last : evaluate(c, knots[i + 1]);
    if (before != 0. && after != 0. && (before < 0.) != (after < 0.) &&
      visit(closeBracket(c, knots[i], knots[i + 1], before, after)))
    {
      return true;
    }
    if (after == 0. && visit(knots[i + 1]))
    {
      return true;
    }
    before = after;
  }
  return false;
}

/// The same with values at the ends of at most `tolerance` as zero: roots on the seam belong to both pieces.
template <class Visit>
bool visitRoots(const Cubic& c, double tolerance, const Visit& visit)
{
  const auto at = [tolerance](double value) { return std::abs(value) <= tolerance ? 0. : value; };
  return visitRoots(c, at(c[0]), at(evaluate(c, 1.)), tolerance, visit);
}

} // namespace treeamr

// Vectors of three.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace treeamr
{

/// x, y and z of a point, a direction or a normal.
using Vec3 = std::array<double, 3>;

/// By the right-hand rule.
inline Vec3 cross(const Vec3& a, const Vec3& b) noexcept
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

/// The sum of the products, axis by axis.
inline double dot(const Vec3& a, const Vec3& b) noexcept
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Zero stays zero, and what is not finite becomes zero.
inline Vec3 normalized(Vec3 v) noexcept
{
  double square = dot(v, v);
  // Beyond these the squares of lengths that are numbers themselves lose digits or overflow.
  if (!(square > 1e-280 && square < 1e300))
  {
    const double largest = std::max({ std::abs(v[0]), std::abs(v[1]), std::abs(v[2]) });
    for (double& x : v)
    {
      x /= largest;
    }
    square = dot(v, v);
    if (!(square >= 1.))
    {
      return {};
    }
  }
  const double length = std::sqrt(square);
  return { v[0] / length, v[1] / length, v[2] / length };
}

} // namespace treeamr

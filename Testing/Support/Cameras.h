// Matrices of cameras, for tests without VTK.
#pragma once

#include "Geometry/Camera.h"

#include <cmath>
#include <numbers>

namespace treeamr::test
{

inline constexpr Matrix4 identityMatrix{ 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

inline Matrix4 multiply(const Matrix4& a, const Matrix4& b)
{
  Matrix4 m{};
  for (int r = 0; r < 4; ++r)
  {
    for (int c = 0; c < 4; ++c)
    {
      for (int k = 0; k < 4; ++k)
      {
        m[4 * r + c] += a[4 * r + k] * b[4 * k + c];
      }
    }
  }
  return m;
}

inline Vec3 operator-(const Vec3& a, const Vec3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

inline Vec3 unit(const Vec3& v)
{
  const double n = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return { v[0] / n, v[1] / n, v[2] / n };
}

/// Through a point to an end, other than that, from `reach` before the end on.
inline Ray rayThrough(const Vec3& through, const Vec3& end, double reach)
{
  const Vec3 away = unit(through - end);
  return { { end[0] + reach * away[0], end[1] + reach * away[1], end[2] + reach * away[2] },
    { -away[0], -away[1], -away[2] } };
}

/// World to view coordinates, looking from the eye to the target.
inline Matrix4 lookAt(const Vec3& eye, const Vec3& target, const Vec3& upwards = { 0.1, 1., 0.2 })
{
  const Vec3 back = unit(eye - target);
  const Vec3 right = unit(cross(upwards, back));
  const Vec3 up = cross(back, right);
  return { right[0], right[1], right[2], -dot(right, eye), up[0], up[1], up[2], -dot(up, eye), back[0],
    back[1], back[2], -dot(back, eye), 0, 0, 0, 1 };
}

/// OpenGL's frustum with a vertical view angle.
inline Matrix4 perspective(double degrees, double near, double far)
{
  const double f = 1. / std::tan(degrees * std::numbers::pi / 360.);
  return { f, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), 2. * far * near / (near - far), 0, 0,
    -1, 0 };
}

inline Matrix4 parallel(double halfHeight, double near, double far)
{
  return { 1. / halfHeight, 0, 0, 0, 0, 1. / halfHeight, 0, 0, 0, 0, 2. / (near - far),
    (far + near) / (near - far), 0, 0, 0, 1 };
}

} // namespace treeamr::test

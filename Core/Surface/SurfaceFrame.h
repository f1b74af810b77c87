// Points, directions and normals of a surface between data coordinates and the world's.
#pragma once

#include "Geometry/Camera.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeamr
{

inline Vec3 pointAt(const Ray& ray, double t) noexcept
{
  return { ray.origin[0] + t * ray.direction[0], ray.origin[1] + t * ray.direction[1],
    ray.origin[2] + t * ray.direction[2] };
}

inline Vec3 cross(const Vec3& a, const Vec3& b) noexcept
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

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

class SurfaceFrame
{
public:
  /// Of an affine matrix that is not singular.
  explicit SurfaceFrame(const Matrix4& worldFromData) noexcept
    : matrix_(worldFromData)
  {
    const Vec3 x{ matrix_[0], matrix_[1], matrix_[2] };
    const Vec3 y{ matrix_[4], matrix_[5], matrix_[6] };
    const Vec3 z{ matrix_[8], matrix_[9], matrix_[10] };
    cofactors_ = { cross(y, z), cross(z, x), cross(x, y) };
    determinant_ = dot(x, cofactors_[0]);
  }

  Vec3 worldPoint(const Vec3& p) const noexcept
  {
    const Vec3 v = worldVector(p);
    return { v[0] + matrix_[3], v[1] + matrix_[7], v[2] + matrix_[11] };
  }
  Vec3 worldVector(const Vec3& v) const noexcept
  {
    Vec3 w;
    for (int r = 0; r < 3; ++r)
    {
      w[r] = matrix_[4 * r] * v[0] + matrix_[4 * r + 1] * v[1] + matrix_[4 * r + 2] * v[2];
    }
    return w;
  }
  Vec3 dataVector(const Vec3& v) const noexcept
  {
    Vec3 w;
    for (int a = 0; a < 3; ++a)
    {
      w[a] = (cofactors_[0][a] * v[0] + cofactors_[1][a] * v[1] + cofactors_[2][a] * v[2]) / determinant_;
    }
    return w;
  }
  /// The unit normal in the world of a gradient in data coordinates, turned towards `side`; `side` itself where
  /// the gradient vanishes. Gradients transform by the inverse transpose, here up to the determinant, whose sign
  /// a normal without a side does not need.
  Vec3 worldNormal(const Vec3& gradient, const Vec3& side) const noexcept
  {
    const Vec3 n = normalized(
      { dot(cofactors_[0], gradient), dot(cofactors_[1], gradient), dot(cofactors_[2], gradient) });
    if (n == Vec3{})
    {
      return side;
    }
    return dot(n, side) < 0. ? Vec3{ -n[0], -n[1], -n[2] } : n;
  }
  /// The unit normal in the world to shade a hit by, on the side of its gradient that is turned towards the eye. Where
  /// that would turn it away from the eye, it lies across the line of sight: turned over, it would take its light from
  /// behind the surface.
  Vec3 shadingNormal(
    const Vec3& gradient, const std::array<float, 3>& normal, const Vec3& toEye) const noexcept
  {
    const Vec3 side = worldNormal(gradient, toEye);
    const Vec3 n = worldNormal({ normal[0], normal[1], normal[2] }, side);
    const double towards = dot(n, toEye);
    if (towards >= 0.)
    {
      return n;
    }
    const Vec3 across =
      normalized({ n[0] - towards * toEye[0], n[1] - towards * toEye[1], n[2] - towards * toEye[2] });
    return across == Vec3{} ? side : across;
  }

private:
  Matrix4 matrix_;
  std::array<Vec3, 3> cofactors_; // rows
  double determinant_;
};

} // namespace treeamr

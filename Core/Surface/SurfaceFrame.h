// Points, directions and normals of a surface between data coordinates and the world's.
#pragma once

#include "Geometry/Camera.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace treeamr
{

/// Of a prop's matrix.
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

  /// Rows of the matrix that takes gradients to normals, up to the determinant.
  const std::array<Vec3, 3>& cofactors() const noexcept { return cofactors_; }
  /// Of a point in data coordinates.
  Vec3 worldPoint(const Vec3& p) const noexcept
  {
    const Vec3 v = worldVector(p);
    return { v[0] + matrix_[3], v[1] + matrix_[7], v[2] + matrix_[11] };
  }
  /// Of a difference of such points.
  Vec3 worldVector(const Vec3& v) const noexcept
  {
    Vec3 w;
    for (int r = 0; r < 3; ++r)
    {
      w[r] = matrix_[4 * r] * v[0] + matrix_[4 * r + 1] * v[1] + matrix_[4 * r + 2] * v[2];
    }
    return w;
  }
  /// The inverse of worldVector().
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
    const Vec3 n = this->transformed(gradient);
    if (n == Vec3{})
    {
      return side;
    }
    return dot(n, side) < 0. ? Vec3{ -n[0], -n[1], -n[2] } : n;
  }
  /// The unit normal in the world to shade a hit by: towards higher values, or lower ones, as the gradient that is
  /// turned towards the eye. Where that would turn it away from the eye, it lies across the line of sight: turned over,
  /// it would take its light from behind the surface, and change abruptly.
  Vec3 shadingNormal(
    const Vec3& gradient, const std::array<float, 3>& normal, const Vec3& toEye) const noexcept
  {
    const Vec3 up = this->transformed(gradient);
    const bool isAway = dot(up, toEye) < 0.;
    const auto turned = [&](const Vec3& v) { return isAway ? Vec3{ -v[0], -v[1], -v[2] } : v; };
    const Vec3 side = up == Vec3{} ? toEye : turned(up);
    const Vec3 n = turned(this->transformed({ normal[0], normal[1], normal[2] }));
    const double towards = dot(n, toEye);
    if (towards > 0.)
    {
      return n;
    }
    const Vec3 across =
      normalized({ n[0] - towards * toEye[0], n[1] - towards * toEye[1], n[2] - towards * toEye[2] });
    return across == Vec3{} ? side : across;
  }

private:
  /// To unit length in the world; 0 stays.
  Vec3 transformed(const Vec3& gradient) const noexcept
  {
    return normalized(
      { dot(cofactors_[0], gradient), dot(cofactors_[1], gradient), dot(cofactors_[2], gradient) });
  }

  Matrix4 matrix_;
  std::array<Vec3, 3> cofactors_; // rows
  double determinant_;
};

} // namespace treeamr

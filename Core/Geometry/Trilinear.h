// Trilinear interpolation between the corners of a box, numbered as in Octant.h. Places count from 0 to 1 along each
// axis of the box.
#pragma once

#include "Geometry/Octant.h"
#include "Geometry/Vec3.h"

#include <array>

namespace treeamr
{

/// Values at the corners of a box.
using Corners = std::array<double, 8>;

/// first: the lowest corner's value in an array with these strides along the axes.
template <class T>
Corners cornersOf(const T* first, const std::array<int, 3>& stride) noexcept
{
  Corners values;
  for (int c = 0; c < 8; ++c)
  {
    values[c] = first[cornerOffset(c, stride)];
  }
  return values;
}

inline double trilinear(const Corners& v, const Vec3& p) noexcept
{
  const auto along = [](double a, double b, double t) { return a + t * (b - a); };
  return along(along(along(v[0], v[1], p[0]), along(v[2], v[3], p[0]), p[1]),
    along(along(v[4], v[5], p[0]), along(v[6], v[7], p[0]), p[1]), p[2]);
}

/// The derivative along an axis, per width of the box. first, stride: as cornersOf(). The same all along that axis.
template <class T>
double slopeAlong(int axis, const T* first, const std::array<int, 3>& stride, const Vec3& p) noexcept
{
  const int b = (axis + 1) % 3;
  const int c = (axis + 2) % 3;
  const auto difference = [&](int i) { return static_cast<double>(first[i + stride[axis]]) - first[i]; };
  const auto alongB = [&](int i) {
    const double low = difference(i);
    return low + p[b] * (difference(i + stride[b]) - low);
  };
  const double low = alongB(0);
  return low + p[c] * (alongB(stride[c]) - low);
}

/// Per width of the box.
inline Vec3 trilinearGradient(const Corners& v, const Vec3& p) noexcept
{
  constexpr std::array<int, 3> stride{ 1, 2, 4 };
  return { slopeAlong(0, v.data(), stride, p), slopeAlong(1, v.data(), stride, p),
    slopeAlong(2, v.data(), stride, p) };
}

/// The same where corners may have no value: those that have one share the weights of the others.
class CornerSum
{
public:
  explicit CornerSum(const Vec3& p) noexcept
    : p_(p)
  {
  }
  void add(int corner, double value) noexcept
  {
    Vec3 w;
    Vec3 d;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = sideOf(corner, a) != 0;
      w[a] = upper ? p_[a] : 1. - p_[a];
      d[a] = upper ? 1. : -1.;
    }
    addTerm(value, w[0] * w[1] * w[2], { d[0] * w[1] * w[2], w[0] * d[1] * w[2], w[0] * w[1] * d[2] });
  }
  double value() const noexcept { return sum_ / weight_; }
  /// Per width of the box.
  Vec3 gradient() const noexcept
  {
    Vec3 g;
    for (int a = 0; a < 3; ++a)
    {
      g[a] = (dSum_[a] - value() * dWeight_[a]) / weight_;
    }
    return g;
  }

private:
  void addTerm(double value, double weight, const Vec3& dWeight) noexcept
  {
    sum_ += weight * value;
    weight_ += weight;
    for (int a = 0; a < 3; ++a)
    {
      dSum_[a] += dWeight[a] * value;
      dWeight_[a] += dWeight[a];
    }
  }
  Vec3 p_;
  double sum_ = 0.;
  double weight_ = 0.;
  Vec3 dSum_{};
  Vec3 dWeight_{};
};

} // namespace treeamr

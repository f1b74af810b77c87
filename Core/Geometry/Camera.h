// The rays of an image, from the matrix that takes data coordinates to clip space.
#pragma once

#include "Geometry/Vec3.h"

#include <array>
#include <cmath>

namespace treeamr
{

/// Row-major, applied to column vectors.
using Matrix4 = std::array<double, 16>;

/// A ray in data coordinates; t counts world length from the origin.
struct Ray
{
  Vec3 origin;    // where t is 0
  Vec3 direction; // of unit length in the world, where a Camera made the ray
};

/// In the ray's coordinates.
inline Vec3 pointAt(const Ray& ray, double t) noexcept
{
  return { ray.origin[0] + t * ray.direction[0], ray.origin[1] + t * ray.direction[1],
    ray.origin[2] + t * ray.direction[2] };
}

/// All rays of a perspective camera: linear in the pixel. A point is eye + t * direction, t not a length.
struct PixelFan
{
  Vec3 direction; // of pixel (0, 0), in data coordinates; of unit world length in the image's middle
  Vec3 perX;      // its change from pixel to pixel
  Vec3 perY;      // and from row to row
  ///@{
  /// 1 / t at window depth z: inverseT + x * inverseTPerX + y * inverseTPerY + z * inverseTPerDepth.
  double inverseT;
  double inverseTPerX;
  double inverseTPerY;
  double inverseTPerDepth;
  ///@}
};

/// Perspective or parallel, by any projection that a matrix can be: off-axis, mirrored, of a sheared prop.
class Camera
{
public:
  /// clipFromData: data coordinates to clip space, NDC z from -1 (near) to 1 (far).
  /// worldFromData: the prop's matrix; only lengths along rays are taken from it.
  /// width x height pixels; pixel (0, 0) is at the lower left. Throws Error for a singular matrix.
  Camera(const Matrix4& clipFromData, const Matrix4& worldFromData, int width, int height);
  /// Lengths along rays are those of data coordinates.
  Camera(const Matrix4& clipFromData, int width, int height);

  ///@{
  /// In pixels.
  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  ///@}
  /// Whether all rays start from one point, the eye.
  bool isPerspective() const noexcept { return perspective_; }
  /// Projection centre in data coordinates; perspective only.
  const Vec3& eye() const noexcept { return eye_; }

  /// The ray through the centre of a pixel. Its origin is the eye, or a point of the near plane.
  Ray ray(int x, int y) const noexcept;
  /// Perspective only.
  PixelFan fan() const noexcept;
  ///@{
  /// The constructor's matrices, and the inverse of the first.
  const Matrix4& worldFromData() const noexcept { return worldFromData_; }
  const Matrix4& clipFromData() const noexcept { return clipFromData_; }
  const Matrix4& dataFromClip() const noexcept { return dataFromClip_; }
  ///@}
  /// The sign that turns directions from the eye to points in front of it; perspective only.
  double forward() const noexcept { return forward_; }
  /// t at a window depth in [0, 1] (0 = near plane) along the ray.
  double tFromDepth(const Ray& ray, double depth) const noexcept;
  /// Whether a box lies between the near and the far plane, touching neither.
  bool seesAllDepthsOf(const Vec3& boxMin, const Vec3& boxMax) const noexcept;
  /// Window depth of the point at t.
  double depthFromT(const Ray& ray, double t) const noexcept;
  /// Of the octants that three planes, across one axis each, part a box into the one to visit first: octant i ^ this
  /// is the i-th in an order in which, for every ray of the camera, an octant follows those that are nearer along each
  /// axis. direction: of any ray in parallel projection.
  int nearestOctant(const Vec3& planes, const Vec3& direction) const noexcept
  {
    int nearest = 0;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = perspective_ ? eye_[a] >= planes[a] : direction[a] < 0.;
      nearest |= upper << a;
    }
    return nearest;
  }
  /// The change of a plane's window depth from the left to the right and from the lower to the upper edge of the
  /// image. point, normal: of the plane, in data coordinates; not finite for a plane through the eye.
  std::array<double, 2> depthSlope(const Vec3& point, const Vec3& normal) const noexcept;

private:
  double worldLength(const Vec3& direction) const noexcept;
  Vec3 unproject(double xNdc, double yNdc, double zNdc) const noexcept;
  Matrix4 clipFromData_;
  Matrix4 dataFromClip_;
  Matrix4 worldFromData_;
  int width_;
  int height_;
  bool perspective_ = false;
  Vec3 eye_{};
  double forward_ = 1.;
};

inline Ray Camera::ray(int px, int py) const noexcept
{
  const double x = 2. * (px + 0.5) / width_ - 1.;
  const double y = 2. * (py + 0.5) / height_ - 1.;
  const Matrix4& m = dataFromClip_;
  Ray ray;
  if (perspective_)
  {
    // The direction is the pixel's point at infinity; a difference of two unprojected points would lose
    // digits far from the coordinate origin.
    ray.origin = eye_;
    const double w = m[12] * x + m[13] * y + m[15];
    for (int a = 0; a < 3; ++a)
    {
      ray.direction[a] = forward_ * (m[4 * a] * x + m[4 * a + 1] * y + m[4 * a + 3] - eye_[a] * w);
    }
  }
  else
  {
    ray.origin = unproject(x, y, -1.);
    for (int a = 0; a < 3; ++a)
    {
      ray.direction[a] = m[4 * a + 2] / m[15];
    }
  }
  const double scale = 1. / worldLength(ray.direction);
  for (double& d : ray.direction)
  {
    d *= scale;
  }
  return ray;
}

inline double Camera::tFromDepth(const Ray& ray, double depth) const noexcept
{
  // Points of one depth form the plane (row z - NDC z * row w) . p = 0.
  const Matrix4& m = clipFromData_;
  const double z = 2. * depth - 1.;
  double atOrigin = m[11] - z * m[15];
  double along = 0.;
  for (int a = 0; a < 3; ++a)
  {
    const double normal = m[8 + a] - z * m[12 + a];
    atOrigin += normal * ray.origin[a];
    along += normal * ray.direction[a];
  }
  return -atOrigin / along;
}

inline double Camera::worldLength(const Vec3& direction) const noexcept
{
  double squared = 0.;
  for (int r = 0; r < 3; ++r)
  {
    double d = 0.;
    for (int c = 0; c < 3; ++c)
    {
      d += worldFromData_[4 * r + c] * direction[c];
    }
    squared += d * d;
  }
  return std::sqrt(squared);
}

} // namespace treeamr

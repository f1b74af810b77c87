#include "Geometry/Camera.h"

#include "Error.h"

#include <cmath>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

/// Gauss-Jordan elimination with row pivots.
Matrix4 inverse(const Matrix4& m)
{
  double a[4][8] = {};
  for (int r = 0; r < 4; ++r)
  {
    for (int c = 0; c < 4; ++c)
    {
      a[r][c] = m[4 * r + c];
    }
    a[r][4 + r] = 1.;
  }
  for (int c = 0; c < 4; ++c)
  {
    int pivot = c;
    for (int r = c + 1; r < 4; ++r)
    {
      pivot = std::abs(a[r][c]) > std::abs(a[pivot][c]) ? r : pivot;
    }
    if (!(std::abs(a[pivot][c]) > 0.) || !std::isfinite(a[pivot][c]))
    {
      throw Error("camera: the matrix from data to clip coordinates is singular or not finite");
    }
    std::swap(a[c], a[pivot]);
    const double scale = 1. / a[c][c];
    for (double& x : a[c])
    {
      x *= scale;
    }
    for (int r = 0; r < 4; ++r)
    {
      const double factor = a[r][c];
      for (int k = 0; r != c && k < 8; ++k)
      {
        a[r][k] -= factor * a[c][k];
      }
    }
  }
  Matrix4 out;
  for (int r = 0; r < 4; ++r)
  {
    for (int c = 0; c < 4; ++c)
    {
      out[4 * r + c] = a[r][4 + c];
    }
  }
  return out;
}

} // namespace

Camera::Camera(const Matrix4& clipFromData, const Matrix4& worldFromData, int width, int height)
  : clipFromData_(clipFromData)
  , dataFromClip_(inverse(clipFromData))
  , worldFromData_(worldFromData)
  , width_(width)
  , height_(height)
{
  if (width < 1 || height < 1)
  {
    throw Error("camera: an image of " + std::to_string(width) + " x " + std::to_string(height) +
      " pixels, allowed are positive sizes");
  }
  // Affine matrices keep w constant: parallel projection.
  perspective_ = clipFromData[12] != 0. || clipFromData[13] != 0. || clipFromData[14] != 0.;
  const Matrix4& m = dataFromClip_;
  if (perspective_)
  {
    // The point whose clip x, y and w vanish.
    for (int a = 0; a < 3; ++a)
    {
      eye_[a] = m[4 * a + 2] / m[14];
    }
    const Vec3 near = unproject(0., 0., -1.);
    const Vec3 far = unproject(0., 0., 1.);
    double along = 0.;
    for (int a = 0; a < 3; ++a)
    {
      along += (far[a] - near[a]) * (m[4 * a + 3] - eye_[a] * m[15]);
    }
    forward_ = along < 0. ? -1. : 1.;
  }
}

Camera::Camera(const Matrix4& clipFromData, int width, int height)
  : Camera(clipFromData, { 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1. }, width, height)
{
}

Vec3 Camera::unproject(double x, double y, double z) const noexcept
{
  const Matrix4& m = dataFromClip_;
  const double w = m[12] * x + m[13] * y + m[14] * z + m[15];
  Vec3 p;
  for (int a = 0; a < 3; ++a)
  {
    p[a] = (m[4 * a] * x + m[4 * a + 1] * y + m[4 * a + 2] * z + m[4 * a + 3]) / w;
  }
  return p;
}

PixelFan Camera::fan() const noexcept
{
  // The homogeneous point of NDC (x, y, z) less the eye times its w: z drops out, because x, y and w of the eye
  // vanish in clip space.
  const Matrix4& m = dataFromClip_;
  const double x0 = 1. / width_ - 1.;
  const double y0 = 1. / height_ - 1.;
  const double perX = 2. / width_;
  const double perY = 2. / height_;
  PixelFan fan;
  Vec3 central;
  for (int a = 0; a < 3; ++a)
  {
    const double alongX = m[4 * a] - eye_[a] * m[12];
    const double alongY = m[4 * a + 1] - eye_[a] * m[13];
    central[a] = m[4 * a + 3] - eye_[a] * m[15];
    fan.direction[a] = central[a] + x0 * alongX + y0 * alongY;
    fan.perX[a] = perX * alongX;
    fan.perY[a] = perY * alongY;
  }
  const double scale = forward_ / worldLength(central);
  for (int a = 0; a < 3; ++a)
  {
    fan.direction[a] *= scale;
    fan.perX[a] *= scale;
    fan.perY[a] *= scale;
  }
  fan.inverseT = scale * (m[15] + x0 * m[12] + y0 * m[13] - m[14]);
  fan.inverseTPerX = scale * perX * m[12];
  fan.inverseTPerY = scale * perY * m[13];
  fan.inverseTPerDepth = scale * 2. * m[14];
  return fan;
}

bool Camera::seesAllDepthsOf(const Vec3& boxMin, const Vec3& boxMax) const noexcept
{
  const Matrix4& m = clipFromData_;
  for (int corner = 0; corner < 8; ++corner)
  {
    double z = m[11];
    double w = m[15];
    for (int a = 0; a < 3; ++a)
    {
      const double p = corner >> a & 1 ? boxMax[a] : boxMin[a];
      z += m[8 + a] * p;
      w += m[12 + a] * p;
    }
    constexpr double margin = 1e-9;
    if (!(std::abs(z / w) < 1. - margin)) // behind the eye, it is above 1
    {
      return false;
    }
  }
  return true;
}

double Camera::depthFromT(const Ray& ray, double t) const noexcept
{
  const Matrix4& m = clipFromData_;
  double z = m[11];
  double w = m[15];
  for (int a = 0; a < 3; ++a)
  {
    const double p = ray.origin[a] + t * ray.direction[a];
    z += m[8 + a] * p;
    w += m[12 + a] * p;
  }
  return 0.5 * z / w + 0.5;
}

std::array<double, 2> Camera::depthSlope(const Vec3& point, const Vec3& normal) const noexcept
{
  // The plane as a row vector, taken to clip space: its product with points of the plane vanishes.
  const Matrix4& m = dataFromClip_;
  const double offset = -(normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2]);
  std::array<double, 3> plane;
  for (int c = 0; c < 3; ++c)
  {
    plane[c] = normal[0] * m[c] + normal[1] * m[4 + c] + normal[2] * m[8 + c] + offset * m[12 + c];
  }
  // Both depths from 0 to 1 and images from edge to edge are half of clip space's.
  return { -plane[0] / plane[2], -plane[1] / plane[2] };
}

} // namespace treeamr

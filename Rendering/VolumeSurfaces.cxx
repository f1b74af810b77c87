#include "VolumeSurfaces.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <cmath>

namespace treeamr
{

namespace
{

constexpr std::size_t pixelsPerTask = 4096;

Vec3 normalized(const Vec3& v, const Vec3& otherwise)
{
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return length > 0. ? Vec3{ v[0] / length, v[1] / length, v[2] / length } : otherwise;
}

/// A data point (w = 1) or vector (w = 0) in world coordinates.
Vec3 toWorld(const Matrix4& m, const Vec3& v, double w)
{
  Vec3 world;
  for (int r = 0; r < 3; ++r)
  {
    world[r] = m[4 * r] * v[0] + m[4 * r + 1] * v[1] + m[4 * r + 2] * v[2] + m[4 * r + 3] * w;
  }
  return world;
}

/// A gradient in world coordinates, but for its length and sign: by the matrix of cofactors.
Vec3 gradientToWorld(const Matrix4& m, const Vec3& gradient)
{
  Vec3 world{};
  for (int r = 0; r < 3; ++r)
  {
    const double* p = m.data() + 4 * ((r + 1) % 3);
    const double* q = m.data() + 4 * ((r + 2) % 3);
    for (int c = 0; c < 3; ++c)
    {
      const int d = (c + 1) % 3;
      const int e = (c + 2) % 3;
      world[r] += (p[d] * q[e] - p[e] * q[d]) * gradient[c];
    }
  }
  return world;
}

} // namespace

bool VolumeSurfaces::build(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues)
{
  if (engine_ && field_ == field && isovalues_ == isovalues)
  {
    return false;
  }
  this->release(); // before the new ones are allocated
  engine_ = std::make_unique<Isosurface>(field, isovalues);
  field_ = field;
  isovalues_ = isovalues;
  return true;
}

void VolumeSurfaces::release()
{
  *this = VolumeSurfaces();
}

void VolumeSurfaces::trace(const Matrix4& clipFromData, const Matrix4& worldFromData, int width, int height)
{
  if (camera_ && camera_->width() == width && camera_->height() == height && clipFromData_ == clipFromData &&
    camera_->worldFromData() == worldFromData)
  {
    return;
  }
  camera_.reset();
  const Camera camera(clipFromData, worldFromData, width, height);
  engine_->render(camera, SurfaceLayers::All, hits_);
  clipFromData_ = clipFromData;
  camera_ = camera;
}

void VolumeSurfaces::light(const std::vector<SurfaceMaterial>& materials, const std::vector<Light>& lights)
{
  rgba_.resize(hits_.hits.size());
  const Matrix4& worldFromData = camera_->worldFromData();
  const auto width = static_cast<std::size_t>(camera_->width());
  const tbb::blocked_range<std::size_t> pixels(0, hits_.first.size() - 1, pixelsPerTask);
  tbb::parallel_for(pixels, [&](const auto& range) {
    for (std::size_t pixel = range.begin(); pixel < range.end(); ++pixel)
    {
      if (hits_.first[pixel] == hits_.first[pixel + 1])
      {
        continue;
      }
      const Ray ray = camera_->ray(static_cast<int>(pixel % width), static_cast<int>(pixel / width));
      const Vec3 away = toWorld(worldFromData, ray.direction, 0.);
      const Vec3 toEye = normalized({ -away[0], -away[1], -away[2] }, {});
      for (std::size_t i = hits_.first[pixel]; i < hits_.first[pixel + 1]; ++i)
      {
        const SurfaceHit& hit = hits_.hits[i];
        Vec3 point;
        for (int a = 0; a < 3; ++a)
        {
          point[a] = ray.origin[a] + hit.t * ray.direction[a];
        }
        const SurfaceMaterial& surface = materials[hit.surface];
        const std::array<float, 3> rgb = shade(surface.material, lights, toWorld(worldFromData, point, 1.),
          normalized(gradientToWorld(worldFromData, hit.gradient), toEye), toEye);
        rgba_[i] = { rgb[0], rgb[1], rgb[2], surface.opacity };
      }
    }
  });
}

} // namespace treeamr

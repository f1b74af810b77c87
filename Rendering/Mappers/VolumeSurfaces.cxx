#include "VolumeSurfaces.h"

#include "Surface/SurfaceFrame.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace treeamr
{

namespace
{

constexpr std::size_t pixelsPerTask = 4096;

} // namespace

bool VolumeSurfaces::set(const std::shared_ptr<const Field>& field, const std::vector<double>& isovalues)
{
  if (!levels_.set(field, isovalues))
  {
    return false;
  }
  // Before there are others.
  engine_.reset();
  camera_.reset();
  return true;
}

void VolumeSurfaces::release()
{
  *this = VolumeSurfaces();
}

void VolumeSurfaces::trace(const Matrix4& clipFromData, int width, int height, double levelOfDetail)
{
  const Camera camera(clipFromData, width, height);
  const std::shared_ptr<const Isosurface>& engine =
    levelOfDetail > 0. ? levels_.ofDetail(camera, levelOfDetail) : levels_.inFull();
  if (camera_ && engine_ == engine && camera_->width() == width && camera_->height() == height &&
    clipFromData_ == clipFromData)
  {
    return;
  }
  camera_.reset();
  engine_ = engine;
  engine_->startFrame();
  engine_->render(camera, SurfaceLayers::All, hits_);
  clipFromData_ = clipFromData;
  camera_ = camera;
}

void VolumeSurfaces::light(const std::vector<SurfaceMaterial>& materials, const std::vector<Light>& lights,
  const Matrix4& viewFromData)
{
  lit_.resize(hits_.hits.size());
  const SurfaceFrame frame(viewFromData);
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
      const Vec3 away = normalized(frame.worldVector(ray.direction));
      const Vec3 side{ -away[0], -away[1], -away[2] };
      for (std::size_t i = hits_.first[pixel]; i < hits_.first[pixel + 1]; ++i)
      {
        const SurfaceHit& hit = hits_.hits[i];
        const SurfaceMaterial& surface = materials[hit.surface];
        const Vec3 point = frame.worldPoint(pointAt(ray, hit.t));
        const std::array<float, 3> rgb =
          shade(surface.material, lights, point, frame.shadingNormal(hit.gradient, hit.normal, side),
            normalized({ -point[0], -point[1], -point[2] }));
        lit_[i] = { hit.t, { rgb[0], rgb[1], rgb[2], surface.opacity } };
      }
    }
  });
}

} // namespace treeamr

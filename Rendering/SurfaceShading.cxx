#include "SurfaceShading.h"

#include "Interpolation/Sampler.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

constexpr std::size_t pixelsPerTask = 4096;

template <class Body>
void forEachPixel(std::size_t pixels, const Body& body)
{
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pixels, pixelsPerTask), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
    {
      body(i);
    }
  });
}

Ray rayOf(const Camera& camera, std::size_t pixel)
{
  return camera.ray(static_cast<int>(pixel % camera.width()), static_cast<int>(pixel / camera.width()));
}

Vec3 pointAt(const Ray& ray, double t)
{
  return { ray.origin[0] + t * ray.direction[0], ray.origin[1] + t * ray.direction[1],
    ray.origin[2] + t * ray.direction[2] };
}

/// Calls body(pixel, hit, index of the hit) for the nearest hit of every pixel that has one.
template <class Body>
void forEachNearest(const HitImage& hits, const Body& body)
{
  forEachPixel(hits.first.size() - 1, [&](std::size_t pixel) {
    const std::size_t first = hits.first[pixel];
    if (first < hits.first[pixel + 1])
    {
      body(pixel, hits.hits[first], first);
    }
  });
}

Vec3 transformPoint(const Matrix4& m, const Vec3& p)
{
  Vec3 q;
  for (int r = 0; r < 3; ++r)
  {
    q[r] = m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3];
  }
  return q;
}

Vec3 transformVector(const Matrix4& m, const Vec3& v)
{
  Vec3 w;
  for (int r = 0; r < 3; ++r)
  {
    w[r] = m[4 * r] * v[0] + m[4 * r + 1] * v[1] + m[4 * r + 2] * v[2];
  }
  return w;
}

Vec3 cross(const Vec3& a, const Vec3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

double dot(const Vec3& a, const Vec3& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vec3 normalized(const Vec3& v)
{
  const double length = std::sqrt(dot(v, v));
  return length > 0. ? Vec3{ v[0] / length, v[1] / length, v[2] / length } : Vec3{};
}

/// Gradients transform by the inverse transpose; its rows are the cross products of the matrix's rows, up to
/// the determinant, whose sign a normal without a side does not need.
class GradientTransform
{
public:
  explicit GradientTransform(const Matrix4& m)
  {
    const Vec3 x{ m[0], m[1], m[2] };
    const Vec3 y{ m[4], m[5], m[6] };
    const Vec3 z{ m[8], m[9], m[10] };
    rows_ = { cross(y, z), cross(z, x), cross(x, y) };
  }
  /// The unit normal, turned towards `side`; `side` itself where the gradient vanishes.
  Vec3 normal(const Vec3& gradient, const Vec3& side) const
  {
    Vec3 n = normalized({ dot(rows_[0], gradient), dot(rows_[1], gradient), dot(rows_[2], gradient) });
    const double towards = dot(n, side);
    if (n == Vec3{})
    {
      return side;
    }
    return towards < 0. ? Vec3{ -n[0], -n[1], -n[2] } : n;
  }

private:
  std::array<Vec3, 3> rows_;
};

} // namespace

std::vector<std::size_t> pixelsOfHits(const HitImage& hits)
{
  std::vector<std::size_t> pixels(hits.hits.size());
  forEachPixel(hits.first.size() - 1, [&](std::size_t pixel) {
    for (std::size_t i = hits.first[pixel]; i < hits.first[pixel + 1]; ++i)
    {
      pixels[i] = pixel;
    }
  });
  return pixels;
}

std::vector<float> valuesAtHits(
  const std::shared_ptr<const Field>& field, const Camera& camera, const HitImage& hits)
{
  const std::unique_ptr<Sampler> sampler = Sampler::create(InterpolationMethod::GTI, field);
  const Bounds domain = field->octree().grid().bounds();
  const std::vector<std::size_t> pixels = pixelsOfHits(hits);
  std::vector<float> values(pixels.size(), std::numeric_limits<float>::quiet_NaN());
  forEachPixel(pixels.size(), [&](std::size_t i) {
    Vec3 point = pointAt(rayOf(camera, pixels[i]), hits.hits[i].t);
    for (int a = 0; a < 3; ++a)
    {
      // A hit on the domain's surface may be rounded to its outside.
      point[a] = std::clamp(point[a], domain.min[a], domain.max[a]);
    }
    FieldSample sample;
    if (sampler->sample(point, sample))
    {
      values[i] = static_cast<float>(sample.value);
    }
  });
  return values;
}

void shadeHits(const HitImage& hits, const Camera& camera, const Matrix4& worldFromData,
  const SurfaceAppearance& appearance, const unsigned char* colors, vtkTreeAMRSurfaceImage& image)
{
  const GradientTransform gradientTransform(worldFromData);
  image.Depth.assign(hits.first.size() - 1, 1.f);
  image.RGBA.assign(4 * image.Depth.size(), 0.f);
  forEachNearest(hits, [&](std::size_t pixel, const SurfaceHit& hit, std::size_t index) {
    const Ray ray = rayOf(camera, pixel);
    const Vec3 away = normalized(transformVector(worldFromData, ray.direction));
    const Vec3 toEye{ -away[0], -away[1], -away[2] };
    Material material = appearance.material;
    if (colors)
    {
      for (int c = 0; c < 3; ++c)
      {
        const float channel = colors[4 * index + c] / 255.f;
        material.ambient[c] = appearance.ambientOfColors * channel;
        material.diffuse[c] = appearance.diffuseOfColors * channel;
      }
    }
    const std::array<float, 3> rgb =
      shade(material, appearance.lights, transformPoint(worldFromData, pointAt(ray, hit.t)),
        gradientTransform.normal(hit.gradient, toEye), toEye);
    std::copy(rgb.begin(), rgb.end(), &image.RGBA[4 * pixel]);
    image.RGBA[4 * pixel + 3] = appearance.opacity;
    image.Depth[pixel] = static_cast<float>(camera.depthFromT(ray, hit.t));
  });
}

void fillHits(
  const HitImage& hits, const Camera& camera, const HitColor& color, vtkTreeAMRSurfaceImage& image)
{
  image.Depth.assign(hits.first.size() - 1, 1.f);
  image.RGBA.assign(4 * image.Depth.size(), 0.f);
  forEachNearest(hits, [&](std::size_t pixel, const SurfaceHit& hit, std::size_t) {
    const std::array<float, 3> rgb = color(hit);
    std::copy(rgb.begin(), rgb.end(), &image.RGBA[4 * pixel]);
    image.RGBA[4 * pixel + 3] = 1.f;
    image.Depth[pixel] = static_cast<float>(camera.depthFromT(rayOf(camera, pixel), hit.t));
  });
}

void placeHits(
  const HitImage& hits, const Camera& camera, const Matrix4& viewFromData, vtkTreeAMRSurfaceImage& image)
{
  const GradientTransform gradientTransform(viewFromData);
  image.Position.assign(3 * (hits.first.size() - 1), 0.f);
  image.Normal.assign(image.Position.size(), 0.f);
  forEachNearest(hits, [&](std::size_t pixel, const SurfaceHit& hit, std::size_t) {
    const Vec3 position = transformPoint(viewFromData, pointAt(rayOf(camera, pixel), hit.t));
    // The eye is at the origin and looks along -z, in parallel projection from infinity.
    const Vec3 normal = gradientTransform.normal(hit.gradient, { 0., 0., 1. });
    std::copy(position.begin(), position.end(), &image.Position[3 * pixel]);
    std::copy(normal.begin(), normal.end(), &image.Normal[3 * pixel]);
  });
}

} // namespace treeamr

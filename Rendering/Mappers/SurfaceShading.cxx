#include "SurfaceShading.h"

#include "Interpolation/Sampler.h"
#include "Surface/SurfaceFrame.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

template <class Body>
void forEach(std::size_t count, const Body& body)
{
  constexpr std::size_t perTask = 4096;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, perTask), [&](const auto& range) {
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

/// Calls body(index of the hit, its pixel's ray) for all hits.
template <class Body>
void forEachHit(const HitImage& hits, const Camera& camera, const Body& body)
{
  forEach(hits.first.size() - 1, [&](std::size_t pixel) {
    if (hits.first[pixel] < hits.first[pixel + 1])
    {
      const Ray ray = rayOf(camera, pixel);
      for (std::size_t i = hits.first[pixel]; i < hits.first[pixel + 1]; ++i)
      {
        body(i, ray);
      }
    }
  });
}

std::size_t filledRows(std::size_t count)
{
  constexpr std::size_t columns = vtkTreeAMRSurfaceImage::Columns;
  return (count + columns - 1) / columns * columns;
}

/// The tiles to draw, from the runs.
void arrangeTiles(const Camera& camera, vtkTreeAMRSurfaceImage& image)
{
  constexpr int size = vtkTreeAMRSurfaceImage::TileSize;
  const int columns = (camera.width() + size - 1) / size;
  const int rows = (camera.height() + size - 1) / size;
  std::vector<float> layers(static_cast<std::size_t>(columns) * rows); // most points of a pixel
  for (std::size_t pixel = 0; 3 * pixel < image.Runs.size(); ++pixel)
  {
    const std::size_t tile = pixel / camera.width() / size * columns + pixel % camera.width() / size;
    layers[tile] = std::max(layers[tile], image.Runs[3 * pixel + 2]);
  }
  image.Tiles.clear();
  for (float layer = *std::max_element(layers.begin(), layers.end()) - 1.f; layer >= 0.f; --layer)
  {
    for (std::size_t tile = 0; tile < layers.size(); ++tile)
    {
      if (layer < layers[tile])
      {
        image.Tiles.insert(image.Tiles.end(),
          { static_cast<float>(tile % columns), static_cast<float>(tile / columns), layer });
      }
    }
  }
  image.NumberOfTiles = static_cast<int>(image.Tiles.size() / 3);
  image.Tiles.resize(3 * filledRows(image.NumberOfTiles));
}

/// Makes room for the points and says where they lie.
void arrangePoints(const HitImage& hits, const Camera& camera, vtkTreeAMRSurfaceImage& image)
{
  constexpr std::size_t columns = vtkTreeAMRSurfaceImage::Columns;
  image.Depth.resize(filledRows(hits.hits.size()));
  image.RGBA.resize(4 * image.Depth.size());
  image.Runs.resize(3 * (hits.first.size() - 1));
  forEach(hits.first.size() - 1, [&](std::size_t pixel) {
    const std::size_t first = hits.first[pixel];
    image.Runs[3 * pixel] = static_cast<float>(first % columns);
    image.Runs[3 * pixel + 1] = static_cast<float>(first / columns);
    image.Runs[3 * pixel + 2] = static_cast<float>(hits.first[pixel + 1] - first);
  });
  arrangeTiles(camera, image);
}

} // namespace

void valuesAtHits(const std::shared_ptr<const Field>& field, const Camera& camera, const HitImage& hits,
  std::size_t stride, float* values)
{
  const std::unique_ptr<Sampler> sampler = Sampler::create(InterpolationMethod::GTI, field);
  const Bounds domain = field->octree().grid().bounds();
  forEachHit(hits, camera, [&](std::size_t i, const Ray& ray) {
    Vec3 point = pointAt(ray, hits.hits[i].t);
    for (int a = 0; a < 3; ++a)
    {
      // A hit on the domain's surface may be rounded to its outside.
      point[a] = std::clamp(point[a], domain.min[a], domain.max[a]);
    }
    FieldSample sample;
    values[stride * i] = sampler->sample(point, sample) ? static_cast<float>(sample.value)
                                                        : std::numeric_limits<float>::quiet_NaN();
  });
}

void shadeHits(const HitImage& hits, const Camera& camera, const SurfaceAppearance& appearance,
  const SurfaceVisibility& visibility, const HitColors& colors, vtkTreeAMRSurfaceImage& image)
{
  const SurfaceFrame frame(camera.worldFromData());
  const std::size_t lights = appearance.lights.size();
  arrangePoints(hits, camera, image);
  forEachHit(hits, camera, [&](std::size_t i, const Ray& ray) {
    const SurfaceHit& hit = hits.hits[i];
    const Vec3 away = normalized(frame.worldVector(ray.direction));
    const Vec3 side{ -away[0], -away[1], -away[2] };
    const Vec3 point = frame.worldPoint(pointAt(ray, hit.t));
    Material material = appearance.material;
    float opacity = appearance.opacity;
    if (colors)
    {
      const unsigned char* const rgba = colors.at(hits.hits, i);
      for (int c = 0; c < 3; ++c)
      {
        const float channel = rgba[c] / 255.f;
        material.ambient[c] = appearance.ambientOfColors * channel;
        material.diffuse[c] = appearance.diffuseOfColors * channel;
      }
      opacity *= appearance.opaque ? 1.f : rgba[3] / 255.f;
    }
    const Vec3 normal = appearance.flat ? frame.worldNormal(hit.gradient, side)
                                        : frame.shadingNormal(hit.gradient, hit.normal, side);
    // VTK's highlights are those of an eye at the view's origin, in parallel and stereo projection, too.
    const Vec3 toEye = normalized({ -point[0], -point[1], -point[2] });
    std::array<float, 3> rgb = shade(material, appearance.lights, point, normal, toEye,
      visibility.lit.empty() ? nullptr : &visibility.lit[lights * i], opacity);
    if (!visibility.open.empty())
    {
      for (float& channel : rgb)
      {
        channel *= 1.f - opacity * (1.f - visibility.open[i]);
      }
    }
    std::copy(rgb.begin(), rgb.end(), &image.RGBA[4 * i]);
    image.RGBA[4 * i + 3] = opacity;
    image.Depth[i] = static_cast<float>(camera.depthFromT(ray, hit.t));
  });
}

void flattenLayers(
  const HitImage& hits, const Camera& camera, const std::vector<float>& depth, vtkTreeAMRSurfaceImage& image)
{
  forEach(hits.first.size() - 1, [&](std::size_t pixel) {
    const std::size_t first = hits.first[pixel];
    std::array<float, 3> sum{};
    float passes = 1.f;
    for (std::size_t i = first; i < hits.first[pixel + 1] && image.Depth[i] <= depth[pixel]; ++i)
    {
      const float alpha = image.RGBA[4 * i + 3];
      for (int c = 0; c < 3; ++c)
      {
        sum[c] += passes * alpha * image.RGBA[4 * i + c];
      }
      passes *= 1.f - alpha;
    }
    const float alpha = 1.f - passes;
    image.Runs[3 * pixel + 2] = alpha > 0.f ? 1.f : 0.f;
    if (alpha > 0.f)
    {
      for (int c = 0; c < 3; ++c)
      {
        image.RGBA[4 * first + c] = sum[c] / alpha;
      }
      image.RGBA[4 * first + 3] = alpha;
    }
  });
  arrangeTiles(camera, image);
}

void slopeHits(const HitImage& hits, const Camera& camera, vtkTreeAMRSurfaceImage& image)
{
  // Seen at a smaller cosine, the tangent plane leaves the surface within the pixel.
  constexpr double leastCosine = 0.1;
  const SurfaceFrame frame(camera.worldFromData());
  image.Slope.resize(2 * image.Depth.size());
  forEachHit(hits, camera, [&](std::size_t i, const Ray& ray) {
    const SurfaceHit& hit = hits.hits[i];
    const Vec3 away = normalized(frame.worldVector(ray.direction));
    const Vec3 toEye{ -away[0], -away[1], -away[2] };
    const double part = std::min(1., dot(frame.worldNormal(hit.gradient, toEye), toEye) / leastCosine);
    const std::array<double, 2> slope = camera.depthSlope(pointAt(ray, hit.t), hit.gradient);
    for (int a = 0; a < 2; ++a)
    {
      const double s = part * slope[a];
      image.Slope[2 * i + a] = std::isfinite(s) ? static_cast<float>(s) : 0.f;
    }
  });
}

void fillHits(
  const HitImage& hits, const Camera& camera, const HitColor& color, vtkTreeAMRSurfaceImage& image)
{
  arrangePoints(hits, camera, image);
  forEachHit(hits, camera, [&](std::size_t i, const Ray& ray) {
    const std::array<float, 3> rgb = color(hits.hits[i]);
    std::copy(rgb.begin(), rgb.end(), &image.RGBA[4 * i]);
    image.RGBA[4 * i + 3] = 1.f;
    image.Depth[i] = static_cast<float>(camera.depthFromT(ray, hits.hits[i].t));
  });
}

void placeHits(const HitImage& hits, const Camera& camera, vtkTreeAMRSurfaceImage& image)
{
  const SurfaceFrame frame(camera.worldFromData());
  image.Position.resize(3 * image.Depth.size());
  image.Normal.resize(image.Position.size());
  forEachHit(hits, camera, [&](std::size_t i, const Ray& ray) {
    const SurfaceHit& hit = hits.hits[i];
    const Vec3 position = frame.worldPoint(pointAt(ray, hit.t));
    // The eye is at the origin and looks along -z, in parallel projection from infinity.
    const Vec3 normal = frame.shadingNormal(hit.gradient, hit.normal, { 0., 0., 1. });
    std::copy(position.begin(), position.end(), &image.Position[3 * i]);
    std::copy(normal.begin(), normal.end(), &image.Normal[3 * i]);
  });
}

} // namespace treeamr

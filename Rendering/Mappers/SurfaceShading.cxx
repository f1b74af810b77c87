#include "SurfaceShading.h"

#include "Interpolation/Sampler.h"
#include "Surface/SurfaceFrame.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

/// Layers whose colours are found many at a time.
class LayerLights
{
public:
  explicit LayerLights(std::span<const SurfaceShader> shaders)
    : shaders_(shaders)
    , hits_(shaders.size())
  {
  }

  bool isFull() const noexcept { return layers_.size() == HitsToLight::most; }
  /// Adds the layer that a walk is at, whose place is `target`; the part `passes` of the light comes from there to the
  /// eye. Returns its opacity. Not when it is full.
  float add(const LayerWalk& walk, std::size_t target, float passes)
  {
    // In its place: a copy would wait until all of it has been written.
    Layer& layer = layers_.emplace_back();
    layer.source = walk.source();
    layer.hit = walk.hit();
    layer.target = target;
    layer.passes = passes;
    const SurfaceShader& shader = walk.shader();
    if (shader.lightsTogether())
    {
      layer.slot = hits_[layer.source].count;
      layer.rgba[3] = shader.add(layer.hit, walk.sight(), hits_[layer.source]);
    }
    else
    {
      layer.slot = -1;
      layer.rgba = shader(layer.hit, walk.sight());
    }
    return layer.rgba[3];
  }
  /// Calls take(target, passes, colour) for all that were added, in their order.
  template <class Take>
  void take(const Take& take)
  {
    for (std::size_t s = 0; s < shaders_.size(); ++s)
    {
      shaders_[s].light(hits_[s]);
    }
    for (Layer& layer : layers_)
    {
      if (layer.slot >= 0)
      {
        const auto& rgb = hits_[layer.source].rgb;
        layer.rgba = shaders_[layer.source].lit(
          layer.hit, { rgb[0][layer.slot], rgb[1][layer.slot], rgb[2][layer.slot] }, layer.rgba[3]);
      }
      take(layer.target, layer.passes, layer.rgba);
    }
    layers_.clear();
    for (HitsToLight& hits : hits_)
    {
      hits.count = 0;
    }
  }

private:
  struct Layer
  {
    std::size_t source;
    std::size_t hit;
    std::size_t target;
    int slot; // of the hits to be lit; -1: its colour is known
    float passes;
    std::array<float, 4> rgba;
  };
  std::span<const SurfaceShader> shaders_;
  std::vector<HitsToLight> hits_; // by shader
  std::vector<Layer> layers_;
};

/// Calls body(pixel, walk through its layers, started, add) for all pixels. add(target, passes) is for the layer that the
/// walk is at, and returns its opacity; take(target, passes, colour) is called for these in their order, later on, and
/// end(pixel) for pixels of which all were taken.
template <class Body, class Take, class End>
void forEachPixel(std::span<const SurfaceShader> shaders, std::size_t pixels, const Body& body,
  const Take& take, const End& end)
{
  constexpr std::size_t perTask = 1024;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pixels, perTask), [&](const auto& range) {
    LayerWalk walk(shaders);
    LayerLights lights(shaders);
    const auto add = [&](std::size_t target, float passes) {
      if (lights.isFull())
      {
        lights.take(take);
      }
      return lights.add(walk, target, passes);
    };
    for (std::size_t pixel = range.begin(); pixel < range.end(); ++pixel)
    {
      walk.start(pixel);
      body(pixel, walk, add);
    }
    lights.take(take);
    for (std::size_t pixel = range.begin(); pixel < range.end(); ++pixel)
    {
      end(pixel);
    }
  });
}

/// Less light than 8 bits can show.
constexpr float noLight = 1.f / 1024.f;

/// Whether a hit is before a window depth. All are before that of the far plane.
bool isBefore(const LayerWalk& walk, float depth)
{
  return depth >= 1.f || static_cast<float>(walk.depth()) <= depth;
}

/// Blends the layers before the window depths of their pixels, down to the last that 8 bits could show, into
/// premultiplied rgba. Calls atNearest(pixel, walk) at the first of each, and end(pixel) for all.
template <class AtNearest, class End>
void blendLayers(std::span<const SurfaceShader> shaders, std::span<const float> depth, float* rgba,
  const AtNearest& atNearest, const End& end)
{
  forEachPixel(
    shaders, depth.size(),
    [&](std::size_t pixel, LayerWalk& walk, const auto& add) {
      std::fill_n(&rgba[4 * pixel], 3, 0.f);
      float passes = 1.f;
      for (bool isNearest = true; passes > noLight && walk.next() && isBefore(walk, depth[pixel]);
           isNearest = false)
      {
        if (isNearest)
        {
          atNearest(pixel, walk);
        }
        passes *= 1.f - add(pixel, passes);
      }
      rgba[4 * pixel + 3] = 1.f - passes;
    },
    [&](std::size_t pixel, float passes, const std::array<float, 4>& layer) {
      for (int c = 0; c < 3; ++c)
      {
        rgba[4 * pixel + c] += passes * layer[3] * layer[c];
      }
    },
    end);
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
    values[stride * i] = sampler->sampleRelative(point, sample) ? static_cast<float>(sample.value)
                                                                : std::numeric_limits<float>::quiet_NaN();
  });
}

SurfaceShader::SurfaceShader(const HitImage& hits, const Camera& camera, SurfaceAppearance appearance,
  const SurfaceVisibility& visibility, HitColors colors)
  : hits_(&hits)
  , camera_(&camera)
  , frame_(camera.worldFromData())
  , appearance_(std::move(appearance))
  , visibility_(&visibility)
  , colors_(std::move(colors))
{
  const auto isSimple = [](const Material& material) { return !shines(material); };
  lightsTogether_ = visibility.lit.empty() && isSimple(appearance_.material) &&
    std::all_of(appearance_.surfaces.begin(), appearance_.surfaces.end(),
      [&](const SurfaceMaterial& surface) { return isSimple(surface.material); }) &&
    std::none_of(appearance_.lights.begin(), appearance_.lights.end(),
      [](const Light& light) { return light.positional; });
}

Sight SurfaceShader::sight(std::size_t pixel) const noexcept
{
  const Ray ray = rayOf(*camera_, pixel);
  const Vec3 away = normalized(frame_.worldVector(ray.direction));
  return { ray, { -away[0], -away[1], -away[2] } };
}

SurfaceMaterial SurfaceShader::materialOf(std::size_t i) const noexcept
{
  const SurfaceHit& hit = hits_->hits[i];
  SurfaceMaterial own = appearance_.surfaces.empty()
    ? SurfaceMaterial{ appearance_.material, appearance_.opacity }
    : appearance_.surfaces[hit.surface];
  if (colors_)
  {
    const unsigned char* const rgba = colors_.at(hits_->hits, i);
    for (int c = 0; c < 3; ++c)
    {
      const float channel = rgba[c] / 255.f;
      own.material.ambient[c] = appearance_.ambientOfColors * channel;
      own.material.diffuse[c] = appearance_.diffuseOfColors * channel;
    }
    own.opacity *= appearance_.opaque ? 1.f : rgba[3] / 255.f;
  }
  return own;
}

std::array<float, 4> SurfaceShader::lit(
  std::size_t i, const std::array<float, 3>& rgb, float opacity) const noexcept
{
  // What of the colour reaches the eye out of narrow places.
  const float open = visibility_->open.empty() ? 1.f : 1.f - opacity * (1.f - visibility_->open[i]);
  return { rgb[0] * open, rgb[1] * open, rgb[2] * open, opacity };
}

std::array<float, 4> SurfaceShader::operator()(std::size_t i, const Sight& sight) const noexcept
{
  const SurfaceHit& hit = hits_->hits[i];
  const Vec3 point = frame_.worldPoint(pointAt(sight.ray, hit.t));
  const auto [material, opacity] = materialOf(i);
  const Vec3 normal = appearance_.flat ? frame_.worldNormal(hit.gradient, sight.toEye)
                                       : frame_.shadingNormal(hit.gradient, hit.normal, sight.toEye);
  // VTK's highlights are those of an eye at the view's origin, in parallel and stereo projection, too.
  const Vec3 toEye = shines(material) ? normalized({ -point[0], -point[1], -point[2] }) : Vec3{};
  return lit(i,
    shade(material, appearance_.lights, point, normal, toEye,
      visibility_->lit.empty() ? nullptr : &visibility_->lit[appearance_.lights.size() * i], opacity),
    opacity);
}

float SurfaceShader::add(std::size_t i, const Sight& sight, HitsToLight& hits) const noexcept
{
  const SurfaceHit& hit = hits_->hits[i];
  if (colors_)
  {
    const auto [material, opacity] = materialOf(i);
    hits.add(sight.toEye, hit, material.ambient, material.diffuse);
    return opacity;
  }
  const bool isAlike = appearance_.surfaces.empty();
  const Material& material = isAlike ? appearance_.material : appearance_.surfaces[hit.surface].material;
  hits.add(sight.toEye, hit, material.ambient, material.diffuse);
  return isAlike ? appearance_.opacity : appearance_.surfaces[hit.surface].opacity;
}

void SurfaceShader::light(HitsToLight& hits) const noexcept
{
  lightHits(frame_, appearance_.lights, appearance_.flat, hits);
}

std::array<float, 2> SurfaceShader::depthSlope(std::size_t i, const Sight& sight) const noexcept
{
  // Seen at a smaller cosine, the tangent plane leaves the surface within the pixel.
  constexpr double leastCosine = 0.1;
  const SurfaceHit& hit = hits_->hits[i];
  const double cosine = dot(frame_.worldNormal(hit.gradient, sight.toEye), sight.toEye);
  const double part = std::min(1., cosine / leastCosine);
  const std::array<double, 2> whole = camera_->depthSlope(pointAt(sight.ray, hit.t), hit.gradient);
  std::array<float, 2> slope;
  for (int a = 0; a < 2; ++a)
  {
    const double s = part * whole[a];
    slope[a] = std::isfinite(s) ? static_cast<float>(s) : 0.f;
  }
  return slope;
}

LayerWalk::LayerWalk(std::span<const SurfaceShader> shaders)
{
  for (const SurfaceShader& shader : shaders)
  {
    sources_.push_back({ &shader });
  }
}

void LayerWalk::start(std::size_t pixel)
{
  isStarted_ = false;
  for (Source& source : sources_)
  {
    const HitImage& hits = source.shader->hits();
    source.hit = hits.first[pixel];
    source.end = hits.first[pixel + 1];
    if (source.hit != source.end)
    {
      source.sight = source.shader->sight(pixel);
      if (sources_.size() > 1)
      {
        source.depth = source.depthOfHit();
      }
    }
  }
}

double LayerWalk::Source::depthOfHit() const noexcept
{
  return shader->camera().depthFromT(sight.ray, shader->hits().hits[hit].t);
}

bool LayerWalk::next()
{
  if (isStarted_)
  {
    Source& last = sources_[current_];
    if (++last.hit != last.end && sources_.size() > 1)
    {
      last.depth = last.depthOfHit();
    }
  }
  isStarted_ = true;
  if (sources_.size() == 1)
  {
    return sources_[0].hit != sources_[0].end;
  }
  bool found = false;
  for (std::size_t s = 0; s < sources_.size(); ++s)
  {
    if (sources_[s].hit != sources_[s].end && (!found || sources_[s].depth < sources_[current_].depth))
    {
      current_ = s;
      found = true;
    }
  }
  return found;
}

double LayerWalk::t(const Camera& camera, const Ray& ray) const noexcept
{
  const Source& source = sources_[current_];
  const bool isSame = source.sight.ray.origin == ray.origin && source.sight.ray.direction == ray.direction;
  return isSame ? source.shader->hits().hits[source.hit].t : camera.tFromDepth(ray, this->depth());
}

std::array<float, 2> LayerWalk::depthSlope() const noexcept
{
  const Source& source = sources_[current_];
  return source.shader->depthSlope(source.hit, source.sight);
}

void shadeHits(const SurfaceShader& shader, bool withSlope, vtkTreeAMRSurfaceImage& image)
{
  const HitImage& hits = shader.hits();
  arrangePoints(hits, shader.camera(), image);
  image.Slope.resize(withSlope ? 2 * image.Depth.size() : 0);
  forEach(hits.first.size() - 1, [&](std::size_t pixel) {
    if (hits.first[pixel] == hits.first[pixel + 1])
    {
      return;
    }
    const Sight sight = shader.sight(pixel);
    for (std::size_t i = hits.first[pixel]; i < hits.first[pixel + 1]; ++i)
    {
      const std::array<float, 4> rgba = shader(i, sight);
      std::copy(rgba.begin(), rgba.end(), &image.RGBA[4 * i]);
      image.Depth[i] = static_cast<float>(shader.camera().depthFromT(sight.ray, hits.hits[i].t));
      if (withSlope)
      {
        const std::array<float, 2> slope = shader.depthSlope(i, sight);
        std::copy(slope.begin(), slope.end(), &image.Slope[2 * i]);
      }
    }
  });
}

void flattenLayers(std::span<const SurfaceShader> shaders, std::span<const float> depth, bool withSlope,
  vtkTreeAMRSurfaceImage& image)
{
  constexpr std::size_t columns = vtkTreeAMRSurfaceImage::Columns;
  const std::size_t pixels = depth.size();
  image.Depth.resize(filledRows(pixels));
  image.RGBA.resize(4 * image.Depth.size());
  image.Slope.resize(withSlope ? 2 * image.Depth.size() : 0);
  image.Runs.resize(3 * pixels);
  blendLayers(
    shaders, depth, image.RGBA.data(),
    [&](std::size_t pixel, const LayerWalk& walk) {
      image.Depth[pixel] = static_cast<float>(walk.depth());
      if (withSlope)
      {
        const std::array<float, 2> slope = walk.depthSlope();
        std::copy(slope.begin(), slope.end(), &image.Slope[2 * pixel]);
      }
    },
    [&](std::size_t pixel) {
      const float alpha = image.RGBA[4 * pixel + 3];
      for (int c = 0; c < 3; ++c)
      {
        float& channel = image.RGBA[4 * pixel + c];
        channel = alpha > 0.f ? channel / alpha : 0.f;
      }
      image.Runs[3 * pixel] = static_cast<float>(pixel % columns);
      image.Runs[3 * pixel + 1] = static_cast<float>(pixel / columns);
      image.Runs[3 * pixel + 2] = alpha > 0.f ? 1.f : 0.f;
    });
  arrangeTiles(shaders.front().camera(), image);
}

void flattenLayers(std::span<const SurfaceShader> shaders, std::span<const float> depth, Image& image)
{
  blendLayers(
    shaders, depth, image.rgba.data(), [](std::size_t, const LayerWalk&) {}, [](std::size_t) {});
}

void collectLayers(std::span<const SurfaceShader> shaders, const Camera& camera, std::span<const float> depth,
  CollectedLayers& layers)
{
  // The kernel compares in its own units: what is hardly behind is left to it.
  constexpr double slack = 1e-5;
  const std::size_t pixels = static_cast<std::size_t>(camera.width()) * camera.height();
  layers.first.assign(pixels + 1, 0);
  for (std::size_t pixel = 0; pixel <= pixels; ++pixel)
  {
    for (const SurfaceShader& shader : shaders)
    {
      layers.first[pixel] += shader.hits().first[pixel];
    }
  }
  layers.layers.resize(layers.first.back());
  const auto collect = [&](std::size_t pixel, LayerWalk& walk, const auto& add) {
    std::size_t i = layers.first[pixel];
    const std::size_t end = layers.first[pixel + 1];
    if (i == end)
    {
      return;
    }
    const Ray ray = rayOf(camera, pixel);
    float passes = 1.f;
    while (passes > noLight && walk.next() && (depth.empty() || walk.depth() <= depth[pixel] + slack))
    {
      layers.layers[i].t = walk.t(camera, ray);
      passes *= 1.f - add(i, passes);
      ++i;
    }
    for (; i < end; ++i)
    {
      layers.layers[i] = { std::numeric_limits<double>::infinity(), {} };
    }
  };
  forEachPixel(
    shaders, pixels, collect,
    [&](std::size_t i, float, const std::array<float, 4>& rgba) { layers.layers[i].rgba = rgba; },
    [](std::size_t) {});
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

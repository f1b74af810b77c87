#include "VolumeLayers.h"

#include "vtkCamera.h"
#include "vtkMatrix4x4.h"
#include "vtkRenderer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace treeamr
{

namespace
{

/// Of a plane across the direction of projection.
float windowDepth(vtkMatrix4x4* projection, double distance)
{
  const double z = -distance * projection->GetElement(2, 2) + projection->GetElement(2, 3);
  const double w = -distance * projection->GetElement(3, 2) + projection->GetElement(3, 3);
  return w > 0. ? static_cast<float>(std::clamp(0.5 * (z / w + 1.), 0., 1.)) : 0.f;
}

template <class Use>
void forEachPixel(std::size_t count, const Use& use)
{
  constexpr std::size_t pixels = 4096; // a task
  tbb::parallel_for(
    tbb::blocked_range<std::size_t>(0, count, pixels), [&](const tbb::blocked_range<std::size_t>& range) {
      for (std::size_t pixel = range.begin(); pixel < range.end(); ++pixel)
      {
        use(pixel);
      }
    });
}

/// Of an opacity; of an opaque one, that no light of single precision passes.
float opticalDepth(float opacity)
{
  constexpr float most = 20.f;
  return opacity < 1.f ? std::min(-std::log1p(-opacity), most) : most;
}

void putBehind(const float* behind, float* rgba)
{
  const float through = 1.f - rgba[3];
  for (int c = 0; c < 4; ++c)
  {
    rgba[c] += through * behind[c];
  }
}

using Trace = std::function<MixedImage(const VolumeLayer&, const PixelMask&)>;

/// A layer in halves.
class Halving
{
public:
  Halving(int most, const Trace& trace, Image& image)
    : most_(most)
    , trace_(trace)
    , image_(image)
  {
  }

  /// whole: the layer's image in one part, of pixels that are wanted; depth: how often it has been halved.
  void add(const VolumeLayer& layer, const MixedImage& whole, const PixelMask& wanted, int depth)
  {
    VolumeLayer near = layer;
    VolumeLayer far = layer;
    near.end = far.begin = 0.5f * (layer.begin + layer.end);
    const bool hasHalves = depth < most_ && near.begin < near.end && far.begin < far.end;
    PixelMask halved(wanted.size());
    forEachPixel(wanted.size(), [&](std::size_t pixel) {
      halved[pixel] = hasHalves && wanted[pixel] && this->isSeen(pixel, this->errorOf(whole, pixel));
      if (wanted[pixel] && !halved[pixel])
      {
        putBehind(&whole.image.rgba[4 * pixel], &image_.rgba[4 * pixel]);
      }
    });
    if (isEmpty(halved))
    {
      return;
    }
    const MixedImage first = trace_(near, halved);
    const MixedImage second = trace_(far, halved);
    this->add(near, first, halved, depth + 1);
    this->add(far, second, halved, depth + 1);
  }

private:
  static float errorOf(const MixedImage& mixed, std::size_t pixel)
  {
    return mixed.error.empty() ? 0.f : mixed.error[pixel];
  }
  static bool isEmpty(const PixelMask& mask)
  {
    return std::all_of(mask.begin(), mask.end(), [](unsigned char wanted) { return wanted == 0; });
  }
  bool isSeen(std::size_t pixel, float error) const
  {
    constexpr float least = 1.f / 256.f;
    return (1.f - image_.rgba[4 * pixel + 3]) * error > least;
  }

  int most_;
  const Trace& trace_;
  Image& image_;
};

} // namespace

std::vector<VolumeLayer> makeVolumeLayers(vtkRenderer* renderer, const VolumeOrder& order)
{
  vtkMatrix4x4* projection =
    renderer->GetActiveCamera()->GetProjectionTransformMatrix(renderer->GetTiledAspectRatio(), -1., 1.);
  std::vector<VolumeLayer> layers;
  const auto add = [&](float begin, float end, bool isMixed) {
    VolumeLayer layer{ begin, end, isMixed, {} };
    for (std::size_t v = 0; v < order.volumes.size(); ++v)
    {
      const auto [nearest, farthest] = order.extents[v];
      constexpr float rounding = 1e-6f;
      if (windowDepth(projection, nearest) - rounding < end &&
        windowDepth(projection, farthest) + rounding > begin)
      {
        layer.volumes.push_back(v);
      }
    }
    if (begin < end && !layer.volumes.empty())
    {
      layers.push_back(std::move(layer));
    }
  };
  const float begin = windowDepth(projection, order.overlap.first);
  const float end = windowDepth(projection, order.overlap.second);
  add(0.f, begin, false);
  add(begin, end, true);
  add(end, 1.f, false);
  return layers;
}

void mixIn(const Image& other, MixedImage& mixed)
{
  Image& image = mixed.image;
  mixed.error.resize(image.rgba.size() / 4, 0.f);
  forEachPixel(mixed.error.size(), [&](std::size_t pixel) {
    float* const rgba = &image.rgba[4 * pixel];
    const float* const otherRgba = &other.rgba[4 * pixel];
    const float own = rgba[3];
    const float opacity = otherRgba[3];
    if (opacity <= 0.f)
    {
      return;
    }
    if (own <= 0.f)
    {
      std::copy_n(otherRgba, 4, rgba);
      return;
    }
    const float depth = opticalDepth(own);
    const float otherDepth = opticalDepth(opacity);
    const float both = own + opacity - own * opacity;
    const float perDepth = both / (depth + otherDepth);
    const float weight = perDepth * depth / own;
    const float otherWeight = perDepth * otherDepth / opacity;
    for (int c = 0; c < 3; ++c)
    {
      rgba[c] = weight * rgba[c] + otherWeight * otherRgba[c];
    }
    rgba[3] = both;
    // Either may be before all of the other.
    mixed.error[pixel] += own * opacity;
  });
}

void putBehind(const Image& behind, Image& image)
{
  forEachPixel(image.rgba.size() / 4,
    [&](std::size_t pixel) { putBehind(&behind.rgba[4 * pixel], &image.rgba[4 * pixel]); });
}

void addLayer(const VolumeLayer& layer, int halvings, const Trace& trace, Image& image)
{
  const PixelMask all(image.rgba.size() / 4, 1);
  Halving(halvings, trace, image).add(layer, trace(layer, all), all, 0);
}

} // namespace treeamr

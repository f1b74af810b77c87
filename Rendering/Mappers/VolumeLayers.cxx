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

bool isEmpty(const PixelMask& mask)
{
  return std::all_of(mask.begin(), mask.end(), [](unsigned char wanted) { return wanted == 0; });
}

/// The least of a part that has all pixels of a mask, which has some.
ImagePart boundsOf(const PixelMask& mask, const ImagePart& part)
{
  int left = part.width;
  int right = 0;
  int lower = part.height;
  int upper = 0;
  for (int row = 0; row < part.height; ++row)
  {
    const auto begin = mask.begin() + static_cast<std::ptrdiff_t>(row) * part.width;
    const auto isWanted = [](unsigned char wanted) { return wanted != 0; };
    const auto first = std::find_if(begin, begin + part.width, isWanted);
    if (first == begin + part.width)
    {
      continue;
    }
    int last = part.width;
    while (begin[last - 1] == 0)
    {
      --last;
    }
    left = std::min(left, static_cast<int>(first - begin));
    right = std::max(right, last);
    lower = std::min(lower, row);
    upper = row + 1;
  }
  return { part.imageWidth, part.imageHeight, part.x + left, part.y + lower, right - left, upper - lower };
}

/// Calls use(pixel of the inner part, pixel of the outer one).
template <class Use>
void forEachShared(const ImagePart& inner, const ImagePart& outer, const Use& use)
{
  for (int row = 0; row < inner.height; ++row)
  {
    const std::size_t of = static_cast<std::size_t>(row) * inner.width;
    const std::size_t from =
      static_cast<std::size_t>(inner.y - outer.y + row) * outer.width + (inner.x - outer.x);
    for (int column = 0; column < inner.width; ++column)
    {
      use(of + column, from + column);
    }
  }
}

/// A layer in halves.
class Halving
{
public:
  Halving(int most, const TraceLayer& trace)
    : most_(most)
    , trace_(trace)
  {
  }

  /// whole: the layer's image in one go, of pixels that are wanted; depth: how often it has been halved. All of the part's
  /// size.
  void add(const VolumeLayer& layer, const ImagePart& part, const MixedImage& whole, const PixelMask& wanted,
    int depth, Image& image) const
  {
    VolumeLayer near = layer;
    VolumeLayer far = layer;
    near.end = far.begin = 0.5f * (layer.begin + layer.end);
    const bool hasHalves =
      depth < most_ && near.begin < near.end && far.begin < far.end && !whole.error.empty();
    PixelMask halved(wanted.size());
    forEachPixel(wanted.size(), [&](std::size_t pixel) {
      constexpr float seen = 1.f / 256.f;
      const float through = 1.f - image.rgba[4 * pixel + 3];
      halved[pixel] = wanted[pixel] && hasHalves && through * whole.error[pixel] > seen;
      if (wanted[pixel] && !halved[pixel])
      {
        putBehind(&whole.image.rgba[4 * pixel], &image.rgba[4 * pixel]);
      }
    });
    if (isEmpty(halved))
    {
      return;
    }
    const ImagePart inner = boundsOf(halved, part);
    Image innerImage(inner.width, inner.height);
    PixelMask innerHalved(innerImage.rgba.size() / 4);
    forEachShared(inner, part, [&](std::size_t of, std::size_t from) {
      innerHalved[of] = halved[from];
      std::copy_n(&image.rgba[4 * from], 4, &innerImage.rgba[4 * of]);
    });
    for (const VolumeLayer& half : { near, far })
    {
      this->add(
        half, inner, trace_(half, inner, innerHalved, innerImage), innerHalved, depth + 1, innerImage);
    }
    forEachShared(inner, part, [&](std::size_t of, std::size_t from) {
      std::copy_n(&innerImage.rgba[4 * of], 4, &image.rgba[4 * from]);
    });
  }

private:
  int most_;
  const TraceLayer& trace_;
};

} // namespace

Matrix4 ImagePart::clip(const Matrix4& ofImage) const noexcept
{
  if (this->isWhole())
  {
    return ofImage;
  }
  Matrix4 result = ofImage;
  for (int column = 0; column < 4; ++column)
  {
    const double w = ofImage[12 + column];
    result[column] = (imageWidth * ofImage[column] - (2. * x + width - imageWidth) * w) / width;
    result[4 + column] = (imageHeight * ofImage[4 + column] - (2. * y + height - imageHeight) * w) / height;
  }
  return result;
}

HitsOfPart::HitsOfPart(const TranslucentHits& ofImage, const ImagePart& part)
{
  first.reserve(static_cast<std::size_t>(part.width) * part.height + 1);
  first.push_back(0);
  for (int row = 0; row < part.height; ++row)
  {
    for (int column = 0; column < part.width; ++column)
    {
      const std::size_t pixel = part.pixel(column, row);
      const auto of =
        ofImage.hits.subspan(ofImage.first[pixel], ofImage.first[pixel + 1] - ofImage.first[pixel]);
      hits.insert(hits.end(), of.begin(), of.end());
      first.push_back(hits.size());
    }
  }
}

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

void addLayer(const VolumeLayer& layer, int halvings, const TraceLayer& trace, Image& image)
{
  const ImagePart whole{ image.width, image.height };
  const PixelMask all(image.rgba.size() / 4, 1);
  Halving(halvings, trace).add(layer, whole, trace(layer, whole, all, image), all, 0, image);
}

} // namespace treeamr

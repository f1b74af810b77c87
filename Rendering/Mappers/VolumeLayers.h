// Volumes that overlap, merged along the rays: in thin layers across the direction of projection, all volumes of a layer
// at once, the layers front to back. Private to the module.
#pragma once

#include "VolumeOrder.h"

#include "Geometry/Camera.h"
#include "Geometry/Image.h"
#include "Geometry/RayStops.h"

#include <functional>
#include <vector>

class vtkRenderer;

namespace treeamr
{

/// A part of all rays, in window depths, and the volumes that are in it.
struct VolumeLayer
{
  float begin;
  float end;
  bool isMixed;                     // else volumes come one after another in it
  std::vector<std::size_t> volumes; // of an order's
};

/// From the near to the far plane: what overlaps, and what is before and behind it.
std::vector<VolumeLayer> makeVolumeLayers(vtkRenderer* renderer, const VolumeOrder& order);

/// A rectangle of an image's pixels.
struct ImagePart
{
  int imageWidth;
  int imageHeight;
  int x = 0;
  int y = 0;
  int width = imageWidth;
  int height = imageHeight;

  bool isWhole() const noexcept { return width == imageWidth && height == imageHeight; }
  /// Of the image, of a pixel of the part.
  std::size_t pixel(int column, int row) const noexcept
  {
    return static_cast<std::size_t>(y + row) * imageWidth + x + column;
  }
  /// The clip space in which the part is all there is.
  Matrix4 clip(const Matrix4& ofImage) const noexcept;
};

/// Those of a part's rays.
struct HitsOfPart
{
  HitsOfPart(const TranslucentHits& ofImage, const ImagePart& part);

  std::vector<std::size_t> first;
  std::vector<TranslucentHit> hits;
};

/// Premultiplied.
struct MixedImage
{
  Image image;
  std::vector<float> error; // at most, of each pixel; empty: none
};

/// Of images of one size. As if both volumes filled their layer evenly: extinctions are added, and the light of each is
/// dimmed by the other as by itself.
void mixIn(const Image& other, MixedImage& mixed);

/// Of premultiplied images of one size.
void putBehind(const Image& behind, Image& image);

/// Which pixels' rays are asked for: not 0.
using PixelMask = std::vector<unsigned char>;

/// Of a layer, some pixels of a part of the image, of which there is what is before the layer.
using TraceLayer = std::function<MixedImage(
  const VolumeLayer& layer, const ImagePart& part, const PixelMask& wanted, const Image& before)>;

/// Puts a layer behind what is before it: where its error may be seen in halves, and these in halves, up to so many
/// times.
void addLayer(const VolumeLayer& layer, int halvings, const TraceLayer& trace, Image& image);

} // namespace treeamr

// Volumes that overlap, merged along the rays: in thin layers across the direction of projection, all volumes of a layer
// at once, the layers front to back. Private to the module.
#pragma once

#include "VolumeOrder.h"

#include "Geometry/Image.h"

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

/// Puts a layer behind what is before it: where its error may be seen in halves, and these in halves, up to so many
/// times, as long as that changes the pixel by a quarter of what an 8-bit channel shows. trace: of a layer, for some
/// pixels.
void addLayer(const VolumeLayer& layer, int halvings,
  const std::function<MixedImage(const VolumeLayer&, const PixelMask&)>& trace, Image& image);

} // namespace treeamr

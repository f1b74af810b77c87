// The converged picture of a scene, which takes minutes: kept in a file.
#pragma once

#include "Geometry/Image.h"
#include "Scene.h"
#include "Volume/VolumeSettings.h"

#include <string>

namespace treeamr::bench
{

/// By the scalar reference at 64 samples per cell. leastTransmittance: of light that rays may leave out; as frames do,
/// so that pictures differ by their samples alone, or less.
Image convergedImage(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  float leastTransmittance = opaqueTransmittance);

/// convergedImage(), from the file at `path` if that is of the same arguments, else computed and written there. The file: the 16 bytes of the digest of these, int32 width and height, then the
/// pixels as they are in Image. Throws Error when it cannot be written.
Image referenceImage(const std::string& path, const ContentDigest& forest, const Field& field,
  const TransferFunction& transferFunction, const Camera& camera,
  float leastTransmittance = opaqueTransmittance);

/// Peak signal to noise ratio of the colours, whose peak is 1, in dB.
double psnr(const Image& image, const Image& reference);

/// As binary PPM of 8 bits per channel, over black. Throws Error when it cannot be written.
void writePicture(const std::string& path, const Image& image);

} // namespace treeamr::bench

// What a volume's frames may be asked for. Each throws Error, which names what was found and what is allowed.
#pragma once

#include "Volume/Volume.h"

#include <span>

namespace treeamr
{

void checkVolume(const Camera& camera, const Image& image);
void checkVolume(const Field& field, const TransferFunction& transferFunction);
void checkVolume(const RayView& view, const VolumeSettings& settings);
void checkVolume(const Camera& camera, std::span<const PixelGroup> groups, std::span<const float> rgba);

} // namespace treeamr

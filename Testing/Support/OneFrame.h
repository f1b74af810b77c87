// Frames of volumes that are rendered once.
#pragma once

#include "Volume/Volume.h"

#include <memory>

namespace treeamr::test
{

/// A volume of a field that outlives it.
inline Volume volumeOf(
  const Field& field, const TransferFunction& transferFunction, std::size_t keptBytes = defaultKeptBytes)
{
  return Volume({ std::shared_ptr<const Field>(), &field }, transferFunction, keptBytes);
}

inline VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, Image& image)
{
  return volumeOf(field, transferFunction).render({ camera, stops }, settings, image);
}

} // namespace treeamr::test

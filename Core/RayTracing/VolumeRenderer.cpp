#include "RayTracing/VolumeRenderer.h"

#include "Error.h"
#include "RayTracing/VolumeKernel.h"
#include "RayTracing/VolumeReference.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace treeamr
{

namespace
{

void check(const Field& field, const Camera& camera, const VolumeSettings& settings, const Image& image)
{
  if (image.width != camera.width() || image.height != camera.height())
  {
    throw Error("volume: an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
      " pixels for a camera of " + std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
  }
  if (!(settings.samplesPerCell > 0.) || !(settings.samplesPerCell <= VolumeSettings::maxSamplesPerCell))
  {
    throw Error("volume: " + std::to_string(settings.samplesPerCell) +
      " samples per cell, allowed are values above 0 up to " +
      std::to_string(VolumeSettings::maxSamplesPerCell));
  }
  if (settings.skipEmpty && !field.hasNodeRanges())
  {
    throw Error("volume: the field has no node ranges to skip by");
  }
}

/// Differences of values and their positions in the table must not leave single precision.
bool fitsKernel(const Field& field, const TransferFunction& transferFunction)
{
  constexpr double large = std::numeric_limits<float>::max() / 4.;
  const Range range = field.range();
  const double width = static_cast<double>(range.max) - range.min;
  const double low = std::abs(transferFunction.min());
  const double scale = transferFunction.scale();
  return width < large && low < large && scale < large && (scale == 0. || scale > 1. / large);
}

/// Where the kernel counts from, and in which units.
void place(VolumeKernelScene& scene)
{
  const Bounds domain = scene.field.octree().grid().bounds();
  const Ray central = scene.camera.ray(scene.camera.width() / 2, scene.camera.height() / 2);
  double diagonal = 0.; // in t: a length along the central ray's scale
  double toCentre = 0.;
  double squared = 0.;
  for (int a = 0; a < 3; ++a)
  {
    diagonal += std::pow(domain.max[a] - domain.min[a], 2);
    toCentre += (0.5 * (domain.min[a] + domain.max[a]) - central.origin[a]) * central.direction[a];
    squared += std::pow(central.direction[a], 2);
  }
  diagonal = std::sqrt(diagonal / squared);
  toCentre /= squared;
  // Far away (narrow angles), counting from the eye would leave the domain to the last digits.
  constexpr double nearby = 8.;
  scene.scale = 1. / diagonal;
  scene.commonOrigin = scene.camera.isPerspective() && std::abs(toCentre) < nearby * diagonal;
  scene.tReference = scene.commonOrigin ? 0. : toCentre - diagonal;
  for (int a = 0; a < 3; ++a)
  {
    scene.reference[a] = central.origin[a] + scene.tReference * central.direction[a];
  }
  for (TransferFunction::Entry& e : scene.table)
  {
    const double perUnit = e.extinction * diagonal;
    e.extinction = static_cast<float>(std::min<double>(perUnit, TransferFunction::opaqueExtinction));
  }
}

} // namespace

VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const DepthInterval& interval, const VolumeSettings& settings, VertexCache& kept,
  Image& image)
{
  check(field, camera, settings, image);
  if (!fitsKernel(field, transferFunction))
  {
    return renderVolumeReference(field, transferFunction, camera, interval, settings, image);
  }
  VolumeKernelScene scene{ field, transferFunction, camera, interval, settings, kept, image, {}, true, 0., 1.,
    transferFunction.entries() };
  place(scene);
  kept.beginFrame();
  tbb::combinable<VolumeStatistics> statistics;
  const int rows = (image.height + volumeTileWidth - 1) / volumeTileWidth;
  const int columns = (image.width + volumeTileWidth - 1) / volumeTileWidth;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 1, 0, columns, 4), [&](const auto& tiles) {
    for (int row = tiles.rows().begin(); row < tiles.rows().end(); ++row)
    {
      statistics.local() += renderVolumeTiles(scene, row, tiles.cols().begin(), tiles.cols().end());
    }
  });
  return statistics.combine([](VolumeStatistics a, const VolumeStatistics& b) { return a += b; });
}

VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const DepthInterval& interval, const VolumeSettings& settings, Image& image)
{
  // For this frame only: tiles share the leaves on their borders.
  VertexCache kept(field.octree().leafCount(), VolumeSettings::defaultKeptBytes);
  return renderVolume(field, transferFunction, camera, interval, settings, kept, image);
}

} // namespace treeamr

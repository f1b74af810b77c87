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
#include <numbers>
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
  const Camera& camera = scene.camera;
  const Bounds domain = scene.field.octree().grid().bounds();
  const Ray central = camera.ray(camera.width() / 2, camera.height() / 2);
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
  scene.features.commonOrigin = camera.isPerspective() && std::abs(toCentre) < nearby * diagonal;
  scene.tReference = scene.features.commonOrigin ? 0. : toCentre - diagonal;
  for (int a = 0; a < 3; ++a)
  {
    scene.reference[a] = central.origin[a] + scene.tReference * central.direction[a];
  }
  if (scene.features.commonOrigin)
  {
    scene.fan = camera.fan();
  }
}

/// Widths of pixels from the distance between two rays in the image's middle.
void measurePixels(VolumeKernelScene& scene)
{
  const Camera& camera = scene.camera;
  const int x = camera.width() / 2;
  const int y = camera.height() / 2;
  const Ray a = camera.ray(x, y);
  const Ray b = camera.ray(x + 1, y);
  double origins = 0.;
  double directions = 0.;
  for (int i = 0; i < 3; ++i)
  {
    origins += std::pow(b.origin[i] - a.origin[i], 2);
    directions += std::pow(b.direction[i] - a.direction[i], 2);
  }
  scene.pixelGrowth = std::sqrt(directions);
  scene.pixelWidth = (std::sqrt(origins) + scene.tReference * scene.pixelGrowth) * scene.scale;
}

void fillTable(VolumeKernelScene& scene)
{
  KernelTable& table = scene.table;
  table.entries = scene.transferFunction.entries();
  table.variation.resize(table.entries.size());
  double variation = 0.;
  for (std::size_t i = 0; i < table.entries.size(); ++i)
  {
    TransferFunction::Entry& e = table.entries[i];
    const double perUnit = std::min<double>(e.extinction / scene.scale, TransferFunction::opaqueExtinction);
    if (i > 0)
    {
      const TransferFunction::Entry& before = scene.transferFunction.entries()[i - 1];
      const double perUnitBefore =
        std::min<double>(before.extinction / scene.scale, TransferFunction::opaqueExtinction);
      variation +=
        std::max({ std::abs(perUnit - perUnitBefore), std::abs(perUnit * e.r - perUnitBefore * before.r),
          std::abs(perUnit * e.g - perUnitBefore * before.g),
          std::abs(perUnit * e.b - perUnitBefore * before.b) });
    }
    table.variation[i] = variation;
    e.extinction = static_cast<float>(perUnit * std::numbers::log2e);
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
  VolumeKernelScene scene{ field, transferFunction, camera, interval, settings, kept, image, {}, {}, 0., 1.,
    {}, {}, 0., 0. };
  place(scene);
  if (settings.levelOfDetailPixels > 0.)
  {
    measurePixels(scene);
  }
  fillTable(scene);
  tbb::combinable<VolumeStatistics> statistics;
  const int rows = (image.height + volumeTileWidth - 1) / volumeTileWidth;
  const int columns = (image.width + volumeTileWidth - 1) / volumeTileWidth;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 1, 0, columns, 4), [&](const auto& tiles) {
    for (int row = tiles.rows().begin(); row < tiles.rows().end(); ++row)
    {
      statistics.local() += renderVolumeTiles(scene, row, tiles.cols().begin(), tiles.cols().end());
    }
  });
  const VolumeStatistics all =
    statistics.combine([](VolumeStatistics a, const VolumeStatistics& b) { return a += b; });
  kept.endFrame(all.kept, all.blocks);
  return all;
}

VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const DepthInterval& interval, const VolumeSettings& settings, Image& image)
{
  // For this frame only: tiles share the leaves on their borders.
  VertexCache kept(field.octree(), VolumeSettings::defaultKeptBytes);
  return renderVolume(field, transferFunction, camera, interval, settings, kept, image);
}

} // namespace treeamr

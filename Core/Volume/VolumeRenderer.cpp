#include "Volume/VolumeRenderer.h"

#include "Error.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/VolumeReference.h"

#include <oneapi/tbb/blocked_range.h>
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

void check(const Camera& camera, const Image& image)
{
  if (image.width != camera.width() || image.height != camera.height())
  {
    throw Error("volume: an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
      " pixels for a camera of " + std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
  }
}

void check(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, const VolumeSettings& settings)
{
  const Range values = field.range();
  if (transferFunction.hasCategories() &&
    !(values.min >= 0.f && values.max < static_cast<float>(transferFunction.entries().size())))
  {
    throw Error("volume: values from " + std::to_string(values.min) + " to " + std::to_string(values.max) +
      " for " + std::to_string(transferFunction.entries().size()) +
      " categories, allowed are their numbers from 0 on");
  }
  if (!(settings.samplesPerCell > 0.) || !(settings.samplesPerCell <= VolumeSettings::maxSamplesPerCell))
  {
    throw Error("volume: " + std::to_string(settings.samplesPerCell) +
      " samples per cell, allowed are values above 0 up to " +
      std::to_string(VolumeSettings::maxSamplesPerCell));
  }
  stops.check(camera, "volume");
}

void check(const Camera& camera, std::span<const PixelGroup> groups, std::span<const float> rgba)
{
  if (rgba.size() != groups.size() * PixelGroup::rgbaSize)
  {
    throw Error("volume: " + std::to_string(rgba.size()) + " floats for " + std::to_string(groups.size()) +
      " groups of pixels, needed are " + std::to_string(PixelGroup::rgbaSize) + " for each");
  }
  for (const auto& [x, y] : groups)
  {
    if (x < 0 || x >= camera.width() || x % PixelGroup::width != 0 || y < 0 || y >= camera.height() ||
      y % PixelGroup::width != 0)
    {
      throw Error("volume: a group of pixels at " + std::to_string(x) + ", " + std::to_string(y) +
        ", allowed are multiples of " + std::to_string(PixelGroup::width) + " in an image of " +
        std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
    }
  }
}

/// Entries of the kernel's table for one of the transfer function: a table of few is tabulated anew, unless nothing
/// lies between its entries.
std::size_t entriesPerEntry(const TransferFunction& transferFunction)
{
  if (transferFunction.hasCategories())
  {
    return 1;
  }
  constexpr std::size_t fewest = 4096;
  return (fewest - 2) / (transferFunction.entries().size() - 1) + 1;
}

/// Differences of values and their positions in the table must not leave single precision.
bool fitsKernel(const Field& field, const TransferFunction& transferFunction)
{
  constexpr double large = std::numeric_limits<float>::max() / 4.;
  const Range range = field.range();
  const double width = static_cast<double>(range.max) - range.min;
  const double low = std::abs(transferFunction.min());
  const double scale = transferFunction.scale() * static_cast<double>(entriesPerEntry(transferFunction));
  // A block cannot count steps of a denormal hull: it must be a small part of an entry.
  constexpr double steep = 0.1 / std::numeric_limits<float>::min();
  return width < large && low < large && scale < steep && (scale == 0. || scale > 1. / large);
}

/// Whether single precision tells neighbouring rays from each other, and the two sides of the domain: not so in far
/// zooms that move the picture but not the eye, nor in domains as thin as a sheet.
bool resolves(const VolumeKernelScene& scene)
{
  const Bounds domain = scene.field.octree().grid().bounds();
  double squared = 0.; // of the way from the reference to the domain's middle
  double thickness = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a)
  {
    squared += std::pow(0.5 * (domain.min[a] + domain.max[a]) - scene.reference[a], 2);
    thickness = std::min(thickness, domain.max[a] - domain.min[a]);
  }
  constexpr double rounding = 0x1p-24;
  const double farthest = scene.dataScale * std::sqrt(squared) + 0.5; // the diagonal is 1
  // Of rays from one point pixels and roundings grow alike on the way.
  const double pixel = scene.features.commonOrigin ? scene.pixelGrowth : scene.pixelWidth / farthest;
  constexpr double parts = 16.;
  constexpr double thicknessParts = 256.;
  return pixel > parts * rounding && scene.dataScale * thickness > thicknessParts * rounding * farthest;
}

/// Where the kernel counts from, and in which units.
void place(VolumeKernelScene& scene)
{
  const Camera& camera = scene.camera;
  const Bounds domain = scene.field.octree().grid().bounds();
  const Ray central = camera.ray(camera.width() / 2, camera.height() / 2);
  scene.direction = central.direction;
  double diagonal = 0.; // squared in data coordinates, then in t: a length along the central ray's scale
  double toCentre = 0.;
  double squared = 0.;
  for (int a = 0; a < 3; ++a)
  {
    diagonal += std::pow(domain.max[a] - domain.min[a], 2);
    toCentre += (0.5 * (domain.min[a] + domain.max[a]) - central.origin[a]) * central.direction[a];
    squared += std::pow(central.direction[a], 2);
  }
  scene.dataScale = 1. / std::sqrt(diagonal);
  diagonal = std::sqrt(diagonal / squared);
  toCentre /= squared;
  // Far away (narrow angles), counting from the eye would leave the domain to the last digits: from its middle then.
  constexpr double nearby = 8.;
  scene.scale = 1. / diagonal;
  scene.features.commonOrigin = camera.isPerspective() && std::abs(toCentre) < nearby * diagonal;
  scene.tReference = scene.features.commonOrigin ? 0. : toCentre;
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
  const double growth = scene.dataScale * std::sqrt(directions); // per t
  scene.pixelWidth = scene.dataScale * std::sqrt(origins) + scene.tReference * growth;
  scene.pixelGrowth = growth / scene.scale;
}

/// Width of a leaf of a level in kernel units; of the mean root where these differ.
double leafWidth(const VolumeKernelScene& scene, int level)
{
  const RootGrid& grid = scene.field.octree().grid();
  const Bounds domain = grid.bounds();
  double width = 0.;
  for (int a = 0; a < 3; ++a)
  {
    width = std::max(width, (domain.max[a] - domain.min[a]) / grid.roots()[a]);
  }
  return std::ldexp(width * scene.dataScale, -level);
}

void fillTable(VolumeKernelScene& scene)
{
  const std::vector<TransferFunction::Entry>& entries = scene.transferFunction.entries();
  const std::size_t perEntry = entriesPerEntry(scene.transferFunction);
  const std::size_t size = (entries.size() - 1) * perEntry + 1;
  // Opaque across a millionth of the smallest leaf: more would only cost the integrals their digits.
  const double opaque = 1e6 / leafWidth(scene, scene.field.octree().leafLevels());
  std::vector<std::array<double, 4>> terms;
  scene.features.categories = scene.transferFunction.hasCategories();
  terms.reserve(scene.features.categories ? 0 : size);
  KernelTable& table = scene.table;
  table.perEntry = static_cast<double>(perEntry);
  table.last = static_cast<float>(size - 1);
  table.entries.resize(size);
  for (std::size_t i = 0; i < size; ++i)
  {
    const TransferFunction::Entry e =
      scene.transferFunction.atPosition(static_cast<double>(i) / table.perEntry);
    table.entries[i] = e;
    const double perUnit = e.extinction / scene.scale;
    table.entries[i].extinction =
      static_cast<float>(std::min<double>(perUnit * std::numbers::log2e, TransferFunction::opaqueExtinction));
    if (!scene.features.categories)
    {
      const double capped = std::min(perUnit, opaque);
      terms.push_back({ capped * e.r, capped * e.g, capped * e.b, capped });
    }
  }
  if (scene.features.categories)
  {
    return; // no leaf varies
  }
  table.variation.assign(size, 0.);
  table.curvature.assign(size, 0.);
  for (std::size_t i = 1; i < size; ++i)
  {
    double change = 0.;
    double bend = 0.;
    for (int c = 0; c < 4; ++c)
    {
      change = std::max(change, std::abs(terms[i][c] - terms[i - 1][c]));
      bend =
        i + 1 < size ? std::max(bend, std::abs(terms[i + 1][c] - 2. * terms[i][c] + terms[i - 1][c])) : 0.;
    }
    table.variation[i] = table.variation[i - 1] + change;
    table.curvature[i] = table.curvature[i - 1] + bend;
  }
  const double error =
    pointSampleError(scene, table.variation.back(), table.curvature.back(), static_cast<double>(size - 1));
  scene.features.preIntegration =
    scene.settings.preIntegration && error * leafWidth(scene, 0) > pointSampleTolerance;
  if (scene.features.preIntegration)
  {
    table.integrals.resize(size);
    std::array<double, 4> sum{};
    for (std::size_t i = 0; i < size; ++i)
    {
      for (int c = 0; c < 4; ++c)
      {
        table.integrals[i].sum[c] = static_cast<float>(sum[c]);
        table.integrals[i].rest[c] = static_cast<float>(sum[c] - table.integrals[i].sum[c]);
        table.integrals[i].own[c] = static_cast<float>(terms[i][c]);
        sum[c] += terms[i][c];
      }
    }
  }
}

/// Without its table.
VolumeKernelScene makeScene(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, BlockCache& kept, Image* image)
{
  VolumeKernelScene scene{ field, transferFunction, camera, stops, settings, kept, image,
    settings.skipEmpty ? &field.nodeRanges() : nullptr, {}, {}, {}, 0., 1., 1., {}, {}, 0., 0. };
  place(scene);
  measurePixels(scene);
  return scene;
}

/// Calls visit(x, y, rgba of the pixel) for a group's pixels that lie in the image.
template <class Visit>
void visitPixels(const PixelGroup& group, const Camera& camera, float* rgba, const Visit& visit)
{
  for (int i = 0; i < PixelGroup::width * PixelGroup::width; ++i, rgba += 4)
  {
    const int x = group.x + i % PixelGroup::width;
    const int y = group.y + i / PixelGroup::width;
    if (x < camera.width() && y < camera.height())
    {
      visit(x, y, rgba);
    }
  }
}

/// A whole image in which all other rays have no part.
void renderGroupsByReference(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings,
  std::span<const PixelGroup> groups, std::span<float> rgba)
{
  Image image(camera.width(), camera.height());
  std::vector<float> begin(image.rgba.size() / 4, 1.f);
  const auto visitAll = [&](const auto& visit) {
    for (std::size_t g = 0; g < groups.size(); ++g)
    {
      visitPixels(groups[g], camera, rgba.data() + g * PixelGroup::rgbaSize,
        [&](int x, int y, float* out) { visit(static_cast<std::size_t>(y) * image.width + x, out); });
    }
  };
  visitAll(
    [&](std::size_t pixel, float*) { begin[pixel] = stops.beginDepth ? stops.beginDepth[pixel] : 0.f; });
  RayStops ofGroups = stops;
  ofGroups.beginDepth = begin.data();
  renderVolumeReference(field, transferFunction, camera, ofGroups, settings, image);
  std::fill(rgba.begin(), rgba.end(), 0.f);
  visitAll([&](std::size_t pixel, float* out) { std::copy_n(image.rgba.data() + 4 * pixel, 4, out); });
}

} // namespace

VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, BlockCache& kept, Image& image)
{
  check(camera, image);
  check(field, transferFunction, camera, stops, settings);
  kept.startFrame(field);
  VolumeKernelScene scene = makeScene(field, transferFunction, camera, stops, settings, kept, &image);
  if (!fitsKernel(field, transferFunction) || !resolves(scene))
  {
    return renderVolumeReference(field, transferFunction, camera, stops, settings, image);
  }
  fillTable(scene);
  if (settings.levelOfDetailPixels > 0. && !scene.features.categories)
  {
    kept.prepareMeans();
  }
  const VolumeLoops loops = volumeLoops(scene.features);
  tbb::combinable<VolumeStatistics> statistics;
  const int rows = (image.height + volumeTileWidth - 1) / volumeTileWidth;
  const int columns = (image.width + volumeTileWidth - 1) / volumeTileWidth;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 1, 0, columns, 4), [&](const auto& tiles) {
    for (int row = tiles.rows().begin(); row < tiles.rows().end(); ++row)
    {
      statistics.local() += loops.renderTiles(scene, row, tiles.cols().begin(), tiles.cols().end());
    }
  });
  const VolumeStatistics all =
    statistics.combine([](VolumeStatistics a, const VolumeStatistics& b) { return a += b; });
  kept.endFrame(all.kept, all.blocks);
  return all;
}

VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, Image& image)
{
  // For this frame only: tiles share the leaves on their borders.
  BlockCache kept(field.octree(), VolumeSettings::defaultKeptBytes);
  return renderVolume(field, transferFunction, camera, stops, settings, kept, image);
}

void renderPixelGroups(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, const VolumeSettings& settings, BlockCache& kept, std::span<const PixelGroup> groups,
  std::span<float> rgba)
{
  check(field, transferFunction, camera, stops, settings);
  check(camera, groups, rgba);
  kept.startFrame(field);
  VolumeKernelScene scene = makeScene(field, transferFunction, camera, stops, settings, kept, nullptr);
  if (!fitsKernel(field, transferFunction) || !resolves(scene))
  {
    renderGroupsByReference(field, transferFunction, camera, stops, settings, groups, rgba);
    return;
  }
  fillTable(scene);
  if (settings.levelOfDetailPixels > 0. && !scene.features.categories)
  {
    kept.prepareMeans();
  }
  const VolumeLoops loops = volumeLoops(scene.features);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups.size(), 4), [&](const auto& part) {
    loops.renderGroups(
      scene, groups.subspan(part.begin(), part.size()), rgba.data() + part.begin() * PixelGroup::rgbaSize);
  });
}

VolumeStatistics renderWithoutWalk(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const VolumeSettings& settings, int repeats, Image& image)
{
  const RayStops stops;
  check(camera, image);
  check(field, transferFunction, camera, stops, settings);
  BlockCache none(field.octree(), 0);
  VolumeKernelScene scene = makeScene(field, transferFunction, camera, stops, settings, none, &image);
  fillTable(scene);
  const auto& entries = scene.table.entries;
  std::size_t faintest = 0;
  for (std::size_t i = 1; i < entries.size(); ++i)
  {
    const float best = entries[faintest].extinction;
    const float e = entries[i].extinction;
    faintest = e > 0.f && (best == 0.f || e < best) ? i : faintest;
  }
  const VolumeLoops loops = volumeLoops(scene.features);
  VolumeStatistics statistics;
  const int columns = (image.width + volumeTileWidth - 1) / volumeTileWidth;
  for (int row = 0; row * volumeTileWidth < image.height; ++row)
  {
    statistics += loops.repeatInCache(scene, row, columns, static_cast<float>(faintest), repeats);
  }
  return statistics;
}

} // namespace treeamr

#include "Volume/Volume.h"

#include "Error.h"
#include "Interpolation/BlockCache.h"
#include "Progress.h"
#include "Volume/Kernel/VolumeKernel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

constexpr const char* colorsOfCategories =
  "volume: categories, and colours by another field: allowed is one of both";

void check(const Camera& camera, const Image& image)
{
  if (image.width != camera.width() || image.height != camera.height())
  {
    throw Error("volume: an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
      " pixels for a camera of " + std::to_string(camera.width()) + " x " + std::to_string(camera.height()));
  }
}

void check(const Field& field, const TransferFunction& transferFunction)
{
  const Range values = field.range();
  if (transferFunction.hasCategories() &&
    !(values.min >= 0.f && values.max < static_cast<float>(transferFunction.entries().size())))
  {
    throw Error("volume: values from " + std::to_string(values.min) + " to " + std::to_string(values.max) +
      " for " + std::to_string(transferFunction.entries().size()) +
      " categories, allowed are their numbers from 0 on");
  }
}

void check(const VolumeShading& shading)
{
  const auto checkAll = [](const char* what, const auto&... numbers) {
    for (const auto& all : { std::span<const double>(numbers)... })
    {
      for (const double number : all)
      {
        if (!std::isfinite(number))
        {
          throw Error("volume: " + std::string(what) + " of " + std::to_string(number) +
            ", allowed are finite numbers");
        }
      }
    }
  };
  const auto three = [](const std::array<float, 3>& rgb) { return Vec3{ rgb[0], rgb[1], rgb[2] }; };
  checkAll("a coefficient of its light", Vec3{ shading.ambient, shading.diffuse, shading.specular },
    three(shading.ambientLight));
  checkAll("an element of the lights' matrix", shading.lightsFromData);
  if (!(shading.specularPower >= 0.f) || !std::isfinite(shading.specularPower))
  {
    throw Error("volume: a specular power of " + std::to_string(shading.specularPower) +
      ", allowed are finite numbers from 0 on");
  }
  for (const Light& light : shading.lights)
  {
    checkAll("a property of a light", light.position, light.direction, light.attenuation, three(light.color),
      three(light.specularColor), Vec3{ light.coneAngle, light.exponent, 0. });
  }
}

void check(const GradientOpacity& function)
{
  if (!(function.longest > 0.) || !std::isfinite(function.longest))
  {
    throw Error("volume: a longest gradient of " + std::to_string(function.longest) +
      ", allowed are finite numbers above 0");
  }
  if (function.entries.size() < 2)
  {
    throw Error(
      "volume: gradient opacity of " + std::to_string(function.entries.size()) + " entries, needed are two");
  }
  for (const float entry : function.entries)
  {
    if (!(entry >= 0.f && entry <= 1.f))
    {
      throw Error("volume: a gradient opacity of " + std::to_string(entry) + ", allowed are 0 to 1");
    }
  }
}

void check(const RayView& view, const VolumeSettings& settings)
{
  if (!(settings.samplesPerCell > 0.) || !(settings.samplesPerCell <= VolumeSettings::maxSamplesPerCell))
  {
    throw Error("volume: " + std::to_string(settings.samplesPerCell) +
      " samples per cell, allowed are values above 0 up to " +
      std::to_string(VolumeSettings::maxSamplesPerCell));
  }
  if (!(settings.leastTransmittance > 0.f) || !(settings.leastTransmittance < 1.f))
  {
    throw Error("volume: rays that end with " + std::to_string(settings.leastTransmittance) +
      " of their light, allowed are values above 0 and below 1");
  }
  view.stops.check(view.camera, "volume");
  const bool isComposite = settings.blend == VolumeBlend::Composite;
  if (view.stops.hits && !isComposite)
  {
    throw Error("volume: surfaces in a blend of values, allowed in composites alone");
  }
  if (!isComposite && (!(settings.unitDistance > 0.) || !std::isfinite(settings.unitDistance)))
  {
    throw Error("volume: a unit distance of " + std::to_string(settings.unitDistance) +
      ", allowed are lengths above 0");
  }
  if (std::isnan(settings.averageRange.min) || std::isnan(settings.averageRange.max))
  {
    throw Error("volume: the range of an average is not a number");
  }
  if (settings.shading)
  {
    check(*settings.shading);
  }
  if (settings.gradientOpacity)
  {
    check(*settings.gradientOpacity);
  }
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

} // namespace

Volume::Volume(std::shared_ptr<const Field> field, TransferFunction transferFunction, std::size_t keptBytes)
  : field_(std::move(field))
  , transferFunction_(std::move(transferFunction))
  , budget_(keptBytes)
{
  if (!field_)
  {
    throw Error("volume: no field");
  }
  check(*field_, transferFunction_);
}

/// Another field that colours.
struct Volume::Colors
{
  std::shared_ptr<const Field> field;
  TransferFunction function; // of extinction 1: the kernel's tables have the colours of what is seen
  std::unique_ptr<VolumeTable> table{};
  std::unique_ptr<BlockCache> kept{};
};

namespace
{

/// A block's gradients take more than three times as much as its values, and much longer to compute.
std::size_t gradientBudget(std::size_t ofValues) noexcept
{
  constexpr std::size_t times = 4;
  return std::min(ofValues, std::numeric_limits<std::size_t>::max() / times) * times;
}

} // namespace

Volume::~Volume() = default;
Volume::Volume(Volume&&) noexcept = default;
Volume& Volume::operator=(Volume&&) noexcept = default;

void Volume::setTransferFunction(TransferFunction transferFunction)
{
  check(*field_, transferFunction);
  if (colors_ && transferFunction.hasCategories())
  {
    throw Error(colorsOfCategories);
  }
  transferFunction_ = std::move(transferFunction);
  table_ = nullptr;
}

void Volume::setColors(std::shared_ptr<const Field> field, const TransferFunction& colors)
{
  std::unique_ptr<Colors> made;
  if (field)
  {
    if (field->sharedOctree() != field_->sharedOctree())
    {
      throw Error("volume: colours of a field in another octree");
    }
    if (colors.hasCategories() || transferFunction_.hasCategories())
    {
      throw Error(colorsOfCategories);
    }
    const bool isSame = colors_ && colors_->field == field;
    made = std::make_unique<Colors>(Colors{ std::move(field), colors.withExtinction(1.f) });
    made->kept = isSame ? std::move(colors_->kept) : nullptr; // a new function changes no values
  }
  colors_ = std::move(made);
}

void Volume::setKeptBytes(std::size_t bytes)
{
  if (bytes != budget_)
  {
    forgetKept();
    budget_ = bytes;
  }
}

std::size_t Volume::keptBytes() const noexcept
{
  return (kept_ ? kept_->byteSize() : 0) + (keptGradients_ ? keptGradients_->byteSize() : 0) +
    (colors_ && colors_->kept ? colors_->kept->byteSize() : 0);
}

/// Gradients and colours take memory while frames use them alone.
void Volume::prepareMemory(bool withGradients, bool withColors, bool withMeans)
{
  if (!kept_)
  {
    kept_ = std::make_unique<BlockCache>(*field_, budget_);
  }
  if (!withGradients)
  {
    keptGradients_ = nullptr;
  }
  else if (!keptGradients_)
  {
    keptGradients_ = std::make_unique<GradientCache>(*field_, gradientBudget(budget_));
  }
  if (colors_ && !withColors)
  {
    colors_->kept = nullptr;
  }
  else if (withColors && !colors_->kept)
  {
    colors_->kept = std::make_unique<BlockCache>(*colors_->field, budget_);
  }
  if (withMeans)
  {
    kept_->prepareMeans();
    if (keptGradients_)
    {
      keptGradients_->prepareMeans();
    }
    if (withColors)
    {
      colors_->kept->prepareMeans();
    }
  }
}

void Volume::forgetKept() noexcept
{
  kept_ = nullptr;
  keptGradients_ = nullptr;
  if (colors_)
  {
    colors_->kept = nullptr;
  }
}

VolumeKernelScene Volume::makeScene(const RayView& view, const VolumeSettings& settings, Image* image)
{
  check(view, settings);
  const Vec3 direction = view.camera.ray(view.camera.width() / 2, view.camera.height() / 2).direction;
  const auto worldMagnitude = static_cast<int>(-std::lround(0.5 * std::log2(dot(direction, direction))));
  if (!table_ || table_->worldMagnitude() != worldMagnitude)
  {
    table_ = std::make_unique<VolumeTable>(*field_, transferFunction_, worldMagnitude);
  }
  const bool hasCategories = transferFunction_.hasCategories();
  const bool withColors = colors_ && settings.blend == VolumeBlend::Composite;
  prepareMemory(
    usesGradients(settings, hasCategories), withColors, settings.levelOfDetailPixels > 0. && !hasCategories);
  VolumeKernelScene scene(
    *field_, transferFunction_, *table_, view, settings, *kept_, keptGradients_.get(), image);
  if (withColors)
  {
    if (!colors_->table)
    {
      colors_->table = std::make_unique<VolumeTable>(*colors_->field, colors_->function, 0);
      colors_->table->integrate(colors_->function);
    }
    scene.colorBy(std::make_shared<const VolumeKernelScene>(
      *colors_->field, colors_->function, *colors_->table, view, settings, *colors_->kept, nullptr, nullptr));
  }
  if (scene.features.preIntegration)
  {
    table_->integrate(transferFunction_);
  }
  return scene;
}

VolumeStatistics Volume::render(const RayView& view, const VolumeSettings& settings, Image& image)
{
  check(view.camera, image);
  const VolumeKernelScene scene = makeScene(view, settings, &image);
  const VolumeLoops loops = volumeLoops(scene.features);
  tbb::combinable<VolumeStatistics> statistics;
  const int rows = (image.height + volumeTileWidth - 1) / volumeTileWidth;
  const int columns = (image.width + volumeTileWidth - 1) / volumeTileWidth;
  constexpr int together = 4;
  const auto renderRow = [&](int row, int begin, int end) {
    const int atOnce = view.progress ? together : end - begin; // however many tiles a task has
    for (int column = begin; column < end; column += atOnce)
    {
      const int next = std::min(column + atOnce, end);
      statistics.local() += loops.renderTiles(scene, row, column, next);
      if (view.progress)
      {
        view.progress->step(next - column);
      }
    }
  };
  if (view.progress)
  {
    view.progress->begin(static_cast<std::size_t>(rows) * columns);
  }
  tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 1, 0, columns, together), [&](const auto& tiles) {
    for (int row = tiles.rows().begin(); row < tiles.rows().end(); ++row)
    {
      renderRow(row, tiles.cols().begin(), tiles.cols().end());
    }
  });
  const VolumeStatistics all =
    statistics.combine([](VolumeStatistics a, const VolumeStatistics& b) { return a += b; });
  kept_->endFrame(all.kept, all.blocks);
  if (keptGradients_)
  {
    keptGradients_->endFrame(all.keptGradients, all.gradients);
  }
  if (scene.colors)
  {
    colors_->kept->endFrame(all.keptColors, all.colors);
  }
  return all;
}

void Volume::renderGroups(const RayView& view, const VolumeSettings& settings,
  std::span<const PixelGroup> groups, std::span<float> rgba)
{
  check(view.camera, groups, rgba);
  const VolumeKernelScene scene = makeScene(view, settings, nullptr);
  const VolumeLoops loops = volumeLoops(scene.features);
  if (view.progress)
  {
    view.progress->begin(groups.size());
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups.size(), 4), [&](const auto& part) {
    loops.renderGroups(
      scene, groups.subspan(part.begin(), part.size()), rgba.data() + part.begin() * PixelGroup::rgbaSize);
    if (view.progress)
    {
      view.progress->step(part.size());
    }
  });
}

VolumeStatistics Volume::renderWithoutWalk(
  const Camera& camera, const VolumeSettings& settings, int repeats, Image& image)
{
  check(camera, image);
  const VolumeKernelScene scene = makeScene(camera, settings, &image);
  std::size_t faintest = 0;
  for (std::size_t i = 1; i < table_->entries.size(); ++i)
  {
    const float best = table_->entries[faintest].extinction;
    const float e = table_->entries[i].extinction;
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

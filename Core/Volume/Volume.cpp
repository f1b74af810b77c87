#include "Volume/Volume.h"

#include "Error.h"
#include "Geometry/Bounds.h"
#include "Interpolation/BlockCache.h"
#include "Progress.h"
#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/ShadowLattice.h"
#include "Volume/TileRelay.h"
#include "Volume/VolumeChecks.h"

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

static_assert(TileRun::tileWidth == volumeTileWidth);

VolumeStatistics sum(VolumeStatistics a, const VolumeStatistics& b) noexcept
{
  return a += b;
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
  checkVolume(*field_, transferFunction_);
}

/// Other fields that take part, and the same of the volume's own where it is one of several.
struct Volume::Mixture
{
  struct Part
  {
    std::shared_ptr<const Field> field;
    TransferFunction function;
    std::unique_ptr<VolumeTable> table{};       // with integrals
    std::unique_ptr<BlockCache> kept{};         // null: the volume's own
    std::unique_ptr<GradientCache> gradients{}; // null: likewise, or it is not lit
    VolumeSettings settings{};                  // of the last frame, of a component that is lit
  };

  VolumeMixing mixing;
  std::vector<Part> parts;
  std::array<float, 4> weights{};
  std::unique_ptr<const KernelTable2D> table{}; // null: there is none
};

namespace
{

std::size_t multiple(std::size_t budget, std::size_t times) noexcept
{
  return std::min(budget, std::numeric_limits<std::size_t>::max() / times) * times;
}

/// A block's gradients take three times as much as its values, and much longer to compute.
std::size_t gradientBudget(std::size_t ofValues) noexcept
{
  return multiple(ofValues, 4);
}

/// Gives a field room for the values of a frame. Where that has gradients, too, opacity by them lets rays see more of a
/// volume than it has room for without: twice as much, once that is so.
void prepareValues(const Field& field, std::size_t budget, bool withGradients, std::unique_ptr<BlockCache>& kept)
{
  const std::size_t most = withGradients ? multiple(budget, 2) : budget;
  const bool suffices = kept && (kept->budget() == most || (kept->budget() == budget && !kept->isFull()));
  if (!suffices)
  {
    kept = nullptr; // first: not both at once
    kept = std::make_unique<BlockCache>(field, most);
  }
}

} // namespace

Volume::~Volume() = default;
Volume::Volume(Volume&&) noexcept = default;
Volume& Volume::operator=(Volume&&) noexcept = default;

void Volume::setTransferFunction(TransferFunction transferFunction)
{
  checkVolume(*field_, transferFunction);
  if (mixture_ && mixture_->table)
  {
    mixture_ = nullptr;
  }
  if (mixture_ && transferFunction.hasCategories())
  {
    throw Error(colorsOfCategories);
  }
  transferFunction_ = std::move(transferFunction);
  table_ = nullptr;
  shadows_ = nullptr;
  if (mixture_ && mixture_->mixing == VolumeMixing::Independent)
  {
    mixture_->parts[0].function = transferFunction_;
    mixture_->parts[0].table = nullptr;
  }
}

void Volume::setColors(std::shared_ptr<const Field> field, const TransferFunction& colors)
{
  Mixture mixture{ VolumeMixing::Colors, {}, {} };
  if (field)
  {
    checkPart(field, colors);
    // Of extinction 1: the tables have the colours of what is seen.
    mixture.parts.push_back({ std::move(field), colors.withExtinction(1.f) });
  }
  mix(std::move(mixture));
}

void Volume::setChannels(const std::array<std::shared_ptr<const Field>, 3>& rgb)
{
  Mixture mixture{ VolumeMixing::Channels, {}, {} };
  for (const std::shared_ptr<const Field>& field : rgb)
  {
    if (field)
    {
      const Range range = field->range();
      const float end = range.max > range.min ? 1.f : 0.f;
      TransferFunction ramp(range.min, range.max, { { 0.f, 0.f, 0.f, 1.f }, { end, end, end, 1.f } });
      checkPart(field, ramp);
      mixture.parts.push_back({ field, std::move(ramp) });
    }
  }
  if (!mixture.parts.empty() && mixture.parts.size() != rgb.size())
  {
    throw Error("volume: colours of " + std::to_string(mixture.parts.size()) + " channels, needed are three");
  }
  mix(std::move(mixture));
}

void Volume::setComponents(std::vector<Component> others, float ownWeight)
{
  Mixture mixture{ VolumeMixing::Independent, {}, {} };
  if (others.size() > mixture.weights.size() - 1)
  {
    throw Error("volume: " + std::to_string(others.size() + 1) + " components, allowed are four");
  }
  if (!others.empty())
  {
    others.insert(others.begin(), { field_, transferFunction_, ownWeight });
  }
  for (Component& component : others)
  {
    checkPart(component.field, component.function);
    if (!(component.weight >= 0.f) || !std::isfinite(component.weight))
    {
      throw Error("volume: a component's weight of " + std::to_string(component.weight) +
        ", allowed are finite numbers from 0 on");
    }
    mixture.weights[mixture.parts.size()] = component.weight;
    mixture.parts.push_back({ std::move(component.field), std::move(component.function) });
  }
  mix(std::move(mixture));
}

void Volume::setTable(std::shared_ptr<const Field> second, const TransferFunction2D& table)
{
  Mixture mixture{ VolumeMixing::Table, {}, {} };
  mixture.table = std::make_unique<const KernelTable2D>(
    table, diagonalOf(field_->octree().grid().bounds()), second == nullptr);
  if (second)
  {
    TransferFunction most = table.mostOverSecond();
    checkPart(second, most);
    mixture.parts.push_back({ std::move(second), std::move(most) });
  }
  transferFunction_ = table.mostOverFirst();
  table_ = nullptr;
  mix(std::move(mixture));
}

void Volume::checkPart(const std::shared_ptr<const Field>& field, const TransferFunction& function) const
{
  if (required(field, "volume").sharedOctree() != field_->sharedOctree())
  {
    throw Error("volume: colours of a field in another octree");
  }
  if (function.hasCategories() || transferFunction_.hasCategories())
  {
    throw Error(colorsOfCategories);
  }
}

/// What fields had, they keep: new functions change no values.
void Volume::mix(Mixture mixture)
{
  if (mixture.parts.empty() && !mixture.table)
  {
    mixture_ = nullptr;
    return;
  }
  auto made = std::make_unique<Mixture>(std::move(mixture));
  for (Mixture::Part& part : made->parts)
  {
    for (std::size_t i = 0; mixture_ && !part.kept && i < mixture_->parts.size(); ++i)
    {
      Mixture::Part& before = mixture_->parts[i];
      if (before.field == part.field)
      {
        part.kept = std::move(before.kept);
        part.gradients = std::move(before.gradients);
      }
    }
  }
  mixture_ = std::move(made);
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
  std::size_t bytes = (kept_ ? kept_->byteSize() : 0) + (keptGradients_ ? keptGradients_->byteSize() : 0) +
    (shadows_ ? shadows_->byteSize() : 0);
  for (std::size_t i = 0; mixture_ && i < mixture_->parts.size(); ++i)
  {
    const Mixture::Part& part = mixture_->parts[i];
    bytes += (part.kept ? part.kept->byteSize() : 0) + (part.gradients ? part.gradients->byteSize() : 0);
  }
  return bytes;
}

/// Values, gradients and colours take memory while frames use them alone.
void Volume::prepareMemory(bool withValues, bool withGradients, bool withColors, bool withMeans)
{
  const std::size_t budget = withValues ? budget_ : 0;
  prepareValues(*field_, budget, withGradients, kept_);
  const bool isLitByColors = withColors && isColoredByOther();
  if (!withGradients || isLitByColors)
  {
    keptGradients_ = nullptr;
  }
  else if (!keptGradients_)
  {
    keptGradients_ = std::make_unique<GradientCache>(*field_, gradientBudget(budget_));
  }
  for (std::size_t i = 0; mixture_ && i < mixture_->parts.size(); ++i)
  {
    Mixture::Part& part = mixture_->parts[i];
    if (!withColors || part.field == field_)
    {
      part.kept = nullptr;
      part.gradients = nullptr;
      continue;
    }
    prepareValues(*part.field, budget, withGradients, part.kept);
    if (!withGradients || (mixture_->mixing != VolumeMixing::Independent && !isLitByColors))
    {
      part.gradients = nullptr;
    }
    else if (!part.gradients)
    {
      part.gradients = std::make_unique<GradientCache>(*part.field, gradientBudget(budget_));
    }
    if (withMeans)
    {
      part.kept->prepareMeans();
      if (part.gradients)
      {
        part.gradients->prepareMeans();
      }
    }
  }
  if (withMeans)
  {
    kept_->prepareMeans();
    if (keptGradients_)
    {
      keptGradients_->prepareMeans();
    }
  }
}

void Volume::forgetKept() noexcept
{
  kept_ = nullptr;
  keptGradients_ = nullptr;
  for (std::size_t i = 0; mixture_ && i < mixture_->parts.size(); ++i)
  {
    mixture_->parts[i].kept = nullptr;
    mixture_->parts[i].gradients = nullptr;
  }
}

VolumeKernelScene Volume::makeScene(const RayView& view, const VolumeSettings& settings, Image* image)
{
  checkVolume(view, settings);
  const Vec3 direction = view.camera.ray(view.camera.width() / 2, view.camera.height() / 2).direction;
  const auto worldMagnitude = static_cast<int>(-std::lround(0.5 * std::log2(dot(direction, direction))));
  if (!table_ || table_->worldMagnitude() != worldMagnitude)
  {
    table_ = std::make_unique<VolumeTable>(*field_, transferFunction_, worldMagnitude);
  }
  const bool hasCategories = transferFunction_.hasCategories();
  const bool withColors = mixture_ && !blendsValues(settings.blend);
  const bool areIndependent = withColors && mixture_->mixing == VolumeMixing::Independent;
  const KernelTable2D* const ofTwo = withColors ? mixture_->table.get() : nullptr;
  const bool areLit = areIndependent && settings.shading && !settings.nearest;
  const bool withGradients = ofTwo ? ofTwo->byGradient || settings.shading
    : areIndependent               ? areLit
                                   : usesGradients(settings, hasCategories);
  prepareMemory(!hasCategories && !settings.nearest, withGradients, withColors,
    settings.levelOfDetailPixels > 0. && !hasCategories);
  const Mixture::Part* const lights = withColors && isColoredByOther() ? &mixture_->parts.front() : nullptr;
  VolumeKernelScene scene(*field_, transferFunction_, *table_, view, settings, *kept_,
    areIndependent ? nullptr
      : lights     ? lights->gradients.get()
                   : keptGradients_.get(),
    image);
  if (lights)
  {
    scene.ofGradients = lights->field.get();
  }
  if (withColors)
  {
    KernelMixture mixture{ mixture_->mixing, {}, mixture_->weights, ofTwo };
    for (Mixture::Part& part : mixture_->parts)
    {
      const int magnitude = areIndependent ? worldMagnitude : 0; // colours have none
      if (!part.table || part.table->worldMagnitude() != magnitude)
      {
        part.table = std::make_unique<VolumeTable>(*part.field, part.function, magnitude);
        part.table->integrate(part.function);
      }
      GradientCache* const gradients = !areLit ? nullptr
        : part.gradients                       ? part.gradients.get()
                                               : keptGradients_.get();
      if (areLit)
      {
        part.settings = settings;
        part.settings.gradientOpacity.reset();
        const std::size_t i = mixture.parts.size();
        part.settings.shading = i > 0 && i <= settings.componentShading.size()
          ? settings.componentShading[i - 1]
          : settings.shading;
      }
      mixture.parts.push_back(
        std::make_shared<const VolumeKernelScene>(*part.field, part.function, *part.table, view,
          areLit ? part.settings : settings, part.kept ? *part.kept : *kept_, gradients, nullptr));
    }
    scene.mix(std::move(mixture));
  }
  if (scene.features.preIntegration)
  {
    table_->integrate(transferFunction_);
  }
  scatter(settings, scene);
  return scene;
}

bool Volume::isColoredByOther() const noexcept
{
  return mixture_ && mixture_->mixing == VolumeMixing::Colors && mixture_->parts.front().field != field_;
}

bool Volume::canScatter() const noexcept
{
  return !mixture_ || (mixture_->mixing != VolumeMixing::Independent && mixture_->mixing != VolumeMixing::Table);
}

/// Shadows take memory while frames use them alone.
void Volume::scatter(const VolumeSettings& settings, VolumeKernelScene& scene)
{
  const bool isAsked = settings.shading && settings.shading->scattering && !blendsValues(settings.blend);
  if (isAsked && !canScatter())
  {
    throw Error("volume: scattered light, and several components or a function of two values: allowed is one of both");
  }
  if (!isAsked || !scene.illumination || !scene.illumination->shades)
  {
    shadows_ = nullptr;
    return;
  }
  if (!shadows_ || shadows_->gradientOpacity() != settings.gradientOpacity)
  {
    table_->integrate(transferFunction_);
    shadows_ = std::make_unique<ShadowLattice>(
      *field_, transferFunction_, *table_->integrals, settings.gradientOpacity);
  }
  const VolumeScattering& scattering = *settings.shading->scattering;
  shadows_->illuminate(scene.illumination->sources(settings.shading->lightsFromData), scattering.reach,
    scene.dataScale / scene.scale);
  scene.illumination->scatter(scattering, *shadows_, scene);
}

VolumeStatistics Volume::render(const RayView& view, const VolumeSettings& settings, Image& image)
{
  checkVolume(view.camera, image);
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
  const VolumeStatistics all = statistics.combine(sum);
  endFrame(scene, all);
  return all;
}

VolumeStatistics Volume::render(
  const RayView& view, const VolumeSettings& settings, Image& image, TileRelay& relay)
{
  checkVolume(view.camera, image);
  VolumeKernelScene scene = makeScene(view, settings, &image);
  scene.goesOn = true;
  scene.relay = relay.box() ? &relay : nullptr;
  if (blendsValues(settings.blend))
  {
    relay.showBy([&scene](float* rgba) { showBlend(scene, rgba); });
  }
  const VolumeLoops loops = volumeLoops(scene.features);
  tbb::combinable<VolumeStatistics> statistics;
  if (view.progress)
  {
    const auto tiles = [](int pixels) { return (pixels + volumeTileWidth - 1) / volumeTileWidth; };
    view.progress->begin(static_cast<std::size_t>(tiles(image.width)) * tiles(image.height));
  }
  relayTiles(relay, [&](const TileRun& run) {
    statistics.local() += loops.renderTiles(scene, run.row, run.columnBegin, run.columnEnd);
    if (view.progress)
    {
      view.progress->step(run.columnEnd - run.columnBegin);
    }
  });
  const VolumeStatistics all = statistics.combine(sum);
  endFrame(scene, all);
  return all;
}

void Volume::endFrame(const VolumeKernelScene& scene, const VolumeStatistics& all)
{
  kept_->endFrame(all.kept, all.blocks);
  if (keptGradients_)
  {
    keptGradients_->endFrame(all.keptGradients, all.gradients);
  }
  for (std::size_t i = 0; scene.mixture && i < mixture_->parts.size(); ++i)
  {
    if (mixture_->parts[i].kept)
    {
      mixture_->parts[i].kept->endFrame(all.keptColors, all.colors);
    }
    if (mixture_->parts[i].gradients)
    {
      mixture_->parts[i].gradients->endFrame(all.keptGradients, all.gradients);
    }
  }
}

void Volume::renderGroups(const RayView& view, const VolumeSettings& settings,
  std::span<const PixelGroup> groups, std::span<float> rgba)
{
  checkVolume(view.camera, groups, rgba);
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
  checkVolume(camera, image);
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

#include "Volume/ErrorEstimate.h"

#include "Error.h"
#include "Volume/Kernel/VolumeKernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace treeamr
{

namespace
{

/// Of the samples, for what a frame is compared with: leaves a sixteenth of its error.
constexpr double refinement = 4.;
/// Below it more samples per cell hardly add to those that every block has.
constexpr double leastConverged = 16.;
/// Of the light that a ray which ended had left: between nothing and all.
constexpr double missedByEnds = 0.5;
/// One group of pixels in so many, within limits: a few dozen estimate an error to a fifth of it.
constexpr std::size_t groupsPerChosen = 500;
constexpr std::size_t leastChosen = 96;
constexpr std::size_t mostChosen = 128;
/// Groups of which one is chosen: to look at all of a large image would take as long as the rays.
constexpr std::size_t candidatesPerChosen = 16;
/// Added to a group's variation: even colours may be wrong.
constexpr float litWeight = 0.02f;
constexpr float unlitWeight = 0.001f;

/// Whether a function changes within a part of the field's range that floats along a ray hardly tell.
bool needsDoubles(const Field& field, const TransferFunction& transferFunction)
{
  constexpr double part = 0x1p-13;
  const Range range = field.range();
  const double least = part * (static_cast<double>(range.max) - range.min);
  const auto& nodes = transferFunction.nodes();
  return std::adjacent_find(nodes.begin(), nodes.end(),
           [&](const auto& a, const auto& b) { return b.value - a.value < least; }) != nodes.end();
}

/// i-th member of the low-discrepancy sequence of the golden ratio in [0, 1).
double golden(std::size_t i)
{
  const double x = static_cast<double>(i + 1) / std::numbers::phi;
  return x - std::floor(x);
}

/// Of what may be wrong in a group of pixels, from its corners.
float expectedError(const Image& frame, const PixelGroup& group)
{
  const int x1 = std::min(group.x + PixelGroup::width, frame.width) - 1;
  const int y1 = std::min(group.y + PixelGroup::width, frame.height) - 1;
  std::array<float, 4> low{ 2.f, 2.f, 2.f, 2.f };
  std::array<float, 4> high{};
  for (const auto& [x, y] : { std::array{ group.x, group.y }, { x1, group.y }, { group.x, y1 }, { x1, y1 } })
  {
    const float* rgba = frame.rgba.data() + 4 * (static_cast<std::size_t>(y) * frame.width + x);
    for (int c = 0; c < 4; ++c)
    {
      low[c] = std::min(low[c], rgba[c]);
      high[c] = std::max(high[c], rgba[c]);
    }
  }
  const float variation = std::max({ high[0] - low[0], high[1] - low[1], high[2] - low[2] });
  return variation + (high[3] > 0.f ? litWeight : unlitWeight);
}

} // namespace

ErrorEstimator::ErrorEstimator(
  Volume& volume, const RayView& view, const VolumeSettings& settings, const Image& frame)
  : volume_(volume)
  , view_(view)
  , settings_(settings)
{
  const Camera& camera = view.camera;
  if (frame.width != camera.width() || frame.height != camera.height())
  {
    throw Error("error estimate: a frame of " + std::to_string(frame.width) + " x " +
      std::to_string(frame.height) + " pixels for a camera of " + std::to_string(camera.width()) + " x " +
      std::to_string(camera.height()));
  }
  choose(frame);
  std::vector<float> ofFrame(groups_.size() * PixelGroup::rgbaSize, 0.f);
  for (std::size_t g = 0; g < groups_.size(); ++g)
  {
    const auto [x, y] = groups_[g];
    const int columns = std::min(PixelGroup::width, frame.width - x);
    for (int row = 0; row < std::min(PixelGroup::width, frame.height - y); ++row)
    {
      std::copy_n(frame.rgba.data() + 4 * (static_cast<std::size_t>(y + row) * frame.width + x), 4 * columns,
        ofFrame.data() + g * PixelGroup::rgbaSize + static_cast<std::size_t>(row) * 4 * PixelGroup::width);
    }
  }
  refine(settings.samplesPerCell);
  ofSamples_ = errorOfSamples(ofFrame);
  ofEnds_ = settings.blend == VolumeBlend::Composite ? errorOfEnds(ofFrame) : 0.;
}

void ErrorEstimator::choose(const Image& frame)
{
  constexpr int perTile = volumeTileWidth / PixelGroup::width;
  const int columns = (frame.width + volumeTileWidth - 1) / volumeTileWidth;
  const int rows = (frame.height + volumeTileWidth - 1) / volumeTileWidth;
  const std::size_t all =
    static_cast<std::size_t>(columns) * rows * perTile * perTile; // also beyond the image
  const std::size_t count = std::clamp(all / groupsPerChosen, leastChosen, mostChosen);
  const std::size_t step = std::max<std::size_t>(1, all / (count * candidatesPerChosen));

  std::vector<PixelGroup> candidates; // in the order of tiles
  std::vector<double> sums;           // of weights up to and with each
  for (std::size_t i = 0; i * step < all; ++i)
  {
    const std::size_t index = i * step + static_cast<std::size_t>(golden(i) * static_cast<double>(step));
    const auto tile = static_cast<int>(index / (perTile * perTile));
    const auto inTile = static_cast<int>(index % (perTile * perTile));
    const PixelGroup group{ tile % columns * volumeTileWidth + inTile % perTile * PixelGroup::width,
      tile / columns * volumeTileWidth + inTile / perTile * PixelGroup::width };
    if (group.x < frame.width && group.y < frame.height)
    {
      candidates.push_back(group);
      sums.push_back(expectedError(frame, group) + (sums.empty() ? 0. : sums.back()));
    }
  }
  if (candidates.empty())
  {
    return;
  }
  const double values = 3. * frame.width * frame.height;
  const double perDraw = sums.back() / static_cast<double>(count);
  std::size_t at = 0;
  std::size_t last = candidates.size(); // drawn last
  for (std::size_t i = 0; i < count; ++i)
  {
    const double sum = (static_cast<double>(i) + golden(i)) * perDraw;
    while (at + 1 < candidates.size() && sums[at] <= sum)
    {
      ++at;
    }
    if (at != last)
    {
      groups_.push_back(candidates[at]);
      weights_.push_back(0.);
      last = at;
    }
    const double chance = (sums[at] - (at > 0 ? sums[at - 1] : 0.)) / perDraw / static_cast<double>(step);
    weights_.back() += 1. / (chance * values);
  }
}

std::vector<float> ErrorEstimator::render(double samplesPerCell, bool doubles)
{
  std::vector<float> rgba(groups_.size() * PixelGroup::rgbaSize);
  VolumeSettings settings = settings_;
  settings.samplesPerCell = samplesPerCell;
  settings.doubles = settings.doubles || doubles;
  volume_.renderGroups(view_, settings, groups_, rgba);
  return rgba;
}

void ErrorEstimator::refine(double samplesPerCell)
{
  const double wanted =
    std::min(std::max(refinement * samplesPerCell, leastConverged), VolumeSettings::maxSamplesPerCell);
  if (wanted > convergedSamples_)
  {
    converged_ = render(wanted, needsDoubles(volume_.field(), volume_.transferFunction()));
    convergedSamples_ = wanted;
  }
}

template <class Squares>
double ErrorEstimator::rootOfSum(const Squares& squares) const noexcept
{
  double all = 0.;
  for (std::size_t g = 0; g < groups_.size(); ++g)
  {
    double ofGroup = 0.;
    for (std::size_t i = g * PixelGroup::rgbaSize; i < (g + 1) * PixelGroup::rgbaSize; i += 4)
    {
      ofGroup += squares(i);
    }
    all += weights_[g] * ofGroup;
  }
  return std::sqrt(all);
}

double ErrorEstimator::errorOfSamples(const std::vector<float>& rgba) const noexcept
{
  return rootOfSum([&](std::size_t i) {
    double sum = 0.;
    for (std::size_t c = i; c < i + 3; ++c)
    {
      const double difference = static_cast<double>(rgba[c]) - converged_[c];
      sum += difference * difference;
    }
    return sum;
  });
}

double ErrorEstimator::errorOfEnds(const std::vector<float>& rgba) const noexcept
{
  return rootOfSum([&](std::size_t i) {
    const double opacity = rgba[i + 3];
    const double missed = opacity > 1. - opaqueTransmittance ? missedByEnds * (1. - opacity) / opacity : 0.;
    return missed * missed * (rgba[i] * rgba[i] + rgba[i + 1] * rgba[i + 1] + rgba[i + 2] * rgba[i + 2]);
  });
}

double ErrorEstimator::findSamplesPerCell(double target, double least, double most)
{
  struct Try
  {
    double samples;
    double error;
  };
  std::vector<Try> tries;
  const auto attempt = [&](double samples) {
    refine(samples);
    tries.push_back({ samples, errorOfSamples(render(samples, false)) });
    return tries.back();
  };
  // What is left of the target for the samples; half of it where the ends of rays alone would miss it.
  const double allowed = std::max(0.5 * target, std::sqrt(std::max(0., target * target - ofEnds_ * ofEnds_)));
  // Neighbouring settings on the two sides of that.
  Try misses{ std::clamp(settings_.samplesPerCell, least, most), ofSamples_ };
  Try meets = misses;
  tries.push_back(misses);
  if (misses.error > allowed)
  {
    while (meets.error > allowed)
    {
      if (meets.samples == most)
      {
        // The fewest that are about as good as the best.
        constexpr double alike = 1.1;
        const double best = std::ranges::min(tries, {}, &Try::error).error;
        return std::ranges::find_if(tries, [&](const Try& t) { return t.error <= alike * best; })->samples;
      }
      misses = meets;
      meets = attempt(std::min(2. * misses.samples, most));
    }
  }
  else
  {
    while (misses.error <= allowed)
    {
      if (misses.samples == least)
      {
        return least;
      }
      meets = misses;
      misses = attempt(std::max(0.5 * meets.samples, least));
    }
  }
  // In between about a power of the samples, with jumps where many blocks get one sample more or are integrated in
  // another way.
  constexpr int refinements = 2;
  for (int i = 0; i < refinements && allowed > 0.; ++i)
  {
    const double part =
      std::log(misses.error / allowed) / (std::log(misses.error) - std::log(std::max(meets.error, 1e-12)));
    const Try between =
      attempt(misses.samples * std::pow(meets.samples / misses.samples, std::clamp(part, 0.1, 0.9)));
    (between.error > allowed ? misses : meets) = between;
  }
  return meets.samples;
}

bool ErrorTarget::update(ErrorEstimator& estimator, double target)
{
  // Room for what the estimate errs by and for other views; within it the samples stay what they are.
  constexpr double aim = 0.7;
  constexpr double aimOfFewer = 0.75;
  constexpr double low = 0.5;
  const double before = samplesPerCell_;
  const double error = estimator.error();
  if (error > target)
  {
    samplesPerCell_ = estimator.findSamplesPerCell(aim * target, least, most);
  }
  else if (error < low * target || target != triedTarget_)
  {
    // Once for each target also of a frame within the room: where samples hardly matter, far fewer may do.
    samplesPerCell_ =
      std::min(before, estimator.findSamplesPerCell(std::max(aimOfFewer * target, error), least, most));
  }
  triedTarget_ = target;
  return error > target && samplesPerCell_ > before;
}

} // namespace treeamr

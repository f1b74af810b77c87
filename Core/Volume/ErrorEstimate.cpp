#include "Volume/ErrorEstimate.h"

#include "Error.h"
#include "Volume/Kernel/VolumeKernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

/// Of the samples, for what a frame is compared with: leaves a sixteenth of its error.
constexpr double refinement = 4.;
/// Below it more samples per cell hardly add to those that every block has.
constexpr double leastConverged = 16.;
/// Rays of what a frame is compared with end when this is left of their light.
constexpr float convergedTransmittance = 0x1p-16f;
/// One group of pixels in so many, within limits: a few dozen estimate an error to a fifth of it.
constexpr std::size_t groupsPerChosen = 500;
constexpr std::size_t leastChosen = 96;
constexpr std::size_t mostChosen = 128;
/// Groups of which one is chosen: to look at all of a large image would take as long as the rays.
constexpr std::size_t candidatesPerChosen = 16;
/// The groups of a thorough estimate, the samples that show where errors are, in those of the frame, and the part of
/// the groups that is drawn by what these change.
constexpr std::size_t thoroughlyChosen = 256;
constexpr double compared = 2.;
constexpr double leastCompared = 4.;
constexpr double partByChange = 0.75;
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

ErrorEstimator::ErrorEstimator(Volume& volume, const RayView& view, const VolumeSettings& settings,
  const Image& frame, EstimateEffort effort)
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
  choose(frame, effort);
  const std::vector<float> rgba = ofFrame(frame);
  refine(settings.samplesPerCell);
  error_ = errorOf(rgba);
}

std::vector<float> ErrorEstimator::ofFrame(const Image& frame) const
{
  std::vector<float> rgba(groups_.size() * PixelGroup::rgbaSize, 0.f);
  for (std::size_t g = 0; g < groups_.size(); ++g)
  {
    const auto [x, y] = groups_[g];
    const int columns = std::min(PixelGroup::width, frame.width - x);
    for (int row = 0; row < std::min(PixelGroup::width, frame.height - y); ++row)
    {
      std::copy_n(frame.rgba.data() + 4 * (static_cast<std::size_t>(y + row) * frame.width + x), 4 * columns,
        rgba.data() + g * PixelGroup::rgbaSize + static_cast<std::size_t>(row) * 4 * PixelGroup::width);
    }
  }
  return rgba;
}

void ErrorEstimator::choose(const Image& frame, EstimateEffort effort)
{
  constexpr int perTile = volumeTileWidth / PixelGroup::width;
  const int columns = (frame.width + volumeTileWidth - 1) / volumeTileWidth;
  const int rows = (frame.height + volumeTileWidth - 1) / volumeTileWidth;
  const std::size_t all =
    static_cast<std::size_t>(columns) * rows * perTile * perTile; // also beyond the image
  const std::size_t count = effort == EstimateEffort::Thorough
    ? thoroughlyChosen
    : std::clamp(all / groupsPerChosen, leastChosen, mostChosen);
  const std::size_t step = std::max<std::size_t>(1, all / (count * candidatesPerChosen));

  std::vector<double> expected; // by candidate
  for (std::size_t i = 0; i * step < all; ++i)
  {
    const std::size_t index = i * step + static_cast<std::size_t>(golden(i) * static_cast<double>(step));
    const auto tile = static_cast<int>(index / (perTile * perTile));
    const auto inTile = static_cast<int>(index % (perTile * perTile));
    const PixelGroup group{ tile % columns * volumeTileWidth + inTile % perTile * PixelGroup::width,
      tile / columns * volumeTileWidth + inTile / perTile * PixelGroup::width };
    if (group.x < frame.width && group.y < frame.height)
    {
      groups_.push_back(group); // in the order of tiles
      expected.push_back(expectedError(frame, group));
    }
  }
  if (effort == EstimateEffort::Thorough)
  {
    addChange(frame, expected);
  }
  draw(expected, count);
  for (double& weight : weights_)
  {
    weight *= static_cast<double>(step) / (3. * frame.width * frame.height);
  }
}

void ErrorEstimator::addChange(const Image& frame, std::vector<double>& expected)
{
  const std::vector<float> before = ofFrame(frame);
  VolumeSettings settings = withSamples(std::max(compared * settings_.samplesPerCell, leastCompared));
  settings.leastTransmittance = convergedTransmittance;
  const std::vector<float> after = render(settings);
  std::vector<double> squares(expected.size(), 0.);
  for (std::size_t i = 0; i < before.size(); ++i)
  {
    squares[i / PixelGroup::rgbaSize] +=
      i % 4 < 3 ? std::pow(static_cast<double>(before[i]) - after[i], 2) : 0.;
  }
  const double sum = std::accumulate(squares.begin(), squares.end(), 0.);
  const double sumOfExpected = std::accumulate(expected.begin(), expected.end(), 0.);
  for (std::size_t g = 0; g < expected.size() && sum > 0.; ++g)
  {
    expected[g] = partByChange * squares[g] / sum + (1. - partByChange) * expected[g] / sumOfExpected;
  }
}

void ErrorEstimator::draw(const std::vector<double>& expected, std::size_t count)
{
  const std::vector<PixelGroup> candidates = std::exchange(groups_, {});
  const double perDraw = std::accumulate(expected.begin(), expected.end(), 0.) / static_cast<double>(count);
  double sum = 0.;
  std::size_t drawn = 0;
  for (std::size_t g = 0; g < candidates.size(); ++g)
  {
    sum += expected[g];
    std::size_t times = 0;
    for (; drawn < count && (static_cast<double>(drawn) + golden(drawn)) * perDraw < sum; ++drawn)
    {
      ++times;
    }
    if (times > 0)
    {
      groups_.push_back(candidates[g]);
      weights_.push_back(static_cast<double>(times) * perDraw / expected[g]);
    }
  }
}

std::vector<float> ErrorEstimator::render(const VolumeSettings& settings)
{
  std::vector<float> rgba(groups_.size() * PixelGroup::rgbaSize);
  volume_.renderGroups(view_, settings, groups_, rgba);
  return rgba;
}

VolumeSettings ErrorEstimator::withSamples(double samplesPerCell) const
{
  VolumeSettings settings = settings_;
  settings.samplesPerCell = std::min(samplesPerCell, VolumeSettings::maxSamplesPerCell);
  return settings;
}

void ErrorEstimator::refine(double samplesPerCell)
{
  VolumeSettings settings = withSamples(std::max(refinement * samplesPerCell, leastConverged));
  if (settings.samplesPerCell > convergedSamples_)
  {
    settings.leastTransmittance = convergedTransmittance;
    settings.doubles = settings.doubles || needsDoubles(volume_.field(), volume_.transferFunction());
    converged_ = render(settings);
    convergedSamples_ = settings.samplesPerCell;
  }
}

double ErrorEstimator::errorOf(const std::vector<float>& rgba) const noexcept
{
  double all = 0.;
  for (std::size_t g = 0; g < groups_.size(); ++g)
  {
    double ofGroup = 0.;
    for (std::size_t i = g * PixelGroup::rgbaSize; i < (g + 1) * PixelGroup::rgbaSize; ++i)
    {
      ofGroup += i % 4 < 3 ? std::pow(static_cast<double>(rgba[i]) - converged_[i], 2) : 0.;
    }
    all += weights_[g] * ofGroup;
  }
  return std::sqrt(all);
}

double ErrorEstimator::errorWith(double samplesPerCell)
{
  refine(samplesPerCell);
  return errorOf(render(withSamples(samplesPerCell)));
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
    tries.push_back({ samples, errorWith(samples) });
    return tries.back();
  };
  // Neighbouring settings on the two sides of the target.
  Try misses{ std::clamp(settings_.samplesPerCell, least, most), error_ };
  Try meets = misses;
  tries.push_back(misses);
  if (misses.error > target)
  {
    while (meets.error > target)
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
    while (misses.error <= target)
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
  for (int i = 0; i < refinements && target > 0.; ++i)
  {
    const double part =
      std::log(misses.error / target) / (std::log(misses.error) - std::log(std::max(meets.error, 1e-12)));
    const Try between =
      attempt(misses.samples * std::pow(meets.samples / misses.samples, std::clamp(part, 0.1, 0.9)));
    (between.error > target ? misses : meets) = between;
  }
  return meets.samples;
}

bool ErrorTarget::update(ErrorEstimator& estimator, double target)
{
  // Room for what the estimate errs by.
  constexpr double aim = 0.95;
  const double before = samplesPerCell_;
  const bool misses = estimator.error() > target;
  if (misses)
  {
    samplesPerCell_ = estimator.findSamplesPerCell(aim * target, least, most);
  }
  else if (const double half = 0.5 * before; half >= least)
  {
    // While half of the samples are too few they stay what they are.
    const double error = estimator.errorWith(half);
    if (error <= target)
    {
      samplesPerCell_ = estimator.findSamplesPerCell(std::max(aim * target, error), least, before);
    }
  }
  return misses && samplesPerCell_ > before;
}

} // namespace treeamr

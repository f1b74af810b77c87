#include "ImageReduction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace treeamr
{

namespace
{

int reducedSize(int size, double distance)
{
  return std::clamp(static_cast<int>(std::ceil(size / distance)), 1, size);
}

/// Pixel of `full` in which the centre of pixel i of `reduced` lies.
int pixelAt(int i, int reduced, int full)
{
  return static_cast<int>((2 * static_cast<std::int64_t>(i) + 1) * full / (2 * reduced));
}

} // namespace

ImageReduction::ImageReduction(int width, int height, double distance)
  : fullWidth_(width)
  , fullHeight_(height)
  , width_(reducedSize(width, distance))
  , height_(reducedSize(height, distance))
{
}

std::vector<float> ImageReduction::sample(const std::vector<float>& full) const
{
  std::vector<int> columns(width_);
  for (int x = 0; x < width_; ++x)
  {
    columns[x] = pixelAt(x, width_, fullWidth_);
  }
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(width_) * height_);
  for (int y = 0; y < height_; ++y)
  {
    const float* row = full.data() + static_cast<std::size_t>(pixelAt(y, height_, fullHeight_)) * fullWidth_;
    for (const int x : columns)
    {
      values.push_back(row[x]);
    }
  }
  return values;
}

double SampleDistanceControl::choose(double allowedTime, double minimum, double maximum)
{
  // A fifth of the time, about the noise of a busy machine.
  constexpr double worthwhile = 1.1;
  double distance = 0.5 * maximum;
  if (fullTime_ > 0.)
  {
    distance = std::sqrt(fullTime_ / allowedTime);
    const double change = distance_ > 0. ? std::max(distance / distance_, distance_ / distance) : worthwhile;
    // Below the minimum the distance is the minimum, not a little more for ever.
    distance = change < worthwhile && distance > minimum ? distance_ : distance;
  }
  distance_ = std::max(minimum, std::min(distance, maximum));
  return distance_;
}

void SampleDistanceControl::record(double distance, double time, bool interactive)
{
  if (!interactive && interactive_)
  {
    return;
  }
  const double fullTime = time * distance * distance;
  // The geometric mean: halves too long and too short alike.
  fullTime_ = interactive && interactive_ ? std::sqrt(fullTime_ * fullTime) : fullTime;
  interactive_ = interactive;
}

void SampleDistanceControl::agree(const Largest& largest)
{
  // Times of still frames, which draw more, do not count beside those of drafts.
  std::array<double, 3> state{ interactive_ ? fullTime_ : 0., interactive_ ? 0. : fullTime_, distance_ };
  largest(state);
  interactive_ = state[0] > 0.;
  fullTime_ = interactive_ ? state[0] : state[1];
  distance_ = state[2];
}

} // namespace treeamr

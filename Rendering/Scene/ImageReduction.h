// Images of fewer rays than the window has pixels, and how many fewer. Private to the module.
#pragma once

#include <array>
#include <functional>
#include <vector>

namespace treeamr
{

/// How the pixels of a reduced image lie over those of a viewport: both cover the same rectangle, edge to
/// edge, so a reduced image is that of a camera of fewer pixels, and its pixels need not be square.
class ImageReduction
{
public:
  /// Rays at least every `distance` >= 1 pixels in each direction of a viewport of width x height.
  ImageReduction(int width, int height, double distance);

  /// Of the viewport.
  int fullWidth() const noexcept { return fullWidth_; }
  int fullHeight() const noexcept { return fullHeight_; }
  /// Of the reduced image.
  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  /// One ray a pixel.
  bool isFull() const noexcept { return width_ == fullWidth_ && height_ == fullHeight_; }

  /// height() x width() values, each of the viewport's pixel in which the centre of a reduced pixel lies (the
  /// upper right one of those that meet there), from fullHeight() x fullWidth(), lower left first.
  std::vector<float> sample(const std::vector<float>& full) const;

private:
  int fullWidth_;
  int fullHeight_;
  int width_;
  int height_;
};

/// Finds the distance between rays with which a frame takes the time it may take, from the times of frames
/// before. Times are in any unit, the same throughout.
///
/// The cost of a frame is taken to be that of a full image over the distance's square. As some of the time
/// does not depend on the distance, an estimate is off, but not on the wrong side: corrected frame by frame
/// the distance approaches its limit without overshooting it. Estimates are averaged, and small changes left
/// out: a resolution that follows the noise of a clock flickers.
class SampleDistanceControl
{
public:
  /// For an interactive frame. Within the limits; half of the maximum when nothing has been measured.
  double choose(double allowedTime, double minimum, double maximum);
  /// What a frame with that distance took. Still frames count until an interactive one has been measured:
  /// these draw less detail.
  void record(double distance, double time, bool interactive);
  /// Of many processes that draw one picture: goes on as the slowest would. To be called on all; largest(numbers): makes
  /// each number the largest of all processes'.
  using Largest = std::function<void(std::array<double, 3>&)>;
  void agree(const Largest& largest);

private:
  double fullTime_ = 0.; // estimated; 0: unknown
  double distance_ = 0.; // chosen last; 0: none
  bool interactive_ = false;
};

} // namespace treeamr

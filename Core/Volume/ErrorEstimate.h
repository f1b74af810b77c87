// How far a frame of a volume is from the converged one, without the converged one: some of its pixels are
// integrated again with more samples.
//
// Groups of 4 x 4 pixels are drawn evenly over the image, more of them where it varies, and each difference counts
// by the inverse of its group's chance: the estimate has no bias but that of what it compares with. That is the
// same integral with `refinement` times the samples. Midpoint samples err by about the inverse square of their
// number, so the difference is the error up to a few per cent, whatever the order is exactly: it varies with the
// transfer function, with pre-integration and between levels, and so does not make a good correction (Richardson).
//
// What no samples change is added: where a ray ended, because it had hardly any light left, half of that light counts
// as an error. All of it is one where the volume goes on as before, nothing where it ends there, too.
#pragma once

#include "Volume/Volume.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace treeamr
{

/// Errors are root mean squares over red, green and blue, premultiplied, peak 1, of all pixels of the image, also
/// of those where nothing is drawn. They are of the integration along the rays alone, not of what levels of detail,
/// fewer rays than pixels or the reconstruction add. Nor do they hold what all frames have in common but the ends of
/// rays: vertex values in steps and the transfer function's table, together less than 1e-4 (80 dB). An error of few
/// pixels may be missed, as that of a function with a step to opaque under many samples.
class ErrorEstimator
{
public:
  /// The frame is one that the volume has rendered, the other arguments are those it was given: volume, camera and
  /// stops must outlive this. The same result on any number of threads. Throws Error as Volume::render().
  ErrorEstimator(Volume& volume, const RayView& view, const VolumeSettings& settings, const Image& frame);

  /// Of the frame.
  double error() const noexcept { return std::hypot(ofSamples_, ofEnds_); }
  /// About the least samples per cell, in [least, most], with which the frame's error meets the target. When it cannot
  /// be met, because rays end or the samples are not enough, those with which samples hardly add to the error, or come
  /// as close as they do. Integrates the pixels again for each of the settings tried.
  double findSamplesPerCell(double target, double least, double most);

private:
  void choose(const Image& frame);
  std::vector<float> render(double samplesPerCell, bool doubles);
  void refine(double samplesPerCell);
  /// Root of the weighted sum of the squares of a pixel's three: by index of the first.
  template <class Squares>
  double rootOfSum(const Squares& squares) const noexcept;
  double errorOfSamples(const std::vector<float>& rgba) const noexcept;
  double errorOfEnds(const std::vector<float>& rgba) const noexcept;

  Volume& volume_;
  RayView view_;
  VolumeSettings settings_;
  std::vector<PixelGroup> groups_;
  std::vector<double> weights_;  // by group: of its squared errors in those of the image
  std::vector<float> converged_; // by group, as Volume::renderGroups() gives it
  double convergedSamples_ = 0.; // per cell
  double ofSamples_ = 0.;        // parts of the frame's error
  double ofEnds_ = 0.;
};

/// The samples per cell of a sequence of frames that shall come to a target with as few as possible.
class ErrorTarget
{
public:
  static constexpr double least = 0.25;
  static constexpr double most = 64.;

  /// samplesPerCell: to begin with.
  explicit ErrorTarget(double samplesPerCell) noexcept
    : samplesPerCell_(std::clamp(samplesPerCell, least, most))
  {
  }
  /// Of the next frame.
  double samplesPerCell() const noexcept { return samplesPerCell_; }
  /// estimator: of a frame with samplesPerCell(). target: above 0, as ErrorEstimator::error(). True when that frame
  /// misses the target and the same one with the new samplesPerCell() should meet it, or come closer.
  bool update(ErrorEstimator& estimator, double target);

private:
  double samplesPerCell_;
  double triedTarget_ = 0.; // of the frame before
};

} // namespace treeamr

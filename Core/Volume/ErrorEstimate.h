// How far a frame of a volume is from the converged one, without the converged one: some of its pixels are
// integrated again with more samples.
//
// Groups of 4 x 4 pixels are drawn evenly over the image, more of them where it varies, and each difference counts
// by the inverse of its group's chance: the estimate has no bias but that of what it compares with. That is the
// same integral with `refinement` times the samples. Midpoint samples err by about the inverse square of their
// number, so the difference is the error up to a few per cent, whatever the order is exactly: it varies with the
// transfer function, with pre-integration and between levels, and so does not make a good correction (Richardson).
//
// Its rays also go on where those of the frame end because hardly any light is left.
#pragma once

#include "Volume/Volume.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace treeamr
{

/// What an estimate may cost, of a frame of a million pixels, and how far it is from the error of all pixels.
enum class EstimateEffort
{
  Quick,   // 2 to 3 %; mostly within a fourth, but few pixels that err may be missed
  Thorough // 20 to 30 %; mostly within a twentieth: a first look at many pixels finds those that err
};

/// Errors are root mean squares over red, green and blue, premultiplied, peak 1, of all pixels of the image, also
/// of those where nothing is drawn. They are of the integration along the rays alone, not of what levels of detail,
/// fewer rays than pixels or the reconstruction add. Nor do they hold what all frames have in common: vertex values in
/// steps and the transfer function's table, together less than 1e-4 (80 dB).
class ErrorEstimator
{
public:
  /// The frame is one that the volume has rendered, the other arguments are those it was given: volume, camera and
  /// stops must outlive this. The same result on any number of threads. Throws Error as Volume::render().
  ErrorEstimator(Volume& volume, const RayView& view, const VolumeSettings& settings, const Image& frame,
    EstimateEffort effort = EstimateEffort::Quick);

  /// Of the frame.
  double error() const noexcept { return error_; }
  /// Of the same frame with other samples, from its pixels that were chosen; these are integrated again.
  double errorWith(double samplesPerCell);
  /// About the least samples per cell, in [least, most], with which the frame's error meets the target. When it cannot
  /// be met, because rays end or the samples are not enough, those with which samples hardly add to the error, or come
  /// as close as they do. Integrates the pixels again for each of the settings tried.
  double findSamplesPerCell(double target, double least, double most);

private:
  void choose(const Image& frame, EstimateEffort effort);
  /// To the expected errors of all groups: by what more samples change in them.
  void addChange(const Image& frame, std::vector<double>& expected);
  /// Keeps so many of the groups, in proportion to their expected errors.
  void draw(const std::vector<double>& expected, std::size_t count);
  std::vector<float> ofFrame(const Image& frame) const;
  VolumeSettings withSamples(double samplesPerCell) const;
  std::vector<float> render(const VolumeSettings& settings);
  void refine(double samplesPerCell);
  double errorOf(const std::vector<float>& rgba) const noexcept;

  Volume& volume_;
  RayView view_;
  VolumeSettings settings_;
  std::vector<PixelGroup> groups_;
  std::vector<double> weights_;  // by group: of its squared errors in those of the image
  std::vector<float> converged_; // by group, as Volume::renderGroups() gives it
  double convergedSamples_ = 0.; // per cell
  double error_ = 0.;            // of the frame
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
};

} // namespace treeamr

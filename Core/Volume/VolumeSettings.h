// What a frame of a volume is asked for, and what it did.
#pragma once

#include <cstdint>

namespace treeamr
{

struct VolumeSettings
{
  /// Samples along a cell's width, up to the maximum, where the transfer function varies in the cell; fewer
  /// where little can change, but one at least for each cell or block of eight that a ray crosses.
  double samplesPerCell = 2.;
  static constexpr double maxSamplesPerCell = 1e6;
  /// Leave out nodes whose range is transparent. Never changes a pixel; off only to test that.
  bool skipEmpty = true;
  /// Integrate over the values between samples where points would miss too much of the transfer function; off only
  /// to measure that.
  bool preIntegration = true;
  /// Count in doubles where floats would do, too; on only to test that.
  bool doubles = false;
  /// Nodes whose children are smaller than this many pixels may be drawn from their means; 0 is off.
  double levelOfDetailPixels = 0.;
};

struct VolumeStatistics
{
  std::uint64_t rays = 0;      // that had a part of the view to themselves
  std::uint64_t nodes = 0;     // inner nodes entered
  std::uint64_t kept = 0;      // blocks of leaves whose vertex values were found
  std::uint64_t blocks = 0;    // that were computed
  std::uint64_t cells = 0;     // leaves in these
  std::uint64_t intervals = 0; // vectors of rays taken through a leaf or block
  std::uint64_t steps = 0;     // of these vectors
  std::uint64_t litSteps = 0;  // that were not transparent for all of their rays
  std::uint64_t samples = 0;   // of the field along rays

  VolumeStatistics& operator+=(const VolumeStatistics& other) noexcept
  {
    rays += other.rays;
    nodes += other.nodes;
    kept += other.kept;
    blocks += other.blocks;
    cells += other.cells;
    intervals += other.intervals;
    steps += other.steps;
    litSteps += other.litSteps;
    samples += other.samples;
    return *this;
  }
};

} // namespace treeamr

// Direct volume rendering (the paper's section 6.1): emission and absorption, front to back.
#pragma once

#include "Field/Field.h"
#include "Field/TransferFunction.h"
#include "Geometry/Camera.h"
#include "Geometry/Image.h"
#include "Geometry/RayStops.h"
#include "MemoryBudget.h"

#include <cstdint>
#include <span>

namespace treeamr
{

class BlockCache;

/// A ray with less light left than this is done: a quarter of what an 8-bit channel shows.
inline constexpr float opaqueTransmittance = 1.f / 1024.f;

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
  /// Nodes whose children are smaller than this many pixels may be drawn from their means; 0 is off.
  double levelOfDetailPixels = 0.;

  /// Budget of a BlockCache that suits most scenes.
  static constexpr std::size_t defaultKeptBytes = treeamr::defaultKeptBytes;
};

/// What a frame did.
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

/// Renders into `image` (overwritten), on all threads. `kept` must have been made for this field and holds
/// what the next frame need not compute again. A ray is integrated from stop to stop, with no sample across one; what
/// the stops hide from all rays is not visited. Throws Error when the image's size or that of the stops is not the
/// camera's, `kept` is another field's, the settings are not finite and positive or a value is none of the transfer
/// function's categories.
VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, BlockCache& kept,
  Image& image);

/// 4 x 4 neighbouring pixels.
struct PixelGroup
{
  static constexpr int width = 4;
  static constexpr int rgbaSize = 4 * width * width;
  int x; // of the lower left pixel, a multiple of width
  int y;
};

/// The pixels of these groups as renderVolume() gives them, to the bit. rgba: rgbaSize floats for each group, row by
/// row from the lower left as in Image; pixels beyond the image are 0. Neighbours in the list that are neighbours in
/// the image, too, cost less. Throws Error as renderVolume(), and for a group outside the image.
void renderPixelGroups(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, const VolumeSettings& settings, BlockCache& kept, std::span<const PixelGroup> groups,
  std::span<float> rgba);

/// For benchmarks: takes the camera's rays through a block of the transfer function's faintest value `repeats`
/// times, on this thread, with the tree walk and the memory of vertex values left out: what an interval, a step
/// and a lit step take at least.
VolumeStatistics renderWithoutWalk(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const VolumeSettings& settings, int repeats, Image& image);
/// The same as renderVolume() above for a single frame.
VolumeStatistics renderVolume(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, Image& image);

} // namespace treeamr

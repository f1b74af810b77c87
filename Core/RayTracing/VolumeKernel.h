// What the vectorised volume renderer is given, and its entry: one source for every instruction set.
#pragma once

#include "RayTracing/VertexCache.h"
#include "RayTracing/VolumeRenderer.h"

namespace treeamr
{

/// The kernel counts in single precision from `reference`, in units that make the domain's diagonal 1, so
/// that neither offsets nor units cost it digits.
struct VolumeKernelScene
{
  const Field& field;
  const TransferFunction& transferFunction;
  const Camera& camera;
  const DepthInterval& interval;
  const VolumeSettings& settings;
  VertexCache& kept;
  Image& image;

  Vec3 reference;    // data coordinates; the eye when all rays start there
  bool commonOrigin; // all rays start at the reference
  double tReference; // t that the kernel counts from
  double scale;      // kernel units per unit of world length and of data coordinates

  /// Transfer function with extinctions per kernel unit; nearest entry.
  std::vector<TransferFunction::Entry> table;
};

constexpr int volumeTileWidth = 16;

/// Renders the tiles [columnBegin, columnEnd) of a row of tiles.
VolumeStatistics renderVolumeTiles(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd);

} // namespace treeamr

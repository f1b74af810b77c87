// What the vectorised volume renderer is given, and its entry: one source for every instruction set.
#pragma once

#include "RayTracing/VertexCache.h"
#include "RayTracing/VolumeRenderer.h"

namespace treeamr
{

/// What a frame needs beyond the common case. Chosen once; each combination is compiled apart.
struct SceneFeatures
{
  bool commonOrigin = true; // all rays start at one point
};

/// The transfer function for the kernel: nearest entry, extinctions in binary orders of magnitude of light per
/// kernel unit.
struct KernelTable
{
  std::vector<TransferFunction::Entry> entries;
  /// Total variation of extinction, and of extinction times colour, before each entry, natural logarithm: the
  /// larger of them, per kernel unit.
  std::vector<double> variation;
};

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

  SceneFeatures features;
  Vec3 reference;    // data coordinates; the eye when all rays start there
  double tReference; // t that the kernel counts from
  double scale;      // kernel units per unit of world length and of data coordinates
  PixelFan fan;      // in data coordinates; common origin only
  KernelTable table;
  /// Width of a pixel at the kernel's t, in kernel units: at t = 0, and its growth.
  double pixelWidth;
  double pixelGrowth;
};

constexpr int volumeTileWidth = 16;

/// Renders the tiles [columnBegin, columnEnd) of a row of tiles.
VolumeStatistics renderVolumeTiles(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd);

} // namespace treeamr

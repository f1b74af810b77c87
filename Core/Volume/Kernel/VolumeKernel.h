// What the vectorised volume renderer is given, and its entry: one source for every instruction set.
#pragma once

#include "Interpolation/BlockCache.h"
#include "Volume/Kernel/VolumeTable.h"
#include "Volume/Volume.h"

#include <algorithm>
#include <span>

namespace treeamr
{

/// What a frame needs beyond the common case, chosen once: what is absent costs nothing.
struct SceneFeatures
{
  bool commonOrigin = true;    // all rays start at one point; compiled apart
  bool doubles = false;        // floats do not resolve the view, the domain or the values; compiled apart
  bool preIntegration = false; // some cell may vary more than samples of the table can follow
  bool categories = false;     // each leaf is one constant
};

/// The kernel counts, in floats unless its features tell otherwise, from `reference`, in units that make the domain's
/// diagonal 1, both as a length on the central ray and in data coordinates, so that neither offsets nor units cost it
/// digits.
struct VolumeKernelScene
{
  /// Refers to all of these. The table's integrals are wanted when the features tell so.
  VolumeKernelScene(const Field& field, const TransferFunction& transferFunction, const VolumeTable& table,
    const RayView& view, const VolumeSettings& settings, BlockCache& kept, Image* image);

  const Field& field;
  const TransferFunction& transferFunction;
  const VolumeTable& table;
  const Camera& camera;
  const RayStops& stops;
  const VolumeSettings& settings;
  BlockCache& kept;
  Image* image;             // null: only groups of pixels are rendered
  const NodeRanges* ranges; // null: nothing is skipped

  SceneFeatures features;
  Vec3 reference;    // data coordinates; the eye when all rays start there
  Vec3 direction;    // of the ray in the image's middle, of all rays in parallel projection
  double tReference; // t that the kernel counts from
  double scale;      // kernel units per unit of world length
  double dataScale;  // and of data coordinates
  PixelFan fan;      // common origin only
  /// Width of a pixel at the kernel's t, in kernel units: at t = 0, and its growth.
  double pixelWidth;
  double pixelGrowth;

private:
  void place();
  void measurePixels();
  bool resolves() const;
};

/// What the transfer function does in a hull, per kernel unit.
struct HullTerms
{
  double variation; // of the optical depth
  double curvature; // sum of what bends in it
  double entries;   // the hull's width
};

/// Whether points follow the optical depth along one width of a leaf: what lies between two samples may be missed, at
/// most the whole variation, but a smooth function errs by its bend over the square of the samples; and what a sample
/// stands for must not hide itself. For any number of samples, so that more of them are never worse.
inline bool pointsSuffice(const VolumeKernelScene& scene, const HullTerms& hull, double leafWidth) noexcept
{
  constexpr double mostMissed = 0.8;
  constexpr double mostBent = 6.4;
  constexpr double mostAtOnce = 4.;
  const double length = scene.dataScale / scene.scale * leafWidth;
  const double variation = length * hull.variation;
  return variation <= mostMissed ||
    (variation <= mostAtOnce && length * hull.curvature * hull.entries <= mostBent);
}

constexpr int volumeTileWidth = 16;
static_assert(volumeTileWidth == 4 * PixelGroup::width);

/// A variant of the kernel, compiled for the best instruction set of this machine.
struct VolumeLoops
{
  /// Renders the tiles [columnBegin, columnEnd) of a row of tiles.
  VolumeStatistics (*renderTiles)(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd);
  /// See Volume::renderGroups().
  void (*renderGroups)(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba);
  /// See Volume::renderWithoutWalk(). position: in the table.
  VolumeStatistics (*repeatInCache)(
    const VolumeKernelScene& scene, int row, int columns, float position, int repeats);
};

VolumeLoops volumeLoopsFromOnePoint();
VolumeLoops volumeLoopsOfAnyRays();
VolumeLoops volumeLoopsInDoubles();
/// That a scene needs.
VolumeLoops volumeLoops(const SceneFeatures& features);

} // namespace treeamr

// Isosurfaces as one eye sees them: the hits of its rays, kept until something moves, and what is known of these
// besides. Private to the module.
#pragma once

#include "ImageReduction.h"
#include "SurfaceLevels.h"
#include "SurfaceShading.h"

#include "Geometry/Camera.h"
#include "Geometry/RayStops.h"
#include "Progress.h"
#include "Surface/Isosurface.h"
#include "Surface/Shading.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace treeamr
{

/// How a picture of surfaces is taken.
struct SurfacePose
{
  Matrix4 clipFromData{};
  Matrix4 viewFromData{};
  int width = 0; // of the viewport, in pixels
  int height = 0;
  SurfaceLayers layers = SurfaceLayers::Nearest;
  SurfaceNormals normals = SurfaceNormals::Smooth;
  DataCut cut;
  std::size_t mostHits = std::numeric_limits<std::size_t>::max(); // of a pixel, nearest first

  bool operator==(const SurfacePose&) const = default;
};

/// What secondary rays are wanted.
struct SecondaryRays
{
  int occlusionSamples = 0;
  double occlusionRadius = 0.;                          // length in the view
  int mostNewSamples = std::numeric_limits<int>::max(); // of a call
  bool shadows = false;
};

class SurfaceView
{
public:
  SurfaceView() = default;
  SurfaceView(const SurfaceView&) = delete;
  SurfaceView& operator=(const SurfaceView&) = delete;

  /// Whether the hits are those of this pose, at whatever distance of rays.
  bool isOf(const SurfacePose& pose) const { return camera_ && pose_ == pose; }
  /// Traces the hits, rays at least `distance` pixels apart; levelOfDetail: pixels of that picture below which cells
  /// are drawn together, or 0. Throws Error as Isosurface(), and Interrupted; then there are no hits.
  void trace(SurfaceLevels& levels, const SurfacePose& pose, double distance, double levelOfDetail,
    Progress* progress = nullptr);
  /// The hits and the surfaces.
  void release();

  /// Of the last trace().
  const std::shared_ptr<const Isosurface>& surface() const noexcept { return surface_; }
  const ImageReduction& reduction() const noexcept { return reduction_; }
  double sampleDistance() const noexcept { return sampleDistance_; }
  const SurfacePose& pose() const noexcept { return pose_; }
  const HitImage& hits() const noexcept { return hits_; }
  const Camera& camera() const noexcept { return *camera_; }

  /// Length in the view of the longest diagonal of the grid's bounds.
  double diagonalOf(const RootGrid& grid) const;
  /// What of the wanted rays is not known yet is traced. Throws Interrupted.
  const SurfaceVisibility& updateVisibility(
    const SecondaryRays& wanted, const std::vector<Light>& lights, Progress* progress = nullptr);

private:
  SurfacePose pose_;
  std::optional<Camera> camera_; // none: no hits
  std::shared_ptr<const Isosurface> surface_;
  ImageReduction reduction_{ 1, 1, 1. };
  double sampleDistance_ = 0.;
  HitImage hits_;
  SurfaceVisibility visibility_;
  std::vector<std::uint16_t> openRays_; // of the occlusionRays_ of each hit
  int occlusionRays_ = 0;
  double occlusionRadius_ = 0.;
  std::vector<Light> shadowLights_;
};

} // namespace treeamr

// Implicit isosurface ray tracing (the paper's section 6.2): no triangles, a hit is a root of the cubic that
// the reconstructed field is along a ray in an octant.
#pragma once

#include "Field/Field.h"
#include "Geometry/RayView.h"
#include "MemoryBudget.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace treeamr
{

/// Where a ray meets a surface.
struct SurfaceHit
{
  double t;      // along the ray, as its maker counts
  Vec3 gradient; // of the field, d value / d data coordinate
  /// To shade by, in data coordinates: unit length, towards higher values, to the second order the normal of the
  /// surface that the field approximates, and continuous across all levels (BlockGradients.h). 0 where that vanishes
  /// and where no normals were asked for.
  std::array<float, 3> normal;
  std::uint32_t surface; // which of Isosurface::isovalues()
  std::uint32_t block;   // where Isosurface::cell() finds the cell
  std::uint8_t octant;   // of the block
};

/// Hits of each pixel's ray, nearest first: those of pixel p = x + width * y, lower left first, are
/// hits[first[p]] up to hits[first[p + 1]].
struct HitImage
{
  LargeVector<std::size_t> first; // width * height + 1 places
  LargeVector<SurfaceHit> hits;   // of all pixels, one after the other
};

/// Throws Error, on behalf of `user`, when the hits are not those of a picture of the camera's size.
void checkPixels(const HitImage& hits, const Camera& camera, const char* user);

/// Which hits of a ray an image has.
enum class SurfaceLayers
{
  Nearest, // one hit per pixel at most
  All      // nearest first
};

/// What hits are to be shaded by.
enum class SurfaceNormals
{
  Smooth, // SurfaceHit::normal
  None    // those of the gradients do
};

/// What there is of surfaces, and what making them took.
struct IsosurfaceStatistics
{
  std::size_t blocks = 0;         // inner nodes that a surface may pass through
  std::size_t blockBytes = 0;     // of their list
  std::size_t hierarchyBytes = 0; // Embree's, and for layers one more
  std::size_t keptBytes = 0;      // of vertex values
  std::size_t gradientBytes = 0;  // of vertex gradients
  double extractionSeconds = 0.;  // of wall time
  double hierarchySeconds = 0.;   // the same, of the hierarchy
};

/// The surfaces of some isovalues of a field, which it keeps, to be met by rays.
class Isosurface
{
public:
  static constexpr std::size_t defaultKeptBytes = treeamr::defaultKeptBytes; // 512 MiB
  static constexpr int allCellDepths = Octree::maxDepth;                     // no level of detail

  /// Finds the nodes that the surfaces of the isovalues may pass through and builds Embree's hierarchy over
  /// them. Vertex values are computed where rays come and kept within keptBytes; gradients where normals are asked for,
  /// within half as much again and what all values leave. Cells deeper than mostCellDepth
  /// (at least 1; a root's is 0) are drawn together by their means, as level of detail (see cellDepthFor()), but
  /// for those that would be together with ghosts. Throws Error without a field or isovalues, for one that is not
  /// finite, or when Embree fails.
  Isosurface(std::shared_ptr<const Field> field, std::vector<double> isovalues,
    std::size_t keptBytes = defaultKeptBytes, int mostCellDepth = allCellDepths);
  ~Isosurface();
  Isosurface(const Isosurface&) = delete;
  Isosurface& operator=(const Isosurface&) = delete;

  /// Ascending, each once.
  const std::vector<double>& isovalues() const noexcept;
  /// As they are now: values are kept while rays come.
  IsosurfaceStatistics statistics() const;
  /// Octants that a surface passes through. The first call takes a while: it looks at all of them. As
  /// startFrame(), while no thread queries.
  std::uint64_t octantCount() const;

  /// Call before a frame, while no thread queries: gives values of earlier views up where the budget is
  /// short, and draws the hierarchy tighter around the surfaces as rays have come to know them. No hit
  /// depends on it. Throws Error when Embree fails; then there are no hits.
  void startFrame() const;
  /// The latter alone, before many rays that are no frame.
  void tighten() const;

  /// First hit along the ray with t in [tMin, tMax]; false: none. Safe from several threads, as all queries.
  bool intersect(const Ray& ray, double tMin, double tMax, SurfaceHit& hit) const;
  /// All hits there, ascending.
  void intersectAll(const Ray& ray, double tMin, double tMax, std::vector<SurfaceHit>& hits) const;
  /// Whether there is any hit.
  bool occluded(const Ray& ray, double tMin, double tMax) const;
  /// Whether there is any in what the cut leaves.
  bool occluded(const Ray& ray, double tMin, double tMax, const DataCut& cut) const;
  /// Hits between the camera's near and far planes, of what the stops leave. Of all layers each pixel gets the
  /// nearest mostHits at most. Throws Interrupted when the view's progress is ended: then the image is of no use.
  void render(const RayView& view, SurfaceLayers layers, HitImage& image,
    std::size_t mostHits = std::numeric_limits<std::size_t>::max(),
    SurfaceNormals normals = SurfaceNormals::Smooth) const;

  /// Its place.
  CellId cell(const SurfaceHit& hit) const noexcept;
  /// Width of that leaf along its shortest axis, in data coordinates.
  double leafWidth(const SurfaceHit& hit) const noexcept;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace treeamr

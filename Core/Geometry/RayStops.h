// Where along a pixel's ray what is drawn begins, ends and changes: window depths, clipping planes, cropping
// regions, a box, translucent surfaces. Each is kept as what it is, a plane as a plane and not as its place on a
// million rays, and met ray by ray when a renderer asks: so fewer rays than pixels, the other eye of a stereo
// window and single pixels have the same stops, and what is absent takes neither time nor memory.
#pragma once

#include "Geometry/Bounds.h"
#include "Geometry/Camera.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace treeamr
{

/// Points p of data coordinates with normal . p >= offset.
struct HalfSpace
{
  Vec3 normal;   // of any length; 0 has all points or, with a positive offset, none
  double offset; // along the normal, times its length

  bool operator==(const HalfSpace&) const = default;
};

/// Two planes across each axis of data coordinates make 27 regions, each shown or hidden: those of
/// vtkVolumeMapper.
struct CroppingRegions
{
  std::array<double, 6> planes; // lower and upper x, y, z
  /// Bit x + 3 y + 9 z; 0 is below the lower plane, 1 between the two, 2 above the upper one. What is below the lower plane
  /// is so where it is above the upper one, too, as in VTK.
  std::uint32_t shown;

  /// Whether nothing can be between the planes of an axis.
  bool hasNoMiddle() const noexcept
  {
    return planes[0] >= planes[1] || planes[2] >= planes[3] || planes[4] >= planes[5];
  }
  /// Of data coordinates; a point in a plane is not between the two.
  bool shows(const Vec3& point) const noexcept;
  bool operator==(const CroppingRegions&) const = default;
};

/// A translucent surface on a ray.
struct TranslucentHit
{
  double t;                  // as Camera::ray() counts
  std::array<float, 4> rgba; // not premultiplied; opacity in [0, 1]
};

/// Those on all of a camera's rays, nearest first: of pixel p = x + width * y, lower left first,
/// hits[first[p]] up to hits[first[p + 1]]. Does not own them.
struct TranslucentHits
{
  std::span<const std::size_t> first;   // width * height + 1 places
  std::span<const TranslucentHit> hits; // of all pixels, one after the other
};

/// The drawn parts of one ray: half-open intervals of t, ascending, apart from each other, none of them empty.
struct RayParts
{
  /// A ray crosses six cropping planes at most, and every other one of its seven parts is shown.
  static constexpr int most = 4;
  int count = 0;                  // of parts, 0 to most
  std::array<double, most> begin; // t of each part
  std::array<double, most> end;   // likewise

  /// One more, behind the others.
  void add(double from, double to) noexcept
  {
    begin[count] = from;
    end[count++] = to;
  }
};

/// What is drawn of data coordinates: what is in all half spaces and in a shown region.
struct DataCut
{
  std::vector<HalfSpace> halfSpaces;       // of clipping planes; none: all of space
  std::optional<CroppingRegions> cropping; // none: all regions

  /// Whether nothing is cut away.
  bool isEmpty() const noexcept { return halfSpaces.empty() && !cropping; }
  /// Draws what is in the box alone.
  void addBox(const Bounds& box);
  /// What is left of a ray's [begin, end). The direction may have any length: t counts in it. The end may be infinite.
  RayParts parts(const Vec3& origin, const Vec3& direction, double begin, double end) const noexcept;

  bool operator==(const DataCut&) const = default;
};

/// The stops of an image's rays. Without any of these everything between the near and the far plane is drawn.
struct RayStops
{
  /// The part of each ray in window depths [0, 1]: nothing where begin >= end. Null stands for 0 or 1 everywhere;
  /// else width * height entries, lower left first. Not owned.
  const float* beginDepth = nullptr;
  const float* endDepth = nullptr; // as beginDepth
  DataCut cut;                     // in data coordinates
  /// Surfaces in the volume, shown whether or not it is cut away around them: who makes the hits has cut them already.
  /// A ray has those from its begin depth up to, but without, its end depth.
  std::optional<TranslucentHits> hits;

  /// Of depths alone.
  static RayStops depths(const float* begin, const float* end) { return { begin, end, {}, {} }; }
  /// Whether no ray is shorter than from the near to the far plane.
  bool isEmpty() const noexcept { return !beginDepth && !endDepth && cut.isEmpty(); }

  /// The drawn parts of camera.ray(x, y), between the depths, too.
  RayParts parts(const Camera& camera, const Ray& ray, int x, int y) const noexcept;

  /// Throws Error, on behalf of `user`, for planes that are not finite and hits that are not those of an image of the
  /// camera's size.
  void check(const Camera& camera, const char* user) const;
};

} // namespace treeamr

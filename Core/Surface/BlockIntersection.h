// Rays and the surfaces in the octants of a block of leaves: roots of the cubics that the field is along them
// (the paper's section 6.2). Hits are found and compared in double precision in TraceSpace, by one ray at a time or by
// the packets of a tile.
#pragma once

#include "Surface/Isosurface.h"
#include "Surface/Kernel/SurfaceKernel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace treeamr
{

/// One of all hits of a ray, in little memory: these are what is sorted.
struct FoundHit
{
  double t;
  std::uint32_t number; // in the order in which they are found
};

/// What a ray on its way through the blocks looks for, and has found.
struct RayHits
{
  static constexpr std::uint32_t noBlock = std::numeric_limits<std::uint32_t>::max();

  double limit; // hits beyond are not wanted
  SurfaceHit nearest;
  Vec3 place;                     // of the nearest hit in its octant
  std::vector<FoundHit>* all;     // null: only the nearest hit is wanted
  std::vector<SurfaceHit>* found; // what their numbers are of, and those of other rays
  std::size_t most;               // of all, that are wanted
  const RayParts* parts;          // hits outside do not count; null: all do

  void clear() noexcept
  {
    limit = nearest.t = std::numeric_limits<double>::infinity();
    nearest.block = noBlock;
    all = nullptr;
    found = nullptr;
    most = std::numeric_limits<std::size_t>::max();
    parts = nullptr;
  }
  bool any() const noexcept { return nearest.block != noBlock; }
  /// Of all hits the next one that is found.
  SurfaceHit& add(double t) const
  {
    // In its place: a copy would wait until both members have been written.
    all->emplace_back(t, static_cast<std::uint32_t>(found->size()));
    return found->emplace_back();
  }
  /// Whether one is nearer than the nearest. Of equal hits of neighbours the first block's counts, whatever the order
  /// of visits.
  bool isNearer(double t, std::uint32_t block) const noexcept
  {
    return t < nearest.t || (t == nearest.t && block < nearest.block);
  }
  bool shows(double t) const noexcept
  {
    if (!parts)
    {
      return true;
    }
    for (int i = 0; i < parts->count; ++i)
    {
      if (t >= parts->begin[i] && t <= parts->end[i])
      {
        return true;
      }
    }
    return false;
  }
};

/// A block, and of the packets of a tile's rays a bit for each that may come to it.
struct MetBlock
{
  std::uint32_t block;
  std::uint32_t packets;
  float
    depth; // along the rays, but for a factor: of two blocks on one ray the nearer has the less, but for some aside
};

/// Where the domain is a unit cube, widened by what floats round; without extent, nothing meets it.
struct UnitBox
{
  /// Half the widening: a ray's origin, direction and the box are each rounded to 2^-24 of coordinates up to 1, and the
  /// ray's parameter reaches 1.
  static constexpr float rounding = 0x1p-22f;
  static constexpr float infinity = std::numeric_limits<float>::infinity();
  std::array<float, 3> low{ infinity, infinity, infinity };
  std::array<float, 3> high{ -infinity, -infinity, -infinity };
};

/// Rays of a tile of an image: packets of 4 x 4 pixels take the same way and ask for the same vertex values.
struct RayTile
{
  static constexpr int packet = PixelRays::edge;
  static constexpr int size = 4 * packet; // pixels along an edge
  static constexpr int most = size * size;
  static_assert(most == SlabRays::most && packet * packet == PixelRays::most);

  int count = 0;
  SlabRays rays;
  std::array<RayHits, most> hits;
  std::array<std::vector<FoundHit>, most> all;
  std::vector<SurfaceHit> found;    // of all rays that want all of them
  std::vector<RayParts> parts;      // of the rays, where stops cut them
  std::vector<MetBlock> blocks;     // by rays that want all hits
  std::vector<std::uint64_t> order; // of these blocks
  OctantCandidates candidates;
  CandidateRoots roots;
  HitPlaces places;
  struct Placed
  {
    int ray;
    std::size_t hit; // of all that are found
  };
  std::array<Placed, HitPlaces::most> placed; // whose places these are

  /// For other rays.
  void clear() noexcept
  {
    count = 0;
    found.clear();
    parts.clear();
    blocks.clear();
    candidates.count = 0;
    candidates.blockCount = 0;
    places.count = 0;
  }
};

/// Safe from several threads, for rays of their own.
class BlockIntersection
{
public:
  BlockIntersection(const SurfaceBlocks& blocks, const SurfaceGradients& gradients, const TraceSpace& space);

  const SurfaceBlocks& blocks() const noexcept { return blocks_; }
  const TraceSpace& space() const noexcept { return space_; }

  /// Adds to a tile the ray that is its next one; mostHits: that are wanted of it.
  void add(std::size_t mostHits, RayTile& tile) const noexcept;

  /// Finds hits of a ray in a block: whether the nearest is now there. Throws when there is no memory for vertex
  /// values, as the next does.
  bool intersect(std::uint32_t block, const RayPart& ray, RayHits& hits) const;
  /// The same for those of the 16 rays from the first on whose bits are set: whose limits have come nearer. For rays
  /// that want their nearest hit.
  std::uint32_t intersect(std::uint32_t block, int first, std::uint32_t wanted, RayTile& tile) const;

  /// The nearest hit of a ray that has been through all blocks; it has one.
  SurfaceHit nearest(const RayHits& hits) const;
  /// Sorts all hits of such a ray, each once, and leaves the nearest that are wanted; what is found stays as it is.
  void sort(const Vec3& direction, const RayHits& hits) const;
  /// Ends the hits of a tile whose rays have been through all blocks; those that want all hits go through them now.
  void finish(RayTile& tile) const;

  /// Of a block's octants that may be active.
  UnitBox unitBox(std::size_t block) const noexcept;
  /// Least width of the leaf that a hit lies in, by the length of the planes' units.
  double leafWidth(const SurfaceHit& hit, const Vec3& unit) const noexcept;
  Vec3 unit() const noexcept { return { space_.width(0), space_.width(1), space_.width(2) }; }

private:
  static bool meetsExtent(const CrossedBlock& block, const RayPart& ray, double limit) noexcept;
  bool nearestInBlock(const CrossedBlock& block, const RayPart& ray, RayHits& hits) const;
  void collectInBlock(const CrossedBlock& block, const RayPart& ray, RayHits& hits) const;
  void setGradients(const CrossedBlock& block, const Vec3& place, SurfaceHit& hit) const;
  template <class Visit, class GoesOn>
  void visitHits(const CrossedBlock& block, const RayPart& ray, const RayHits& hits, const Visit& visit,
    const GoesOn& goesOn) const;
  CrossedBlock opened(std::uint32_t number) const;

  /// Finds what rays find in a block that they enter.
  void enter(RayTile& tile, const CrossedBlock& place, const BlockEntries& entries) const;
  /// Adds what they may hit in the last block of the candidates.
  void cross(RayTile& tile, const BlockEntries& entries) const;
  /// Finds what rays have to find in the blocks that they come to, from near to far.
  void takeBlocks(RayTile& tile) const;
  /// Finds the roots of the candidates that there are.
  void takeCandidates(RayTile& tile) const;
  void takeRoot(RayTile& tile, int candidate, double s, double t) const;
  /// Takes the roots from the i-th on that are in one block, of rays that want all hits; returns the end of these.
  int takeLayers(RayTile& tile, int i) const;
  void takeLayer(RayTile& tile, int candidate, double s, double t, const GradientRecord* gradients) const;
  /// Calls take(gradients of a block with some octants, null without normals), for places of theirs that it adds.
  template <class Take>
  void withGradients(RayTile& tile, const CrossedBlock& block, std::uint64_t octants, const Take& take) const;
  /// Where a ray's nearest hit is, or the one of the tile's layers that is given.
  void addPlace(RayTile& tile, int ray, std::size_t hit, const CrossedBlock& block,
    const GradientRecord* gradients, int octant, const Vec3& place) const;
  /// That of a ray's nearest hit.
  void addNearest(RayTile& tile, int ray) const;
  /// Of the nearest hits, block by block.
  void prepareGradients(const RayTile& tile) const;
  /// Gives the hits at the places that there are their gradients and normals.
  void takePlaces(RayTile& tile) const;

  const SurfaceBlocks& blocks_;
  const SurfaceGradients& gradients_;
  const TraceSpace& space_;
  double widest_; // extent of the domain
};

} // namespace treeamr

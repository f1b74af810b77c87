// Many rays through the octants of blocks of leaves at once, vectorised with Highway and compiled once for each instruction
// set, with the bits of Camera::ray(), TraceSpace::start(), walkBlock(), alongCrossing(), visitRoots(), gradientAt(),
// normalAt() and shade() on all; the best is chosen when the program runs. Each stage packs what it found, so that the next
// one has no idle lanes.
#pragma once

#include "Surface/BlockWalk.h"
#include "Surface/Isosurface.h"
#include "Surface/Shading.h"
#include "Surface/SurfaceFrame.h"

#include <array>
#include <cstdint>
#include <span>
#include <tuple>

namespace treeamr
{

/// The rays of a packet of pixels side by side, by component.
struct PixelRays
{
  static constexpr int edge = 4; // of the packet, in pixels
  static constexpr int most = edge * edge;
  using Component = std::array<double, most>;
  alignas(64) std::array<Component, 3> origin; // in data coordinates
  alignas(64) std::array<Component, 3> direction;
  alignas(64) Component begin; // the part that is asked about
  alignas(64) Component end;

  Ray at(int i) const noexcept
  {
    return { { origin[0][i], origin[1][i], origin[2][i] },
      { direction[0][i], direction[1][i], direction[2][i] } };
  }
};

/// Camera::ray() of the pixels from (x, y) on, row by row; as far as from the near to the far plane when these cut it.
void castRays(const Camera& camera, bool isCut, int x, int y, PixelRays& rays) noexcept;

/// Parts of rays side by side, by component. All of them may be read beyond the last, by a vector.
struct SlabRays
{
  static constexpr int most = 256;
  using Component = std::array<double, most + 8>;
  using FloatComponent = std::array<float, most + 16>;
  alignas(64) std::array<Component, 3> origin{};
  alignas(64) std::array<Component, 3> direction{};
  alignas(64) std::array<Component, 3> inverse{};
  /// The part [enter, leave] of a ray is asked about, nothing that starts beyond the limit.
  alignas(64) Component enter{};
  alignas(64) Component leave{};
  alignas(64) Component limit{};
  alignas(64) Component rounding{};
  /// Of that part, where the domain is a unit cube: what SurfaceHierarchy asks with.
  alignas(64) std::array<FloatComponent, 3> unitOrigin{};
  alignas(64) std::array<FloatComponent, 3> unitDirection{};

  RayPart at(int i) const noexcept
  {
    RayPart part;
    for (int a = 0; a < 3; ++a)
    {
      part.ray.origin[a] = origin[a][i];
      part.ray.direction[a] = direction[a][i];
      part.ray.inverse[a] = inverse[a][i];
    }
    part.tEnter = enter[i];
    part.tLeave = leave[i];
    part.rounding = rounding[i];
    return part;
  }
  Vec3 directionOf(int i) const noexcept { return { direction[0][i], direction[1][i], direction[2][i] }; }
};

/// Adds those of the rays whose bits are set that TraceSpace::start() and toUnitCube() are true for, with what these
/// find, from the count-th on. Returns their bits.
std::uint32_t startRays(
  const TraceSpace& space, const PixelRays& rays, std::uint32_t wanted, int count, SlabRays& found) noexcept;

/// A block that rays are crossed with.
struct CrossedBlock
{
  const SurfaceRecord* record;
  BlockPlanes planes;
  std::uint32_t number;
  /// By axis the octants that may be active: see SurfaceBlock.
  std::array<int, 3> first;
  std::array<int, 3> end;

  CrossedBlock() noexcept = default;
  CrossedBlock(const TraceSpace& space, const SurfaceBlock& block, std::uint32_t numberOfBlock) noexcept
    : record(nullptr)
    , planes(space, block)
    , number(numberOfBlock)
  {
    for (int a = 0; a < 3; ++a)
    {
      first[a] = block.firstActive(a);
      end[a] = block.endActive(a);
    }
  }
};

/// Parts of rays in octants in which the field may reach an isovalue, by component, of some blocks.
struct OctantCandidates
{
  static constexpr int mostRays = 4 * PixelRays::most; // that are crossed with a block at once
  static constexpr int mostIsovalues = 4;              // that are looked for at once
  static constexpr int mostOctants = 10;               // that a ray passes in a block
  static constexpr int mostAdded = mostRays * mostIsovalues * mostOctants;
  /// So many are worth to find their roots.
  static constexpr int enough = 64;
  static constexpr int most = enough + mostAdded;
  using Component = std::array<double, most + 8>;

  int count = 0;
  alignas(64) Component t0;
  alignas(64) Component t1;
  alignas(64) std::array<Component, 4> cubic; // coefficients of the field less the isovalue over [t0, t1]
  alignas(64) Component tolerance;            // for visitRoots()
  alignas(64) std::array<Component, 3> from;  // place at t0, 0 to 1 in the octant
  alignas(64) std::array<Component, 3> part;  // from there to the place at t1
  alignas(64) std::array<std::int64_t, std::tuple_size_v<Component>> code;
  static constexpr int isovalueShift = 6;
  static constexpr int blockShift = 40;

  int blockCount = 0;
  std::array<CrossedBlock, enough + 1> blocks;

  CrossedBlock& last() noexcept { return blocks[blockCount - 1]; }
  const CrossedBlock& last() const noexcept { return blocks[blockCount - 1]; }
  /// Of blocks whose candidates have been taken.
  void keepLastBlock() noexcept
  {
    blocks[0] = last();
    blockCount = 1;
  }
  /// The last one, when it has no candidates.
  void dropEmptyBlock() noexcept
  {
    if (count == 0 || code[count - 1] >> blockShift != blockCount - 1)
    {
      --blockCount;
    }
  }
  Cubic along(int i) const noexcept { return { cubic[0][i], cubic[1][i], cubic[2][i], cubic[3][i] }; }
  Vec3 place(int i, double s) const noexcept
  {
    return { from[0][i] + s * part[0][i], from[1][i] + s * part[1][i], from[2][i] + s * part[2][i] };
  }
  const CrossedBlock& block(int i) const noexcept { return blocks[code[i] >> blockShift]; }
  int ray(int i) const noexcept { return static_cast<int>(code[i] >> 32 & (SlabRays::most - 1)); }
  std::uint8_t octant(int i) const noexcept { return static_cast<std::uint8_t>(code[i] & 63); }
  std::uint32_t isovalue(int i) const noexcept
  {
    return static_cast<std::uint32_t>(code[i]) >> isovalueShift;
  }
};

/// Rays that come between the planes that narrow a block, before their limits: the others have nothing to find in it.
/// By component, which a vector beyond the last may be written and read of.
struct BlockEntries
{
  static constexpr int most = OctantCandidates::mostRays;
  using Component = std::array<double, most + 8>;
  int count = 0;
  alignas(64) Component t0; // the part between the planes
  alignas(64) Component t1;
  alignas(64) std::array<std::int64_t, most + 8> ray;

  /// For those of a packet.
  bool hasRoom() const noexcept { return count <= most - PixelRays::most; }
};

/// Adds those of the 16 rays from the first on whose bits are set in `wanted`.
void enterBlock(const CrossedBlock& block, const SlabRays& rays, int first, std::uint32_t wanted,
  BlockEntries& entries) noexcept;
/// Adds those of the packets of 16 rays whose bits are set, of `count` rays; returns the bits of the packets that there
/// was no room for.
std::uint32_t enterBlockByPackets(const CrossedBlock& block, const SlabRays& rays, int count,
  std::uint32_t packets, BlockEntries& entries) noexcept;

/// Adds those in the last block of the rays that enter it, and of as many isovalues as mostIsovalues at most, numbered
/// from firstIsovalue. Those of a ray come in its order, and of an octant in that of the isovalues.
void crossBlock(std::span<const double> isovalues, int firstIsovalue, const SlabRays& rays,
  const BlockEntries& entries, OctantCandidates& found) noexcept;

/// Roots of the cubics of candidates.
struct CandidateRoots
{
  static constexpr int mostOfEach = 4;
  static constexpr int most = mostOfEach * OctantCandidates::most;
  int count = 0;
  std::array<double, most> s; // part of the way through the octant
  std::array<double, most> t;
  std::array<int, most> candidate;
};

/// Finds those that visitRoots() visits, in its order, of one candidate after the other; firstOnly: one of each.
void findRoots(const OctantCandidates& candidates, bool firstOnly, CandidateRoots& found) noexcept;

/// The places of some hits, side by side, and their gradients and normals; see gradientAt() and normalAt().
struct HitPlaces
{
  static constexpr int most = 64; // what is announced of the first is in the cache by then
  using Component = std::array<double, most>;
  int count = 0;
  bool withNormals = true; // else they are 0
  /// Of the octant's first corner: the others' are in the order of the block's vertices.
  std::array<const double*, most> values;
  std::array<const GradientRecord::Vertex*, most> vertexGradients; // with normals
  alignas(64) std::array<Component, 3> inverseWidth;               // of the octant
  alignas(64) std::array<Component, 3> place;
  alignas(64) std::array<Component, 3> gradient; // as SurfaceHit's
  alignas(64) std::array<Component, 3> normal;

  /// Adds a place in an octant. The records must be there until the normals are found. gradients: null without
  /// normals.
  void add(const CrossedBlock& block, const GradientRecord* gradients, int octant, const Vec3& at) noexcept
  {
    values[count] = block.record->values.data() + firstVertex(octant);
    vertexGradients[count] = gradients ? &gradients->vertices[firstVertex(octant)] : nullptr;
    for (int a = 0; a < 3; ++a)
    {
      inverseWidth[a][count] = block.planes.inverseWidth[a][octant >> 2 * a & 3];
      place[a][count] = at[a];
    }
    ++count;
  }
};

/// Finds them. width: of the planes' units, in data coordinates.
void findNormals(const Vec3& width, HitPlaces& hits) noexcept;

/// Hits to be lit, by component, without highlights.
struct HitsToLight
{
  static constexpr int most = 64;
  using Component = std::array<double, most>;
  using FloatComponent = std::array<float, most>;
  int count = 0;
  alignas(64) std::array<Component, 3> toEye;
  alignas(64) std::array<Component, 3> gradient;     // as SurfaceHit's
  alignas(64) std::array<FloatComponent, 3> normal;  // as SurfaceHit's
  alignas(64) std::array<FloatComponent, 3> ambient; // as Material's
  alignas(64) std::array<FloatComponent, 3> diffuse;
  alignas(64) std::array<FloatComponent, 3> rgb; // what shade() finds by SurfaceFrame's normal

  void add(const Vec3& hitToEye, const SurfaceHit& hit, const std::array<float, 3>& hitAmbient,
    const std::array<float, 3>& hitDiffuse) noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      toEye[a][count] = hitToEye[a];
      gradient[a][count] = hit.gradient[a];
      normal[a][count] = hit.normal[a];
      ambient[a][count] = hitAmbient[a];
      diffuse[a][count] = hitDiffuse[a];
    }
    ++count;
  }
};

/// Lights them; lights: without a position. flat: by the gradients alone.
void lightHits(
  const SurfaceFrame& frame, std::span<const Light> lights, bool flat, HitsToLight& hits) noexcept;

} // namespace treeamr

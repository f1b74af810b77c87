// Many rays through the octants of a block of leaves at once, vectorised with Highway and compiled once for each
// instruction set, with the bits of walkBlock() and alongCrossing() on all; the best is chosen when the program runs.
#pragma once

#include "Surface/BlockWalk.h"

#include <array>
#include <cstdint>
#include <span>
#include <tuple>

namespace treeamr
{

/// Rays side by side, by component. All of them may be read beyond the last, by a vector.
struct SlabRays
{
  static constexpr int most = 256;
  using Component = std::array<double, most + 8>;
  alignas(64) std::array<Component, 3> origin{};
  alignas(64) std::array<Component, 3> direction{};
  alignas(64) std::array<Component, 3> inverse{};
  /// The part [enter, leave] of a ray is asked about, nothing that starts beyond the limit.
  alignas(64) Component enter{};
  alignas(64) Component leave{};
  alignas(64) Component limit{};
  /// Bound of the error of a place along the ray.
  alignas(64) Component rounding{};

  void set(int i, const SlabRay& ray) noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      origin[a][i] = ray.origin[a];
      direction[a][i] = ray.direction[a];
      inverse[a][i] = ray.inverse[a];
    }
  }
};

/// Parts of rays in octants in which the field may reach an isovalue, by component.
struct OctantCandidates
{
  static constexpr int mostRays = 16;
  static constexpr int mostIsovalues = 4;
  static constexpr int mostOctants = 10; // that a ray passes in a block
  using Component = std::array<double, mostRays * mostIsovalues * mostOctants + 8>;
  int count = 0;
  alignas(64) Component t0;
  alignas(64) Component t1;
  alignas(64) std::array<Component, 4> cubic; // coefficients of the field less the isovalue over [t0, t1]
  alignas(64) Component tolerance;            // for visitRoots()
  alignas(64) std::array<std::int64_t, std::tuple_size_v<Component>> code;

  Cubic along(int i) const noexcept { return { cubic[0][i], cubic[1][i], cubic[2][i], cubic[3][i] }; }
  int ray(int i) const noexcept { return static_cast<int>(code[i] >> 32); }
  std::uint8_t octant(int i) const noexcept { return static_cast<std::uint8_t>(code[i] & 63); }
  int isovalue(int i) const noexcept { return static_cast<int>(code[i] >> 6 & 3); }
};

/// Finds those of `count` rays from the first, at most mostRays, and of as many isovalues as mostIsovalues at most.
/// Those of a ray come in its order, and of an octant in that of the isovalues.
void crossBlock(const SurfaceRecord& record, const BlockPlanes& planes, std::span<const double> isovalues,
  const SlabRays& rays, int first, int count, OctantCandidates& found) noexcept;

} // namespace treeamr

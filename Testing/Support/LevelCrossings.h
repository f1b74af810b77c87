// Random crossings of the faces at which levels meet, along a surface: whether what is found at hits jumps there.
#pragma once

#include "Surface/Isosurface.h"

#include <array>
#include <functional>
#include <random>
#include <vector>

namespace treeamr::test
{

/// The surface must live as long.
class LevelCrossings
{
public:
  static constexpr int mostLevels = 4; // by which the levels of two leaves at a face may differ

  LevelCrossings(const Field& field, const Isosurface& surface);

  /// Whether the surface was seen to cross faces of leaves of levels so many apart.
  bool has(int levels) const noexcept { return !faces_[levels].empty(); }
  /// Crosses such a face at random: hits at four places in a line through it, steps of 2e-6 of the finer leaf's width
  /// apart, two on each side. False where the surface does not go there.
  bool cross(int levels, std::array<SurfaceHit, 4>& hits);

private:
  struct Face
  {
    std::array<Coord, 3> index; // of the finer leaf
    int depth;
    int axis;
    int side;
  };
  bool cross(const Face& face, std::array<SurfaceHit, 4>& hits);

  const RootGrid& grid_;
  const Isosurface& surface_;
  std::array<std::vector<Face>, mostLevels + 1> faces_;
  std::mt19937 random_{ 3 };
};

/// How far a direction at four hits turns from the second to the third, beyond twice as far as the hits of one side are
/// apart; degrees.
double jumpOf(const std::array<SurfaceHit, 4>& hits, const std::function<Vec3(const SurfaceHit&)>& direction);

/// Those of SurfaceHit.
inline Vec3 normalOf(const SurfaceHit& hit)
{
  return { hit.normal[0], hit.normal[1], hit.normal[2] };
}

} // namespace treeamr::test

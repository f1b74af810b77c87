// The part of a contour in octants with finer neighbours, whose faces these neighbours cut.
#pragma once

#include "Contour/Contour.h"
#include "Contour/Octant.h"

#include <compare>

namespace treeamr
{

/// An octant by its place on the lattice of its depth, which is one more than its leaf's.
struct OctantKey
{
  int depth = 0;
  std::array<Coord, 3> index{};

  auto operator<=>(const OctantKey&) const noexcept = default;
};

/// A contour line on the boundary of an octant, in the direction of FaceSegments.
struct TransitionLine
{
  static constexpr int ownFace = -1;       // of a face that the octant does not share with finer ones
  static constexpr std::int64_t none = -1; // in place of a point: the face's lines must begin or end here

  OctantKey octant;
  int face = ownFace;
  std::int64_t from = none; // points of the mesh
  std::int64_t to = none;

  auto operator<=>(const TransitionLine&) const noexcept = default;
};

struct TransitionOctant
{
  OctantKey octant;
  OctantValues values{};

  auto operator<=>(const TransitionOctant& other) const noexcept { return octant <=> other.octant; }
};

/// Adds the triangles within the octants that the lines lie on. Both lists are sorted on return.
void closeTransitions(const RootGrid& grid, std::vector<TransitionLine>& lines,
  std::vector<TransitionOctant>& octants, ContourMesh& mesh);

} // namespace treeamr

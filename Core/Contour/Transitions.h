// The part of a contour in octants and dual cells with smaller neighbours, whose faces these neighbours cut.
#pragma once

#include "Contour/Contour.h"
#include "Contour/Octant.h"

#include <tuple>

namespace treeamr
{

/// An octant or a dual cell by its lower corner on the octant lattice of its leaf, whose depth is one more than the
/// leaf's.
struct PieceKey
{
  int depth = 0;
  int width = 1; // in octants: a dual cell has 2
  std::array<Coord, 3> index{};

  bool operator==(const PieceKey&) const noexcept = default;
  bool operator<(const PieceKey& other) const noexcept
  {
    for (int a = 2; a >= 0; --a)
    {
      if (index[a] != other.index[a])
      {
        return index[a] < other.index[a];
      }
    }
    return depth != other.depth ? depth < other.depth : width < other.width;
  }
};

/// A contour line on the boundary of a piece, in the direction of FaceSegments.
struct TransitionLine
{
  static constexpr int ownFace = -1;       // of a face that the piece does not share with smaller ones
  static constexpr std::int64_t none = -1; // in place of a point: the face's lines must begin or end here

  PieceKey piece;
  int face = ownFace;
  std::int64_t from = none; // points of the mesh
  std::int64_t to = none;

  bool operator<(const TransitionLine& other) const noexcept
  {
    if (!(piece == other.piece))
    {
      return piece < other.piece;
    }
    return std::tie(face, from, to) < std::tie(other.face, other.from, other.to);
  }
};

struct TransitionPiece
{
  PieceKey piece;
  PieceValues values{};

  bool operator<(const TransitionPiece& other) const noexcept { return piece < other.piece; }
};

/// Adds the triangles within the pieces that the lines lie on. Both lists are sorted on return.
void closeTransitions(const RootGrid& grid, std::vector<TransitionLine>& lines,
  std::vector<TransitionPiece>& pieces, ContourMesh& mesh);

} // namespace treeamr

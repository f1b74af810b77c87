// The part of a contour in octants and dual cells with smaller neighbours, whose faces these neighbours cut.
#pragma once

#include "Contour/Contour.h"
#include "Contour/Piece.h"

#include <tuple>

namespace treeamr
{

/// An octant or a dual cell by its lower corner on the octant lattice of its leaf, whose depth is one more
/// than the leaf's.
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

/// A contour line on the boundary of a piece, in the direction of FaceSegments. Or, to go with the piece's
/// lines, the number of its values.
struct TransitionLine
{
  static constexpr int ownFace = -1;       // of a face of which all lines are there
  static constexpr int valuesFace = -2;    // no line: `from` is the number of the values
  static constexpr std::int64_t none = -1; // in place of a point: the face's lines must begin or end here

  PieceKey piece;
  std::int64_t from = none; // points of the mesh
  std::int64_t to = none;
  int face = ownFace;

  bool operator<(const TransitionLine& other) const noexcept
  {
    if (!(piece == other.piece))
    {
      return piece < other.piece;
    }
    return std::tie(face, from, to) < std::tie(other.face, other.from, other.to);
  }
};

/// Whether a box owns a piece: it has the middle.
inline bool owns(const LatticeBox& box, const PieceKey& piece, int padding) noexcept
{
  CellId middle{ {}, piece.depth + 1 - padding };
  for (int a = 0; a < 3; ++a)
  {
    middle.index[a] = 2 * piece.index[a] + piece.width;
  }
  return box.owns(middle);
}

/// Adds the triangles within the pieces that the lines lie on, of a box within those that it owns. octantDepth: of the finest
/// octants. Sorts the lines.
void closeTransitions(const RootGrid& grid, int octantDepth, const std::optional<LatticeBox>& box,
  std::vector<TransitionLine>& lines, const std::vector<PieceValues>& values, ContourMesh& mesh);

} // namespace treeamr

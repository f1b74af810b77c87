// The part of a contour in the leaves of one block: what Contour.cpp puts together.
#pragma once

#include "Contour/Contour.h"
#include "Contour/DualCells.h"
#include "Contour/Piece.h"
#include "Contour/Transitions.h"
#include "Interpolation/BlockValues.h"
#include "Octree/TreePath.h"

namespace treeamr
{

/// A crossing that other blocks may find, too.
struct SharedCrossing
{
  std::array<Coord, 3> middle; // of the largest edge, which it names, in half widths of the finest octants
  int size; // of the edge on which it was found: log2 of its length over the finest octants'
  std::int64_t point;

  /// Crossings of one edge follow each other, those of the largest pieces first.
  bool operator<(const SharedCrossing& other) const noexcept
  {
    for (int a = 2; a >= 0; --a)
    {
      if (middle[a] != other.middle[a])
      {
        return middle[a] < other.middle[a];
      }
    }
    return size != other.size ? size > other.size : point < other.point;
  }
};

/// What one task finds; points count from 0 in each.
struct ContourPart
{
  std::vector<std::array<double, 3>> points;
  std::vector<SharedCrossing> shared;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<TransitionLine> lines;
  std::vector<PieceValues> values; // of pieces with smaller neighbours
  std::vector<ContourMesh::Block> blocks;
};

/// World coordinates per axis of a block's octant planes -1 to 5, which are its own and one beyond on either
/// side; those beyond the domain lie at its end.
using OctantPlanes = std::array<std::array<double, 7>, 3>;

OctantPlanes octantPlanes(const RootGrid& grid, const std::array<Coord, 3>& index, int depth) noexcept;

class BlockContour
{
public:
  BlockContour(const Field& field, double isovalue, const std::optional<LatticeBox>& box);

  /// Of the leaves among the children of the inner node at the path's end.
  void extract(TreePath& path, ContourPart& part);
  /// Of an octree whose root is a leaf, of a field that is given at its corners.
  void extractOnlyLeaf(ContourPart& part);

private:
  using Place = std::array<int, 3>; // on the block's octant lattice

  /// A leaf and what is around it.
  struct Leaf
  {
    bool ghost;
    // Masks of entries of its neighbourhood:
    std::uint32_t inner;             // inner nodes
    std::uint32_t same;              // leaves of its size
    std::uint32_t coarse;            // parts of coarser leaves
    std::uint32_t ghosts;            // parts of coarser leaves that are ghosts
    std::array<std::uint8_t, 27> up; // levels from it to the coarser leaf of each entry
  };
  /// An octant, a dual cell or a leaf.
  struct Piece
  {
    Place low;
    int width;        // in octants: 1 or 2
    const Leaf* leaf; // null for dual cells
    unsigned inside;  // mask of corners
  };

  void markInside() noexcept;
  bool crossesLeaf(int octant) const noexcept;
  void start(const std::array<Coord, 3>& index, int depth, bool alone, ContourPart& part);

  void extractLeaf(TreePath& path, int octant, ContourPart& part);
  void extractOctant(const Leaf& leaf, const Place& low, unsigned inside, ContourPart& part);
  void extractWhole(const Leaf& leaf, int octant, ContourPart& part);
  void extractDual(const Place& corner, ContourPart& part);
  /// finer: mask of faces towards smaller pieces.
  void extractPiece(const Piece& piece, unsigned finer, ContourPart& part);
  void handOver(
    const Piece& piece, int face, const PieceKey& to, const FaceSegments& segments, ContourPart& part);
  void askFiner(const Piece& piece, int face, const PieceKey& key, ContourPart& part);
  bool isComplete(const PieceKey& key) const noexcept;
  PieceKey keyOf(const Place& low, int width) const noexcept;
  PieceKey neighbour(const Piece& piece, int face) const noexcept;

  std::array<double, 3> localPoint(int edge) const noexcept;
  std::uint32_t addPoint(const Piece& piece, const std::array<double, 3>& local, ContourPart& part);
  std::uint32_t pointOn(const Piece& piece, int edge, ContourPart& part);
  void nameCrossing(const Piece& piece, int edge, std::int64_t point, ContourPart& part) const;
  void fillLoops(const Piece& piece, std::array<std::int8_t, 12>& next, ContourPart& part);
  void fillLoop(const Piece& piece, const std::array<int, 12>& loop, int count, ContourPart& part);

  const Octree& octree_;
  const Field& field_;
  double isovalue_;
  std::optional<LatticeBox> box_;
  bool noneMissing_; // cells of the domain; false where others hold some, for all of them are to do the same
  bool wholeLeaves_; // are trilinear
  int finestDepth_;  // of the finest octants
  BlockEvaluator evaluator_;

  // Of the current block.
  BlockValues block_;
  std::array<std::uint8_t, 25> inside_; // a bit per vertex, row after row
  bool started_;
  bool alone_; // no child is refined: octants' edges inside belong to no other block
  int depth_;  // of the octants' lattice
  std::array<Coord, 3> base_;
  OctantPlanes plane_;
  DualCells dualCells_;
  // By axis and lower end; -1: none yet.
  std::array<std::int32_t, 375> pointOfEdge_;
  std::array<std::int32_t, 192> pointOfWideEdge_; // of dual cells or leaves

  PieceValues values_; // of the current piece
};

} // namespace treeamr

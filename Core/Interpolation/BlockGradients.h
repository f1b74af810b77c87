// The vertex gradients of a block of leaves: continuous wherever leaves meet, as the vertex values are, where the
// gradient of the trilinear pieces jumps. To shade by, in surfaces and volumes.
//
// A gradient G(v) at a vertex v of the octant lattice depends on v and the tree alone; in an octant the gradient is the
// trilinear interpolant of its eight. With L the coarsest level of the leaves that touch v:
// - If v is not on the octant lattice of level L, G(v) is interpolated between the vertices of level L around it.
// - Otherwise it is, axis by axis, the difference of the field between two of the points v + k h(L) / 2, k from -2 to
//   2, over their distance in the world: of the outermost two that are even along the axis, v - h(L) and v + h(L) away
//   from the domain's end and missing cells. A vertex is even when of the cells that V would take values of, each has
//   its mirror image, or both are missing: beside a missing one the field is flat, so that differences from there
//   would be too small. Where only one is even or none, as in a layer of single cells, the outermost two with any cell
//   count.
// Where roots of unequal sizes meet, distances in the world keep this continuous, and of the first order.
//
// Its error is of the second order for smooth fields inside the domain, of the first where levels meet; none for
// trilinear fields away from missing cells. (The paper leaves gradients open.)
//
// CornerGradients.h says what they are in leaves of a field that is given at corners.
#pragma once

#include "Field/Field.h"
#include "Geometry/Vec3.h"
#include "Interpolation/BlockValues.h"
#include "Interpolation/CornerGradients.h"
#include "Octree/TreePath.h"

#include <array>
#include <bit>
#include <bitset>
#include <cstdint>
#include <memory>
#include <optional>

namespace treeamr
{

/// d value / d world coordinate, in the order of BlockValues. Vertices that were not asked for hold anything.
using BlockGradients = std::array<Vec3, block::vertexCount>;

/// Some of a block's vertices: by z a mask with the bits x + 5 y.
using BlockVertices = std::array<std::uint32_t, block::verticesPerEdge>;

inline void add(BlockVertices& vertices, int x, int y, int z) noexcept
{
  vertices[z] |= 1u << (x + block::verticesPerEdge * y);
}

/// Calls f(vertex) for each.
template <class F>
void forEachVertex(const BlockVertices& vertices, const F& f)
{
  for (int z = 0; z < block::verticesPerEdge; ++z)
  {
    for (std::uint32_t rest = vertices[z]; rest != 0; rest &= rest - 1)
    {
      f(std::countr_zero(rest) + block::vertexStride[2] * z);
    }
  }
}

/// Those of octants x + 4 y + 16 z.
BlockVertices verticesOfOctants(std::uint64_t octants) noexcept;

/// Of one field, which must live as long, for one thread. The way down the tree, and what is known along it, is kept
/// for the next block.
class GradientEvaluator
{
public:
  /// As BlockEvaluator::computeUnrounded() gives them.
  using Values = std::array<double, block::vertexCount>;

  explicit GradientEvaluator(const Field& field);

  /// At some vertices, each of a drawn child, of the inner node at the path's end. With means, every node of the
  /// children's size is taken as a leaf. values: the same block's, which save time; null: not at hand.
  void compute(const BlockPath& path, BlockCells cells, const BlockVertices& vertices,
    BlockGradients& gradients, const Values* values = nullptr) noexcept;

private:
  /// In and around an inner node lie 6 x 6 x 6 cells of its children's size, from its lower corner -2 to 3 along each
  /// axis, and 9 x 9 x 9 points of their octants' lattice, -2 to 6 half widths from that corner. Either count from 0
  /// here; a point by its index x + 9 y + 81 z.
  static constexpr int cellsPerEdge = 6;
  static constexpr int pointsPerEdge = 9;
  static constexpr int cellCount = cellsPerEdge * cellsPerEdge * cellsPerEdge;
  static constexpr int pointCount = pointsPerEdge * pointsPerEdge * pointsPerEdge;

  /// Of a point's value. Bits 1, 2, 4: the axes along which the point is even; none where no cell touches it.
  enum ValueState : std::uint8_t
  {
    unknown = 0,
    isEven = 7,
    isThere = 8, // some cell touches the point
    isKnown = 16
  };
  struct Value
  {
    double value;
    std::uint8_t state;
  };
  /// Of cells, by z, with the bits x + 6 y.
  using CellMask = std::array<std::uint64_t, cellsPerEdge>;
  struct Level
  {
    std::uint64_t node = noNode;
    CellMask coarse;  // parts of coarser leaves
    CellMask special; // and what else is no leaf of this size
    bool hasSpecial;
    CellMask drawn;                                      // the node's children that are leaves
    bool isComplete;                                     // no cell is missing
    const Values* vertices;                              // of the drawn children; null: not at hand
    std::array<double, cellCount> cellValue;             // 0 of coarse and missing ones
    std::array<std::uint64_t, cellCount> inner;          // of special cells; noNode: it is missing or coarse
    std::array<std::array<double, pointsPerEdge>, 3> at; // world coordinates of the points, from the first on
    std::array<double, pointCount> value;
    std::array<std::uint8_t, pointCount> state; // of values
    std::bitset<block::vertexCount> gradientKnown;
    BlockGradients gradient;
  };
  static constexpr std::uint64_t noNode = ~std::uint64_t(0);

  void moveTo(const BlockPath& path) noexcept;
  void setLeafDepth(int depth) noexcept;
  void computeFromCorners(
    const BlockPath& path, const BlockVertices& vertices, BlockGradients& gradients) noexcept;
  void gather(int depth, Level& level) const noexcept;
  void measure(int depth, Level& level) const noexcept;
  Level& levelAt(int depth) noexcept;

  void meanCells(Level& level) const noexcept;
  Value valueAt(int depth, Level& level, int point) noexcept;
  Value valueBesideSpecial(int depth, Level& level, int point) noexcept;
  template <unsigned Axes>
  Value onLattice(int depth, const Level& level, int firstCell) const noexcept;
  Value amidFiner(std::array<NodeRef, 8> around) const noexcept;
  Value betweenCoarser(int depth, int point) noexcept;
  template <class F>
  int forCoarser(int depth, int point, const F& f) noexcept;
  void computeMany(
    int depth, Level& level, const BlockVertices& vertices, BlockGradients& gradients) noexcept;
  Vec3 gradientAt(int depth, Level& level, int vertex) noexcept;
  double slopeAt(int depth, Level& level, int axis, int point) noexcept;
  double slopeBesideMissing(int depth, Level& level, int axis, int point) noexcept;
  double rootWidth(int axis, Coord root) const noexcept;

  const Field& field_;
  const Octree& octree_;
  Vec3 uniformWidth_{}; // of the roots; 0: they differ
  bool hasAllCells_;
  int leafDepth_;                          // nodes of this depth are taken as leaves
  std::optional<CornerGradients> corners_; // none: the values are those at centres
  TreePath path_;
  std::unique_ptr<Level[]> levels_; // by depth of the inner node
};

} // namespace treeamr

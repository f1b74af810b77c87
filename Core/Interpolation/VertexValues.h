// The values at the octant-lattice vertices of a leaf: what GTI and the octant method define.
//
// A leaf has 27 vertices: its centre, and the centres of its faces, midpoints of its edges and corners. The
// field inside one of its octants is the trilinear interpolant of eight of them.
#pragma once

#include "Field/Field.h"
#include "Geometry/Trilinear.h"
#include "Octree/TreePath.h"

#include <array>

namespace treeamr
{

/// Order x + 3 y + 9 z with x, y, z in 0, 1, 2 half widths from the leaf's lower corner.
using VertexValues = std::array<float, 27>;
inline constexpr std::array<int, 3> leafVertexStride{ 1, 3, 9 };

enum class VertexRule
{
  GTI,   // the paper's weights
  Octant // Wang et al. 2019: the same cells, with equal weights
};

/// Vertex values of the inner nodes on a path, kept while a walk stays below them. Vertices that hang on a
/// coarser face take them from there, and the eight leaves of a parent share most of them. For one field and
/// rule.
class VertexMemo
{
public:
  VertexMemo() noexcept
  {
    for (Entry& e : entries_)
    {
      e.known = 0;
    }
  }
  /// The value of a vertex of `node`, a node of the path at a depth; compute() makes it when it is not known.
  template <class Compute>
  double get(int depth, NodeRef node, int vertex, const Compute& compute) noexcept
  {
    Entry& e = entries_[depth];
    if (e.known == 0 || !(e.owner == node))
    {
      e.owner = node;
      e.known = 0;
    }
    const std::uint32_t bit = 1u << vertex;
    if ((e.known & bit) == 0)
    {
      // Recursion reaches coarser depths only: this entry keeps its owner.
      e.values[vertex] = compute();
      e.known |= bit;
    }
    return e.values[vertex];
  }

private:
  struct Entry
  {
    NodeRef owner;
    std::uint32_t known; // mask of vertices
    std::array<double, 27> values;
  };
  std::array<Entry, Octree::maxDepth + 1> entries_;
};

/// The path must end at a leaf.
template <VertexRule Rule>
VertexValues vertexValues(const TreePath& path, const Field& field, VertexMemo& memo) noexcept;
/// The same for a single leaf.
template <VertexRule Rule>
VertexValues vertexValues(const TreePath& path, const Field& field) noexcept
{
  VertexMemo memo;
  return vertexValues<Rule>(path, field, memo);
}

/// Of one octant of the leaf by GTI, for a part of the time.
Corners octantCorners(const TreePath& path, const Field& field, VertexMemo& memo, int octant) noexcept;

/// Hull of the 27 values, and so of the field inside the leaf.
inline Range hull(const VertexValues& values) noexcept
{
  Range r{ values[0], values[0] };
  for (const float v : values)
  {
    r.min = v < r.min ? v : r.min;
    r.max = v > r.max ? v : r.max;
  }
  return r;
}

extern template VertexValues vertexValues<VertexRule::GTI>(
  const TreePath&, const Field&, VertexMemo&) noexcept;
extern template VertexValues vertexValues<VertexRule::Octant>(
  const TreePath&, const Field&, VertexMemo&) noexcept;

} // namespace treeamr

// The values at the octant-lattice vertices of a leaf: what GTI and the octant method define.
//
// A leaf has 27 vertices: its centre, and the centres of its faces, midpoints of its edges and corners. The
// field inside one of its octants is the trilinear interpolant of eight of them.
#pragma once

#include "Octree/Field.h"
#include "Octree/TreePath.h"

#include <array>

namespace treeamr
{

/// Order x + 3 y + 9 z with x, y, z in 0, 1, 2 half widths from the leaf's lower corner.
using VertexValues = std::array<float, 27>;

enum class VertexRule
{
  GTI,   // the paper's weights
  Octant // Wang et al. 2019: equal weights, and refined neighbours by their means
};

/// The path must end at a leaf.
template <VertexRule Rule>
VertexValues vertexValues(const TreePath& path, const Field& field) noexcept;

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

extern template VertexValues vertexValues<VertexRule::GTI>(const TreePath&, const Field&) noexcept;
extern template VertexValues vertexValues<VertexRule::Octant>(const TreePath&, const Field&) noexcept;

} // namespace treeamr

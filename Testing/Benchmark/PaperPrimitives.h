// The paper's extraction of active cubic primitives (section 6.2, Algorithm 1), to compare the ray tracer's
// isosurfaces with.
//
// Deviations: neighbours come from the carried neighbourhoods of TreePath.h, not from look-ups from the root, and
// a cell's 27 vertices are computed once where the paper computes 64 for its octants. All three ways run in
// parallel. Filtering uses the node ranges, which hold the field inside a node but not the rest of the dual cells
// that reach into it: so Filtered takes a dual cell where a cell is met whose octant of it is active.
#pragma once

#include "Field/Field.h"

#include <array>
#include <cstdint>
#include <vector>

namespace treeamr::bench
{

enum class Extraction
{
  Naive,     // the octants of all cells
  DualCells, // a dual cell in place of eight octants of cells of one level (optimisation 1)
  Filtered   // the same from the cells alone that the isosurface may pass (optimisation 2)
};

/// A cube with the field at its corners, whose range holds the isovalue.
struct Primitive
{
  enum class Kind : std::uint8_t
  {
    Octant,  // one unit of its lattice wide
    DualCell // two units, between the centres of eight drawn cells of one level
  };
  std::array<std::uint32_t, 3> index; // lower corner on the lattice of half cells
  std::uint8_t level;                 // of that lattice: the cells' plus one
  Kind kind;
};
static_assert(sizeof(Primitive) == 16);

struct Primitives
{
  std::vector<Primitive> primitives;
  std::vector<std::array<float, 8>> values; // at each one's corners, x fastest

  std::size_t byteSize() const noexcept
  {
    return primitives.size() * sizeof(Primitive) + values.size() * sizeof(values[0]);
  }
};

/// In any order. The field needs its node ranges. Throws Error for a tree too deep for the indices.
Primitives extractPrimitives(const Field& field, float isovalue, Extraction extraction);

/// Drawn cells that the isosurface passes: with an active octant.
std::uint64_t countActiveCells(const Field& field, float isovalue);

/// The field at the corners of the octants of a dual cell; order x + 3 y + 9 z.
std::array<float, 27> dualCellVertices(const std::array<float, 8>& corners) noexcept;

} // namespace treeamr::bench

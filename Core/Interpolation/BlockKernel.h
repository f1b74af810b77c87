// The parts of block values that go over all of a block, vectorised with Highway and compiled once for each
// instruction set, with the same bits on all; the best is chosen when the program runs.
#pragma once

#include "Field/RangeCode.h"
#include "Interpolation/BlockLattice.h"

#include <array>
#include <cstdint>

namespace treeamr
{

/// Values at the 5 x 5 x 5 vertices between and in the middle of 4 x 4 x 4 cells of one size, as means along one axis
/// after the other. places: x + 4 y + 16 z, and eight that are only read. values: x + 5 y + 25 z, and three of no
/// meaning.
void meansBetween(const std::array<double, 72>& places, std::array<double, 128>& values) noexcept;

/// To single precision; returns their hull.
Range roundValues(
  const std::array<double, 128>& values, std::array<float, block::vertexCount>& rounded) noexcept;

Range hull(const std::array<float, block::vertexCount>& values) noexcept;

/// In whole steps from 0 to `last` across their hull, to the nearest. The hull's width must be finite.
void quantise(const std::array<float, block::vertexCount>& values, Range hull, float last,
  std::array<std::uint16_t, 128>& steps) noexcept;

} // namespace treeamr

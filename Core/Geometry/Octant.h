// One numbering for the eight children of a node, the octants of a cell and the corners of a box: bit a of the number
// is the side along axis a, 0 the lower and 1 the upper one, so it is x + 2 y + 4 z.
#pragma once

#include <array>
#include <cstdint>

namespace treeamr
{

/// Cell (or plane) index along one axis on the lattice of one level.
using Coord = std::int64_t;

/// 0: the lower side along an axis (0 to 2), 1: the upper one.
constexpr int sideOf(int octant, int axis) noexcept
{
  return octant >> axis & 1;
}

/// The octant that leads to the ancestor `up` levels above the node at an index, from that one's parent.
constexpr int octantAbove(const std::array<Coord, 3>& index, int up) noexcept
{
  return static_cast<int>((index[0] >> up & 1) | (index[1] >> up & 1) << 1 | (index[2] >> up & 1) << 2);
}

/// The index of the child in an octant, on the lattice of the next level.
constexpr std::array<Coord, 3> indexOfChild(const std::array<Coord, 3>& index, int octant) noexcept
{
  return { 2 * index[0] + sideOf(octant, 0), 2 * index[1] + sideOf(octant, 1),
    2 * index[2] + sideOf(octant, 2) };
}

/// How far a corner lies from the lowest one in an array with these strides along the axes.
constexpr int cornerOffset(int corner, const std::array<int, 3>& stride) noexcept
{
  return sideOf(corner, 0) * stride[0] + sideOf(corner, 1) * stride[1] + sideOf(corner, 2) * stride[2];
}

} // namespace treeamr

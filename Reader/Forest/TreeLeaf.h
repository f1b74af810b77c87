// What a reader tells of leaves of a forest of octrees.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treeamr
{

struct TreeLeaf
{
  std::int32_t tree;                  // its tree's number
  std::array<std::uint32_t, 3> index; // in [0, 2^level), on the lattice of its level in the tree
  int level;                          // 0: all of the tree
  std::uint64_t number;               // among all leaves of the source
  const std::byte* payload; // its bytes, at any alignment, valid as long as the block is; null: none
};

/// Level of the deepest node around both, of one tree; that of the coarser one when it is around the other.
inline int commonLevel(const TreeLeaf& a, const TreeLeaf& b) noexcept
{
  const int level = a.level < b.level ? a.level : b.level;
  std::uint32_t differing = 0;
  for (int axis = 0; axis < 3; ++axis)
  {
    differing |= (a.index[axis] >> (a.level - level)) ^ (b.index[axis] >> (b.level - level));
  }
  return level - static_cast<int>(std::bit_width(differing));
}

/// The leaves of these numbers, up to but without the end.
struct LeafRange
{
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  std::uint64_t count() const noexcept { return end - begin; }
};

/// Leaves of one range in a source, or of several that follow each other.
struct LeafBlock
{
  std::vector<TreeLeaf> leaves;
  std::vector<std::byte> bytes;    // that the leaves were read of
  std::vector<std::byte> payloads; // that are in a file of their own
};

} // namespace treeamr

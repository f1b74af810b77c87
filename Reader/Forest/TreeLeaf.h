// What a reader tells of a leaf of a forest of octrees.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace treeamr
{

struct TreeLeaf
{
  std::int32_t tree;                  // its tree's number
  std::array<std::uint32_t, 3> index; // in [0, 2^level), on the lattice of its level in the tree
  int level;                          // 0: all of the tree
  std::uint64_t number;               // among all leaves of the source
  const std::byte* payload;           // its bytes, at any alignment, valid during the visit only; null: none
};

} // namespace treeamr

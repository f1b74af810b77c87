// What a reader tells of leaves of a forest of octrees.
#pragma once

#include <array>
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

/// Leaves that follow each other in a source.
struct LeafBlock
{
  std::vector<TreeLeaf> leaves;
  std::vector<std::byte> bytes;    // that the leaves were read of
  std::vector<std::byte> payloads; // that are in a file of their own
};

} // namespace treeamr

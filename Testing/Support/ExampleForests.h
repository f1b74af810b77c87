// Forests with payloads that a test can predict.
#pragma once

#include "Support/ForestWriter.h"

namespace treeamr::test
{

/// Deterministic and different for each cell.
inline std::uint64_t hashOf(const ForestQuadrant& q)
{
  std::uint64_t h = 0x9e3779b97f4a7c15u;
  for (const std::uint64_t part : { std::uint64_t(q.tree), std::uint64_t(q.level), std::uint64_t(q.index[0]),
         std::uint64_t(q.index[1]), std::uint64_t(q.index[2]) })
  {
    h = (h ^ part) * 0xbf58476d1ce4e5b9u;
    h ^= h >> 29;
  }
  return h;
}

/// One cell in `oneIn` is refined, below maxLevel.
inline void refineAtRandom(ForestWriter& forest, int maxLevel, int oneIn)
{
  forest.refine([=](const ForestQuadrant& q) {
    return q.level < maxLevel && hashOf(q) % static_cast<std::uint64_t>(oneIn) == 0;
  });
}

inline void fillWithHashes(ForestWriter& forest, std::size_t bytes)
{
  forest.setPayload(bytes, [=](const ForestQuadrant& q, std::byte* payload) {
    for (std::size_t i = 0; i < bytes; ++i)
    {
      payload[i] = static_cast<std::byte>(hashOf(q) >> (8 * (i % 8)) ^ i);
    }
  });
}

/// 12 trees, some of them refined, 12 bytes a cell.
inline ForestWriter smallBrick()
{
  auto forest = ForestWriter::brick({ 3, 2, 2 });
  refineAtRandom(forest, 3, 3);
  fillWithHashes(forest, 12);
  return forest;
}

} // namespace treeamr::test

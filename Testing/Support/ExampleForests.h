// Forests with payloads that a test can predict.
#pragma once

#include "Support/ForestWriter.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <random>
#include <vector>

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

/// Of the unit cube: all 48 turned and reflected ones, or the turned ones alone.
inline std::vector<ForestWriter::Corners> turnedCubes(bool reflectedToo)
{
  std::vector<ForestWriter::Corners> cubes;
  std::array<std::size_t, 3> axes{ 0, 1, 2 };
  do
  {
    const bool isEven = (axes[0] < axes[1]) == ((axes[1] < axes[2]) == (axes[0] < axes[2]));
    for (int flips = 0; flips < 8; ++flips)
    {
      if (!reflectedToo && (std::popcount(static_cast<unsigned>(flips)) % 2 == 0) != isEven)
      {
        continue;
      }
      ForestWriter::Corners& corners = cubes.emplace_back();
      for (int c = 0; c < 8; ++c)
      {
        for (std::size_t a = 0; a < 3; ++a)
        {
          corners[static_cast<std::size_t>(c)][axes[a]] = (c ^ flips) >> a & 1;
        }
      }
    }
  }
  while (std::ranges::next_permutation(axes).found);
  return cubes;
}

inline void move(ForestWriter::Corners& corners, const ForestWriter::Point& by)
{
  for (ForestWriter::Point& corner : corners)
  {
    std::ranges::transform(corner, by, corner.begin(), std::plus());
  }
}

/// A wall of three by two by two trees with one left out, each turned in any way.
inline ForestWriter turnedWall()
{
  const std::vector<ForestWriter::Corners> cubes = turnedCubes(false);
  std::mt19937 random(5);
  std::vector<ForestWriter::Corners> trees;
  for (int i = 0; i < 11; ++i)
  {
    trees.push_back(cubes[random() % cubes.size()]);
    move(trees.back(),
      { static_cast<double>(i % 3), static_cast<double>(i / 3 % 2), static_cast<double>(i / 6) });
  }
  return ForestWriter::joinedTrees(trees);
}

} // namespace treeamr::test

// The blocks that a tile's rays come to: each once, from near to far, with all of its visits in their order.
#include "Surface/BlockVisits.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace treeamr
{

namespace
{

using Visited = std::vector<std::pair<int, std::uint32_t>>; // first ray of the packet, rays

float depthOf(std::uint32_t block)
{
  return (static_cast<float>(block % 97) - 48.f) * 0.25f; // some equal, some negative
}

void expectVisits(BlockVisits& visits, const std::map<std::uint32_t, Visited>& expected)
{
  visits.sort();
  ASSERT_EQ(visits.blockCount(), expected.size());
  std::map<std::uint32_t, Visited> found;
  for (std::size_t i = 0; i < visits.blockCount(); ++i)
  {
    const std::uint32_t block = visits.block(i);
    EXPECT_FALSE(found.contains(block)) << block;
    visits.forVisits(
      i, [&](const BlockVisits::Visit& visit) { found[block].emplace_back(visit.first, visit.wanted); });
    if (i > 0)
    {
      EXPECT_LE(depthOf(visits.block(i - 1)), depthOf(block));
    }
  }
  EXPECT_EQ(found, expected);
}

} // namespace

TEST(BlockVisits, AreThoseOfEachBlockInTheirOrderFromNearToFar)
{
  std::mt19937 random(5);
  BlockVisits visits;
  for (const std::uint32_t blocks : { 1u, 40u, 3000u, 7u })
  {
    std::map<std::uint32_t, Visited> expected;
    for (int packet = 0; packet < 16; ++packet)
    {
      for (std::uint32_t i = 0; i < blocks; ++i)
      {
        const std::uint32_t block =
          random() % (2 * blocks) * 0x10001u; // numbers with a pattern, up to large ones
        const std::uint32_t wanted = 1 + random() % 0xffffu;
        int asked = 0;
        visits.add(block, 16 * packet, wanted, [&] {
          ++asked;
          return depthOf(block);
        });
        EXPECT_EQ(asked, expected.contains(block) ? 0 : 1);
        expected[block].emplace_back(16 * packet, wanted);
      }
    }
    expectVisits(visits, expected);
    visits.clear();
    EXPECT_EQ(visits.blockCount(), 0u);
  }
}

} // namespace treeamr

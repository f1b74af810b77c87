// Large arrays lie on large pages, small ones take no more than they need, and what cannot be had throws.
#include "LargeArray.h"
#include "ChunkPool.h"
#include "Field/Field.h"
#include "Octree/OctreeBuilder.h"
#include "Support/AllocationCounter.h"
#include "Support/ProceduralTree.h"

#include <gtest/gtest.h>

#include <cstdint>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr std::size_t MiB = std::size_t(1) << 20;

std::size_t placeInLargePage(const void* memory)
{
  return reinterpret_cast<std::uintptr_t>(memory) % largePage;
}

struct Chunk
{
  static constexpr std::uint32_t size = 64;
  std::array<std::array<std::byte, 4096>, size> records;
};

/// Adds so many records, each filled.
void add(ChunkPool<Chunk>::Writer& writer, int records)
{
  for (int i = 0; i < records; ++i)
  {
    Chunk* const chunk = writer.room();
    ASSERT_NE(chunk, nullptr);
    chunk->records[writer.index()].fill(std::byte(i));
    writer.keep();
  }
}

} // namespace

TEST(LargeArray, BeginsOnALargePageAboveFourMegabytes)
{
  for (const std::size_t bytes : { 4 * MiB, 4 * MiB + 1, 64 * MiB })
  {
    const LargeVector<char> vector(bytes);
    EXPECT_EQ(placeInLargePage(vector.data()), 0u) << bytes;
    EXPECT_EQ(placeInLargePage(makeLargeArray<char>(bytes).get()), 0u) << bytes;
  }
  const LargeVector<double> grown = [] {
    LargeVector<double> v;
    for (int i = 0; i < 1000000; ++i)
    {
      v.push_back(i);
    }
    return v;
  }();
  EXPECT_EQ(placeInLargePage(grown.data()), 0u);
  EXPECT_EQ(grown[999999], 999999.);
}

TEST(LargeArray, TakesTheBytesThatItHolds)
{
  for (const std::size_t bytes : { std::size_t(1), 4 * MiB - 1, 4 * MiB, 5 * MiB + 1 })
  {
    EXPECT_EQ(peakBytes([&] { LargeVector<char> vector(bytes); }), bytes);
    EXPECT_EQ(peakBytes([&] { makeLargeArray<char>(bytes); }), bytes);
  }
}

TEST(LargeArray, ThrowsWhereThereIsNoMemory)
{
  const std::size_t tooMuch = std::size_t(1) << 60;
  EXPECT_THROW(LargeVector<float>(tooMuch / sizeof(float)), std::bad_alloc);
  EXPECT_THROW(makeLargeArray<float>(tooMuch / sizeof(float)), std::bad_alloc);
  EXPECT_THROW(makeLargeArray<double>(~std::size_t(0) / 2), std::bad_alloc);
}

TEST(LargeArray, PoolsBeginSmallAndGrowByLargeArrays)
{
  const std::size_t before = allocatedBytes;
  ChunkPool<Chunk> pool(100000, 512 * MiB);
  const std::size_t tables = allocatedBytes - before;
  ChunkPool<Chunk>::Writer writer(pool);
  add(writer, 1);
  EXPECT_EQ(allocatedBytes - before, tables + sizeof(Chunk));
  add(writer, 64 * 64);
  EXPECT_LE(allocatedBytes - before, tables + 65 * sizeof(Chunk) + largeArrayBytes);
  EXPECT_EQ(placeInLargePage(&pool.chunkOf(40 * 64).records) % sizeof(Chunk), 0u);
}

TEST(LargeArray, PoolsStayInTheirBudget)
{
  const std::size_t before = allocatedBytes;
  const std::size_t budget = 37 * sizeof(Chunk);
  ChunkPool<Chunk> pool(100000, budget);
  const std::size_t tables = allocatedBytes - before;
  ChunkPool<Chunk>::Writer writer(pool);
  int added = 0;
  while (Chunk* const chunk = writer.room())
  {
    chunk->records[writer.index()].fill(std::byte(added));
    writer.keep();
    ++added;
  }
  EXPECT_EQ(added, 37 * 64 - 1); // 0 is no number
  EXPECT_EQ(allocatedBytes - before, tables + budget);
  EXPECT_TRUE(pool.overflowed());

  pool.forget();
  EXPECT_TRUE(pool.giveUp(18 * sizeof(Chunk)));
  EXPECT_LE(allocatedBytes - before, tables + 19 * sizeof(Chunk) + largeArrayBytes);
  ChunkPool<Chunk>::Writer again(pool);
  add(again, 19 * 64 - 1);
  EXPECT_EQ(again.room(), nullptr);
  EXPECT_LE(allocatedBytes - before, tables + 19 * sizeof(Chunk) + largeArrayBytes);
}

TEST(LargeArray, IsWhatOctreesAndFieldsAreMadeOf)
{
  greatestOnSmallPages = 0;
  const ProceduralTree tree(9, 3.); // some million cells
  auto built = buildOctree(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), tree);
  const Field field(built.octree, std::move(built.values));
  ASSERT_GT(field.octree().byteSize() + field.byteSize(), 16 * MiB);
  EXPECT_LT(greatestOnSmallPages, largeArrayBytes);
}

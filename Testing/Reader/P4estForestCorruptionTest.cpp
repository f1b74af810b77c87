// Spoilt forests: every truncation, every bit before the quadrants and of the quadrants, noise and huge
// counts. Each must read as a valid forest or throw Error, and ask the heap for no more than the file's size
// warrants.
#include "Error.h"
#include "Forest/P4estForestFile.h"
#include "Support/ExampleForests.h"
#include "Support/ForestBytes.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <new>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

// What is asked of the heap. Not inlined: g++ 12 then takes malloc's memory and delete for a mismatch.
namespace
{
std::atomic<std::size_t> heapBytes = 0;
std::atomic<std::size_t> heapPeak = 0;
} // namespace

[[gnu::noinline]] void* operator new(std::size_t bytes)
{
  void* const memory = std::malloc(bytes ? bytes : 1);
  if (!memory)
  {
    throw std::bad_alloc();
  }
  const std::size_t now = heapBytes += malloc_usable_size(memory);
  if (now > heapPeak)
  {
    heapPeak = now;
  }
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
  if (memory)
  {
    heapBytes -= malloc_usable_size(memory);
    std::free(memory);
  }
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
  operator delete(memory);
}

namespace
{

/// By intervals of the Morton curve at level 29, not by the parser's walk.
void expectEachTreeCovered(const P4estForestFile& file)
{
  using Wide = unsigned __int128;
  constexpr int maxLevel = P4estForestFile::maxLevel;
  std::vector<Wide> covered(file.treeCount(), 0);
  file.visitQuadrants([&](const TreeLeaf& q) {
    ASSERT_GE(q.level, 0);
    ASSERT_LE(q.level, maxLevel);
    Wide begin = 0;
    for (int bit = 0; bit < q.level; ++bit)
    {
      for (int a = 0; a < 3; ++a)
      {
        begin |= Wide(q.index[a] >> bit & 1) << (3 * (bit + maxLevel - q.level) + a);
      }
    }
    ASSERT_LT(std::max({ q.index[0], q.index[1], q.index[2] }), 1u << q.level);
    ASSERT_TRUE(covered[q.tree] == begin);
    covered[q.tree] += Wide(1) << 3 * (maxLevel - q.level);
  });
  for (const Wide end : covered)
  {
    ASSERT_TRUE(end == Wide(1) << 3 * maxLevel);
  }
}

/// True when the file is read as a valid forest; otherwise it must throw Error and nothing else.
bool readsOrThrows(const std::string& path, std::size_t fileBytes)
{
  const std::size_t before = heapBytes;
  heapPeak = before;
  bool valid = true;
  try
  {
    const P4estForestFile file(path);
    expectEachTreeCovered(file);
  }
  catch (const Error&)
  {
    valid = false;
  }
  // Twice the file: its tables once as they are kept and once as a block is read; the rest is the stream's
  // buffer and strings.
  EXPECT_LE(heapPeak - before, 2 * fileBytes + 64 * 1024);
  return valid;
}

/// A file of which one bit at a time is wrong.
class BitFlipper
{
public:
  BitFlipper(std::string path, Bytes bytes)
    : path_(std::move(path))
    , bytes_(std::move(bytes))
  {
    writeBytes(path_, bytes_);
    stream_.open(path_, std::ios::binary | std::ios::in | std::ios::out);
  }
  /// Whether the forest still reads with this bit flipped.
  bool reads(std::size_t byte, int bit)
  {
    put(byte, bytes_[byte] ^ std::byte(1 << bit));
    const bool valid = readsOrThrows(path_, bytes_.size());
    put(byte, bytes_[byte]);
    return valid;
  }

private:
  void put(std::size_t at, std::byte value)
  {
    stream_.seekp(static_cast<std::streamoff>(at));
    stream_.put(static_cast<char>(value));
    stream_.flush();
  }
  std::string path_;
  Bytes bytes_;
  std::fstream stream_;
};

class P4estForestCorruptionTest : public ::testing::Test
{
protected:
  TemporaryFolder folder_;
};

TEST_F(P4estForestCorruptionTest, EveryTruncationIsAnError)
{
  const std::string path = folder_.file("cut.p8est");
  smallBrick().save(path);
  const Bytes bytes = readBytes(path);
  ASSERT_EQ(bytes.size(), findSections(bytes).end);
  for (std::size_t size = bytes.size(); size-- > 0;)
  {
    std::filesystem::resize_file(path, size);
    ASSERT_FALSE(readsOrThrows(path, size)) << "cut to " << size << " of " << bytes.size();
  }
}

TEST_F(P4estForestCorruptionTest, EveryFlippedBitBeforeTheQuadrants)
{
  ForestWriter forest = smallBrick();
  forest.setTreeAttributes(3);
  const std::string path = folder_.file("flip.p8est");
  forest.save(path);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  BitFlipper flipper(path, bytes);
  for (std::size_t byte = 0; byte < s.quadrants; ++byte)
  {
    for (int bit = 0; bit < 8; ++bit)
    {
      const bool reads = flipper.reads(byte, bit);
      const bool isMagic = byte < 8;
      const bool isCount = (byte >= s.connectivityCounts && byte < s.connectivityCounts + 72) ||
        (byte >= s.forestHeader && byte < s.treeEndsEnd);
      // 24 and 20 bytes per quadrant differ by two bits, so each number is told.
      if (isMagic || isCount)
      {
        ASSERT_FALSE(reads) << "byte " << byte << ", bit " << bit;
      }
    }
  }
  EXPECT_TRUE(readsOrThrows(path, bytes.size()));
}

TEST_F(P4estForestCorruptionTest, EveryFlippedBitOfAQuadrant)
{
  ForestWriter forest = smallBrick();
  const std::string path = folder_.file("flip.p8est");
  forest.save(path);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  BitFlipper flipper(path, bytes);
  for (std::size_t byte = s.quadrants; byte < s.end; ++byte)
  {
    const bool isPayload = (byte - s.quadrants) % s.recordBytes >= 16;
    for (int bit = 0; bit < 8; ++bit)
    {
      ASSERT_EQ(flipper.reads(byte, bit), isPayload) << "byte " << byte << ", bit " << bit;
    }
  }
}

TEST_F(P4estForestCorruptionTest, ManyFlippedBitsOfALargerForest)
{
  auto forest = ForestWriter::brick({ 2, 2, 2 });
  forest.refine([](const ForestQuadrant& q) { return q.level < 2 || (q.level < 5 && hashOf(q) % 5 == 0); });
  const std::string path = folder_.file("flip.p8est");
  forest.save(path, false);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  BitFlipper flipper(path, bytes);
  std::mt19937_64 random(20240229);
  for (int i = 0; i < 5000; ++i)
  {
    const std::size_t byte = s.quadrants + random() % (s.end - s.quadrants);
    const int bit = static_cast<int>(random() % 8);
    ASSERT_FALSE(flipper.reads(byte, bit)) << "byte " << byte << ", bit " << bit;
  }
  for (int i = 0; i < 200; ++i)
  {
    const std::size_t size = random() % bytes.size();
    writeBytes(path, Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(readsOrThrows(path, size)) << "cut to " << size;
  }
}

TEST_F(P4estForestCorruptionTest, RandomBytesInEverySection)
{
  const std::string path = folder_.file("noise.p8est");
  smallBrick().save(path);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  std::mt19937_64 random(7);
  for (const std::size_t begin :
    { s.connectivityCounts, s.connectivityBody, s.forestHeader, s.partition, s.treeEnds, s.quadrants })
  {
    for (int i = 0; i < 300; ++i)
    {
      Bytes noisy = bytes;
      for (std::size_t n = 1 + random() % 40; n > 0 && begin + n < noisy.size(); --n)
      {
        noisy[begin + random() % n] = static_cast<std::byte>(random());
      }
      writeBytes(path, noisy);
      readsOrThrows(path, noisy.size());
    }
  }
}

// Counts so large that their products overflow, and the file's own size beside them.
TEST_F(P4estForestCorruptionTest, HugeCounts)
{
  const std::string path = folder_.file("huge.p8est");
  smallBrick().save(path);
  const Bytes bytes = readBytes(path);
  const ForestSections s = findSections(bytes);
  std::vector<std::size_t> counts{ s.forestHeader + 24, s.forestHeader + 40, s.partition, s.treeEnds };
  for (std::size_t i = 2; i < 9; ++i)
  {
    counts.push_back(s.connectivityCounts + 8 * i);
  }
  for (const std::size_t at : counts)
  {
    for (const std::uint64_t value :
      { std::uint64_t(1) << 63, ~std::uint64_t(0), (~std::uint64_t(0)) / 24 + 1, std::uint64_t(1) << 32,
        std::uint64_t(1) << 31, (std::uint64_t(1) << 31) - 1, std::uint64_t(1) << 60 })
    {
      Bytes huge = bytes;
      putAt(huge, at, value);
      writeBytes(path, huge);
      EXPECT_FALSE(readsOrThrows(path, huge.size())) << "offset " << at << ", value " << value;
    }
  }
}

} // namespace

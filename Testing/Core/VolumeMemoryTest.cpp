// What a volume keeps from frame to frame: vertex values within a budget, and its table.
#include "Interpolation/BlockCache.h"
#include "Support/AllocationCounter.h"
#include "Support/Fields.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeViews.h"

#include <oneapi/tbb/task_arena.h>

#include <gtest/gtest.h>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;

std::shared_ptr<const Field> randomField(const RandomTree& options)
{
  return makeField(unitRoots(options.roots), makeRandomTree(options));
}

constexpr std::size_t chunkBytes = 256 * BlockCache::blockBytes;

/// Of the table of nodes, and of one chunk of blocks more.
std::size_t smallestBudget(const Octree& octree)
{
  return octree.innerCount() * 4 + chunkBytes;
}

} // namespace

TEST(VolumeMemory, KeptValuesNeverChangeABit)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  const Camera camera(views().front().clip, identityMatrix, width, height);
  const Octree& octree = field->octree();
  inFloatsAndDoubles({}, [&](const VolumeSettings& settings) {
    Volume none(field, smooth(), 0);
    Volume one(field, smooth(), smallestBudget(octree));
    Volume all(field, smooth());
    Image images[]{ { width, height }, { width, height }, { width, height }, { width, height } };
    const auto computed = none.render(camera, settings, images[0]).blocks;
    one.render(camera, settings, images[1]);
    const auto first = all.render(camera, settings, images[2]).blocks;
    const auto second = all.render(camera, settings, images[3]);
    for (const Image& image : images)
    {
      EXPECT_EQ(image.rgba, images[0].rgba);
    }
    EXPECT_LE(first, computed);
    EXPECT_GT(first, 100u);
    EXPECT_EQ(second.blocks, 0u);
    EXPECT_EQ(second.cells, 0u);
    EXPECT_GT(second.kept, 100u);
    EXPECT_EQ(none.keptBytes(), 0u);
    EXPECT_LE(one.keptBytes(), smallestBudget(octree) + 1024);
    EXPECT_GE(all.keptBytes(), first * BlockCache::blockBytes);
  });
}

TEST(VolumeMemory, KeepsNoMoreThanItsBudgetInAnyFrame)
{
  const auto field = randomField({ 5, { 2, 2, 2 }, 6, 0.7, 0., false });
  const Octree& octree = field->octree();
  ASSERT_GT(octree.innerCount(), 400u);
  const std::size_t nothing = BlockCache(*field, smallestBudget(octree)).byteSize();
  Volume volume(field, smooth(), smallestBudget(octree));
  // Each view twice: what was kept for one gives way to the next.
  for (const View& view : views())
  {
    for (int repeat = 0; repeat < 3; ++repeat)
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      Image image(width, height);
      Image expected(width, height);
      volume.render(camera, {}, image);
      renderVolume(*field, smooth(), camera, {}, {}, expected);
      EXPECT_EQ(image.rgba, expected.rgba) << view.name;
      EXPECT_LE(volume.keptBytes(), nothing + chunkBytes);
    }
  }
}

TEST(VolumeMemory, LitFramesHaveTwiceTheRoomForValues)
{
  const auto field = randomField({ 5, { 2, 2, 2 }, 6, 0.7, 0., false });
  const Octree& octree = field->octree();
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image image(width, height);
  // One thread, which begins no chunks of its own.
  tbb::task_arena(1).execute([&] {
    VolumeSettings lit;
    lit.gradientOpacity = GradientOpacity{ 1., { 0.9f, 1.f } };
    Volume all(field, smooth());
    const std::uint64_t blocks = all.render(camera, lit, image).blocks;
    const std::uint64_t chunks = blocks / 256 + 1;
    ASSERT_GE(chunks, 2u);
    const std::size_t budget = octree.innerCount() * 4 + (chunks + 1) / 2 * chunkBytes;
    const std::size_t values = BlockCache(*field, budget).byteSize() + (chunks + 1) / 2 * chunkBytes;
    Volume volume(field, smooth(), budget);
    volume.render(camera, {}, image);
    EXPECT_GT(volume.render(camera, {}, image).blocks, 0u);
    EXPECT_LE(volume.keptBytes(), values);
    volume.render(camera, lit, image);
    EXPECT_EQ(volume.render(camera, lit, image).blocks, 0u);
    // Plain frames have what is theirs again.
    EXPECT_GT(volume.render(camera, {}, image).blocks, 0u);
    EXPECT_LE(volume.keptBytes(), values);
  });
}

TEST(VolumeMemory, AMovingCameraTabulatesNothing)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  constexpr std::size_t count = 100000;
  // Of which the integrals are taken, too.
  std::vector<TransferFunction::Entry> entries(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    entries[i] = { 1.f, 0.5f, 0.2f, i % 1000 == 0 ? 1000.f : 0.1f };
  }
  constexpr std::size_t tableBytes = count * sizeof(TransferFunction::Entry);
  Volume volume(field, TransferFunction(0., 1., entries));
  std::vector<std::size_t> bytes;
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    Image image(width, height);
    bytes.push_back(peakBytes([&] { volume.render(camera, {}, image); }));
  }
  EXPECT_GT(bytes.front(), 4 * tableBytes);
  for (std::size_t i = 1; i < bytes.size(); ++i)
  {
    EXPECT_LT(bytes[i], tableBytes) << views()[i].name;
  }
}

TEST(VolumeMemory, BlocksOfManyFramesShareTheirChunks)
{
  const auto field = randomField({ 5, { 2, 2, 2 }, 6, 0.7, 0., false });
  const std::size_t nothing = BlockCache(*field, defaultKeptBytes).byteSize();
  Volume volume(field, smooth());
  std::size_t blocks = 0;
  for (const View& view : views())
  {
    Image image(width, height);
    blocks += volume.render(Camera(view.clip, identityMatrix, width, height), {}, image).blocks;
  }
  // One that is not full for each thread.
  const std::size_t chunks = blocks / 256 + static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  EXPECT_GT(blocks, 256u);
  EXPECT_LE(volume.keptBytes(), nothing + chunks * chunkBytes);
}

// The boxes that a tile's rays come to, against each ray and each box, on every instruction set: all that a packet's
// rays meet, and hardly more.
#include "Surface/BlockBoxes.h"
#include "Support/Cameras.h"
#include "Support/Targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Of views at the box from 0 to 3, 2, 1: the tiles of a small window.
struct View
{
  std::string name;
  Camera camera;
};

std::vector<View> views()
{
  const Vec3 middle{ 1.5, 1., 0.5 };
  const auto view = [](const std::string& name, const Matrix4& projection, const Matrix4& look) {
    return View{ name, Camera(multiply(projection, look), identityMatrix, 44, 38) };
  };
  const Matrix4 wide = perspective(60., 0.1, 20.);
  return { view("perspective", wide, lookAt({ 4.1, 3.3, 5.2 }, middle)),
    view("from behind", wide, lookAt({ -2.1, -1.3, -1.2 }, middle)),
    view("from inside", wide, lookAt({ 0.3, 0.4, 0.6 }, { 3., 1.7, 0.2 })),
    view("along faces", wide, lookAt({ 1.5, 1., 9. }, middle, { 0., 1., 0. })),
    view("far away", perspective(1e-7, 1e9, 3e9), lookAt({ 1e9, 1.2e9, 8e8 }, middle)),
    view("parallel", parallel(2., 0.1, 20.), lookAt({ 4.1, 3.3, 5.2 }, middle)),
    view("parallel to faces", parallel(1.15, 1., 20.), lookAt({ 1.5, 1., 9. }, middle, { 0., 1., 0. })) };
}

using Boxes = std::vector<UnitBox>;

/// Near each other when their numbers are, as in Morton order; some without extent.
Boxes randomBoxes(std::size_t count)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<float> part(0.f, 1.f);
  Boxes boxes(count);
  std::array<float, 3> corner{};
  for (std::size_t i = 0; i < count; ++i)
  {
    for (int a = 0; a < 3; ++a)
    {
      corner[a] = i % 16 == 0 ? part(random) : std::min(1.f, corner[a] + 0.02f * part(random));
      if (i % 29 != 5)
      {
        boxes[i].low[a] = corner[a];
        boxes[i].high[a] = std::min(1.f, corner[a] + 0.4f * part(random));
      }
    }
  }
  return boxes;
}

BoxLevels levelsOf(Boxes boxes)
{
  BoxLevels levels;
  while (levels.empty() || boxes.size() > 1)
  {
    Boxes unions((boxes.size() + BoxGroup::size - 1) / BoxGroup::size);
    levels.emplace_back(unions.size());
    boxes.resize(unions.size() * BoxGroup::size);
    for (std::size_t i = 0; i < boxes.size(); ++i)
    {
      UnitBox& all = unions[i / BoxGroup::size];
      for (int a = 0; a < 3; ++a)
      {
        levels.back()[i / BoxGroup::size].low[a][i % BoxGroup::size] = boxes[i].low[a];
        levels.back()[i / BoxGroup::size].high[a][i % BoxGroup::size] = boxes[i].high[a];
        all.low[a] = std::min(all.low[a], boxes[i].low[a]);
        all.high[a] = std::max(all.high[a], boxes[i].high[a]);
      }
    }
    boxes = unions;
  }
  return levels;
}

/// Whether a ray goes through a box.
bool meets(const TraceSpace& space, const RayPart& part, const UnitBox& box)
{
  double in = part.tEnter;
  double out = part.tLeave;
  Vec3 low;
  Vec3 high;
  for (int a = 0; a < 3; ++a)
  {
    const double extent = space.domain().max[a] - space.domain().min[a];
    low[a] = space.domain().min[a] + box.low[a] * extent;
    high[a] = space.domain().min[a] + box.high[a] * extent;
  }
  return low[0] <= high[0] && part.ray.clip(low, high, in, out);
}

/// The rays of a tile's packets that meet the domain.
int startTile(const TraceSpace& space, const Camera& camera, int i, int j, SlabRays& rays)
{
  int count = 0;
  for (int y = RayTile::size * j; y < RayTile::size * (j + 1); y += RayTile::packet)
  {
    for (int x = RayTile::size * i; x < RayTile::size * (i + 1); x += RayTile::packet)
    {
      PixelRays pixels;
      castRays(camera, false, x, y, pixels);
      count += std::popcount(startRays(space, pixels, 0xffffu, count, rays));
    }
  }
  return count;
}

} // namespace

TEST(BlockBoxes, AreThoseThatPacketsMeetAndHardlyMore)
{
  for (const std::size_t count : { std::size_t(1), std::size_t(8), std::size_t(777) })
  {
    const Boxes boxes = randomBoxes(count);
    const BoxLevels levels = levelsOf(boxes);
    const RootGrid grid = RootGrid::uniform({ 3, 2, 1 }, { 0., 0., 0. }, { 1., 1., 1. });
    const TraceSpace space(grid);
    std::size_t met = 0;
    std::size_t found = 0;
    forEachTarget([&](const char* target) {
      for (const auto& [name, camera] : views())
      {
        SCOPED_TRACE(name + " on " + target);
        for (int tile = 0; tile < 9; ++tile)
        {
          const auto rays = std::make_unique<SlabRays>();
          const int rayCount = startTile(space, camera, tile % 3, tile / 3, *rays);
          std::vector<MetBlock> blocks;
          findBlocks(space, levels, *rays, rayCount, blocks);
          std::map<std::uint32_t, std::uint32_t> packetsOf;
          for (const MetBlock& block : blocks)
          {
            ASSERT_LT(block.block, count);
            ASSERT_NE(block.packets, 0u);
            ASSERT_TRUE(packetsOf.emplace(block.block, block.packets).second) << "twice";
            found += std::popcount(block.packets);
          }
          for (std::uint32_t b = 0; b < count; ++b)
          {
            std::uint32_t expected = 0;
            for (int r = 0; r < rayCount; ++r)
            {
              expected |= static_cast<std::uint32_t>(meets(space, rays->at(r), boxes[b]))
                << r / PixelRays::most;
            }
            met += std::popcount(expected);
            ASSERT_EQ(expected & ~packetsOf[b], 0u) << "box " << b << " of tile " << tile;
          }
        }
      }
    });
    if (count > 100)
    {
      EXPECT_GT(met, 20000u);
      EXPECT_LT(found, met + met / 2) << met;
    }
  }
}

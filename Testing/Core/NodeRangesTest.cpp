// Ranges in two bytes: around the exact range whatever the values, and the tightest there is.
#include "Field/Field.h"
#include "Field/RangeCode.h"
#include "Interpolation/VertexValues.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <random>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr float largest = std::numeric_limits<float>::max();
constexpr float denormal = std::numeric_limits<float>::denorm_min();

/// Any finite float, by its bits.
float anyFloat(std::mt19937& random)
{
  for (;;)
  {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::abs(value) <= largest)
    {
      return value;
    }
  }
}

float between(Range range, std::mt19937& random)
{
  std::uniform_real_distribution<double> unit(0., 1.);
  const double at = unit(random);
  return std::clamp(static_cast<float>(range.min * (1. - at) + range.max * at), range.min, range.max);
}

Range ordered(float a, float b)
{
  return { std::min(a, b), std::max(a, b) };
}

Range decodeRaw(int lower, int upper, Range parent)
{
  const std::array<std::uint8_t, 2> bytes{ static_cast<std::uint8_t>(lower),
    static_cast<std::uint8_t>(upper) };
  return std::bit_cast<RangeCode>(bytes).decode(parent);
}

std::vector<Range> parents()
{
  std::vector<Range> ranges{ { 0.f, 0.f }, { 1.f, 1.f }, { 0.f, 1.f }, { -largest, largest },
    { -1e38f, 1e-38f }, { largest, largest }, { -largest, -largest }, { 0.f, denormal },
    { -denormal, denormal }, { 0.f, 100 * denormal }, { -200 * denormal, 300 * denormal },
    { 1.f, std::nextafter(1.f, 2.f) }, { 1e8f, 1e8f + 640.f }, { -0.f, 0.f } };
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i)
  {
    ranges.push_back(ordered(anyFloat(random), anyFloat(random)));
  }
  return ranges;
}

} // namespace

TEST(RangeCode, IsTheTightestAroundTheExactRange)
{
  std::mt19937 random(4);
  for (const Range parent : parents())
  {
    std::array<Range, 256> byCode;
    for (int code = 0; code < 256; ++code)
    {
      byCode[code] = decodeRaw(code, code, parent);
    }
    std::vector<Range> exact{ parent, { parent.min, parent.min }, { parent.max, parent.max } };
    for (int i = 0; i < 40; ++i)
    {
      const float value = between(parent, random);
      exact.push_back(ordered(value, i % 2 == 0 ? value : between(parent, random)));
      exact.push_back({ byCode[random() % 256].min, parent.max }); // on a step
    }
    for (const Range e : exact)
    {
      const Range decoded = RangeCode(e, parent).decode(parent);
      Range best = parent;
      for (const Range& c : byCode)
      {
        best.min = c.min <= e.min ? std::max(best.min, c.min) : best.min;
        best.max = c.max >= e.max ? std::min(best.max, c.max) : best.max;
      }
      EXPECT_EQ(decoded.min, best.min) << e.min << ' ' << e.max << " in " << parent.min << ' ' << parent.max;
      EXPECT_EQ(decoded.max, best.max) << e.min << ' ' << e.max << " in " << parent.min << ' ' << parent.max;
    }
  }
}

TEST(RangeCode, DividesTheParentIntoEqualSteps)
{
  const Range parent{ -1.f, 254.f };
  for (int code = 0; code < 256; ++code)
  {
    const Range decoded = decodeRaw(code, code, parent);
    EXPECT_EQ(decoded.min, static_cast<float>(code - 1));
    EXPECT_EQ(decoded.max, static_cast<float>(code - 1));
  }
  const Range whole{ -largest, largest };
  EXPECT_EQ(decodeRaw(0, 255, whole).min, -largest);
  EXPECT_EQ(decodeRaw(0, 255, whole).max, largest);
}

TEST(NodeRanges, HoldTheVertexValuesOfAnyField)
{
  const std::vector<std::function<float(std::mt19937&)>> fields{
    anyFloat,
    [](std::mt19937&) { return 0.1f; },
    [](std::mt19937& random) { return random() % 2 == 0 ? -largest : largest; },
    [](std::mt19937& random) { return static_cast<float>(random() % 3) * denormal; },
    [](std::mt19937& random) { return random() % 64 == 0 ? 1e38f : 1e-38f; },
    [](std::mt19937& random) { return 1e8f + static_cast<float>(random() % 1000); },
  };
  std::mt19937 random(6);
  for (const RandomTree& options : propertyTrees())
  {
    for (const auto& value : fields)
    {
      auto cells = makeRandomTree(options);
      for (LeafCell& c : cells)
      {
        c.value = value(random);
      }
      auto built = buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
      Field field(built.octree, std::move(built.values));
      std::vector<Range> decoded(Octree::maxDepth + 1); // of the nodes on the path
      TreePath root(*built.octree);
      forEachNode(root, [&](const TreePath& path) {
        const Range parent = path.depth() == 0 ? field.range() : decoded[path.depth() - 1];
        if (path.node().isInner())
        {
          const Range range = field.nodeRanges().of(path.node().index(), parent);
          EXPECT_LE(parent.min, range.min);
          EXPECT_LE(range.max, parent.max);
          decoded[path.depth()] = range;
        }
        else
        {
          const Range exact = hull(vertexValues<VertexRule::GTI>(path, field));
          EXPECT_LE(parent.min, exact.min);
          EXPECT_GE(parent.max, exact.max);
        }
      });
    }
  }
}

TEST(NodeRanges, CostTwoBytesPerInnerNode)
{
  const RandomTree options{ 3, { 2, 2, 2 }, 5, 0.7, 0., true };
  auto built =
    buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options));
  Field field(built.octree, std::move(built.values));
  const std::size_t before = field.byteSize();
  EXPECT_EQ(before, 4 * (built.octree->leafCount() + built.octree->innerCount()))
    << "none before they are asked for";
  const Field copy(field);
  EXPECT_EQ(field.nodeRanges().byteSize(), 2 * built.octree->innerCount());
  EXPECT_EQ(field.byteSize() - before, 2 * built.octree->innerCount());
  EXPECT_EQ(&copy.nodeRanges(), &field.nodeRanges()) << "copies share them";
}

TEST(NodeRanges, AreMadeOnceWhoeverAsks)
{
  const RandomTree options{ 4, { 2, 2, 2 }, 5, 0.7, 0., true };
  auto built =
    buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options));
  const Field field(built.octree, std::move(built.values));
  std::vector<const NodeRanges*> found(64);
  tbb::parallel_for(std::size_t(0), found.size(), [&](std::size_t i) { found[i] = &field.nodeRanges(); });
  EXPECT_EQ(std::count(found.begin(), found.end(), &field.nodeRanges()), 64);
}

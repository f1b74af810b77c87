// Points near each other share what they need: with the same bits as each by itself.
#include "Interpolation/PointSampler.h"
#include "Geometry/Trilinear.h"
#include "Interpolation/VertexValues.h"
#include "Support/Fields.h"
#include "Support/ListSource.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// The leaf at a point by the definition: halves of boxes from the root down, the upper one of two or, along the axes in
/// `lower`, the lower one.
bool descend(TreePath& path, Vec3 p, unsigned lower, Vec3& place)
{
  path.reset();
  while (path.node().isInner())
  {
    int octant = 0;
    for (int a = 0; a < 3; ++a)
    {
      p[a] *= 2.;
      const bool upper = lower >> a & 1 ? p[a] > 1. : p[a] >= 1.;
      octant |= upper << a;
      p[a] -= upper;
    }
    path.descend(octant);
  }
  place = p;
  return path.node().isLeaf();
}

bool find(TreePath& path, const Vec3& pWorld, Vec3& place)
{
  const RootGrid& grid = path.octree().grid();
  Vec3 p;
  for (int a = 0; a < 3; ++a)
  {
    p[a] = std::ldexp(grid.latticeCoordinate(a, pWorld[a]), -grid.paddingDepth());
    if (std::isnan(p[a]))
    {
      return false;
    }
  }
  for (unsigned lower = 0; lower < 8; ++lower)
  {
    bool onPlanes = true;
    for (int a = 0; a < 3; ++a)
    {
      const double finest = std::ldexp(p[a], grid.paddingDepth() + path.octree().leafLevels());
      onPlanes = onPlanes && (!(lower >> a & 1) || finest == std::floor(finest));
    }
    if (onPlanes && descend(path, p, lower, place))
    {
      return true;
    }
  }
  return false;
}

/// Expects the finder and the sampler to give what the point's leaf gives by itself; whether there is one.
bool expectSame(const Field& field, const Vec3& p, LeafFinder& finder, PointSampler& sampler)
{
  TreePath path(field.octree());
  Vec3 place;
  LeafFinder::Leaf leaf;
  FieldSample sample;
  double value = 0.;
  if (!find(path, p, place))
  {
    EXPECT_FALSE(finder.find(p, leaf));
    EXPECT_FALSE(sampler.sample(p, sample));
    EXPECT_FALSE(sampler.value(p, value));
    return false;
  }
  EXPECT_TRUE(finder.find(p, leaf));
  EXPECT_EQ(leaf.depth, path.depth());
  EXPECT_EQ(leaf.index, path.index());
  EXPECT_EQ(leaf.place, place);
  const VertexValues values = vertexValues<VertexRule::GTI>(path, field);
  const Bounds box = field.octree().grid().nodeBounds(path.index(), path.depth());
  int first = 0;
  for (int a = 0; a < 3; ++a)
  {
    const bool upper = place[a] >= 0.5;
    first += upper * leafVertexStride[a];
    place[a] = 2. * place[a] - upper;
  }
  const Corners corners = cornersOf(values.data() + first, leafVertexStride);
  EXPECT_TRUE(sampler.sample(p, sample));
  EXPECT_TRUE(sampler.value(p, value));
  EXPECT_EQ(sample.value, trilinear(corners, place));
  EXPECT_EQ(value, sample.value);
  const Vec3 gradient = trilinearGradient(corners, place);
  for (int a = 0; a < 3; ++a)
  {
    if (const double width = box.max[a] - box.min[a]; width > 0.) // the deepest cells have none in the world
    {
      EXPECT_EQ(sample.gradient[a], 2. * gradient[a] / width);
    }
  }
  return true;
}

/// Points of a walk: short steps, now and then a jump, and often on planes of a lattice or the domain's ends.
class Walk
{
public:
  Walk(const Bounds& domain, int levels, std::uint32_t seed)
    : domain_(domain)
    , random_(seed)
    , perUnit_(std::ldexp(1., std::min(levels, 20)))
  {
  }
  Vec3 next()
  {
    std::uniform_real_distribution<double> unit(0., 1.);
    const bool jumps = unit(random_) < 0.05;
    Vec3 p;
    for (int a = 0; a < 3; ++a)
    {
      part_[a] = jumps ? unit(random_) : std::clamp(part_[a] + 0.02 * (unit(random_) - 0.5), 0., 1.);
      const double width = domain_.max[a] - domain_.min[a];
      const double chance = unit(random_);
      p[a] = domain_.min[a] + part_[a] * width;
      p[a] = chance < 0.2 ? std::round(p[a] * perUnit_) / perUnit_ : p[a];
      p[a] = chance > 0.98 ? domain_.max[a] : chance > 0.96 ? domain_.min[a] : p[a];
    }
    return p;
  }

private:
  Bounds domain_;
  std::mt19937 random_;
  double perUnit_;
  Vec3 part_{ 0.5, 0.5, 0.5 };
};

} // namespace

TEST(PointSampler, HasTheBitsOfEachLeafByItself)
{
  int inside = 0;
  int outside = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
    LeafFinder finder(field->octree());
    PointSampler sampler(*field);
    Walk walk(field->octree().grid().bounds(), options.levels, options.seed);
    for (int i = 0; i < 2000 && !HasFailure(); ++i)
    {
      (expectSame(*field, walk.next(), finder, sampler) ? inside : outside)++;
    }
  }
  EXPECT_GT(inside, 30000);
  EXPECT_GT(outside, 3000);
}

TEST(PointSampler, KnowsStretchedRootsAndSingleCells)
{
  const RandomTree options{ 3, { 2, 1, 1 }, 4, 0.6, 0.1, false };
  for (const auto& field :
    { makeField(
        RootGrid({ std::vector<double>{ 0., 1., 4. }, { -3., 0.5 }, { 0., 2. } }), makeRandomTree(options)),
      makeField(unitRoots({ 1, 1, 1 }), { { { {}, 0 }, 3.f } }),
      makeField(unitRoots({ 3, 1, 1 }), { { { { 1, 0, 0 }, 0 }, 3.f } }),
      makeField(unitRoots({ 1, 1, 1 }), {}) })
  {
    LeafFinder finder(field->octree());
    PointSampler sampler(*field);
    Walk walk(field->octree().grid().bounds(), 4, 5);
    for (int i = 0; i < 5000 && !HasFailure(); ++i)
    {
      expectSame(*field, walk.next(), finder, sampler);
    }
    for (const double bad : { std::nan(""), -1e300, HUGE_VAL, 4.0001 })
    {
      expectSame(*field, { bad, 0.5, 0.5 }, finder, sampler);
    }
  }
}

// Digits: a lattice index of a deep level has more than a double.
TEST(PointSampler, KnowsTheDeepestCells)
{
  for (const int keep : { 0, 7, 5 })
  {
    std::vector<LeafCell> cells;
    std::array<Coord, 3> parent{};
    constexpr int depth = 60;
    for (int level = 1; level <= depth; ++level)
    {
      const int inner = level == 1 ? 7 - keep : keep; // towards the middle of the domain
      for (int o = 0; o < 8; ++o)
      {
        if (o != inner || level == depth)
        {
          cells.push_back({ { indexOfChild(parent, o), level }, static_cast<float>(level + o) });
        }
      }
      parent = indexOfChild(parent, inner);
    }
    const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
    LeafFinder finder(field->octree());
    PointSampler sampler(*field);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> sides(-1., 1.);
    for (int i = 0; i < 4000 && !HasFailure(); ++i)
    {
      Vec3 p;
      for (double& x : p)
      {
        const double offset = std::ldexp(sides(random), -static_cast<int>(random() % 55));
        x = 0.5 + (random() % 8 == 0 ? 0. : offset * 0.5);
      }
      expectSame(*field, p, finder, sampler);
    }
  }
}

TEST(PointSampler, ComputesABlockOnceForPointsNearEachOther)
{
  const RandomTree options{ 7, { 4, 4, 1 }, 3, 0.8, 0., false };
  const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
  PointSampler sampler(*field);
  LeafFinder finder(field->octree());
  std::set<std::uint64_t> blocks;
  constexpr int size = 200;
  for (int j = 0; j < size; ++j)
  {
    for (int i = 0; i < size; ++i)
    {
      const Vec3 p{ 4. * (i + 0.5) / size, 4. * (j + 0.5) / size, 0.3 };
      double value;
      ASSERT_TRUE(sampler.value(p, value));
      LeafFinder::Leaf leaf;
      ASSERT_TRUE(finder.find(p, leaf));
      blocks.insert(finder.pathToParent().node[finder.pathToParent().depth]);
    }
  }
  // Of the blocks of a few rows some fall on each other's place.
  EXPECT_LT(static_cast<double>(sampler.computedBlocks()), 2. * static_cast<double>(blocks.size()));
  EXPECT_GT(static_cast<double>(sampler.computedBlocks()), 0.5 * static_cast<double>(blocks.size()));
  EXPECT_GT(blocks.size(), 50u);
}

// Vertex gradients, against their brute-force evaluation and as properties.
#include "Interpolation/BlockGradients.h"
#include "Interpolation/GradientCache.h"
#include "Support/BruteForceGTI.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr std::uint64_t allOctants = ~std::uint64_t(0);

/// Calls f(path, children) for the inner nodes with leaves among their children.
template <class F>
void forEachBlock(const Octree& octree, const F& f)
{
  TreePath root(octree);
  forEachNode(root, [&](const TreePath& at) {
    if (at.node().isInner() && octree.children(at.node().index()).leaf != 0)
    {
      f(at, octree.children(at.node().index()));
    }
  });
}

/// A vertex of a block on the lattice of the finest octants.
BruteForceGTI::Vertex finestVertex(const Octree& octree, const TreePath& block, int vertex)
{
  const int up = octree.grid().paddingDepth() + octree.leafLevels() - 1 - block.depth();
  BruteForceGTI::Vertex v{ vertex % 5, vertex / 5 % 5, vertex / 25 };
  for (int a = 0; a < 3; ++a)
  {
    v[a] = (4 * block.index()[a] + v[a]) << up;
  }
  return v;
}

/// Of a random octant of a leaf among the children.
int randomOctant(const Octree::Children& children, std::mt19937& random)
{
  int octant;
  do
  {
    octant = static_cast<int>(random() % 64);
  }
  while (!(children.leaf >> ((octant >> 1 & 1) | (octant >> 3 & 1) << 1 | octant >> 5 << 2) & 1));
  return octant;
}

std::uint64_t octantsOfLeaves(const Octree::Children& children)
{
  std::uint64_t octants = 0;
  for (int o = 0; o < 64; ++o)
  {
    const int child = (o >> 1 & 1) | (o >> 3 & 1) << 1 | o >> 5 << 2;
    octants |= static_cast<std::uint64_t>(children.leaf >> child & 1) << o;
  }
  return octants;
}

int cornerOf(int octant, int corner)
{
  return block::vertexIndex(octant & 3, octant >> 2 & 3, octant >> 4) +
    cornerOffset(corner, block::vertexStride);
}

/// Planes that are apart by different widths.
RootGrid unequalRoots(const std::array<int, 3>& roots)
{
  std::array<std::vector<double>, 3> planes;
  for (int a = 0; a < 3; ++a)
  {
    planes[a] = { 0. };
    for (int i = 0; i < roots[a]; ++i)
    {
      planes[a].push_back(planes[a].back() + 0.25 * (1 + a) + 0.5 * (i % 2));
    }
  }
  return RootGrid(planes);
}

double largest(const Vec3& v)
{
  return std::max({ std::abs(v[0]), std::abs(v[1]), std::abs(v[2]) });
}

} // namespace

TEST(BlockGradients, EqualTheBruteForceEvaluation)
{
  int compared = 0;
  int hanging = 0;
  int oneSided = 0;
  double worst = 0.; // part of the steepest
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const RootGrid grid = options.seed % 2 != 0 ? unitRoots(options.roots) : unequalRoots(options.roots);
    const auto field = makeField(grid, cells);
    const BruteForceGTI brute(options.roots, cells);
    GradientEvaluator evaluator(*field);
    std::mt19937 random(options.seed);
    forEachBlock(field->octree(), [&](const TreePath& block, const Octree::Children& children) {
      if (random() % 4 != 0)
      {
        return;
      }
      const int octant = randomOctant(children, random);
      const int vertex = cornerOf(octant, static_cast<int>(random() % 8));
      BlockGradients gradients;
      evaluator.compute(
        BlockPath(block), BlockCells::Leaves, verticesOfOctants(std::uint64_t(1) << octant), gradients);
      const BruteForceGTI::Vertex v = finestVertex(field->octree(), block, vertex);
      const Vec3 expected = brute.gradient(v, grid);
      const Vec3& found = gradients[vertex];
      const double scale = std::max(1., largest(expected));
      for (int a = 0; a < 3; ++a)
      {
        worst = std::max(worst, std::abs(found[a] - expected[a]) / scale);
      }
      ++compared;
      hanging += std::any_of(block.around(block.depth()).begin(), block.around(block.depth()).end(),
        [&](NodeRef node) { return node.isLeaf() && node.depth() < block.depth(); });
      oneSided += !brute.isEven(v, 0);
    });
  }
  EXPECT_LT(worst, 1e-5); // means are rounded to float
  EXPECT_GT(compared, 2000);
  EXPECT_GT(hanging, 200);
  EXPECT_GT(oneSided, 500);
}

TEST(BlockGradients, AreTheSameWithTheBlocksValuesAtHand)
{
  for (const RandomTree& options : propertyTrees())
  {
    const auto field = makeField(unitRoots(options.roots), makeRandomTree(options));
    GradientEvaluator evaluator(*field);
    GradientEvaluator alone(*field);
    BlockEvaluator ofValues(*field);
    forEachBlock(field->octree(), [&](const TreePath& block, const Octree::Children& children) {
      std::array<double, block::vertexCount> values;
      ofValues.computeUnrounded(BlockPath(block), BlockCells::Leaves, values);
      const BlockVertices vertices = verticesOfOctants(octantsOfLeaves(children));
      BlockGradients with{};
      BlockGradients without{};
      evaluator.compute(BlockPath(block), BlockCells::Leaves, vertices, with, &values);
      alone.compute(BlockPath(block), BlockCells::Leaves, vertices, without);
      for (int v = 0; v < block::vertexCount; ++v)
      {
        const bool isAsked = vertices[v / 25] >> v % 25 & 1;
        for (int a = 0; a < 3 && isAsked; ++a)
        {
          ASSERT_NEAR(with[v][a], without[v][a], 1e-12) << "seed " << options.seed << ", vertex " << v;
        }
      }
    });
  }
}

TEST(BlockGradients, OfTrilinearFieldsAreExact)
{
  // Values are whole numbers of 2^-15: nothing is rounded.
  const auto f = [](const Vec3& p) {
    return p[0] * p[1] * p[2] + 2. * p[0] * p[1] - p[1] * p[2] + 3. * p[0] - p[2];
  };
  const auto gradientOf = [](const Vec3& p) {
    return Vec3{ p[1] * p[2] + 2. * p[1] + 3., p[0] * p[2] + 2. * p[0] - p[2], p[0] * p[1] - p[1] - 1. };
  };
  int compared = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed)
  {
    auto cells = makeRandomTree({ seed, { 4, 4, 4 }, 4, 0.4, 0., false });
    setValues(cells, f);
    const auto field = makeField(unitRoots({ 4, 4, 4 }), cells);
    GradientEvaluator evaluator(*field);
    forEachBlock(field->octree(), [&](const TreePath& block, const Octree::Children& children) {
      std::uint64_t octants = octantsOfLeaves(children);
      BlockGradients gradients;
      evaluator.compute(BlockPath(block), BlockCells::Leaves, verticesOfOctants(octants), gradients);
      for (; octants != 0; octants &= octants - 1)
      {
        for (int corner = 0; corner < 8; ++corner)
        {
          const int vertex = cornerOf(std::countr_zero(octants), corner);
          const BruteForceGTI::Vertex v = finestVertex(field->octree(), block, vertex);
          Vec3 p;
          bool isInside = true; // no missing cell takes part even where roots are leaves
          for (int a = 0; a < 3; ++a)
          {
            p[a] = std::ldexp(static_cast<double>(v[a]), -field->octree().leafLevels() - 1);
            isInside = isInside && p[a] >= 1.5 && p[a] <= 2.5;
          }
          if (isInside)
          {
            const Vec3 expected = gradientOf(p);
            for (int a = 0; a < 3; ++a)
            {
              ASSERT_NEAR(gradients[vertex][a], expected[a], 1e-12);
            }
            ++compared;
          }
        }
      }
    });
  }
  EXPECT_GT(compared, 5000);
}

TEST(BlockGradients, OfAPlaneReachTheDomainsEnd)
{
  // Cells of one size, where the outer halves are flat.
  auto cells = makeRandomTree({ 1, { 2, 2, 2 }, 1, 1., 0., false });
  setValues(cells, [](const auto& p) { return p[0] - 2. * p[1] + 4. * p[2]; });
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  GradientEvaluator evaluator(*field);
  forEachBlock(field->octree(), [&](const TreePath& block, const Octree::Children&) {
    BlockGradients gradients;
    evaluator.compute(BlockPath(block), BlockCells::Leaves, verticesOfOctants(allOctants), gradients);
    for (const Vec3& gradient : gradients)
    {
      EXPECT_EQ(gradient, (Vec3{ 1., -2., 4. }));
    }
  });
}

TEST(BlockGradients, OfMeansAreThoseOfTheTreeCutThere)
{
  auto cells = makeRandomTree({ 5, { 2, 2, 2 }, 4, 0.7, 0., false });
  std::mt19937 random(6);
  for (LeafCell& c : cells)
  {
    c.value = static_cast<float>(random() % 256); // so that means are exact
  }
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  constexpr int cut = 2; // level
  const BruteForceGTI whole({ 2, 2, 2 }, cells);
  std::vector<LeafCell> cutCells;
  for (const LeafCell& c : cells)
  {
    CellId cell = c.cell;
    const int up = std::max(0, cell.level - cut);
    for (Coord& i : cell.index)
    {
      i >>= up;
    }
    cell.level -= up;
    const auto isSame = [&](const LeafCell& other) {
      return other.cell.level == cell.level && other.cell.index == cell.index;
    };
    if (std::none_of(cutCells.begin(), cutCells.end(), isSame))
    {
      cutCells.push_back({ cell, static_cast<float>(*whole.cellValue(cell.level, cell.index)) });
    }
  }
  const auto cutField = makeField(unitRoots({ 2, 2, 2 }), cutCells);
  GradientEvaluator evaluator(*field);
  GradientEvaluator ofCut(*cutField);
  int refined = 0;
  TreePath root(cutField->octree());
  forEachNode(root, [&](const TreePath& at) {
    if (at.depth() != cut ||
      !at.node().isInner()) // blocks of cells of that level, as the roots are at depth 1
    {
      return;
    }
    const BlockPath path(field->octree(), at.index(), at.depth());
    BlockGradients means;
    BlockGradients leaves;
    BlockGradients expected;
    evaluator.compute(path, BlockCells::Leaves, verticesOfOctants(1),
      leaves); // in between: what is known of either is another
    evaluator.compute(path, BlockCells::Means, verticesOfOctants(allOctants), means);
    ofCut.compute(BlockPath(at), BlockCells::Leaves, verticesOfOctants(allOctants), expected);
    EXPECT_EQ(means, expected);
    refined += field->octree().children(path.node[path.depth]).innerCount();
  });
  EXPECT_GT(refined, 20);
}

TEST(BlockGradients, KeepTheirDigitsForFieldsAndCellsOfAnySize)
{
  const RandomTree options{ 9, { 2, 3, 1 }, 4, 0.6, 0.1, false };
  const auto cells = makeRandomTree(options);
  const auto gradientsOf = [&](int value, int width, double offset) {
    auto scaled = cells;
    for (LeafCell& c : scaled)
    {
      c.value = std::ldexp(c.value, value);
    }
    const double w = std::ldexp(1., width);
    const auto field =
      makeField(RootGrid::uniform(options.roots, { offset, offset, offset }, { w, w, w }), scaled);
    GradientEvaluator evaluator(*field);
    std::vector<BlockGradients> all;
    forEachBlock(field->octree(), [&](const TreePath& block, const Octree::Children& children) {
      std::mt19937 random(3);
      all.emplace_back();
      all.back().fill({});
      evaluator.compute(BlockPath(block), BlockCells::Leaves,
        verticesOfOctants(std::uint64_t(1) << randomOctant(children, random)), all.back());
    });
    return all;
  };
  const auto expected = gradientsOf(0, 0, 0.);
  for (const auto& [value, width, offset] :
    { std::tuple{ 126, -60, 0. }, { -100, 60, 0. }, { 126, 300, 0. }, { 0, -20, 1024. } })
  {
    const auto found = gradientsOf(value, width, offset);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
    {
      for (int v = 0; v < block::vertexCount; ++v)
      {
        for (int a = 0; a < 3; ++a)
        {
          // To the bit: powers of two change no digit.
          ASSERT_EQ(std::ldexp(found[i][v][a], width - value), expected[i][v][a]);
        }
      }
    }
  }
}

// Between the steps that are kept, wherever in a leaf, a gradient is as long as the record says at least; of a plane's it
// says that to the last part.
TEST(BlockGradients, RecordsBoundThemFromBelow)
{
  const RandomTree options{ 8, { 2, 2, 2 }, 4, 0.6, 0.1, false };
  std::vector<LeafCell> cells = makeRandomTree(options);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0., 1.);
  for (const bool isPlane : { false, true })
  {
    setValues(cells, [&](const auto& p) {
      return isPlane ? 3. * p[0] - 2. * p[1] + p[2] : std::sin(2. * p[0] + p[1]) * std::cos(1.5 * p[2]);
    });
    const auto field = makeField(unitRoots(options.roots), cells);
    const Octree& octree = field->octree();
    GradientEvaluator evaluator(*field);
    BlockGradients gradients;
    double tightest = 1e9;
    int bounded = 0;
    forEachBlock(octree, [&](const TreePath& at, const Octree::Children& children) {
      const BlockVertices vertices = verticesOfOctants(octantsOfLeaves(children));
      evaluator.compute(BlockPath(at), BlockCells::Leaves, vertices, gradients);
      const BlockGradientRecord record(gradients, vertices, 1.);
      const std::array<std::uint8_t, 8> least = record.least();
      for (int sample = 0; sample < 200; ++sample)
      {
        const int octant = randomOctant(children, random);
        const std::array<double, 3> f{ unit(random), unit(random), unit(random) };
        Vec3 gradient{};
        for (int corner = 0; corner < 8; ++corner)
        {
          const double weight = (corner & 1 ? f[0] : 1. - f[0]) * (corner & 2 ? f[1] : 1. - f[1]) *
            (corner & 4 ? f[2] : 1. - f[2]);
          for (int a = 0; a < 3; ++a)
          {
            gradient[a] += weight * record.steps[a][cornerOf(octant, corner)];
          }
        }
        const int child = (octant >> 1 & 1) | (octant >> 3 & 1) << 1 | octant >> 5 << 2;
        const double length = std::sqrt(dot(gradient, gradient));
        const double bound = least[child] * BlockGradientRecord::most / double(BlockGradientRecord::leastParts);
        ASSERT_LE(bound, length);
        bounded += least[child] > 0;
        tightest = std::min(tightest, length - bound);
      }
    });
    EXPECT_GT(bounded, 1000);
    EXPECT_LT(tightest, 1.01 * BlockGradientRecord::most / BlockGradientRecord::leastParts);
  }
}

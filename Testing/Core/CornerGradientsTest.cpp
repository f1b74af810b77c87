// Gradients of fields that are given at the corners of leaves, against their definition and those of known functions.
#include "Interpolation/BlockGradients.h"
#include "Support/BruteForceGTI.h"
#include "Support/CornerFunction.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// The definition in CornerGradients.h.
class ExpectedGradients
{
public:
  using Vertex = CornerFunction::Vertex;

  explicit ExpectedGradients(const CornerCase& c)
    : function_(c.function)
    , truth_(c.options.roots, c.cells)
  {
    for (const LeafCell& cell : c.cells)
    {
      finest_ = std::max(finest_, cell.cell.level);
    }
  }

  Vec3 at(const Vertex& v) const
  {
    for (int level = 0; level <= finest_; ++level)
    {
      for (int side = 0; side < 8; ++side)
      {
        const CellId cell = this->cellAt(v, side, level);
        if (this->isLeaf(cell))
        {
          return this->at(v, cell);
        }
      }
    }
    ADD_FAILURE() << "no leaf";
    return {};
  }

private:
  Coord width(int level) const { return Coord(2) << (finest_ - level); }
  CellId cellAt(const Vertex& v, int side, int level) const
  {
    CellId cell{ {}, level };
    for (int a = 0; a < 3; ++a)
    {
      const Coord half = v[a] - (sideOf(side, a) ? 0 : 1);
      cell.index[a] = half < 0 ? -1 : half / this->width(level);
    }
    return cell;
  }
  bool isLeaf(const CellId& cell) const
  {
    return truth_.cellValue(cell.level, cell.index) && !truth_.isRefined(cell.level, cell.index) &&
      (cell.level == 0 ||
        truth_.isRefined(cell.level - 1, { cell.index[0] >> 1, cell.index[1] >> 1, cell.index[2] >> 1 }));
  }
  /// Whether a leaf in a cell touches one of its corners.
  bool hasLeafAt(CellId cell, int corner) const
  {
    while (truth_.isRefined(cell.level, cell.index))
    {
      cell = { indexOfChild(cell.index, corner), cell.level + 1 };
    }
    return truth_.cellValue(cell.level, cell.index).has_value();
  }
  /// coarsest: leaf around v.
  Vec3 at(const Vertex& v, const CellId& coarsest) const
  {
    const Coord h = this->width(coarsest.level);
    Vec3 place;
    bool hangs = false;
    for (int a = 0; a < 3; ++a)
    {
      const Coord rest = v[a] - h * coarsest.index[a];
      place[a] = static_cast<double>(rest) / static_cast<double>(h);
      hangs = hangs || (rest != 0 && rest != h);
    }
    Vec3 gradient{};
    if (hangs)
    {
      for (int c = 0; c < 8; ++c)
      {
        double weight = 1.;
        Vertex corner;
        for (int a = 0; a < 3; ++a)
        {
          weight *= sideOf(c, a) ? place[a] : 1. - place[a];
          corner[a] = h * (coarsest.index[a] + sideOf(c, a));
        }
        const Vec3 one = weight != 0. ? this->at(corner) : Vec3{};
        for (int a = 0; a < 3; ++a)
        {
          gradient[a] += weight * one[a];
        }
      }
      return gradient;
    }
    for (int a = 0; a < 3; ++a)
    {
      std::array<Vertex, 2> ends{ v, v };
      for (int upper = 0; upper < 2; ++upper)
      {
        bool has = false;
        for (int side = 0; side < 8; ++side)
        {
          has = has ||
            (sideOf(side, a) == upper &&
              this->hasLeafAt(this->cellAt(v, side, coarsest.level), (7 - side) ^ 1 << a));
        }
        ends[upper][a] += !has ? 0 : upper ? h : -h;
      }
      const double distance = std::ldexp(static_cast<double>(ends[1][a] - ends[0][a]), -finest_ - 1);
      gradient[a] = (function_.vertex(ends[1]) - function_.vertex(ends[0])) / distance;
    }
    return gradient;
  }

  const CornerFunction& function_;
  BruteForceGTI truth_;
  int finest_ = 0;
};

/// Calls f(path, octant, block) with the gradients at the vertices of each leaf.
template <class F>
void forEachLeafGradients(const Field& field, const F& f)
{
  GradientEvaluator evaluator(field);
  TreePath root(field.octree());
  forEachNode(root, [&](const TreePath& path) {
    if (!path.node().isInner())
    {
      return;
    }
    const unsigned leaves = field.octree().children(path.node().index()).leaf;
    for (int o = 0; o < 8; ++o)
    {
      if (leaves >> o & 1)
      {
        BlockVertices wanted{};
        for (int i = 0; i < 27; ++i)
        {
          add(wanted, 2 * sideOf(o, 0) + i % 3, 2 * sideOf(o, 1) + i / 3 % 3, 2 * sideOf(o, 2) + i / 9);
        }
        BlockGradients gradients;
        evaluator.compute(BlockPath(path), BlockCells::Leaves, wanted, gradients);
        f(path, o, gradients);
      }
    }
  });
}

} // namespace

TEST(CornerGradients, AreTheDefinition)
{
  int leaves = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const CornerCase c(options);
    const Field& field = *c.field;
    const ExpectedGradients expected(c);
    const int up = field.octree().leafLevels() + field.octree().grid().paddingDepth();
    forEachLeafGradients(field, [&](const TreePath& path, int octant, const BlockGradients& gradients) {
      if (leaves++ % 7 != 0)
      {
        return;
      }
      const int first =
        block::vertexIndex(2 * sideOf(octant, 0), 2 * sideOf(octant, 1), 2 * sideOf(octant, 2));
      std::array<Vec3, 8> corners;
      Vec3 mean{};
      for (int corner = 0; corner < 8; ++corner)
      {
        CornerFunction::Vertex v;
        for (int a = 0; a < 3; ++a)
        {
          v[a] = (2 * path.index()[a] + sideOf(octant, a) + sideOf(corner, a)) << (up - path.depth());
        }
        corners[corner] = expected.at(v);
        const Vec3& found = gradients[first + 2 * cornerOffset(corner, block::vertexStride)];
        for (int a = 0; a < 3; ++a)
        {
          ASSERT_NEAR(found[a], corners[corner][a], std::ldexp(1e-6, up)) << options.seed;
          mean[a] += corners[corner][a] / 8.;
        }
      }
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_NEAR(
          gradients[first + cornerOffset(7, block::vertexStride)][a], mean[a], std::ldexp(1e-6, up));
      }
    });
  }
  EXPECT_GT(leaves, 10000);
}

TEST(CornerGradients, OfATrilinearFunctionAreExactWhereNoCellIsMissing)
{
  const RandomTree options{ 7, { 3, 3, 3 }, 4, 0.95, 0., false };
  const auto cells = makeRandomTree(options);
  const auto f = [](const Vec3& p) {
    return 1. + 2. * p[0] - p[1] + 0.5 * p[2] + p[0] * p[1] - 0.3 * p[1] * p[2] + 0.7 * p[0] * p[2] +
      0.2 * p[0] * p[1] * p[2];
  };
  const CornerFunction function(cells, f);
  const auto field = function.field(unitRoots(options.roots));
  int inner = 0;
  const Octree& octree = field->octree();
  forEachLeafGradients(*field, [&](const TreePath& path, int octant, const BlockGradients& gradients) {
    const Bounds box = octree.grid().nodeBounds(indexOfChild(path.index(), octant), path.depth() + 1);
    for (int a = 0; a < 3; ++a)
    {
      if (box.min[a] < 1. || box.max[a] > 2.) // the middle root, beside which no leaf is larger
      {
        return;
      }
    }
    ++inner;
    const int first = block::vertexIndex(2 * sideOf(octant, 0), 2 * sideOf(octant, 1), 2 * sideOf(octant, 2));
    for (int corner = 0; corner < 8; ++corner)
    {
      Vec3 p;
      for (int a = 0; a < 3; ++a)
      {
        p[a] = sideOf(corner, a) ? box.max[a] : box.min[a];
      }
      const Vec3& g = gradients[first + 2 * cornerOffset(corner, block::vertexStride)];
      EXPECT_NEAR(g[0], 2. + p[1] + 0.7 * p[2] + 0.2 * p[1] * p[2], 1e-3);
      EXPECT_NEAR(g[1], -1. + p[0] - 0.3 * p[2] + 0.2 * p[0] * p[2], 1e-3);
      EXPECT_NEAR(g[2], 0.5 - 0.3 * p[1] + 0.7 * p[0] + 0.2 * p[0] * p[1], 1e-3);
    }
  });
  EXPECT_GT(inner, 100);
}

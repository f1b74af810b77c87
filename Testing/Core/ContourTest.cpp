// The contour is checked for what makes it a surface: every edge is run through once in each direction, and
// edges with one triangle lie on the boundary of the drawn cells.
#include "Contour/Contour.h"

#include "Contour/Octant.h"
#include "Error.h"
#include "Interpolation/Sampler.h"
#include "Interpolation/VertexValues.h"
#include "Octree/OctreeBuilder.h"
#include "Octree/TreePath.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Point = std::array<double, 3>;

Point minus(const Point& p, const Point& q)
{
  return { p[0] - q[0], p[1] - q[1], p[2] - q[2] };
}
double dot(const Point& p, const Point& q)
{
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}
Point cross(const Point& p, const Point& q)
{
  return { p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0] };
}

Field makeField(const RandomTree& options, const std::vector<LeafCell>& cells)
{
  auto built = buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
  Field field(built.octree, built.values);
  field.computeNodeRanges();
  return field;
}

/// A field as a source of trees with a quarter of the leaves as ghosts.
class WithGhosts
{
public:
  using Handle = NodeRef;

  explicit WithGhosts(const Field& field)
    : field_(field)
  {
    TreePath root(field.octree());
    forEachNode(root, [&](const TreePath& path) {
      if (path.depth() == field.octree().grid().paddingDepth())
      {
        roots_.emplace_back(path.index(), path.node());
      }
    });
  }
  std::size_t rootCount() const { return roots_.size(); }
  std::array<Coord, 3> rootPlace(std::size_t i) const { return roots_[i].first; }
  Handle root(std::size_t i) const { return roots_[i].second; }
  static NodeKind kind(const Handle& node) { return node.kind(); }
  Handle child(const Handle& node, int octant) const { return field_.octree().child(node, octant); }
  float value(const Handle& node) const { return field_.value(node); }
  static constexpr bool ghosts() { return true; }
  static bool isGhost(const Handle& node) { return node.index() * 2654435761u >> 5 & 1 && node.index() & 4; }

private:
  const Field& field_;
  std::vector<std::pair<std::array<Coord, 3>, NodeRef>> roots_;
};

/// Of each edge, lower point first: how often triangles run along it up and down.
std::map<std::array<std::int64_t, 2>, std::array<int, 2>> edgesOf(const ContourMesh& mesh)
{
  std::map<std::array<std::int64_t, 2>, std::array<int, 2>> edges;
  for (const auto& t : mesh.triangles)
  {
    for (int i = 0; i < 3; ++i)
    {
      const std::int64_t from = t[i];
      const std::int64_t to = t[(i + 1) % 3];
      ++edges[{ std::min(from, to), std::max(from, to) }][from < to ? 0 : 1];
    }
  }
  return edges;
}

/// Boxes of the drawn leaves, to ask what is at a point.
class Leaves
{
public:
  explicit Leaves(const Field& field)
  {
    TreePath root(field.octree());
    forEachNode(root, [&](const TreePath& path) {
      if (path.node().isLeaf() && !field.octree().isGhost(path.node().index()))
      {
        boxes_.push_back(field.octree().grid().nodeBounds(path.index(), path.depth()));
      }
    });
  }
  /// Whether an octant's face on which the line from p to q lies has no drawn cell on some part of its other
  /// side.
  bool isOpen(const Point& p, const Point& q) const
  {
    for (const Bounds& leaf : boxes_)
    {
      for (int face = 0; holds(leaf, p) && holds(leaf, q) && face < 24; ++face)
      {
        const int axis = face / 8;
        const bool upper = face & 1;
        Bounds octant = leaf;
        octant.min[axis] = octant.max[axis] = upper ? leaf.max[axis] : leaf.min[axis];
        for (int i = 1; i < 3; ++i)
        {
          const int a = (axis + i) % 3;
          (face >> i & 1 ? octant.min : octant.max)[a] = 0.5 * (leaf.min[a] + leaf.max[a]);
        }
        if (holds(octant, p) && holds(octant, q) && isOpen(octant, axis))
        {
          return true;
        }
      }
    }
    return false;
  }

private:
  static bool holds(const Bounds& box, const Point& p)
  {
    // A crossing of a coarse edge may lie just beyond a vertex that hangs on it.
    constexpr double rounding = 1e-7;
    bool inside = true;
    for (int a = 0; a < 3; ++a)
    {
      inside = inside && p[a] > box.min[a] - rounding && p[a] < box.max[a] + rounding;
    }
    return inside;
  }
  bool isOpen(const Bounds& face, int axis) const
  {
    double covered = 0.; // on both sides
    double whole = 2.;
    for (const Bounds& b : boxes_)
    {
      double area = face.min[axis] == b.min[axis] || face.min[axis] == b.max[axis] ? 1. : 0.;
      for (int i = 1; i < 3; ++i)
      {
        const int a = (axis + i) % 3;
        area *= std::max(0., std::min(face.max[a], b.max[a]) - std::max(face.min[a], b.min[a]));
      }
      covered += area;
    }
    for (int i = 1; i < 3; ++i)
    {
      const int a = (axis + i) % 3;
      whole *= face.max[a] - face.min[a];
    }
    return covered < whole * (1. - 1e-9);
  }

  std::vector<Bounds> boxes_;
};

/// Returns the number of boundary edges.
int expectSurface(const ContourMesh& mesh, const Field& field, const std::string& name)
{
  const Leaves leaves(field);
  int boundary = 0;
  int wrong = 0;
  for (const auto& [edge, count] : edgesOf(mesh))
  {
    EXPECT_NE(edge[0], edge[1]) << name;
    if (count[0] == 1 && count[1] == 1)
    {
      continue;
    }
    ++boundary;
    const Point& p = mesh.points[edge[0]];
    const Point& q = mesh.points[edge[1]];
    const bool fine = count[0] + count[1] == 1 && leaves.isOpen(p, q);
    wrong += !fine;
    if (!fine && wrong < 5)
    {
      ADD_FAILURE() << name << ": edge at " << p[0] << " " << p[1] << " " << p[2] << " to " << q[0] << " " << q[1] << " " << q[2] << " has "
                    << count[0] << " + " << count[1] << " triangles";
    }
  }
  EXPECT_EQ(wrong, 0) << name;
  std::vector<bool> used(mesh.points.size());
  for (const auto& t : mesh.triangles)
  {
    for (const std::int64_t p : t)
    {
      used.at(p) = true;
    }
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << name;
  return boundary;
}

} // namespace

TEST(Contour, IsASurfaceOnRandomTrees)
{
  int triangles = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const Field field = makeField(options, makeRandomTree(options));
    for (const double isovalue : { 0., 0.1, -0.3 })
    {
      const ContourMesh mesh = contour(field, isovalue);
      expectSurface(mesh, field, "seed " + std::to_string(options.seed) + " at " + std::to_string(isovalue));
      triangles += static_cast<int>(mesh.triangles.size());
    }
  }
  EXPECT_GT(triangles, 100000);
}

TEST(Contour, IsASurfaceWhereVerticesHaveTheIsovalue)
{
  std::mt19937 random(3);
  int triangles = 0;
  for (const RandomTree& options : propertyTrees())
  {
    auto cells = makeRandomTree(options);
    for (LeafCell& c : cells)
    {
      c.value = static_cast<float>(random() % 3) - 1.f;
    }
    const Field field = makeField(options, cells);
    for (const double isovalue : { 0., 0.5, 1., -0.25 })
    {
      const ContourMesh mesh = contour(field, isovalue);
      expectSurface(mesh, field, "seed " + std::to_string(options.seed) + " at " + std::to_string(isovalue));
      triangles += static_cast<int>(mesh.triangles.size());
    }
  }
  EXPECT_GT(triangles, 100000);
}

TEST(Contour, IsASurfaceAtGhosts)
{
  int edges = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const Field plain = makeField(options, makeRandomTree(options));
    auto built = buildOctree(plain.octree().grid(), WithGhosts(plain));
    Field field(built.octree, built.values);
    field.computeNodeRanges();
    edges += expectSurface(contour(field, 0.05), field, "seed " + std::to_string(options.seed));
  }
  EXPECT_GT(edges, 1000);
}

TEST(Contour, IsClosedForValuesOfAnySize)
{
  std::mt19937 random(9);
  for (const RandomTree& options : propertyTrees())
  {
    if (options.missing > 0.)
    {
      continue;
    }
    auto cells = makeRandomTree(options);
    std::vector<double> isovalues;
    for (LeafCell& c : cells)
    {
      c.value = std::ldexp(c.value, static_cast<int>(random() % 201) - 100);
      if (random() % 300 == 0)
      {
        isovalues.push_back(c.value);
      }
    }
    const Field field = makeField(options, cells);
    for (const double isovalue : isovalues)
    {
      const ContourMesh mesh = contour(field, isovalue);
      expectSurface(mesh, field, "seed " + std::to_string(options.seed) + " at " + std::to_string(isovalue));
    }
  }
}

TEST(Contour, PointsHaveTheIsovalue)
{
  // A point on an octant's edge is within 2^-24 of the edge; the centres of loops are found by iteration.
  int centres = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto field = std::make_shared<const Field>(makeField(options, makeRandomTree(options)));
    const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
    const ContourMesh mesh = contour(*field, 0.1);
    const std::vector<float> values = interpolate(*field, mesh);
    ASSERT_EQ(values.size(), mesh.points.size());
    int off = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
    {
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(mesh.points[i], sample));
      EXPECT_NEAR(values[i], sample.value, 4e-7);
      off += std::abs(values[i] - 0.1) > 4e-7;
    }
    EXPECT_LE(off, static_cast<int>(values.size()) / 20) << "seed " << options.seed;
    centres += off;
  }
  EXPECT_LT(centres, 1000);
}

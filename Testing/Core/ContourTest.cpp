// The contour is checked for what makes it a surface: every edge is run through once in each direction, and
// edges with one triangle lie on the boundary of the drawn cells.
#include "Contour/Contour.h"

#include "Error.h"
#include "Interpolation/Sampler.h"
#include "Octree/OctreeBuilder.h"
#include "Octree/TreePath.h"
#include "Support/BruteForceGTI.h"
#include "Support/CornerFunction.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"
#include "Support/RefinedTrees.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Point = std::array<double, 3>;

Point minus(const Point& p, const Point& q)
{
  return { p[0] - q[0], p[1] - q[1], p[2] - q[2] };
}
Field makeField(const RandomTree& options, const std::vector<LeafCell>& cells)
{
  auto built = buildOctree(RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), cells);
  return Field(built.octree, built.values);
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
std::vector<std::pair<std::array<std::int64_t, 2>, std::array<int, 2>>> edgesOf(const ContourMesh& mesh)
{
  std::vector<std::pair<std::array<std::int64_t, 2>, bool>> runs;
  for (const auto& t : mesh.triangles)
  {
    for (int i = 0; i < 3; ++i)
    {
      const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
      runs.push_back({ { low, high }, t[i] == high });
    }
  }
  std::sort(runs.begin(), runs.end());
  std::vector<std::pair<std::array<std::int64_t, 2>, std::array<int, 2>>> edges;
  for (const auto& [edge, down] : runs)
  {
    if (edges.empty() || edges.back().first != edge)
    {
      edges.push_back({ edge, {} });
    }
    ++edges.back().second[down];
  }
  return edges;
}

/// Boxes of the drawn leaves, to ask what is at a point.
class Leaves
{
public:
  explicit Leaves(const Field& field)
    : domain_(field.octree().grid().bounds())
    , whole_(field.corners() != nullptr)
  {
    TreePath root(field.octree());
    forEachNode(root, [&](const TreePath& path) {
      if (path.node().isLeaf() && !field.octree().isGhost(path.node().index()))
      {
        boxes_.push_back(field.octree().grid().nodeBounds(path.index(), path.depth()));
      }
    });
  }
  /// Whether a face of a piece, an octant or a leaf, on which the line from p to q lies has no drawn cell on some part of
  /// its other side.
  bool isOpen(const Point& p, const Point& q) const
  {
    for (int a = 0; a < 3; ++a)
    {
      if (p[a] == q[a] && (p[a] == domain_.min[a] || p[a] == domain_.max[a]))
      {
        return true;
      }
    }
    for (const Bounds& leaf : boxes_)
    {
      for (int face = 0; holds(leaf, p) && holds(leaf, q) && face < 24; ++face)
      {
        const int axis = face / 8;
        const bool upper = face & 1;
        Bounds octant = leaf;
        octant.min[axis] = octant.max[axis] = upper ? leaf.max[axis] : leaf.min[axis];
        for (int i = 1; i < 3 && !whole_; ++i)
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

  Bounds domain_;
  bool whole_; // leaves are pieces
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
      ADD_FAILURE() << name << ": edge at " << p[0] << " " << p[1] << " " << p[2] << " to " << q[0] << " "
                    << q[1] << " " << q[2] << " has " << count[0] << " + " << count[1] << " triangles";
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
    const ContourMesh mesh = contour(field, 0.05, { .gradients = true });
    edges += expectSurface(mesh, field, "seed " + std::to_string(options.seed));
    for (const auto& g : mesh.gradients)
    {
      EXPECT_TRUE(std::isfinite(g[0]) && std::isfinite(g[1]) && std::isfinite(g[2]));
    }
  }
  EXPECT_GT(edges, 1000);
}

TEST(Contour, OfCornersIsASurface)
{
  int triangles = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const CornerFunction function(makeRandomTree(options), options.seed);
    const auto field = function.field(unitRoots(options.roots));
    for (const double isovalue : { 0., 0.1, -0.3 })
    {
      const ContourMesh mesh = contour(*field, isovalue);
      expectSurface(mesh, *field, "seed " + std::to_string(options.seed) + " at " + std::to_string(isovalue));
      triangles += static_cast<int>(mesh.triangles.size());
    }
  }
  EXPECT_GT(triangles, 50000);
}

TEST(Contour, OfCornersIsASurfaceWhereTheyHaveTheIsovalue)
{
  for (const RandomTree& options : propertyTrees())
  {
    std::mt19937 random(options.seed);
    const CornerFunction function(
      makeRandomTree(options), [&](const Point&) { return static_cast<double>(random() % 3) - 1.; });
    const auto field = function.field(unitRoots(options.roots));
    for (const double isovalue : { 0., 0.5, 1., -0.25 })
    {
      expectSurface(contour(*field, isovalue), *field,
        "seed " + std::to_string(options.seed) + " at " + std::to_string(isovalue));
    }
  }
}

TEST(Contour, OfCornersIsASurfaceAtGhosts)
{
  for (const RandomTree& options : propertyTrees())
  {
    const CornerFunction function(makeRandomTree(options), options.seed);
    const auto plain = function.field(unitRoots(options.roots));
    const auto octree = buildOctree(plain->octree().grid(), WithGhosts(*plain)).octree;
    const std::vector<CellId> leaves = leavesOf(*octree);
    const Field field = Field::ofCorners(octree, [&](std::uint64_t leaf) {
      std::array<float, 8> corners;
      const std::array<double, 8> values = function.corners(leaves[leaf]);
      std::copy(values.begin(), values.end(), corners.begin());
      return corners;
    });
    ASSERT_TRUE(field.corners());
    expectSurface(contour(field, 0.05), field, "seed " + std::to_string(options.seed));
  }
}

TEST(Contour, OfHangingCornersThatAreFreeIsASurface)
{
  // As writers leave them that evaluate elements of higher order at cells' corners alone.
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const auto octree = buildOctree(unitRoots(options.roots), cells).octree;
    const std::vector<CellId> leaves = leavesOf(*octree);
    const Field field = Field::ofCorners(octree, [&](std::uint64_t leaf) {
      std::array<float, 8> corners;
      for (int c = 0; c < 8; ++c)
      {
        Point p;
        for (int a = 0; a < 3; ++a)
        {
          p[a] = std::ldexp(static_cast<double>(leaves[leaf].index[a] + sideOf(c, a)), -leaves[leaf].level);
        }
        corners[c] =
          static_cast<float>(std::sin(40. * p[0] + 3.) * std::cos(31. * p[1]) + 0.7 * std::sin(50. * p[2]));
      }
      return corners;
    });
    ASSERT_TRUE(field.corners());
    for (const double isovalue : { 0., 0.3 })
    {
      expectSurface(contour(field, isovalue), field,
        "seed " + std::to_string(options.seed) + " at " + std::to_string(isovalue));
    }
  }
}

TEST(Contour, OfCornersPassesWhereTheFunctionDoes)
{
  int onEdges = 0;
  int centres = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const CornerFunction function(cells, options.seed);
    const auto field = function.field(unitRoots(options.roots));
    const auto octree = field->sharedOctree();
    constexpr double isovalue = 0.05;
    const ContourMesh mesh = contour(*field, isovalue, { .gradients = true });
    const std::vector<float> values = interpolate(*field, mesh);
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      const Point& p = mesh.points[i];
      CellId leaf;
      ASSERT_TRUE(findCell(*octree, p, leaf));
      int onPlanes = 0;
      for (int a = 0; a < 3; ++a)
      {
        const double place = std::ldexp(p[a], leaf.level);
        onPlanes += place == std::floor(place);
      }
      // At a vertex that has the isovalue a point keeps a little away.
      const double found = function.value(leaf, p);
      ASSERT_NEAR(values[i], found, 2e-6);
      if (onPlanes >= 2)
      {
        ++onEdges;
        ASSERT_NEAR(found, isovalue, 1e-6) << options.seed;
      }
      else
      {
        ++centres; // in a long loop: near the surface
        ASSERT_NEAR(found, isovalue, 0.2);
      }
      for (const double g : mesh.gradients[i])
      {
        ASSERT_TRUE(std::isfinite(g));
      }
    }
  }
  EXPECT_GT(onEdges, 20000);
  EXPECT_GT(centres, 1000);
}

TEST(Contour, OfCornersOfASingleCellIsInIt)
{
  const std::vector<LeafCell> cells{ { {}, 0.f } };
  const CornerFunction function(cells, [](const Point& p) { return p[0]; });
  const auto field = function.field(unitRoots({ 1, 1, 1 }));
  const ContourMesh mesh = contour(*field, 0.25, { .gradients = true });
  ASSERT_EQ(mesh.points.size(), 4u);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  for (std::size_t i = 0; i < 4; ++i)
  {
    EXPECT_EQ(mesh.points[i][0], 0.25);
    EXPECT_NEAR(mesh.gradients[i][0], 1., 1e-6);
    EXPECT_NEAR(mesh.gradients[i][1], 0., 1e-6);
  }
  EXPECT_EQ(interpolate(*field, mesh), std::vector<float>(4, 0.25f));
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

namespace
{

double areaOf(const ContourMesh& mesh)
{
  double area = 0.;
  for (const auto& t : mesh.triangles)
  {
    const Point n =
      cross(minus(mesh.points[t[1]], mesh.points[t[0]]), minus(mesh.points[t[2]], mesh.points[t[0]]));
    area += 0.5 * std::sqrt(dot(n, n));
  }
  return area;
}

/// Positive when the triangles look outside.
double volumeOf(const ContourMesh& mesh)
{
  double volume = 0.;
  for (const auto& t : mesh.triangles)
  {
    volume += dot(mesh.points[t[0]], cross(mesh.points[t[1]], mesh.points[t[2]])) / 6.;
  }
  return volume;
}

/// Cells of two sizes, `jump` levels apart, in a chequered pattern, with the values of -|p - c|.
Field makeBall(int level, int jump, const Point& centreOfBall)
{
  std::vector<LeafCell> cells;
  const Coord n = Coord(1) << level;
  for (Coord i = 0; i < n * n * n; ++i)
  {
    const std::array<Coord, 3> c{ i % n, i / n % n, i / (n * n) };
    const int finer = (c[0] + c[1] + c[2]) % 3 == 0 ? jump : 0;
    const Coord m = Coord(1) << finer;
    for (Coord j = 0; j < m * m * m; ++j)
    {
      cells.push_back(
        { { { m * c[0] + j % m, m * c[1] + j / m % m, m * c[2] + j / (m * m) }, level + finer }, 0.f });
    }
  }
  setValues(cells, [&](const Point& p) {
    const Point d = minus(p, centreOfBall);
    return -std::sqrt(dot(d, d));
  });
  return makeField({}, cells);
}

bool sameBits(const ContourMesh& p, const ContourMesh& q)
{
  return p.points == q.points && p.triangles == q.triangles && p.gradients == q.gradients;
}

} // namespace

TEST(Contour, OfADistanceIsASphere)
{
  constexpr double radius = 0.3;
  const Point middle{ 0.51, 0.48, 0.503 };
  for (const int jump : { 0, 1, 2 })
  {
    std::array<double, 2> areaError{};
    std::array<double, 2> volumeError{};
    for (int i = 0; i < 2; ++i)
    {
      const ContourMesh mesh = contour(makeBall(4 + i, jump, middle), -radius);
      const auto edges = edgesOf(mesh);
      for (const auto& [edge, count] : edges)
      {
        ASSERT_TRUE(count[0] == 1 && count[1] == 1);
      }
      EXPECT_EQ(static_cast<std::int64_t>(mesh.points.size() + mesh.triangles.size()),
        static_cast<std::int64_t>(edges.size()) + 2);
      areaError[i] = std::abs(areaOf(mesh) / (4. * M_PI * radius * radius) - 1.);
      volumeError[i] = std::abs(volumeOf(mesh) / (4. / 3. * M_PI * radius * radius * radius) - 1.);
    }
    EXPECT_LT(areaError[0], 0.02);
    EXPECT_NEAR(areaError[0] / areaError[1], 4., 0.8) << jump;
    EXPECT_NEAR(volumeError[0] / volumeError[1], 4., 0.8) << jump;
  }
}

TEST(Contour, JoinsOctantsBetweenLeavesOfOneSize)
{
  // Then all points lie on lines between centres of cells.
  const ContourMesh mesh = contour(makeBall(4, 0, { 0.51, 0.48, 0.503 }), -0.3);
  EXPECT_GT(mesh.points.size(), 300u);
  for (const Point& p : mesh.points)
  {
    int onCentres = 0;
    for (const double x : p)
    {
      const double place = 16. * x - 0.5;
      onCentres += place == std::floor(place);
    }
    EXPECT_GE(onCentres, 2);
  }
}

TEST(Contour, TakesUnevenRoots)
{
  const RootGrid grid(std::array<std::vector<double>, 3>{
    { { -1., 0., 3., 3.5, 4.5, 5.5 }, { 10., 10.25, 12.25, 14.25 }, { 0., 1., 2., 4., 8. } } });
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 10 * 6 * 8; ++i)
  {
    const std::array<Coord, 3> c{ i % 10, i / 10 % 6, i / 60 };
    Point p;
    for (int a = 0; a < 3; ++a)
    {
      p[a] = 0.5 * (grid.worldPlane(a, c[a], 1) + grid.worldPlane(a, c[a] + 1, 1));
    }
    cells.push_back({ { c, 1 }, static_cast<float>(p[0] * p[0] + p[1] + 0.5 * p[2]) });
  }
  auto built = buildOctree(grid, cells);
  const auto field = std::make_shared<const Field>(built.octree, built.values);
  const ContourMesh mesh = contour(*field, 16., { .gradients = true });
  EXPECT_GT(mesh.points.size(), 100u);
  expectSurface(mesh, *field, "uneven");
  const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
  const std::vector<float> values = interpolate(*field, mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    FieldSample sample;
    ASSERT_TRUE(sampler->sample(mesh.points[i], sample));
    EXPECT_NEAR(sample.value, 16., 2e-5); // of values up to 50
    EXPECT_NEAR(values[i], 16., 2e-5);
  }
}

TEST(Contour, OfATrilinearFunctionIsExact)
{
  int checked = 0;
  for (const std::uint32_t seed : { 1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u })
  {
    const RandomTree options{ seed, { 4, 4, 4 }, 3, 0.4, 0., false };
    auto cells = makeRandomTree(options);
    setValues(cells, [](const Point& p) { return p[0] * p[1] * p[2]; });
    const ContourMesh mesh = contour(makeField(options, cells), 8., { .gradients = true });
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      const Point& p = mesh.points[i];
      // Away from the domain's edge, where neighbours are missing.
      if (*std::min_element(p.begin(), p.end()) > 0.51 && *std::max_element(p.begin(), p.end()) < 3.49)
      {
        EXPECT_NEAR(p[0] * p[1] * p[2], 8., 2e-5);            // of values up to 64
        EXPECT_NEAR(mesh.gradients[i][0], p[1] * p[2], 5e-4); // rounded values over a width of 1/16
        EXPECT_NEAR(mesh.gradients[i][1], p[0] * p[2], 5e-4);
        EXPECT_NEAR(mesh.gradients[i][2], p[0] * p[1], 5e-4);
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 3000);
}

TEST(Contour, GradientsAreThoseBetweenVertices)
{
  int checked = 0;
  double worst = 0.; // part of the steepest around
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const BruteForceGTI brute(options.roots, cells);
    const RootGrid grid = RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. });
    const Field field = makeField(options, cells);
    const ContourMesh mesh = contour(field, 0.125, { .gradients = true });
    ASSERT_EQ(mesh.gradients.size(), mesh.points.size());
    for (std::size_t i = options.seed; i < mesh.points.size(); i += mesh.points.size() / 10)
    {
      const CellId* leaf = brute.leafAt(mesh.points[i]);
      if (!leaf)
      {
        continue; // on a face towards a missing cell
      }
      BruteForceGTI::Vertex first; // of the octant
      std::array<double, 3> part;
      const int up = field.octree().leafLevels() - leaf->level;
      for (int a = 0; a < 3; ++a)
      {
        const double octants = std::ldexp(mesh.points[i][a], leaf->level + 1);
        const Coord low = std::clamp(static_cast<Coord>(octants), 2 * leaf->index[a], 2 * leaf->index[a] + 1);
        first[a] = low << up;
        part[a] = octants - static_cast<double>(low);
      }
      Point expected{};
      double steepest = 0.;
      for (int corner = 0; corner < 8; ++corner)
      {
        BruteForceGTI::Vertex v = first;
        double weight = 1.;
        for (int a = 0; a < 3; ++a)
        {
          v[a] += Coord(corner >> a & 1) << up;
          weight *= corner >> a & 1 ? part[a] : 1. - part[a];
        }
        const Point gradient = brute.gradient(v, grid);
        for (int a = 0; a < 3; ++a)
        {
          expected[a] += weight * gradient[a];
          steepest = std::max(steepest, std::abs(gradient[a]));
        }
      }
      for (int a = 0; a < 3; ++a)
      {
        worst = std::max(worst, std::abs(mesh.gradients[i][a] - expected[a]) / steepest);
      }
      ++checked;
    }
  }
  EXPECT_LT(worst, 1e-5);
  EXPECT_GT(checked, 250);
}

TEST(Contour, GradientsConvergeWhereLevelsAreFourApart)
{
  const BaseTree tree = makeBaseTrees().back();
  for (const AnalyticSurface& surface : makeAnalyticSurfaces())
  {
    constexpr int steps = 3;
    constexpr int coarsest = 3;
    std::array<double, steps> largest{};
    std::array<double, steps> mean{};
    for (int step = 0; step < steps; ++step)
    {
      const auto field = makeFieldNear(tree, coarsest + step, surface);
      const ContourMesh mesh = contour(*field, surface.isovalue, { .gradients = true });
      double ofAngles = 0.;
      for (std::size_t i = 0; i < mesh.points.size(); ++i)
      {
        const Point exact = gradientOf(surface.field, mesh.points[i]);
        const Point off = minus(mesh.gradients[i], exact);
        const double error = std::sqrt(dot(off, off)); // of a unit vector
        largest[step] = std::max(largest[step], error);
        mean[step] += error / static_cast<double>(mesh.points.size());
        ofAngles = std::max(ofAngles, degreesBetween(mesh.gradients[i], exact));
      }
      std::printf("%s, refined %d times: largest %.4f, mean %.5f, largest angle %.3f degrees\n", surface.name,
        coarsest + step, largest[step], mean[step], ofAngles);
    }
    const double ofLargest = std::log2(largest[0] / largest[steps - 1]) / (steps - 1);
    const double ofMean = std::log2(mean[0] / mean[steps - 1]) / (steps - 1);
    std::printf("orders %.2f, %.2f\n", ofLargest, ofMean);
    EXPECT_GE(ofLargest, 1.) << surface.name;
    EXPECT_GE(ofMean, 1.6) << surface.name;
  }
}

TEST(Contour, RefinementFarFromTheSurfaceDoesNotMatter)
{
  const BaseTree tree = makeBaseTrees().back();
  const AnalyticSurface surface = makeAnalyticSurfaces().front();
  constexpr int refinement = 2;
  const ContourMesh near =
    contour(*makeFieldNear(tree, refinement, surface), surface.isovalue, { .gradients = true });
  const ContourMesh all =
    contour(*makeField(tree, refinement, surface.field), surface.isovalue, { .gradients = true });
  ASSERT_EQ(near.points.size(), all.points.size());
  double worst = 0.;
  for (std::size_t i = 0; i < all.points.size(); ++i)
  {
    const Point off = minus(near.gradients[i], all.gradients[i]);
    worst = std::max(worst, std::sqrt(dot(off, off)));
  }
  EXPECT_LT(worst, 1e-5);
}

TEST(Contour, DoesNotDependOnTheNumberOfThreads)
{
  for (const Field& field : { makeBall(5, 1, { 0.4, 0.5, 0.6 }),
         makeField(propertyTrees()[23], makeRandomTree(propertyTrees()[23])) })
  {
    std::vector<ContourMesh> meshes;
    for (const int threads : { 1, 2, 4 })
    {
      const oneapi::tbb::global_control control(
        oneapi::tbb::global_control::max_allowed_parallelism, threads);
      meshes.push_back(contour(field, -0.25, { .gradients = true }));
    }
    EXPECT_GT(meshes[0].triangles.size(), 1000u);
    EXPECT_TRUE(sameBits(meshes[0], meshes[1]));
    EXPECT_TRUE(sameBits(meshes[0], meshes[2]));
  }
}

TEST(Contour, TakesDeepTreesFarFromTheOrigin)
{
  // Refined down to level 19 around one point; the surface, a plane, goes through all sizes.
  std::vector<LeafCell> cells;
  std::array<Coord, 3> at{};
  for (int level = 1; level <= 19; ++level)
  {
    for (int o = 0; o < 8; ++o)
    {
      const std::array<Coord, 3> child{ 2 * at[0] + (o & 1), 2 * at[1] + (o >> 1 & 1), 2 * at[2] + (o >> 2) };
      if (o != (level & 7) || level == 19)
      {
        cells.push_back({ { child, level }, 0.f });
      }
    }
    const int inner = level & 7;
    at = { 2 * at[0] + (inner & 1), 2 * at[1] + (inner >> 1 & 1), 2 * at[2] + (inner >> 2) };
  }
  const Point target = centre({ at, 19 });
  setValues(cells, [&](const Point& p) {
    const Point d = minus(p, target);
    return d[0] + 2. * d[1] - 0.5 * d[2];
  });
  const std::array<double, 3> origin{ 1e6, -1e6, 3e5 };
  auto built = buildOctree(RootGrid::uniform({ 1, 1, 1 }, origin, { 1., 1., 1. }), cells);
  Field field(built.octree, built.values);
  const ContourMesh mesh = contour(field, 0.);
  EXPECT_GT(mesh.triangles.size(), 19u * 20u);
  for (const auto& [edge, count] : edgesOf(mesh))
  {
    if (count[0] + count[1] == 1)
    {
      bool onBoundary = false;
      for (int a = 0; a < 3; ++a)
      {
        const double p = mesh.points[edge[0]][a];
        const double q = mesh.points[edge[1]][a];
        onBoundary = onBoundary || (p == q && (p == origin[a] || p == origin[a] + 1.));
      }
      EXPECT_TRUE(onBoundary);
      continue;
    }
    EXPECT_TRUE(count[0] == 1 && count[1] == 1);
  }
}

TEST(Contour, IsEmptyWithoutCrossings)
{
  auto one =
    buildOctree(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), { { { {}, 0 }, 1.f } });
  Field field(one.octree, one.values);
  EXPECT_TRUE(contour(field, 1.).triangles.empty());
  const Field ball = makeBall(2, 1, { 0.5, 0.5, 0.5 });
  EXPECT_TRUE(contour(ball, 1.).points.empty());
  EXPECT_TRUE(interpolate(ball, contour(ball, 1.)).empty());
  auto none =
    buildOctree(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), std::vector<LeafCell>{});
  Field empty(none.octree, none.values);
  EXPECT_TRUE(contour(empty, 0.).points.empty());
}

TEST(Contour, ReportsProgressAndStops)
{
  const Field field = makeBall(4, 1, { 0.5, 0.5, 0.5 });
  double last = 0.;
  const ContourMesh all = contour(field, -0.3, { .progress = [&](double done) {
    EXPECT_GE(done, last);
    last = done;
    return true;
  } });
  EXPECT_EQ(last, 1.);
  EXPECT_FALSE(all.triangles.empty());
  int calls = 0;
  const ContourMesh stopped = contour(field, -0.3, { .progress = [&](double) { return ++calls < 2; } });
  EXPECT_EQ(calls, 2);
  EXPECT_TRUE(stopped.points.empty());
}

TEST(Contour, RejectsWhatItCannotUse)
{
  const Field field = makeBall(2, 1, { 0.5, 0.5, 0.5 });
  for (const double bad :
    { std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity() })
  {
    EXPECT_THROW(contour(field, bad), Error);
  }
}

// The normals that isosurfaces are shaded by: against the brute-force vertex gradients, across level boundaries, and
// their order of convergence.
#include "Support/BruteForceGTI.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"
#include "Surface/Isosurface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// A signed distance from a surface, in a domain of 4 x 4 x 4 roots.
struct Shape
{
  const char* name;
  double (*value)(const Vec3& p);
  Vec3 (*gradient)(const Vec3& p);
};

constexpr Vec3 middle{ 2.04, 1.96, 2.02 };
constexpr double radius = 1.36;
constexpr std::array<int, 3> roots{ 4, 4, 4 };

double sphere(const Vec3& p)
{
  const Vec3 d = p - middle;
  return std::sqrt(dot(d, d)) - radius;
}

Vec3 sphereGradient(const Vec3& p)
{
  return normalized(p - middle);
}

/// Of a torus around an oblique axis: the place along the axis, and of the nearest point of the circle.
Vec3 fromCircle(const Vec3& p)
{
  const Vec3 axis = normalized({ 1., 2., 3. });
  const Vec3 d = p - middle;
  const double along = dot(d, axis);
  Vec3 across;
  for (int a = 0; a < 3; ++a)
  {
    across[a] = d[a] - along * axis[a];
  }
  const Vec3 out = normalized(across);
  Vec3 from;
  for (int a = 0; a < 3; ++a)
  {
    from[a] = d[a] - 0.88 * out[a];
  }
  return from;
}

double torus(const Vec3& p)
{
  const Vec3 d = fromCircle(p);
  return std::sqrt(dot(d, d)) - 0.48;
}

Vec3 torusGradient(const Vec3& p)
{
  return normalized(fromCircle(p));
}

constexpr std::array<Shape, 2> shapes{ Shape{ "sphere", sphere, sphereGradient },
  Shape{ "torus", torus, torusGradient } };

/// Between the directions of two vectors.
double degrees(const Vec3& a, const Vec3& b)
{
  const Vec3 sine = cross(a, b);
  return std::atan2(std::sqrt(dot(sine, sine)), dot(a, b)) * 180. / std::numbers::pi;
}

Vec3 normalOf(const SurfaceHit& hit)
{
  return { hit.normal[0], hit.normal[1], hit.normal[2] };
}

Vec3 at(const Ray& ray, double t)
{
  return { ray.origin[0] + t * ray.direction[0], ray.origin[1] + t * ray.direction[1],
    ray.origin[2] + t * ray.direction[2] };
}

/// Every leaf refined so many times: levels meet where they did.
std::vector<LeafCell> refined(const std::vector<LeafCell>& cells, int times)
{
  const Coord count = Coord(1) << times;
  std::vector<LeafCell> all;
  for (const LeafCell& leaf : cells)
  {
    for (Coord i = 0; i < count * count * count; ++i)
    {
      const std::array<Coord, 3> place{ i % count, i / count % count, i / (count * count) };
      LeafCell cell{ { {}, leaf.cell.level + times }, 0.f };
      for (int a = 0; a < 3; ++a)
      {
        cell.cell.index[a] = (leaf.cell.index[a] << times) + place[a];
      }
      all.push_back(cell);
    }
  }
  return all;
}

} // namespace

TEST(SurfaceNormals, AreThoseBetweenVertexGradients)
{
  double worst = 0.;
  int checked = 0;
  for (const RandomTree& options : propertyTrees())
  {
    const auto cells = makeRandomTree(options);
    const RootGrid grid = unitRoots(options.roots);
    const BruteForceGTI brute(options.roots, cells);
    const auto field = makeField(grid, cells);
    const Isosurface surface(field, { 0.1 });
    std::mt19937 random(options.seed);
    std::uniform_real_distribution<double> unit(0., 1.);
    for (int i = 0; i < 5; ++i)
    {
      const Vec3 target{ options.roots[0] * unit(random), options.roots[1] * unit(random),
        options.roots[2] * unit(random) };
      const Vec3 from{ 9. * unit(random), -7., 5. };
      const Ray ray{ from, normalized(target - from) };
      std::vector<SurfaceHit> hits;
      surface.intersectAll(ray, 0., 100., hits);
      for (const SurfaceHit& hit : hits)
      {
        const CellId leaf = surface.cell(hit);
        const int up = field->octree().leafLevels() - leaf.level;
        Vec3 expected{};
        for (int corner = 0; corner < 8; ++corner)
        {
          BruteForceGTI::Vertex v;
          double weight = 1.;
          for (int a = 0; a < 3; ++a)
          {
            const Coord low = 2 * leaf.index[a] + (hit.octant >> 2 * a & 1);
            const double part =
              std::clamp(std::ldexp(at(ray, hit.t)[a], leaf.level + 1) - static_cast<double>(low), 0., 1.);
            v[a] = (low + sideOf(corner, a)) << up;
            weight *= sideOf(corner, a) != 0 ? part : 1. - part;
          }
          const std::array<double, 3> gradient = brute.gradient(v, grid);
          for (int a = 0; a < 3; ++a)
          {
            expected[a] += weight * gradient[a];
          }
        }
        worst = std::max(worst, degrees(normalOf(hit), expected));
        ++checked;
      }
    }
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_GT(checked, 250);
}

TEST(SurfaceNormals, DoNotJumpWhereLevelsMeet)
{
  std::array<int, 5> ofJump{}; // crossings by the difference of levels
  double worst = 0.;           // beyond twice the step's own change, in degrees
  for (const std::uint32_t seed : { 7u, 8u, 9u })
  {
    auto cells = makeRandomTree({ seed, roots, 5, 0.25, 0., false });
    if (seed < 9) // else random values
    {
      setValues(cells, shapes[seed - 7].value);
    }
    const auto field = makeField(unitRoots(roots), cells);
    const Isosurface surface(field, { 0. });
    struct Face
    {
      CellId cell;
      int axis;
      int side;
    };
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1., 1.);
    // Hits of four parallel rays close together, two on each side of a face, in it along a random line.
    std::array<SurfaceHit, 4> hits;
    const auto cross = [&](const Face& face) {
      const double width = std::ldexp(1., -face.cell.level);
      Ray ray{};
      for (int a = 0; a < 3; ++a)
      {
        const double off = a == face.axis ? (face.side - 0.5) * width : 0.45 * width * unit(random);
        ray.origin[a] = centre(face.cell)[a] + off;
        ray.direction[a] = a == face.axis ? 0. : unit(random);
      }
      ray.direction = normalized(ray.direction);
      bool all = true;
      for (int k = 0; k < 4 && all; ++k)
      {
        Ray beside = ray;
        beside.origin[face.axis] += (2 * k - 3) * 1e-6 * width;
        all = surface.intersect(beside, -0.3 * width, 0.3 * width, hits[k]) &&
          std::abs(hits[k].t - hits[0].t) < 1e-3 * width;
      }
      return all;
    };
    std::array<std::vector<Face>, 5>
      faces; // that the surface crosses, by how much coarser the leaf beyond is
    TreePath root(field->octree());
    forEachNode(root, [&](const TreePath& path) {
      const CellId cell{ path.index(), path.depth() - field->octree().grid().paddingDepth() };
      for (int f = 0; f < 6 && path.node().isLeaf(); ++f)
      {
        constexpr std::array<int, 3> stride{ 1, 3, 9 };
        const NodeRef beside = path.around(path.depth())[13 + (f & 1 ? stride[f >> 1] : -stride[f >> 1])];
        const int jump = path.depth() - beside.depth();
        const Face face{ cell, f >> 1, f & 1 };
        for (int i = 0; i < 8 && beside.isLeaf() && jump > 0 && jump <= 4; ++i)
        {
          if (cross(face))
          {
            faces[jump].push_back(face);
            break;
          }
        }
      }
    });
    for (int i = 0; i < 140000; ++i)
    {
      const int jump = 1 + i % 4;
      if (!faces[jump].empty() && cross(faces[jump][random() % faces[jump].size()]))
      {
        const auto change = [&](int k) { return degrees(normalOf(hits[k]), normalOf(hits[k + 1])); };
        worst = std::max(worst, change(1) - 2. * std::max(change(0), change(2)));
        ++ofJump[jump];
      }
    }
  }
  std::printf("crossings by jump: %d %d %d %d, largest jump %.2g degrees\n", ofJump[1], ofJump[2], ofJump[3],
    ofJump[4], worst);
  EXPECT_LE(worst, 0.05);
  EXPECT_GT(ofJump[1] + ofJump[2] + ofJump[3] + ofJump[4], 100000);
  EXPECT_GT(*std::min_element(ofJump.begin() + 1, ofJump.end()), 8000);
}

TEST(SurfaceNormals, ConvergeToThoseOfTheSurface)
{
  for (const Shape& shape : shapes)
  {
    const auto base = makeRandomTree({ 11, roots, 3, 0.12, 0., false });
    constexpr int steps = 3;
    std::array<double, steps> mean{};
    std::array<double, steps> largest{};
    for (int step = 0; step < steps; ++step)
    {
      auto cells = refined(base, step + 2);
      setValues(cells, shape.value);
      const Isosurface surface(makeField(unitRoots(roots), cells), { 0. });
      std::mt19937 random(4);
      std::normal_distribution<double> normal;
      int count = 0;
      while (count < 8000)
      {
        const Vec3 away = normalized({ normal(random), normal(random), normal(random) });
        const Ray ray{ { middle[0] + 4. * away[0], middle[1] + 4. * away[1], middle[2] + 4. * away[2] },
          normalized({ 0.7 * normal(random) - 4. * away[0], 0.7 * normal(random) - 4. * away[1],
            0.7 * normal(random) - 4. * away[2] }) };
        SurfaceHit hit;
        if (surface.intersect(ray, 0., 20., hit))
        {
          const double angle = degrees(normalOf(hit), shape.gradient(at(ray, hit.t)));
          mean[step] += angle;
          largest[step] = std::max(largest[step], angle);
          ++count;
        }
      }
      mean[step] /= count;
      std::printf("%s, refined %d times: mean %.3f, largest %.2f degrees\n", shape.name, step + 2, mean[step],
        largest[step]);
    }
    const double ofMean = 0.5 * std::log2(mean[0] / mean[steps - 1]);
    const double ofLargest = 0.5 * std::log2(largest[0] / largest[steps - 1]);
    std::printf("orders %.2f, %.2f\n", ofMean, ofLargest);
    EXPECT_GT(ofMean, 1.8);
    EXPECT_GT(ofLargest, 1.);
  }
}

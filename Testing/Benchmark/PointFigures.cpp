#include "PointFigures.h"

#include "Error.h"
#include "Geometry/Trilinear.h"
#include "Interpolation/PointSampler.h"
#include "Interpolation/VertexValues.h"
#include "Meter.h"
#include "Surface/Isosurface.h"

#include <limits>
#include <random>

namespace treeamr::bench
{

namespace
{

/// The way down from the root, and the vertex values of the leaf alone.
double valueByItself(const Field& field, const Vec3& point)
{
  LeafFinder::Leaf leaf;
  if (!LeafFinder(field.octree()).find(point, leaf))
  {
    return 0.;
  }
  TreePath path(field.octree());
  for (int up = leaf.depth - 1; up >= 0; --up)
  {
    path.descend(octantAbove(leaf.index, up));
  }
  const VertexValues values = vertexValues<VertexRule::GTI>(path, field);
  int first = 0;
  Vec3 place;
  for (int a = 0; a < 3; ++a)
  {
    const bool upper = leaf.place[a] >= 0.5;
    first += upper * leafVertexStride[a];
    place[a] = 2. * leaf.place[a] - upper;
  }
  return trilinear(cornersOf(values.data() + first, leafVertexStride), place);
}

struct Times
{
  double kept;  // nanoseconds a point
  double alone; // without anything kept
};

Times measurePoints(const Field& field, const std::vector<Vec3>& points)
{
  std::vector<double> kept(points.size());
  std::vector<double> alone(points.size());
  const auto fillKept = [&] {
    PointSampler sampler(field);
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      sampler.value(points[i], kept[i]);
    }
  };
  const auto fillAlone = [&] {
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      alone[i] = valueByItself(field, points[i]);
    }
  };
  const auto nanoseconds = [&](const Cost& cost) {
    return 1e9 * cost.cpu / static_cast<double>(points.size());
  };
  const Times times{ nanoseconds(best(fillKept)), nanoseconds(best(fillAlone)) };
  if (kept != alone)
  {
    throw Error("points: values that are kept and others differ");
  }
  return times;
}

std::vector<Vec3> rowsOfASlice(const Bounds& domain)
{
  constexpr int size = 512;
  std::vector<Vec3> points;
  for (int j = 0; j < size; ++j)
  {
    for (int i = 0; i < size; ++i)
    {
      const Vec3 part{ (i + 0.5) / size, (j + 0.5) / size, 0.5001 };
      Vec3& point = points.emplace_back();
      for (int a = 0; a < 3; ++a)
      {
        point[a] = domain.min[a] + part[a] * (domain.max[a] - domain.min[a]);
      }
    }
  }
  return points;
}

std::vector<Vec3> hitsOf(const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera)
{
  HitImage image;
  Isosurface(field, { isovalue }).render(camera, SurfaceLayers::Nearest, image);
  std::vector<Vec3> points;
  constexpr int tile = 16; // pixels along an edge
  for (int y0 = 0; y0 < camera.height(); y0 += tile)
  {
    for (int x0 = 0; x0 < camera.width(); x0 += tile)
    {
      for (int k = 0; k < tile * tile; ++k)
      {
        const int x = x0 + k % tile;
        const int y = y0 + k / tile;
        if (x >= camera.width() || y >= camera.height())
        {
          continue;
        }
        const std::size_t pixel = static_cast<std::size_t>(y) * camera.width() + x;
        for (std::size_t i = image.first[pixel]; i < image.first[pixel + 1]; ++i)
        {
          points.push_back(pointAt(camera.ray(x, y), image.hits[i].t));
        }
      }
    }
  }
  return points;
}

std::vector<Vec3> atRandom(const Bounds& domain)
{
  std::mt19937_64 random(1);
  std::vector<Vec3> points(100000);
  for (Vec3& point : points)
  {
    for (int a = 0; a < 3; ++a)
    {
      point[a] = std::uniform_real_distribution<double>(domain.min[a], domain.max[a])(random);
    }
  }
  return points;
}

} // namespace

std::vector<Figure> pointFigures(
  const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera)
{
  const Bounds domain = field->octree().grid().bounds();
  const Times slice = measurePoints(*field, rowsOfASlice(domain));
  const Times hits = measurePoints(*field, hitsOf(field, isovalue, camera));
  const Times random = measurePoints(*field, atRandom(domain));
  return {
    { "ns_slice", slice.kept, "slice ns", 0 },
    { "ratio_slice", slice.alone / slice.kept, "alone/kept", 1 },
    { "ns_hits", hits.kept, "hits ns", 0 },
    { "ratio_hits", hits.alone / hits.kept, "alone/kept", 1 },
    { "ns_random", random.kept, "random ns", 0 },
    { "ratio_random", random.alone / random.kept, "alone/kept", 1 },
  };
}

} // namespace treeamr::bench

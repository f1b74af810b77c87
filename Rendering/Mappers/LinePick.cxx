#include "LinePick.h"

#include "HyperTreeGridConverter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

Vec3 scaled(const Vec3& v, double factor)
{
  return { factor * v[0], factor * v[1], factor * v[2] };
}

/// Along a ray, in its parameter: the length that takes it through a box from face to face.
double lengthThrough(const Bounds& box, const Ray& ray)
{
  double length = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a)
  {
    length = std::min(length, (box.max[a] - box.min[a]) / std::abs(ray.direction[a]));
  }
  return length;
}

/// Of the face of the bounds or of the cropping regions that the ray is in, against its way: the axis whose planes are
/// nearest to t.
Vec3 faceNormal(const Ray& ray, double t, const Bounds& bounds, const DataCut& cut)
{
  Vec3 normal{};
  double least = std::numeric_limits<double>::infinity();
  const auto meet = [&](int a, double plane) {
    const double apart = std::abs((plane - ray.origin[a]) / ray.direction[a] - t);
    if (apart < least)
    {
      least = apart;
      normal = {};
      normal[a] = -std::copysign(1., ray.direction[a]);
    }
  };
  for (int a = 0; a < 3; ++a)
  {
    meet(a, bounds.min[a]);
    meet(a, bounds.max[a]);
    if (cut.cropping)
    {
      meet(a, cut.cropping->planes[2 * a]);
      meet(a, cut.cropping->planes[2 * a + 1]);
    }
  }
  return normal;
}

class VolumeWalk
{
public:
  VolumeWalk(const Sampler& sampler, const Octree& octree, const Ray& ray,
    const std::function<double(double)>& opacity)
    : sampler_(sampler)
    , octree_(octree)
    , ray_(ray)
    , opacity_(opacity)
  {
    const RootGrid& grid = octree.grid();
    Bounds finest = grid.bounds();
    for (int a = 0; a < 3; ++a)
    {
      finest.max[a] =
        finest.min[a] + std::ldexp((finest.max[a] - finest.min[a]) / grid.roots()[a], -octree.leafLevels());
    }
    finest_ = lengthThrough(finest, ray);
  }

  double opacityAt(double t, FieldSample& sample) const
  {
    return sampler_.sample(pointAt(ray_, t), sample) ? opacity_(sample.value) : 0.;
  }
  double stepAt(double t) const
  {
    constexpr double stepsInACell = 8.;
    CellId cell;
    if (!findCell(octree_, pointAt(ray_, t), cell))
    {
      return finest_;
    }
    const RootGrid& grid = octree_.grid();
    return lengthThrough(grid.nodeBounds(cell.index, cell.level + grid.paddingDepth()), ray_) / stepsInACell;
  }
  /// The first place of [begin, end] that is opaque enough, after none for `begin`.
  std::optional<double> find(double begin, double end, double least) const
  {
    FieldSample sample;
    double before = begin;
    double t = begin;
    while (!(this->opacityAt(t, sample) >= least))
    {
      if (t >= end)
      {
        return std::nullopt;
      }
      before = t;
      // Also where a step is lost beside t.
      t = std::min(end, std::max(t + this->stepAt(t), std::nextafter(t, end)));
    }
    constexpr int halvings = 40;
    for (int i = 0; i < halvings && before < t; ++i)
    {
      const double middle = 0.5 * (before + t);
      (this->opacityAt(middle, sample) >= least ? t : before) = middle;
    }
    return t;
  }

private:
  const Sampler& sampler_;
  const Octree& octree_;
  Ray ray_;
  const std::function<double(double)>& opacity_;
  double finest_;
};

} // namespace

PickLine pickLine(const double p1[3], const double p2[3], double t1, double t2)
{
  return { { { p1[0], p1[1], p1[2] }, { p2[0] - p1[0], p2[1] - p1[1], p2[2] - p1[2] } }, t1, t2 };
}

vtkIdType tell(const LinePick& pick, vtkHyperTreeGrid* grid, double& t, double normal[3], double& value)
{
  t = pick.t;
  std::copy(pick.normal.begin(), pick.normal.end(), normal);
  value = pick.value;
  return globalIndex(*grid, pick.cell);
}

std::optional<LinePick> pickSurface(const Isosurface& surface, const PickLine& line)
{
  SurfaceHit hit;
  if (!surface.intersect(line.ray, line.begin, line.end, hit))
  {
    return std::nullopt;
  }
  return LinePick{ hit.t, scaled(hit.gradient, -1.), surface.isovalues()[hit.surface], surface.cell(hit) };
}

std::optional<LinePick> pickVolume(const Sampler& sampler, const Octree& octree, const PickLine& line,
  const DataCut& cut, const std::function<double(double)>& opacity, double least)
{
  const Bounds bounds = octree.grid().bounds();
  DataCut inside = cut;
  inside.addBox(bounds);
  const RayParts parts = inside.parts(line.ray.origin, line.ray.direction, line.begin, line.end);
  const VolumeWalk walk(sampler, octree, line.ray, opacity);
  for (int i = 0; i < parts.count; ++i)
  {
    if (const std::optional<double> t = walk.find(parts.begin[i], parts.end[i], least))
    {
      LinePick pick{ *t, {}, 0., {} };
      FieldSample sample;
      sampler.sample(pointAt(line.ray, *t), sample);
      findCell(octree, pointAt(line.ray, *t), pick.cell);
      pick.value = sample.value;
      pick.normal =
        *t == parts.begin[i] ? faceNormal(line.ray, *t, bounds, cut) : scaled(sample.gradient, -1.);
      return pick;
    }
  }
  return std::nullopt;
}

} // namespace treeamr

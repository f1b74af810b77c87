#include "Interpolation/Sampler.h"

#include "Geometry/Trilinear.h"
#include "Interpolation/CornerSampler.h"
#include "Interpolation/LeafFinder.h"
#include "Interpolation/PointSampler.h"
#include "Interpolation/VertexValues.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cmath>

namespace treeamr
{

namespace
{

/// Where in a leaf a point is: 0 to 1 per axis.
using Local = Vec3;

/// Goes to the leaf that holds a point, if there is one.
bool locate(TreePath& path, const Vec3& pWorld, Local& local) noexcept
{
  LeafFinder::Leaf leaf;
  if (!LeafFinder(path.octree()).find(pWorld, leaf))
  {
    return false;
  }
  for (int up = leaf.depth - 1; up >= 0; --up)
  {
    path.descend(octantAbove(leaf.index, up));
  }
  local = leaf.place;
  return true;
}

/// Scales a derivative per cell width to one per world coordinate.
void toWorld(const TreePath& path, std::array<double, 3>& gradient) noexcept
{
  const Bounds b = path.octree().grid().nodeBounds(path.index(), path.depth());
  for (int a = 0; a < 3; ++a)
  {
    gradient[a] /= b.max[a] - b.min[a];
  }
}

void sampleNearest(const TreePath& path, const Field& field, const Local&, FieldSample& out) noexcept
{
  out = { field.relative(path.node()), {} };
}

void sampleOctant(const TreePath& path, const Field& field, const Local& local, FieldSample& out) noexcept
{
  const VertexValues v = vertexValues<VertexRule::Octant>(path, field);
  int base = 0;
  std::array<double, 3> f;
  for (int a = 0; a < 3; ++a)
  {
    const bool upper = local[a] >= 0.5;
    base += upper ? leafVertexStride[a] : 0;
    f[a] = 2. * local[a] - upper;
  }
  const Corners corners = cornersOf(v.data() + base, leafVertexStride);
  out = { trilinear(corners, f), trilinearGradient(corners, f) };
  for (double& g : out.gradient)
  {
    g *= 2.;
  }
}

/// Trilinear on the dual grid of the cells `finer` levels below the leaf. False, and nothing done, when a
/// corner is refined further and `stopAtFiner` asks to be told.
bool sampleDual(const TreePath& path, const Field& field, const Local& local, int finer, bool stopAtFiner,
  FieldSample& out) noexcept
{
  const double scale = std::ldexp(1., finer);
  std::array<Coord, 3> base;
  std::array<double, 3> f;
  for (int a = 0; a < 3; ++a)
  {
    const double at = local[a] * scale - 0.5;
    base[a] = static_cast<Coord>(std::floor(at));
    f[a] = at - static_cast<double>(base[a]);
  }
  CornerSum sum(f);
  for (int c = 0; c < 8; ++c)
  {
    int entry = 0;
    std::array<Coord, 3> cell;
    for (int a = 2; a >= 0; --a)
    {
      cell[a] = base[a] + sideOf(c, a);
      entry = 3 * entry + static_cast<int>(cell[a] >> finer) + 1;
    }
    NodeRef node = path.around(path.depth())[entry];
    for (int bit = finer - 1; bit >= 0 && node.isInner(); --bit)
    {
      node = path.octree().child(node, octantAbove(cell, bit));
    }
    if (node.isInner() && stopAtFiner)
    {
      return false;
    }
    if (!node.isNone())
    {
      sum.add(c, field.relative(node));
    }
  }
  out = { sum.value(), sum.gradient() };
  for (double& g : out.gradient)
  {
    g *= scale;
  }
  return true;
}

void sampleCurrent(const TreePath& path, const Field& field, const Local& local, FieldSample& out) noexcept
{
  sampleDual(path, field, local, 0, false, out);
}

void sampleFinest(const TreePath& path, const Field& field, const Local& local, FieldSample& out) noexcept
{
  for (int finer = 0; !sampleDual(path, field, local, finer, true, out); ++finer)
  {
  }
}

using LeafRule = void (*)(const TreePath&, const Field&, const Local&, FieldSample&) noexcept;

template <LeafRule Rule>
class SamplerOf : public Sampler
{
public:
  explicit SamplerOf(std::shared_ptr<const Field> field)
    : Sampler(std::move(field))
  {
  }
  bool sampleRelative(const std::array<double, 3>& pWorld, FieldSample& sample) const override
  {
    TreePath path(this->field().octree());
    Local local;
    if (!locate(path, pWorld, local))
    {
      return false;
    }
    Rule(path, this->field(), local, sample);
    toWorld(path, sample.gradient);
    return true;
  }
};

/// Of what keeps the way to its last point: PointSampler or CornerSampler.
template <class OfThread>
class ContinuousSampler : public Sampler
{
public:
  explicit ContinuousSampler(std::shared_ptr<const Field> field)
    : Sampler(std::move(field))
    , ofThreads_([this] { return OfThread(this->field()); })
  {
  }
  bool sampleRelative(const std::array<double, 3>& pWorld, FieldSample& sample) const override
  {
    return ofThreads_.local().sample(pWorld, sample);
  }

private:
  mutable tbb::enumerable_thread_specific<OfThread> ofThreads_;
};

} // namespace

std::unique_ptr<Sampler> Sampler::create(InterpolationMethod method, std::shared_ptr<const Field> field)
{
  required(field, "sampler");
  switch (method)
  {
    case InterpolationMethod::Nearest:
      return std::make_unique<SamplerOf<sampleNearest>>(std::move(field));
    case InterpolationMethod::Current:
      return std::make_unique<SamplerOf<sampleCurrent>>(std::move(field));
    case InterpolationMethod::Finest:
      return std::make_unique<SamplerOf<sampleFinest>>(std::move(field));
    case InterpolationMethod::Octant:
      return std::make_unique<SamplerOf<sampleOctant>>(std::move(field));
    case InterpolationMethod::GTI:
      break;
  }
  if (field->corners())
  {
    return std::make_unique<ContinuousSampler<CornerSampler>>(std::move(field));
  }
  return std::make_unique<ContinuousSampler<PointSampler>>(std::move(field));
}

bool findCell(const Octree& octree, const std::array<double, 3>& pWorld, CellId& cell)
{
  LeafFinder::Leaf leaf;
  if (!LeafFinder(octree).find(pWorld, leaf))
  {
    return false;
  }
  cell = { leaf.index, leaf.depth - octree.grid().paddingDepth() };
  return true;
}

} // namespace treeamr

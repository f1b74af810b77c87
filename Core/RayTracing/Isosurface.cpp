// The paper's section 6.2 with octants as primitives: one descent pruned by the nodes' ranges finds the
// active ones, Embree builds the hierarchy over their boxes, and a hit is the first root of the cubic that
// the trilinear field is along a ray.
//
// Embree works in single precision. It sees the domain as a unit cube and rays that start where they enter
// it, and only selects candidates with it: boxes are widened by its rounding, and hits are found and compared
// in double precision, so the surface is exact at any depth of the tree and any distance from the origin.
#include "RayTracing/Isosurface.h"

#include "Error.h"
#include "Interpolation/VertexValues.h"
#include "Octree/TreePath.h"
#include "RayTracing/CubicRoot.h"
#include "RayTracing/RayBox.h"

#include <embree3/rtcore.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace treeamr
{

namespace
{

/// An octant with the field's values at its corners, x fastest.
struct ActiveOctant
{
  std::array<Coord, 3> index; // on the octant lattice of its leaf
  std::int32_t level;         // of that lattice: the leaf's plus one
  std::array<float, 8> values;
};

class Extraction
{
public:
  Extraction(const Field& field, float isovalue)
    : field_(field)
    , isovalue_(isovalue)
    , serialDepth_(field.octree().grid().paddingDepth() + field.octree().leafLevels() - 3)
  {
  }

  /// parent: the range of the node's parent, of the root the field's.
  void visit(TreePath& path, VertexMemo& memo, Range parent, std::vector<ActiveOctant>& found) const
  {
    const NodeRef node = path.node();
    if (node.isLeaf())
    {
      visitLeaf(path, memo, found);
      return;
    }
    const Range range = field_.nodeRange(node, parent);
    if (!(range.min <= isovalue_ && isovalue_ <= range.max))
    {
      return;
    }
    const auto visitChild = [this, range](
                              TreePath& at, VertexMemo& known, int octant, std::vector<ActiveOctant>& into) {
      if (!at.octree().child(at.node(), octant).isNone())
      {
        at.descend(octant);
        visit(at, known, range, into);
        at.ascend();
      }
    };
    if (path.depth() >= serialDepth_)
    {
      for (int o = 0; o < 8; ++o)
      {
        visitChild(path, memo, o, found);
      }
      return;
    }
    std::array<std::vector<ActiveOctant>, 8> parts;
    tbb::parallel_for(0, 8, [&](int o) {
      TreePath own(path);
      VertexMemo known;
      visitChild(own, known, o, parts[o]);
    });
    for (const auto& part : parts)
    {
      found.insert(found.end(), part.begin(), part.end());
    }
  }

private:
  void visitLeaf(const TreePath& path, VertexMemo& memo, std::vector<ActiveOctant>& found) const
  {
    if (field_.octree().isGhost(path.node().index()))
    {
      return;
    }
    const VertexValues vertices = vertexValues<VertexRule::GTI>(path, field_, memo);
    const Range range = hull(vertices);
    if (!(range.min <= isovalue_ && isovalue_ <= range.max))
    {
      return;
    }
    for (int o = 0; o < 8; ++o)
    {
      const int base = (o & 1) + 3 * (o >> 1 & 1) + 9 * (o >> 2);
      ActiveOctant octant;
      for (int c = 0; c < 8; ++c)
      {
        octant.values[c] = vertices[base + (c & 1) + 3 * (c >> 1 & 1) + 9 * (c >> 2)];
      }
      const auto [low, high] = std::minmax_element(octant.values.begin(), octant.values.end());
      if (*low <= isovalue_ && isovalue_ <= *high)
      {
        octant.level = path.depth() - field_.octree().grid().paddingDepth() + 1;
        for (int a = 0; a < 3; ++a)
        {
          octant.index[a] = 2 * path.index()[a] + (o >> a & 1);
        }
        found.push_back(octant);
      }
    }
  }

  const Field& field_;
  float isovalue_;
  int serialDepth_;
};

/// The field minus the isovalue along the part [t0, t1] of a ray, over s in [0, 1].
Cubic alongRay(const ActiveOctant& octant, float isovalue, const Vec3& from, const Vec3& to) noexcept
{
  // Interpolating along x, y and z in turn multiplies by one linear polynomial each.
  std::array<std::array<double, 2>, 4> x;
  for (int i = 0; i < 4; ++i)
  {
    const double low = static_cast<double>(octant.values[2 * i]) - isovalue;
    const double difference = static_cast<double>(octant.values[2 * i + 1]) - octant.values[2 * i];
    x[i] = { low + from[0] * difference, (to[0] - from[0]) * difference };
  }
  std::array<std::array<double, 3>, 2> y;
  const double dy = to[1] - from[1];
  for (int i = 0; i < 2; ++i)
  {
    const auto& low = x[2 * i];
    const std::array<double, 2> d{ x[2 * i + 1][0] - low[0], x[2 * i + 1][1] - low[1] };
    y[i] = { low[0] + from[1] * d[0], low[1] + from[1] * d[1] + dy * d[0], dy * d[1] };
  }
  const double dz = to[2] - from[2];
  const std::array<double, 3> d{ y[1][0] - y[0][0], y[1][1] - y[0][1], y[1][2] - y[0][2] };
  return { y[0][0] + from[2] * d[0], y[0][1] + from[2] * d[1] + dz * d[0],
    y[0][2] + from[2] * d[2] + dz * d[1], dz * d[2] };
}

/// d value / d position in the octant (0 to 1 per axis).
Vec3 gradientAt(const ActiveOctant& octant, const Vec3& p) noexcept
{
  Vec3 gradient{};
  for (int c = 0; c < 8; ++c)
  {
    Vec3 w;
    Vec3 d;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = c >> a & 1;
      w[a] = upper ? p[a] : 1. - p[a];
      d[a] = upper ? 1. : -1.;
    }
    gradient[0] += octant.values[c] * d[0] * w[1] * w[2];
    gradient[1] += octant.values[c] * w[0] * d[1] * w[2];
    gradient[2] += octant.values[c] * w[0] * w[1] * d[2];
  }
  return gradient;
}

/// Half the widening of a box in Embree's unit cube: a ray's origin, direction and the box are each rounded
/// to 2^-24 of coordinates up to 1, and the ray's parameter reaches 1.
constexpr float embreeRounding = 0x1p-22f;

} // namespace

struct Isosurface::Impl
{
  std::shared_ptr<const Field> field;
  float isovalue;
  Bounds domain;
  std::vector<ActiveOctant> octants;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Impl()
  {
    if (scene)
    {
      rtcReleaseScene(scene);
    }
    if (device)
    {
      rtcReleaseDevice(device);
    }
  }

  /// A ray's query, passed through Embree.
  struct Query
  {
    RTCIntersectContext context; // first: Embree hands back a pointer to it
    const Impl* surface;
    SlabRay ray;
    double tHit;
    double tEnter; // Embree's ray parameter 0
    double tLeave; // Embree's ray parameter 1
    std::uint32_t octant = RTC_INVALID_GEOMETRY_ID;
  };

  Bounds boxOf(const ActiveOctant& octant) const noexcept
  {
    Bounds b;
    for (int a = 0; a < 3; ++a)
    {
      b.min[a] = field->octree().grid().worldPlane(a, octant.index[a], octant.level);
      b.max[a] = field->octree().grid().worldPlane(a, octant.index[a] + 1, octant.level);
    }
    return b;
  }

  static void bounds(const RTCBoundsFunctionArguments* args) noexcept
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    const Bounds box = self.boxOf(self.octants[args->primID]);
    float* lower = &args->bounds_o->lower_x;
    float* upper = &args->bounds_o->upper_x;
    for (int a = 0; a < 3; ++a)
    {
      const double extent = self.domain.max[a] - self.domain.min[a];
      lower[a] = static_cast<float>((box.min[a] - self.domain.min[a]) / extent) - embreeRounding;
      upper[a] = static_cast<float>((box.max[a] - self.domain.min[a]) / extent) + embreeRounding;
    }
  }

  static void intersect(const RTCIntersectFunctionNArguments* args) noexcept
  {
    auto& query = *reinterpret_cast<Query*>(args->context);
    const Impl& self = *query.surface;
    if (args->valid[0] == 0)
    {
      return;
    }
    double t;
    if (!self.hitOctant(self.octants[args->primID], query, t))
    {
      return;
    }
    // Neighbours meet in shared faces: of equal hits the first octant's counts, whatever the order of visits.
    if (t < query.tHit || (t == query.tHit && args->primID < query.octant))
    {
      query.tHit = t;
      query.octant = args->primID;
      const auto parameter = static_cast<float>((t - query.tEnter) / (query.tLeave - query.tEnter));
      RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, 1), 1, 0) = parameter + embreeRounding;
    }
  }

  bool hitOctant(const ActiveOctant& octant, const Query& query, double& t) const noexcept
  {
    const Bounds box = boxOf(octant);
    double t0 = query.tEnter;
    double t1 = query.tLeave; // not up to tHit: equal hits of neighbours must both be found
    if (!query.ray.clip(box.min, box.max, t0, t1))
    {
      return false;
    }
    double root;
    if (!firstRoot(
          alongRay(octant, isovalue, localAt(box, query.ray, t0), localAt(box, query.ray, t1)), root))
    {
      return false;
    }
    t = t0 + root * (t1 - t0);
    return true;
  }

  static Vec3 localAt(const Bounds& box, const SlabRay& ray, double t) noexcept
  {
    Vec3 p;
    for (int a = 0; a < 3; ++a)
    {
      p[a] =
        std::clamp((ray.origin[a] + t * ray.direction[a] - box.min[a]) / (box.max[a] - box.min[a]), 0., 1.);
    }
    return p;
  }

  void build()
  {
    device = rtcNewDevice(nullptr);
    if (!device)
    {
      throw Error("isosurface: Embree made no device, error " + std::to_string(rtcGetDeviceError(nullptr)));
    }
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(octants.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    {
      throw Error("isosurface: Embree reports error " + std::to_string(error) + " for " +
        std::to_string(octants.size()) + " octants");
    }
  }
};

Isosurface::Isosurface(std::shared_ptr<const Field> field, float isovalue)
  : impl_(std::make_unique<Impl>())
{
  if (!std::isfinite(isovalue))
  {
    throw Error("isosurface: isovalue " + std::to_string(isovalue) + ", allowed are finite values");
  }
  if (!field->hasNodeRanges())
  {
    throw Error("isosurface: the field has no node ranges to find the surface by");
  }
  impl_->field = std::move(field);
  impl_->isovalue = isovalue;
  impl_->domain = impl_->field->octree().grid().bounds();
  TreePath path(impl_->field->octree());
  if (!path.node().isNone())
  {
    VertexMemo memo;
    Extraction(*impl_->field, isovalue).visit(path, memo, impl_->field->range(), impl_->octants);
  }
  impl_->octants.shrink_to_fit();
  if (impl_->octants.size() >= RTC_INVALID_GEOMETRY_ID)
  {
    throw Error("isosurface: " + std::to_string(impl_->octants.size()) + " active octants, allowed are " +
      std::to_string(RTC_INVALID_GEOMETRY_ID - 1));
  }
  if (!impl_->octants.empty())
  {
    impl_->build();
  }
}

Isosurface::~Isosurface() = default;

float Isosurface::isovalue() const noexcept
{
  return impl_->isovalue;
}

std::size_t Isosurface::primitiveCount() const noexcept
{
  return impl_->octants.size();
}

bool Isosurface::intersect(const Ray& ray, double tMin, double tMax, Hit& hit) const
{
  if (impl_->octants.empty())
  {
    return false;
  }
  const SlabRay slab(ray);
  double tEnter = tMin;
  double tLeave = tMax;
  if (!slab.clip(impl_->domain.min, impl_->domain.max, tEnter, tLeave))
  {
    return false;
  }
  Impl::Query query{ {}, impl_.get(), slab, tLeave, tEnter, tLeave };
  rtcInitIntersectContext(&query.context);
  RTCRayHit rayHit{};
  float* origin = &rayHit.ray.org_x;
  float* direction = &rayHit.ray.dir_x;
  for (int a = 0; a < 3; ++a)
  {
    const double extent = impl_->domain.max[a] - impl_->domain.min[a];
    origin[a] =
      static_cast<float>((ray.origin[a] + tEnter * ray.direction[a] - impl_->domain.min[a]) / extent);
    direction[a] = static_cast<float>(ray.direction[a] * (tLeave - tEnter) / extent);
  }
  rayHit.ray.tnear = 0.f;
  rayHit.ray.tfar = 1.f + embreeRounding;
  rayHit.ray.mask = 0xffffffffu;
  rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &query.context, &rayHit);
  if (query.octant == RTC_INVALID_GEOMETRY_ID)
  {
    return false;
  }
  const ActiveOctant& octant = impl_->octants[query.octant];
  const Bounds box = impl_->boxOf(octant);
  hit.t = query.tHit;
  hit.gradient = gradientAt(octant, Impl::localAt(box, slab, query.tHit));
  for (int a = 0; a < 3; ++a)
  {
    hit.gradient[a] /= box.max[a] - box.min[a];
  }
  return true;
}

void Isosurface::render(const Camera& camera, HitImage& hits) const
{
  const std::size_t pixels = static_cast<std::size_t>(camera.width()) * camera.height();
  hits.depth.assign(pixels, 1.f);
  hits.hit.assign(pixels, 0);
  hits.point.resize(pixels);
  hits.gradient.resize(pixels);
  tbb::parallel_for(tbb::blocked_range<int>(0, camera.height(), 4), [&](const auto& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
    {
      for (int x = 0; x < camera.width(); ++x)
      {
        const Ray ray = camera.ray(x, y);
        Hit hit;
        if (!intersect(ray, camera.tFromDepth(ray, 0.), camera.tFromDepth(ray, 1.), hit))
        {
          continue;
        }
        const std::size_t pixel = static_cast<std::size_t>(y) * camera.width() + x;
        hits.hit[pixel] = 1;
        hits.depth[pixel] = static_cast<float>(camera.depthFromT(ray, hit.t));
        hits.gradient[pixel] = hit.gradient;
        for (int a = 0; a < 3; ++a)
        {
          hits.point[pixel][a] = ray.origin[a] + hit.t * ray.direction[a];
        }
      }
    }
  });
}

} // namespace treeamr

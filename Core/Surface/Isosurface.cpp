// Embree works in single precision. It sees the domain as a unit cube and rays that start where they enter it,
// and only selects candidates with it: boxes are widened by its rounding, and hits are found and compared in
// double precision, so the surface is exact at any depth of the tree and any distance from the origin.
#include "Surface/Isosurface.h"

#include "Error.h"
#include "Surface/BlockWalk.h"
#include "Surface/SurfaceBlocks.h"
#include "Surface/SurfaceFrame.h"
#include "Surface/SurfaceKernel.h"

#include <embree3/rtcore.h>
#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

/// Half the widening of a box in Embree's unit cube: a ray's origin, direction and the box are each rounded
/// to 2^-24 of coordinates up to 1, and the ray's parameter reaches 1.
constexpr float embreeRounding = 0x1p-22f;

/// Hits of one surface that are no further apart than this part of a cell are one: pieces that meet in a seam both
/// have a root on it.
constexpr double sameHit = 0x1p-32;

double seconds(std::chrono::steady_clock::time_point from)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

std::vector<double> checked(std::vector<double> isovalues)
{
  if (isovalues.empty())
  {
    throw Error("isosurface: no isovalue, needed is at least one");
  }
  for (const double isovalue : isovalues)
  {
    if (!std::isfinite(isovalue))
    {
      throw Error("isosurface: isovalue " + std::to_string(isovalue) + ", allowed are finite values");
    }
  }
  std::sort(isovalues.begin(), isovalues.end());
  isovalues.erase(std::unique(isovalues.begin(), isovalues.end()), isovalues.end());
  return isovalues;
}

void checkRanges(const Field& field)
{
  if (!field.hasNodeRanges())
  {
    throw Error("isosurface: the field has no node ranges to find the surface by");
  }
}

/// True only for pixels whose ray passes the box at a distance: cheaper than to make the ray.
bool missesBox(const PixelFan& fan, const Vec3& eye, const Bounds& box, int x, int y) noexcept
{
  double in = 0.;
  double out = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a)
  {
    const double inverse = 1. / (fan.direction[a] + x * fan.perX[a] + y * fan.perY[a]);
    const double margin = 1e-6 * (box.max[a] - box.min[a]);
    const double low = (box.min[a] - margin - eye[a]) * inverse;
    const double high = (box.max[a] + margin - eye[a]) * inverse;
    in = std::max(in, std::min(low, high));
    out = std::min(out, std::max(low, high));
  }
  return in > out; // not for NaN
}

struct Query
{
  SlabRay ray;
  double tEnter;   // Embree's ray parameter 0
  double tLeave;   // Embree's ray parameter 1
  double rounding; // bound of the error of a place along the ray
  SurfaceHit nearest;
  Vec3 place; // of the nearest hit in its octant
  std::vector<SurfaceHit>* all;
  std::size_t most; // of all, that are wanted

  float parameterOf(double t) const noexcept
  {
    return static_cast<float>((t - tEnter) / (tLeave - tEnter)) + embreeRounding;
  }
};

/// Rays of a tile of an image: packets of 4 x 4 pixels take the same way and ask for the same vertex values.
struct TileRays
{
  static constexpr int packet = 4;
  static constexpr int size = 4 * packet; // pixels along an edge
  static_assert(size * size == SlabRays::most && packet * packet == OctantCandidates::mostRays);

  std::array<Query, size * size> queries;
  std::array<std::size_t, size * size> pixels;
  std::array<RTCRayHit, size * size> rays;
  std::array<std::vector<SurfaceHit>, size * size> all;
  SlabRays slabs;
  OctantCandidates candidates;
};

/// Queries of rays, passed through Embree: a ray's id is the number of its query.
struct Batch
{
  RTCIntersectContext context; // first: Embree hands back a pointer to it
  Query* queries;
  TileRays* tile = nullptr;   // of the queries, for those of many rays
  std::exception_ptr failure; // of a callback: Embree would drop it with the rest of the hits

  explicit Batch(Query& query)
    : queries(&query)
  {
    rtcInitIntersectContext(&context);
  }
  explicit Batch(TileRays& rays)
    : queries(rays.queries.data())
    , tile(&rays)
  {
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
  void rethrow() const
  {
    if (failure)
    {
      std::rethrow_exception(failure);
    }
  }
};

} // namespace

struct Isosurface::Impl
{
  IsosurfaceStatistics statistics;
  SurfaceBlocks blocks;
  TraceSpace space;
  Bounds domain;  // in it
  Vec3 perExtent; // of it
  double widest;  // extent of it
  std::atomic<std::ptrdiff_t> embreeBytes{ 0 };
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::uint64_t computedBefore = 0; // of the blocks' values, before the hierarchy was built
  mutable tbb::enumerable_thread_specific<std::unique_ptr<TileRays>> workers; // for frames

  Impl(std::shared_ptr<const Field> field, std::vector<double> isovalues, std::size_t keptBytes,
    int mostCellDepth)
    : blocks(field, std::move(isovalues), keptBytes, mostCellDepth)
    , space(field->octree().grid())
    , domain(space.domain())
    , widest(0.)
  {
    for (int a = 0; a < 3; ++a)
    {
      perExtent[a] = 1. / (domain.max[a] - domain.min[a]);
      widest = std::max(widest, domain.max[a] - domain.min[a]);
    }
  }
  ~Impl()
  {
    try
    {
      // Releasing nothing is an error, which a later one would hide behind.
      if (scene)
      {
        rtcReleaseScene(scene);
      }
      if (device)
      {
        rtcReleaseDevice(device);
      }
    }
    catch (...)
    {
      // A surface that static objects hold, as ParaView's do after sys.exit(), outlives Embree's own ones.
    }
  }

  /// Embree 3.13 crashes where memory turns out to be short, but reports an error where it is refused.
  static bool count(void* self, ssize_t bytes, bool isDone) noexcept
  {
    if (bytes > 0 && !isDone)
    {
      void* const memory = ::operator new(static_cast<std::size_t>(bytes), std::nothrow);
      ::operator delete(memory);
      if (!memory)
      {
        return false;
      }
    }
    static_cast<Impl*>(self)->embreeBytes += bytes;
    return true;
  }

  static void bounds(const RTCBoundsFunctionArguments* args) noexcept
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    const SurfaceBlock& block = self.blocks.all()[args->primID];
    float* lower = &args->bounds_o->lower_x;
    float* upper = &args->bounds_o->upper_x;
    if (block.isEmpty())
    {
      // Embree leaves out what has no extent.
      std::fill(lower, lower + 3, std::numeric_limits<float>::infinity());
      std::fill(upper, upper + 3, -std::numeric_limits<float>::infinity());
      return;
    }
    const BlockPlanes planes(self.space, block);
    for (int a = 0; a < 3; ++a)
    {
      const double extent = self.domain.max[a] - self.domain.min[a];
      const double low = planes.at[a][block.firstActive(a)];
      const double high = planes.at[a][block.endActive(a)];
      lower[a] = static_cast<float>((low - self.domain.min[a]) / extent) - embreeRounding;
      upper[a] = static_cast<float>((high - self.domain.min[a]) / extent) + embreeRounding;
    }
  }

  /// Whether one of the rays that Embree asks about meets the box of the block's active octants.
  template <class Args>
  static bool meetsExtent(const Args* args, RTCRayN* rays, const SurfaceBlock& block,
    const BlockPlanes& planes, const Batch& batch) noexcept
  {
    Vec3 low;
    Vec3 high;
    for (int a = 0; a < 3; ++a)
    {
      low[a] = planes.at[a][block.firstActive(a)];
      high[a] = planes.at[a][block.endActive(a)];
    }
    for (unsigned i = 0; i < args->N; ++i)
    {
      if (args->valid[i] != 0)
      {
        const Query& query = batch.queries[RTCRayN_id(rays, args->N, i)];
        double in = query.tEnter;
        double out = query.all ? query.tLeave : std::min(query.tLeave, query.nearest.t);
        // A hit may lie on the box: on a seam, where rounding decides.
        if (query.ray.clip(low, high, in, out) || in - out <= 0x1p-20 * (query.tLeave - query.tEnter))
        {
          return true;
        }
      }
    }
    return false;
  }

  /// Calls visit(batch, record, planes) for the rays that Embree asks about.
  template <class Args, class Visit>
  static void visitBlock(const Args* args, RTCRayN* rays, const Visit& visit) noexcept
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    Batch& batch = *reinterpret_cast<Batch*>(args->context);
    try
    {
      const SurfaceBlock& block = self.blocks.all()[args->primID];
      if (block.isEmpty())
      {
        return;
      }
      const BlockPlanes planes(self.space, block);
      // To compute values again takes longer than to look whether a ray comes near the surface.
      if (block.isNarrowed() && !self.blocks.isKept(args->primID) &&
        !meetsExtent(args, rays, block, planes, batch))
      {
        return;
      }
      const SurfaceRecord& record = self.blocks.record(args->primID);
      record.prefetch();
      visit(batch, record, planes);
    }
    catch (...)
    {
      batch.failure = std::current_exception();
    }
  }

  static void intersectBlock(const RTCIntersectFunctionNArguments* args)
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
    const auto cut = [&](const Query& query, unsigned i, double t) {
      RTCRayN_tfar(rays, args->N, i) = query.parameterOf(t);
    };
    visitBlock(args, rays, [&](Batch& batch, const SurfaceRecord& record, const BlockPlanes& planes) {
      for (unsigned i = 0; i < args->N;)
      {
        // Runs of rays that lie side by side.
        const unsigned first = RTCRayN_id(rays, args->N, i);
        unsigned count = 0;
        while (i + count < args->N && count < OctantCandidates::mostRays && args->valid[i + count] != 0 &&
          RTCRayN_id(rays, args->N, i + count) == first + count)
        {
          ++count;
        }
        if (count > 1)
        {
          self.crossTogether(args->primID, record, planes, *batch.tile, first, count,
            [&](unsigned k, double t) { cut(batch.queries[first + k], i + k, t); });
        }
        else if (count == 1)
        {
          Query& query = batch.queries[first];
          if (query.all)
          {
            self.collectInBlock(args->primID, record, planes, query);
          }
          else if (self.nearestInBlock(args->primID, record, planes, query))
          {
            cut(query, i, query.nearest.t);
          }
        }
        i += std::max(count, 1u);
      }
    });
  }

  static void occludeBlock(const RTCOccludedFunctionNArguments* args)
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    visitBlock(args, args->ray, [&](Batch& batch, const SurfaceRecord& record, const BlockPlanes& planes) {
      for (unsigned i = 0; i < args->N; ++i)
      {
        if (args->valid[i] != 0 &&
          self.nearestInBlock(args->primID, record, planes, batch.queries[RTCRayN_id(args->ray, args->N, i)]))
        {
          RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
        }
      }
    });
  }

  /// Bound of the error of a place in an octant of the block.
  static double placeError(const BlockPlanes& planes, const Query& query) noexcept
  {
    const double perWidth =
      std::max({ planes.inverseWidth[0][0], planes.inverseWidth[1][0], planes.inverseWidth[2][0] });
    return query.rounding * perWidth;
  }

  /// The roots on a crossing; get: the crossing, for mixed records only.
  template <class Get, class Visit>
  static void visitCrossing(const SurfaceRecord& record, const BlockPlanes& planes, const Query& query,
    double isovalue, const Cubic& cubic, double tolerance, const Get& get, const Visit& visit)
  {
    if (!record.isMixed())
    {
      visitRoots(cubic, tolerance, visit);
      return;
    }
    const OctantCrossing& crossing = get();
    const auto at = [&](const Vec3& place) {
      return onSeam(record, isovalue, crossing.octant, place, placeError(planes, query));
    };
    visitRoots(cubic, at(crossing.from), at(crossing.to), 0., visit);
  }

  /// Calls visit(surface, crossing, s) for the roots of single rays, of each surface's on a crossing until it returns
  /// true, and goesOn() after each crossing.
  template <class Visit, class GoesOn>
  void visitHits(const SurfaceRecord& record, const BlockPlanes& planes, const Query& query,
    const double& limit, const Visit& visit, const GoesOn& goesOn) const
  {
    // How far from zero a value may be on the seam of two octants that is zero on it.
    const double tolerance = record.tolerance + record.width() * placeError(planes, query);
    walkBlock(planes, record.active, query.ray, query.tEnter, query.tLeave, limit,
      [&](const OctantCrossing& crossing) {
        for (std::uint32_t surface = 0; surface < blocks.isovalues().size(); ++surface)
        {
          const double isovalue = blocks.isovalues()[surface];
          visitCrossing(
            record, planes, query, isovalue, alongCrossing(record, isovalue, crossing), tolerance,
            [&]() -> const OctantCrossing& { return crossing; },
            [&](double s) { return visit(surface, crossing, s); });
        }
        return goesOn();
      });
  }

  /// Makes a root the query's nearest hit when it is.
  static bool takeNearest(std::uint32_t block, std::uint32_t surface, const OctantCrossing& crossing,
    double s, Query& query) noexcept
  {
    // Of equal hits of neighbours the first block's counts, whatever the order of visits.
    const double t = crossing.t0 + s * (crossing.t1 - crossing.t0);
    if (!(t < query.nearest.t || (t == query.nearest.t && block < query.nearest.block)))
    {
      return false;
    }
    query.nearest = { t, {}, {}, surface, block, static_cast<std::uint8_t>(crossing.octant) };
    query.place = crossing.place(s);
    return true;
  }

  /// Whether the query's nearest hit is now in this block.
  bool nearestInBlock(
    std::uint32_t block, const SurfaceRecord& record, const BlockPlanes& planes, Query& query) const
  {
    bool closer = false;
    visitHits(
      record, planes, query, query.nearest.t,
      [&](std::uint32_t surface, const OctantCrossing& crossing, double s) {
        closer = takeNearest(block, surface, crossing, s, query) || closer;
        return true;
      },
      [&] { return !closer; });
    return closer;
  }

  /// At a place in the hit's octant.
  void setGradients(
    const SurfaceRecord& record, const BlockPlanes& planes, const Vec3& place, SurfaceHit& hit) const noexcept
  {
    auto [exact, smooth] = gradientsAt(record, planes, domain, hit.octant, place);
    for (int a = 0; a < 3; ++a)
    {
      exact[a] /= space.width(a);
      smooth[a] /= space.width(a);
    }
    hit.gradient = exact;
    const Vec3 normal = normalized(dot(smooth, exact) > 0. ? smooth : exact);
    std::copy(normal.begin(), normal.end(), hit.normal.begin());
  }

  void collect(std::uint32_t block, std::uint32_t surface, const SurfaceRecord& record,
    const BlockPlanes& planes, const OctantCrossing& crossing, double s, std::vector<SurfaceHit>& all) const
  {
    all.push_back({ crossing.t0 + s * (crossing.t1 - crossing.t0), {}, {}, surface, block,
      static_cast<std::uint8_t>(crossing.octant) });
    setGradients(record, planes, crossing.place(s), all.back());
  }

  void collectInBlock(
    std::uint32_t block, const SurfaceRecord& record, const BlockPlanes& planes, Query& query) const
  {
    visitHits(
      record, planes, query, query.tLeave,
      [&](std::uint32_t surface, const OctantCrossing& crossing, double s) {
        collect(block, surface, record, planes, crossing, s, *query.all);
        return false;
      },
      [] { return true; });
  }

  /// The same for rays side by side. cut(k, t): those of ray first + k need not be asked about beyond t.
  template <class Cut>
  void crossTogether(std::uint32_t block, const SurfaceRecord& record, const BlockPlanes& planes,
    TileRays& tile, unsigned first, unsigned count, const Cut& cut) const
  {
    const std::span<const double> isovalues = blocks.isovalues();
    OctantCandidates& candidates = tile.candidates;
    for (std::size_t s0 = 0; s0 < isovalues.size(); s0 += OctantCandidates::mostIsovalues)
    {
      const auto some =
        isovalues.subspan(s0, std::min<std::size_t>(OctantCandidates::mostIsovalues, isovalues.size() - s0));
      crossBlock(
        record, planes, some, tile.slabs, static_cast<int>(first), static_cast<int>(count), candidates);
      for (int i = 0; i < candidates.count; ++i)
      {
        const auto number = static_cast<std::size_t>(candidates.ray(i));
        Query& query = tile.queries[number];
        const auto surface = static_cast<std::uint32_t>(s0) + candidates.isovalue(i);
        std::optional<OctantCrossing> made;
        const auto crossing = [&]() -> const OctantCrossing& {
          if (!made)
          {
            made.emplace(planes, query.ray, candidates.octant(i), candidates.t0[i], candidates.t1[i]);
          }
          return *made;
        };
        const auto visit = [&](double s) {
          if (query.all)
          {
            collect(block, surface, record, planes, crossing(), s, *query.all);
            return false;
          }
          if (takeNearest(block, surface, crossing(), s, query))
          {
            tile.slabs.limit[number] = query.nearest.t;
            cut(number - first, query.nearest.t);
          }
          return true;
        };
        visitCrossing(record, planes, query, isovalues[surface], candidates.along(i), candidates.tolerance[i],
          crossing, visit);
      }
    }
    for (unsigned k = 0; k < count; ++k)
    {
      // Not at every hit: to sort them takes time.
      Query& query = tile.queries[first + k];
      if (query.all && query.all->size() / 2 >= query.most)
      {
        finish(query, *query.all);
        if (query.all->size() == query.most)
        {
          tile.slabs.limit[first + k] = query.all->back().t;
          cut(k, query.all->back().t);
        }
      }
    }
  }

  void build()
  {
    const auto start = std::chrono::steady_clock::now();
    device = rtcNewDevice(nullptr);
    if (!device)
    {
      throw Error("isosurface: Embree made no device, error " + std::to_string(rtcGetDeviceError(nullptr)));
    }
    rtcSetDeviceMemoryMonitorFunction(device, count, this);
    scene = rtcNewScene(device);
    RTCGeometry geometry = scene ? rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER) : nullptr;
    if (geometry) // else the device has the error
    {
      rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(blocks.all().size()));
      rtcSetGeometryUserData(geometry, this);
      rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
      rtcSetGeometryIntersectFunction(geometry, intersectBlock);
      rtcSetGeometryOccludedFunction(geometry, occludeBlock);
      // Three times as fast to build as Embree's default, for frames that take 1 or 2 % longer; the scene's quality
      // alone makes frames 25 % slower.
      rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
      rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene, geometry);
      rtcReleaseGeometry(geometry);
      rtcCommitScene(scene);
    }
    check();
    statistics.hierarchySeconds = seconds(start);
  }

  /// While no thread queries. The hierarchy is built again, over the extents that rays have narrowed since, each time
  /// that these have become twice as many: until then frames visit more blocks than they need to.
  void startFrame()
  {
    blocks.startFrame();
    const std::uint64_t computed = blocks.computedCount();
    if (scene && computed >= blocks.all().size() / 64 + 2 * computedBefore && computed > computedBefore)
    {
      const auto start = std::chrono::steady_clock::now();
      computedBefore = computed;
      rtcCommitGeometry(rtcGetGeometry(scene, 0));
      rtcCommitScene(scene);
      try
      {
        check();
      }
      catch (...)
      {
        rtcReleaseScene(std::exchange(scene, nullptr)); // rays would find it half made
        throw;
      }
      statistics.hierarchySeconds += seconds(start);
    }
  }

  void check() const
  {
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    {
      throw Error("isosurface: Embree reports error " + std::to_string(error) + " for " +
        std::to_string(blocks.all().size()) + " nodes");
    }
  }

  /// The query for a ray, and the ray in Embree's unit cube; false when it misses the domain. id: the query's number.
  bool prepare(const Ray& world, double tMin, double tMax, unsigned id, Query& query, RTCRay& ray) const
  {
    if (!scene)
    {
      return false;
    }
    query.ray = SlabRay(space.ray(world));
    query.tEnter = tMin;
    query.tLeave = tMax;
    query.rounding = 0.;
    query.all = nullptr;
    query.most = std::numeric_limits<std::size_t>::max();
    query.ray.enterUpperFaces(domain);
    if (!query.ray.clip(domain.min, domain.max, query.tEnter, query.tLeave))
    {
      return false;
    }
    for (int a = 0; a < 3; ++a)
    {
      const double reach = std::abs(query.ray.origin[a]) + query.tLeave * std::abs(query.ray.direction[a]);
      query.rounding = std::max(query.rounding, 0x1p-50 * reach);
    }
    query.nearest.t = std::numeric_limits<double>::infinity();
    query.nearest.block = RTC_INVALID_GEOMETRY_ID;
    float* origin = &ray.org_x;
    float* direction = &ray.dir_x;
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = static_cast<float>(
        (query.ray.origin[a] + query.tEnter * query.ray.direction[a] - domain.min[a]) * perExtent[a]);
      direction[a] =
        static_cast<float>(query.ray.direction[a] * (query.tLeave - query.tEnter) * perExtent[a]);
      // Not for NaN, nor from so far away that no digits are left: Embree may abort.
      constexpr float aroundCube = 4.f;
      if (!(std::abs(origin[a]) + std::abs(direction[a]) <= aroundCube))
      {
        return false;
      }
    }
    ray.tnear = 0.f;
    ray.tfar = 1.f + embreeRounding;
    ray.time = 0.f;
    ray.mask = 0xffffffffu;
    ray.id = id;
    ray.flags = 0;
    return true;
  }

  void trace(Query& query, RTCRayHit& ray) const
  {
    Batch batch(query);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &batch.context, &ray);
    batch.rethrow();
  }

  /// The nearest hit of a traced query, if there is one.
  bool finish(const Query& query, SurfaceHit& hit) const
  {
    if (query.nearest.block == RTC_INVALID_GEOMETRY_ID)
    {
      return false;
    }
    hit = query.nearest;
    const BlockPlanes planes(space, blocks.all()[hit.block]);
    setGradients(blocks.record(hit.block), planes, query.place, hit);
    return true;
  }

  /// Least width of the leaf that a hit lies in.
  double leafWidth(const SurfaceHit& hit, const Vec3& perUnit) const noexcept
  {
    const BlockPlanes planes(space, blocks.all()[hit.block]);
    double width = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a)
    {
      const int cell = hit.octant >> 2 * a & 2;
      width = std::min(width, (planes.at[a][cell + 2] - planes.at[a][cell]) * perUnit[a]);
    }
    return width;
  }

  /// Sorts the hits of a traced query, each once, and leaves the nearest that are wanted.
  void finish(const Query& query, std::vector<SurfaceHit>& hits) const
  {
    // They come nearly sorted.
    for (std::size_t i = 1; i < hits.size(); ++i)
    {
      const auto before = [](const SurfaceHit& a, const SurfaceHit& b) {
        return a.t != b.t ? a.t < b.t : a.surface != b.surface ? a.surface < b.surface : a.block < b.block;
      };
      if (before(hits[i], hits[i - 1]))
      {
        const auto at = std::upper_bound(hits.begin(), hits.begin() + i, hits[i], before);
        std::rotate(at, hits.begin() + i, hits.begin() + i + 1);
      }
    }
    const Vec3& d = query.ray.direction;
    const double speed = std::max({ std::abs(d[0]), std::abs(d[1]), std::abs(d[2]) });
    std::size_t kept = 0;
    for (const SurfaceHit& hit : hits)
    {
      bool isNew = true;
      for (std::size_t k = kept; k > 0 && (hit.t - hits[k - 1].t) * speed <= sameHit * widest; --k)
      {
        if (hits[k - 1].surface == hit.surface)
        {
          isNew = (hit.t - hits[k - 1].t) * speed > sameHit * leafWidth(hits[k - 1], { 1., 1., 1. });
          break;
        }
      }
      if (isNew)
      {
        hits[kept++] = hit;
      }
    }
    hits.resize(std::min(kept, query.most));
  }
};

void checkPixels(const HitImage& hits, const Camera& camera, const char* user)
{
  const std::size_t needed = static_cast<std::size_t>(camera.width()) * camera.height() + 1;
  if (hits.first.size() != needed)
  {
    throw Error(std::string(user) + ": surface hits in " + std::to_string(hits.first.size()) +
      " entries by pixel, needed are " + std::to_string(needed));
  }
  if (hits.first.back() != hits.hits.size())
  {
    throw Error(std::string(user) + ": " + std::to_string(hits.hits.size()) +
      " surface hits, where the entries by pixel end at " + std::to_string(hits.first.back()));
  }
}

Isosurface::Isosurface(
  std::shared_ptr<const Field> field, std::vector<double> isovalues, std::size_t keptBytes, int mostCellDepth)
{
  isovalues = checked(std::move(isovalues));
  checkRanges(required(field, "isosurface"));
  const auto start = std::chrono::steady_clock::now();
  impl_ = std::make_unique<Impl>(std::move(field), std::move(isovalues), keptBytes, mostCellDepth);
  impl_->statistics.extractionSeconds = seconds(start);
  const std::size_t blocks = impl_->blocks.all().size();
  if (blocks >= RTC_INVALID_GEOMETRY_ID)
  {
    throw Error("isosurface: " + std::to_string(blocks) + " nodes with the surface, allowed are " +
      std::to_string(RTC_INVALID_GEOMETRY_ID - 1));
  }
  if (blocks != 0)
  {
    impl_->build();
  }
}

Isosurface::~Isosurface() = default;

const std::vector<double>& Isosurface::isovalues() const noexcept
{
  return impl_->blocks.isovalues();
}

IsosurfaceStatistics Isosurface::statistics() const
{
  IsosurfaceStatistics statistics = impl_->statistics;
  statistics.blocks = impl_->blocks.all().size();
  statistics.blockBytes = impl_->blocks.byteSize();
  statistics.hierarchyBytes = static_cast<std::size_t>(impl_->embreeBytes.load());
  statistics.keptBytes = impl_->blocks.keptBytes();
  return statistics;
}

std::uint64_t Isosurface::octantCount() const
{
  return impl_->blocks.octantCount();
}

void Isosurface::startFrame() const
{
  impl_->startFrame();
}

bool Isosurface::intersect(const Ray& ray, double tMin, double tMax, SurfaceHit& hit) const
{
  Query query;
  RTCRayHit r;
  if (!impl_->prepare(ray, tMin, tMax, 0, query, r.ray))
  {
    return false;
  }
  impl_->trace(query, r);
  return impl_->finish(query, hit);
}

void Isosurface::intersectAll(const Ray& ray, double tMin, double tMax, std::vector<SurfaceHit>& hits) const
{
  hits.clear();
  Query query;
  RTCRayHit r;
  if (impl_->prepare(ray, tMin, tMax, 0, query, r.ray))
  {
    query.all = &hits;
    impl_->trace(query, r);
    impl_->finish(query, hits);
  }
}

bool Isosurface::occluded(const Ray& ray, double tMin, double tMax) const
{
  Query query;
  RTCRay r;
  if (!impl_->prepare(ray, tMin, tMax, 0, query, r))
  {
    return false;
  }
  Batch batch(query);
  rtcOccluded1(impl_->scene, &batch.context, &r);
  batch.rethrow();
  return query.nearest.block != RTC_INVALID_GEOMETRY_ID;
}

void Isosurface::render(
  const Camera& camera, SurfaceLayers layers, HitImage& image, std::size_t mostHits) const
{
  const auto width = static_cast<std::size_t>(camera.width());
  const std::size_t pixels = width * camera.height();
  image.first.assign(pixels + 1, 0);
  const std::optional<PixelFan> fan = camera.isPerspective() ? std::optional(camera.fan()) : std::nullopt;
  const Vec3 eye = camera.eye();
  const Bounds domain = impl_->blocks.field().octree().grid().bounds();
  const bool isCut = !camera.seesAllDepthsOf(domain.min, domain.max);
  constexpr int packet = TileRays::packet;
  constexpr int tile = TileRays::size;
  const int tilesX = (camera.width() + tile - 1) / tile;
  const int tilesY = (camera.height() + tile - 1) / tile;
  std::vector<std::vector<SurfaceHit>> parts(static_cast<std::size_t>(tilesX) * tilesY);
  const auto forTiles = [&](const auto& body) {
    tbb::parallel_for(
      tbb::blocked_range2d<int>(0, tilesY, 0, tilesX), [&](const tbb::blocked_range2d<int>& range) {
        for (int j = range.rows().begin(); j < range.rows().end(); ++j)
        {
          for (int i = range.cols().begin(); i < range.cols().end(); ++i)
          {
            body(i, j, parts[static_cast<std::size_t>(j) * tilesX + i]);
          }
        }
      });
  };
  const auto forPixels = [&](int i, int j, const auto& body) {
    for (int k = 0; k < tile * tile; ++k)
    {
      const int inPacket = k % (packet * packet);
      const int ofTile = k / (packet * packet);
      const int x = i * tile + packet * (ofTile % 4) + inPacket % packet;
      const int y = j * tile + packet * (ofTile / 4) + inPacket / packet;
      if (x < camera.width() && y < camera.height())
      {
        body(x, y, y * width + x);
      }
    }
  };
  forTiles([&](int i, int j, std::vector<SurfaceHit>& found) {
    std::unique_ptr<TileRays>& own = impl_->workers.local();
    own = own ? std::move(own) : std::make_unique<TileRays>();
    // The pixels that show the box form a convex area.
    bool mayMiss = false;
    for (int corner = 0; fan && corner < 4; ++corner)
    {
      mayMiss =
        mayMiss || missesBox(*fan, eye, domain, (i + (corner & 1)) * tile, (j + (corner >> 1)) * tile);
    }
    unsigned count = 0;
    forPixels(i, j, [&](int x, int y, std::size_t pixel) {
      if (mayMiss && missesBox(*fan, eye, domain, x, y))
      {
        return;
      }
      const Ray ray = camera.ray(x, y);
      const double tMin = isCut ? camera.tFromDepth(ray, 0.) : 0.;
      const double tMax = isCut ? camera.tFromDepth(ray, 1.) : std::numeric_limits<double>::infinity();
      RTCRayHit& r = own->rays[count];
      Query& query = own->queries[count];
      if (impl_->prepare(ray, tMin, tMax, count, query, r.ray))
      {
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        own->slabs.set(count, query.ray);
        own->slabs.enter[count] = query.tEnter;
        own->slabs.leave[count] = query.tLeave;
        own->slabs.limit[count] = query.nearest.t;
        own->slabs.rounding[count] = query.rounding;
        if (layers == SurfaceLayers::All)
        {
          own->all[count].clear();
          query.all = &own->all[count];
          query.most = mostHits;
        }
        own->pixels[count++] = pixel;
      }
    });
    if (count == 0)
    {
      return;
    }
    Batch batch(*own);
    rtcIntersect1M(impl_->scene, &batch.context, own->rays.data(), count, sizeof(RTCRayHit));
    batch.rethrow();
    for (unsigned k = 0; k < count; ++k)
    {
      const std::size_t before = found.size();
      if (layers == SurfaceLayers::All)
      {
        std::vector<SurfaceHit>& hits = own->all[k];
        impl_->finish(own->queries[k], hits);
        found.insert(found.end(), hits.begin(), hits.end());
      }
      else if (SurfaceHit hit; impl_->finish(own->queries[k], hit))
      {
        found.push_back(hit);
      }
      image.first[own->pixels[k] + 1] = found.size() - before;
    }
  });
  for (std::size_t p = 0; p < pixels; ++p)
  {
    image.first[p + 1] += image.first[p];
  }
  image.hits.resize(image.first[pixels]);
  forTiles([&](int i, int j, const std::vector<SurfaceHit>& found) {
    auto next = found.begin();
    forPixels(i, j, [&](int, int, std::size_t pixel) {
      const auto count = static_cast<std::ptrdiff_t>(image.first[pixel + 1] - image.first[pixel]);
      std::copy(next, next + count, image.hits.begin() + static_cast<std::ptrdiff_t>(image.first[pixel]));
      next += count;
    });
  });
}

CellId Isosurface::cell(const SurfaceHit& hit) const noexcept
{
  const SurfaceBlock& block = impl_->blocks.all()[hit.block];
  CellId cell{ {}, block.depth() + 1 - impl_->blocks.field().octree().grid().paddingDepth() };
  for (int a = 0; a < 3; ++a)
  {
    cell.index[a] = 2 * block.index(a) + (hit.octant >> (2 * a + 1) & 1);
  }
  return cell;
}

double Isosurface::leafWidth(const SurfaceHit& hit) const noexcept
{
  const TraceSpace& space = impl_->space;
  return impl_->leafWidth(hit, { space.width(0), space.width(1), space.width(2) });
}

} // namespace treeamr

#include "Surface/SurfaceHierarchy.h"

#include "Error.h"

#if TREEAMR_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

/// Half the widening of a box in Embree's unit cube: a ray's origin, direction and the box are each rounded
/// to 2^-24 of coordinates up to 1, and the ray's parameter reaches 1.
constexpr float embreeRounding = 0x1p-22f;

constexpr int packetRays = 16;

double seconds(std::chrono::steady_clock::time_point from)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

/// Embree's parameter of a ray is 0 where it enters the domain and 1 where it leaves.
float parameterOf(const SurfaceRay& ray, double t) noexcept
{
  return static_cast<float>((t - ray.tEnter) / (ray.tLeave - ray.tEnter)) + embreeRounding;
}

/// Rays passed through Embree: a ray's id is its number.
struct Query
{
#if TREEAMR_EMBREE >= 4
  RTCRayQueryContext context; // first: Embree hands back a pointer to it
#else
  RTCIntersectContext context; // first: Embree hands back a pointer to it
#endif
  SurfaceRay* rays;
  RayTile* tile = nullptr;
  std::exception_ptr failure; // of a callback: Embree would drop it with the rest of the hits

  explicit Query(SurfaceRay* some)
    : rays(some)
  {
#if TREEAMR_EMBREE >= 4
    rtcInitRayQueryContext(&context);
#else
    rtcInitIntersectContext(&context);
#endif
  }
  void rethrow() const
  {
    if (failure)
    {
      std::rethrow_exception(failure);
    }
  }
  void intersect(RTCScene scene, RTCRayHit& ray)
  {
#if TREEAMR_EMBREE >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene, &ray, &arguments);
#else
    rtcIntersect1(scene, &context, &ray);
#endif
  }
  void intersect(RTCScene scene, const int* valid, RTCRayHit16& rayHits)
  {
#if TREEAMR_EMBREE >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &rayHits, &arguments);
#else
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &rayHits);
#endif
  }
  void occluded(RTCScene scene, RTCRay& ray)
  {
#if TREEAMR_EMBREE >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, &ray, &arguments);
#else
    rtcOccluded1(scene, &context, &ray);
#endif
  }
};

} // namespace

struct SurfaceHierarchy::Impl
{
  const BlockIntersection& intersection;
  Bounds domain;
  Vec3 perExtent; // of it
  std::atomic<std::ptrdiff_t> bytes{ 0 };
  double seconds = 0.;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::uint64_t computedBefore = 0; // of the blocks' values, before it was built

  explicit Impl(const BlockIntersection& with)
    : intersection(with)
    , domain(with.space().domain())
  {
    for (int a = 0; a < 3; ++a)
    {
      perExtent[a] = 1. / (domain.max[a] - domain.min[a]);
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
    static_cast<Impl*>(self)->bytes += bytes;
    return true;
  }

  static void bounds(const RTCBoundsFunctionArguments* args) noexcept
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    const SurfaceBlock& block = self.intersection.blocks().all()[args->primID];
    float* lower = &args->bounds_o->lower_x;
    float* upper = &args->bounds_o->upper_x;
    if (block.isEmpty())
    {
      // Embree leaves out what has no extent.
      std::fill(lower, lower + 3, std::numeric_limits<float>::infinity());
      std::fill(upper, upper + 3, -std::numeric_limits<float>::infinity());
      return;
    }
    const BlockPlanes planes(self.intersection.space(), block);
    for (int a = 0; a < 3; ++a)
    {
      const double extent = self.domain.max[a] - self.domain.min[a];
      const double low = planes.at[a][block.firstActive(a)];
      const double high = planes.at[a][block.endActive(a)];
      lower[a] = static_cast<float>((low - self.domain.min[a]) / extent) - embreeRounding;
      upper[a] = static_cast<float>((high - self.domain.min[a]) / extent) + embreeRounding;
    }
  }

  /// Calls visit(query, numbers of rays) for the rays that Embree asks about, and reply(i, ray) for those whose bits
  /// are set in what it returns; i: Embree's.
  template <class Args, class Visit, class Reply>
  static void ask(const Args* args, RTCRayN* rays, const Visit& visit, const Reply& reply) noexcept
  {
    Query& query = *reinterpret_cast<Query*>(args->context);
    std::array<unsigned, packetRays> numbers;
    std::array<unsigned, packetRays> places;
    std::size_t count = 0;
    for (unsigned i = 0; i < args->N && count < numbers.size(); ++i)
    {
      if (args->valid[i] != 0)
      {
        places[count] = i;
        numbers[count++] = RTCRayN_id(rays, args->N, i);
      }
    }
    try
    {
      std::uint32_t changed = visit(query, std::span<const unsigned>(numbers.data(), count));
      for (; changed != 0; changed &= changed - 1)
      {
        const int k = std::countr_zero(changed);
        reply(places[k], query.rays[numbers[k]]);
      }
    }
    catch (...)
    {
      query.failure = std::current_exception();
    }
  }

  static void intersectBlock(const RTCIntersectFunctionNArguments* args) noexcept
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
    ask(
      args, rays,
      [&](Query& query, std::span<const unsigned> numbers) {
        return self.intersection.intersect(args->primID, numbers, query.rays, query.tile);
      },
      [&](
        unsigned i, const SurfaceRay& ray) { RTCRayN_tfar(rays, args->N, i) = parameterOf(ray, ray.limit); });
  }

  static void occludeBlock(const RTCOccludedFunctionNArguments* args) noexcept
  {
    const Impl& self = *static_cast<const Impl*>(args->geometryUserPtr);
    ask(
      args, args->ray,
      [&](Query& query, std::span<const unsigned> numbers) {
        return self.intersection.intersect(args->primID, numbers, query.rays, nullptr);
      },
      [&](unsigned i, const SurfaceRay&) {
        RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
      });
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
      rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(intersection.blocks().all().size()));
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
    seconds += treeamr::seconds(start);
  }

  void check() const
  {
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    {
      throw Error("isosurface: Embree reports error " + std::to_string(error) + " for " +
        std::to_string(intersection.blocks().all().size()) + " nodes");
    }
  }

  /// In Embree's unit cube; false: see reaches().
  bool find(
    const SurfaceRay& ray, std::array<float, 3>& origin, std::array<float, 3>& direction) const noexcept
  {
    for (int a = 0; a < 3; ++a)
    {
      origin[a] = static_cast<float>(
        (ray.ray.origin[a] + ray.tEnter * ray.ray.direction[a] - domain.min[a]) * perExtent[a]);
      direction[a] = static_cast<float>(ray.ray.direction[a] * (ray.tLeave - ray.tEnter) * perExtent[a]);
      constexpr float aroundCube = 4.f;
      if (!(std::abs(origin[a]) + std::abs(direction[a]) <= aroundCube)) // Embree may abort
      {
        return false;
      }
    }
    return true;
  }

  RTCRay single(const SurfaceRay& ray) const noexcept
  {
    std::array<float, 3> origin;
    std::array<float, 3> direction;
    find(ray, origin, direction);
    return { origin[0], origin[1], origin[2], 0.f, direction[0], direction[1], direction[2], 0.f,
      1.f + embreeRounding, 0xffffffffu, 0, 0 };
  }
};

SurfaceHierarchy::SurfaceHierarchy(const BlockIntersection& intersection)
  : impl_(std::make_unique<Impl>(intersection))
{
  const std::size_t blocks = intersection.blocks().all().size();
  if (blocks >= blockLimit)
  {
    throw Error("isosurface: " + std::to_string(blocks) + " nodes with the surface, allowed are " +
      std::to_string(blockLimit - 1));
  }
  if (blocks != 0)
  {
    impl_->build();
  }
}

SurfaceHierarchy::~SurfaceHierarchy() = default;

void SurfaceHierarchy::update()
{
  Impl& self = *impl_;
  const SurfaceBlocks& blocks = self.intersection.blocks();
  const std::uint64_t computed = blocks.computedCount();
  if (self.scene && computed >= blocks.all().size() / 64 + 2 * self.computedBefore &&
    computed > self.computedBefore)
  {
    const auto start = std::chrono::steady_clock::now();
    self.computedBefore = computed;
    rtcCommitGeometry(rtcGetGeometry(self.scene, 0));
    rtcCommitScene(self.scene);
    try
    {
      self.check();
    }
    catch (...)
    {
      rtcReleaseScene(std::exchange(self.scene, nullptr)); // rays would find it half made
      throw;
    }
    self.seconds += treeamr::seconds(start);
  }
}

std::size_t SurfaceHierarchy::byteSize() const noexcept
{
  return static_cast<std::size_t>(impl_->bytes.load());
}

double SurfaceHierarchy::seconds() const noexcept
{
  return impl_->seconds;
}

bool SurfaceHierarchy::reaches(const SurfaceRay& ray) const noexcept
{
  std::array<float, 3> origin;
  std::array<float, 3> direction;
  return impl_->scene && impl_->find(ray, origin, direction);
}

void SurfaceHierarchy::intersect(SurfaceRay& ray) const
{
  RTCRayHit hit;
  hit.ray = impl_->single(ray);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  Query query(&ray);
  query.intersect(impl_->scene, hit);
  query.rethrow();
}

void SurfaceHierarchy::intersect(RayTile& tile) const
{
  Query query(tile.rays.data());
  query.tile = &tile;
  for (int first = 0; first < tile.count; first += packetRays)
  {
    alignas(64) int valid[packetRays];
    RTCRayHit16 packet;
    for (int i = 0; i < packetRays; ++i)
    {
      valid[i] = first + i < tile.count ? -1 : 0;
      std::array<float, 3> origin{};
      std::array<float, 3> direction{};
      if (valid[i] != 0)
      {
        impl_->find(tile.rays[first + i], origin, direction);
      }
      packet.ray.org_x[i] = origin[0];
      packet.ray.org_y[i] = origin[1];
      packet.ray.org_z[i] = origin[2];
      packet.ray.tnear[i] = 0.f;
      packet.ray.dir_x[i] = direction[0];
      packet.ray.dir_y[i] = direction[1];
      packet.ray.dir_z[i] = direction[2];
      packet.ray.time[i] = 0.f;
      packet.ray.tfar[i] = 1.f + embreeRounding;
      packet.ray.mask[i] = 0xffffffffu;
      packet.ray.id[i] = static_cast<unsigned>(first + i);
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    query.intersect(impl_->scene, valid, packet);
    query.rethrow();
  }
}

bool SurfaceHierarchy::occluded(SurfaceRay& ray) const
{
  RTCRay r = impl_->single(ray);
  Query query(&ray);
  query.occluded(impl_->scene, r);
  query.rethrow();
  return ray.hasHit();
}

} // namespace treeamr

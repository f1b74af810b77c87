#include "Surface/SurfaceHierarchy.h"

#include "Error.h"
#include "Surface/EmbreeVersions.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <numeric>
#include <string>
#include <utility>

namespace treeamr
{

namespace
{

constexpr int packetRays = 16;

double seconds(std::chrono::steady_clock::time_point from)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

/// Embree's parameter of a ray is 0 where it enters the domain and 1 where it leaves.
float parameterOf(double tEnter, double tLeave, double t) noexcept
{
  return static_cast<float>((t - tEnter) / (tLeave - tEnter)) + UnitBox::rounding;
}

/// A single ray, or those of a tile by their ids, passed through Embree.
struct Query
{
  embree::Context context; // first: Embree hands back a pointer to it
  const RayPart* ray = nullptr;
  RayHits* hits = nullptr;
  RayTile* tile = nullptr;
  std::exception_ptr failure; // of a callback: Embree would drop it with the rest of the hits

  Query() { embree::initialise(context); }
  Query(const RayPart& one, RayHits& of)
    : Query()
  {
    ray = &one;
    hits = &of;
  }
  explicit Query(RayTile& some)
    : Query()
  {
    tile = &some;
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

struct SurfaceHierarchy::Impl
{
  const BlockIntersection& intersection;
  std::atomic<std::ptrdiff_t> bytes{ 0 };
  double seconds = 0.;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::uint64_t computedBefore = 0; // of the blocks' values, before it was built

  explicit Impl(const BlockIntersection& with)
    : intersection(with)
  {
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
    // Embree leaves out what has no extent.
    const UnitBox box = self.intersection.unitBox(args->primID);
    std::copy(box.low.begin(), box.low.end(), &args->bounds_o->lower_x);
    std::copy(box.high.begin(), box.high.end(), &args->bounds_o->upper_x);
  }

  /// Finds hits of the rays that Embree asks about; reply(i, part of the ray, limit) for those whose limits have come
  /// nearer; i: Embree's.
  template <class Args, class Reply>
  static void ask(const Args* args, RTCRayN* rays, const Reply& reply) noexcept
  {
    const BlockIntersection& intersection = static_cast<const Impl*>(args->geometryUserPtr)->intersection;
    Query& query = *reinterpret_cast<Query*>(args->context);
    if (query.failure)
    {
      return; // what failed has left the tile half done
    }
    try
    {
      if (!query.tile)
      {
        if (args->valid[0] != 0 && intersection.intersect(args->primID, *query.ray, *query.hits))
        {
          reply(0, query.ray->tEnter, query.ray->tLeave, query.hits->limit);
        }
        return;
      }
      // All of one packet, in the order of their ids or less than that.
      std::uint32_t wanted = 0;
      std::array<unsigned, packetRays> place;
      unsigned id = 0;
      for (unsigned i = 0; i < args->N; ++i)
      {
        if (args->valid[i] != 0)
        {
          id = RTCRayN_id(rays, args->N, i);
          wanted |= 1u << id % packetRays;
          place[id % packetRays] = i;
        }
      }
      const unsigned first = id - id % packetRays;
      std::uint32_t nearer =
        intersection.intersect(args->primID, static_cast<int>(first), wanted, *query.tile);
      for (; nearer != 0; nearer &= nearer - 1)
      {
        const int k = std::countr_zero(nearer);
        const SlabRays& parts = query.tile->rays;
        reply(place[k], parts.enter[first + k], parts.leave[first + k], parts.limit[first + k]);
      }
    }
    catch (...)
    {
      query.failure = std::current_exception();
    }
  }

  static void intersectBlock(const RTCIntersectFunctionNArguments* args) noexcept
  {
    RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
    ask(args, rays, [&](unsigned i, double tEnter, double tLeave, double limit) {
      RTCRayN_tfar(rays, args->N, i) = parameterOf(tEnter, tLeave, limit);
    });
  }

  static void occludeBlock(const RTCOccludedFunctionNArguments* args) noexcept
  {
    ask(args, args->ray, [&](unsigned i, double, double, double) {
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

  /// False for a ray that can meet no block.
  bool find(const RayPart& part, RTCRay& ray) const noexcept
  {
    std::array<float, 3> o{};
    std::array<float, 3> d{};
    const bool found = scene && intersection.space().toUnitCube(part, o, d);
    ray = { o[0], o[1], o[2], 0.f, d[0], d[1], d[2], 0.f, 1.f + UnitBox::rounding, 0xffffffffu, 0, 0 };
    return found;
  }

  /// 16 rays of a tile from the first on.
  static void fill(const RayTile& tile, int first, RTCRay16& rays) noexcept
  {
    const auto copy = [first](const SlabRays::FloatComponent& from, float* to) {
      std::copy_n(from.data() + first, packetRays, to);
    };
    copy(tile.rays.unitOrigin[0], rays.org_x);
    copy(tile.rays.unitOrigin[1], rays.org_y);
    copy(tile.rays.unitOrigin[2], rays.org_z);
    copy(tile.rays.unitDirection[0], rays.dir_x);
    copy(tile.rays.unitDirection[1], rays.dir_y);
    copy(tile.rays.unitDirection[2], rays.dir_z);
    std::fill_n(rays.tnear, packetRays, 0.f);
    std::fill_n(rays.tfar, packetRays, 1.f + UnitBox::rounding);
    std::fill_n(rays.time, packetRays, 0.f);
    std::fill_n(rays.mask, packetRays, 0xffffffffu);
    std::fill_n(rays.flags, packetRays, 0u);
    std::iota(rays.id, rays.id + packetRays, static_cast<unsigned>(first));
  }

  /// Calls body(valid, first) for packets of a tile's rays.
  template <class Body>
  static void forPackets(const RayTile& tile, const Body& body)
  {
    for (int first = 0; first < tile.count; first += packetRays)
    {
      alignas(64) int valid[packetRays];
      for (int i = 0; i < packetRays; ++i)
      {
        valid[i] = first + i < tile.count ? -1 : 0;
      }
      body(valid, first);
    }
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
  if (self.scene && blocks.areMuchNarrower(self.computedBefore))
  {
    const auto start = std::chrono::steady_clock::now();
    self.computedBefore = blocks.computedCount();
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

bool SurfaceHierarchy::isEmpty() const noexcept
{
  return !impl_->scene;
}

void SurfaceHierarchy::intersect(const RayPart& part, RayHits& hits) const
{
  RTCRayHit ray;
  if (impl_->find(part, ray.ray))
  {
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    Query query(part, hits);
    embree::intersect(impl_->scene, query.context, ray);
    query.rethrow();
  }
}

void SurfaceHierarchy::occluded(const RayPart& part, RayHits& hits) const
{
  RTCRay ray;
  if (impl_->find(part, ray))
  {
    Query query(part, hits);
    embree::occluded(impl_->scene, query.context, ray);
    query.rethrow();
  }
}

void SurfaceHierarchy::intersect(RayTile& tile) const
{
  Query query(tile);
  Impl::forPackets(tile, [&](const int* valid, int first) {
    RTCRayHit16 packet;
    Impl::fill(tile, first, packet.ray);
    std::fill_n(packet.hit.geomID, packetRays, RTC_INVALID_GEOMETRY_ID);
    embree::intersect(impl_->scene, query.context, valid, packet);
    query.rethrow();
  });
}

} // namespace treeamr

// Every allocation of a small scene fails once, those included that Embree announces: what allocates must throw and
// nothing else, lose no memory, and give the right result the next time. On one thread, where allocations come in one
// order, and on all.
#include "Contour/Contour.h"
#include "Error.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"
#include "Surface/EmbreeVersions.h"
#include "Surface/SecondaryRays.h"
#include "Volume/Volume.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <vector>

namespace
{

std::atomic<long> untilFailure{ 0 }; // the allocation that makes it 0 fails
std::atomic<bool> failed{ false };
std::atomic<long> blocks{ 0 }; // allocated by new and not deleted

bool mayAllocate() noexcept
{
  if (untilFailure.load(std::memory_order_relaxed) > 0 && --untilFailure == 0)
  {
    failed = true;
    return false;
  }
  return true;
}

void* allocate(std::size_t size, std::size_t alignment) noexcept
{
  if (!mayAllocate())
  {
    return nullptr;
  }
  // A multiple of the alignment, as the C standard asks.
  void* const pointer = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  blocks += pointer != nullptr;
  return pointer;
}

void* allocateOrThrow(std::size_t size, std::size_t alignment)
{
  if (void* const pointer = allocate(size, alignment))
  {
    return pointer;
  }
  throw std::bad_alloc();
}

void release(void* pointer) noexcept
{
  blocks -= pointer != nullptr;
  std::free(pointer);
}

} // namespace

// The forms for arrays call these.
void* operator new(std::size_t size)
{
  return allocateOrThrow(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
  return allocateOrThrow(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
  return allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept
{
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* pointer) noexcept
{
  release(pointer);
}
void operator delete(void* pointer, std::size_t) noexcept
{
  release(pointer);
}
void operator delete(void* pointer, std::align_val_t) noexcept
{
  release(pointer);
}
void operator delete(void* pointer, std::size_t, std::align_val_t) noexcept
{
  release(pointer);
}

// What Embree allocates its hierarchies with.
extern "C" int posix_memalign(void** pointer, std::size_t alignment, std::size_t size) noexcept
{
  if (!mayAllocate())
  {
    return ENOMEM;
  }
  *pointer = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  return *pointer ? 0 : ENOMEM;
}

namespace
{

bool deviceFails = false;
std::atomic<long> untilShortage{ 0 }; // as untilFailure, for what Embree announces to its memory monitor
RTCMemoryMonitorFunction monitor = nullptr;

template <class Function>
Function* embrees(const char* name)
{
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

struct NoFailure
{
  long rest = untilFailure.exchange(0);
  ~NoFailure() { untilFailure = rest; }
};

bool monitorShortOfMemory(void* user, ssize_t bytes, bool post)
{
  const bool isShort = bytes > 0 && untilShortage > 0 && --untilShortage == 0;
  const NoFailure guard; // but one
  untilFailure = isShort ? 1 : 0;
  return monitor(user, bytes, post);
}

} // namespace

// In front of Embree's. Version 3.13 loses memory or crashes when an allocation fails within these that it has not
// announced to its monitor, or that the monitor has allowed.
extern "C" RTCDevice rtcNewDevice(const char* config)
{
  const NoFailure guard;
  return deviceFails ? nullptr : embrees<decltype(rtcNewDevice)>("rtcNewDevice")(config);
}
extern "C" RTCScene rtcNewScene(RTCDevice device)
{
  const NoFailure guard;
  return embrees<decltype(rtcNewScene)>("rtcNewScene")(device);
}
extern "C" void rtcCommitScene(RTCScene scene)
{
  const NoFailure guard;
  embrees<decltype(rtcCommitScene)>("rtcCommitScene")(scene);
}
extern "C" RTCError rtcGetDeviceError(RTCDevice device)
{
  const NoFailure guard;
  return embrees<decltype(rtcGetDeviceError)>("rtcGetDeviceError")(device);
}
extern "C" void rtcSetDeviceMemoryMonitorFunction(
  RTCDevice device, RTCMemoryMonitorFunction function, void* user)
{
  monitor = function;
  embrees<decltype(rtcSetDeviceMemoryMonitorFunction)>("rtcSetDeviceMemoryMonitorFunction")(
    device, monitorShortOfMemory, user);
}

namespace treeamr::test
{

namespace
{

/// Numbers that tell two results apart.
using Result = std::vector<double>;
using Work = std::function<Result()>;

class AllocationFailureTest : public ::testing::Test
{
protected:
  AllocationFailureTest()
  {
    RandomTree options;
    options.roots = { 2, 1, 2 };
    options.levels = 3;
    options.missing = 0.1;
    cells_ = makeRandomTree(options);
    setValues(cells_, [](const std::array<double, 3>& p) { return p[0] + 0.5 * p[1] * p[2]; });
    field_ = makeField(grid_, cells_);
  }

  /// After each failure the same work must succeed with the same result.
  void expectRecovery(const Work& work)
  {
    {
      const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
      failOneByOne(work, untilFailure, 0);
    }
    // Which allocation is the n-th is a matter of chance then, and TBB's threads keep some of what they allocate.
    failOneByOne(work, untilFailure, std::numeric_limits<long>::max());
  }

  const RootGrid grid_ = unitRoots({ 2, 1, 2 });
  const Camera camera_{ multiply(perspective(50., 0.5, 10.), lookAt({ 3., 2., 4. }, { 1., 0.5, 1. })),
    identityMatrix, 40, 30 };
  std::vector<LeafCell> cells_;
  std::shared_ptr<const Field> field_;
  const Work makeSurface_ = [this] {
    const Isosurface surface(field_, { 0.8, 1.1 });
    const IsosurfaceStatistics statistics = surface.statistics();
    return Result{ static_cast<double>(surface.octantCount()), static_cast<double>(statistics.blocks) };
  };

  static void failOneByOne(const Work& work, std::atomic<long>& countdown, long lostBlocks)
  {
    const Result expected = work();
    ASSERT_EQ(work(), expected);
    int thrown = 0;
    for (long n = 1;; ++n)
    {
      const long before = blocks;
      failed = false;
      countdown = n;
      bool threw = false;
      try
      {
        const Result found = work();
        countdown = 0;
        ASSERT_EQ(found, expected) << "without allocation " << n;
      }
      catch (const std::bad_alloc&)
      {
        threw = true;
      }
      catch (const Error&)
      {
        threw = true;
      }
      countdown = 0;
      if (!failed)
      {
        ASSERT_FALSE(threw);
        break;
      }
      thrown += threw;
      ASSERT_LE(blocks - before, lostBlocks) << "after the failure of allocation " << n;
      ASSERT_EQ(work(), expected) << "after the failure of allocation " << n;
    }
    EXPECT_GT(thrown, 0);
  }
};

void append(Result& result, const HitImage& image)
{
  for (const std::size_t first : image.first)
  {
    result.push_back(static_cast<double>(first));
  }
  for (const SurfaceHit& hit : image.hits)
  {
    result.insert(result.end(),
      { hit.t, hit.gradient[0], hit.gradient[1], hit.gradient[2], static_cast<double>(hit.surface) });
  }
}

} // namespace

TEST_F(AllocationFailureTest, octreeAndField)
{
  expectRecovery([&] {
    const std::shared_ptr<const Field> field = makeField(grid_, cells_);
    Result result;
    for (std::uint64_t i = 0; i < field->octree().leafCount(); ++i)
    {
      result.push_back(field->value({ NodeKind::Leaf, 0, i }));
    }
    return result;
  });
}

TEST_F(AllocationFailureTest, isosurfaceFromTheStart)
{
  expectRecovery(makeSurface_);
}

TEST_F(AllocationFailureTest, noMemoryForEmbreesHierarchy)
{
  const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
  failOneByOne(makeSurface_, untilShortage, 0);
}

TEST_F(AllocationFailureTest, noDeviceOfEmbree)
{
  {
    const Isosurface nowhere(field_, { 100. }); // has none and needs none
  }
  deviceFails = true;
  try
  {
    makeSurface_();
    ADD_FAILURE();
  }
  catch (const Error& error)
  {
    EXPECT_STREQ(error.what(), "isosurface: Embree made no device, error 0");
  }
  deviceFails = false;
  EXPECT_GT(makeSurface_()[0], 0.);
}

// Values are computed where rays come: in callbacks of Embree.
TEST_F(AllocationFailureTest, isosurfaceThatKeepsNothing)
{
  const Isosurface surface(field_, { 0.8, 1.1 }, 0);
  for (const SurfaceLayers layers : { SurfaceLayers::Nearest, SurfaceLayers::All })
  {
    expectRecovery([&] {
      HitImage image;
      surface.render(camera_, layers, image);
      Result result;
      append(result, image);
      return result;
    });
  }
}

TEST_F(AllocationFailureTest, raysOfAnIsosurface)
{
  const Isosurface surface(field_, { 0.8, 1.1 });
  HitImage image;
  surface.render(camera_, SurfaceLayers::All, image);
  ASSERT_GT(image.hits.size(), 200u);
  expectRecovery([&] {
    Result result;
    std::vector<SurfaceHit> hits;
    surface.intersectAll(camera_.ray(20, 15), 0., 100., hits);
    for (const SurfaceHit& hit : hits)
    {
      result.push_back(hit.t);
    }
    return result;
  });
  expectRecovery([&] {
    std::vector<std::uint16_t> open(image.hits.size());
    traceAmbientOcclusion(surface, camera_, image, 0.5, 0, 4, open);
    return Result(open.begin(), open.end());
  });
}

TEST_F(AllocationFailureTest, contour)
{
  expectRecovery([&] {
    ContourOptions options;
    options.gradients = true;
    const ContourMesh mesh = treeamr::contour(*field_, 0.9, options);
    const std::vector<float> values = interpolate(*field_, mesh);
    Result result(values.begin(), values.end());
    for (const auto& triangle : mesh.triangles)
    {
      result.insert(result.end(), triangle.begin(), triangle.end());
    }
    return result;
  });
}

TEST_F(AllocationFailureTest, volume)
{
  std::vector<TransferFunction::Entry> entries(64);
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    entries[i] = { 0.5f, 0.01f * static_cast<float>(i), 1.f, 0.1f * static_cast<float>(i % 7) };
  }
  const TransferFunction colors(0., 2., entries);
  const Isosurface surface(field_, { 0.8, 1.1 });
  HitImage hits;
  surface.render(camera_, SurfaceLayers::All, hits);
  std::vector<TranslucentHit> translucent;
  for (const SurfaceHit& hit : hits.hits)
  {
    translucent.push_back({ hit.t, { 0.1f, 0.7f, 0.2f, 0.3f } });
  }
  RayStops surfaces;
  surfaces.hits = { hits.first, translucent };
  const auto draw = [&](Volume& volume, double levelOfDetail) {
    VolumeSettings settings;
    settings.levelOfDetailPixels = levelOfDetail;
    Image image(camera_.width(), camera_.height());
    volume.render({ camera_, surfaces }, settings, image);
    return Result(image.rgba.begin(), image.rgba.end());
  };
  expectRecovery([&] {
    Volume volume(field_, colors);
    return draw(volume, 0.);
  });
  // One from frame to frame, as a mapper has it.
  Volume volume(field_, colors);
  expectRecovery([&] { return draw(volume, 4.); });
}

} // namespace treeamr::test

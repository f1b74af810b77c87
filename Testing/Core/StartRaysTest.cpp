// The vectorised rays of packets of pixels, against Camera::ray(), TraceSpace::start() and toUnitCube() on every
// instruction set: equal to the bit.
#include "Support/Cameras.h"
#include "Support/Targets.h"
#include "Surface/Kernel/SurfaceKernel.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <memory>
#include <string>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 37;
constexpr int height = 23;

struct View
{
  std::string name;
  Camera camera;
};

Matrix4 scaling(double x, double y, double z)
{
  return { x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1 };
}

/// Looking at the box from 0 to 3, 2, 1.
std::vector<View> views()
{
  const Vec3 middle{ 1.5, 1., 0.5 };
  const auto view = [](const std::string& name, const Matrix4& projection, const Matrix4& look,
                      const Matrix4& world = identityMatrix) {
    return View{ name, Camera(multiply(projection, multiply(look, world)), world, width, height) };
  };
  const Matrix4 wide = perspective(60., 0.1, 20.);
  const Matrix4 fromAside = lookAt({ 4.1, 3.3, 5.2 }, middle);
  return { view("perspective", wide, fromAside),
    view("seen partly", perspective(20., 6., 7.), lookAt({ 4.1, 3.3, 5.2 }, { 0., 0., 0. })),
    view("from inside", wide, lookAt({ 0.3, 0.4, 0.6 }, { 3., 1.7, 0.2 })),
    view("off axis", { 1.4, 0, 0.6, 0, 0, 1.4, -0.3, 0, 0, 0, -1.01, -0.2, 0, 0, -1, 0 }, fromAside),
    view("far away", perspective(1e-7, 1e9, 3e9), lookAt({ 1e9, 1.2e9, 8e8 }, middle)),
    view("too far away", perspective(1e-13, 1e15, 3e15), lookAt({ 1e15, 1.2e15, 8e14 }, middle)),
    view("parallel", parallel(2., 0.1, 20.), fromAside),
    view("parallel to faces", parallel(1.15, 1., 20.), lookAt({ 1.5, 1., 9. }, middle, { 0., 1., 0. })),
    view("perspective along faces", wide, lookAt({ 3., 2., 9. }, { 3., 2., 0. }, { 0., 1., 0. })),
    view("mirrored", wide, fromAside, scaling(-1., 1.5, 0.25)),
    view("parallel, mirrored", parallel(2., 0.1, 20.), fromAside, scaling(1., 1., -3.)) };
}

std::vector<RootGrid> grids()
{
  return { RootGrid::uniform({ 3, 2, 1 }, { 0., 0., 0. }, { 1., 1., 1. }),
    RootGrid::uniform({ 2, 2, 2 }, { -1., 0.25, 0.1 }, { 1.7, 0.3, 0.9 }),
    RootGrid({ std::vector<double>{ 0., 1.3, 3. }, { -0.2, 0.4, 2. }, { 0., 1. } }) };
}

/// What is found of a ray.
struct Found
{
  RayPart part;
  std::array<float, 3> unitOrigin;
  std::array<float, 3> unitDirection;
};

std::vector<std::uint64_t> bitsOf(const Found& ray)
{
  std::vector<std::uint64_t> bits;
  for (int a = 0; a < 3; ++a)
  {
    for (const double x : { ray.part.ray.origin[a], ray.part.ray.direction[a], ray.part.ray.inverse[a] })
    {
      bits.push_back(std::bit_cast<std::uint64_t>(x));
    }
    bits.push_back(std::bit_cast<std::uint32_t>(ray.unitOrigin[a]));
    bits.push_back(std::bit_cast<std::uint32_t>(ray.unitDirection[a]));
  }
  for (const double x : { ray.part.tEnter, ray.part.tLeave, ray.part.rounding })
  {
    bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return bits;
}

Found foundOf(const SlabRays& rays, int i)
{
  Found found{ rays.at(i), {}, {} };
  for (int a = 0; a < 3; ++a)
  {
    found.unitOrigin[a] = rays.unitOrigin[a][i];
    found.unitDirection[a] = rays.unitDirection[a][i];
  }
  return found;
}

} // namespace

TEST(StartRays, AreTheRaysOfTheCameraInTheDomainToTheBit)
{
  int started = 0;
  int missed = 0;
  forEachTarget([&](const char* target) {
    for (const RootGrid& grid : grids())
    {
      const TraceSpace space(grid);
      for (const auto& [name, camera] : views())
      {
        for (const bool isCut : { false, true })
        {
          SCOPED_TRACE(name + (isCut ? ", cut" : "") + " on " + target);
          const auto rays = std::make_unique<SlabRays>();
          for (int y = 0; y < height; y += PixelRays::edge)
          {
            int count = 0; // rays of a row follow each other
            std::vector<Found> expected;
            for (int x = 0; x < width; x += PixelRays::edge)
            {
              PixelRays pixels;
              castRays(camera, isCut, x, y, pixels);
              // Not all are asked about.
              const std::uint32_t wanted = 0xffff & ~(1u << x % 16);
              std::uint32_t expectedBits = 0;
              for (int p = 0; p < PixelRays::most; ++p)
              {
                const Ray ray = camera.ray(x + p % PixelRays::edge, y + p / PixelRays::edge);
                const double begin = isCut ? camera.tFromDepth(ray, 0.) : 0.;
                const double end =
                  isCut ? camera.tFromDepth(ray, 1.) : std::numeric_limits<double>::infinity();
                ASSERT_EQ(pixels.at(p).origin, ray.origin);
                ASSERT_EQ(pixels.at(p).direction, ray.direction);
                ASSERT_EQ(pixels.begin[p], begin);
                ASSERT_EQ(pixels.end[p], end);
                Found found;
                if (wanted >> p & 1 && space.start(ray, begin, end, found.part) &&
                  space.toUnitCube(found.part, found.unitOrigin, found.unitDirection))
                {
                  expected.push_back(found);
                  expectedBits |= 1u << p;
                }
              }
              ASSERT_EQ(startRays(space, pixels, wanted, count, *rays), expectedBits);
              count = static_cast<int>(expected.size());
              started += std::popcount(expectedBits);
              missed += PixelRays::most - std::popcount(expectedBits);
            }
            for (int i = 0; i < count; ++i)
            {
              ASSERT_EQ(bitsOf(foundOf(*rays, i)), bitsOf(expected[i])) << "ray " << i << " of row " << y;
            }
          }
        }
      }
    }
  });
  EXPECT_GT(started, 10000);
  EXPECT_GT(missed, 10000);
}

TEST(StartRays, OfNumbersThatAreNoneStartNowhere)
{
  const RootGrid grid = RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. });
  const TraceSpace space(grid);
  forEachTarget([&](const char* target) {
    PixelRays rays;
    for (auto* component : { &rays.origin, &rays.direction })
    {
      for (auto& numbers : *component)
      {
        numbers.fill(std::numeric_limits<double>::quiet_NaN());
      }
    }
    rays.begin.fill(0.);
    rays.end.fill(1.);
    const auto found = std::make_unique<SlabRays>();
    EXPECT_EQ(startRays(space, rays, 0xffff, 0, *found), 0u) << target;
  });
}

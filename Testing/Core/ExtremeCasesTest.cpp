// Extreme values, trees and domains, for the volume renderer and the isosurface, against the
// reconstruction in extended precision along each ray. Each case records what it measured.
#include "Error.h"
#include "Interpolation/Sampler.h"
#include "Support/ExactScene.h"
#include "Support/Measured.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Two roots along each axis. The first is refined to a depth towards the point where all eight meet, the others are
/// single cells: across their faces, edges and corners levels differ by the depth.
std::vector<LeafCell> cornerTree(int depth, std::uint32_t seed = 1)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1.f, 1.f);
  std::vector<LeafCell> cells;
  for (int o = 1; o < 8; ++o)
  {
    cells.push_back({ { { o & 1, o >> 1 & 1, o >> 2 }, 0 }, value(random) });
  }
  for (int level = 1; level <= depth; ++level)
  {
    const Coord last = (Coord(1) << level) - 1;
    for (int o = 0; o < (level == depth ? 8 : 7); ++o)
    {
      cells.push_back(
        { { { last - 1 + (o & 1), last - 1 + (o >> 1 & 1), last - 1 + (o >> 2) }, level }, value(random) });
    }
  }
  return cells;
}

/// Looks at the deepest cell of a corner tree, which fills the picture: by an eye near it, by parallel rays, by a
/// narrow angle from outside.
std::vector<Camera> zooms(int depth)
{
  const double width = std::ldexp(1., -depth);
  const Vec3 middle{ 1. - 0.5 * width, 1. - 0.5 * width, 1. - 0.5 * width };
  const auto away = [&](double distance) {
    return Vec3{ middle[0] - 0.8 * distance, middle[1] - 0.5 * distance, middle[2] - 0.4 * distance };
  };
  const auto camera = [](const Matrix4& projection, const Matrix4& view) {
    return Camera(multiply(projection, view), identityMatrix, 9, 7);
  };
  return { camera(perspective(40., 0.01 * width, 8. * width), lookAt(away(2. * width), middle)),
    camera(parallel(0.7 * width, 0.5 * width, 8. * width), lookAt(away(2. * width), middle)),
    camera(perspective(std::atan(0.2 * width) * 360. / std::numbers::pi, 3., 3. + 8. * width),
      lookAt(away(3. + 2. * width), middle)) };
}

} // namespace

// Values

TEST(ExtremeCases, VolumeOfValuesFrom1em40To1e38)
{
  // Values of a few digits, so that denormal numbers hold them.
  auto cells = randomCells();
  for (LeafCell& c : cells)
  {
    c.value = std::round(128.f * c.value) / 128.f;
  }
  double largest = 0.;
  for (const int exponent : { -133, -126, -110, -100, -60, 0, 60, 100, 126 })
  {
    auto scaled = cells;
    for (LeafCell& c : scaled)
    {
      c.value = std::ldexp(c.value, exponent);
    }
    ExactScene scene({ 2, 2, 2 }, scaled);
    largest = std::max(largest, scene.volumeError(smooth(10., std::ldexp(1., exponent)), outside()));
    EXPECT_GT(scene.brightest(), 0.8);
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

// Beside a value of 1e30, in the view of any decade below it.
TEST(ExtremeCases, VolumeOfSixtyDecades)
{
  std::vector<TransferFunction::Node> nodes;
  for (int i = 0; i <= 1800; ++i)
  {
    const double decade = -30. + i / 30.;
    const auto wave = [&](double perDecade) {
      return static_cast<float>(0.5 + 0.4 * std::sin(perDecade * decade));
    };
    const TransferFunction::Entry entry{ wave(2.1), wave(1.3), wave(0.7), wave(1.9) };
    nodes.push_back({ std::pow(10., decade), entry, entry });
  }
  const auto function = TransferFunction::ofNodes(std::move(nodes));
  const Vec3 middle{ 0.3, 0.5, 0.5 };
  const Camera camera(
    multiply(parallel(0.12, 1., 20.), lookAt({ middle[0], middle[1], 5. }, middle)), identityMatrix, 16, 8);
  double largest = 0.;
  for (const int decade : { -30, -29, -28, -27, -26, -20, -10, 0, 10, 20, 28 })
  {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> decades(decade + 0.05, decade + 1.25);
    std::vector<LeafCell> cells;
    for (int x = 0; x < 8; ++x)
    {
      for (int yz = 0; yz < 4; ++yz)
      {
        const double value = x == 7 ? 1e30 : std::pow(10., decades(random));
        cells.push_back({ { { x, yz & 1, yz >> 1 }, 0 }, static_cast<float>(value) });
      }
    }
    ExactScene scene({ 8, 2, 2 }, cells);
    largest = std::max(largest, scene.volumeError(function, camera));
    EXPECT_GT(scene.brightest(), 0.3);
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceOfValuesFrom1em40To1e38)
{
  auto cells = randomCells();
  for (LeafCell& c : cells)
  {
    c.value = std::round(128.f * c.value) / 128.f;
  }
  double largest = 0.;
  for (const int exponent : { -133, -126, -100, 0, 100, 126 })
  {
    auto scaled = cells;
    for (LeafCell& c : scaled)
    {
      c.value = std::ldexp(c.value, exponent);
    }
    ExactScene scene({ 2, 2, 2 }, scaled);
    largest =
      std::max(largest, scene.surfaceError(std::ldexp(0.2501, exponent), outside(), std::ldexp(1., -4)));
    EXPECT_GT(scene.hits(), 100u);
  }
  expectAtMost(largest, 1e-3, "of a cell's width");
}

namespace
{

/// Of values from 0 to 8, but for a few small cells.
std::vector<LeafCell> cellsWith(float other)
{
  auto cells = randomCells();
  std::size_t small = 0;
  for (LeafCell& c : cells)
  {
    c.value = c.cell.level == 4 && small++ % 300 == 7 ? other : 4.f + 4.f * c.value;
  }
  return cells;
}

} // namespace

TEST(ExtremeCases, VolumeBesideHugeValues)
{
  // At seams to them the field jumps.
  double largest = 0.;
  const TransferFunction colors(0., 8., smooth(5.).entries());
  for (const float huge : { -1e30f, 1e30f, -1e20f, -1e9f, 3e37f })
  {
    ExactScene scene({ 2, 2, 2 }, cellsWith(huge));
    largest = std::max(largest, scene.volumeError(colors, outside()));
    EXPECT_GT(scene.brightest(), 0.8);
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, VolumeWhoseTableIsAStep)
{
  // All of it between a number and the next, or as narrow as numbers go.
  double largest = 0.;
  std::vector<TransferFunction::Entry> entries(100, { 0.f, 1.f, 0.5f, 0.f });
  entries.back() = { 1.f, 0.f, 0.5f, 2.f };
  for (const double end : { 1e-20, 1e-26, 1e-29, 1e-45, 1e-300, 5e-324, std::nextafter(0.25, 1.) })
  {
    ExactScene scene({ 2, 2, 2 }, randomCells());
    const TransferFunction step(end > 0.1 ? 0.25 : 0., end, entries);
    largest = std::max(largest, scene.volumeError(step, outside()));
    EXPECT_GT(scene.brightest(), 0.5);
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceBesideHugeValues)
{
  // No pixel in the middle: its ray would meet the vertex that the camera looks at.
  double largest = 0.;
  for (const float huge : { -1e30f, 1e30f, -1e20f, 1e9f, -1e6f, 3e37f })
  {
    ExactScene scene({ 2, 2, 2 }, cellsWith(huge));
    largest = std::max(largest, scene.surfaceError(4.1, outside(38, 32), std::ldexp(1., -4)));
    EXPECT_GT(scene.hits(), 1000u);
  }
  expectAtMost(largest, 1e-5, "of a cell's width");
}

TEST(ExtremeCases, VolumeWhereHugeNumbersChangeSign)
{
  auto cells = randomCells();
  for (LeafCell& c : cells)
  {
    c.value = c.value < 0.f ? -3e38f : 3e38f;
  }
  ExactScene scene({ 2, 2, 2 }, cells);
  const double error = scene.volumeError(smooth(10., 3e38), outside());
  EXPECT_GT(scene.brightest(), 0.8);
  expectAtMost(error, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceWhereHugeNumbersChangeSign)
{
  auto cells = randomCells();
  for (LeafCell& c : cells)
  {
    c.value = c.value < 0.f ? -3e38f : 3e38f;
  }
  ExactScene scene({ 2, 2, 2 }, cells);
  const double error = scene.surfaceError(1e37, outside(), std::ldexp(1., -4));
  EXPECT_GT(scene.hits(), 100u);
  expectAtMost(error, 1e-6, "of a cell's width");
}

TEST(ExtremeCases, VolumeOfAConstant)
{
  // At either end of the table, beyond it, far away from it.
  std::vector<TransferFunction::Entry> ends{ { 1.f, 0.f, 0.5f, 0.2f }, { 0.f, 1.f, 0.5f, 1.f } };
  double largest = 0.;
  for (const float value : { 0.f, 1.f, -1.f, 1e-45f, 1e-38f, 1e38f, -3.4e38f })
  {
    auto cells = randomCells();
    for (LeafCell& c : cells)
    {
      c.value = value;
    }
    ExactScene scene({ 2, 2, 2 }, cells);
    for (const double scale : { 1e-30, 1., 1e38 })
    {
      largest = std::max(largest, scene.volumeError(TransferFunction(-scale, scale, ends), outside()));
    }
    EXPECT_GT(scene.brightest(), 0.3);
  }
  // The nearest of 4096 entries.
  expectAtMost(largest, 2e-4, "of a channel");
}

TEST(ExtremeCases, CellsThatAreNotFiniteAreRefusedAndLeftOutWithoutATrace)
{
  // What reads data leaves them out; the field would not take them. The neighbours are those of missing cells.
  auto cells = randomCells();
  const float notFinite[]{ NAN, INFINITY, -INFINITY };
  for (std::size_t i = 0; i < cells.size(); i += 7)
  {
    cells[i].value = notFinite[i % 3];
  }
  try
  {
    makeField(unitRoots({ 2, 2, 2 }), cells);
    ADD_FAILURE() << "no error";
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find("is not finite"), std::string::npos) << error.what();
  }
  std::erase_if(cells, [](const LeafCell& c) { return !std::isfinite(c.value); });
  ExactScene scene({ 2, 2, 2 }, cells);
  const double error = scene.volumeError(smooth(10.), outside());
  EXPECT_GT(scene.brightest(), 0.8);
  const double surfaceError = scene.surfaceError(0.1, outside(), std::ldexp(1., -4));
  EXPECT_GT(scene.hits(), 100u);
  EXPECT_LE(surfaceError, 1e-5);
  expectAtMost(error, halfAStep, "of a channel");
}

// Trees

TEST(ExtremeCases, ValuesAcrossLevelJumpsUpToNineteen)
{
  double largest = 0.;
  for (int depth = 1; depth <= 19; ++depth)
  {
    const auto cells = cornerTree(depth);
    const BruteForceGTI truth({ 2, 2, 2 }, cells);
    const auto sampler = Sampler::create(InterpolationMethod::GTI, makeField(unitRoots({ 2, 2, 2 }), cells));
    std::mt19937 random(depth);
    std::uniform_real_distribution<double> uniform(-1., 1.);
    for (int i = 0; i < 400; ++i)
    {
      const double reach = std::ldexp(1., -(i % (depth + 2)));
      const Vec3 p{ 1. + reach * uniform(random), 1. + reach * uniform(random),
        1. + reach * uniform(random) };
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(p, sample));
      largest = std::max(largest, std::abs(sample.value - truth.value(p).value()));
    }
  }
  expectAtMost(largest, 1e-6, "of half the range");
}

TEST(ExtremeCases, VolumeZoomedToTheDeepestCellFrom1To19)
{
  double largest = 0.;
  for (int depth = 1; depth <= 19; ++depth)
  {
    ExactScene scene({ 2, 2, 2 }, cornerTree(depth));
    const TransferFunction transferFunction = smooth(std::ldexp(2., depth));
    for (const Camera& camera : zooms(depth))
    {
      largest = std::max(largest, scene.volumeError(transferFunction, camera));
    }
    EXPECT_GT(scene.brightest(), 0.5) << depth;
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceZoomedToTheDeepestCellFrom1To19)
{
  double largest = 0.;
  for (int depth = 1; depth <= 19; ++depth)
  {
    ExactScene scene({ 2, 2, 2 }, cornerTree(depth, 3));
    for (const Camera& camera : zooms(depth))
    {
      largest = std::max(largest, scene.surfaceError(0.1, camera, std::ldexp(1., -depth)));
    }
    EXPECT_GT(scene.hits(), 5u) << depth;
  }
  expectAtMost(largest, 1e-5, "of the deepest cell's width");
}

TEST(ExtremeCases, VolumeOfCells4096To1InOneView)
{
  double largest = 0.;
  ExactScene scene({ 2, 2, 2 }, cornerTree(12));
  for (const double distance : { 4., 1., 0.1, 0.01 })
  {
    const Camera camera(multiply(perspective(40., 1e-3 * distance, 20.),
                          lookAt({ 1. - 0.8 * distance, 1. - 0.5 * distance, 1. - 0.4 * distance },
                            { 1. - 1e-4, 1. - 1e-4, 1. - 1e-4 })),
      identityMatrix, 21, 21);
    largest = std::max(largest, scene.volumeError(smooth(2. / distance), camera));
  }
  EXPECT_GT(scene.brightest(), 0.5);
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceOfCells4096To1InOneView)
{
  double largest = 0.;
  ExactScene scene({ 2, 2, 2 }, cornerTree(12, 3));
  for (const double distance : { 4., 1., 0.1, 0.01 })
  {
    const Camera camera(multiply(perspective(40., 1e-3 * distance, 20.),
                          lookAt({ 1. - 0.8 * distance, 1. - 0.5 * distance, 1. - 0.4 * distance },
                            { 1. - 1e-4, 1. - 1e-4, 1. - 1e-4 })),
      identityMatrix, 21, 21);
    largest = std::max(largest, scene.surfaceError(0.1, camera, std::ldexp(1., -12)));
  }
  EXPECT_GT(scene.hits(), 500u);
  // Means of refined cells have the digits of single precision, across a cell 4096 times as wide.
  expectAtMost(largest, 4096. * 0x1p-24, "of the smallest cell's width");
}

// Domains

namespace
{

struct Domain
{
  double offset;
  double width;
};
const Domain domains[]{ { 0., 1e-30 }, { 0., 1e-20 }, { 0., 1e-12 }, { 0., 1e-6 }, { 0., 1. }, { 0., 1e6 },
  { 0., 1e12 }, { 0., 1e20 }, { 0., 1e30 }, { 1e9, 1. }, { -1e12, 1e3 } };

RootGrid gridOf(const Domain& domain)
{
  const double root = domain.width / 2.;
  return RootGrid::uniform(
    { 2, 2, 2 }, { domain.offset, domain.offset, domain.offset }, { root, root, root });
}

Camera cameraOf(const Domain& domain)
{
  const double w = domain.width;
  const double middle = domain.offset + 0.5 * w;
  return Camera(multiply(perspective(40., 0.1 * w, 10. * w),
                  lookAt({ middle + 1.5 * w, middle + w, middle + 1.25 * w }, { middle, middle, middle })),
    identityMatrix, 13, 11);
}

} // namespace

TEST(ExtremeCases, VolumeInDomains1em30To1e30WideAndFarFromTheOrigin)
{
  double largest = 0.;
  for (const Domain& domain : domains)
  {
    ExactScene scene(gridOf(domain), randomCells());
    largest = std::max(largest, scene.volumeError(smooth(20. / domain.width), cameraOf(domain)));
    EXPECT_GT(scene.brightest(), 0.8);
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceInDomains1em30To1e30WideAndFarFromTheOrigin)
{
  double largest = 0.;
  for (const Domain& domain : domains)
  {
    ExactScene scene(gridOf(domain), randomCells());
    largest = std::max(largest, scene.surfaceError(0.1, cameraOf(domain), std::ldexp(domain.width, -5)));
    EXPECT_GT(scene.hits(), 100u);
  }
  expectAtMost(largest, 1e-4, "of a cell's width");
}

TEST(ExtremeCases, CameraRaysFarFromTheOrigin)
{
  // The middle of the picture is the point that the camera was turned to.
  double largest = 0.;
  for (const Domain& domain : domains)
  {
    const Camera camera = cameraOf(domain);
    const Ray ray = camera.ray(6, 5);
    const double middle = domain.offset + 0.5 * domain.width;
    const Vec3 toMiddle{ middle - ray.origin[0], middle - ray.origin[1], middle - ray.origin[2] };
    const Vec3 beside = cross(toMiddle, ray.direction);
    largest = std::max(largest, std::sqrt(dot(beside, beside)) / domain.width);
  }
  expectAtMost(largest, 1e-3, "of the domain's width");
}

TEST(ExtremeCases, VolumeOfASheet)
{
  // Of a billionth of its width: one cell, and 4 x 4.
  double largest = 0.;
  for (const int roots : { 1, 4 })
  {
    const double width = 2. / roots;
    std::vector<LeafCell> cells;
    for (int i = 0; i < roots * roots; ++i)
    {
      cells.push_back({ { { i % roots, i / roots, 0 }, 0 }, static_cast<float>(std::sin(0.7 + i)) });
    }
    ExactScene scene(RootGrid::uniform({ roots, roots, 1 }, { 0., 0., 0. }, { width, width, 1e-9 }), cells);
    largest = std::max(largest, scene.volumeError(smooth(1e9), outside()));
    EXPECT_GT(scene.brightest(), 0.2);
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceInASheet)
{
  // It runs through the sheet: every ray's hit is the sheet's, to its thickness.
  std::vector<LeafCell> cells;
  for (int i = 0; i < 16; ++i)
  {
    cells.push_back({ { { i % 4, i / 4, 0 }, 0 }, static_cast<float>(std::sin(0.7 + i)) });
  }
  ExactScene scene(RootGrid::uniform({ 4, 4, 1 }, { 0., 0., 0. }, { 0.5, 0.5, 1e-9 }), cells);
  // Along the sheet, where the surface is seen.
  const Camera camera(
    multiply(parallel(4e-10, 0.1, 20.), lookAt({ -3., -2., 5e-10 }, { 1., 1., 5e-10 }, { 0., 0., 1. })),
    identityMatrix, 13, 11);
  const double error = scene.surfaceError(0.1, camera, 0.5);
  EXPECT_GT(scene.hits(), 100u);
  expectAtMost(error, 1e-5, "of a cell's width");
}

namespace
{

ExactScene needle()
{
  std::vector<LeafCell> cells;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-1.f, 1.f);
  for (int i = 0; i < 10000; ++i)
  {
    cells.push_back({ { { 0, 0, i }, 0 }, value(random) });
  }
  return ExactScene({ 1, 1, 10000 }, cells);
}

/// Of the whole, obliquely; of its middle; along it.
std::vector<Camera> needleCameras()
{
  const auto camera = [](double angle, double near, double far, const Vec3& eye, const Vec3& target) {
    return Camera(multiply(perspective(angle, near, far), lookAt(eye, target)), identityMatrix, 3, 41);
  };
  return { camera(1., 1e3, 1e5, { 3000., 20000., 5000. }, { 0.5, 0.5, 5000. }),
    camera(40., 0.1, 100., { 6., 5., 5004. }, { 0.5, 0.5, 5000.3 }),
    camera(0.02, 1., 1e5, { 0.7, 0.6, -3000. }, { 0.5, 0.5, 5000. }) };
}

} // namespace

TEST(ExtremeCases, VolumeOfTenThousandRootsInARow)
{
  ExactScene scene = needle();
  double largest = 0.;
  for (const Camera& camera : needleCameras())
  {
    largest = std::max(largest, scene.volumeError(smooth(2.), camera));
  }
  EXPECT_GT(scene.brightest(), 0.5);
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceInTenThousandRootsInARow)
{
  ExactScene scene = needle();
  double largest = 0.;
  for (const Camera& camera : needleCameras())
  {
    largest = std::max(largest, scene.surfaceError(0.1, camera, 1.));
  }
  EXPECT_GT(scene.hits(), 100u);
  expectAtMost(largest, 1e-5, "of a cell's width");
}

// The vectorised volume renderer on every instruction set of this machine, against the scalar reference.
#include "Octree/OctreeBuilder.h"
#include "RayTracing/VertexCache.h"
#include "RayTracing/VolumeReference.h"
#include "RayTracing/VolumeRenderer.h"
#include "Support/Cameras.h"
#include "Support/RandomTrees.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstdio>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;

std::shared_ptr<const Field> makeField(const RandomTree& options, const RootGrid& grid)
{
  auto built = buildOctree(grid, makeRandomTree(options));
  auto field = std::make_shared<Field>(built.octree, built.values);
  field->computeNodeRanges();
  return field;
}

std::shared_ptr<const Field> makeField(const RandomTree& options)
{
  return makeField(options, RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }));
}

/// Smooth, and fine enough that reading the nearest entry is as good as interpolating.
TransferFunction smooth()
{
  std::vector<TransferFunction::Entry> entries;
  for (int i = 0; i <= 1 << 16; ++i)
  {
    const float u = static_cast<float>(i) / (1 << 16);
    const float rise = std::max(0.f, u - 0.5f);
    entries.push_back({ u, 1.f - u, 0.5f, 30.f * rise * rise });
  }
  return TransferFunction(-1., 1., entries);
}

struct View
{
  const char* name;
  Matrix4 clip;
};

/// Of a domain of 2 x 2 x 2.
std::vector<View> views()
{
  const Vec3 middle{ 1., 1., 1. };
  return { { "perspective", multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle)) },
    { "inside", multiply(perspective(90., 1e-3, 20.), lookAt({ 1.1, 0.8, 1.3 }, { 0., 0.1, 0.2 })) },
    { "narrow", multiply(perspective(0.3, 900., 1100.), lookAt({ 600., 500., 620. }, middle)) },
    { "parallel", multiply(parallel(1.9, 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle)) },
    { "along an axis",
      multiply(parallel(1.2, 0.1, 20.), { 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1, -5, 0, 0, 0, 1 }) } };
}

/// Calls f for each instruction set that the kernel was compiled for and this machine has.
template <class F>
void forEachTarget(const F& f)
{
  std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  for (; targets != 0; targets &= targets - 1)
  {
    const std::int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    f(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

float largestDifference(const Image& a, const Image& b)
{
  float largest = 0.f;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
  {
    largest = std::max(largest, std::abs(a.rgba[i] - b.rgba[i]));
  }
  return largest;
}

} // namespace

TEST(VolumeKernel, EqualsTheReferenceOnEveryTarget)
{
  const auto field = makeField({ 12, { 2, 2, 2 }, 5, 0.6, 0.1, false });
  const TransferFunction transferFunction = smooth();
  VolumeSettings settings;
  // A ray whose way is a whole number of steps long, but for rounding, may take one more: with many the
  // pictures still agree.
  settings.samplesPerCell = 64.;
  int targets = 0;
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    Image expected(width, height);
    renderVolumeReference(*field, transferFunction, camera, {}, settings, expected);
    float brightest = 0.f;
    for (const float c : expected.rgba)
    {
      brightest = std::max(brightest, c);
    }
    EXPECT_GT(brightest, 0.3f) << view.name;
    forEachTarget([&](const char* target) {
      Image image(width, height);
      renderVolume(*field, transferFunction, camera, {}, settings, image);
      EXPECT_LT(largestDifference(image, expected), 1e-3f) << view.name << " on " << target;
      ++targets;
    });
  }
  EXPECT_GE(targets, 5);
}

TEST(VolumeKernel, TargetsAgree)
{
  const auto field = makeField({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image first(0, 0);
  forEachTarget([&](const char* target) {
    Image image(width, height);
    renderVolume(*field, smooth(), camera, {}, {}, image);
    if (first.width == 0)
    {
      first = image;
    }
    const float difference = largestDifference(image, first);
    std::printf("%s: largest difference %.2g\n", target, difference);
    EXPECT_LT(difference, 1e-4f) << target;
  });
}

TEST(VolumeKernel, SkippingNeverChangesABitOnAnyTarget)
{
  const auto field = makeField({ 31, { 2, 2, 2 }, 5, 0.6, 0.1, false });
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    forEachTarget([&](const char* target) {
      Image with(width, height);
      Image without(width, height);
      VolumeSettings settings;
      const auto skipped = renderVolume(*field, smooth(), camera, {}, settings, with);
      settings.skipEmpty = false;
      const auto all = renderVolume(*field, smooth(), camera, {}, settings, without);
      EXPECT_EQ(with.rgba, without.rgba) << view.name << " on " << target;
      EXPECT_LT(skipped.samples, all.samples);
    });
  }
}

TEST(VolumeKernel, KeptValuesNeverChangeABit)
{
  const auto field = makeField({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  const Camera camera(views().front().clip, identityMatrix, width, height);
  const std::uint64_t leaves = field->octree().leafCount();
  VertexCache none(leaves, 0);
  VertexCache one(leaves, 4 * leaves + 128 * 1024);
  VertexCache all(leaves, VolumeSettings::defaultKeptBytes);
  Image images[]{ { width, height }, { width, height }, { width, height }, { width, height } };
  const auto computed = renderVolume(*field, smooth(), camera, {}, {}, none, images[0]).cells;
  renderVolume(*field, smooth(), camera, {}, {}, one, images[1]);
  const auto first = renderVolume(*field, smooth(), camera, {}, {}, all, images[2]).cells;
  const auto second = renderVolume(*field, smooth(), camera, {}, {}, all, images[3]).cells;
  for (const Image& image : images)
  {
    EXPECT_EQ(image.rgba, images[0].rgba);
  }
  EXPECT_LE(first, computed);
  EXPECT_GT(first, 100u);
  EXPECT_EQ(second, 0u);
  EXPECT_EQ(none.byteSize(), 0u);
  EXPECT_LE(one.byteSize(), 4 * leaves + 128 * 1024 + 1024);
  EXPECT_GE(all.byteSize(), first * sizeof(VertexRecord));
}

TEST(VolumeKernel, KeepsNoMoreThanItsBudgetInAnyFrame)
{
  const auto field = makeField({ 5, { 2, 2, 2 }, 6, 0.7, 0., false });
  const std::uint64_t leaves = field->octree().leafCount();
  ASSERT_GT(leaves, 1100u);
  VertexCache kept(leaves, 4 * leaves + 128 * 1024);
  const std::size_t before = kept.byteSize();
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    Image image(width, height);
    Image expected(width, height);
    renderVolume(*field, smooth(), camera, {}, {}, kept, image);
    renderVolume(*field, smooth(), camera, {}, {}, expected);
    EXPECT_EQ(image.rgba, expected.rgba) << view.name;
    EXPECT_LE(kept.byteSize(), before + 1024 * sizeof(VertexRecord));
  }
}

TEST(VolumeKernel, UnitsAndOffsetsDoNotMatter)
{
  // The same tree a million cell widths from the origin, and 1e-9 and 1e9 wide.
  const RandomTree options{ 12, { 2, 2, 2 }, 5, 0.6, 0., false };
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image expected(width, height);
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  renderVolume(*makeField(options), smooth(), camera, {}, settings, expected);
  for (const double size : { 1e-9, 1., 1e9 })
  {
    const double offset = 1e6 / 32. * size;
    const Matrix4 toUnit{ 1. / size, 0, 0, -offset / size, 0, 1. / size, 0, -offset / size, 0, 0, 1. / size,
      -offset / size, 0, 0, 0, 1 };
    const Camera placed(multiply(views().front().clip, toUnit), toUnit, width, height);
    Image image(width, height);
    renderVolume(
      *makeField(options, RootGrid::uniform({ 2, 2, 2 }, { offset, offset, offset }, { size, size, size })),
      smooth(), placed, {}, settings, image);
    EXPECT_LT(largestDifference(image, expected), 1e-3f) << size;
  }
}

TEST(VolumeKernel, HugeValuesAreRenderedByTheReference)
{
  auto cells = makeRandomTree({ 12, { 1, 1, 1 }, 3, 0.6, 0., false });
  for (LeafCell& c : cells)
  {
    c.value *= 3e38f;
  }
  auto built = buildOctree(RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), cells);
  Field field(built.octree, built.values);
  field.computeNodeRanges();
  const TransferFunction transferFunction(-3e38, 3e38, { { 1.f, 0.f, 0.f, 0.f }, { 0.f, 1.f, 0.f, 5.f } });
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image image(width, height);
  Image expected(width, height);
  renderVolume(field, transferFunction, camera, {}, {}, image);
  renderVolumeReference(field, transferFunction, camera, {}, {}, expected);
  EXPECT_EQ(image.rgba, expected.rgba);
  for (const float c : image.rgba)
  {
    EXPECT_TRUE(std::isfinite(c));
  }
}

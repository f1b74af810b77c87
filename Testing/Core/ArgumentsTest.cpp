// Arguments that do not belong together, or to nothing: each throws Error before anything is allocated for it or read.
#include "Contour/Contour.h"
#include "Error.h"
#include "Interpolation/Sampler.h"
#include "Support/AllocationCounter.h"
#include "Support/Cameras.h"
#include "Support/ExactScene.h"
#include "Surface/OcclusionFilter.h"
#include "Surface/SecondaryRays.h"
#include "Volume/Volume.h"

#include <gtest/gtest.h>

#include <climits>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

std::shared_ptr<Field> wavesIn(const std::shared_ptr<const Octree>& octree, float offset)
{
  std::vector<float> values(octree->leafCount());
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    values[i] = offset + 0.1f * static_cast<float>(i % 7);
  }
  auto field = std::make_shared<Field>(octree, std::move(values));
  return field;
}

std::shared_ptr<const Octree> randomOctree(std::uint32_t seed)
{
  RandomTree options;
  options.seed = seed;
  options.roots = { 2, 2, 2 };
  options.levels = 3;
  return buildOctree(
    RootGrid::uniform(options.roots, { 0., 0., 0. }, { 1., 1., 1. }), makeRandomTree(options))
    .octree;
}

Camera smallCamera()
{
  return Camera(
    multiply(perspective(40., 1., 9.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix, 16, 16);
}

const TransferFunction fog(0., 1., { { 1.f, 1.f, 1.f, 1.f }, { 1.f, 1.f, 1.f, 1.f } });

} // namespace

TEST(Arguments, NumbersOfRootsAreRefusedBeforeTheirPlanesAreMade)
{
  for (const std::array<int, 3>& roots : { std::array{ 2000000000, 1, 1 }, { 1, INT_MAX, 1 },
         { 1, 1, (1 << 24) + 1 }, { 0, 1, 1 }, { 1, -1, 1 }, { 1, 1, INT_MIN } })
  {
    const std::size_t peak = peakBytes([&] {
      EXPECT_THROW(RootGrid::uniform(roots, { 0., 0., 0. }, { 1., 1., 1. }), Error)
        << roots[0] << ' ' << roots[1] << ' ' << roots[2];
    });
    EXPECT_LT(peak, 100000u);
  }
  EXPECT_EQ(RootGrid::uniform({ 1 << 24, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }).paddingDepth(), 24);
}

TEST(Arguments, NullPointersAreRefused)
{
  EXPECT_THROW(Field(nullptr, {}), Error);
  EXPECT_THROW(Field(nullptr, { 1.f }), Error);
  EXPECT_THROW(Isosurface(nullptr, { 0.5 }), Error);
  EXPECT_THROW(Volume(nullptr, fog), Error);
  for (const auto method : { InterpolationMethod::Nearest, InterpolationMethod::GTI })
  {
    EXPECT_THROW(Sampler::create(method, nullptr), Error);
  }
}

TEST(Arguments, AMeshIsInterpolatedOnItsOwnOctree)
{
  const auto octree = randomOctree(1);
  const ContourMesh mesh = contour(*wavesIn(octree, 0.f), 0.3);
  ASSERT_FALSE(mesh.points.empty());
  EXPECT_EQ(interpolate(*wavesIn(octree, 1.f), mesh).size(), mesh.points.size());
  EXPECT_THROW(interpolate(*wavesIn(randomOctree(2), 0.f), mesh), Error);
}

TEST(Arguments, HitsFitTheirPicture)
{
  const Isosurface surface(wavesIn(randomOctree(1), 0.f), { 0.3 });
  const Camera camera = smallCamera();
  HitImage hits;
  surface.render(camera, SurfaceLayers::Nearest, hits);
  ASSERT_FALSE(hits.hits.empty());
  const std::vector<std::uint16_t> open(hits.hits.size());
  std::vector<std::uint16_t> tooFew(hits.hits.size() - 1);
  std::vector<std::uint8_t> lit;
  EXPECT_NO_THROW(filterAmbientOcclusion(camera, hits, open, 1));
  EXPECT_THROW(filterAmbientOcclusion(camera, hits, open, 0), Error);
  EXPECT_THROW(filterAmbientOcclusion(camera, hits, tooFew, 1), Error);
  EXPECT_THROW(traceAmbientOcclusion(surface, camera, hits, 1., 0, 1, tooFew), Error);

  const auto expectRefused = [&](const HitImage& bad) {
    std::vector<std::uint16_t> counts(bad.hits.size());
    EXPECT_THROW(filterAmbientOcclusion(camera, bad, counts, 1), Error);
    EXPECT_THROW(traceAmbientOcclusion(surface, camera, bad, 1., 0, 1, counts), Error);
    EXPECT_THROW(traceShadows(surface, camera, bad, { Light() }, lit), Error);
  };
  HitImage otherSize = hits;
  otherSize.first.pop_back();
  expectRefused(otherSize);
  HitImage lost = hits;
  lost.hits.pop_back();
  expectRefused(lost);
  expectRefused({});
}

TEST(Arguments, ErrorsAreTextWhateverBytesTheyTellOf)
{
  EXPECT_STREQ(Error("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\xb3").what(),
    "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\xb3");
  // Latin-1, cut characters, one that takes too many bytes, half of a pair, one beyond the last.
  EXPECT_STREQ(Error("caf\xe9 x").what(), "caf? x");
  EXPECT_STREQ(Error("cut \xe2\x82").what(), "cut ??");
  EXPECT_STREQ(Error("\xe2\x82x").what(), "??x");
  EXPECT_STREQ(Error("\xc0\xaf").what(), "??");
  EXPECT_STREQ(Error("\xed\xa0\x80").what(), "???");
  EXPECT_STREQ(Error("\xf4\x90\x80\x80 \xff").what(), "???? ?");
}

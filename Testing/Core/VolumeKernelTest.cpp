// The volume kernels, of float and of double lanes, on every instruction set of this machine, against the scalar
// reference.
#include "Error.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/ListSource.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Support/VolumeViews.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;

std::shared_ptr<const Field> randomField(const RandomTree& options)
{
  return makeField(unitRoots(options.roots), makeRandomTree(options));
}

/// Two roots along each axis, waves with empty space between them.
std::shared_ptr<const Field> makeWaves(std::vector<LeafCell> cells)
{
  setValues(cells, [](const auto& p) { return std::sin(3. * p[0] + p[1]) * std::cos(2. * p[2]); });
  return makeField(unitRoots({ 2, 2, 2 }), cells);
}

/// None to six hits along each ray through the domain of 2 x 2 x 2, some at one place, faint to opaque.
PixelHits makeHits(const Camera& camera)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  PixelHits hits;
  for (int y = 0; y < camera.height(); ++y)
  {
    for (int x = 0; x < camera.width(); ++x)
    {
      const Ray ray = camera.ray(x, y);
      const double middle = (1. - ray.origin[0]) * ray.direction[0] +
        (1. - ray.origin[1]) * ray.direction[1] + (1. - ray.origin[2]) * ray.direction[2];
      std::vector<double> ts;
      for (auto i = random() % 7; i > 0; --i)
      {
        ts.push_back(i == 2 && !ts.empty() ? ts.back() : middle + 4. * uniform(random) - 2.);
      }
      std::sort(ts.begin(), ts.end());
      for (const double t : ts)
      {
        const float alpha = uniform(random);
        hits.add(t, { uniform(random), uniform(random), uniform(random), alpha > 0.9f ? 1.f : 0.5f * alpha });
      }
      hits.endPixel();
    }
  }
  return hits;
}

} // namespace

TEST(VolumeKernel, EqualsTheReferenceOnEveryTarget)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0.1, false });
  const TransferFunction transferFunction = smooth();
  VolumeSettings settings;
  // A ray whose way is a whole number of steps long, but for rounding, may take one more: with many the
  // pictures still agree.
  settings.samplesPerCell = 64.;
  int kernels = 0;
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
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      Image image(width, height);
      renderVolume(*field, transferFunction, camera, {}, ofKernel, image);
      EXPECT_LT(largestDifference(image, expected), 1e-3f) << view.name << " on " << kernel;
      ++kernels;
    });
  }
  EXPECT_GE(kernels, 10);
}

TEST(VolumeKernel, EqualsTheReferenceWithSurfacesOnEveryTarget)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0.1, false });
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    const PixelHits hits = makeHits(camera);
    // Some rays with all of their length, some with a part of it, some with none.
    std::vector<float> begin(width * height, 0.f);
    std::vector<float> end(width * height, 1.f);
    for (std::size_t i = 0; i < begin.size(); i += 3)
    {
      const int x = static_cast<int>(i) % width;
      const int y = static_cast<int>(i) / width;
      const Ray ray = camera.ray(x, y);
      const double middle = (1. - ray.origin[0]) * ray.direction[0] +
        (1. - ray.origin[1]) * ray.direction[1] + (1. - ray.origin[2]) * ray.direction[2];
      (i % 2 == 0 ? begin : end)[i] =
        static_cast<float>(i % 5 == 0 ? 0.5 : std::clamp(camera.depthFromT(ray, middle), 0., 1.));
    }
    const RayStops parts = RayStops::depths(begin.data(), end.data());
    const RayStops surfaces = hits.stops(begin.data(), end.data());
    Image expected(width, height);
    Image without(width, height);
    renderVolumeReference(*field, smooth(), camera, surfaces, settings, expected);
    renderVolumeReference(*field, smooth(), camera, parts, settings, without);
    EXPECT_GT(largestDifference(expected, without), 0.5f) << view.name;
    std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      Image image(width, height);
      renderVolume(*field, smooth(), camera, surfaces, ofKernel, image);
      EXPECT_LT(largestDifference(image, expected), 1e-3f) << view.name << " on " << kernel;
      Image& first = firsts[ofKernel.doubles];
      if (first.width == 0)
      {
        first = image;
      }
      EXPECT_EQ(image.rgba, first.rgba) << view.name << " on " << kernel;
    });
  }
}

TEST(VolumeKernel, EveryTargetGivesTheSameBits)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  // Smooth, and with spikes that are integrated.
  std::vector<TransferFunction::Entry> spikes(4096, { 0.9f, 0.5f, 0.1f, 0.f });
  for (std::size_t i = 100; i < spikes.size(); i += 400)
  {
    spikes[i].extinction = 1000.f;
  }
  for (const TransferFunction& transferFunction : { smooth(), TransferFunction(-1., 1., spikes) })
  {
    for (const View& view : views())
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
      int kernels = 0;
      forEachKernel({}, [&](const std::string& kernel, const VolumeSettings& settings) {
        Image image(width, height);
        renderVolume(*field, transferFunction, camera, {}, settings, image);
        Image& first = firsts[settings.doubles];
        if (first.width == 0)
        {
          first = image;
        }
        EXPECT_EQ(image.rgba, first.rgba) << view.name << " on " << kernel;
        ++kernels;
      });
      EXPECT_GE(kernels, 4);
      EXPECT_NE(firsts[0].rgba, firsts[1].rgba) << view.name;
    }
  }
}

TEST(VolumeKernel, SkippingNeverChangesABitOnAnyTarget)
{
  const auto field = makeWaves(makeRandomTree({ 31, { 2, 2, 2 }, 5, 0.6, 0.1, false }));
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    forEachKernel({}, [&](const std::string& kernel, VolumeSettings settings) {
      Image with(width, height);
      Image without(width, height);
      const auto skipped = renderVolume(*field, smooth(), camera, {}, settings, with);
      settings.skipEmpty = false;
      const auto all = renderVolume(*field, smooth(), camera, {}, settings, without);
      EXPECT_EQ(with.rgba, without.rgba) << view.name << " on " << kernel;
      EXPECT_LT(skipped.samples, all.samples);
    });
  }
}

TEST(VolumeKernel, RaysWithoutAPartLeaveTheOthersAlone)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0.1, false });
  std::vector<float> begin(width * height, 0.f);
  for (int y = 0; y < height; y += 3)
  {
    for (int x = 0; x < width; x += 2)
    {
      begin[y * width + x] = 1.f; // the corners of tiles among them
    }
  }
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    Image all(width, height);
    Image some(width, height);
    const std::vector<float> ends(width * height, 1.f);
    const std::vector<float> zero(width * height, 0.f);
    renderVolume(*field, smooth(), camera, RayStops::depths(zero.data(), ends.data()), {}, all);
    const auto statistics =
      renderVolume(*field, smooth(), camera, RayStops::depths(begin.data(), nullptr), {}, some);
    std::uint64_t rays = 0;
    for (std::size_t i = 0; i < begin.size(); ++i)
    {
      rays += begin[i] == 0.f;
      for (int c = 0; c < 4; ++c)
      {
        ASSERT_EQ(some.rgba[4 * i + c], begin[i] == 0.f ? all.rgba[4 * i + c] : 0.f)
          << view.name << ", pixel " << i;
      }
    }
    EXPECT_EQ(statistics.rays, rays);
  }
}

namespace
{

/// Every third group of an image, those on its upper and right border among them; the same picture to the bit.
void expectGroupsOf(const Image& image, const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, const char* name)
{
  constexpr int w = PixelGroup::width;
  std::vector<PixelGroup> groups;
  for (int i = 0, y = 0; y < image.height; y += w)
  {
    for (int x = 0; x < image.width; x += w, ++i)
    {
      if (i % 3 == 0)
      {
        groups.push_back({ x, y });
      }
    }
  }
  std::vector<float> rgba(groups.size() * PixelGroup::rgbaSize, -1.f);
  volumeOf(field, transferFunction, 0).renderGroups({ camera, stops }, settings, groups, rgba);
  int beyond = 0;
  for (std::size_t i = 0; i < rgba.size(); ++i)
  {
    const PixelGroup& group = groups[i / PixelGroup::rgbaSize];
    const auto inGroup = static_cast<int>(i % PixelGroup::rgbaSize);
    const int x = group.x + inGroup / 4 % w;
    const int y = group.y + inGroup / 4 / w;
    const bool inside = x < image.width && y < image.height;
    beyond += !inside;
    ASSERT_EQ(rgba[i], inside ? image.rgba[4 * (static_cast<std::size_t>(y) * image.width + x) + i % 4] : 0.f)
      << name << ", pixel " << x << ", " << y;
  }
  EXPECT_GT(beyond, 0) << name;
}

} // namespace

TEST(VolumeKernel, GroupsHaveTheBitsOfTheFrame)
{
  const RandomTree options{ 12, { 2, 2, 2 }, 5, 0.6, 0., false };
  const auto field = randomField(options);
  std::vector<LeafCell> huge = makeRandomTree(options);
  for (LeafCell& cell : huge)
  {
    cell.value *= 3e38f;
  }
  const auto hugeField = makeField(unitRoots(options.roots), huge);
  const TransferFunction ofHuge(-3e38, 3e38, { { 1.f, 0.f, 0.f, 0.f }, { 0.f, 1.f, 0.f, 5.f } });
  std::vector<float> end(width * height, 1.f);
  for (std::size_t i = 0; i < end.size(); i += 5)
  {
    end[i] = i % 2 == 0 ? 0.f : 0.98f;
  }
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    const PixelHits hits = makeHits(camera);
    const RayStops surfaces = hits.stops(nullptr, end.data());
    const auto expectGroups = [&](const Field& f, const TransferFunction& tf, const RayStops& stops,
                                const VolumeSettings& settings) {
      Image image(width, height);
      renderVolume(f, tf, camera, stops, settings, image);
      expectGroupsOf(image, f, tf, camera, stops, settings, view.name);
    };
    VolumeSettings coarse;
    coarse.levelOfDetailPixels = 4.;
    forEachKernel({}, [&](const std::string& /*kernel*/, const VolumeSettings& settings) {
      expectGroups(*field, smooth(), {}, settings);
    });
    inFloatsAndDoubles(
      {}, [&](const VolumeSettings& settings) { expectGroups(*field, smooth(), surfaces, settings); });
    inFloatsAndDoubles(
      coarse, [&](const VolumeSettings& settings) { expectGroups(*field, smooth(), {}, settings); });
    expectGroups(*hugeField, ofHuge, surfaces, {});
  }
}

TEST(VolumeKernel, CutsEqualTheReferenceOnEveryTarget)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 5, 0.6, 0.1, false });
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  std::vector<float> end(width * height, 1.f);
  for (std::size_t i = 0; i < end.size(); i += 7)
  {
    end[i] = 0.9f;
  }
  for (const View& view : views())
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    const PixelHits hits = makeHits(camera);
    RayStops planes = hits.stops(nullptr, end.data());
    planes.cut.halfSpaces = { { { 1., 0.4, -0.3 }, 0.6 }, { { -0.2, -1., 0.1 }, -1.4 },
      { { 0., 0.1, -1. }, -1.6 } };
    RayStops regions; // a lattice of holes
    regions.cut.cropping = CroppingRegions{ { 0.4, 1.3, 0.7, 1.5, 0.3, 1.25 }, 0x2aaaaaau };
    RayStops both = planes;
    both.cut.cropping = regions.cut.cropping;
    for (const RayStops& stops : { planes, regions, both })
    {
      Image expected(width, height);
      Image whole(width, height);
      renderVolumeReference(*field, smooth(), camera, stops, settings, expected);
      renderVolumeReference(*field, smooth(), camera, {}, settings, whole);
      EXPECT_GT(largestDifference(expected, whole), 0.2f) << view.name;
      forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
        Image image(width, height);
        renderVolume(*field, smooth(), camera, stops, ofKernel, image);
        EXPECT_LT(largestDifference(image, expected), 1e-3f) << view.name << " on " << kernel;
        expectGroupsOf(image, *field, smooth(), camera, stops, ofKernel, view.name);
      });
    }
  }
}

TEST(VolumeKernel, GroupsOutsideTheImageAreAnError)
{
  const auto field = randomField({ 12, { 2, 2, 2 }, 2, 0.6, 0., false });
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Volume volume(field, smooth(), 0);
  const auto render = [&](const PixelGroup& group, std::size_t floats) {
    std::vector<float> rgba(floats);
    volume.renderGroups(camera, {}, { &group, 1 }, rgba);
  };
  EXPECT_NO_THROW(render({ 60, 52 }, 64));
  EXPECT_THROW(render({ 60, 52 }, 63), Error);
  EXPECT_THROW(render({ 64, 52 }, 64), Error);
  EXPECT_THROW(render({ 60, 56 }, 64), Error);
  EXPECT_THROW(render({ -4, 0 }, 64), Error);
  EXPECT_THROW(render({ 0, 2 }, 64), Error);
}

TEST(VolumeKernel, UnitsAndOffsetsDoNotMatter)
{
  // The same tree a million cell widths from the origin, and 1e-9 and 1e9 wide.
  const RandomTree options{ 12, { 2, 2, 2 }, 5, 0.6, 0., false };
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image expected(width, height);
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  renderVolume(*randomField(options), smooth(), camera, {}, settings, expected);
  for (const double size : { 1e-9, 1., 1e9 })
  {
    const double offset = 1e6 / 32. * size;
    const Matrix4 toUnit{ 1. / size, 0, 0, -offset / size, 0, 1. / size, 0, -offset / size, 0, 0, 1. / size,
      -offset / size, 0, 0, 0, 1 };
    const Camera placed(multiply(views().front().clip, toUnit), toUnit, width, height);
    Image image(width, height);
    renderVolume(*makeField(RootGrid::uniform({ 2, 2, 2 }, { offset, offset, offset }, { size, size, size }),
                   makeRandomTree(options)),
      smooth(), placed, {}, settings, image);
    EXPECT_LT(largestDifference(image, expected), 1e-3f) << size;
  }
}

TEST(VolumeKernel, HugeValuesAreRenderedInDoubles)
{
  auto cells = makeRandomTree({ 12, { 1, 1, 1 }, 3, 0.6, 0., false });
  for (LeafCell& c : cells)
  {
    c.value *= 3e38f;
  }
  const auto field = makeField(unitRoots({ 1, 1, 1 }), cells);
  const TransferFunction transferFunction(-3e38, 3e38, { { 1.f, 0.f, 0.f, 0.f }, { 0.f, 1.f, 0.f, 5.f } });
  const Camera camera(views().front().clip, identityMatrix, width, height);
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  const PixelHits hits = makeHits(camera);
  for (const RayStops& stops : { RayStops(), hits.stops() })
  {
    Image expected(width, height);
    renderVolumeReference(*field, transferFunction, camera, stops, settings, expected);
    Image asked(width, height);
    inFloatsAndDoubles(settings, [&](const VolumeSettings& either) {
      Image image(width, height);
      renderVolume(*field, transferFunction, camera, stops, either, image);
      EXPECT_LT(largestDifference(image, expected), 1e-3f);
      asked = image;
    });
    Image chosen(width, height);
    renderVolume(*field, transferFunction, camera, stops, settings, chosen);
    EXPECT_EQ(chosen.rgba, asked.rgba);
  }
}

TEST(VolumeKernel, WithoutPreIntegrationASpikeIsMissedOrFillsAStep)
{
  auto cells = makeRandomTree({ 1, { 2, 2, 2 }, 3, 1., 0., false });
  setValues(cells, [](const auto& p) { return p[2]; });
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const Camera camera(views().back().clip, identityMatrix, width, height);
  VolumeSettings settings;
  settings.preIntegration = false;
  int missed = 0;
  for (int at = 700; at < 3400; at += 123)
  {
    std::vector<TransferFunction::Entry> entries(4096, { 0.f, 0.f, 0.f, 0.f });
    entries[at].extinction = 1000.f;
    Image image(width, height);
    renderVolume(*field, TransferFunction(0., 2., entries), camera, {}, settings, image);
    const float alpha = image.rgba[4 * (width * (height / 2) + width / 2) + 3];
    EXPECT_TRUE(alpha == 0.f || alpha > 0.999f) << at << ": " << alpha;
    missed += alpha == 0.f;
  }
  // Of 4096 values a ray takes two samples in each of its 16 cells.
  EXPECT_GE(missed, 20);
}

TEST(VolumeKernel, OpaqueEntriesLeaveTheOthersTheirDigits)
{
  // Opaque values below and above those that are seen: sums over the table must not lose what lies between.
  auto cells = makeRandomTree({ 1, { 2, 2, 2 }, 3, 1., 0., false });
  setValues(cells, [](const auto& p) { return 0.5 + 0.5 * p[2]; });
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const Camera camera(views().back().clip, identityMatrix, width, height);
  std::vector<TransferFunction::Entry> entries(4096, { 1.f, 1.f, 1.f, 0.f });
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    const double u = 2. * static_cast<double>(i) / 4095.;
    entries[i].extinction = u < 0.4 || u > 1.6 ? TransferFunction::opaqueExtinction
                                               : static_cast<float>(30. * std::pow(std::sin(90. * u), 2));
  }
  const TransferFunction transferFunction(0., 2., entries);
  Image image(width, height);
  renderVolume(*field, transferFunction, camera, {}, {}, image);
  VolumeSettings fine;
  fine.samplesPerCell = 4096.;
  Image expected(width, height);
  renderVolumeReference(*field, transferFunction, camera, {}, fine, expected);
  EXPECT_LT(largestDifference(image, expected), 2e-3f);
}

TEST(VolumeKernel, AHullFarWiderThanTheTableKeepsItsDigits)
{
  // Steps of a hull of a million would be coarser than all of the table.
  auto cells = makeRandomTree({ 12, { 2, 2, 2 }, 5, 0.6, 0., false });
  for (std::size_t i = 0; i < cells.size(); i += 50)
  {
    cells[i].value = 1e6f;
  }
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image expected(width, height);
  renderVolumeConverged(*field, smooth(), camera, {}, expected);
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(*field, smooth(), camera, {}, ofKernel, image);
    EXPECT_LT(largestDifference(image, expected), 4e-3f) << kernel;
  });
}

TEST(VolumeKernel, LevelOfDetailTakesLessAndKeepsTheFieldsMean)
{
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 64 * 64 * 64; ++i)
  {
    cells.push_back({ { { i % 64, i / 64 % 64, i / 4096 }, 5 }, 0.f });
  }
  const auto field = makeWaves(std::move(cells));
  const Camera camera(views().front().clip, identityMatrix, width, height);
  Image full(width, height);
  Image draft(width, height);
  inFloatsAndDoubles({}, [&](VolumeSettings settings) {
    const auto all = renderVolume(*field, smooth(), camera, {}, settings, full);
    settings.levelOfDetailPixels = 1e-3; // no node is that small
    const auto same = renderVolume(*field, smooth(), camera, {}, settings, draft);
    EXPECT_EQ(draft.rgba, full.rgba);
    EXPECT_EQ(same.samples, all.samples);
    settings.levelOfDetailPixels = 2.5;
    const auto less = renderVolume(*field, smooth(), camera, {}, settings, draft);
    EXPECT_LT(less.nodes, all.nodes / 2);
    EXPECT_LT(less.samples, all.samples);
    double sum = 0.;
    double squared = 0.;
    for (std::size_t i = 0; i < full.rgba.size(); ++i)
    {
      sum += full.rgba[i];
      squared += std::pow(full.rgba[i] - draft.rgba[i], 2);
    }
    const auto size = static_cast<double>(full.rgba.size());
    EXPECT_GT(sum / size, 0.03);
    EXPECT_LT(std::sqrt(squared / size), 0.01);
    EXPECT_GT(squared, 0.);
  });
}

// Nodes without ghosts are drawn as in a tree that has none.
TEST(VolumeKernel, OneGhostCostsNoMoreThanItsOwnNodes)
{
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 64 * 64 * 64; ++i)
  {
    cells.push_back({ { { i % 64, i / 64 % 64, i / 4096 }, 5 }, 0.f });
  }
  setValues(cells, [](const auto& p) { return std::sin(3. * p[0] + p[1]) * std::cos(2. * p[2]); });
  LeafCell& ghost = cells[(31 * 64 + 30) * 64 + 29];
  ghost.value = -1.5f; // transparent, so that nothing is missing without it
  const auto plain = makeField(unitRoots({ 2, 2, 2 }), cells);
  ListSource source({ 2, 2, 2 }, cells);
  source.ghostsBelow = -1.25f;
  auto built = buildOctree(unitRoots({ 2, 2, 2 }), source);
  ASSERT_TRUE(built.octree->hasGhosts());
  auto field = std::make_shared<Field>(built.octree, built.values);
  const Camera camera(views().front().clip, identityMatrix, width, height);
  constexpr std::uint64_t ofItsNodes = 64; // levels and siblings
  for (const double pixels : { 0., 2.5 })
  {
    inFloatsAndDoubles({}, [&](VolumeSettings settings) {
      settings.levelOfDetailPixels = pixels;
      Image expected(width, height);
      Image image(width, height);
      const auto without = renderVolume(*plain, smooth(), camera, {}, settings, expected);
      const auto with = renderVolume(*field, smooth(), camera, {}, settings, image);
      EXPECT_LE(with.nodes, without.nodes + ofItsNodes) << pixels;
      EXPECT_LE(with.blocks, without.blocks + ofItsNodes) << pixels;
      EXPECT_LT(largestDifference(image, expected), 0.02f) << pixels;
    });
  }
}

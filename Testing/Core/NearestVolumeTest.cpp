// Volumes whose cells show their own values, on every instruction set and in both precisions: against each ray's way
// through the boxes of all leaves, and, where they are lit, against the scalar reference.
#include "Support/Cameras.h"
#include "Support/ExactCells.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Support/VolumeViews.h"
#include "Volume/ErrorEstimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 29;
constexpr int height = 23;
using Entry = TransferFunction::Entry;
/// Roundings of the rays' places, at these extinctions.
constexpr double rounding = 3e-5;

std::vector<LeafCell> waves(const RandomTree& options)
{
  std::vector<LeafCell> cells = makeRandomTree(options);
  setValues(cells, [](const auto& p) { return std::sin(3. * p[0] + p[1]) * std::cos(2. * p[2]); });
  return cells;
}

std::vector<RandomTree> trees()
{
  return { { 12, { 2, 2, 2 }, 4, 0.6, 0., false }, { 13, { 2, 2, 2 }, 5, 0.4, 0.2, false },
    { 5, { 2, 2, 2 }, 3, 1., 0., false }, { 3, { 1, 1, 1 }, 0, 0., 0., false } };
}

/// Of entries, with a jump and a peak that no table has, and such that hide one another.
std::vector<TransferFunction> functions()
{
  const Entry haze{ 0.1f, 0.4f, 0.9f, 0.3f };
  const Entry peak{ 0.9f, 0.2f, 0.1f, 4.f };
  return { TransferFunction(-1., 1., { { 0.9f, 0.2f, 0.1f, 0.f }, { 0.3f, 0.7f, 0.9f, 3.f } }),
    TransferFunction::ofNodes({ { -0.5, {}, haze }, { 0.3 - 1e-5, haze, haze }, { 0.3, peak, peak },
      { 0.3 + 1e-5, haze, haze }, { 0.8, { 0.f, 1.f, 0.f, 0.3f }, {} } }),
    TransferFunction::ofNodes(
      { { 0., {}, { 0.9f, 0.9f, 0.2f, static_cast<float>(TransferFunction::opaqueExtinction) } } }) };
}

std::vector<Camera> cameras()
{
  std::vector<Camera> result;
  for (const View& view : views())
  {
    if (std::string(view.name) != "along an axis") // whose rays are in faces
    {
      result.emplace_back(view.clip, identityMatrix, width, height);
    }
  }
  return result;
}

VolumeSettings nearest(VolumeBlend blend = VolumeBlend::Composite)
{
  VolumeSettings settings;
  settings.nearest = true;
  settings.blend = blend;
  settings.unitDistance = 1.3;
  return settings;
}

/// Calls expected(the parts of a pixel's ray) for all pixels, and compares every kernel with it, but where that depends on
/// an edge that the ray grazes.
template <class Expected>
void expectExact(const RandomTree& tree, const TransferFunction& function, const Camera& camera,
  const VolumeSettings& settings, const Expected& expected)
{
  const std::vector<LeafCell> cells = waves(tree);
  const auto field = makeField(unitRoots(tree.roots), cells);
  Image exact(width, height);
  std::vector<int> grazes;
  for (int i = 0; i < width * height; ++i)
  {
    std::vector<CellPart> parts = partsOfRay(unitRoots(tree.roots), cells, camera, i % width, i / width);
    const std::array<double, 4> rgba = expected(parts);
    std::copy(rgba.begin(), rgba.end(), exact.rgba.begin() + 4 * i);
    std::erase_if(parts, [](const CellPart& part) { return part.end - part.begin < 1e-4; });
    const std::array<double, 4> others = expected(parts);
    for (int c = 0; c < 4 && (grazes.empty() || grazes.back() != i); ++c)
    {
      if (std::abs(rgba[c] - others[c]) > 0.1 * rounding)
      {
        grazes.push_back(i);
      }
    }
  }
  EXPECT_LT(grazes.size(), static_cast<std::size_t>(width * height / 50));
  EXPECT_GT(*std::max_element(exact.rgba.begin(), exact.rgba.end()), 0.05f);
  std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(*field, function, camera, {}, ofKernel, image);
    Image compared = image;
    for (const int i : grazes)
    {
      std::copy_n(exact.rgba.begin() + 4 * i, 4, compared.rgba.begin() + 4 * i);
    }
    int differing = 0; // a ray may graze an edge on the other side, too
    for (std::size_t i = 0; i < exact.rgba.size(); i += 4)
    {
      differing += !std::equal(compared.rgba.begin() + i, compared.rgba.begin() + i + 4,
        exact.rgba.begin() + i, [](float a, float b) { return std::abs(a - b) < rounding; });
    }
    EXPECT_LE(differing, 1) << kernel;
    Image& first = firsts[ofKernel.doubles];
    first = first.width == 0 ? image : first;
    EXPECT_EQ(image.rgba, first.rgba) << kernel;
  });
}

} // namespace

TEST(NearestVolume, EveryRayIsThatThroughTheLeavesBoxes)
{
  for (const RandomTree& tree : trees())
  {
    for (const TransferFunction& function : functions())
    {
      for (const Camera& camera : cameras())
      {
        // A cell whose wave is not in the peak may be transparent altogether.
        if (tree.levels == 0 && function.at(waves(tree)[0].value).extinction == 0.f)
        {
          continue;
        }
        VolumeSettings settings = nearest();
        settings.leastTransmittance = 1e-6f;
        expectExact(tree, function, camera, settings, [&](const std::vector<CellPart>& parts) {
          return lightOf(parts, [&](float value) { return function.at(value); });
        });
      }
    }
  }
}

TEST(NearestVolume, BlendsOfValuesAreThoseOfTheLeaves)
{
  const TransferFunction function = functions()[0];
  const auto opacityOf = [&](float value) { return -std::expm1(-1.3 * function.at(value).extinction); };
  for (const RandomTree& tree : { trees()[0], trees()[1], trees()[2] })
  {
    const std::vector<LeafCell> cells = waves(tree);
    const Range range = makeField(unitRoots(tree.roots), cells)->range();
    const auto grey = [](double value) {
      const double shown = std::clamp(value, 0., 1.);
      return std::array{ shown, shown, shown, 1. };
    };
    for (const Camera& camera : cameras())
    {
      for (const bool isMaximum : { true, false })
      {
        const auto extreme = [&](const std::vector<CellPart>& parts) -> std::array<double, 4> {
          if (parts.empty())
          {
            return {};
          }
          const auto [least, most] = std::minmax_element(parts.begin(), parts.end(),
            [](const CellPart& a, const CellPart& b) { return a.value < b.value; });
          const float value = (isMaximum ? most : least)->value;
          const Entry entry = function.at(value);
          const double opacity = opacityOf(value);
          return { opacity * entry.r, opacity * entry.g, opacity * entry.b, opacity };
        };
        expectExact(
          tree, function, camera, nearest(isMaximum ? VolumeBlend::Maximum : VolumeBlend::Minimum), extreme);
      }
      VolumeSettings average = nearest(VolumeBlend::Average);
      average.averageRange = { -0.4f, 0.7f };
      expectExact(tree, function, camera, average, [&](const std::vector<CellPart>& parts) {
        double sum = 0.;
        double length = 0.;
        for (const CellPart& part : parts)
        {
          const bool counts = part.value >= -0.4f && part.value <= 0.7f;
          const double place = (part.value - range.min) / (range.max - range.min);
          sum += counts ? (part.end - part.begin) * place * opacityOf(part.value) : 0.;
          length += counts ? part.end - part.begin : 0.;
        }
        return length > 0. ? grey(sum / length) : std::array<double, 4>{};
      });
    }
  }
}

TEST(NearestVolume, LightAndColorsAreThoseOfTheCentres)
{
  VolumeShading shading;
  shading.ambient = 0.2f;
  shading.specular = 0.f; // which changes along a ray, as positional lights do
  shading.lightsFromData = lookAt({ 4., 3., 3.5 }, { 1., 1., 1. });
  Light light;
  light.direction = normalized({ 0.4, -1., -0.5 });
  shading.lights = { light };
  VolumeSettings lit = nearest();
  lit.shading = shading;
  VolumeSettings byGradient = nearest();
  byGradient.gradientOpacity = GradientOpacity{ 4., { 0.f, 0.1f, 0.8f, 1.f, 0.6f } };
  VolumeSettings both = byGradient;
  both.shading = shading;
  for (const RandomTree& tree : { trees()[0], trees()[1] })
  {
    std::vector<LeafCell> cells = waves(tree);
    const auto field = makeField(unitRoots(tree.roots), cells);
    setValues(cells, [](const auto& p) { return p[1]; });
    const auto colored = std::make_shared<const Field>(
      field->sharedOctree(), LargeVector<float>(makeField(unitRoots(tree.roots), cells)->leafValues()));
    const TransferFunction colors(0., 2., { { 0.1f, 0.9f, 0.2f, 1.f }, { 0.9f, 0.1f, 0.4f, 1.f } });
    const ReferenceColors byColor{ *colored, colors };
    for (const Camera& camera : cameras())
    {
      for (const VolumeSettings& settings : { lit, byGradient, both, nearest() })
      {
        for (const ReferenceColors* by : { static_cast<const ReferenceColors*>(nullptr), &byColor })
        {
          Image expected(width, height);
          renderVolumeReference(*field, functions()[0], camera, {}, settings, expected, by);
          forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
            Volume volume(field, functions()[0]);
            volume.setColors(by ? colored : nullptr, colors);
            Image image(width, height);
            volume.render(camera, ofKernel, image);
            EXPECT_LT(largestDifference(image, expected), 2e-3f) << kernel;
          });
        }
      }
    }
  }
}

// Nothing is reconstructed, kept or missed.
TEST(NearestVolume, SettingsOfTheReconstructionChangeNoBit)
{
  const auto field = makeField(unitRoots({ 2, 2, 2 }), waves(trees()[1]));
  for (const Camera& camera : cameras())
  {
    Volume volume(field, functions()[1]);
    Image image(width, height);
    VolumeSettings linear;
    volume.render(camera, linear, image);
    EXPECT_GT(volume.keptBytes(), 0u);
    const VolumeStatistics skipped = volume.render(camera, nearest(), image);
    EXPECT_EQ(volume.keptBytes(), 0u);
    VolumeSettings all = nearest();
    all.skipEmpty = false;
    VolumeSettings samples = nearest();
    samples.samplesPerCell = 64.;
    for (const VolumeSettings& settings : { all, samples })
    {
      Image again(width, height);
      const VolumeStatistics statistics = volume.render(camera, settings, again);
      EXPECT_EQ(again.rgba, image.rgba);
      EXPECT_GE(statistics.samples, skipped.samples);
      EXPECT_EQ(statistics.blocks + statistics.kept, 0u);
    }
    std::vector<PixelGroup> groups{ { 4, 8 }, { 12, 12 } };
    std::vector<float> rgba(groups.size() * PixelGroup::rgbaSize);
    volume.renderGroups(camera, nearest(), groups, rgba);
    EXPECT_TRUE(std::equal(rgba.begin(), rgba.begin() + 16, image.rgba.begin() + 4 * (4 + 8 * width)));
    ErrorEstimator estimator(volume, camera, nearest(), image);
    EXPECT_LT(estimator.error(), 1e-6); // of rays that end
  }
}

TEST(NearestVolume, DraftsShowMeansOfNodes)
{
  const RandomTree tree{ 5, { 2, 2, 2 }, 2, 1., 0., false };
  const auto field = makeField(unitRoots(tree.roots), waves(tree));
  // A cell for each child of a root, which a draft that may draw all together comes to.
  std::vector<LeafCell> means;
  TreePath path(field->octree());
  forEachNode(path, [&](const TreePath& at) {
    if (at.depth() == field->octree().grid().paddingDepth() + 1)
    {
      means.push_back({ { at.index(), 1 }, static_cast<float>(field->value(at.node())) });
    }
  });
  ASSERT_EQ(means.size(), 64u);
  const auto coarse = makeField(unitRoots(tree.roots), means);
  VolumeSettings draft = nearest();
  draft.levelOfDetailPixels = 1e4;
  for (const Camera& camera : cameras())
  {
    Image expected(width, height);
    Image image(width, height);
    renderVolume(*coarse, functions()[0], camera, {}, nearest(), expected);
    renderVolume(*field, functions()[0], camera, {}, draft, image);
    EXPECT_LT(largestDifference(image, expected), rounding);
    renderVolume(*field, functions()[0], camera, {}, nearest(), image);
    EXPECT_GT(largestDifference(image, expected), 0.01f);
  }
}

TEST(NearestVolume, CutsAndSurfacesAreTheReferences)
{
  const auto field = makeField(unitRoots({ 2, 2, 2 }), waves(trees()[0]));
  for (const Camera& camera : cameras())
  {
    PixelHits hits;
    for (int i = 0; i < width * height; ++i)
    {
      const Ray ray = camera.ray(i % width, i / width);
      hits.add(camera.tFromDepth(ray, 0.3), { 0.2f, 0.9f, 0.4f, 0.3f });
      hits.add(camera.tFromDepth(ray, 0.9), { 0.9f, 0.9f, 0.9f, 0.9f });
      hits.endPixel();
    }
    RayStops stops = hits.stops();
    stops.cut.halfSpaces = { { { 1., 0.5, 0.2 }, 0.9 } };
    stops.cut.cropping = CroppingRegions{ { 0.3, 1.4, 0.5, 1.6, 0.2, 1.7 }, 0x5ca3c96 };
    Image expected(width, height);
    renderVolumeReference(*field, functions()[0], camera, stops, nearest(), expected);
    forEachKernel(nearest(), [&](const std::string& kernel, const VolumeSettings& settings) {
      Image image(width, height);
      renderVolume(*field, functions()[0], camera, stops, settings, image);
      EXPECT_LT(largestDifference(image, expected), rounding) << kernel;
    });
  }
}

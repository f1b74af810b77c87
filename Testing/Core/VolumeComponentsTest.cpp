// Volumes of several fields at once, channels of colour and independent components, on every instruction set and in both
// precisions: against the same mixed at points along the rays, by samplers in doubles.
#include "Error.h"
#include "Interpolation/Sampler.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeLight.h"
#include "Support/VolumeViews.h"
#include "Volume/Volume.h"

#include <gtest/gtest.h>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 31;
constexpr int height = 27;
constexpr double tolerance = 2e-3;
using Entry = TransferFunction::Entry;
using FieldPtr = std::shared_ptr<const Field>;

/// Of one octree; the last one's values are not those of the others.
std::vector<FieldPtr> fields()
{
  const RandomTree tree{ 31, { 2, 2, 2 }, 4, 0.7, 0.05, true };
  std::vector<LeafCell> cells = makeRandomTree(tree);
  std::vector<FieldPtr> result;
  const std::vector<std::function<double(const std::array<double, 3>&)>> values{
    [](const auto& p) { return std::sin(2. * p[0] + p[1]) * std::cos(1.5 * p[2]); },
    [](const auto& p) { return std::cos(p[0] - 2. * p[2]); },
    [](const auto& p) { return std::sin(p[0] * p[1]); },
    [](const auto& p) { return 1e3 * (p[1] + 0.3 * std::sin(2. * p[2])) + 2e3; }
  };
  for (const auto& value : values)
  {
    setValues(cells, value);
    const FieldPtr field = makeField(unitRoots(tree.roots), cells);
    result.push_back(result.empty()
        ? field
        : std::make_shared<const Field>(result[0]->sharedOctree(), LargeVector<float>(field->leafValues())));
  }
  return result;
}

const std::vector<TransferFunction>& functions()
{
  static const std::vector<TransferFunction> all{ TransferFunction(-1., 1.,
                                                    { { 0.9f, 0.2f, 0.1f, 0.f }, { 0.2f, 0.5f, 0.9f, 2.f } }),
    TransferFunction(-1., 1., { { 0.1f, 0.9f, 0.1f, 1.f }, { 0.9f, 0.9f, 0.2f, 0.f } }),
    TransferFunction(-1., 1., { { 0.f, 0.f, 1.f, 0.f }, { 1.f, 1.f, 1.f, 3.f } }),
    TransferFunction(1800., 4300., { { 0.9f, 0.1f, 0.2f, 0.2f }, { 0.2f, 0.8f, 0.1f, 0.9f } }) };
  return all;
}

/// Light that points of a field emit, and their extinction.
using Emission = std::function<std::array<double, 4>(const Vec3&)>;

/// Along all of the domain but this much at its faces.
Image march(const Camera& camera, const Emission& emission, double margin = 0.)
{
  constexpr int steps = 1500;
  Image image(width, height);
  tbb::parallel_for(0, width * height, [&](int i) {
    const Ray ray = camera.ray(i % width, i / width);
    double begin = camera.tFromDepth(ray, 0.);
    double end = camera.tFromDepth(ray, 1.);
    for (int a = 0; a < 3; ++a)
    {
      const double low = (margin - ray.origin[a]) / ray.direction[a];
      const double high = (2. - margin - ray.origin[a]) / ray.direction[a];
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
    double passes = 1.;
    for (int s = 0; s < steps && begin < end; ++s)
    {
      const auto e = emission(pointAt(ray, std::lerp(begin, end, (s + 0.5) / steps)));
      if (e[3] > 0.)
      {
        const double held = -std::expm1(-e[3] * (end - begin) / steps);
        for (int c = 0; c < 4; ++c)
        {
          image.rgba[4 * i + c] += static_cast<float>(passes * held * e[c] / e[3]);
        }
        passes *= 1. - held;
      }
    }
  });
  return image;
}

using Samplers = std::vector<std::unique_ptr<Sampler>>;
Samplers samplersOf(const std::vector<FieldPtr>& all, InterpolationMethod method)
{
  Samplers samplers;
  for (const FieldPtr& field : all)
  {
    samplers.push_back(Sampler::create(method, field));
  }
  return samplers;
}

/// As vtkGPUVolumeRayCastMapper mixes opacities of short steps.
std::array<double, 4> mixed(const Samplers& samplers, const std::vector<float>& weights, const Vec3& point)
{
  std::array<double, 4> sum{};
  double squares = 0.;
  double weighted = 0.;
  for (std::size_t i = 0; i < weights.size(); ++i)
  {
    FieldSample sample;
    if (!samplers[i]->sampleRelative(point, sample) || weights[i] == 0.f)
    {
      continue;
    }
    const Entry e = functions()[i].at(static_cast<float>(sample.value));
    squares += std::pow(e.extinction, 2);
    weighted += weights[i] * e.extinction;
    sum[0] += weights[i] * e.extinction * e.r;
    sum[1] += weights[i] * e.extinction * e.g;
    sum[2] += weights[i] * e.extinction * e.b;
  }
  sum[3] = weighted > 0. ? squares / weighted : 0.;
  return sum;
}

void setComponents(Volume& volume, const std::vector<FieldPtr>& all, const std::vector<float>& weights)
{
  std::vector<Volume::Component> others;
  for (std::size_t i = 1; i < weights.size(); ++i)
  {
    others.push_back({ all[i], functions()[i], weights[i] });
  }
  volume.setComponents(std::move(others), weights[0]);
}

std::vector<Camera> cameras()
{
  return { Camera(views()[0].clip, identityMatrix, width, height),
    Camera(views()[3].clip, identityMatrix, width, height) };
}

/// Colours of several components may be brighter than white, as VTK's are before they are shown.
void expectPictures(
  Volume& volume, const RayView& view, const VolumeSettings& settings, const Image& expected)
{
  EXPECT_GT(*std::max_element(expected.rgba.begin(), expected.rgba.end()), 0.2f);
  VolumeSettings many = settings;
  many.samplesPerCell = 32.;
  inFloatsAndDoubles(many, [&](const VolumeSettings& ofKernel) {
    Image image(width, height);
    volume.render(view, ofKernel, image);
    EXPECT_LT(largestDifference(image, expected), 3. * tolerance); // a march's steps pass the ends of cells
    EXPECT_LT(meanDifference(image, expected), 0.3 * tolerance);
  });
  std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    volume.render(view, ofKernel, image);
    EXPECT_LT(meanDifference(image, expected), tolerance) << kernel;
    Image& first = firsts[ofKernel.doubles];
    first = first.width == 0 ? image : first;
    EXPECT_EQ(image.rgba, first.rgba) << kernel;
  });
}

} // namespace

TEST(VolumeComponents, IndependentOnesAreMixedAtEachPoint)
{
  const std::vector<FieldPtr> all = fields();
  for (const bool isNearest : { false, true })
  {
    const Samplers samplers =
      samplersOf(all, isNearest ? InterpolationMethod::Nearest : InterpolationMethod::GTI);
    VolumeSettings settings;
    settings.nearest = isNearest;
    for (const std::vector<float>& weights :
      { std::vector{ 1.f, 1.f }, { 1.f, 0.3f, 0.8f }, { 0.f, 1.f, 0.f, 0.5f } })
    {
      Volume volume(all[0], functions()[0]);
      setComponents(volume, all, weights);
      for (const Camera& camera : cameras())
      {
        const Image expected =
          march(camera, [&](const Vec3& point) { return mixed(samplers, weights, point); });
        expectPictures(volume, camera, settings, expected);
      }
    }
  }
}

/// Linear ones, whose gradients are these everywhere but at the domain's faces.
TEST(VolumeComponents, EachIsLitByItsOwnGradients)
{
  const RandomTree tree{ 31, { 2, 2, 2 }, 3, 1., 0., true };
  constexpr double margin = 0.25; // of two cells
  std::vector<LeafCell> cells = makeRandomTree(tree);
  const std::vector<Vec3> slopes{ { 0.3, 0.1, -0.2 }, { -0.1, 0.4, 0.2 }, { 0.05, -0.2, 0.5 } };
  std::vector<FieldPtr> all;
  for (const Vec3& slope : slopes)
  {
    setValues(cells, [&](const auto& p) { return slope[0] * p[0] + slope[1] * p[1] + slope[2] * p[2]; });
    const FieldPtr field = makeField(unitRoots(tree.roots), cells);
    all.push_back(all.empty()
        ? field
        : std::make_shared<const Field>(all[0]->sharedOctree(), LargeVector<float>(field->leafValues())));
  }
  const std::vector<float> weights{ 1.f, 0.6f, 0.9f };
  Volume volume(all[0], functions()[0]);
  setComponents(volume, all, weights);
  Light light;
  light.positional = true;
  light.position = { 1., 4., -1. };
  light.color = { 0.9f, 1.f, 0.7f };
  VolumeSettings settings;
  for (int i = 0; i < 3; ++i)
  {
    VolumeShading shading;
    shading.ambient = 0.2f * static_cast<float>(i);
    shading.specular = 0.3f * static_cast<float>(i);
    shading.specularPower = 4.f;
    shading.ambientLight = { 0.02f, 0.f, 0.05f };
    shading.lights = { light };
    if (i == 0)
    {
      settings.shading = shading;
      continue;
    }
    settings.componentShading.push_back(shading);
  }
  RayStops stops;
  stops.cut.addBox({ { margin, margin, margin }, { 2. - margin, 2. - margin, 2. - margin } });
  for (const Camera& camera : cameras())
  {
    const auto emission = [&](const Vec3& point) {
      std::array<double, 4> sum{};
      double squares = 0.;
      double weighted = 0.;
      for (int i = 0; i < 3; ++i)
      {
        const Entry e = functions()[i].at(static_cast<float>(dot(slopes[i], point)));
        const VolumeShading& shading = i == 0 ? *settings.shading : settings.componentShading[i - 1];
        const auto lit = lightVolume(shading, point, slopes[i], { e.r, e.g, e.b });
        squares += std::pow(e.extinction, 2);
        weighted += weights[i] * e.extinction;
        for (int c = 0; c < 3; ++c)
        {
          sum[c] += weights[i] * e.extinction * lit[c];
        }
      }
      sum[3] = weighted > 0. ? squares / weighted : 0.;
      return sum;
    };
    const Image expected = march(camera, emission, margin);
    const RayView view{ camera, stops };
    expectPictures(volume, view, settings, expected);
    VolumeSettings unlit = settings;
    unlit.shading.reset();
    Image image(width, height);
    volume.render(view, unlit, image);
    EXPECT_GT(largestDifference(image, expected), 0.05f);
  }
}

TEST(VolumeComponents, ChannelsAreTheColors)
{
  const std::vector<FieldPtr> all = fields();
  for (const bool isNearest : { false, true })
  {
    const Samplers samplers =
      samplersOf(all, isNearest ? InterpolationMethod::Nearest : InterpolationMethod::GTI);
    VolumeSettings settings;
    settings.nearest = isNearest;
    Volume volume(all[0], functions()[0]);
    volume.setChannels({ all[1], all[2], all[3] });
    for (const Camera& camera : cameras())
    {
      const Image expected = march(camera, [&](const Vec3& point) {
        std::array<double, 4> e{};
        FieldSample sample;
        if (samplers[0]->sampleRelative(point, sample))
        {
          e[3] = functions()[0].at(static_cast<float>(sample.value)).extinction;
          for (int c = 0; c < 3; ++c)
          {
            const Range range = all[c + 1]->range();
            samplers[c + 1]->sampleRelative(point, sample);
            e[c] = e[3] * (sample.value - range.min) / (range.max - range.min);
          }
        }
        return e;
      });
      expectPictures(volume, camera, settings, expected);
    }
  }
}

TEST(VolumeComponents, OneWithWeightsOfOneIsTheVolumeItself)
{
  const std::vector<FieldPtr> all = fields();
  const Camera camera = cameras()[0];
  Volume volume(all[0], functions()[0]);
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  Image alone(width, height);
  volume.render(camera, settings, alone);
  // The others have no weight.
  setComponents(volume, all, { 1.f, 0.f, 0.f });
  EXPECT_TRUE(volume.hasColors());
  Image image(width, height);
  volume.render(camera, settings, image);
  EXPECT_LT(largestDifference(image, alone), 1e-3f);
  // New functions are drawn, and nothing stays of what is taken back.
  volume.setTransferFunction(functions()[1]);
  volume.render(camera, settings, image);
  EXPECT_GT(largestDifference(image, alone), 0.1f);
  volume.setTransferFunction(functions()[0]);
  volume.setComponents({});
  EXPECT_FALSE(volume.hasColors());
  volume.render(camera, settings, image);
  EXPECT_EQ(image.rgba, alone.rgba);
}

TEST(VolumeComponents, SkippingChangesNoBit)
{
  const std::vector<FieldPtr> all = fields();
  Volume volume(all[0], functions()[0]);
  const TransferFunction half = TransferFunction::ofNodes(
    { { 0.4, {}, { 0.f, 1.f, 0.f, 0.f } }, { 1., { 1.f, 0.f, 0.f, 2.f }, { 1.f, 0.f, 0.f, 2.f } } });
  volume.setTransferFunction(half);
  volume.setComponents({ { all[1], half, 0.7f } });
  forEachKernel({}, [&](const std::string& kernel, VolumeSettings settings) {
    Image with(width, height);
    Image without(width, height);
    const VolumeStatistics skipped = volume.render(cameras()[0], settings, with);
    settings.skipEmpty = false;
    const VolumeStatistics visited = volume.render(cameras()[0], settings, without);
    EXPECT_EQ(with.rgba, without.rgba) << kernel;
    EXPECT_LT(skipped.samples, visited.samples) << kernel;
  });
}

TEST(VolumeComponents, RefuseWhatDoesNotFit)
{
  const std::vector<FieldPtr> all = fields();
  const FieldPtr other = fields()[1]; // of an octree like it
  Volume volume(all[0], functions()[0]);
  EXPECT_THROW(volume.setComponents({ { other, functions()[1] } }), Error);
  EXPECT_THROW(volume.setComponents({ { nullptr, functions()[1] } }), Error);
  EXPECT_THROW(volume.setComponents({ { all[1], functions()[1], -1.f } }), Error);
  EXPECT_THROW(
    volume.setComponents({ { all[1], functions()[1], std::numeric_limits<float>::quiet_NaN() } }), Error);
  EXPECT_THROW(volume.setComponents({ 4, { all[1], functions()[1] } }), Error);
  EXPECT_THROW(volume.setComponents({ { all[1], TransferFunction::ofCategories({ {} }) } }), Error);
  EXPECT_THROW(volume.setChannels({ all[1], nullptr, all[2] }), Error);
  EXPECT_THROW(volume.setChannels({ all[1], other, all[2] }), Error);
  EXPECT_FALSE(volume.hasColors());
}

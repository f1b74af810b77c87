// Scattered light: against what is known of even volumes, and against shadow rays to every sample of others.
#include "Error.h"
#include "Interpolation/PointSampler.h"
#include "Octree/OctreeBuilder.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Volume/ShadowLattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 24;
constexpr int height = 20;
constexpr double cell = 1. / ShadowLattice::cellsAcross; // of a unit cube's lattice

/// The same everywhere in the unit cube.
std::shared_ptr<const Field> evenCube()
{
  std::vector<LeafCell> cells;
  for (int i = 0; i < 8; ++i)
  {
    cells.push_back({ { { i & 1, i >> 1 & 1, i >> 2 }, 1 }, 0.5f });
  }
  return makeField(unitRoots({ 1, 1, 1 }), cells);
}

constexpr TransferFunction::Entry grey{ 0.5f, 0.75f, 1.f, 3.f };

TransferFunction even()
{
  return TransferFunction(0., 1., { grey, grey });
}

struct ScatteringView
{
  const char* name;
  Matrix4 clipFromView;
  Matrix4 viewFromData;
  Vec3 eye; // from which scattered light is seen, as VTK has it in parallel projection, too

  Camera camera() const { return Camera(multiply(clipFromView, viewFromData), identityMatrix, width, height); }
  Vec3 point(const Vec3& p) const
  {
    Vec3 result;
    for (int r = 0; r < 3; ++r)
    {
      result[r] = dot({ viewFromData[4 * r], viewFromData[4 * r + 1], viewFromData[4 * r + 2] }, p) +
        viewFromData[4 * r + 3];
    }
    return result;
  }
  Vec3 direction(const Vec3& v) const { return point(v) - point({ 0., 0., 0. }); }
};

std::vector<ScatteringView> views()
{
  const Vec3 middle{ 0.5, 0.5, 0.5 };
  const Vec3 outside{ 2., 1.6, 1.4 };
  const Vec3 inside{ 0.6, 0.4, 0.7 };
  return { { "perspective", perspective(40., 0.1, 20.), lookAt(outside, middle), outside },
    { "inside", perspective(90., 1e-3, 20.), lookAt(inside, { 0., 0.1, 0.2 }), inside },
    { "parallel", parallel(0.95, 0.1, 20.), lookAt(outside, middle), outside } };
}

struct DataLight
{
  const char* name;
  bool positional;
  Vec3 place;
};

const std::array<DataLight, 3> lights{ DataLight{ "from above", false, unit({ 0.3, -1., 0.2 }) },
  { "inside", true, { 0.3, 0.55, 0.6 } }, { "outside", true, { -1., 1.5, 0.4 } } };

VolumeSettings scattering(const ScatteringView& view, const DataLight& from)
{
  Light light;
  light.positional = from.positional;
  if (from.positional)
  {
    light.position = view.point(from.place);
  }
  else
  {
    light.direction = view.direction(from.place);
  }
  light.color = { 1.f, 0.8f, 0.6f };
  VolumeSettings settings;
  settings.samplesPerCell = 64.;
  settings.shading.emplace();
  settings.shading->diffuse = 0.9f;
  settings.shading->lights = { light };
  settings.shading->lightsFromData = view.viewFromData;
  settings.shading->scattering.emplace();
  return settings;
}

/// Where a ray is in the unit cube; false: nowhere.
bool findCube(const Ray& ray, double& begin, double& end)
{
  for (int a = 0; a < 3; ++a)
  {
    const double to0 = (0. - ray.origin[a]) / ray.direction[a];
    const double to1 = (1. - ray.origin[a]) / ray.direction[a];
    begin = std::max(begin, std::min(to0, to1));
    end = std::min(end, std::max(to0, to1));
  }
  return begin < end;
}

/// Optical depth of a way, to which the light's settings do not matter.
using DepthOf = std::function<double(const Vec3& from, const Vec3& way, double length)>;
using ExtinctionAt = std::function<double(const Vec3& point)>;

/// By shadow rays from every one of many samples.
Image bruteForce(const ScatteringView& view, const VolumeSettings& settings, const DataLight& light,
  const ExtinctionAt& extinctionAt, const DepthOf& depthOf, int steps)
{
  const VolumeScattering& scattering = *settings.shading->scattering;
  const Camera camera = view.camera();
  Image image(width, height);
  for (int pixel = 0; pixel < width * height; ++pixel)
  {
    const Ray ray = camera.ray(pixel % width, pixel / width);
    double begin = camera.isPerspective() ? 0. : -std::numeric_limits<double>::infinity();
    double end = std::numeric_limits<double>::infinity();
    if (!findCube(ray, begin, end))
    {
      continue;
    }
    const double step = (end - begin) / steps;
    const double speed = std::sqrt(dot(ray.direction, ray.direction));
    double through = 1.;
    for (int i = 0; i < steps; ++i)
    {
      Vec3 point;
      for (int a = 0; a < 3; ++a)
      {
        point[a] = ray.origin[a] + (begin + (i + 0.5) * step) * ray.direction[a];
      }
      const double held = 1. - std::exp(-extinctionAt(point) * step * speed);
      Vec3 way = light.positional ? light.place - point : Vec3{} - light.place;
      double far = light.positional ? std::sqrt(dot(way, way)) : std::numeric_limits<double>::infinity();
      way = unit(way);
      double near = cell;
      findCube({ point, way }, near, far);
      far = std::min(far, cell + scattering.reach);
      const double depth = far > near ? depthOf(point, way, far) : 0.;
      const double g = scattering.anisotropy;
      const double cosine = dot(way, unit(point - view.eye)); // of light against the way, and what is seen
      const double phase = (1. - g * g) / std::pow(1. + g * g - 2. * g * cosine, 1.5);
      const double rgb[3] = { grey.r, grey.g, grey.b };
      for (int c = 0; c < 3; ++c)
      {
        const double lit = std::exp(-depth) * phase * rgb[c] * settings.shading->diffuse *
          settings.shading->lights[0].color[c];
        image.rgba[4 * pixel + c] += static_cast<float>(through * held * std::min(lit, 1.));
      }
      image.rgba[4 * pixel + 3] += static_cast<float>(through * held);
      through *= 1. - held;
    }
  }
  return image;
}

Image evenPicture(const ScatteringView& view, const VolumeSettings& settings, const DataLight& light)
{
  return bruteForce(
    view, settings, light, [](const Vec3&) { return grey.extinction; },
    [](const Vec3&, const Vec3&, double length) { return grey.extinction * std::max(length - cell, 0.); }, 1000);
}

} // namespace

TEST(VolumeScattering, EvenVolumesAreKnown)
{
  const auto field = evenCube();
  Volume volume = volumeOf(*field, even()); // which keeps what comes through, whatever the kernel and the view
  for (const DataLight& light : lights)
  {
    for (const double reach : { 2., 0.2 })
    {
      if (light.positional && reach < 1.) // takes long, for the same
      {
        continue;
      }
      for (const ScatteringView& view : views())
      {
        for (const float anisotropy : { 0.f, 0.6f, -0.4f })
        {
          VolumeSettings settings = scattering(view, light);
          settings.shading->scattering->anisotropy = anisotropy;
          settings.shading->scattering->reach = reach;
          const Image expected = evenPicture(view, settings, light);
          forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
            Image image(width, height);
            volume.render({ view.camera(), {} }, ofKernel, image);
            EXPECT_LT(meanDifference(image, expected), 2e-3)
              << view.name << ", light " << light.name << ", reach " << reach << ", anisotropy " << anisotropy
              << " on " << kernel;
          });
        }
      }
    }
  }
}

// Where the gradient is 0 what is reflected is the ambient light alone.
TEST(VolumeScattering, BlendsWithReflectedLightAsVTK)
{
  const auto field = evenCube();
  const ScatteringView view = views()[0];
  VolumeSettings settings = scattering(view, lights[0]);
  settings.shading->ambientLight = { 0.1f, 0.2f, 0.3f };
  settings.shading->scattering->sampleLength = 0.1;
  Volume volume = volumeOf(*field, even());
  const auto render = [&](const VolumeSettings& with) {
    Image image(width, height);
    volume.render({ view.camera(), {} }, with, image);
    return image;
  };
  VolumeSettings reflecting = settings;
  reflecting.shading->scattering.reset();
  const Image none = render(reflecting);
  const Image all = render(settings);
  const double opacity = 1. - std::exp(-0.1 * grey.extinction);
  for (const float blending : { 0.3f, 0.9f, 1.f, 1.4f, 2.f })
  {
    settings.shading->scattering->blending = blending;
    const double v = 0.5 * blending;
    const double falls = std::exp(-2. * v * opacity);
    const double part = blending < 1.f ? 2. * v * falls : 2. * (1. - v) * falls + 2. * v - 1.;
    Image expected(width, height);
    for (std::size_t i = 0; i < expected.rgba.size(); ++i)
    {
      expected.rgba[i] = static_cast<float>((1. - part) * none.rgba[i] + part * all.rgba[i]);
    }
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      EXPECT_LT(largestDifference(render(ofKernel), expected), 1e-4f) << blending << " on " << kernel;
    });
  }
}

TEST(VolumeScattering, ShadowsAreThoseOfRaysToEverySample)
{
  RandomTree options{ 7, { 1, 1, 1 }, 5, 0.6, 0., true };
  std::vector<LeafCell> cells = makeRandomTree(options);
  // Two balls.
  const auto at = [](const std::array<double, 3>& p) {
    const auto ball = [&](double x, double y, double z) {
      return std::exp(-40. * (std::pow(p[0] - x, 2) + std::pow(p[1] - y, 2) + std::pow(p[2] - z, 2)));
    };
    return ball(0.45, 0.7, 0.5) + ball(0.55, 0.3, 0.5);
  };
  setValues(cells, at);
  const auto field = makeField(unitRoots(options.roots), cells);
  const TransferFunction function(0.1, 1., { { grey.r, grey.g, grey.b, 0.f }, { grey.r, grey.g, grey.b, 25.f } });
  PointSampler sampler(*field);
  const ExtinctionAt extinctionAt = [&](const Vec3& point) {
    double value = 0.;
    return sampler.value(point, value) ? function.at(static_cast<float>(value)).extinction : 0.;
  };
  const DepthOf depthOf = [&](const Vec3& from, const Vec3& way, double length) {
    constexpr int steps = 100;
    double sum = 0.;
    for (int i = 0; i < steps; ++i)
    {
      const double along = cell + (length - cell) * (i + 0.5) / steps;
      sum += extinctionAt({ from[0] + along * way[0], from[1] + along * way[1], from[2] + along * way[2] });
    }
    return sum * (length - cell) / steps;
  };
  const ScatteringView view = views()[0];
  for (const DataLight& light : lights)
  {
    VolumeSettings settings = scattering(view, light);
    settings.samplesPerCell = 16.;
    const Image expected = bruteForce(view, settings, light, extinctionAt, depthOf, 200);
    Image image(width, height);
    renderVolume(*field, function, view.camera(), {}, settings, image);
    EXPECT_LT(meanDifference(image, expected), 3e-3) << light.name;
    settings.shading->scattering->reach = 0.;
    Image without(width, height);
    renderVolume(*field, function, view.camera(), {}, settings, without);
    EXPECT_GT(meanDifference(without, expected), 3e-2) << light.name;
  }
}

// What is kept between frames is of the frame's own functions and lights.
TEST(VolumeScattering, FollowsFunctionsLightsAndGradientOpacity)
{
  const auto field = evenCube();
  const ScatteringView view = views()[0];
  Volume volume = volumeOf(*field, even());
  const auto expectOwn = [&](const VolumeSettings& settings, const char* what) {
    Image kept(width, height);
    volume.render(view.camera(), settings, kept);
    Image own(width, height);
    volumeOf(*field, volume.transferFunction()).render(view.camera(), settings, own);
    EXPECT_EQ(own.rgba, kept.rgba) << what;
    return kept;
  };
  const std::size_t before = volume.keptBytes();
  VolumeSettings settings = scattering(view, lights[0]);
  const Image first = expectOwn(settings, "first");
  EXPECT_GT(volume.keptBytes(), before);
  settings = scattering(view, { "from below", false, unit({ 0.1, 1., 0.3 }) });
  EXPECT_NE(first.rgba, expectOwn(settings, "light").rgba);
  TransferFunction::Entry thin = grey;
  thin.extinction = 0.5f;
  volume.setTransferFunction(TransferFunction(0., 1., { thin, thin }));
  const Image even = expectOwn(settings, "function");
  settings.gradientOpacity = GradientOpacity{ 1., { 0.25f, 1.f } };
  EXPECT_NE(even.rgba, expectOwn(settings, "gradient opacity").rgba);
  settings.shading->scattering.reset();
  expectOwn(settings, "none");
}

TEST(VolumeScattering, RefusesWhatIsNoScattering)
{
  const auto field = evenCube();
  const ScatteringView view = views()[0];
  const auto refused = [&](const auto& change) {
    VolumeSettings settings = scattering(view, lights[0]);
    change(*settings.shading->scattering);
    Image image(width, height);
    EXPECT_THROW(renderVolume(*field, even(), view.camera(), {}, settings, image), Error);
  };
  Volume components = volumeOf(*field, even());
  components.setComponents({ { field, even() } });
  EXPECT_FALSE(components.canScatter());
  Image image(width, height);
  EXPECT_THROW(components.render(view.camera(), scattering(view, lights[0]), image), Error);
  refused([](VolumeScattering& s) { s.blending = 0.f; });
  refused([](VolumeScattering& s) { s.blending = 2.5f; });
  refused([](VolumeScattering& s) { s.reach = -1.; });
  refused([](VolumeScattering& s) { s.anisotropy = 1.f; });
  refused([](VolumeScattering& s) { s.sampleLength = std::numeric_limits<double>::quiet_NaN(); });
}

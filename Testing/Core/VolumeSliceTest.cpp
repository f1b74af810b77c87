// Slices of volumes, on every instruction set and in both precisions: against the field at the points where the pixels'
// rays meet the plane.
#include "Error.h"
#include "Interpolation/Sampler.h"
#include "Support/Cameras.h"
#include "Support/Fields.h"
#include "Support/ImageError.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/PixelHits.h"
#include "Support/RandomTrees.h"
#include "Support/VolumeReference.h"
#include "Support/VolumeViews.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr int width = 61;
constexpr int height = 53;
constexpr float tolerance = 2e-3f;
constexpr double unitDistance = 0.7;
using Entry = TransferFunction::Entry;

std::shared_ptr<const Field> waveField(double missing = 0.)
{
  const RandomTree options{ 31, { 2, 2, 2 }, 5, 0.7, missing, false };
  std::vector<LeafCell> cells = makeRandomTree(options);
  setValues(cells, [](const auto& p) { return std::sin(2. * p[0] + p[1]) * std::cos(1.5 * p[2]); });
  return makeField(unitRoots(options.roots), cells);
}

TransferFunction colors()
{
  return TransferFunction(-1., 1., { { 0.9f, 0.2f, 0.1f, 0.1f }, { 0.3f, 0.7f, 0.9f, 3.f } });
}

VolumeSettings sliceBy(const HalfSpace& plane)
{
  VolumeSettings settings;
  settings.blend = VolumeBlend::Slice;
  settings.slice = plane;
  settings.unitDistance = unitDistance;
  return settings;
}

std::vector<HalfSpace> planes()
{
  return { { { 0., 0., 1. }, 1. }, { { 1., 2., -0.5 }, 2.2 }, { { -3., 0.1, 0.2 }, -4.1 } };
}

/// Of a pixel's ray, between the near and the far plane; NaN is none.
double placeOf(const HalfSpace& plane, const Camera& camera, const Ray& ray)
{
  const double t = (plane.offset - dot(plane.normal, ray.origin)) / dot(plane.normal, ray.direction);
  const bool isSeen = t >= camera.tFromDepth(ray, 0.) && t < camera.tFromDepth(ray, 1.);
  return isSeen ? t : std::numeric_limits<double>::quiet_NaN();
}

std::array<double, 4> rgbaOf(const Entry& entry)
{
  const double opacity = -std::expm1(-entry.extinction * unitDistance);
  return { opacity * entry.r, opacity * entry.g, opacity * entry.b, opacity };
}

/// By a sampler.
Image exactSlice(const std::shared_ptr<const Field>& field, InterpolationMethod method,
  const TransferFunction& function, const HalfSpace& plane, const Camera& camera)
{
  const auto sampler = Sampler::create(method, field);
  Image image(width, height);
  for (int i = 0; i < width * height; ++i)
  {
    const Ray ray = camera.ray(i % width, i / width);
    Vec3 point = pointAt(ray, placeOf(plane, camera, ray));
    for (int a = 0; a < 3; ++a)
    {
      // Rounding would choose one of the sides of what is in a face.
      const bool isAcross = plane.normal[a] * plane.normal[a] == dot(plane.normal, plane.normal);
      point[a] = isAcross && std::isfinite(point[a]) ? plane.offset / plane.normal[a] : point[a];
    }
    FieldSample sample;
    if (sampler->sampleRelative(point, sample))
    {
      const auto rgba = rgbaOf(function.at(static_cast<float>(sample.value)));
      std::copy(rgba.begin(), rgba.end(), image.rgba.begin() + 4 * i);
    }
  }
  return image;
}

void expectPicture(const std::shared_ptr<const Field>& field, const TransferFunction& function,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, const Image& expected,
  const std::string& what)
{
  EXPECT_GT(*std::max_element(expected.rgba.begin(), expected.rgba.end()), 0.2f) << what;
  std::array<Image, 2> firsts{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
  forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
    Image image(width, height);
    renderVolume(*field, function, camera, stops, ofKernel, image);
    EXPECT_LT(partThatDiffers(image, expected, tolerance), 0.003) << what << " on " << kernel;
    Image& first = firsts[ofKernel.doubles];
    first = first.width == 0 ? image : first;
    EXPECT_EQ(image.rgba, first.rgba) << what << " on " << kernel;
  });
}

} // namespace

TEST(VolumeSlice, ShowsTheFieldInThePlane)
{
  // Where steps of a block's values are seen, which light through cells would not show.
  const Entry blue{ 0.f, 0.f, 1.f, 0.5f };
  const Entry orange{ 1.f, 0.5f, 0.f, 3.f };
  const TransferFunction peak = TransferFunction::ofNodes({ { -1., {}, {} }, { 0.1, {}, {} },
    { 0.105, orange, orange }, { 0.11, blue, blue }, { 1., blue, blue } });
  for (const double missing : { 0., 0.1 })
  {
    const auto field = waveField(missing);
    for (const View& view : views())
    {
      const Camera camera(view.clip, identityMatrix, width, height);
      for (const HalfSpace& plane : planes())
      {
        // A ray in a face belongs to either side, of which one may be missing.
        const bool areInFaces = std::string(view.name) == "along an axis";
        for (const TransferFunction& function : { colors(), peak })
        {
          const Image expected = exactSlice(field, InterpolationMethod::GTI, function, plane, camera);
          const bool isSeen = *std::max_element(expected.rgba.begin(), expected.rgba.end()) > 0.2f;
          if (isSeen && !(areInFaces && missing > 0.))
          {
            expectPicture(field, function, camera, {}, sliceBy(plane), expected, view.name);
          }
        }
      }
    }
  }
}

TEST(VolumeSlice, OfCellsThemselves)
{
  const auto field = waveField();
  for (const View& view : { views()[0], views()[3] })
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    for (const HalfSpace& plane : { planes()[1], planes()[2] }) // in no faces of cells
    {
      VolumeSettings settings = sliceBy(plane);
      settings.nearest = true;
      expectPicture(field, colors(), camera, {}, settings,
        exactSlice(field, InterpolationMethod::Nearest, colors(), plane, camera), view.name);
    }
  }
}

TEST(VolumeSlice, LightGradientsAndColorsAreTheReferences)
{
  const auto field = waveField();
  LargeVector<float> others(field->leafValues());
  std::transform(others.begin(), others.end(), others.begin(), [](float v) { return v * v; });
  const auto colored = std::make_shared<const Field>(field->sharedOctree(), std::move(others));
  const TransferFunction byColor(0., 1., { { 0.1f, 0.9f, 0.2f, 1.f }, { 0.9f, 0.1f, 0.4f, 1.f } });
  const ReferenceColors reference{ *colored, byColor };
  VolumeSettings settings = sliceBy(planes()[1]);
  Light light;
  light.positional = true;
  light.position = { 0.3, 1., 0. };
  VolumeShading& shading = settings.shading.emplace();
  shading.ambient = 0.2f;
  shading.specular = 0.4f;
  shading.lightsFromData = lookAt({ 4., 3., 3.5 }, { 1., 1., 1. });
  shading.lights = { light };
  settings.gradientOpacity = GradientOpacity{ 4., { 0.f, 0.1f, 0.8f, 1.f, 0.6f } };
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  for (const bool isNearest : { false, true })
  {
    settings.nearest = isNearest;
    Image expected(width, height);
    renderVolumeReference(*field, colors(), camera, {}, settings, expected, &reference);
    forEachKernel(settings, [&](const std::string& kernel, const VolumeSettings& ofKernel) {
      Volume volume(field, colors());
      volume.setColors(colored, byColor);
      Image image(width, height);
      volume.render(camera, ofKernel, image);
      EXPECT_LT(partThatDiffers(image, expected, tolerance), 0.003) << kernel;
    });
  }
}

TEST(VolumeSlice, IsHiddenCutAndAmongSurfaces)
{
  const auto field = waveField();
  const HalfSpace plane = planes()[1];
  for (const View& view : { views()[0], views()[1], views()[3] })
  {
    const Camera camera(view.clip, identityMatrix, width, height);
    const Image alone = exactSlice(field, InterpolationMethod::GTI, colors(), plane, camera);
    RayStops cut;
    cut.cut.halfSpaces = { { { 1., 0.5, 0.2 }, 0.9 } };
    cut.cut.cropping = CroppingRegions{ { 0.3, 1.4, 0.5, 1.6, 0.2, 1.7 }, 0x5ca3c96 };
    std::vector<float> end(width * height);
    PixelHits hits;
    Image hidden(width, height);
    Image shown(width, height);
    Image layered(width, height);
    const std::array<double, 4> before{ 0.2, 0.9, 0.4, 0.3 };
    const std::array<double, 4> behind{ 0.9, 0.8, 0.7, 0.6 };
    for (int i = 0; i < width * height; ++i)
    {
      const Ray ray = camera.ray(i % width, i / width);
      const double t = placeOf(plane, camera, ray);
      const Vec3 point = pointAt(ray, t);
      const bool isMet = alone.rgba[4 * i + 3] > 0.f;
      end[i] = static_cast<float>(isMet ? camera.depthFromT(ray, t) + (i % 2 == 0 ? 1e-3 : -1e-3) : 1.);
      const bool isShown =
        1. * point[0] + 0.5 * point[1] + 0.2 * point[2] >= 0.9 && cut.cut.cropping->shows(point);
      std::array<double, 4> layers{};
      double passes = 1.;
      const auto add = [&](const std::array<double, 4>& premultiplied) {
        for (int c = 0; c < 4; ++c)
        {
          layers[c] += passes * premultiplied[c];
        }
        passes *= 1. - premultiplied[3];
      };
      const auto premultiplied = [](const std::array<double, 4>& c) {
        return std::array{ c[0] * c[3], c[1] * c[3], c[2] * c[3], c[3] };
      };
      const std::array<float, 4> own{ alone.rgba[4 * i], alone.rgba[4 * i + 1], alone.rgba[4 * i + 2],
        alone.rgba[4 * i + 3] };
      if (isMet)
      {
        const auto rgba = [](const std::array<double, 4>& c) {
          return std::array<float, 4>{ static_cast<float>(c[0]), static_cast<float>(c[1]),
            static_cast<float>(c[2]), static_cast<float>(c[3]) };
        };
        hits.add(0.99 * t, rgba(before));
        hits.add(1.01 * t, rgba(behind));
        add(premultiplied(before));
        add({ own[0], own[1], own[2], own[3] });
        add(premultiplied(behind));
      }
      hits.endPixel();
      for (int c = 0; c < 4; ++c)
      {
        hidden.rgba[4 * i + c] = i % 2 == 0 ? own[c] : 0.f;
        shown.rgba[4 * i + c] = isShown ? own[c] : 0.f;
        layered.rgba[4 * i + c] = static_cast<float>(layers[c]);
      }
    }
    const VolumeSettings settings = sliceBy(plane);
    expectPicture(
      field, colors(), camera, RayStops::depths(nullptr, end.data()), settings, hidden, view.name);
    expectPicture(field, colors(), camera, cut, settings, shown, view.name);
    expectPicture(field, colors(), camera, hits.stops(), settings, layered, view.name);
  }
}

TEST(VolumeSlice, VisitsWhatIsInThePlaneAlone)
{
  const auto field = waveField();
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  Image image(width, height);
  Volume volume(field, colors());
  const VolumeStatistics slice = volume.render(camera, sliceBy(planes()[1]), image);
  EXPECT_LE(slice.samples, static_cast<std::uint64_t>(width) * height);
  const VolumeStatistics all = volume.render(camera, {}, image);
  EXPECT_LT(3 * slice.nodes, all.nodes);
  // Beside the domain, and along rays in parallel.
  for (const HalfSpace& plane : { HalfSpace{ { 0., 0., 1. }, 2.5 }, HalfSpace{ { 0., 0., 1. }, -7. } })
  {
    volume.render(camera, sliceBy(plane), image);
    EXPECT_EQ(*std::max_element(image.rgba.begin(), image.rgba.end()), 0.f);
  }
  const Camera along(views()[4].clip, identityMatrix, width, height);
  volume.render(along, sliceBy({ { 1., 0., 0. }, 0.77 }), image);
  EXPECT_EQ(*std::max_element(image.rgba.begin(), image.rgba.end()), 0.f);
}

TEST(VolumeSlice, RefusesPlanesThatAreNone)
{
  const auto field = waveField();
  const Camera camera(views()[0].clip, identityMatrix, width, height);
  Image image(width, height);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const HalfSpace& plane : { HalfSpace{ { 0., 0., 0. }, 1. }, HalfSpace{ { nan, 0., 1. }, 1. },
         HalfSpace{ { 0., infinity, 1. }, 1. }, HalfSpace{ { 0., 1., 1. }, nan } })
  {
    EXPECT_THROW(renderVolume(*field, colors(), camera, {}, sliceBy(plane), image), Error);
  }
  VolumeSettings settings = sliceBy(planes()[0]);
  settings.unitDistance = 0.;
  EXPECT_THROW(renderVolume(*field, colors(), camera, {}, settings, image), Error);
}

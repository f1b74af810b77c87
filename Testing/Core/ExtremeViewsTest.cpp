// Extreme isovalues, rays and cameras, for the volume renderer and the isosurface. Each case records what it
// measured.
#include "Error.h"
#include "Support/ExactScene.h"
#include "Support/Measured.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The field is z in [0, 2], linear between the centres of the outermost cells, constant beyond.
std::shared_ptr<const Field> slope()
{
  std::vector<LeafCell> cells;
  for (Coord i = 0; i < 512; ++i)
  {
    cells.push_back({ { { i % 8, i / 8 % 8, i / 64 }, 2 }, 0.25f * (static_cast<float>(i / 64) + 0.5f) });
  }
  return makeField(unitRoots({ 2, 2, 2 }), cells);
}

/// Runs along z, through the octants' insides, faces and edges.
std::vector<Ray> raysAlongZ(bool upwards)
{
  std::vector<Ray> rays;
  for (int i = 0; i < 17 * 17; ++i)
  {
    rays.push_back({ { i % 17 / 8., i / 17 / 8., upwards ? -1. : 3. }, { 0., 0., upwards ? 1. : -1. } });
    rays.push_back(rays.back());
    rays.back().origin[0] = std::abs(rays.back().origin[0] - 0.01);
  }
  return rays;
}

/// The largest distance from z of the nearest hits of rays along z; infinite where one is missing, or should be the
/// only one and is not.
double distanceFromPlane(const Isosurface& surface, double z, bool upwards, bool single)
{
  double largest = 0.;
  std::vector<SurfaceHit> all;
  for (const Ray& ray : raysAlongZ(upwards))
  {
    SurfaceHit hit;
    surface.intersectAll(ray, 0., 9., all);
    if (!surface.intersect(ray, 0., 9., hit) || (single && all.size() != 1) || all.front().t != hit.t)
    {
      return infinity;
    }
    largest = std::max(largest, std::abs(ray.origin[2] + hit.t * ray.direction[2] - z));
  }
  return largest;
}

} // namespace

// Isovalues

TEST(ExtremeCases, SurfaceAtTheMinimumAndTheMaximum)
{
  // The outermost half cells are flat on the isovalue: the surface is where they begin, seen from either side. At the least
  // value all is inside, as contours have it.
  const auto field = slope();
  EXPECT_EQ(Isosurface(field, { 0.125 }).octantCount(), 0u);
  const Isosurface surface(field, { 1.875 });
  const double largest =
    std::max(distanceFromPlane(surface, 1.875, true, true), distanceFromPlane(surface, 1.875, false, true));
  expectAtMost(largest, 1e-15, "of the domain's width");
}

TEST(ExtremeCases, SurfaceExactlyAtCellsAndVertices)
{
  // Through cells' centres, and through their faces: each ray has one hit.
  const auto field = slope();
  double largest = 0.;
  for (const double isovalue : { 0.375, 0.5, 1., 1.125, 1.625 })
  {
    const Isosurface surface(field, { isovalue });
    largest = std::max({ largest, distanceFromPlane(surface, isovalue, true, true),
      distanceFromPlane(surface, isovalue, false, true) });
  }
  expectAtMost(largest, 1e-15, "of the domain's width");
}

TEST(ExtremeCases, SurfaceAtValuesOfRandomCells)
{
  const auto cells = randomCells();
  ExactScene scene({ 2, 2, 2 }, cells);
  double largest = 0.;
  for (std::size_t i = 0; i < cells.size(); i += cells.size() / 5)
  {
    largest = std::max(largest, scene.surfaceError(cells[i].value, outside(), std::ldexp(1., -4)));
  }
  EXPECT_GT(scene.hits(), 300u);
  expectAtMost(largest, 1e-5, "of the smallest cell's width");
}

TEST(ExtremeCases, SurfaceOfAConstant)
{
  auto cells = randomCells();
  for (LeafCell& c : cells)
  {
    c.value = 0.7f;
  }
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  // As contours are: nothing passes an isovalue that all values are, or none.
  std::vector<SurfaceHit> hits;
  std::size_t most = 0;
  for (const float isovalue : { 0.7f, std::nextafter(0.7f, 0.f), std::nextafter(0.7f, 1.f), -3e38f, 3e38f })
  {
    const Isosurface surface(field, { isovalue });
    EXPECT_EQ(surface.octantCount(), 0u) << isovalue;
    for (const Ray& ray : raysAlongZ(true))
    {
      surface.intersectAll(ray, 0., 9., hits);
      most = std::max(most, hits.size());
    }
  }
  expectAtMost(static_cast<double>(most), 0., "hits of a ray");
}

TEST(ExtremeCases, SurfaceBesideAnIsovalueFarOutOfRange)
{
  const auto cells = randomCells();
  const auto field = makeField(unitRoots({ 2, 2, 2 }), cells);
  const Isosurface alone(field, { 0.1 });
  double differing = 0.;
  for (const double far : { -1e300, -1e10, 1e10, 1e300 })
  {
    const Isosurface both(field, { 0.1, far });
    HitImage expected;
    HitImage hits;
    alone.render(outside(), SurfaceLayers::All, expected);
    both.render(outside(), SurfaceLayers::All, hits);
    ASSERT_GT(expected.hits.size(), 100u);
    for (std::size_t i = 0; i + 1 < expected.first.size(); ++i)
    {
      const std::size_t count = expected.first[i + 1] - expected.first[i];
      bool same = hits.first[i + 1] - hits.first[i] == count;
      for (std::size_t k = 0; same && k < count; ++k)
      {
        same = hits.hits[hits.first[i] + k].t == expected.hits[expected.first[i] + k].t;
      }
      differing += same ? 0. : 1.;
    }
  }
  expectAtMost(differing, 0., "rays differ");
}

TEST(ExtremeCases, IsovaluesThatAreNotFiniteAreRefused)
{
  const auto field = slope();
  double accepted = 0.;
  for (const double isovalue : { static_cast<double>(NAN), infinity, -infinity })
  {
    try
    {
      const Isosurface surface(field, { 1., isovalue });
      accepted += 1.;
    }
    catch (const Error& error)
    {
      EXPECT_NE(std::string(error.what()).find("allowed are finite values"), std::string::npos);
    }
  }
  expectAtMost(accepted, 0., "accepted");
}

// Rays

namespace
{

/// Parallel rays along an axis, on the planes between and in the middle of cells of level 3: through the faces, edges
/// and corners of their octants.
std::vector<Camera> alongAxes()
{
  std::vector<Camera> cameras;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (const double sign : { -1., 1. })
    {
      for (const double shift : { 0., 0.0625 })
      {
        Matrix4 view{};
        view[(axis + 1) % 3] = 1.;
        view[4 + (axis + 2) % 3] = 1.;
        view[8 + axis] = sign;
        view[3] = -1. - shift;
        view[7] = -1.;
        view[11] = -4. - sign;
        view[15] = 1.;
        cameras.emplace_back(multiply(parallel(2., 1., 9.), view), identityMatrix, 32, 32);
      }
    }
  }
  return cameras;
}

/// Perspective, from places in and on cells of level 3, with rays in the planes through them, and from places on the
/// domain's faces, without.
std::vector<Camera> fromPlaces()
{
  struct Place
  {
    Vec3 eye;
    int pixels;
  };
  const Place places[]{ { { 1., 1., 1. }, 15 }, { { 1., 1., 0.6 }, 15 }, { { 1., 0.7, 0.6 }, 15 },
    { { 0.625, 0.7, 0.6 }, 15 }, { { 0.5625, 0.5625, 0.5625 }, 15 }, { { 1.03, 0.72, 0.61 }, 15 },
    { { 2., 0.7, 0.6 }, 16 }, { { 0., 0.7, 0.6 }, 16 }, { { 0., 0., 0. }, 16 }, { { 2., 2., 2. }, 16 } };
  std::vector<Camera> cameras;
  for (const auto& [eye, pixels] : places)
  {
    for (const double sign : { -1., 1. })
    {
      const Matrix4 view{ 1, 0, 0, -eye[0], 0, 1, 0, -eye[1], 0, 0, sign, -sign * eye[2], 0, 0, 0, 1 };
      cameras.emplace_back(multiply(perspective(60., 1e-3, 9.), view), identityMatrix, pixels, pixels);
    }
    cameras.emplace_back(
      multiply(perspective(90., 1e-3, 9.), lookAt(eye, { 1.1, 0.9, 1.2 })), identityMatrix, 9, 9);
  }
  return cameras;
}

} // namespace

TEST(ExtremeCases, VolumeByRaysInFacesAndEdges)
{
  ExactScene scene({ 2, 2, 2 }, makeRandomTree({ 3, { 2, 2, 2 }, 3, 0.7, 0., false }));
  double largest = 0.;
  for (const Camera& camera : alongAxes())
  {
    largest = std::max(largest, scene.volumeError(smooth(10.), camera));
  }
  EXPECT_GT(scene.brightest(), 0.8);
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceByRaysInFacesAndEdges)
{
  ExactScene scene({ 2, 2, 2 }, makeRandomTree({ 3, { 2, 2, 2 }, 3, 0.7, 0., false }));
  double largest = 0.;
  for (const Camera& camera : alongAxes())
  {
    largest = std::max(largest, scene.surfaceError(0.1, camera, 0.125));
  }
  EXPECT_GT(scene.hits(), 1000u);
  expectAtMost(largest, 1e-5, "of the smallest cell's width");
}

TEST(ExtremeCases, VolumeFromVerticesFacesAndInside)
{
  ExactScene scene({ 2, 2, 2 }, makeRandomTree({ 3, { 2, 2, 2 }, 3, 0.7, 0., false }));
  double largest = 0.;
  for (const Camera& camera : fromPlaces())
  {
    largest = std::max(largest, scene.volumeError(smooth(10.), camera));
  }
  EXPECT_GT(scene.brightest(), 0.8);
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceFromVerticesFacesAndInside)
{
  ExactScene scene({ 2, 2, 2 }, makeRandomTree({ 3, { 2, 2, 2 }, 3, 0.7, 0., false }));
  double largest = 0.;
  for (const Camera& camera : fromPlaces())
  {
    largest = std::max(largest, scene.surfaceError(0.1, camera, 0.125));
  }
  EXPECT_GT(scene.hits(), 1000u);
  expectAtMost(largest, 1e-5, "of the smallest cell's width");
}

TEST(ExtremeCases, RaysWithoutALengthOrANumberHitNothing)
{
  const Isosurface surface(makeField(unitRoots({ 2, 2, 2 }), randomCells()), { 0.1 });
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Vec3 inside{ 1.03, 0.72, 0.61 };
  const Ray rays[]{ { inside, { 0., 0., 0. } }, { { 5., 5., 5. }, { 0., 0., 0. } },
    { inside, { nan, nan, nan } }, { inside, { nan, 1., 0. } }, { { nan, nan, nan }, { 1., 0., 0. } },
    { { nan, 0.7, 0.6 }, { 0., 1., 0. } }, { { infinity, 0.7, 0.6 }, { -1., 0., 0. } },
    { inside, { infinity, 0., 0. } } };
  double hits = 0.;
  std::vector<SurfaceHit> all;
  for (const Ray& ray : rays)
  {
    for (const double end : { 9., infinity, nan })
    {
      SurfaceHit hit;
      surface.intersectAll(ray, 0., end, all);
      hits += static_cast<double>(all.size()) + surface.intersect(ray, 0., end, hit) +
        surface.occluded(ray, 0., end);
    }
  }
  expectAtMost(hits, 0., "hits");
}

// Cameras

namespace
{

constexpr int widePixels = 16384;

/// From the distance at which the domain fills the picture, and through it; from nearby.
std::vector<Camera> angles()
{
  const auto camera = [](double degrees, double distance, double near, double far) {
    const Vec3 eye{ 1. + 0.6 * distance, 1. + 0.64 * distance, 1. + 0.48 * distance };
    return Camera(
      multiply(perspective(degrees, near, far), lookAt(eye, { 1., 1., 1. })), identityMatrix, 13, 13);
  };
  return { camera(0.001, 1.5e5, 1.4e5, 1.6e5), camera(0.001, 4., 0.1, 9.), camera(179., 0.02, 1e-4, 9.),
    camera(179., 1.8, 1e-4, 9.) };
}

} // namespace

TEST(ExtremeCases, VolumeAtAnglesFromAThousandthTo179Degrees)
{
  ExactScene scene({ 2, 2, 2 }, randomCells());
  double largest = 0.;
  for (const Camera& camera : angles())
  {
    largest = std::max(largest, scene.volumeError(smooth(10.), camera));
  }
  EXPECT_GT(scene.brightest(), 0.8);
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceAtAnglesFromAThousandthTo179Degrees)
{
  ExactScene scene({ 2, 2, 2 }, randomCells());
  double largest = 0.;
  for (const Camera& camera : angles())
  {
    largest = std::max(largest, scene.surfaceError(0.1, camera, std::ldexp(1., -4)));
  }
  EXPECT_GT(scene.hits(), 300u);
  expectAtMost(largest, 1e-5, "of the smallest cell's width");
}

TEST(ExtremeCases, CameraRaysAtAnglesFromAThousandthTo179Degrees)
{
  // Against their slopes by hand.
  double largest = 0.;
  for (const double degrees : { 0.001, 1., 90., 179. })
  {
    constexpr int width = 31;
    const Vec3 eye{ 0.3, -0.2, 5. };
    const Matrix4 view{ 1, 0, 0, -eye[0], 0, 1, 0, -eye[1], 0, 0, 1, -eye[2], 0, 0, 0, 1 };
    const Camera camera(multiply(perspective(degrees, 0.1, 9.), view), identityMatrix, width, width);
    const double pixel = 2. * std::tan(degrees * std::numbers::pi / 360.) / width;
    for (int i = 0; i < width * width; ++i)
    {
      const Ray ray = camera.ray(i % width, i / width);
      const int steps[]{ i % width - width / 2, i / width - width / 2 };
      for (int a = 0; a < 2; ++a)
      {
        largest = std::max(largest, std::abs(-ray.direction[a] / ray.direction[2] / pixel - steps[a]));
      }
    }
  }
  expectAtMost(largest, 1e-6, "of a pixel");
}

namespace
{

/// Pictures so wide of a point, from two sides: parallel and by a narrow angle. The domain's upper corner is an outline
/// in all.
std::vector<Camera> closeUps(const Vec3& point, double pictureWidth)
{
  std::vector<Camera> cameras;
  for (const double sign : { 1., -1. })
  {
    const Vec3 eye{ point[0] + sign * 3.2, point[1] - sign * 2.3, point[2] + sign * 2.7 };
    const Matrix4 view = lookAt(eye, point);
    const double distance = std::sqrt(dot(eye, eye) - 2. * dot(eye, point) + dot(point, point));
    cameras.emplace_back(multiply(parallel(0.5 * pictureWidth, 0.1, 9.), view), identityMatrix, 9, 9);
    cameras.emplace_back(
      multiply(perspective(pictureWidth / distance * 180. / std::numbers::pi, 0.1, 9.), view), identityMatrix,
      9, 9);
  }
  return cameras;
}

} // namespace

TEST(ExtremeCases, VolumeZoomedUpTo1e11Times)
{
  // Into the domain's corner, where rays leave a medium before it is opaque, of layers so dense that sums over the table
  // cap them; and to an edge of cells inside, with what the picture shows of it before everything.
  double largest = 0.;
  for (const double zoom : { 1e6, 1e8, 1e10, 1e11 })
  {
    ExactScene scene({ 2, 2, 2 }, makeRandomTree({ 3, { 2, 2, 2 }, 3, 0.7, 0., false }));
    auto layers = smooth(10. * zoom).entries();
    for (std::size_t i = 0; i < layers.size(); ++i)
    {
      layers[i].extinction *= i % 2000 < 1500 ? 1.f : 0.f;
    }
    for (const Camera& camera : closeUps({ 2., 2., 2. }, 1. / zoom))
    {
      largest = std::max(largest, scene.volumeError(TransferFunction(-1., 1., layers), camera));
    }
    EXPECT_GT(scene.brightest(), 0.5) << zoom;
    for (const Camera& camera : closeUps({ 1., 0.75, 1.25 }, 1. / zoom))
    {
      largest = std::max(largest, scene.volumeError(smooth(0.5), camera));
    }
  }
  expectAtMost(largest, halfAStep, "of a channel");
}

TEST(ExtremeCases, VolumeInPicturesOfOnePixelAndOf16384x2)
{
  ExactScene scene({ 2, 2, 2 }, randomCells());
  const double one = scene.volumeError(smooth(10.), outside(1, 1));
  const double wide = scene.volumeError(smooth(10.), outside(widePixels, 2), 97);
  EXPECT_GT(scene.brightest(), 0.8);
  expectAtMost(std::max(one, wide), halfAStep, "of a channel");
}

TEST(ExtremeCases, SurfaceInPicturesOfOnePixelAndOf16384x2)
{
  ExactScene scene({ 2, 2, 2 }, randomCells());
  const double one = scene.surfaceError(0.1, outside(1, 1), std::ldexp(1., -4));
  const double wide = scene.surfaceError(0.1, outside(widePixels, 2), std::ldexp(1., -4), 97);
  EXPECT_GT(scene.hits(), 100u);
  expectAtMost(std::max(one, wide), 1e-5, "of the smallest cell's width");
}

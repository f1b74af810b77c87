// A tree whose pictures are compared with the exact answer along each ray.
#pragma once

#include "Support/Cameras.h"
#include "Support/ExactRay.h"
#include "Support/Fields.h"
#include "Support/Kernels.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Surface/Isosurface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace treeamr::test
{

/// Of a colour's channel: no 8-bit picture shows it.
inline constexpr double halfAStep = 0.5 / 255.;

/// A tree, its domain and the exact answer for world rays.
class ExactScene
{
public:
  ExactScene(const RootGrid& grid, const std::vector<LeafCell>& cells)
    : grid_(grid)
    , field_(makeField(grid, cells))
    , exact_(grid.roots(), cells)
  {
  }
  ExactScene(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells)
    : ExactScene(unitRoots(roots), cells)
  {
  }

  /// The largest error of a channel over every `stride`th pixel, with float and double lanes, infinite where instruction
  /// sets differ.
  double volumeError(const TransferFunction& transferFunction, const Camera& camera, int stride = 1,
    double samplesPerCell = 16.)
  {
    VolumeSettings settings;
    settings.samplesPerCell = samplesPerCell;
    std::array<Image, 2> images{ Image(0, 0), Image(0, 0) }; // of floats, of doubles
    double largest = 0.;
    forEachKernel(settings, [&](const std::string& /*kernel*/, const VolumeSettings& ofKernel) {
      Image again(camera.width(), camera.height());
      renderVolume(*field_, transferFunction, camera, {}, ofKernel, again);
      Image& image = images[ofKernel.doubles];
      image = image.width == 0 ? again : image;
      largest = image.rgba == again.rgba ? largest : std::numeric_limits<double>::infinity();
    });
    for (int i = 0; i < camera.width() * camera.height(); i += stride)
    {
      const Ray ray = camera.ray(i % camera.width(), i / camera.width());
      const auto expected =
        exact_.light(toRoots(ray), camera.tFromDepth(ray, 0.), camera.tFromDepth(ray, 1.), transferFunction);
      brightest_ = std::max(brightest_, expected[3]);
      for (const Image& image : images)
      {
        for (int c = 0; c < 4; ++c)
        {
          const double error = std::abs(image.rgba[4 * static_cast<std::size_t>(i) + c] - expected[c]);
          largest = error <= largest ? largest : error; // NaN counts
        }
      }
    }
    return largest;
  }
  /// The most opaque pixel so far.
  double brightest() const { return brightest_; }

  /// The largest error of a hit's t in `unit`, infinite where hits are missing or too many.
  double surfaceError(double isovalue, const Camera& camera, double unit, int stride = 1)
  {
    const Isosurface surface(field_, { isovalue });
    HitImage image;
    surface.render(camera, SurfaceLayers::All, image);
    double largest = 0.;
    for (int i = 0; i < camera.width() * camera.height(); i += stride)
    {
      const Ray ray = camera.ray(i % camera.width(), i / camera.width());
      auto expected =
        exact_.crossings(toRoots(ray), camera.tFromDepth(ray, 0.), camera.tFromDepth(ray, 1.), isovalue);
      // Hits that double precision does not tell apart are one.
      constexpr double same = 0x1p-40;
      expected.erase(std::unique(expected.begin(), expected.end(),
                       [&](double a, double b) { return b - a < same * unit; }),
        expected.end());
      hits_ += expected.size();
      if (image.first[i + 1] - image.first[i] != expected.size())
      {
        return std::numeric_limits<double>::infinity();
      }
      for (std::size_t k = 0; k < expected.size(); ++k)
      {
        const double error = std::abs(image.hits[image.first[i] + k].t - expected[k]) / unit;
        largest = error <= largest ? largest : error;
      }
    }
    return largest;
  }
  /// Of surfaces so far.
  std::size_t hits() const { return hits_; }

private:
  Ray toRoots(const Ray& world) const
  {
    const Bounds domain = grid_.bounds();
    Ray ray;
    for (int a = 0; a < 3; ++a)
    {
      const double width = (domain.max[a] - domain.min[a]) / grid_.roots()[a];
      ray.origin[a] = (world.origin[a] - domain.min[a]) / width;
      ray.direction[a] = world.direction[a] / width;
    }
    return ray;
  }

  RootGrid grid_;
  std::shared_ptr<const Field> field_;
  ExactRay exact_;
  double brightest_ = 0.;
  std::size_t hits_ = 0;
};

/// Of values in [-scale, scale], with extinctions per world length up to about `extinction`.
inline TransferFunction smooth(double extinction, double scale = 1.)
{
  constexpr int last = 1 << 16;
  std::vector<TransferFunction::Entry> entries;
  for (int i = 0; i <= last; ++i)
  {
    const float u = static_cast<float>(i) / last;
    const float rise = std::max(0.f, 2.f * u - 0.8f);
    entries.push_back({ u, 1.f - u, 0.5f, static_cast<float>(extinction) * rise * rise });
  }
  return TransferFunction(-scale, scale, entries);
}

inline std::vector<LeafCell> randomCells()
{
  return makeRandomTree({ 12, { 2, 2, 2 }, 4, 0.6, 0., false });
}

/// Of two roots along each axis.
inline Camera outside(int width = 13, int height = 11)
{
  return Camera(multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, { 1., 1., 1. })), identityMatrix,
    width, height);
}

} // namespace treeamr::test

// Volumes and isosurfaces among rectangles, and the layers of them along each pixel's line of sight.
#pragma once

#include "RenderingScene.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace treeamr::test
{

inline constexpr Color orange{ 0.9, 0.5, 0.2 };
inline constexpr Color background{ 0.1, 0.2, 0.3 };
inline constexpr double extinction = 0.8;

/// The depth buffer's last bit, as a distance within the clipping range, times the extinction.
inline constexpr double floatTolerance = 2e-5;
/// Blending in 8 bits rounds the factor, the products and their sum.
inline constexpr double eightBits = 1.5 / 255.;

struct Rectangle
{
  Point center;
  Point halfU;
  Point halfV;
  Color color;
  double opacity = 1.;
};

inline Point cross(const Point& a, const Point& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

inline double dot(const Point& a, const Point& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A rectangle across the view, on the line from the focal point to the camera: 0 is the centre of the box.
inline Rectangle facingRectangle(
  double towardsCamera, double halfSize, const Color& color, double opacity = 1.)
{
  Rectangle r;
  r.center = { 0.55 * towardsCamera, 0.4 * towardsCamera, 0.75 * towardsCamera };
  r.halfU = { 0.8 * halfSize, 0., -0.6 * halfSize };
  r.halfV = { -0.2 * halfSize, 0.95 * halfSize, -0.25 * halfSize };
  r.color = color;
  r.opacity = opacity;
  return r;
}

/// Obliquely through the box.
inline Rectangle obliqueRectangle(const Color& color, double opacity = 1.)
{
  return { { 0.1, 0., 0.2 }, { 1.3, 0.3, -0.4 }, { -0.3, 0.9, 0.9 }, color, opacity };
}

class CompositingTest : public RenderingTest
{
protected:
  struct Order
  {
    /// VTK's approximation without depth peeling for volumes: the whole volume over all translucent polygons.
    bool volumeOverTranslucent = false;
    /// Pixels left out at most, for the polygons' edges.
    double maxLeftOut = 0.25;
  };

  static void addRectangles(Scene& scene, const std::vector<Rectangle>& rectangles)
  {
    for (const Rectangle& r : rectangles)
    {
      scene.addRectangle(r.center, r.halfU, r.halfV, r.color, r.opacity);
    }
  }

  static std::optional<double> hit(const PixelRay& ray, const Rectangle& r)
  {
    const double s = Scene::meet(ray, r.center, cross(r.halfU, r.halfV));
    if (!(s > 0. && s < 1.))
    {
      return {};
    }
    const Point p = ray.at(s);
    const Point d{ p[0] - r.center[0], p[1] - r.center[1], p[2] - r.center[2] };
    // The halves need not be orthogonal.
    const Point n = cross(r.halfU, r.halfV);
    const double u = dot(cross(d, r.halfV), n) / dot(n, n);
    const double v = dot(cross(r.halfU, d), n) / dot(n, n);
    return std::abs(u) <= 1. && std::abs(v) <= 1. ? std::optional(s) : std::nullopt;
  }

  /// Whether some rectangle's edge passes through the pixel or close by.
  static bool isEdge(const Scene& scene, int x, int y, const std::vector<Rectangle>& rectangles)
  {
    for (const Rectangle& r : rectangles)
    {
      const bool inside = hit(scene.ray(x, y), r).has_value();
      for (int i = 0; i < 25; ++i)
      {
        if (hit(scene.ray(x + 0.5 * (i % 5 - 2), y + 0.5 * (i / 5 - 2)), r).has_value() != inside)
        {
          return true;
        }
      }
    }
    return false;
  }

  static Color expected(
    const PixelRay& ray, vtkVolume* volume, const std::vector<Rectangle>& rectangles, const Order& order)
  {
    std::vector<std::pair<double, const Rectangle*>> hits;
    for (const Rectangle& r : rectangles)
    {
      if (const auto s = hit(ray, r))
      {
        hits.emplace_back(*s, &r);
      }
    }
    std::sort(hits.begin(), hits.end());
    double entry = 2.;
    double exit = 2.;
    if (!volume || !Scene::chord(ray, volume, Box(), entry, exit))
    {
      entry = exit = 2.;
    }
    const auto segment = [&](double from, double to) {
      const double length = std::max(0., std::min(to, exit) - std::max(from, entry)) * ray.length();
      return Layer{ orange, -std::expm1(-extinction * length) };
    };
    std::vector<Layer> layers;
    double reached = 0.;
    double end = 1.;
    for (const auto& [s, rectangle] : hits)
    {
      if (!order.volumeOverTranslucent)
      {
        layers.push_back(segment(reached, s));
        reached = s;
      }
      layers.push_back({ rectangle->color, rectangle->opacity });
      if (rectangle->opacity >= 1.)
      {
        end = s;
        break;
      }
    }
    if (order.volumeOverTranslucent)
    {
      layers.insert(layers.begin(), segment(0., end));
    }
    else
    {
      layers.push_back(segment(reached, end));
    }
    return composite(layers, background);
  }

  static void expectLayers(Scene& scene, vtkVolume* volume, const std::vector<Rectangle>& rectangles,
    double tolerance, const Order& order)
  {
    scene.renderer->SetBackground(background.data());
    const auto pixels = scene.render();
    int leftOut = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        if (isEdge(scene, x, y, rectangles))
        {
          ++leftOut;
          continue;
        }
        const Color color = expected(scene.ray(x, y), volume, rectangles, order);
        for (int c = 0; c < 3; ++c)
        {
          ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], color[c], tolerance)
            << "channel " << c << " of pixel " << x << ", " << y;
        }
      }
    }
    EXPECT_LT(leftOut, order.maxLeftOut * static_cast<double>(pixels.size()));
  }
  static void expectLayers(
    Scene& scene, vtkVolume* volume, const std::vector<Rectangle>& rectangles, double tolerance)
  {
    expectLayers(scene, volume, rectangles, tolerance, {});
  }

  static vtkVolume* addBox(Scene& scene)
  {
    return scene.addVolume(makeTestGrid(), "one", orange, extinction);
  }

  static void peel(Scene& scene, int peels)
  {
    scene.renderer->SetUseDepthPeeling(true);
    scene.renderer->SetUseDepthPeelingForVolumes(true);
    scene.renderer->SetMaximumNumberOfPeels(peels);
    scene.renderer->SetOcclusionRatio(0.);
  }
};

inline constexpr Color blue{ 0.2, 0.3, 0.9 };
inline constexpr Color green{ 0.1, 0.8, 0.3 };
inline constexpr Color white{ 1., 1., 1. };
inline constexpr Color red{ 0.8, 0.1, 0.1 };

// The surface z = 0.1 is a rectangle, but for the half cells at the domain's edge.
class SurfaceCompositingTest : public CompositingTest
{
protected:
  static constexpr double level = 0.1;
  static Rectangle surface(const Color& color, double opacity = 1.)
  {
    return { { 0., 0., level }, { 1., 0., 0. }, { 0., 1., 0. }, color, opacity };
  }
  static vtkActor* addSurface(Scene& scene, vtkHyperTreeGrid* grid, const Color& color, double opacity = 1.)
  {
    vtkActor* actor = scene.addIsosurface(grid, "z", level);
    actor->GetProperty()->LightingOff();
    actor->GetProperty()->SetColor(color[0], color[1], color[2]);
    actor->GetProperty()->SetOpacity(opacity);
    return actor;
  }
};

} // namespace treeamr::test

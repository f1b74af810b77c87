// The isosurface that most tests look at: a plane, where the reconstruction is exact.
#pragma once

#include "RenderingScene.h"

#include "vtkMatrix4x4.h"

#include <cmath>

namespace treeamr::test
{

/// The depth buffer's step, and the field's values in single precision.
inline constexpr double depthTolerance = 1e-6;

/// Half a root cell from the domain's edge the field is extrapolated: compare inside.
inline constexpr double reach = 0.75;

inline bool isInside(const Point& p, double within = reach)
{
  return std::abs(p[0]) <= within && std::abs(p[1]) <= within && std::abs(p[2]) <= within;
}

inline double windowDepth(const Scene& scene, const Point& p)
{
  vtkMatrix4x4* clipFromWorld = scene.renderer->GetActiveCamera()->GetCompositeProjectionTransformMatrix(
    scene.renderer->GetTiledAspectRatio(), -1., 1.);
  const double in[4] = { p[0], p[1], p[2], 1. };
  double out[4];
  clipFromWorld->MultiplyPoint(in, out);
  return 0.5 * out[2] / out[3] + 0.5;
}

class PlaneSurfaceTest : public RenderingTest
{
protected:
  /// f = (p - center) . normal, whose surface 0 is the plane, on a grid with two levels of refinement.
  static constexpr Point center{ 0.05, 0.1, -0.1 };
  static constexpr Point normal{ 0.3, 0.5, 0.6 };
  static vtkSmartPointer<vtkHyperTreeGrid> planeGrid()
  {
    GridOptions options;
    options.roots = { 4, 4, 4 };
    options.refine = [](const Point& c, int level) { return level < 2 && c[0] + c[2] > 0.1; };
    return makeGrid(options,
      { { "plane",
          [](const Point& p) {
            double f = 0.;
            for (int a = 0; a < 3; ++a)
            {
              f += (p[a] - center[a]) * normal[a];
            }
            return f;
          } },
        { "x", [](const Point& p) { return p[0]; } }, { "y", [](const Point& p) { return p[1]; } } });
  }
  /// The same plane as a polygon.
  static vtkActor* addPolygon(Scene& scene)
  {
    const Point u{ 1.2, 0., -0.6 };
    const Point v{ normal[1] * u[2] - normal[2] * u[1], normal[2] * u[0] - normal[0] * u[2],
      normal[0] * u[1] - normal[1] * u[0] };
    return scene.addRectangle(
      center, { 2. * u[0], 2. * u[1], 2. * u[2] }, { 2. * v[0], 2. * v[1], 2. * v[2] }, { 1., 1., 1. });
  }

  static void expectPlaneDepths(Scene& scene, vtkActor* actor, double within = reach)
  {
    scene.render();
    const std::vector<float> depths = scene.depths();
    int compared = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const PixelRay dataRay = Scene::inDataOf(actor, ray);
        const double s = Scene::meet(dataRay, center, normal);
        if (!(s > 0. && s < 1.) || !isInside(dataRay.at(s), within))
        {
          continue;
        }
        ++compared;
        ASSERT_NEAR(depths[static_cast<std::size_t>(y) * scene.width() + x], windowDepth(scene, ray.at(s)),
          depthTolerance)
          << "pixel " << x << ", " << y;
      }
    }
    EXPECT_GT(compared, scene.width() * scene.height() / 20);
  }
};

} // namespace treeamr::test

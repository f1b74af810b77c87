#include "IsosurfaceError.h"

#include "Contour/Contour.h"
#include "Convergence.h"
#include "Meter.h"
#include "Scene.h"
#include "Support/Cameras.h"
#include "Support/LevelCrossings.h"
#include "Support/RefinedTrees.h"
#include "Surface/Isosurface.h"
#include "Surface/SurfaceFrame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <utility>

namespace treeamr::report
{

namespace
{

using namespace test;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

struct SurfaceErrors
{
  ErrorNorms distance;
  ErrorNorms angle;    // degrees
  ErrorNorms gradient; // of a unit vector

  /// normal: of any length, towards higher values.
  void add(const AnalyticSurface& surface, const Vec3& p, const Vec3& normal)
  {
    addAngle(surface, p, normal, gradientOf(surface.field, p));
  }
  void addGradient(const AnalyticSurface& surface, const Vec3& p, const Vec3& ofField)
  {
    const Vec3 exact = gradientOf(surface.field, p);
    addAngle(surface, p, ofField, exact);
    gradient.add(std::hypot(ofField[0] - exact[0], ofField[1] - exact[1], ofField[2] - exact[2]));
  }

private:
  void addAngle(const AnalyticSurface& surface, const Vec3& p, const Vec3& normal, const Vec3& exact)
  {
    distance.add(std::abs(surface.field(p) - surface.isovalue));
    angle.add(degreesBetween(normal, exact));
  }
};

/// What a row is made of.
struct Result
{
  const char* method;
  SurfaceErrors errors;
  double cpuBuild;
  double cpuFrame = none;
  double cpuFirstFrame = none;
  double triangles = none;
  double openEdges = none;
  /// Largest turn where levels meet, in degrees, and that of the trilinear pieces' own gradients.
  double jump = none;
  double jumpOfPieces = none;
};

/// Over random crossings of faces where levels meet; none where there are no such.
void measureJumps(const Field& field, const Isosurface& isosurface, Result& result)
{
  LevelCrossings across(field, isosurface);
  std::array<SurfaceHit, 4> hits;
  for (int i = 0; i < 100000; ++i)
  {
    const int levels = 1 + i % LevelCrossings::mostLevels;
    if (across.has(levels) && across.cross(levels, hits))
    {
      result.jump = std::fmax(result.jump, jumpOf(hits, normalOf));
      result.jumpOfPieces =
        std::fmax(result.jumpOfPieces, jumpOf(hits, [](const SurfaceHit& hit) { return hit.gradient; }));
    }
  }
}

Result measureImplicit(const std::shared_ptr<const Field>& field, const AnalyticSurface& surface)
{
  Result result{ "implicit", {}, 0. };
  const Camera camera = bench::makeCamera();
  std::unique_ptr<Isosurface> isosurface;
  HitImage image;
  result.cpuBuild = bench::best([&] { isosurface.reset(); },
    [&] {
      isosurface = std::make_unique<Isosurface>(field, std::vector<double>{ surface.isovalue });
    }).cpu;
  const auto frame = [&] { isosurface->render(camera, SurfaceLayers::Nearest, image); };
  result.cpuFirstFrame = bench::measure(frame).cpu;
  result.cpuFrame = bench::best(frame).cpu;
  isosurface->render(camera, SurfaceLayers::All, image);
  for (int y = 0; y < camera.height(); ++y)
  {
    for (int x = 0; x < camera.width(); ++x)
    {
      const std::size_t pixel = x + static_cast<std::size_t>(camera.width()) * y;
      const Ray ray = camera.ray(x, y);
      for (std::size_t h = image.first[pixel]; h < image.first[pixel + 1]; ++h)
      {
        result.errors.add(surface, pointAt(ray, image.hits[h].t), normalOf(image.hits[h]));
      }
    }
  }
  measureJumps(*field, *isosurface, result);
  return result;
}

/// That only one triangle has.
std::size_t countOpenEdges(const ContourMesh& mesh)
{
  std::vector<std::pair<std::int64_t, std::int64_t>> edges;
  for (const auto& t : mesh.triangles)
  {
    for (int i = 0; i < 3; ++i)
    {
      edges.push_back(std::minmax(t[i], t[(i + 1) % 3]));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (std::size_t i = 0; i < edges.size();)
  {
    const auto end =
      std::find_if(edges.begin() + i, edges.end(), [&](const auto& e) { return e != edges[i]; });
    const auto count = static_cast<std::size_t>(end - edges.begin()) - i;
    open += count == 1;
    i += count;
  }
  return open;
}

/// Twice the triangle's area long, towards lower values.
Vec3 triangleNormal(const ContourMesh& mesh, const std::array<std::int64_t, 3>& t)
{
  return cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]);
}

/// Calls f(triangle, weights of its points) for points spread evenly over the mesh.
template <class F>
void forEvenPoints(const ContourMesh& mesh, std::size_t count, const F& f)
{
  std::vector<double> sums; // of areas up to each triangle's end
  for (const auto& t : mesh.triangles)
  {
    const Vec3 normal = triangleNormal(mesh, t);
    sums.push_back((sums.empty() ? 0. : sums.back()) + std::sqrt(dot(normal, normal)));
  }
  std::mt19937 random(23);
  std::uniform_real_distribution<double> unit(0., 1.);
  std::size_t triangle = 0;
  for (std::size_t i = 0; i < count; ++i)
  {
    const double at = (static_cast<double>(i) + unit(random)) / static_cast<double>(count) * sums.back();
    while (triangle + 1 < sums.size() && sums[triangle] < at)
    {
      ++triangle;
    }
    const double s = std::sqrt(unit(random));
    const double w = unit(random) * s;
    f(mesh.triangles[triangle], Vec3{ 1. - s, s - w, w });
  }
}

std::vector<Result> measureContour(const Field& field, const AnalyticSurface& surface)
{
  ContourMesh mesh;
  const auto cpu = [&](bool gradients) {
    return bench::best([&] { mesh = {}; }, [&] { mesh = contour(field, surface.isovalue, { gradients }); })
      .cpu;
  };
  Result flat{ "contour-flat", {}, cpu(false) };
  Result vertices{ "contour-vertices", {}, cpu(true) };
  Result smooth{ "contour-smooth", {}, vertices.cpuBuild };
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    const auto& [x, y, z] = mesh.gradients[i];
    vertices.errors.addGradient(surface, mesh.points[i], { x, y, z });
  }
  forEvenPoints(mesh, 200000, [&](const std::array<std::int64_t, 3>& t, const Vec3& weights) {
    Vec3 p{};
    Vec3 gradient{};
    for (int c = 0; c < 3; ++c)
    {
      const Vec3 n =
        normalized({ mesh.gradients[t[c]][0], mesh.gradients[t[c]][1], mesh.gradients[t[c]][2] });
      for (int a = 0; a < 3; ++a)
      {
        p[a] += weights[c] * mesh.points[t[c]][a];
        gradient[a] += weights[c] * n[a];
      }
    }
    const Vec3 down = triangleNormal(mesh, t);
    flat.errors.add(surface, p, { -down[0], -down[1], -down[2] });
    smooth.errors.add(surface, p, gradient);
  });
  const auto open = static_cast<double>(countOpenEdges(mesh));
  std::vector<Result> results{ vertices, flat, smooth };
  for (Result& result : results)
  {
    result.triangles = static_cast<double>(mesh.triangles.size());
    result.openEdges = open;
  }
  return results;
}

/// Of one method, from coarse to fine.
struct History
{
  std::vector<ErrorNorms> distance;
  std::vector<ErrorNorms> angle;
  std::vector<ErrorNorms> gradient;
};

std::vector<bench::Figure> errorFigures(
  const BaseTree& tree, int refinement, double cells, const Result& result)
{
  const double h = tree.finestWidth(refinement);
  const ErrorNorms& distance = result.errors.distance;
  const ErrorNorms& angle = result.errors.angle;
  const ErrorNorms& gradient = result.errors.gradient;
  return {
    { "refinement", static_cast<double>(refinement) },
    { "h", h, "h", 5 },
    { "cells", cells, "cells" },
    { "cpu_s_build", result.cpuBuild, "build CPU-s", 4 },
    { "cpu_s_frame", result.cpuFrame, "frame CPU-s", 3 },
    { "cpu_s_first_picture", result.cpuBuild + result.cpuFirstFrame, "first picture", 3 },
    { "points", static_cast<double>(distance.count()), "points" },
    { "distance_max", distance.max(), "1e-6 max", 2, 1e6 },
    { "distance_mean", distance.mean(), "1e-6 mean", 3, 1e6 },
    { "distance_max_h", distance.max() / h, "max/h", 4 },
    { "distance_mean_h", distance.mean() / h, "mean/h", 5 },
    { "angle_max_degrees", angle.max(), "max degrees", 3 },
    { "angle_mean_degrees", angle.mean(), "mean degrees", 4 },
    { "gradient_max", gradient.count() > 0 ? gradient.max() : none, "of gradients", 4 },
    { "gradient_mean", gradient.mean(), "mean", 5 },
    { "jump_degrees", result.jump, "jump", 5 },
    { "jump_of_pieces_degrees", result.jumpOfPieces, "of pieces", 1 },
    { "triangles", result.triangles, "triangles" },
    { "open_edges", result.openEdges, "open edges" },
  };
}

/// From which on errors fall with their order: the largest cells are small beside the surfaces, and where cells four
/// levels smaller lie beside such, half as large.
int coarsestRefinement(const BaseTree& tree)
{
  return tree.levels < 4 ? 2 : 3;
}

/// Also adds rows of orders, which are a table of its own.
void measureSurface(const BaseTree& tree, const AnalyticSurface& surface, int refinements,
  bench::Report& report, std::vector<bench::Row>& orderRows)
{
  const auto labels = [&](const std::string& method) {
    return std::vector<std::pair<const char*, std::string>>{ { "surface", surface.name },
      { "tree", tree.name }, { "method", method } };
  };
  std::map<std::string, History> histories;
  const int coarsest = coarsestRefinement(tree);
  for (int refinement = coarsest; refinement < coarsest + refinements; ++refinement)
  {
    const auto field = makeField(tree, refinement, surface.field);
    std::vector<Result> results = measureContour(*field, surface);
    results.insert(results.begin(), measureImplicit(field, surface));
    for (const Result& result : results)
    {
      const auto cells = static_cast<double>(field->octree().leafCount());
      report.add({ tree.name + "-" + std::to_string(refinement),
        errorFigures(tree, refinement, cells, result), labels(result.method) });
      histories[result.method].distance.push_back(result.errors.distance);
      histories[result.method].angle.push_back(result.errors.angle);
      histories[result.method].gradient.push_back(result.errors.gradient);
    }
  }
  for (const auto& [method, history] : histories)
  {
    const ConvergenceOrder distance = fittedOrder(history.distance);
    const ConvergenceOrder angle = fittedOrder(history.angle);
    const ConvergenceOrder gradient = fittedOrder(history.gradient);
    orderRows.push_back({ tree.name,
      { { "order_distance_max", distance.ofMax, "distance max", 2 },
        { "order_distance_mean", distance.ofMean, "mean", 2 },
        { "order_angle_max", angle.ofMax, "angle max", 2 }, { "order_angle_mean", angle.ofMean, "mean", 2 },
        { "order_gradient_max", gradient.ofMax, "gradient max", 2 },
        { "order_gradient_mean", gradient.ofMean, "mean", 2 } },
      labels(method) });
  }
}

} // namespace

void measureIsosurfaceError(const Options& options, bench::Report& errors, bench::Report& orders)
{
  const std::vector<AnalyticSurface> surfaces = makeAnalyticSurfaces();
  std::vector<bench::Row> orderRows;
  for (const BaseTree& tree : makeBaseTrees())
  {
    for (const AnalyticSurface& surface : std::span(surfaces).first(options.brief ? 1 : surfaces.size()))
    {
      measureSurface(tree, surface, options.brief ? 2 : 3, errors, orderRows);
    }
  }
  for (bench::Row& row : orderRows)
  {
    orders.add(std::move(row));
  }
}

} // namespace treeamr::report

#include "IsosurfaceFigures.h"

#include "Meter.h"
#include "PaperPrimitives.h"
#include "RayTracing/Isosurface.h"

namespace treeamr::bench
{

namespace
{

struct PaperCost
{
  Seconds extraction;
  std::size_t primitives;
};

PaperCost measurePaper(const Field& field, float isovalue, Extraction extraction)
{
  Primitives found;
  const Seconds seconds =
    best([&] { found = {}; }, [&] { found = extractPrimitives(field, isovalue, extraction); }, 1);
  return { seconds, found.primitives.size() };
}

double activePercent(const Field& field, float isovalue)
{
  return 100. * static_cast<double>(countActiveCells(field, isovalue)) /
    static_cast<double>(field.octree().leafCount());
}

struct RayTracerCost
{
  Seconds construction; // extraction and hierarchy
  Seconds coldFrame;    // the first after it
  Seconds frame;
  double bytes; // resident
  double primitives;
};

RayTracerCost measureRayTracer(
  const std::shared_ptr<const Field>& field, float isovalue, const Camera& camera)
{
  RayTracerCost cost;
  std::unique_ptr<Isosurface> surface;
  HitImage hits;
  const auto forget = [&] { surface.reset(); };
  const auto construct = [&] { surface = std::make_unique<Isosurface>(field, isovalue); };
  const auto render = [&] { surface->render(camera, hits); };
  cost.construction = best(forget, construct, 1);
  cost.coldFrame = measure(render);
  cost.frame = best(render);
  cost.primitives = static_cast<double>(surface->primitiveCount());
  const auto with = static_cast<double>(residentBytes());
  forget();
  cost.bytes = with - static_cast<double>(residentBytes());
  return cost;
}

} // namespace

std::vector<Figure> isosurfaceFigures(
  const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera)
{
  const auto value = static_cast<float>(isovalue);
  const auto cells = static_cast<double>(field->octree().leafCount());
  const PaperCost naive = measurePaper(*field, value, Extraction::Naive);
  const PaperCost dualCells = measurePaper(*field, value, Extraction::DualCells);
  const PaperCost filtered = measurePaper(*field, value, Extraction::Filtered);
  const RayTracerCost own = measureRayTracer(field, value, camera);
  return {
    { "isovalue", isovalue, "isovalue", 2 },
    { "cells", cells, "cells" },
    { "active_percent", activePercent(*field, value), "active %", 2 },
    { "naive_cpu_s", naive.extraction.cpu, "naive", 4 },
    { "opt1_cpu_s", dualCells.extraction.cpu, "opt. 1", 4 },
    { "opt2_cpu_s", filtered.extraction.cpu, "opt. 2", 4 },
    { "opt2_cells_per_s", cells / filtered.extraction.wall, "M cells/s", 1, 1e-6 },
    { "naive_primitives", static_cast<double>(naive.primitives), "octants" },
    { "opt2_primitives", static_cast<double>(filtered.primitives), "with dual" },
    { "construction_cpu_s", own.construction.cpu, "construct", 3 },
    { "primitives", own.primitives, "primitives" },
    { "bytes_per_primitive", own.bytes / own.primitives, "B/prim", 1 },
    { "cpu_s_frame", own.frame.cpu, "CPU-s", 3 },
    { "cpu_s_frame_cold", own.coldFrame.cpu, "cold CPU-s", 3 },
  };
}

std::vector<Figure> activityFigures(const Field& field, double isovalue)
{
  const auto value = static_cast<float>(isovalue);
  const PaperCost filtered = measurePaper(field, value, Extraction::Filtered);
  return {
    { "isovalue", isovalue, "isovalue", 3 },
    { "active_percent", activePercent(field, value), "active %", 2 },
    { "opt2_cpu_s", filtered.extraction.cpu, "opt. 2", 3 },
    { "opt2_wall_s", filtered.extraction.wall, "wall s", 3 },
    { "opt2_primitives", static_cast<double>(filtered.primitives), "with dual" },
  };
}

} // namespace treeamr::bench

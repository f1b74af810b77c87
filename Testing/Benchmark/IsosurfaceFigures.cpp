#include "IsosurfaceFigures.h"

#include "PaperPrimitives.h"
#include "Scene.h"
#include "Surface/SurfaceBlocks.h"

namespace treeamr::bench
{

namespace
{

struct PaperCost
{
  Cost extraction;
  std::size_t primitives;
};

PaperCost measurePaper(const Field& field, float isovalue, Extraction extraction)
{
  Primitives found;
  const Cost seconds =
    best([&] { found = {}; }, [&] { found = extractPrimitives(field, isovalue, extraction); }, 1);
  return { seconds, found.primitives.size() };
}

double activePercent(const Field& field, float isovalue)
{
  return 100. * static_cast<double>(countActiveCells(field, isovalue)) /
    static_cast<double>(field.octree().leafCount());
}

} // namespace

IsosurfaceCosts measureIsosurface(
  const std::shared_ptr<const Field>& field, double isovalue, const Camera& camera)
{
  IsosurfaceCosts costs;
  std::unique_ptr<Isosurface> surface;
  HitImage hits;
  const std::vector<double> isovalues{ isovalue };
  costs.extraction =
    best([&] { SurfaceBlocks(field, isovalues, Isosurface::defaultKeptBytes, Isosurface::allCellDepths); });
  costs.construction =
    best([&] { surface.reset(); }, [&] { surface = std::make_unique<Isosurface>(field, isovalues); });
  const auto render = [&] {
    surface->startFrame();
    surface->render(camera, SurfaceLayers::Nearest, hits);
  };
  costs.coldFrame = measure(render);
  costs.frame = best(render);
  costs.statistics = surface->statistics();
  const Camera fewRays = makeCamera(camera.width() / 10);
  costs.draft = best([&] { surface->render(fewRays, SurfaceLayers::Nearest, hits); });
  surface = std::make_unique<Isosurface>(field, std::vector<double>{ 0.4 * isovalue, 0.9 * isovalue });
  const auto renderTwo = [&](SurfaceLayers layers) {
    return best([&] {
      surface->startFrame();
      surface->render(camera, layers, hits);
    });
  };
  costs.opaqueOfTwo = renderTwo(SurfaceLayers::Nearest);
  costs.layersOfTwo = renderTwo(SurfaceLayers::All);
  return costs;
}

std::vector<Figure> isosurfaceFigures(
  const std::shared_ptr<const Field>& field, double isovalue, const IsosurfaceCosts& own)
{
  const auto value = static_cast<float>(isovalue);
  const auto cells = static_cast<double>(field->octree().leafCount());
  const PaperCost naive = measurePaper(*field, value, Extraction::Naive);
  const PaperCost dualCells = measurePaper(*field, value, Extraction::DualCells);
  const PaperCost filtered = measurePaper(*field, value, Extraction::Filtered);
  const auto blocks = static_cast<double>(own.statistics.blocks);
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
    { "extraction_cpu_s", own.extraction.cpu, "extraction", 3 },
    { "bvh_cpu_s", own.construction.cpu - own.extraction.cpu, "BVH", 3 },
    { "primitives", blocks, "primitives" },
    { "bytes_per_primitive", static_cast<double>(own.statistics.blockBytes) / blocks, "B/prim", 1 },
    { "bvh_bytes_per_primitive", static_cast<double>(own.statistics.hierarchyBytes) / blocks, "BVH B", 1 },
    { "kept_bytes", static_cast<double>(own.statistics.keptBytes), "kept MiB", 0, 1. / 1048576. },
    { "cpu_s_frame", own.frame.cpu, "CPU-s", 3 },
    { "cpu_s_frame_cold", own.coldFrame.cpu, "cold CPU-s", 3 },
    { "cpu_s_new_isovalue", own.construction.cpu + own.coldFrame.cpu, "new value", 3 },
    { "cpu_s_draft", own.draft.cpu, "draft", 4 },
    { "cpu_s_two_opaque", own.opaqueOfTwo.cpu, "two opaque", 3 },
    { "cpu_s_two_layers", own.layersOfTwo.cpu, "all layers", 3 },
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

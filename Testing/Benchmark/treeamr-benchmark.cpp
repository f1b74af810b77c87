// Measures the ray tracer on the forests <name>.p8est of a folder, whose names Scene.cpp has; CPU seconds are those
// of the whole process on all threads.
//
// treeamr-benchmark FOLDER [--only NAME] [--part volume|isosurface|points|reading|unstructured] [--samples S]
//   [--picture FILE.ppm] [--json FILE]
//
// Volume: memory, seconds, and PSNR against the scalar reference at 64 samples per cell, which is kept beside the
// forest as <name>.reference. Bytes per cell: allocated, resident after the build without its input, and the
// build's peak beyond its input. A kept frame finds vertex values of the frames before in the cache, a cold one
// begins without. --samples and --picture are for this part.
//
// Isosurface: the paper's extraction of active primitives in its three ways, the last of them over more isovalues,
// and the ray tracer's surface: construction and frames, of which a cold one is the first.
//
// Points: nanoseconds a point of the reconstruction, where points are near each other and where they are not.
//
// Unstructured: a grid made of the cells as hexahedra, of forests of a few million cells at most.
//
// The first two print what their steps take of the system: CPU seconds, those of them in the system, page faults, and the most
// resident memory.
//
// --only procedural-200M: about 200M cells that are on no disk, whether they fit memory.
#include "Error.h"
#include "IsosurfaceFigures.h"
#include "Limit.h"
#include "Meter.h"
#include "PointFigures.h"
#include "ReadingFigures.h"
#include "ReferenceImage.h"
#include "Report.h"
#include "Scene.h"
#include "Support/VolumeReference.h"
#include "UnstructuredFigures.h"
#include "Volume/Volume.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>

namespace treeamr::bench
{

namespace
{

constexpr const char* syntheticName = "synthetic";

struct Options
{
  std::string folder;
  std::string only; // empty: all data sets
  bool volume = true;
  bool isosurface = true;
  bool points = true;
  bool reading = true;
  bool unstructured = true;
  std::string picture;
  std::string json;
  VolumeSettings settings;
};

/// Nothing when the arguments are not understood.
std::optional<Options> parse(int argc, char* argv[])
{
  if (argc < 2 || argc % 2 != 0)
  {
    return std::nullopt;
  }
  Options options;
  options.folder = argv[1];
  for (int i = 2; i < argc; i += 2)
  {
    const std::string_view name = argv[i];
    const std::string_view value = argv[i + 1];
    if (name == "--only")
    {
      options.only = value;
    }
    else if (name == "--part" &&
      (value == "volume" || value == "isosurface" || value == "points" || value == "reading" ||
        value == "unstructured"))
    {
      options.volume = value == "volume";
      options.isosurface = value == "isosurface";
      options.points = value == "points";
      options.reading = value == "reading";
      options.unstructured = value == "unstructured";
    }
    else if (name == "--picture")
    {
      options.picture = value;
    }
    else if (name == "--json")
    {
      options.json = value;
    }
    else if (name != "--samples" ||
      std::from_chars(value.data(), value.data() + value.size(), options.settings.samplesPerCell).ptr !=
        value.data() + value.size())
    {
      return std::nullopt;
    }
  }
  if (!options.picture.empty() && options.only.empty()) // of which data set?
  {
    return std::nullopt;
  }
  return options;
}

struct Measurement
{
  std::vector<Figure> figures;
  std::vector<Row> system;
  Image image;
  double cells;
  double cpuSecondsPerFrame;
};

/// What a step of the work takes of the system. resident: the most since takePeakResidentBytes() was called before.
Row systemRow(const std::string& dataSet, const char* step, const Cost& cost, std::size_t resident)
{
  return { dataSet,
    { { "cpu_s", cost.cpu, "CPU-s", 3 }, { "system_s", cost.system, "system s", 3 },
      { "page_faults", cost.faults, "faults" },
      { "peak_resident_bytes", static_cast<double>(resident), "peak MiB", 0, 1. / 1048576. } },
    { { "step", step } } };
}

struct BuiltField
{
  std::shared_ptr<Field> field;
  std::vector<Figure> figures;
  Row system;
};

/// From cells in random order.
BuiltField measureBuild(const std::string& dataSet, LargeVector<LeafCell> cells, std::size_t residentBefore)
{
  const auto count = static_cast<double>(cells.size());
  std::shuffle(cells.begin(), cells.end(), std::mt19937_64(1));
  std::shared_ptr<Field> field;
  const std::size_t residentWithInput = residentBytes();
  takePeakResidentBytes();
  const Cost build = measure([&] { field = buildField({ 1, 1, 1 }, std::move(cells)); });
  const std::size_t peak = takePeakResidentBytes();
  const auto perCell = [&](std::size_t bytes, std::size_t before) {
    return (static_cast<double>(bytes) - static_cast<double>(before)) / count;
  };
  std::vector<Figure> figures = {
    { "cells", count, "cells" },
    { "bytes_per_cell", perCell(field->byteSize() + field->octree().byteSize(), 0), "B/cell", 2 },
    { "resident_bytes_per_cell", perCell(residentBytes(), residentBefore), "resident", 2 },
    { "build_peak_bytes_per_cell", perCell(peak, residentWithInput), "peak", 2 },
    { "build_cells_per_s", count / build.wall, "M cells/s", 2, 1e-6 },
    { "build_cpu_s_per_cell", build.cpu / count, "CPU ns", 0, 1e9 },
  };
  return { std::move(field), std::move(figures), systemRow(dataSet, "build", build, peak) };
}

Measurement measureVolume(const Options& options, const Scene& scene)
{
  const std::string file = options.folder + "/" + scene.name;
  const std::size_t resident = residentBytes();
  takePeakResidentBytes();
  Forest forest;
  const Cost read = measure([&] { forest = readForest(file + ".p8est"); });
  std::vector<Row> system{ systemRow(scene.name, "read", read, takePeakResidentBytes()) };
  auto [field, figures, building] = measureBuild(scene.name, std::move(forest.cells), resident);
  system.push_back(std::move(building));

  const Camera camera = makeCamera();
  Image image(camera.width(), camera.height());
  std::optional<Volume> volume;
  const auto forget = [&, &field = field] { volume.emplace(field, scene.transferFunction); };
  VolumeStatistics statistics;
  const auto frame = [&] { statistics = volume->render(camera, options.settings, image); };
  const auto measureFrame = [&](const char* step, const auto& prepare) {
    takePeakResidentBytes();
    const Cost cost = best(prepare, frame);
    system.push_back(systemRow(scene.name, step, cost, takePeakResidentBytes()));
    return cost;
  };
  const Cost cold = measureFrame("cold frame", forget);
  const Cost warm = measureFrame("frame", [] {});
  Cost single;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    single = best(frame);
  }
  Image scalarImage(camera.width(), camera.height());
  const Cost scalar = measure([&] {
    test::renderVolumeReference(*field, scene.transferFunction, camera, {}, options.settings, scalarImage);
  });
  const Image reference =
    referenceImage(file + ".reference", forest.digest, *field, scene.transferFunction, camera);

  figures.insert(figures.end(),
    {
      { "cpu_s_frame", warm.cpu, "CPU-s", 3 },
      { "wall_s_frame", warm.wall, "wall s", 3 },
      { "cpu_s_frame_cold", cold.cpu, "cold CPU-s", 3 },
      { "wall_s_frame_cold", cold.wall, "cold wall", 3 },
      { "cpu_s_frame_scalar", scalar.cpu, "scalar", 2 },
      { "limit_ratio", limitSeconds(field, scene.transferFunction, camera, statistics) / warm.cpu,
        "limit/CPU", 2 },
      { "psnr_db", psnr(image, reference), "dB", 2 },
      { "thread_speedup", single.wall / warm.wall, "1 thr/all", 2 },
      { "kept_bytes", static_cast<double>(volume->keptBytes()), "kept MiB", 0, 1. / 1048576. },
    });
  return { std::move(figures), std::move(system), std::move(image),
    static_cast<double>(field->leafValues().size()), warm.cpu };
}

/// Octree, ranges and a frame of a procedural source of about 200M cells, in a memory that is measured.
void runHuge(const Options& options)
{
  const std::size_t before = residentBytes();
  takePeakResidentBytes();
  std::shared_ptr<Field> field;
  const Cost build = measure([&] { field = buildProceduralField(12, 2.55); });
  const auto count = static_cast<double>(field->octree().leafCount());
  const Camera camera = makeCamera();
  Image image(camera.width(), camera.height());
  Volume volume(field, makeScenes().back().transferFunction);
  const auto frame = [&] { volume.render(camera, options.settings, image); };
  const Cost cold = measure(frame);
  const Cost warm = best(frame);
  Report("volume").add({ "procedural-200M",
    { { nullptr, count, "cells" },
      { nullptr, static_cast<double>(field->byteSize() + field->octree().byteSize()) / count, "B/cell", 2 },
      { nullptr, build.cpu / count, "CPU ns", 0, 1e9 }, { nullptr, warm.cpu, "CPU-s", 3 },
      { nullptr, cold.cpu, "cold CPU-s", 3 },
      { nullptr, static_cast<double>(takePeakResidentBytes() - before), "peak MiB", 0, 1. / 1048576. } } });
  if (!options.picture.empty())
  {
    writePicture(options.picture, image);
  }
}

void runVolume(const Options& options, Report& report, std::vector<Row>& system)
{
  std::optional<Measurement> few;
  for (const Scene& scene : makeScenes())
  {
    if (!options.only.empty() && scene.name != options.only)
    {
      continue;
    }
    const Measurement result = measureVolume(options, scene);
    report.add({ scene.name, result.figures });
    system.insert(system.end(), result.system.begin(), result.system.end());
    if (!options.picture.empty())
    {
      writePicture(options.picture, result.image);
    }
    if (scene.name == "mandelbulb-0.3M")
    {
      few = result;
    }
    else if (scene.name == "mandelbulb-20M" && few)
    {
      const double cells = result.cells / few->cells;
      const double time = result.cpuSecondsPerFrame / few->cpuSecondsPerFrame;
      std::printf("%-16s  %.1f times the cells of 0.3M, %.1f times the CPU-s: %.3f\n", "  growth", cells,
        time, time / cells);
    }
  }
}

std::vector<Figure> runIsosurface(const std::string& dataSet, const std::shared_ptr<const Field>& field,
  double isovalue, const Camera& camera, std::vector<Row>& system)
{
  takePeakResidentBytes();
  const IsosurfaceCosts costs = measureIsosurface(field, isovalue, camera);
  const std::size_t peak = takePeakResidentBytes();
  system.push_back(systemRow(dataSet, "surface", costs.construction, peak));
  system.push_back(systemRow(dataSet, "its cold frame", costs.coldFrame, peak));
  system.push_back(systemRow(dataSet, "its frame", costs.frame, peak));
  return isosurfaceFigures(field, isovalue, costs);
}

void runIsosurface(const Options& options, Report& report, Report& activity, std::vector<Row>& system)
{
  const Camera camera = makeCamera();
  std::vector<Row> activityRows; // a table of its own after the other
  if (options.only.empty() || options.only == syntheticName)
  {
    Forest forest = makeSyntheticForest();
    const auto field = buildField(forest.roots, std::move(forest.cells));
    report.add({ syntheticName, runIsosurface(syntheticName, field, 6.5, camera, system) });
  }
  for (const Scene& scene : makeScenes())
  {
    if (!options.only.empty() && scene.name != options.only)
    {
      continue;
    }
    Forest forest = readForest(options.folder + "/" + scene.name + ".p8est");
    const auto field = buildField(forest.roots, std::move(forest.cells));
    report.add({ scene.name, runIsosurface(scene.name, field, scene.isovalue, camera, system) });
    for (const double isovalue : scene.moreIsovalues)
    {
      activityRows.push_back({ scene.name, activityFigures(*field, isovalue) });
    }
  }
  for (Row& row : activityRows)
  {
    activity.add(std::move(row));
  }
}

void runPoints(const Options& options, Report& report)
{
  for (const Scene& scene : makeScenes())
  {
    if (options.only.empty() || options.only == scene.name)
    {
      Forest forest = readForest(options.folder + "/" + scene.name + ".p8est");
      const auto field = buildField(forest.roots, std::move(forest.cells));
      report.add({ scene.name, pointFigures(field, scene.isovalue, makeCamera()) });
    }
  }
}

void runReading(const Options& options, Report& report)
{
  for (const Scene& scene : makeScenes())
  {
    if (options.only.empty() || options.only == scene.name)
    {
      report.add({ scene.name, readingFigures(options.folder + "/" + scene.name + ".p8est") });
    }
  }
}

void runUnstructured(const Options& options, Report& report)
{
  constexpr std::size_t most = 5000000; // hexahedra take 270 bytes a cell
  for (const Scene& scene : makeScenes())
  {
    if (options.only.empty() || options.only == scene.name)
    {
      const Forest forest = readForest(options.folder + "/" + scene.name + ".p8est");
      if (forest.cells.size() <= most)
      {
        report.add({ scene.name, unstructuredFigures(forest) });
      }
    }
  }
}

void run(const Options& options)
{
  if (options.only == "procedural-200M")
  {
    runHuge(options);
    return;
  }
  const std::vector<Scene> scenes = makeScenes();
  if (!options.only.empty() && options.only != syntheticName &&
    std::none_of(scenes.begin(), scenes.end(), [&](const Scene& s) { return s.name == options.only; }))
  {
    throw Error("--only " + options.only + ": no such data set");
  }
  Report volume("volume");
  Report isosurface("isosurface");
  Report activity("isosurface_activity");
  Report points("points");
  Report reading("reading");
  Report unstructured("unstructured");
  Report system("system");
  std::vector<Row> systemRows; // after the other tables
  if (options.volume)
  {
    runVolume(options, volume, systemRows);
  }
  if (options.isosurface)
  {
    runIsosurface(options, isosurface, activity, systemRows);
  }
  if (options.points)
  {
    runPoints(options, points);
  }
  if (options.reading)
  {
    runReading(options, reading);
  }
  if (options.unstructured)
  {
    runUnstructured(options, unstructured);
  }
  for (Row& row : systemRows)
  {
    system.add(std::move(row));
  }
  if (!options.json.empty())
  {
    writeJson(options.json, { &volume, &isosurface, &activity, &points, &reading, &unstructured, &system });
  }
}

} // namespace

} // namespace treeamr::bench

int main(int argc, char* argv[])
{
  const auto options = treeamr::bench::parse(argc, argv);
  if (!options)
  {
    std::fprintf(stderr,
      "usage: treeamr-benchmark FOLDER [--only NAME] [--part volume|isosurface|points|reading|unstructured]\n"
      "  [--samples S] [--picture FILE.ppm] [--json FILE]\n"
      "--picture needs --only\n");
    return 2;
  }
  try
  {
    treeamr::bench::run(*options);
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "treeamr-benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}

#include "UnstructuredFigures.h"

#include "Error.h"
#include "Meter.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCellType.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkPoints.h"
#include "vtkTreeAMRFromUnstructured.h"
#include "vtkTypeInt64Array.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnstructuredGrid.h"
#include "vtkXMLUnstructuredGridReader.h"
#include "vtkXMLUnstructuredGridWriter.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>

namespace treeamr::bench
{

namespace
{

vtkSmartPointer<vtkUnstructuredGrid> hexahedra(const Forest& forest, bool shuffled, double scale)
{
  const std::size_t count = forest.cells.size();
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  if (shuffled)
  {
    std::shuffle(order.begin(), order.end(), std::mt19937_64(1));
  }
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(static_cast<vtkIdType>(8 * count));
  vtkNew<vtkTypeInt64Array> offsets;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(count + 1));
  vtkNew<vtkTypeInt64Array> ids;
  ids->SetNumberOfValues(static_cast<vtkIdType>(8 * count));
  std::iota(ids->GetPointer(0), ids->GetPointer(0) + 8 * count, 0);
  vtkNew<vtkDoubleArray> values;
  values->SetName("value");
  values->SetNumberOfValues(static_cast<vtkIdType>(count));
  double* point = coordinates->GetPointer(0);
  for (std::size_t i = 0; i < count; ++i)
  {
    const LeafCell& leaf = forest.cells[order[i]];
    const double width = std::ldexp(1., -leaf.cell.level);
    for (int o = 0; o < 8; ++o)
    {
      for (int a = 0; a < 3; ++a)
      {
        const double at = 0.5 + (sideOf(o, a) - 0.5) * scale;
        *point++ = (static_cast<double>(leaf.cell.index[a]) + at) * width;
      }
    }
    offsets->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt64>(8 * i));
    values->SetValue(static_cast<vtkIdType>(i), leaf.value);
  }
  offsets->SetValue(static_cast<vtkIdType>(count), static_cast<vtkTypeInt64>(8 * count));
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(VTK_VOXEL, cells);
  grid->GetCellData()->AddArray(values);
  return grid;
}

struct Conversion
{
  double seconds;
  double cpuSeconds;
  double bytesPerCell;
};

Conversion convert(const Forest& forest, bool shuffled, double scale)
{
  const auto input = hexahedra(forest, shuffled, scale);
  const auto count = static_cast<double>(forest.cells.size());
  Conversion best{ INFINITY, INFINITY, 0. };
  for (int run = 0; run < 3; ++run)
  {
    vtkNew<vtkTreeAMRFromUnstructured> filter;
    filter->SetInputDataObject(input);
    takePeakResidentBytes();
    const Cost cost = measure([&] { filter->Update(); });
    const std::size_t peak = takePeakResidentBytes();
    const auto* const grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
    if (const_cast<vtkHyperTreeGrid*>(grid)->GetNumberOfLeaves() != static_cast<vtkIdType>(count))
    {
      throw Error("hexahedra of a forest make a grid of other cells");
    }
    best = { std::min(best.seconds, cost.wall), std::min(best.cpuSeconds, cost.cpu),
      std::max(
        best.bytesPerCell, (static_cast<double>(peak) - static_cast<double>(residentBytes())) / count) };
  }
  return best;
}

/// By VTK's reader of .vtu files, which is ParaView's, of the hexahedra as raw appended data.
Cost readByVtk(const Forest& forest)
{
  const std::string path = std::filesystem::temp_directory_path() / "treeamr-benchmark.vtu";
  {
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    writer->SetFileName(path.c_str());
    writer->SetInputData(hexahedra(forest, false, 1.));
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorTypeToNone();
    writer->Write();
  }
  const Cost cost = best([&] {
    vtkNew<vtkXMLUnstructuredGridReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
  });
  std::filesystem::remove(path);
  return cost;
}

} // namespace

std::vector<Figure> unstructuredFigures(const Forest& forest)
{
  const auto count = static_cast<double>(forest.cells.size());
  const Conversion ordered = convert(forest, false, 1.);
  const Conversion shuffled = convert(forest, true, 1.);
  const Conversion shrunk = convert(forest, false, 0.95);
  const Cost reading = readByVtk(forest);
  return {
    { "cells", count, "cells" },
    { "cells_per_s", count / ordered.seconds, "M cells/s", 2, 1e-6 },
    { "cpu_s_per_cell", ordered.cpuSeconds / count, "CPU ns", 0, 1e9 },
    { "peak_bytes_per_cell", ordered.bytesPerCell, "peak B/cell", 1 },
    { "cells_per_s_shuffled", count / shuffled.seconds, "shuffled", 2, 1e-6 },
    { "cpu_s_per_cell_shuffled", shuffled.cpuSeconds / count, "CPU ns", 0, 1e9 },
    { "peak_bytes_per_cell_shuffled", shuffled.bytesPerCell, "peak B/cell", 1 },
    { "cells_per_s_shrunk", count / shrunk.seconds, "shrunk", 2, 1e-6 },
    { "cpu_s_per_cell_shrunk", shrunk.cpuSeconds / count, "CPU ns", 0, 1e9 },
    { "peak_bytes_per_cell_shrunk", shrunk.bytesPerCell, "peak B/cell", 1 },
    { "cpu_s_per_cell_vtu_read", reading.cpu / count, "VTK's .vtu read", 0, 1e9 },
  };
}

} // namespace treeamr::bench

#include "ReadingFigures.h"

#include "Error.h"
#include "Meter.h"
#include "Support/P4estSession.h"

#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkTreeAMRP4estReader.h"

#include <p8est.h>

namespace treeamr::bench
{

std::vector<Figure> readingFigures(const std::string& path)
{
  double count = 0.;
  double beyond = 0.;
  const auto read = [&] {
    vtkNew<vtkTreeAMRP4estReader> reader;
    reader->SetFileName(path.c_str());
    reader->SetPayload("double value");
    takePeakResidentBytes();
    const std::size_t before = residentBytes();
    reader->Update();
    vtkHyperTreeGrid* const grid = reader->GetHyperTreeGridOutput();
    count = static_cast<double>(grid->GetNumberOfLeaves());
    beyond = static_cast<double>(takePeakResidentBytes()) - static_cast<double>(before) -
      1024. * static_cast<double>(grid->GetActualMemorySize());
  };
  const Cost ours = best(read);
  if (count == 0.)
  {
    throw Error(path + ": no quadrants");
  }
  test::startP4est();
  const Cost libp4est = best([&] {
    p8est_connectivity_t* connectivity = nullptr;
    p8est_t* const forest =
      p8est_load(path.c_str(), MPI_COMM_SELF, sizeof(double), 1, nullptr, &connectivity);
    p8est_destroy(forest);
    p8est_connectivity_destroy(connectivity);
  });
  return {
    { "cells", count, "cells" },
    { "cells_per_s", count / ours.wall, "M cells/s", 1, 1e-6 },
    { "cpu_s_per_cell", ours.cpu / count, "CPU ns", 0, 1e9 },
    { "peak_bytes_beyond_grid", beyond, "MiB more", 1, 1. / 1048576. },
    { "cells_per_s_p8est_load", count / libp4est.wall, "p8est_load", 1, 1e-6 },
    { "cpu_s_per_cell_p8est_load", libp4est.cpu / count, "CPU ns", 0, 1e9 },
  };
}

} // namespace treeamr::bench

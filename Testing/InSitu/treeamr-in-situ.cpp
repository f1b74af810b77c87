// A simulation with libp4est whose pictures ParaView makes while it runs, on any number of processes, and what they cost.
//
// mpiexec -np 2 treeamr-in-situ SCRIPT FOLDER [steps minLevel maxLevel]
// By default 20 3 6. FOLDER: for the script's pictures. Prints a table; memory is that of the process that has most of it.
#include "InSitu/Advection.h"
#include "InSitu/CatalystAdaptor.h"
#include "InSitu/ForestGrid.h"
#include "Meter.h"

#include "vtkHyperTreeGrid.h"

#include <p8est.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>

namespace
{

using namespace treeamr;

struct Options
{
  int steps = 20;
  int minLevel = 3;
  int maxLevel = 6;
};

std::optional<Options> parse(int argc, char* argv[])
{
  Options options;
  if (argc != 3 && argc != 6)
  {
    return std::nullopt;
  }
  int* const numbers[] = { &options.steps, &options.minLevel, &options.maxLevel };
  for (int i = 3; i < argc; ++i)
  {
    const std::string_view text = argv[i];
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), *numbers[i - 3]);
    if (code != std::errc() || end != text.data() + text.size())
    {
      return std::nullopt;
    }
  }
  const bool allowed = options.steps >= 0 && options.minLevel >= 0 && options.minLevel <= options.maxLevel &&
    options.maxLevel <= P8EST_QMAXLEVEL;
  return allowed ? std::optional(options) : std::nullopt;
}

double largest(double number)
{
  MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return number;
}

/// Bytes in MiB.
double largestMemory(std::size_t bytes)
{
  return largest(static_cast<double>(bytes) / 0x1p20);
}

/// Wall seconds of all processes, with their waiting for each other.
template <class Work>
double seconds(const Work& work)
{
  MPI_Barrier(MPI_COMM_WORLD);
  const double start = MPI_Wtime();
  work();
  return largest(MPI_Wtime() - start);
}

bool run(const Options& options, const std::string& script, const std::string& folder)
{
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  test::Advection simulation(MPI_COMM_WORLD, options.minLevel, options.maxLevel);
  const double simulationAlone = largestMemory(bench::residentBytes());
  // ParaView goes to the folder.
  test::CatalystAdaptor catalyst(MPI_COMM_WORLD, "dye", std::filesystem::absolute(script), folder);
  if (rank == 0)
  {
    std::printf("resident before ParaView: %.0f MiB\n", simulationAlone);
    std::puts("step    cells  simulation s  grid s  rendering s  forest MiB  grid MiB  resident MiB  most MiB");
  }
  for (int step = 0; step <= options.steps; ++step)
  {
    const double simulated = step == 0 ? 0. : seconds([&] { simulation.advance(); });
    bench::takePeakResidentBytes();
    vtkSmartPointer<vtkHyperTreeGrid> grid;
    const double gridded = seconds([&] {
      grid = test::gridOfForest(*simulation.forest(), "dye", offsetof(test::DyeCell, concentration));
    });
    bool isRight = true;
    const double rendered = seconds([&] { isRight = catalyst.execute(step, simulation.time(), grid); });
    const double gridMemory = largestMemory(static_cast<std::size_t>(grid->GetActualMemorySize()) << 10);
    const double peak = largestMemory(bench::takePeakResidentBytes());
    const double resident = largestMemory(bench::residentBytes());
    const double forest = largestMemory(simulation.memoryBytes());
    if (rank == 0)
    {
      std::printf("%4d %8lld %13.3f %7.3f %12.3f %11.1f %9.1f %13.0f %9.0f\n", step,
        static_cast<long long>(simulation.forest()->global_num_quadrants), simulated, gridded, rendered, forest,
        gridMemory, resident, peak);
      std::fflush(stdout);
    }
    if (largest(isRight ? 0. : 1.) > 0.)
    {
      return false;
    }
  }
  return true;
}

} // namespace

int main(int argc, char* argv[])
{
  const std::optional<Options> options = parse(argc, argv);
  if (!options)
  {
    std::cerr << "usage: treeamr-in-situ SCRIPT FOLDER [steps minLevel maxLevel]\n"
              << "by default 20 3 6; 0 <= minLevel <= maxLevel <= " << P8EST_QMAXLEVEL << '\n';
    return 2;
  }
  MPI_Init(&argc, &argv);
  sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_ERROR);
  p4est_init(nullptr, SC_LP_ERROR);
  bool isRight = false;
  try
  {
    isRight = run(*options, argv[1], argv[2]);
  }
  catch (const std::exception& error)
  {
    std::cerr << "treeamr-in-situ: " << error.what() << '\n';
    MPI_Abort(MPI_COMM_WORLD, 1); // the others wait for this one
  }
  sc_finalize();
  MPI_Finalize();
  return isRight ? 0 : 1;
}

// Between a program that computes and ParaView's in situ library, Catalyst, with a hyper tree grid as its one channel.
//
// Debian 12 has Catalyst's own classes and the Python modules for the scripts of Catalyst 2, but neither libcatalyst nor ParaView's
// implementation of it; and what these hand over, Conduit's meshes, has no hyper tree grids in ParaView 5.11. So scripts are those
// of Catalyst 2, and the grid goes to them as a VTK object, as it is, by the classes that were there before.
#pragma once

#include "vtkNew.h"

#include <mpi.h>

#include <string>

class vtkCPProcessor;
class vtkHyperTreeGrid;

namespace treeamr::test
{

class CatalystAdaptor
{
public:
  /// Collective. One for a program. script: finds the grids as TrivialProducer(registrationName=channel). folder: for what it
  /// writes. Throws std::runtime_error where ParaView does not start, or there is no such script.
  CatalystAdaptor(
    MPI_Comm communicator, const std::string& channel, const std::string& script, const std::string& folder);
  ~CatalystAdaptor();
  CatalystAdaptor(const CatalystAdaptor&) = delete;
  CatalystAdaptor& operator=(const CatalystAdaptor&) = delete;

  /// Collective. grid: this process's, which is not copied. Whether the script went well.
  bool execute(int step, double time, vtkHyperTreeGrid* grid);

private:
  std::string channel_;
  vtkNew<vtkCPProcessor> processor_;
};

} // namespace treeamr::test

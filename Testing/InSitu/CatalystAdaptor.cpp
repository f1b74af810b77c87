#include "InSitu/CatalystAdaptor.h"

#include "vtkCPDataDescription.h"
#include "vtkCPInputDataDescription.h"
#include "vtkCPProcessor.h"
#include "vtkCPPythonScriptV2Pipeline.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMPI.h"

#include <stdexcept>

namespace treeamr::test
{

CatalystAdaptor::CatalystAdaptor(
  MPI_Comm communicator, const std::string& channel, const std::string& script, const std::string& folder)
  : channel_(channel)
{
  vtkMPICommunicatorOpaqueComm comm(&communicator);
  if (!processor_->Initialize(comm, folder.c_str()))
  {
    throw std::runtime_error("ParaView does not start");
  }
  vtkNew<vtkCPPythonScriptV2Pipeline> pipeline;
  if (!pipeline->Initialize(script.c_str()))
  {
    throw std::runtime_error(script + ": no script for Catalyst 2");
  }
  processor_->AddPipeline(pipeline);
}

CatalystAdaptor::~CatalystAdaptor()
{
  processor_->Finalize();
}

bool CatalystAdaptor::execute(int step, double time, vtkHyperTreeGrid* grid)
{
  vtkNew<vtkCPDataDescription> description;
  description->AddInput(channel_.c_str());
  description->SetTimeData(time, static_cast<vtkIdType>(step));
  if (!processor_->RequestDataDescription(description))
  {
    return true; // nothing is wanted of this step
  }
  description->GetInputDescriptionByName(channel_.c_str())->SetGrid(grid);
  return processor_->CoProcess(description) != 0;
}

} // namespace treeamr::test

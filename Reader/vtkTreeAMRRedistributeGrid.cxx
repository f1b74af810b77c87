#include "vtkTreeAMRRedistributeGrid.h"

#include "GridExchange.h"

#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkTreeAMRRedistributeGrid);

vtkTreeAMRRedistributeGrid::vtkTreeAMRRedistributeGrid()
  : Controller(vtkMultiProcessController::GetGlobalController())
{
}

vtkTreeAMRRedistributeGrid::~vtkTreeAMRRedistributeGrid() = default;

void vtkTreeAMRRedistributeGrid::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Controller: " << this->Controller.Get() << endl;
}

void vtkTreeAMRRedistributeGrid::SetController(vtkMultiProcessController* controller)
{
  if (this->Controller != controller)
  {
    this->Controller = controller;
    this->Modified();
  }
}

vtkMultiProcessController* vtkTreeAMRRedistributeGrid::GetController()
{
  return this->Controller;
}

const char* vtkTreeAMRRedistributeGrid::GetInputKind() const
{
  return "redistribution";
}

int vtkTreeAMRRedistributeGrid::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  return 1;
}

void vtkTreeAMRRedistributeGrid::Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output)
{
  const treeamr::ExchangedGrid made =
    treeamr::exchangeGrid(vtkHyperTreeGrid::SafeDownCast(pieces.front()), this->Controller);
  this->WarnOfLeftOut(made.leftOut);
  output->ShallowCopy(made.grid);
}

#include "vtkTreeAMRGridAlgorithm.h"

#include "BlockArrays.h"
#include "CornerArrays.h"
#include "OnceReporter.h"
#include "PieceController.h"

#include "vtkDataObject.h"
#include "vtkFieldData.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <exception>
#include <vector>

namespace
{

using SDDP = vtkStreamingDemandDrivenPipeline;

int PieceOf(vtkInformation* info)
{
  return info->Has(SDDP::UPDATE_PIECE_NUMBER()) ? info->Get(SDDP::UPDATE_PIECE_NUMBER()) : 0;
}

// The pieces of all processes, in the first one; none in the others. Each calls it.
std::vector<vtkSmartPointer<vtkDataObject>> Gathered(
  vtkMultiProcessController* controller, vtkDataObject* input)
{
  constexpr int tag = 7325;
  const bool isFirst = controller->GetLocalProcessId() == 0;
  const vtkIdType own = input->GetNumberOfElements(vtkDataObject::CELL);
  std::vector<vtkIdType> cells(static_cast<std::size_t>(controller->GetNumberOfProcesses()));
  controller->Gather(&own, cells.data(), 1, 0);
  std::vector<vtkSmartPointer<vtkDataObject>> pieces;
  if (!isFirst)
  {
    if (own > 0)
    {
      controller->Send(input, 0, tag);
    }
    return pieces;
  }
  pieces.emplace_back(input);
  for (int process = 1; process < controller->GetNumberOfProcesses(); ++process)
  {
    if (cells[static_cast<std::size_t>(process)] > 0)
    {
      pieces.push_back(vtk::TakeSmartPointer(controller->ReceiveDataObject(process, tag)));
    }
  }
  return pieces;
}

std::string Listed(const std::vector<std::string>& texts)
{
  std::string list;
  for (const std::string& text : texts)
  {
    list += (list.empty() ? "" : ", ") + text;
  }
  return list;
}

} // namespace

vtkTreeAMRGridAlgorithm::vtkTreeAMRGridAlgorithm()
  : Warnings(std::make_unique<treeamr::OnceReporter>())
{
}

vtkTreeAMRGridAlgorithm::~vtkTreeAMRGridAlgorithm() = default;

void vtkTreeAMRGridAlgorithm::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

int vtkTreeAMRGridAlgorithm::FillOutputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkHyperTreeGrid");
  return 1;
}

// Each process asks for its own piece, as it always does: sources would make what others show of them anew. Of several
// pieces in one process the first has all.
int vtkTreeAMRGridAlgorithm::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkInformation* const inInfo = inputVector[0]->GetInformationObject(0);
  if (this->GathersPieces() && !treeamr::pieceController(outputVector->GetInformationObject(0)))
  {
    inInfo->Set(SDDP::UPDATE_PIECE_NUMBER(), 0);
    inInfo->Set(SDDP::UPDATE_NUMBER_OF_PIECES(), 1);
  }
  inInfo->Set(SDDP::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  return 1;
}

int vtkTreeAMRGridAlgorithm::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* const input = vtkDataObject::GetData(inputVector[0]);
  vtkInformation* const outInfo = outputVector->GetInformationObject(0);
  vtkHyperTreeGrid* const output = vtkHyperTreeGrid::GetData(outInfo);
  vtkNew<vtkFieldData> fieldData; // the input's, which the executive passes on
  fieldData->ShallowCopy(output->GetFieldData());
  output->Initialize();
  try
  {
    vtkMultiProcessController* const controller =
      this->GathersPieces() ? treeamr::pieceController(outInfo) : nullptr;
    const std::vector<vtkSmartPointer<vtkDataObject>> pieces =
      controller ? Gathered(controller, input) : std::vector<vtkSmartPointer<vtkDataObject>>{ input };
    if (!this->GathersPieces() || PieceOf(outInfo) == 0)
    {
      vtkNew<vtkHyperTreeGrid> grid;
      this->Convert({ pieces.begin(), pieces.end() }, grid);
      treeamr::setCornerRanges(*grid);
      output->ShallowCopy(grid);
    }
  }
  catch (const std::bad_alloc&)
  {
    output->Initialize();
    vtkErrorMacro(<< this->GetInputKind() << ": not enough memory");
  }
  catch (const std::exception& error)
  {
    output->Initialize();
    vtkErrorMacro(<< this->GetInputKind() << ": " << error.what());
  }
  this->Warnings->endRound();
  for (int i = 0; i < fieldData->GetNumberOfArrays(); ++i)
  {
    vtkAbstractArray* const array = fieldData->GetAbstractArray(i);
    if (!array->GetName() || !output->GetFieldData()->HasArray(array->GetName()))
    {
      output->GetFieldData()->AddArray(array);
    }
  }
  return 1;
}

void vtkTreeAMRGridAlgorithm::WarnOfArrays(const treeamr::BlockArrays& arrays)
{
  if (!arrays.averaged.empty())
  {
    this->Warn("arrays of points are averaged to the cells: " + Listed(arrays.averaged) + ".");
  }
  this->WarnOfLeftOut(arrays.leftOut);
}

void vtkTreeAMRGridAlgorithm::WarnOfLeftOut(const std::vector<std::string>& leftOut)
{
  if (!leftOut.empty())
  {
    this->Warn("left out: " + Listed(leftOut) + ".");
  }
}

void vtkTreeAMRGridAlgorithm::Warn(const std::string& message)
{
  if (this->Warnings->isNews(message))
  {
    vtkWarningMacro(<< this->GetInputKind() << ": " << message);
  }
}

int vtkTreeAMRGridAlgorithm::ProcessTrees(vtkHyperTreeGrid*, vtkDataObject*)
{
  return 1; // pure in the base class, for inputs that have trees
}

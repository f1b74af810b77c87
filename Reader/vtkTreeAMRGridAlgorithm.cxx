#include "vtkTreeAMRGridAlgorithm.h"

#include "BlockArrays.h"
#include "OnceReporter.h"

#include "vtkDataObject.h"
#include "vtkFieldData.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
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

// All pieces to the first process. The others ask for the last of so many that a source which gives what it is asked for
// has nothing in it.
int vtkTreeAMRGridAlgorithm::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  constexpr int many = 1 << 16;
  const bool isFirst = PieceOf(outputVector->GetInformationObject(0)) == 0;
  vtkInformation* const inInfo = inputVector[0]->GetInformationObject(0);
  inInfo->Set(SDDP::UPDATE_PIECE_NUMBER(), isFirst ? 0 : many - 1);
  inInfo->Set(SDDP::UPDATE_NUMBER_OF_PIECES(), isFirst ? 1 : many);
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
    if (PieceOf(outInfo) > 0)
    {
      if (const vtkIdType cells = input->GetNumberOfElements(vtkDataObject::CELL); cells > 0)
      {
        this->Warn(
          "the first process has asked its source for all cells and makes the grid of them; process " +
          std::to_string(PieceOf(outInfo)) + " has asked for none and was given " + std::to_string(cells) +
          ", which are not in the grid unless the first one has them, too.");
      }
    }
    else
    {
      vtkNew<vtkHyperTreeGrid> grid;
      this->Convert(input, grid);
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
  output->GetFieldData()->ShallowCopy(fieldData);
  return 1;
}

void vtkTreeAMRGridAlgorithm::WarnOfArrays(const treeamr::BlockArrays& arrays)
{
  if (!arrays.averaged.empty())
  {
    this->Warn("arrays of points are averaged to the cells: " + Listed(arrays.averaged) + ".");
  }
  if (!arrays.leftOut.empty())
  {
    this->Warn("left out: " + Listed(arrays.leftOut) + ".");
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

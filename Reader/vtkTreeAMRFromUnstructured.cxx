#include "vtkTreeAMRFromUnstructured.h"

#include "HexahedronBlocks.h"
#include "HexahedronGrid.h"

#include "vtkInformation.h"
#include "vtkObjectFactory.h"

#include <vector>

vtkStandardNewMacro(vtkTreeAMRFromUnstructured);

void vtkTreeAMRFromUnstructured::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

const char* vtkTreeAMRFromUnstructured::GetInputKind() const
{
  return "unstructured grid";
}

int vtkTreeAMRFromUnstructured::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

void vtkTreeAMRFromUnstructured::Convert(vtkDataObject* input, vtkHyperTreeGrid* output)
{
  const std::vector<treeamr::HexahedronBlock> blocks = treeamr::hexahedronBlocks(input);
  if (blocks.empty())
  {
    return;
  }
  const treeamr::BlockArrays arrays = treeamr::arraysOf(blocks);
  treeamr::makeGrid(blocks, arrays, output);
  this->WarnOfArrays(arrays);
}

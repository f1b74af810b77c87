#include "vtkTreeAMRMergeGrids.h"

#include "MergedGrid.h"

#include "vtkInformation.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkTreeAMRMergeGrids);

void vtkTreeAMRMergeGrids::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

const char* vtkTreeAMRMergeGrids::GetInputKind() const
{
  return "hyper tree grids";
}

int vtkTreeAMRMergeGrids::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

void vtkTreeAMRMergeGrids::Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output)
{
  const std::vector<treeamr::NamedGrid> grids = treeamr::gridsWithTrees(pieces.front());
  std::vector<std::string> leftOut = treeamr::blocksOfOtherKinds(pieces.front());
  if (!grids.empty())
  {
    const std::vector<std::string> arrays = treeamr::mergeGrids(grids, output);
    leftOut.insert(leftOut.end(), arrays.begin(), arrays.end());
  }
  this->WarnOfLeftOut(leftOut);
}

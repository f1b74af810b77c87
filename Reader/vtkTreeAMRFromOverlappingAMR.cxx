#include "vtkTreeAMRFromOverlappingAMR.h"

#include "AMRBlocks.h"
#include "AMRGrid.h"

#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkOverlappingAMR.h"

#include <algorithm>
#include <iterator>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRFromOverlappingAMR);

void vtkTreeAMRFromOverlappingAMR::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

const char* vtkTreeAMRFromOverlappingAMR::GetInputKind() const
{
  return "overlapping AMR";
}

int vtkTreeAMRFromOverlappingAMR::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkOverlappingAMR");
  return 1;
}

void vtkTreeAMRFromOverlappingAMR::Convert(
  const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output)
{
  std::vector<treeamr::AMRBlock> blocks;
  for (vtkDataObject* const piece : pieces)
  {
    std::vector<treeamr::AMRBlock> ofPiece = treeamr::blocksOf(vtkOverlappingAMR::SafeDownCast(piece));
    std::ranges::move(ofPiece, std::back_inserter(blocks));
  }
  if (blocks.empty())
  {
    return;
  }
  const treeamr::BlockArrays arrays = treeamr::arraysOf(blocks);
  const treeamr::AMRBlock* const divided = treeamr::makeGrid(blocks, arrays, output);
  this->WarnOfArrays(arrays);
  if (divided)
  {
    this->Warn("finer blocks cover cells in part, the first of " + divided->name() +
      "; the rest of these is divided into cells of their values.");
  }
}

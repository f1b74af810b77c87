#include "vtkTreeAMRFromUnstructured.h"

#include "HexahedronBlocks.h"
#include "HexahedronGrid.h"

#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRFromUnstructured);

void vtkTreeAMRFromUnstructured::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  this->PointDataArraySelection->PrintSelf(os, indent.GetNextIndent());
  os << indent << "SelectionIsFinal: " << this->SelectionIsFinal << "\n";
}

vtkMTimeType vtkTreeAMRFromUnstructured::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->PointDataArraySelection->GetMTime());
}

bool vtkTreeAMRFromUnstructured::IsWanted(const std::string& array)
{
  const bool all = !this->SelectionIsFinal && this->PointDataArraySelection->GetNumberOfArrays() == 0;
  return all || this->PointDataArraySelection->ArrayIsEnabled(array.c_str());
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

void vtkTreeAMRFromUnstructured::Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output)
{
  std::vector<treeamr::HexahedronBlock> blocks;
  for (vtkDataObject* const piece : pieces)
  {
    std::vector<treeamr::HexahedronBlock> ofPiece = treeamr::hexahedronBlocks(piece);
    std::ranges::move(ofPiece, std::back_inserter(blocks));
  }
  if (blocks.empty())
  {
    return;
  }
  const treeamr::BlockArrays arrays =
    treeamr::arraysOf(blocks, [this](const std::string& array) { return this->IsWanted(array); });
  this->WarnOfUnknownArrays(arrays);
  treeamr::makeGrid(blocks, arrays, output);
  this->WarnOfArrays(arrays);
}

void vtkTreeAMRFromUnstructured::WarnOfUnknownArrays(const treeamr::BlockArrays& arrays)
{
  std::set<std::string> known;
  for (const treeamr::NamedDataSet& block : arrays.blocks)
  {
    for (int i = 0; block.points && i < block.points->GetNumberOfArrays(); ++i)
    {
      const char* const name = block.points->GetArrayName(i);
      known.insert(name ? name : "");
    }
  }
  std::string names;
  for (const std::string& name : known)
  {
    names += name.empty() ? "" : (names.empty() ? "'" : ", '") + name + "'";
  }
  for (int i = 0; i < this->PointDataArraySelection->GetNumberOfArrays(); ++i)
  {
    const std::string name = this->PointDataArraySelection->GetArrayName(i);
    if (this->PointDataArraySelection->GetArraySetting(i) && !known.contains(name))
    {
      this->Warn("no array of points is '" + name + "', which is selected; there are " +
        (names.empty() ? "none" : names) + ".");
    }
  }
}

#include "vtkTreeAMRFromTable.h"

#include "Error.h"
#include "TableGrid.h"

#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"
#include "vtkTable.h"

#include <cmath>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRFromTable);

void vtkTreeAMRFromTable::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "LevelColumn: " << this->LevelColumn << "\n";
  os << indent << "IColumn: " << this->IColumn << "\n";
  os << indent << "JColumn: " << this->JColumn << "\n";
  os << indent << "KColumn: " << this->KColumn << "\n";
  os << indent << "Origin: (" << this->Origin[0] << ", " << this->Origin[1] << ", " << this->Origin[2]
     << ")\n";
  os << indent << "Spacing: (" << this->Spacing[0] << ", " << this->Spacing[1] << ", " << this->Spacing[2]
     << ")\n";
  os << indent << "Roots: (" << this->Roots[0] << ", " << this->Roots[1] << ", " << this->Roots[2] << ")\n";
}

const char* vtkTreeAMRFromTable::GetInputKind() const
{
  return "table";
}

int vtkTreeAMRFromTable::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkTable");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

std::array<std::string, 4> vtkTreeAMRFromTable::ColumnNames() const
{
  return { this->LevelColumn, this->IColumn, this->JColumn, this->KColumn };
}

void vtkTreeAMRFromTable::Convert(const std::vector<vtkDataObject*>& pieces, vtkHyperTreeGrid* output)
{
  treeamr::TableLattice lattice;
  for (int a = 0; a < 3; ++a)
  {
    lattice.origin[a] = this->Origin[a];
    lattice.spacing[a] = this->Spacing[a];
    lattice.roots[a] = this->Roots[a];
    if (!std::isfinite(this->Origin[a]) || !std::isfinite(this->Spacing[a]) || !(this->Spacing[a] > 0.) ||
      this->Roots[a] < 0)
    {
      throw treeamr::Error(std::string("along ") + "xyz"[a] + " Origin " + std::to_string(this->Origin[a]) +
        ", Spacing " + std::to_string(this->Spacing[a]) + ", Roots " + std::to_string(this->Roots[a]) +
        "; allowed are finite origins, spacings above 0 and 0 roots or more");
    }
  }
  std::vector<treeamr::TableBlock> blocks;
  const auto add = [&](vtkDataObject* data, const std::string& name) {
    vtkTable* const table = vtkTable::SafeDownCast(data);
    if (table && table->GetNumberOfRows() > 0)
    {
      blocks.emplace_back(table, this->ColumnNames(), name);
    }
  };
  for (vtkDataObject* const piece : pieces)
  {
    if (auto* const composite = vtkCompositeDataSet::SafeDownCast(piece))
    {
      const auto block = vtk::TakeSmartPointer(composite->NewIterator());
      for (block->InitTraversal(); !block->IsDoneWithTraversal(); block->GoToNextItem())
      {
        add(block->GetCurrentDataObject(), treeamr::nameOfBlock(*block));
      }
    }
    else
    {
      add(piece, "");
    }
  }
  if (blocks.empty())
  {
    return;
  }
  std::vector<treeamr::NamedDataSet> arraysOfBlocks;
  for (const treeamr::TableBlock& block : blocks)
  {
    arraysOfBlocks.emplace_back(block.others, block.rows, block.name);
  }
  treeamr::BlockArrays arrays = treeamr::arraysOf(std::move(arraysOfBlocks), {});
  for (const treeamr::TableBlock& block : blocks)
  {
    arrays.leftOut.insert(arrays.leftOut.end(), block.leftOut.begin(), block.leftOut.end());
  }
  treeamr::makeGrid(blocks, lattice, arrays, output);
  this->WarnOfArrays(arrays);
}

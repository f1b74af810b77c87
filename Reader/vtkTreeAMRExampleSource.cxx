// The trees are built level by level, so that the places of all cells in the array follow from their order.
#include "vtkTreeAMRExampleSource.h"

#include "BalancedTreeBuilder.h"
#include "ExampleFields.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <array>
#include <cmath>
#include <string>

vtkStandardNewMacro(vtkTreeAMRExampleSource);

namespace
{

/// In DatasetType's order.
constexpr std::array<const char*, 3> DatasetNames = { "Synthetic", "Mandelbulb", "Sheet" };
constexpr std::array<const char*, 3> ArrayNames = { "xyz", "mandelbulb", "sheet" };

constexpr int SyntheticRoots = 4;
constexpr int DeepestLevel = 12;
/// Coarse cells included. 3 GiB for the tree and its values.
constexpr std::uint64_t CellLimit = std::uint64_t(1) << 28;

/// An empty lattice of cubic roots of the given width, with its corner at the origin.
void InitializeGrid(vtkHyperTreeGrid* grid, int roots, double rootWidth)
{
  grid->Initialize();
  const int planes = roots + 1;
  grid->SetDimensions(planes, planes, planes);
  grid->SetBranchFactor(2);
  vtkNew<vtkDoubleArray> coordinates;
  for (int i = 0; i < planes; ++i)
  {
    coordinates->InsertNextValue(i * rootWidth);
  }
  grid->SetXCoordinates(coordinates);
  grid->SetYCoordinates(coordinates);
  grid->SetZCoordinates(coordinates);
}

void AddCellScalars(vtkHyperTreeGrid* grid, vtkDoubleArray* values, const char* name)
{
  values->SetName(name);
  grid->GetCellData()->SetScalars(values);
}

double MeanOfChildren(const double* children)
{
  double sum = 0.;
  for (int o = 0; o < 8; ++o)
  {
    sum += children[o];
  }
  return sum / 8.;
}

void BuildSynthetic(vtkHyperTreeGrid* grid)
{
  const auto f = [](double x, double y, double z) { return x * y * z; };
  vtkNew<vtkDoubleArray> values;
  for (unsigned int k = 0; k < SyntheticRoots; ++k)
  {
    for (unsigned int j = 0; j < SyntheticRoots; ++j)
    {
      for (unsigned int i = 0; i < SyntheticRoots; ++i)
      {
        vtkIdType id = 0;
        grid->GetIndexFromLevelZeroCoordinates(id, i, j, k);
        vtkHyperTree* tree = grid->GetTree(id, true);
        const vtkIdType root = values->GetNumberOfValues();
        tree->SetGlobalIndexStart(root);
        if (i < SyntheticRoots / 2)
        {
          values->InsertNextValue(f(i + 0.5, j + 0.5, k + 0.5));
          continue;
        }
        tree->SubdivideLeaf(0, 0);
        values->InsertNextValue(0.);
        for (int o = 0; o < 8; ++o)
        {
          values->InsertNextValue(
            f(i + 0.25 + 0.5 * (o & 1), j + 0.25 + 0.5 * (o >> 1 & 1), k + 0.25 + 0.5 * (o >> 2)));
        }
        values->SetValue(root, MeanOfChildren(values->GetPointer(root + 1)));
      }
    }
  }
  AddCellScalars(grid, values, ArrayNames[vtkTreeAMRExampleSource::SYNTHETIC]);
}

/// A tree over the unit cube with the values of field(x, y, z), which several threads call. The children of the n-th
/// refined cell, level by level, are vertices 8 n + 1 to 8 n + 8.
template <class Field>
void BuildRefined(vtkHyperTreeGrid* grid, const Field& field, const char* name, int minimumLevel,
  int maximumLevel, double threshold)
{
  const auto refine = [&field, threshold](const std::array<std::uint32_t, 3>& index, int level) {
    const double width = std::ldexp(1., -level);
    return treeamr::rangeOverProbes(field, { index[0] * width, index[1] * width, index[2] * width }, width) >
      threshold;
  };
  const treeamr::BalancedTreeBuilder builder(minimumLevel, maximumLevel, CellLimit, refine);

  vtkHyperTree* tree = grid->GetTree(0, true);
  tree->SetGlobalIndexStart(0);
  std::vector<vtkIdType> refinedVertices;
  refinedVertices.reserve(builder.refinedCount());
  vtkIdType firstOfParents = 0; // the number of refined cells above the parents' level
  for (std::size_t level = 0; level < builder.refined().size(); ++level)
  {
    const auto firstHere = static_cast<vtkIdType>(refinedVertices.size());
    std::size_t parent = 0;
    for (const treeamr::MortonKey key : builder.refined()[level])
    {
      vtkIdType vertex = 0;
      if (level > 0)
      {
        const auto& parents = builder.refined()[level - 1];
        while (parents[parent] != key / 8)
        {
          ++parent;
        }
        vertex = 8 * (firstOfParents + static_cast<vtkIdType>(parent)) + 1 + static_cast<vtkIdType>(key % 8);
      }
      tree->SubdivideLeaf(vertex, static_cast<unsigned int>(level));
      refinedVertices.push_back(vertex);
    }
    firstOfParents = firstHere;
  }

  vtkNew<vtkDoubleArray> values;
  values->SetNumberOfValues(tree->GetNumberOfVertices());
  double* const value = values->GetPointer(0);
  const auto evaluate = [&](vtkIdType vertex, treeamr::MortonKey key, std::size_t level) {
    const std::array<std::uint32_t, 3> index = treeamr::mortonIndex(key);
    const double width = std::ldexp(1., -static_cast<int>(level));
    value[vertex] = field((index[0] + 0.5) * width, (index[1] + 0.5) * width, (index[2] + 0.5) * width);
  };
  if (refinedVertices.empty())
  {
    evaluate(0, 0, 0);
  }
  std::size_t firstOfLevel = 0;
  for (std::size_t level = 0; level < builder.refined().size(); ++level)
  {
    const std::vector<treeamr::MortonKey>& parents = builder.refined()[level];
    tbb::parallel_for(std::size_t(0), parents.size(), [&](std::size_t i) {
      for (int o = 0; o < 8; ++o)
      {
        const auto vertex = static_cast<vtkIdType>(8 * (firstOfLevel + i) + 1 + o);
        if (tree->IsLeaf(vertex))
        {
          evaluate(vertex, 8 * parents[i] + o, level + 1);
        }
      }
    });
    firstOfLevel += parents.size();
  }
  for (std::size_t n = refinedVertices.size(); n-- > 0;)
  {
    value[refinedVertices[n]] = MeanOfChildren(value + 8 * n + 1);
  }
  AddCellScalars(grid, values, name);
}

} // namespace

vtkTreeAMRExampleSource::vtkTreeAMRExampleSource()
{
  this->SetNumberOfInputPorts(0);
}

void vtkTreeAMRExampleSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Dataset: "
     << (this->Dataset >= SYNTHETIC && this->Dataset <= SHEET ? DatasetNames[this->Dataset] : "unknown")
     << "\n";
  os << indent << "MinimumLevel: " << this->MinimumLevel << "\n";
  os << indent << "MaximumLevel: " << this->MaximumLevel << "\n";
  os << indent << "RefinementThreshold: " << this->RefinementThreshold << "\n";
}

int vtkTreeAMRExampleSource::FillOutputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkHyperTreeGrid");
  return 1;
}

int vtkTreeAMRExampleSource::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  const int roots = this->Dataset == SYNTHETIC ? SyntheticRoots : 1;
  const int extent[6] = { 0, roots, 0, roots, 0, roots };
  vtkInformation* info = outputVector->GetInformationObject(0);
  info->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent, 6);
  info->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  return 1;
}

void vtkTreeAMRExampleSource::CheckProperties()
{
  const auto fail = [](const std::string& what) { throw treeamr::Error("example: " + what); };
  if (this->Dataset < SYNTHETIC || this->Dataset > SHEET)
  {
    fail("Dataset is " + std::to_string(this->Dataset) +
      ", allowed are 0 (Synthetic), 1 (Mandelbulb) and 2 (Sheet)");
  }
  if (this->MaximumLevel < 0 || this->MaximumLevel > DeepestLevel)
  {
    fail("MaximumLevel is " + std::to_string(this->MaximumLevel) + ", allowed is 0 to " +
      std::to_string(DeepestLevel));
  }
  if (this->MinimumLevel < 0 || this->MinimumLevel > this->MaximumLevel)
  {
    fail("MinimumLevel is " + std::to_string(this->MinimumLevel) +
      ", allowed is 0 to MaximumLevel, which is " + std::to_string(this->MaximumLevel));
  }
  if (!(this->RefinementThreshold >= 0.) || !std::isfinite(this->RefinementThreshold))
  {
    fail("RefinementThreshold is " + std::to_string(this->RefinementThreshold) +
      ", allowed are finite values from 0 on");
  }
}

int vtkTreeAMRExampleSource::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkInformation* info = outputVector->GetInformationObject(0);
  vtkHyperTreeGrid* output = vtkHyperTreeGrid::GetData(info);
  try
  {
    this->CheckProperties();
    const bool synthetic = this->Dataset == SYNTHETIC;
    InitializeGrid(output, synthetic ? SyntheticRoots : 1, 1.);
    if (info->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()) > 0)
    {
      AddCellScalars(output, vtkNew<vtkDoubleArray>(), ArrayNames[this->Dataset]);
    }
    else if (synthetic)
    {
      BuildSynthetic(output);
    }
    else
    {
      const auto build = [&](const auto& field) {
        BuildRefined(output, field, ArrayNames[this->Dataset], this->MinimumLevel, this->MaximumLevel,
          this->RefinementThreshold);
      };
      this->Dataset == SHEET ? build(treeamr::SaturatedSheet()) : build(treeamr::mandelbulb);
    }
  }
  catch (const std::exception& e)
  {
    output->Initialize();
    vtkErrorMacro(<< e.what());
    return 0;
  }
  return 1;
}

int vtkTreeAMRExampleSource::ProcessTrees(vtkHyperTreeGrid*, vtkDataObject*)
{
  vtkErrorMacro("A source has no input trees to process.");
  return 0;
}

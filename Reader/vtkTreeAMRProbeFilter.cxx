// One sampler per component, all points in parallel.
#include "vtkTreeAMRProbeFilter.h"

#include "CornerArrays.h"
#include "FilteredArrays.h"
#include "GridExchange.h"
#include "GridPartition.h"
#include "HyperTreeGridConverter.h"
#include "LostDigits.h"
#include "MergedGrid.h"
#include "OnceReporter.h"
#include "PieceController.h"
#include "PointExchange.h"

#include "Error.h"
#include "Interpolation/Sampler.h"

#include "vtkCellData.h"
#include "vtkCharArray.h"
#include "vtkDataArraySelection.h"
#include "vtkDataSet.h"
#include "vtkExecutive.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRProbeFilter);

namespace
{

/// The results for one cell array: values, and gradients or null.
struct ArrayResult
{
  vtkSmartPointer<vtkDataArray> Values;
  vtkSmartPointer<vtkDataArray> Gradients;
};

vtkSmartPointer<vtkDataArray> NewArray(int type, const std::string& name, int components, vtkIdType points)
{
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(points);
  return array;
}

/// offset + value in an array's type: of integers the nearest one, as vtkProbeFilter has it.
template <class Number>
Number NumberOf(double offset, double value)
{
  if constexpr (std::is_floating_point_v<Number>)
  {
    return static_cast<Number>(offset + value);
  }
  else
  {
    // With digits for 64 bits, where doubles have 53.
    const long double whole = std::round(static_cast<long double>(offset) + value);
    constexpr Number least = std::numeric_limits<Number>::lowest();
    constexpr Number most = std::numeric_limits<Number>::max();
    return whole >= static_cast<long double>(most) ? most
      : whole > static_cast<long double>(least)    ? static_cast<Number>(whole)
                                                   : least;
  }
}

/// Writes one component at all points, NaN (of integers anything) where the sampler has no cell, and marks the others.
/// values: of the result.
template <class Number>
void SampleComponent(const treeamr::Sampler& sampler, double offset, vtkDataSet* input, int component,
  const ArrayResult& result, Number* values, std::vector<char>& valid)
{
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const int components = result.Values->GetNumberOfComponents();
  tbb::parallel_for(
    tbb::blocked_range<vtkIdType>(0, input->GetNumberOfPoints(), 1024), [&](const auto& range) {
      for (vtkIdType i = range.begin(); i != range.end(); ++i)
      {
        std::array<double, 3> point;
        input->GetPoint(i, point.data());
        treeamr::FieldSample sample{ nan, { nan, nan, nan } };
        if (sampler.sampleRelative(point, sample))
        {
          valid[i] = 1;
        }
        values[i * components + component] = NumberOf<Number>(offset, sample.value);
        for (int a = 0; result.Gradients && a < 3; ++a)
        {
          result.Gradients->SetComponent(i, 3 * component + a, sample.gradient[a]);
        }
      }
    });
}

/// A cell array at all points, from one field after the other. Marks points inside its cells in `valid`. octrees: keeps
/// those of the fields for the next arrays, as the cache does not. corners, remarks: get what there is to say.
ArrayResult SampleArray(vtkDataSet* input, vtkHyperTreeGrid* source, const std::string& name,
  treeamr::InterpolationMethod method, bool gradients, std::vector<char>& valid,
  std::vector<std::shared_ptr<const treeamr::Octree>>& octrees, treeamr::CornerRemarks& corners,
  std::vector<treeamr::Remark>& remarks)
{
  const vtkIdType points = input->GetNumberOfPoints();
  std::vector<char> inCells(points);
  ArrayResult result;
  for (int c = 0; !result.Values || c < result.Values->GetNumberOfComponents(); ++c)
  {
    auto field = treeamr::acquireField(source, { name, c });
    octrees.push_back(field->sharedOctree());
    vtkDataArray& cells = *source->GetCellData()->GetArray(name.c_str());
    if (method == treeamr::InterpolationMethod::GTI) // others take means
    {
      corners.add(cells, *field);
    }
    remarks.push_back(treeamr::unsuitableRange(cells, *field));
    remarks.push_back(treeamr::roundedIntegers(cells, *field));
    if (!result.Values)
    {
      const int components = treeamr::fieldComponents(cells);
      // Of bits not all can be written at once.
      const int type = cells.GetDataType() == VTK_BIT ? VTK_UNSIGNED_CHAR : cells.GetDataType();
      result.Values = NewArray(type, name, components, points);
      if (gradients)
      {
        result.Gradients = NewArray(VTK_DOUBLE, name + "_gradient", 3 * components, points);
      }
    }
    const double offset = field->offset();
    const auto sampler = treeamr::Sampler::create(method, std::move(field));
    switch (result.Values->GetDataType())
    {
      vtkTemplateMacro(SampleComponent(
        *sampler, offset, input, c, result, static_cast<VTK_TT*>(result.Values->GetVoidPointer(0)), inCells));
    }
  }
  std::transform(valid.begin(), valid.end(), inCells.begin(), valid.begin(), std::logical_or<>());
  return result;
}

/// Of each point the place of its cell in the cell arrays, -1 where it has none.
std::vector<vtkIdType> FindCells(vtkDataSet* input, vtkHyperTreeGrid* source)
{
  if (input->GetNumberOfPoints() == 0)
  {
    return {};
  }
  const auto octree = treeamr::acquireOctree(source);
  std::vector<vtkIdType> places(input->GetNumberOfPoints(), -1);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, places.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
    {
      std::array<double, 3> point;
      input->GetPoint(static_cast<vtkIdType>(i), point.data());
      if (treeamr::CellId cell; treeamr::findCell(*octree, point, cell))
      {
        places[i] = treeamr::globalIndex(*source, cell);
      }
    }
  });
  return places;
}

/// A cell array's own tuples at all points. Marks points that have a finite number in `valid`. Throws Error for an array
/// that is too short.
ArrayResult CopyArray(
  vtkDataArray* cells, const std::vector<vtkIdType>& places, bool gradients, std::vector<char>& valid)
{
  const auto points = static_cast<vtkIdType>(places.size());
  const int components = cells->GetNumberOfComponents();
  const vtkIdType last = points > 0 ? *std::max_element(places.begin(), places.end()) : -1;
  if (last >= cells->GetNumberOfTuples())
  {
    throw treeamr::Error("hyper tree grid: cell array '" + std::string(cells->GetName()) + "' has " +
      std::to_string(cells->GetNumberOfTuples()) + " tuples, a cell at a point has number " +
      std::to_string(last));
  }
  ArrayResult result{ NewArray(cells->GetDataType(), cells->GetName(), components, points), nullptr };
  for (vtkIdType i = 0; i < points; ++i)
  {
    if (places[i] < 0)
    {
      continue; // cleared later
    }
    result.Values->SetTuple(i, places[i], cells);
    for (int c = 0; !valid[i] && c < components; ++c)
    {
      valid[i] = std::isfinite(cells->GetComponent(places[i], c));
    }
  }
  if (gradients)
  {
    result.Gradients =
      NewArray(VTK_DOUBLE, std::string(cells->GetName()) + "_gradient", 3 * components, points);
    result.Gradients->Fill(0.);
  }
  return result;
}

/// Whether the grid's depth limit is above some of its leaves.
bool IsLimited(vtkHyperTreeGrid* grid)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator trees;
  grid->InitializeTreeIterator(trees);
  bool limited = false;
  while (vtkHyperTree* tree = trees.GetNextTree())
  {
    limited = limited || tree->GetNumberOfLevels() > grid->GetDepthLimiter() + std::uint64_t(1);
  }
  return limited;
}

/// NaN stands for no value: that is 0 at points where no array has one.
void ClearOutside(vtkDataArray* array, const std::vector<char>& valid)
{
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
  {
    for (int c = 0; !valid[i] && c < array->GetNumberOfComponents(); ++c)
    {
      array->SetComponent(i, c, 0.);
    }
  }
}

/// Throws Error unless the points come first and the grid second.
void CheckInputs(vtkDataObject* input, vtkDataObject* source)
{
  const bool inputIsGrid = vtkHyperTreeGrid::SafeDownCast(input) != nullptr;
  const bool sourceIsGrid =
    vtkHyperTreeGrid::SafeDownCast(source) || !treeamr::gridsWithTrees(source).empty();
  if (inputIsGrid || !sourceIsGrid)
  {
    throw treeamr::Error(std::string("probe: Input is a ") + input->GetClassName() + " and Source a " +
      source->GetClassName() +
      "; allowed are a vtkDataSet, which has the points, as Input and a vtkHyperTreeGrid, which has the "
      "values, as "
      "Source" +
      (inputIsGrid && !sourceIsGrid ? ": exchange the two" : ""));
  }
}

/// The source itself, or a collection's grids as one. Throws Error when they are none. remarks: gets what is left out.
vtkSmartPointer<vtkHyperTreeGrid> OneGrid(vtkDataObject* source, std::vector<std::string>& remarks)
{
  if (auto* const grid = vtkHyperTreeGrid::SafeDownCast(source))
  {
    return grid;
  }
  for (const std::string& block : treeamr::blocksOfOtherKinds(source))
  {
    remarks.push_back("probe: " + block + ", which is left out of Source");
  }
  auto merged = vtkSmartPointer<vtkHyperTreeGrid>::New();
  try
  {
    for (const std::string& array : treeamr::mergeGrids(treeamr::gridsWithTrees(source), merged))
    {
      remarks.push_back("probe: left out of the grids of Source: " + array);
    }
  }
  catch (const treeamr::Error& e)
  {
    throw treeamr::Error("probe: the grids of Source, a " + std::string(source->GetClassName()) +
      ", cannot be made one: " + e.what() + ". Extract one block first");
  }
  return merged;
}

/// The arrays whose names are not taken, and their roles where free.
void PassArrays(vtkDataSetAttributes* from, vtkDataSetAttributes* to)
{
  for (int i = 0; i < from->GetNumberOfArrays(); ++i)
  {
    vtkAbstractArray* array = from->GetAbstractArray(i);
    if (!array->GetName() || !to->HasArray(array->GetName()))
    {
      to->AddArray(array);
    }
  }
  for (int i = 0; i < vtkDataSetAttributes::NUM_ATTRIBUTES; ++i)
  {
    vtkAbstractArray* array = from->GetAbstractAttribute(i);
    if (array && array->GetName() && !to->GetAbstractAttribute(i))
    {
      to->SetActiveAttribute(array->GetName(), i);
    }
  }
}

} // namespace

vtkTreeAMRProbeFilter::vtkTreeAMRProbeFilter()
  : Warnings(std::make_unique<treeamr::OnceReporter>())
{
  this->SetNumberOfInputPorts(2);
  this->SetValidPointMaskArrayName("vtkValidPointMask");
}

vtkTreeAMRProbeFilter::~vtkTreeAMRProbeFilter()
{
  this->SetValidPointMaskArrayName(nullptr);
}

void vtkTreeAMRProbeFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  this->CellDataArraySelection->PrintSelf(os, indent.GetNextIndent());
  os << indent << "SelectionIsFinal: " << this->SelectionIsFinal << "\n";
  os << indent << "InterpolationMethod: " << this->InterpolationMethod << "\n";
  os << indent << "ComputeGradients: " << this->ComputeGradients << "\n";
  os << indent << "ValidPointMaskArrayName: "
     << (this->ValidPointMaskArrayName ? this->ValidPointMaskArrayName : "(none)") << "\n";
  os << indent << "PassPointArrays: " << this->PassPointArrays << "\n";
  os << indent << "PassCellArrays: " << this->PassCellArrays << "\n";
  os << indent << "PassFieldArrays: " << this->PassFieldArrays << "\n";
}

vtkMTimeType vtkTreeAMRProbeFilter::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->CellDataArraySelection->GetMTime());
}

void vtkTreeAMRProbeFilter::SetSourceData(vtkHyperTreeGrid* source)
{
  this->SetInputDataInternal(1, source);
}

void vtkTreeAMRProbeFilter::SetSourceConnection(vtkAlgorithmOutput* source)
{
  this->SetInputConnection(1, source);
}

vtkHyperTreeGrid* vtkTreeAMRProbeFilter::GetSource()
{
  return this->GetNumberOfInputConnections(1) > 0
    ? vtkHyperTreeGrid::SafeDownCast(this->GetExecutive()->GetInputData(1, 0))
    : nullptr;
}

// Each takes what is meant for the other, so that RequestData() can tell which is which.
int vtkTreeAMRProbeFilter::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  if (port == 1) // or else the executive would hand over the blocks of a collection one after the other
  {
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  }
  return 1;
}

int vtkTreeAMRProbeFilter::RequestDataObject(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (vtkDataSet::GetData(inputVector[0]))
  {
    return this->Superclass::RequestDataObject(request, inputVector, outputVector);
  }
  if (!vtkDataSet::GetData(outputVector))
  {
    vtkNew<vtkPolyData> empty;
    outputVector->GetInformationObject(0)->Set(vtkDataObject::DATA_OBJECT(), empty);
  }
  return 1;
}

int vtkTreeAMRProbeFilter::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using SDDP = vtkStreamingDemandDrivenPipeline;
  vtkInformation* inInfo = inputVector[0]->GetInformationObject(0);
  vtkInformation* sourceInfo = inputVector[1]->GetInformationObject(0);
  vtkInformation* outInfo = outputVector->GetInformationObject(0);
  outInfo->CopyEntry(sourceInfo, SDDP::TIME_STEPS());
  outInfo->CopyEntry(sourceInfo, SDDP::TIME_RANGE());
  outInfo->CopyEntry(inInfo, SDDP::WHOLE_EXTENT());
  return 1;
}

// Each process has its pieces of the points and of the grid.
int vtkTreeAMRProbeFilter::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  using SDDP = vtkStreamingDemandDrivenPipeline;
  const int done = this->Superclass::RequestUpdateExtent(request, inputVector, outputVector);
  vtkInformation* sourceInfo = inputVector[1]->GetInformationObject(0);
  sourceInfo->Remove(SDDP::UPDATE_EXTENT());
  if (sourceInfo->Has(SDDP::WHOLE_EXTENT()))
  {
    sourceInfo->Set(SDDP::UPDATE_EXTENT(), sourceInfo->Get(SDDP::WHOLE_EXTENT()), 6);
  }
  vtkMultiProcessController* const controller =
    treeamr::pieceController(outputVector->GetInformationObject(0));
  sourceInfo->Set(SDDP::UPDATE_PIECE_NUMBER(), controller ? controller->GetLocalProcessId() : 0);
  sourceInfo->Set(SDDP::UPDATE_NUMBER_OF_PIECES(), controller ? controller->GetNumberOfProcesses() : 1);
  sourceInfo->Set(SDDP::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  return done;
}

int vtkTreeAMRProbeFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataSet* output = vtkDataSet::GetData(outputVector);
  try
  {
    vtkDataSet* input = vtkDataSet::GetData(inputVector[0]);
    std::vector<std::string> remarks;
    vtkSmartPointer<vtkHyperTreeGrid> source;
    const auto findSource = [&] {
      CheckInputs(vtkDataObject::GetData(inputVector[0]), vtkDataObject::GetData(inputVector[1]));
      source = OneGrid(vtkDataObject::GetData(inputVector[1]), remarks);
      output->CopyStructure(input);
    };
    if (auto* const controller = treeamr::pieceController(outputVector->GetInformationObject(0)))
    {
      const treeamr::ProcessGroup group(*controller);
      group.together(findSource);
      this->ProbeOnAll(group, input, source, remarks, output);
    }
    else
    {
      findSource();
      this->Probe(input, source, remarks, output);
    }
    if (this->PassPointArrays)
    {
      PassArrays(input->GetPointData(), output->GetPointData());
    }
    if (this->PassCellArrays)
    {
      PassArrays(input->GetCellData(), output->GetCellData());
    }
    // The pipeline passes field data beforehand, but the CopyStructure() of some data sets clears it.
    output->GetFieldData()->Initialize();
    if (this->PassFieldArrays)
    {
      output->GetFieldData()->PassData(input->GetFieldData());
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

// The grid's cells go to the processes' boxes, the points to those in whose boxes they lie, and the values back.
void vtkTreeAMRProbeFilter::ProbeOnAll(const treeamr::ProcessGroup& group, vtkDataSet* input,
  vtkHyperTreeGrid* source, const std::vector<std::string>& remarksOnSource, vtkDataSet* output)
{
  std::vector<std::string> names;
  group.together(
    [&] { names = treeamr::takenArrays(*source, *this->CellDataArraySelection, this->SelectionIsFinal); });
  const treeamr::ExchangedGrid exchanged = treeamr::exchangeGrid(source, &group.controller(), { names });
  std::vector<std::string> remarks = remarksOnSource;
  for (const std::string& array : exchanged.leftOut)
  {
    remarks.push_back("probe: left out of Source: " + array);
  }
  if (!group.any(treeamr::partitionOf(*exchanged.grid).has_value()))
  {
    throw treeamr::Error("probe: the source holds no tree on any process");
  }
  const treeamr::PointExchange exchange(group, *exchanged.grid, *input);
  vtkNew<vtkPolyData> answers;
  std::string failure;
  const bool hasTrees = !treeamr::gridsWithTrees(exchanged.grid).empty();
  group.together([&] {
    try
    {
      if (hasTrees)
      {
        this->Probe(&exchange.asked(), exchanged.grid, remarks, answers);
      }
    }
    catch (const treeamr::Error& error)
    {
      failure = error.what(); // as where all values are NaN: others may have some
    }
  });
  const bool isAnswered = group.any(hasTrees && failure.empty());
  group.together([&] {
    if (!isAnswered && !failure.empty())
    {
      throw treeamr::Error(failure);
    }
  });
  exchange.answer(*answers->GetPointData(), *output->GetPointData());
  group.together([&] {
    vtkDataArray* mask = output->GetPointData()->GetArray(this->ValidPointMaskArrayName);
    if (!mask)
    {
      vtkNew<vtkCharArray> none;
      none->SetName(this->ValidPointMaskArrayName);
      none->SetNumberOfValues(input->GetNumberOfPoints());
      none->Fill(0.);
      output->GetPointData()->AddArray(none);
      mask = none;
    }
    std::vector<char> valid(static_cast<std::size_t>(input->GetNumberOfPoints()));
    for (std::size_t i = 0; i < valid.size(); ++i)
    {
      valid[i] = static_cast<char>(mask->GetComponent(static_cast<vtkIdType>(i), 0));
    }
    for (int i = 0; i < output->GetPointData()->GetNumberOfArrays(); ++i)
    {
      ClearOutside(output->GetPointData()->GetArray(i), valid);
    }
  });
}

void vtkTreeAMRProbeFilter::Probe(vtkDataSet* input, vtkHyperTreeGrid* source,
  const std::vector<std::string>& remarksOnSource, vtkDataSet* output)
{
  const vtkIdType points = input->GetNumberOfPoints();
  if (points > 0)
  {
    double unused[3];
    input->GetPoint(0, unused); // the first call builds what later ones only read
  }
  const auto method = static_cast<treeamr::InterpolationMethod>(this->InterpolationMethod);
  std::vector<char> valid(points);
  std::vector<std::shared_ptr<const treeamr::Octree>> octrees;
  std::vector<ArrayResult> results;
  std::vector<treeamr::Remark> remarks;
  treeamr::CornerRemarks corners;
  // Above the depth limit cells have means of leaves, which no array holds.
  const bool copies = this->InterpolationMethod == NEAREST && !IsLimited(source);
  std::vector<vtkIdType> places;
  bool hasCells = true;
  for (const std::string& name :
    treeamr::takenArrays(*source, *this->CellDataArraySelection, this->SelectionIsFinal))
  {
    try
    {
      vtkDataArray* array = source->GetCellData()->GetArray(name.c_str());
      if (array && copies && !treeamr::isAtCorners(*array))
      {
        places = places.empty() ? FindCells(input, source) : std::move(places);
        results.push_back(CopyArray(array, places, this->ComputeGradients, valid));
        continue;
      }
      results.push_back(
        SampleArray(input, source, name, method, this->ComputeGradients, valid, octrees, corners, remarks));
    }
    catch (const treeamr::NoCells&)
    {
      hasCells = false;
    }
    catch (const treeamr::Error& e)
    {
      remarks.push_back({ e.what(), e.what() });
    }
  }

  if (results.empty() && hasCells)
  {
    throw treeamr::Error(remarks.empty()
        ? "probe: the source has no numeric cell array that is named and selected"
        : remarks.front().text);
  }
  std::ranges::move(corners.all(), std::back_inserter(remarks));
  for (const std::string& text : remarksOnSource)
  {
    remarks.push_back({ text, text });
  }
  for (const treeamr::Remark& remark : remarks)
  {
    if (!remark.text.empty() && this->Warnings->isNews(remark.about))
    {
      vtkWarningMacro(<< remark.text);
    }
  }
  this->Warnings->endRound();
  for (const ArrayResult& result : results)
  {
    for (vtkDataArray* array : { result.Values.Get(), result.Gradients.Get() })
    {
      if (array)
      {
        ClearOutside(array, valid);
        output->GetPointData()->AddArray(array);
      }
    }
  }
  vtkNew<vtkCharArray> mask;
  mask->SetName(this->ValidPointMaskArrayName);
  mask->SetNumberOfValues(points);
  std::copy(valid.begin(), valid.end(), mask->GetPointer(0));
  output->GetPointData()->AddArray(mask);
}

// One surface after the other in the core, put together here.
#include "vtkTreeAMRContourFilter.h"

#include "CornerArrays.h"
#include "FilteredArrays.h"
#include "HyperTreeGridConverter.h"
#include "LostDigits.h"
#include "MergedGrid.h"
#include "OnceReporter.h"
#include "PieceController.h"
#include "ProcessGroup.h"

#include "Contour/Contour.h"
#include "Error.h"
#include "GridExchange.h"
#include "GridPartition.h"
#include "Interpolation/Sampler.h"
#include "Surface/SurfaceFrame.h"

#include "vtkAppendPolyData.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkTypeInt32Array.h"
#include "vtkTypeInt64Array.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

vtkStandardNewMacro(vtkTreeAMRContourFilter);

namespace
{

/// The surface of an isovalue, and the number of its first point in the output.
struct Surface
{
  double Value;
  vtkIdType FirstPoint;
  treeamr::ContourMesh Mesh;
};

/// Calls body(first, end) for ranges of [0, count) in parallel.
template <class Body>
void ForRanges(std::size_t count, const Body& body)
{
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096),
    [&](const auto& range) { body(range.begin(), range.end()); });
}

void AddPoints(const std::vector<Surface>& surfaces, vtkIdType count, vtkPolyData* output)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  for (const Surface& surface : surfaces)
  {
    double* to = static_cast<double*>(points->GetVoidPointer(0)) + 3 * surface.FirstPoint;
    for (const auto& point : surface.Mesh.points)
    {
      to = std::copy(point.begin(), point.end(), to);
    }
  }
  output->SetPoints(points);
}

template <class Array>
void AddTrianglesOf(const std::vector<Surface>& surfaces, vtkIdType count, vtkPolyData* output)
{
  using Number = typename Array::ValueType;
  vtkNew<Array> offsets;
  offsets->SetNumberOfValues(count + 1);
  vtkNew<Array> connectivity;
  connectivity->SetNumberOfValues(3 * count);
  Number* offset = offsets->GetPointer(0);
  ForRanges(static_cast<std::size_t>(count) + 1, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i)
    {
      offset[i] = static_cast<Number>(3 * i);
    }
  });
  Number* to = connectivity->GetPointer(0);
  for (const Surface& surface : surfaces)
  {
    const auto& triangles = surface.Mesh.triangles;
    ForRanges(triangles.size(), [&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i)
      {
        for (int c = 0; c < 3; ++c)
        {
          to[3 * i + c] = static_cast<Number>(surface.FirstPoint + triangles[i][c]);
        }
      }
    });
    to += 3 * triangles.size();
  }
  vtkNew<vtkCellArray> polygons;
  polygons->SetData(offsets, connectivity);
  output->SetPolys(polygons);
}

void AddTriangles(
  const std::vector<Surface>& surfaces, vtkIdType points, vtkIdType triangles, vtkPolyData* output)
{
  if (std::max(points, 3 * triangles) < std::numeric_limits<vtkTypeInt32>::max())
  {
    AddTrianglesOf<vtkTypeInt32Array>(surfaces, triangles, output);
  }
  else
  {
    AddTrianglesOf<vtkTypeInt64Array>(surfaces, triangles, output);
  }
}

/// A vector of each point: convert(its gradient).
template <class Array, class Convert>
vtkSmartPointer<Array> VectorArray(
  const std::vector<Surface>& surfaces, vtkIdType count, const char* name, const Convert& convert)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(count);
  for (const Surface& surface : surfaces)
  {
    const auto& gradients = surface.Mesh.gradients;
    auto* to = array->GetPointer(3 * surface.FirstPoint);
    ForRanges(gradients.size(), [&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i)
      {
        const std::array<double, 3> vector = convert(gradients[i]);
        for (int a = 0; a < 3; ++a)
        {
          to[3 * i + a] = static_cast<typename Array::ValueType>(vector[a]);
        }
      }
    });
  }
  return array;
}

/// Of doubles where the cells' values may have more digits than floats.
vtkSmartPointer<vtkDataArray> NewPointArray(vtkDataArray* cells, int components, vtkIdType count)
{
  const bool fitsFloat =
    cells->GetDataType() == VTK_FLOAT || cells->GetDataTypeSize() < static_cast<int>(sizeof(float));
  auto array =
    vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(fitsFloat ? VTK_FLOAT : VTK_DOUBLE));
  array->SetName(cells->GetName());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(count);
  return array;
}

/// The isovalue of each point, as the array that is contoured would hold it.
vtkSmartPointer<vtkDataArray> Isovalues(
  vtkDataArray* contoured, const std::vector<Surface>& surfaces, vtkIdType points)
{
  vtkSmartPointer<vtkDataArray> values = NewPointArray(contoured, 1, points);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
  {
    const vtkIdType end = i + 1 < surfaces.size() ? surfaces[i + 1].FirstPoint : points;
    for (vtkIdType p = surfaces[i].FirstPoint; p < end; ++p)
    {
      values->SetComponent(p, 0, surfaces[i].Value);
    }
  }
  return values;
}

/// Relative values, for a field that cuts other cells from the octree than the contoured one.
std::vector<float> SampleEach(
  const std::shared_ptr<const treeamr::Field>& field, const std::vector<std::array<double, 3>>& points)
{
  const auto sampler = treeamr::Sampler::create(treeamr::InterpolationMethod::GTI, field);
  std::vector<float> values(points.size());
  ForRanges(points.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i)
    {
      treeamr::FieldSample sample{ std::numeric_limits<double>::quiet_NaN(), {} };
      sampler->sampleRelative(points[i], sample);
      values[i] = static_cast<float>(sample.value);
    }
  });
  return values;
}

/// A cell array at all points. corners: what there is to say of its own; warn(remark): what else there is.
template <class Warn>
vtkSmartPointer<vtkDataArray> Interpolate(vtkHyperTreeGrid* input, const std::string& name,
  const treeamr::Octree& octree, const std::vector<Surface>& surfaces, vtkIdType count,
  treeamr::CornerRemarks& corners, const Warn& warn)
{
  vtkDataArray* cells = input->GetCellData()->GetArray(name.c_str());
  const int components = cells ? treeamr::fieldComponents(*cells) : 0;
  const auto array = cells ? NewPointArray(cells, components, count) : nullptr;
  for (int c = 0; !cells || (c < components && count > 0); ++c)
  {
    const auto field = treeamr::acquireField(input, { name, c }); // throws without the array
    corners.add(*cells, *field);
    warn(treeamr::unsuitableRange(*cells, *field));
    warn(treeamr::roundedIntegers(*cells, *field));
    for (const Surface& surface : surfaces)
    {
      const std::vector<float> values = &field->octree() == &octree
        ? treeamr::interpolate(*field, surface.Mesh)
        : SampleEach(field, surface.Mesh.points);
      ForRanges(values.size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i)
        {
          array->SetComponent(surface.FirstPoint + static_cast<vtkIdType>(i), c, field->offset() + values[i]);
        }
      });
    }
  }
  return array;
}

/// Of the array to contour, be it there or not. Of no name, as a proxy has before its input is up to date: the active
/// scalars, or else the first array.
std::string NameOf(vtkHyperTreeGrid* input, vtkDataArray* found, vtkInformation* wanted)
{
  if (found && found->GetName())
  {
    return found->GetName();
  }
  const char* const name = wanted->Get(vtkDataObject::FIELD_NAME());
  if (name && *name)
  {
    return name;
  }
  vtkCellData* const cells = input->GetCellData();
  vtkDataArray* const first = cells->GetScalars() ? cells->GetScalars() : cells->GetArray(0);
  if (name && first && first->GetName())
  {
    return first->GetName();
  }
  throw treeamr::Error(
    "contour: the input has no active cell scalars of a name; call SetInputArrayToProcess() with the name of "
    "one of its cell arrays, or choose one in Contour By");
}

} // namespace

vtkTreeAMRContourFilter::vtkTreeAMRContourFilter()
  : Warnings(std::make_unique<treeamr::OnceReporter>())
{
  this->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, vtkDataSetAttributes::SCALARS);
}

vtkTreeAMRContourFilter::~vtkTreeAMRContourFilter() = default;

void vtkTreeAMRContourFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  this->ContourValues->PrintSelf(os, indent.GetNextIndent());
  this->CellDataArraySelection->PrintSelf(os, indent.GetNextIndent());
  os << indent << "SelectionIsFinal: " << this->SelectionIsFinal << "\n";
  os << indent << "Component: " << this->Component << "\n";
  os << indent << "ComputeNormals: " << this->ComputeNormals << "\n";
  os << indent << "ComputeGradients: " << this->ComputeGradients << "\n";
  os << indent << "ComputeScalars: " << this->ComputeScalars << "\n";
}

void vtkTreeAMRContourFilter::SetValue(int i, double value)
{
  this->ContourValues->SetValue(i, value);
}

double vtkTreeAMRContourFilter::GetValue(int i)
{
  return this->ContourValues->GetValue(i);
}

double* vtkTreeAMRContourFilter::GetValues()
{
  return this->ContourValues->GetValues();
}

void vtkTreeAMRContourFilter::GetValues(double* contourValues)
{
  this->ContourValues->GetValues(contourValues);
}

void vtkTreeAMRContourFilter::SetNumberOfContours(int number)
{
  this->ContourValues->SetNumberOfContours(number);
}

vtkIdType vtkTreeAMRContourFilter::GetNumberOfContours()
{
  return this->ContourValues->GetNumberOfContours();
}

void vtkTreeAMRContourFilter::GenerateValues(int numContours, double range[2])
{
  this->ContourValues->GenerateValues(numContours, range);
}

void vtkTreeAMRContourFilter::GenerateValues(int numContours, double rangeStart, double rangeEnd)
{
  this->ContourValues->GenerateValues(numContours, rangeStart, rangeEnd);
}

vtkMTimeType vtkTreeAMRContourFilter::GetMTime()
{
  return std::max({ this->Superclass::GetMTime(), this->ContourValues->GetMTime(),
    this->CellDataArraySelection->GetMTime() });
}

int vtkTreeAMRContourFilter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  // Named too, or else the executive would hand over the blocks one after the other.
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

int vtkTreeAMRContourFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0]);
  vtkPolyData* output = vtkPolyData::GetData(outputVector);
  try
  {
    if (auto* const controller = treeamr::pieceController(outputVector->GetInformationObject(0)))
    {
      this->ContourOnAll(treeamr::ProcessGroup(*controller), input, output);
    }
    else
    {
      this->ContourAll(input, output);
    }
    this->Warnings->endRound();
  }
  catch (const treeamr::NoCells&)
  {
    output->Initialize();
  }
  catch (const std::exception& e)
  {
    output->Initialize();
    vtkErrorMacro(<< e.what());
    return 0;
  }
  return 1;
}

// The processes' grids as one, of which each contours its box; collections as each process can by itself.
void vtkTreeAMRContourFilter::ContourOnAll(
  const treeamr::ProcessGroup& group, vtkDataObject* input, vtkPolyData* output)
{
  std::vector<treeamr::NamedGrid> grids;
  std::vector<std::string> arrays;
  group.together([&] {
    grids = treeamr::gridsWithTrees(input);
    if (grids.size() == 1)
    {
      vtkHyperTreeGrid* const grid = grids.front().grid;
      arrays = treeamr::takenArrays(*grid, *this->CellDataArraySelection, this->SelectionIsFinal);
      arrays.push_back(
        NameOf(grid, this->GetInputArrayToProcess(0, grid), this->GetInputArrayInformation(0)));
    }
  });
  if (group.any(grids.size() > 1 || (!grids.empty() && !vtkHyperTreeGrid::SafeDownCast(input))))
  {
    group.together([&] { this->ContourAll(input, output); });
    return;
  }
  const treeamr::ExchangedGrid exchanged =
    treeamr::exchangeGrid(grids.empty() ? nullptr : grids.front().grid, &group.controller(), { arrays });
  group.together([&] {
    for (const std::string& array : exchanged.leftOut)
    {
      const std::string text = "contour: left out: " + array;
      this->Warn({ text, text });
    }
    if (exchanged.grid && !treeamr::gridsWithTrees(exchanged.grid).empty())
    {
      this->Contour(exchanged.grid, output);
    }
  });
}

// Grids on one lattice as one, without seams; others one by one.
void vtkTreeAMRContourFilter::ContourAll(vtkDataObject* input, vtkPolyData* output)
{
  const std::vector<treeamr::NamedGrid> grids = treeamr::gridsWithTrees(input);
  for (const std::string& block : treeamr::blocksOfOtherKinds(input))
  {
    const std::string text = "contour: " + block + ", which is left out";
    this->Warn({ text, text });
  }
  if (grids.size() < 2)
  {
    if (!grids.empty())
    {
      this->Contour(grids[0].grid, output); // not a copy, of which nothing is known from times before
    }
    return;
  }
  vtkNew<vtkHyperTreeGrid> merged;
  std::string objection;
  try
  {
    for (const std::string& array : treeamr::mergeGrids(grids, merged))
    {
      const std::string text = "contour: left out of the grids of the collection: " + array;
      this->Warn({ text, text });
    }
  }
  catch (const treeamr::Error& e)
  {
    objection = e.what();
  }
  if (objection.empty())
  {
    this->Contour(merged, output);
    return;
  }
  const std::string text = "contour: the grids of the collection are contoured one by one, with gaps between "
                           "them, for they cannot be made one: " +
    objection;
  this->Warn({ text, text });
  vtkNew<vtkAppendPolyData> all;
  for (const treeamr::NamedGrid& grid : grids)
  {
    vtkNew<vtkPolyData> part;
    this->Contour(grid.grid, part);
    all->AddInputData(part);
  }
  all->Update();
  output->ShallowCopy(all->GetOutput());
}

void vtkTreeAMRContourFilter::Contour(vtkHyperTreeGrid* input, vtkPolyData* output)
{
  const std::string contouredName =
    NameOf(input, this->GetInputArrayToProcess(0, input), this->GetInputArrayInformation(0));
  vtkDataArray* contoured = input->GetCellData()->GetArray(contouredName.c_str());
  // As ParaView's list of components has it, one beyond the last is the magnitude.
  const bool isMagnitude = contoured && this->Component == treeamr::fieldComponents(*contoured);
  const auto field = treeamr::acquireField(input, { contouredName, isMagnitude ? -1 : this->Component });
  treeamr::CornerRemarks corners;
  corners.add(*contoured, *field);
  this->Warn(treeamr::unsuitableRange(*contoured, *field));
  std::vector<Surface> surfaces(this->GetNumberOfContours());
  vtkIdType points = 0;
  vtkIdType triangles = 0;
  treeamr::ContourOptions options;
  options.gradients = this->ComputeNormals || this->ComputeGradients;
  if (const auto partition = treeamr::partitionOf(*input))
  {
    options.box = partition->box();
  }
  for (std::size_t i = 0; i < surfaces.size(); ++i)
  {
    options.progress = [&](double done) {
      this->UpdateProgress(0.9 * (static_cast<double>(i) + done) / static_cast<double>(surfaces.size()));
      return !this->GetAbortExecute();
    };
    const double value = this->GetValue(static_cast<int>(i));
    surfaces[i] = { value, points, treeamr::contour(*field, value, options) };
    if (this->GetAbortExecute())
    {
      return;
    }
    points += static_cast<vtkIdType>(surfaces[i].Mesh.points.size());
    triangles += static_cast<vtkIdType>(surfaces[i].Mesh.triangles.size());
  }

  AddPoints(surfaces, points, output);
  AddTriangles(surfaces, points, triangles, output);
  vtkPointData* pointData = output->GetPointData();
  if (this->ComputeScalars)
  {
    pointData->SetScalars(Isovalues(contoured, surfaces, points));
  }
  if (this->ComputeGradients)
  {
    pointData->SetVectors(VectorArray<vtkDoubleArray>(
      surfaces, points, "Gradients", [](const auto& gradient) { return gradient; }));
  }
  if (this->ComputeNormals)
  {
    pointData->SetNormals(VectorArray<vtkFloatArray>(surfaces, points, "Normals", [](const auto& gradient) {
      const auto [x, y, z] = treeamr::normalized(gradient);
      return std::array<double, 3>{ -x, -y, -z };
    }));
  }
  const auto interpolate = [&](const std::string& name) {
    return Interpolate(input, name, field->octree(), surfaces, points, corners,
      [this](const treeamr::Remark& remark) { this->Warn(remark); });
  };
  for (const std::string& name :
    treeamr::takenArrays(*input, *this->CellDataArraySelection, this->SelectionIsFinal))
  {
    if (this->GetAbortExecute())
    {
      return;
    }
    if (input->GetCellData()->GetArray(name.c_str()) == contoured)
    {
      continue;
    }
    try
    {
      pointData->AddArray(interpolate(name));
    }
    catch (const treeamr::Error& e)
    {
      this->Warn({ e.what(), e.what() });
    }
  }
  for (const treeamr::Remark& remark : corners.all())
  {
    this->Warn(remark);
  }
}

void vtkTreeAMRContourFilter::Warn(const treeamr::Remark& remark)
{
  if (!remark.text.empty() && this->Warnings->isNews(remark.about))
  {
    vtkWarningMacro(<< remark.text);
  }
}

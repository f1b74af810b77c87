#include "IsosurfaceTriangles.h"

#include "MapperInput.h"
#include "SurfaceColors.h"

#include "Interpolation/Sampler.h"

#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkTreeAMRContourFilter.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkUnsignedCharArray.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace treeamr
{

namespace
{

/// values[stride * i]: of the field at point i, less its offset, NaN where it has none.
void sampleAtPoints(const std::shared_ptr<const Field>& field, InterpolationMethod method,
  vtkPolyData* triangles, std::size_t stride, float* values)
{
  const std::unique_ptr<Sampler> sampler = Sampler::create(method, field);
  tbb::parallel_for(
    tbb::blocked_range<vtkIdType>(0, triangles->GetNumberOfPoints(), 4096), [&](const auto& range) {
      for (vtkIdType i = range.begin(); i < range.end(); ++i)
      {
        std::array<double, 3> point;
        triangles->GetPoint(i, point.data());
        FieldSample sample{ std::numeric_limits<double>::quiet_NaN(), {} };
        sampler->sampleRelative(point, sample);
        values[stride * static_cast<std::size_t>(i)] = static_cast<float>(sample.value);
      }
    });
}

/// Which surface each point is of, by the isovalue in the active scalars, as hits have it.
std::vector<SurfaceHit> surfacesOf(vtkPolyData* triangles, const std::vector<double>& isovalues)
{
  vtkDataArray* scalars = triangles->GetPointData()->GetScalars();
  std::vector<SurfaceHit> hits(static_cast<std::size_t>(triangles->GetNumberOfPoints()));
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    // Those in the array may be rounded to single precision.
    const double value = scalars->GetTuple1(static_cast<vtkIdType>(i));
    const auto nearest = std::min_element(isovalues.begin(), isovalues.end(),
      [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); });
    hits[i].surface = static_cast<std::uint32_t>(nearest - isovalues.begin());
  }
  return hits;
}

} // namespace

vtkStandardNewMacro(IsosurfaceTriangles);

void IsosurfaceTriangles::SetMapper(vtkTreeAMRIsosurfaceMapper* mapper)
{
  if (this->Mapper != mapper)
  {
    this->Mapper = mapper;
    this->Modified();
  }
}

vtkMTimeType IsosurfaceTriangles::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->Mapper->GetMTime());
}

int IsosurfaceTriangles::FillInputPortInformation(int vtkNotUsed(port), vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  // A mapper without input has no surface.
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

int IsosurfaceTriangles::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkHyperTreeGrid* input = vtkHyperTreeGrid::GetData(inputVector[0]);
  vtkPolyData* output = vtkPolyData::GetData(outputVector);
  if (!input)
  {
    return 1;
  }
  vtkNew<vtkHyperTreeGrid> grid;
  grid->ShallowCopy(input);
  const std::string contoured = processedArrayName(this->Mapper, grid);
  vtkNew<vtkTreeAMRContourFilter> filter;
  filter->SetInputDataObject(grid);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, contoured.c_str());
  filter->SetComponent(this->Mapper->GetIsosurfaceComponent());
  filter->GetCellDataArraySelection()->DisableArray(contoured.c_str()); // and with it all others
  filter->SetNumberOfContours(static_cast<int>(this->Mapper->GetNumberOfContours()));
  for (int i = 0; i < this->Mapper->GetNumberOfContours(); ++i)
  {
    filter->SetValue(i, this->Mapper->GetValue(i));
  }
  filter->Update();
  output->ShallowCopy(filter->GetOutput());
  if (output->GetNumberOfPoints() == 0)
  {
    return 1;
  }
  vtkSmartPointer<vtkDataArray> colors;
  try
  {
    colors = this->Colors(grid, output);
  }
  catch (const std::exception& error)
  {
    vtkWarningMacro(<< describe(error));
  }
  // Isovalues that stayed the active scalars would be taken for colours.
  colors ? output->GetPointData()->SetScalars(colors) : output->GetPointData()->SetActiveScalars(nullptr);
  return 1;
}

vtkSmartPointer<vtkUnsignedCharArray> IsosurfaceTriangles::Colors(
  vtkHyperTreeGrid* grid, vtkPolyData* triangles)
{
  const ColorSource source = selectColors(this->Mapper, grid);
  if (!source.array)
  {
    return nullptr;
  }
  std::vector<double> isovalues(this->Mapper->GetNumberOfContours());
  this->Mapper->GetValues(isovalues.data());
  const std::vector<SurfaceHit> hits = surfacesOf(triangles, isovalues);
  const std::size_t count = source.components.size();
  const bool ofItself = count == 1 &&
    isSameArray(grid, source.components[0],
      { processedArrayName(this->Mapper, grid), this->Mapper->GetIsosurfaceComponent() });
  std::vector<float> values(count * hits.size());
  HitColors colors;
  if (hasCategories(this->Mapper, source))
  {
    const auto categories = acquireCategories(grid, source.components[0]);
    sampleAtPoints(
      { categories, &categories->numbers }, InterpolationMethod::Nearest, triangles, 1, values.data());
    colors = mapCategories(this->Mapper, *categories, values, hits, ofItself ? &isovalues : nullptr);
  }
  else if (ofItself)
  {
    colors = mapIsovalues(this->Mapper, source, isovalues);
  }
  else
  {
    std::vector<double> offsets;
    for (std::size_t c = 0; c < count; ++c)
    {
      const auto field = acquireField(grid, source.components[c]);
      sampleAtPoints(field, InterpolationMethod::GTI, triangles, count, &values[c]);
      offsets.push_back(field->offset());
    }
    colors = mapValues(this->Mapper, source, values, offsets);
  }
  auto rgba = vtkSmartPointer<vtkUnsignedCharArray>::New();
  rgba->SetName("Colors");
  rgba->SetNumberOfComponents(4);
  rgba->SetNumberOfTuples(triangles->GetNumberOfPoints());
  for (std::size_t i = 0; i < hits.size(); ++i)
  {
    std::copy_n(colors.at(hits, i), 4, rgba->GetPointer(4 * static_cast<vtkIdType>(i)));
  }
  return rgba;
}

} // namespace treeamr

// The probe filter against the core's samplers and fields with exact answers.
#include "vtkTreeAMRProbeFilter.h"

#include "HyperTreeGridConverter.h"
#include "vtkTreeAMRExampleSource.h"

#include "Interpolation/Sampler.h"
#include "Support/HyperTreeGrids.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkCharArray.h"
#include "vtkCommand.h"
#include "vtkCompositeDataPipeline.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkImageData.h"
#include "vtkIntArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkTypeInt64Array.h"
#include "vtkUnsignedCharArray.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

bool isValid(vtkDataSet* output, vtkIdType point)
{
  return output->GetPointData()->GetArray("vtkValidPointMask")->GetTuple1(point) != 0.;
}

} // namespace

TEST(ProbeFilter, EqualsTheSamplerForEachMethodAndComponent)
{
  const auto grid = makeGrid({ .roots = { 2, 2, 2 }, .missingTrees = 0.2, .masked = 0.1, .ghosts = 0.05 });
  double bounds[6];
  computeLocalBounds(grid, bounds);
  const auto points =
    randomPoints({ bounds[0] - 0.5, bounds[1] + 0.5, bounds[2], bounds[3], bounds[4], bounds[5] }, 2000);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(points);
  probe->SetSourceData(grid);
  probe->ComputeGradientsOn();
  EXPECT_EQ(probe->GetSource(), grid);
  EXPECT_EQ(probe->GetInterpolationMethod(), vtkTreeAMRProbeFilter::GTI);
  for (int method = vtkTreeAMRProbeFilter::NEAREST; method <= vtkTreeAMRProbeFilter::GTI; ++method)
  {
    probe->SetInterpolationMethod(method);
    probe->Update();
    vtkDataSet* output = probe->GetOutput();
    ASSERT_EQ(output->GetNumberOfPoints(), 2000);
    EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 7); // three arrays, their gradients, the mask
    int inside = 0;
    for (const std::string name : { "scalar", "vector", "count" })
    {
      vtkDataArray* values = output->GetPointData()->GetArray(name.c_str());
      vtkDataArray* gradients = output->GetPointData()->GetArray((name + "_gradient").c_str());
      ASSERT_NE(values, nullptr) << name;
      ASSERT_NE(gradients, nullptr) << name;
      const bool isNearest = method == vtkTreeAMRProbeFilter::NEAREST;
      const int type = grid->GetCellData()->GetArray(name.c_str())->GetDataType();
      EXPECT_EQ(values->GetDataType(), type);
      EXPECT_EQ(values->GetNumberOfComponents(), name == "vector" ? 3 : 1);
      EXPECT_EQ(gradients->GetNumberOfComponents(), 3 * values->GetNumberOfComponents());
      const auto rounded = [&](double x) {
        return type == VTK_DOUBLE ? x : type == VTK_INT ? std::round(x) : static_cast<float>(x);
      };
      for (int c = 0; c < values->GetNumberOfComponents(); ++c)
      {
        const auto sampler =
          Sampler::create(static_cast<InterpolationMethod>(method), acquireField(grid, { name, c }));
        for (vtkIdType i = 0; i < 2000; ++i)
        {
          std::array<double, 3> p;
          points->GetPoint(i, p.data());
          FieldSample expected;
          ASSERT_EQ(sampler->sample(p, expected), isValid(output, i));
          inside += isValid(output, i);
          const double found = values->GetComponent(i, c); // with all digits of the cell's own value
          ASSERT_EQ(isNearest ? static_cast<float>(found) : found, rounded(expected.value))
            << name << " at point " << i;
          for (int a = 0; a < 3; ++a)
          {
            ASSERT_EQ(gradients->GetComponent(i, 3 * c + a), expected.gradient[a]) << name;
          }
        }
      }
    }
    EXPECT_GT(inside, 2000);
    EXPECT_LT(inside, 9000);
  }
}

TEST(ProbeFilter, ReproducesATrilinearField)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  const auto points = randomPoints({ 0., 4., 0., 4., 0., 4. }, 5000);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(points);
  probe->SetSourceConnection(source->GetOutputPort());
  probe->ComputeGradientsOn();
  probe->SetInterpolationMethodToGTI();
  probe->Update();
  vtkPointData* output = probe->GetOutput()->GetPointData();
  const double range = 64.;
  int inner = 0;
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i)
  {
    EXPECT_TRUE(isValid(probe->GetOutput(), i));
    const double* p = points->GetPoint(i);
    if (*std::min_element(p, p + 3) < 1. || *std::max_element(p, p + 3) > 3.)
    {
      continue; // a missing neighbour at the domain's edge may take part
    }
    ++inner;
    EXPECT_NEAR(output->GetArray("xyz")->GetTuple1(i), p[0] * p[1] * p[2], 1e-5 * range);
    const double* gradient = output->GetArray("xyz_gradient")->GetTuple3(i);
    EXPECT_NEAR(gradient[0], p[1] * p[2], 1e-5 * range);
    EXPECT_NEAR(gradient[1], p[0] * p[2], 1e-5 * range);
    EXPECT_NEAR(gradient[2], p[0] * p[1], 1e-5 * range);
  }
  EXPECT_GT(inner, 300);
}

TEST(ProbeFilter, MarksPointsOutside)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(2., 2., 2.);
  points->InsertNextPoint(0., 4., 4.); // a corner of the domain: cells are closed
  points->InsertNextPoint(-1e-3, 2., 2.);
  points->InsertNextPoint(2., 2., 4.01);
  points->InsertNextPoint(std::nan(""), 2., 2.);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(data);
  probe->SetSourceConnection(source->GetOutputPort());
  probe->SetValidPointMaskArrayName("inside");
  probe->ComputeGradientsOn();
  probe->Update();
  vtkPointData* output = probe->GetOutput()->GetPointData();
  auto* mask = vtkCharArray::SafeDownCast(output->GetArray("inside"));
  ASSERT_NE(mask, nullptr);
  const int expected[5] = { 1, 1, 0, 0, 0 };
  for (int i = 0; i < 5; ++i)
  {
    EXPECT_EQ(mask->GetValue(i), expected[i]) << i;
    if (!expected[i])
    {
      EXPECT_EQ(output->GetArray("xyz")->GetTuple1(i), 0.);
      EXPECT_EQ(output->GetArray("xyz_gradient")->GetTuple3(i)[2], 0.);
    }
  }
  EXPECT_NEAR(output->GetArray("xyz")->GetTuple1(0), 8., 1e-5);
}

TEST(ProbeFilter, ProbesImagesAndPassesArrays)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  vtkNew<vtkImageData> image;
  image->SetDimensions(5, 4, 3);
  image->SetOrigin(0.5, 0.5, 0.5);
  vtkNew<vtkIntArray> ids;
  ids->SetName("ids");
  ids->SetNumberOfValues(60);
  vtkNew<vtkIntArray> taken;
  taken->SetName("xyz");
  taken->SetNumberOfValues(60);
  vtkNew<vtkIntArray> cellIds;
  cellIds->SetName("cell ids");
  cellIds->SetNumberOfValues(24);
  image->GetPointData()->SetScalars(ids);
  image->GetPointData()->AddArray(taken);
  image->GetCellData()->AddArray(cellIds);
  vtkNew<vtkStringArray> note;
  note->SetName("note");
  image->GetFieldData()->AddArray(note);

  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(image);
  probe->SetSourceConnection(source->GetOutputPort());
  probe->Update();
  auto* output = vtkImageData::SafeDownCast(probe->GetOutput());
  ASSERT_NE(output, nullptr);
  EXPECT_EQ(output->GetNumberOfPoints(), 60);
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 2);
  EXPECT_EQ(output->GetCellData()->GetNumberOfArrays(), 0);
  EXPECT_TRUE(output->GetFieldData()->HasArray("note"));

  probe->PassPointArraysOn();
  probe->PassCellArraysOn();
  probe->PassFieldArraysOff();
  probe->Update();
  EXPECT_EQ(output->GetPointData()->GetArray("ids"), ids);
  EXPECT_EQ(output->GetPointData()->GetScalars(), ids);
  EXPECT_EQ(output->GetPointData()->GetArray("xyz")->GetDataType(), VTK_DOUBLE);
  EXPECT_TRUE(output->GetCellData()->HasArray("cell ids"));
  EXPECT_FALSE(output->GetFieldData()->HasArray("note"));
}

TEST(ProbeFilter, TakesNoPoints)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  vtkNew<vtkPolyData> none;
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(none);
  probe->SetSourceConnection(source->GetOutputPort());
  probe->Update();
  ASSERT_NE(probe->GetOutput()->GetPointData()->GetArray("xyz"), nullptr);
  EXPECT_EQ(probe->GetOutput()->GetPointData()->GetArray("xyz")->GetNumberOfTuples(), 0);
}

TEST(ProbeFilter, GivesNaNWhereOneArrayAloneHasNoValue)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  auto* scalar = vtkDoubleArray::SafeDownCast(grid->GetCellData()->GetArray("scalar"));
  vtkNew<vtkFloatArray> other;
  other->SetName("other");
  other->SetNumberOfValues(9);
  other->FillValue(3.f);
  grid->GetCellData()->AddArray(other);
  scalar->SetValue(1, std::nan("")); // the cell at the origin
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(0.25, 0.25, 0.25);
  points->InsertNextPoint(0.75, 0.25, 0.25);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(data);
  probe->SetSourceData(grid);
  probe->Update();
  vtkPointData* output = probe->GetOutput()->GetPointData();
  EXPECT_TRUE(isValid(probe->GetOutput(), 0));
  EXPECT_TRUE(std::isnan(output->GetArray("scalar")->GetTuple1(0)));
  EXPECT_EQ(output->GetArray("other")->GetTuple1(0), 3.);
  EXPECT_EQ(output->GetArray("scalar")->GetTuple1(1), 3.);
}

TEST(ProbeFilter, NearestCopiesWhatTheCellHas)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  vtkNew<vtkTypeInt64Array> ids;
  ids->SetName("ids");
  ids->SetNumberOfValues(9);
  vtkNew<vtkDoubleArray> large;
  large->SetName("large");
  large->SetNumberOfComponents(2);
  large->SetNumberOfTuples(9);
  for (vtkIdType i = 0; i < 9; ++i)
  {
    ids->SetValue(i, (vtkTypeInt64(1) << 62) + i);
    large->SetTuple2(i, 1e9 + 1e-3 * static_cast<double>(i), i == 4 ? std::nan("") : 1e-60);
  }
  vtkNew<vtkIntArray> tooShort;
  tooShort->SetName("short");
  tooShort->SetNumberOfValues(5);
  for (vtkDataArray* array : { static_cast<vtkDataArray*>(ids), static_cast<vtkDataArray*>(large),
         static_cast<vtkDataArray*>(tooShort) })
  {
    grid->GetCellData()->AddArray(array);
  }
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(0.75, 0.75, 0.25); // vertex 4
  points->InsertNextPoint(0.25, 0.25, 0.75); // vertex 5
  points->InsertNextPoint(0.25, 0.25, 1.75);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(data);
  probe->SetSourceData(grid);
  probe->SetInterpolationMethodToNearest();
  const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
  probe->Update();
  vtkPointData* output = probe->GetOutput()->GetPointData();
  auto* foundIds = vtkAOSDataArrayTemplate<vtkTypeInt64>::FastDownCast(output->GetArray("ids"));
  ASSERT_NE(foundIds, nullptr);
  EXPECT_EQ(foundIds->GetValue(0), ids->GetValue(4));
  EXPECT_EQ(foundIds->GetValue(1), ids->GetValue(5));
  EXPECT_EQ(foundIds->GetValue(2), 0);
  EXPECT_EQ(output->GetArray("large")->GetComponent(1, 0), 1e9 + 5e-3);
  EXPECT_EQ(output->GetArray("large")->GetComponent(1, 1), 1e-60);
  EXPECT_TRUE(std::isnan(output->GetArray("large")->GetComponent(0, 1)));
  EXPECT_TRUE(isValid(probe->GetOutput(), 0));
  EXPECT_FALSE(isValid(probe->GetOutput(), 2));
  EXPECT_FALSE(output->HasArray("short"));
  ASSERT_EQ(warnings.messages().size(), 1u);
  EXPECT_NE(warnings.messages()[0].find("'short' has 5 tuples"), std::string::npos) << warnings.messages()[0];

  // Of a cell at the depth limit the mean of what is below.
  grid->GetCellData()->RemoveArray("short");
  grid->SetDepthLimiter(0);
  probe->Modified();
  probe->Update();
  EXPECT_EQ(probe->GetOutput()->GetPointData()->GetArray("scalar")->GetTuple1(0), 5.5);
}

TEST(ProbeFilter, LeavesOutSingleArraysWithAWarning)
{
  const auto grid = makeGrid({ .notFinite = 1. });
  const auto points = randomPoints({ -1., 0., 0., 1., 1., 2. }, 10);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(points);
  probe->SetSourceData(grid);
  const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
  probe->Update();
  ASSERT_EQ(warnings.messages().size(), 1u);
  EXPECT_NE(warnings.messages()[0].find("finite value in array 'scalar'"), std::string::npos);
  EXPECT_FALSE(probe->GetOutput()->GetPointData()->HasArray("scalar"));
  EXPECT_TRUE(probe->GetOutput()->GetPointData()->HasArray("vector"));
}

TEST(ProbeFilter, SaysWhichInputIsTheGrid)
{
  const auto grid = makeUniformlyRefinedGrid(2);
  const auto points = randomPoints({ 0., 1., 0., 1., 0., 1. }, 3);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  const MessageCatcher errors(probe, vtkCommand::ErrorEvent);
  const MessageCatcher pipelineErrors(probe->GetExecutive(), vtkCommand::ErrorEvent);
  const std::string allowed = "; allowed are a vtkDataSet, which has the points, as Input and a "
                              "vtkHyperTreeGrid, which has the values, as Source";
  const auto expectError = [&](vtkDataObject* input, vtkDataObject* source, const std::string& message) {
    probe->SetInputDataObject(0, input);
    probe->SetInputDataObject(1, source);
    const std::size_t before = errors.messages().size();
    probe->Update();
    ASSERT_EQ(errors.messages().size(), before + 1);
    EXPECT_NE(errors.messages().back().find(message), std::string::npos) << errors.messages().back();
    EXPECT_EQ(probe->GetOutput()->GetNumberOfPoints(), 0);
  };
  expectError(grid, points,
    "probe: Input is a vtkHyperTreeGrid and Source a vtkPolyData" + allowed + ": exchange the two");
  expectError(grid, grid, "probe: Input is a vtkHyperTreeGrid and Source a vtkHyperTreeGrid" + allowed);
  expectError(points, points, "probe: Input is a vtkPolyData and Source a vtkPolyData" + allowed);
  vtkNew<vtkImageData> image;
  image->SetDimensions(2, 2, 2);
  probe->SetInputDataObject(0, image);
  probe->SetInputDataObject(1, grid);
  probe->Update();
  EXPECT_TRUE(probe->GetOutput()->IsA("vtkImageData"));
  EXPECT_NE(probe->GetOutput()->GetPointData()->GetArray("scalar"), nullptr);
}

// The pipeline probes its leaves one by one.
TEST(ProbeFilter, TakesCompositePoints)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, randomPoints({ 0., 1., 0., 1., 0., 1. }, 3));
  blocks->SetBlock(1, randomPoints({ 0., 1., 0., 1., 0., 1. }, 5));
  vtkNew<vtkTreeAMRProbeFilter> probe;
  vtkNew<vtkCompositeDataPipeline> pipeline;
  probe->SetExecutive(pipeline);
  probe->SetInputDataObject(0, blocks);
  probe->SetInputDataObject(1, makeUniformlyRefinedGrid(2));
  probe->Update();
  auto* output = vtkMultiBlockDataSet::SafeDownCast(probe->GetOutputDataObject(0));
  ASSERT_NE(output, nullptr);
  for (const unsigned int i : { 0u, 1u })
  {
    auto* block = vtkPolyData::SafeDownCast(output->GetBlock(i));
    ASSERT_NE(block, nullptr);
    EXPECT_EQ(block->GetPointData()->GetArray("scalar")->GetNumberOfTuples(), 3 + 2 * vtkIdType(i));
  }
}

TEST(ProbeFilter, ReportsGridsThatCannotBeProbed)
{
  const auto points = randomPoints({ 0., 1., 0., 1., 0., 1. }, 10);
  const auto expectError = [&](vtkHyperTreeGrid* grid, const std::string& part) {
    vtkNew<vtkTreeAMRProbeFilter> probe;
    probe->SetInputData(points);
    probe->SetSourceData(grid);
    const MessageCatcher errors(probe, vtkCommand::ErrorEvent);
    const MessageCatcher pipeline(probe->GetExecutive(), vtkCommand::ErrorEvent);
    probe->Update();
    ASSERT_EQ(errors.messages().size(), 1u) << part;
    EXPECT_NE(errors.messages()[0].find(part), std::string::npos) << errors.messages()[0];
    EXPECT_EQ(probe->GetOutput()->GetNumberOfPoints(), 0);
  };
  vtkNew<vtkHyperTreeGrid> empty;
  expectError(empty, "no numeric cell array");
  const auto interfaces = makeGrid({});
  interfaces->SetHasInterface(true);
  expectError(interfaces, "material interfaces");
  expectError(makeGrid({ .missingTrees = 1. }), "holds no tree");
}

TEST(ProbeFilter, OfASourceWithoutCellsNoPointIsValid)
{
  const auto grid = makeGrid({ .roots = { 2, 1, 1 } });
  vtkNew<vtkBitArray> mask;
  mask->SetNumberOfTuples(grid->GetNumberOfCells());
  mask->Fill(1.);
  grid->SetMask(mask);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  const MessageCatcher errors(probe, vtkCommand::ErrorEvent);
  const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
  probe->SetInputData(randomPoints({ 0., 2., 0., 1., 0., 1. }, 20));
  probe->SetSourceData(grid);
  for (int method = vtkTreeAMRProbeFilter::NEAREST; method <= vtkTreeAMRProbeFilter::GTI; ++method)
  {
    probe->SetInterpolationMethod(method);
    probe->Update();
    ASSERT_EQ(probe->GetOutput()->GetNumberOfPoints(), 20);
    for (vtkIdType point = 0; point < 20; ++point)
    {
      EXPECT_FALSE(isValid(probe->GetOutput(), point));
    }
  }
  EXPECT_TRUE(errors.messages().empty() && warnings.messages().empty());
}

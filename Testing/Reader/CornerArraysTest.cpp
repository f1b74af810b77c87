// Cell arrays of values at corners: their marks, and what becomes of them in the core and in the filters.
#include "CornerArrays.h"
#include "Field/CornerValues.h"
#include "Interpolation/Sampler.h"
#include "Support/HyperTreeGrids.h"
#include "vtkTreeAMRContourFilter.h"
#include "vtkTreeAMRProbeFilter.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridThreshold.h"
#include "vtkInformation.h"
#include "vtkInformationIntegerKey.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkVersionMacros.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Point = std::array<double, 3>;
using Function = std::function<double(const Point&)>;

/// Trilinear everywhere, so that no corner hangs in the air.
double trilinearFunction(const Point& p)
{
  return 3. + 2. * p[0] - p[1] + 0.5 * p[2] + p[0] * p[1] - 0.3 * p[1] * p[2] + 0.2 * p[0] * p[1] * p[2];
}

/// Adds "corners" with a function's values at the corners of the leaves that are not masked, and NaN elsewhere. mirrored:
/// mask of axes along which the grid's coordinates decrease.
vtkDataArray& addCorners(vtkHyperTreeGrid* grid, const Function& f, int mirrored = 0)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName("corners");
  markAsCorners(*array);
  array->SetNumberOfTuples(grid->GetCellData()->GetArray("scalar")->GetNumberOfTuples());
  array->Fill(std::numeric_limits<double>::quiet_NaN());
  const unsigned int limit = grid->GetDepthLimiter();
  grid->SetDepthLimiter(~0u);
  forEachLeaf(grid, [&](const double* bounds, vtkIdType index) {
    for (int c = 0; c < cornerCount; ++c)
    {
      Point p;
      for (int a = 0; a < 3; ++a)
      {
        const auto [low, high] = std::minmax(bounds[2 * a], bounds[2 * a + 1]);
        p[a] = (c ^ mirrored) >> a & 1 ? high : low;
      }
      array->SetComponent(index, c, f(p));
    }
  });
  grid->SetDepthLimiter(limit);
  grid->GetCellData()->AddArray(array);
  return *grid->GetCellData()->GetArray("corners");
}

/// Whether it masks its input's cells or copies those that are left.
void setJustMask(vtkHyperTreeGridThreshold& threshold, bool justMask)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  threshold.SetMemoryStrategy(
    justMask ? vtkHyperTreeGridThreshold::MaskInput : vtkHyperTreeGridThreshold::DeepThreshold);
#else
  threshold.SetJustCreateNewMask(justMask);
#endif
}

Point randomPointIn(const DrawnCell& cell, std::mt19937& random)
{
  std::uniform_real_distribution<double> uniform(0.01, 0.99);
  Point p;
  for (int a = 0; a < 3; ++a)
  {
    p[a] = std::lerp(cell.bounds[a], cell.bounds[a + 3], uniform(random));
  }
  return p;
}

} // namespace

TEST(CornerArrays, AreFieldsOfTheirValues)
{
  std::vector<RandomHyperTreeGrid> grids(7);
  grids[1].masked = 0.2;
  grids[1].missingTrees = 0.3;
  grids[2].mirrored = 5;
  grids[3].mirrored = 7;
  grids[3].explicitIndices = true;
  grids[4].transposedRoots = true;
  grids[4].uniform = true;
  grids[5].depthLimit = 2;
  grids[6].depthLimit = 1;
  grids[6].mirrored = 2;
  for (std::size_t i = 0; i < grids.size(); ++i)
  {
    SCOPED_TRACE(i);
    grids[i].seed = 100 + static_cast<std::uint32_t>(i);
    const auto grid = makeGrid(grids[i]);
    addCorners(grid, trilinearFunction, grids[i].mirrored);
    const auto field = acquireField(grid, { "corners", 3 });
    ASSERT_TRUE(field->corners());
    EXPECT_EQ(field, acquireField(grid, { "corners", -1 }));
    EXPECT_EQ(field->sharedOctree(), acquireField(grid, { "scalar", 0 })->sharedOctree());
    const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
    const double range = static_cast<double>(field->range().max) - field->range().min;
    std::mt19937 random(3);
    for (const DrawnCell& cell : drawnCells(*field))
    {
      const Point p = randomPointIn(cell, random);
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(p, sample));
      ASSERT_NEAR(sample.value, trilinearFunction(p), 1e-6 * range);
    }
  }
}

TEST(CornerArrays, KeepTheDigitsOfDoubles)
{
  const auto grid = makeGrid({});
  const auto f = [](const Point& p) { return 101325. + 1e-4 * trilinearFunction(p); };
  addCorners(grid, f);
  const auto field = acquireField(grid, { "corners" });
  ASSERT_TRUE(field->corners());
  EXPECT_NE(field->offset(), 0.);
  const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
  std::mt19937 random(3);
  for (const DrawnCell& cell : drawnCells(*field))
  {
    const Point p = randomPointIn(cell, random);
    FieldSample sample;
    ASSERT_TRUE(sampler->sample(p, sample));
    ASSERT_NEAR(sample.value, f(p), 1e-9);
  }
}

TEST(CornerArrays, LeaveOutCellsOfWhichACornerIsNotFinite)
{
  const auto grid = makeGrid({});
  vtkDataArray& array = addCorners(grid, trilinearFunction);
  const std::size_t cells = acquireField(grid, { "corners" })->leafValues().size();
  forEachLeaf(grid, [&](const double*, vtkIdType index) {
    if (index % 5 == 0)
    {
      array.SetComponent(index, static_cast<int>(index % 8), std::numeric_limits<double>::infinity());
    }
  });
  const auto field = acquireField(grid, { "corners" });
  EXPECT_LT(field->leafValues().size(), cells);
  EXPECT_TRUE(field->corners());
}

TEST(CornerArrays, AreToldByKeyOrNames)
{
  vtkNew<vtkDoubleArray> array;
  array->SetNumberOfComponents(8);
  EXPECT_FALSE(isAtCorners(*array));
  EXPECT_EQ(fieldComponents(*array), 8);
  array->GetInformation()->Set(cornerValuesKey(), 1);
  EXPECT_TRUE(isAtCorners(*array));
  EXPECT_EQ(fieldComponents(*array), 1);
  array->GetInformation()->Remove(cornerValuesKey());
  EXPECT_FALSE(isAtCorners(*array));
  markAsCorners(*array);
  array->GetInformation()->Remove(cornerValuesKey());
  EXPECT_TRUE(isAtCorners(*array));
  array->SetComponentName(7, "other");
  EXPECT_FALSE(isAtCorners(*array));
  vtkNew<vtkDoubleArray> scalar;
  scalar->GetInformation()->Set(cornerValuesKey(), 1);
  EXPECT_FALSE(isAtCorners(*scalar));
}

TEST(CornerArrays, StayMarkedInFilters)
{
  const auto grid = makeGrid({});
  addCorners(grid, trilinearFunction);
  const auto expectMarked = [](vtkHyperTreeGrid* other) {
    vtkDataArray* const array = other->GetCellData()->GetArray("corners");
    ASSERT_TRUE(array);
    EXPECT_TRUE(isAtCorners(*array));
    EXPECT_EQ(array->GetInformation()->Get(cornerValuesKey()), 1);
    EXPECT_STREQ(array->GetComponentName(6), "011");
  };
  vtkNew<vtkHyperTreeGrid> copy;
  copy->DeepCopy(grid);
  expectMarked(copy);

  vtkNew<vtkHyperTreeGridThreshold> threshold;
  threshold->SetInputData(grid);
  threshold->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
  threshold->ThresholdBetween(-0.5, 2.);
  for (const bool justMask : { true, false })
  {
    setJustMask(*threshold, justMask);
    threshold->Update();
    expectMarked(vtkHyperTreeGrid::SafeDownCast(threshold->GetOutputDataObject(0)));
  }
}

TEST(CornerArrays, AreProbedAsOneComponent)
{
  const auto grid = makeGrid({});
  addCorners(grid, trilinearFunction);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  std::array<double, 6> bounds;
  computeLocalBounds(grid, bounds.data());
  probe->SetInputData(randomPoints(bounds, 1000));
  probe->SetSourceData(grid);
  probe->SetComputeGradients(true);
  const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
  probe->Update();
  EXPECT_TRUE(warnings.messages().empty());
  vtkDataSet* const output = probe->GetOutput();
  vtkDataArray* const values = output->GetPointData()->GetArray("corners");
  vtkDataArray* const mask = output->GetPointData()->GetArray("vtkValidPointMask");
  ASSERT_EQ(values->GetNumberOfComponents(), 1);
  EXPECT_EQ(output->GetPointData()->GetArray("corners_gradient")->GetNumberOfComponents(), 3);
  int inside = 0;
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
  {
    if (mask->GetComponent(i, 0) != 0.)
    {
      ++inside;
      Point p;
      output->GetPoint(i, p.data());
      ASSERT_NEAR(values->GetComponent(i, 0), trilinearFunction(p), 1e-4);
      ASSERT_NEAR(output->GetPointData()->GetArray("corners_gradient")->GetComponent(i, 2),
        0.5 - 0.3 * p[1] + 0.2 * p[0] * p[1], 1e-3);
    }
  }
  EXPECT_GT(inside, 100);

  // The nearest value is the cell's mean.
  probe->SetInterpolationMethod(vtkTreeAMRProbeFilter::NEAREST);
  probe->Update();
  EXPECT_EQ(probe->GetOutput()->GetPointData()->GetArray("corners")->GetNumberOfComponents(), 1);
}

TEST(CornerArrays, AreContouredAsOneComponent)
{
  const auto grid = makeGrid({});
  vtkDataArray& corners = addCorners(grid, trilinearFunction);
  vtkNew<vtkDoubleArray> second;
  second->DeepCopy(&corners);
  second->SetName("second");
  for (vtkIdType i = 0; i < second->GetNumberOfValues(); ++i)
  {
    second->SetValue(i, 2. * second->GetValue(i));
  }
  grid->GetCellData()->AddArray(second);
  vtkNew<vtkTreeAMRContourFilter> contour;
  contour->SetInputData(grid);
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "corners");
  contour->SetValue(0, 4.);
  contour->Update();
  vtkPolyData* const output = contour->GetOutput();
  ASSERT_GT(output->GetNumberOfPoints(), 10);
  vtkDataArray* const values = output->GetPointData()->GetArray("second");
  ASSERT_EQ(values->GetNumberOfComponents(), 1);
  for (vtkIdType i = 0; i < output->GetNumberOfPoints(); ++i)
  {
    Point p;
    output->GetPoint(i, p.data());
    EXPECT_NEAR(trilinearFunction(p), 4., 1e-3); // centres of loops are near it
    EXPECT_NEAR(values->GetComponent(i, 0), 2. * trilinearFunction(p), 1e-4);
  }
}

TEST(CornerArrays, ThatDisagreeAreMeansWithAMessage)
{
  const auto grid = makeGrid({});
  vtkDataArray& array = addCorners(grid, trilinearFunction);
  vtkIdType first = -1;
  forEachLeaf(grid, [&](const double*, vtkIdType index) { first = first < 0 ? index : first; });
  for (int c = 0; c < cornerCount; ++c)
  {
    array.SetComponent(first, c, array.GetComponent(first, c) + 0.5);
  }
  const auto field = acquireField(grid, { "corners" });
  EXPECT_FALSE(field->corners());
  EXPECT_NEAR(field->cornerJump(), 0.5, 1e-5);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(randomPoints({ 0., 1., 0., 1., 0., 1. }, 10));
  probe->SetSourceData(grid);
  const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
  probe->Update();
  ASSERT_EQ(warnings.messages().size(), 1u);
  EXPECT_NE(warnings.messages()[0].find("'corners' at corners that cells share differ by up to 0.5"),
    std::string::npos)
    << warnings.messages()[0];
  probe->Modified();
  probe->Update();
  EXPECT_EQ(warnings.messages().size(), 1u); // once
}

TEST(CornerArrays, ThatHangElsewhereAreNamed)
{
  const auto grid = makeGrid({});
  vtkDataArray& array =
    addCorners(grid, [](const Point& p) { return std::sin(5. * p[0]) * std::cos(4. * p[1] + p[2]); });
  const auto field = acquireField(grid, { "corners" });
  ASSERT_TRUE(field->corners());
  const Remark remark = unevenCorners(array, *field);
  EXPECT_NE(remark.text.find("at corners that hang on larger cells differ by up to"), std::string::npos);
}

TEST(CornerArrays, AreNamedTogether)
{
  const auto grid = makeGrid({});
  vtkDataArray& corners =
    addCorners(grid, [](const Point& p) { return std::sin(5. * p[0]) * std::cos(4. * p[1] + p[2]); });
  vtkNew<vtkDoubleArray> second;
  second->DeepCopy(&corners);
  second->SetName("second");
  grid->GetCellData()->AddArray(second);
  vtkNew<vtkTreeAMRProbeFilter> probe;
  probe->SetInputData(randomPoints({ 0., 1., 0., 1., 0., 1. }, 10));
  probe->SetSourceData(grid);
  vtkNew<vtkTreeAMRContourFilter> contour;
  contour->SetInputData(grid);
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "corners");
  contour->SetValue(0, 0.1);
  for (vtkAlgorithm* const filter :
    { static_cast<vtkAlgorithm*>(probe), static_cast<vtkAlgorithm*>(contour) })
  {
    const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
    filter->Update();
    ASSERT_EQ(warnings.messages().size(), 1u);
    EXPECT_NE(warnings.messages()[0].find("'corners', 'second' at corners that hang"), std::string::npos)
      << warnings.messages()[0];
  }
  // The means of the cells have none.
  vtkNew<vtkTreeAMRProbeFilter> nearest;
  nearest->SetInputData(randomPoints({ 0., 1., 0., 1., 0., 1. }, 10));
  nearest->SetSourceData(grid);
  nearest->SetInterpolationMethodToNearest();
  const MessageCatcher warnings(nearest, vtkCommand::WarningEvent);
  nearest->Update();
  EXPECT_TRUE(warnings.messages().empty());
}

TEST(CornerArrays, HaveOneRangeWhicheverComponentIsChosen)
{
  const auto grid = makeGrid({});
  vtkDataArray& array = addCorners(grid, trilinearFunction);
  std::array<double, 2> expected{ 1e300, -1e300 };
  for (vtkIdType i = 0; i < array.GetNumberOfTuples(); ++i)
  {
    for (int c = 0; c < cornerCount; ++c)
    {
      const double value = array.GetComponent(i, c);
      expected = { std::fmin(expected[0], value), std::fmax(expected[1], value) };
    }
  }
  setCornerRanges(*grid);
  vtkCellData* const cells = grid->GetCellData();
  vtkDataArray* const ranged = cells->GetArray("corners");
  EXPECT_EQ(ranged->GetInformation()->Get(cornerValuesKey()), 1);
  for (int c = -1; c < cornerCount; ++c)
  {
    std::array<double, 2> range;
    ranged->GetRange(range.data(), c);
    EXPECT_EQ(range, expected) << c;
    ranged->GetFiniteRange(range.data(), c);
    EXPECT_EQ(range, expected) << c;
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0) // as ParaView 5.13 asks
    EXPECT_TRUE(cells->GetRange("corners", range.data(), c));
    EXPECT_EQ(range, expected) << c;
    EXPECT_TRUE(cells->GetFiniteRange("corners", range.data(), c));
    EXPECT_EQ(range, expected) << c;
#endif
  }
}

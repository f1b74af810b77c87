// The contour filter against the core's contour, and what it adds: several values, arrays, messages.
#include "vtkTreeAMRContourFilter.h"

#include "HyperTreeGridConverter.h"
#include "vtkTreeAMRExampleSource.h"

#include "Contour/Contour.h"
#include "Interpolation/Sampler.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCallbackCommand.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIdList.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace treeamr;
using namespace treeamr::test;

TEST(ContourFilter, GivesTheCoresSurfacesOneAfterTheOther)
{
  const auto grid = makeGrid({ .roots = { 2, 2, 2 }, .missingTrees = 0.2, .masked = 0.1, .ghosts = 0.05 });
  const auto field = acquireField(grid, { "scalar", 0 });
  vtkNew<vtkTreeAMRContourFilter> filter;
  filter->SetInputData(grid);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
  filter->SetNumberOfContours(2);
  filter->SetValue(0, 0.1);
  filter->SetValue(1, -0.2);
  filter->ComputeGradientsOn();
  filter->Update();
  vtkPolyData* output = filter->GetOutput();
  vtkDataArray* scalars = output->GetPointData()->GetScalars();
  vtkDataArray* normals = output->GetPointData()->GetNormals();
  vtkDataArray* gradients = output->GetPointData()->GetVectors();
  ASSERT_TRUE(scalars && normals && gradients);
  EXPECT_STREQ(scalars->GetName(), "scalar");
  EXPECT_STREQ(normals->GetName(), "Normals");
  EXPECT_STREQ(gradients->GetName(), "Gradients");
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 5); // "vector" and "count", too
  vtkIdType point = 0;
  vtkIdType triangle = 0;
  for (const double value : { 0.1, -0.2 })
  {
    const ContourMesh mesh = contour(*field, value, { .gradients = true });
    ASSERT_GT(mesh.triangles.size(), 500u);
    vtkNew<vtkIdList> corners;
    for (const auto& t : mesh.triangles)
    {
      output->GetPolys()->GetCellAtId(triangle++, corners);
      ASSERT_EQ(corners->GetNumberOfIds(), 3);
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_EQ(corners->GetId(c), point + t[c]);
      }
    }
    for (std::size_t i = 0; i < mesh.points.size(); ++i, ++point)
    {
      std::array<double, 3> p;
      output->GetPoint(point, p.data());
      ASSERT_EQ(p, mesh.points[i]);
      ASSERT_EQ(scalars->GetTuple1(point), value);
      const auto& g = mesh.gradients[i];
      const double length = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_EQ(gradients->GetComponent(point, a), g[a]);
        ASSERT_NEAR(normals->GetComponent(point, a), length > 0. ? -g[a] / length : 0., 1e-6);
      }
    }
  }
  EXPECT_EQ(point, output->GetNumberOfPoints());
  EXPECT_EQ(triangle, output->GetNumberOfPolys());
}

TEST(ContourFilter, NormalsHaveLengthOneForValuesAndCellsOfAnySize)
{
  const auto normalsOf = [](int value, const std::array<int, 3>& width, double offset) {
    const auto grid = makeGrid({ .roots = { 2, 2, 2 } });
    vtkDataArray* unscaled = grid->GetCellData()->GetArray("scalar");
    vtkNew<vtkFloatArray> scalar;
    scalar->SetName("scalar");
    for (vtkIdType i = 0; i < unscaled->GetNumberOfTuples(); ++i)
    {
      scalar->InsertNextValue(static_cast<float>(std::ldexp(unscaled->GetTuple1(i) + offset, value)));
    }
    grid->GetCellData()->AddArray(scalar);
    const std::array<vtkDataArray*, 3> planes{ grid->GetXCoordinates(), grid->GetYCoordinates(),
      grid->GetZCoordinates() };
    for (int a = 0; a < 3; ++a)
    {
      for (vtkIdType i = 0; i < planes[a]->GetNumberOfTuples(); ++i)
      {
        planes[a]->SetTuple1(i, std::ldexp(planes[a]->GetTuple1(i), width[a]));
      }
    }
    vtkNew<vtkTreeAMRContourFilter> filter;
    filter->SetInputData(grid);
    filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
    filter->SetValue(0, std::ldexp(0.1 + offset, value));
    filter->Update();
    vtkSmartPointer<vtkDataArray> normals = filter->GetOutput()->GetPointData()->GetNormals();
    EXPECT_GT(normals->GetNumberOfTuples(), 1000);
    int wrong = 0;
    for (vtkIdType i = 0; i < normals->GetNumberOfTuples(); ++i)
    {
      wrong += !(std::abs(vtkMath::Norm(normals->GetTuple3(i)) - 1.) < 1e-6);
    }
    EXPECT_EQ(wrong, 0) << "values times 2^" << value << ", widths times 2^" << width[0];
    return normals;
  };
  const auto expected = normalsOf(0, {}, 0.);
  const auto expectSame = [&](int value, const std::array<int, 3>& width) {
    const auto found = normalsOf(value, width, 0.);
    ASSERT_EQ(found->GetNumberOfTuples(), expected->GetNumberOfTuples());
    for (vtkIdType i = 0; i < found->GetNumberOfTuples(); ++i)
    {
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_EQ(found->GetComponent(i, a), expected->GetComponent(i, a))
          << "values times 2^" << value << ", widths times 2^" << width[0];
      }
    }
  };
  // To the bit: powers of two change no digit of normal floats.
  for (const auto& [value, width] : { std::pair(-110, 0), { -110, 130 }, { -80, 0 }, { -80, 67 }, { 0, -130 },
         { 0, 130 }, { 67, 0 }, { 100, -67 }, { 127, 0 }, { 127, -130 } })
  {
    expectSame(value, { width, width, width });
  }
  normalsOf(-145, {}, 0.); // a few denormals: steps
  normalsOf(-60, { -60, 0, 60 }, 0.);
  normalsOf(-110, { 40, 40, 40 }, 1e4);
  normalsOf(100, { 40, 40, 40 }, 1e4);
}

TEST(ContourFilter, InterpolatesTheOtherArrays)
{
  const auto grid = makeGrid({ .roots = { 2, 2, 2 }, .missingTrees = 0.2, .masked = 0.1 });
  vtkNew<vtkTreeAMRContourFilter> filter;
  filter->SetInputData(grid);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
  filter->SetValue(0, 0.);
  filter->Update();
  vtkPolyData* output = filter->GetOutput();
  EXPECT_FALSE(output->GetPointData()->HasArray("Gradients"));
  ASSERT_GT(output->GetNumberOfPoints(), 500);
  for (const std::string name : { "vector", "count" })
  {
    vtkDataArray* values = output->GetPointData()->GetArray(name.c_str());
    ASSERT_NE(values, nullptr);
    EXPECT_EQ(values->GetDataType(), name == "vector" ? VTK_FLOAT : VTK_DOUBLE);
    ASSERT_EQ(values->GetNumberOfComponents(), name == "vector" ? 3 : 1);
    const double tolerance = name == "vector" ? 1e-6 : 1e-3; // of values up to 1 and 999
    for (int c = 0; c < values->GetNumberOfComponents(); ++c)
    {
      const auto sampler = Sampler::create(InterpolationMethod::GTI, acquireField(grid, { name, c }));
      for (vtkIdType i = 0; i < output->GetNumberOfPoints(); ++i)
      {
        std::array<double, 3> p;
        output->GetPoint(i, p.data());
        FieldSample expected;
        ASSERT_TRUE(sampler->sample(p, expected));
        ASSERT_NEAR(values->GetComponent(i, c), expected.value, tolerance);
      }
    }
  }
}

TEST(ContourFilter, GivesNaNWhereAnotherArrayHasNoValue)
{
  const auto grid = makeUniformlyRefinedGrid(2); // "scalar" counts the cells
  vtkNew<vtkDoubleArray> other;
  other->SetName("other");
  const vtkIdType cells = grid->GetCellData()->GetArray("scalar")->GetNumberOfTuples();
  for (vtkIdType i = 0; i < cells; ++i)
  {
    other->InsertNextValue(i < cells / 2 ? std::nan("") : 2.);
  }
  grid->GetCellData()->AddArray(other);
  vtkNew<vtkTreeAMRContourFilter> filter;
  filter->SetInputData(grid);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
  filter->SetValue(0, 0.5 * static_cast<double>(cells));
  filter->Update();
  auto* values = vtkDoubleArray::SafeDownCast(filter->GetOutput()->GetPointData()->GetArray("other"));
  ASSERT_NE(values, nullptr);
  int missing = 0;
  for (vtkIdType i = 0; i < values->GetNumberOfValues(); ++i)
  {
    missing += std::isnan(values->GetValue(i));
    EXPECT_TRUE(std::isnan(values->GetValue(i)) || values->GetValue(i) == 2.);
  }
  EXPECT_GT(missing, 0);
  EXPECT_LT(missing, values->GetNumberOfValues());
}

TEST(ContourFilter, TakesTheActiveScalarsAndAddsNothingUnasked)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  vtkNew<vtkTreeAMRContourFilter> filter;
  filter->SetInputConnection(source->GetOutputPort());
  filter->GenerateValues(3, 10., 20.);
  filter->ComputeNormalsOff();
  filter->ComputeScalarsOff();
  filter->Update();
  EXPECT_EQ(filter->GetNumberOfContours(), 3);
  EXPECT_EQ(filter->GetValue(1), 15.);
  EXPECT_GT(filter->GetOutput()->GetNumberOfPolys(), 0);
  EXPECT_EQ(filter->GetOutput()->GetPointData()->GetNumberOfArrays(), 0);
  const vtkIdType before = filter->GetOutput()->GetNumberOfPolys();
  filter->SetNumberOfContours(1);
  filter->Update();
  EXPECT_LT(filter->GetOutput()->GetNumberOfPolys(), before);
  filter->SetNumberOfContours(0);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPolys(), 0);
  filter->SetValue(0, 1e9);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
}

TEST(ContourFilter, IsSilentWithoutTreesOrCells)
{
  const auto masked = makeGrid({});
  addRandomMask(masked, 1., 1);
  for (const auto& grid : { makeGrid({ .missingTrees = 1. }), masked })
  {
    vtkNew<vtkTreeAMRContourFilter> filter;
    filter->SetInputData(grid);
    filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "scalar");
    const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
    filter->Update();
    EXPECT_TRUE(errors.messages().empty());
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
}

TEST(ContourFilter, ReportsProgressAndAborts)
{
  vtkNew<vtkTreeAMRExampleSource> source;
  source->SetDatasetToSynthetic();
  vtkNew<vtkTreeAMRContourFilter> filter;
  filter->SetInputConnection(source->GetOutputPort());
  filter->SetValue(0, 8.);
  double last = 0.;
  vtkNew<vtkCallbackCommand> watch;
  watch->SetClientData(&last);
  watch->SetCallback([](vtkObject*, unsigned long, void* data, void* progress) {
    EXPECT_GE(*static_cast<double*>(progress), *static_cast<double*>(data));
    *static_cast<double*>(data) = *static_cast<double*>(progress);
  });
  const unsigned long watching = filter->AddObserver(vtkCommand::ProgressEvent, watch);
  filter->Update();
  EXPECT_EQ(last, 1.);
  EXPECT_GT(filter->GetOutput()->GetNumberOfPolys(), 0);
  filter->RemoveObserver(watching);
  vtkNew<vtkCallbackCommand> stop;
  stop->SetCallback([](vtkObject* caller, unsigned long, void*, void*) {
    static_cast<vtkTreeAMRContourFilter*>(caller)->SetAbortExecute(1);
  });
  filter->AddObserver(vtkCommand::ProgressEvent, stop);
  filter->SetValue(0, 9.);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPolys(), 0);
}

TEST(ContourFilter, ReportsWhatItCannotUse)
{
  const auto expectError = [](vtkHyperTreeGrid* grid, const char* array, double value,
                             const std::string& part) {
    vtkNew<vtkTreeAMRContourFilter> filter;
    filter->SetInputData(grid);
    if (array)
    {
      filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, array);
    }
    filter->SetValue(0, value);
    const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
    const MessageCatcher pipeline(filter->GetExecutive(), vtkCommand::ErrorEvent);
    filter->Update();
    ASSERT_EQ(errors.messages().size(), 1u) << part;
    EXPECT_NE(errors.messages()[0].find(part), std::string::npos) << errors.messages()[0];
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  };
  const auto grid = makeGrid({});
  expectError(grid, "scalar", std::nan(""), "isovalue nan");
  expectError(grid, "scalar", std::numeric_limits<double>::infinity(), "isovalue inf");
  expectError(grid, "nothing", 0., "'nothing' does not exist; there are: 'scalar', 'vector', 'count'");
  expectError(grid, nullptr, 0., "no active cell scalars");
  vtkNew<vtkStringArray> text;
  text->SetName("text");
  grid->GetCellData()->AddArray(text);
  expectError(grid, "text", 0., "'text' is a vtkStringArray, allowed are arrays of numbers");
  grid->SetHasInterface(true);
  expectError(grid, "scalar", 0., "material interfaces");
}

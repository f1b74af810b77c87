// What exporters write of an isosurface, and that nobody else has it contoured.
#include "PlaneSurface.h"

#include "vtkActorCollection.h"
#include "vtkAlgorithm.h"
#include "vtkCellData.h"
#include "vtkCellPicker.h"
#include "vtkCommand.h"
#include "vtkCullerCollection.h"
#include "vtkDoubleArray.h"
#include "vtkHardwareSelector.h"
#include "vtkLookupTable.h"
#include "vtkMapper.h"
#include "vtkOBJExporter.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkPropPicker.h"
#include "vtkSelection.h"
#include "vtkSphereSource.h"
#include "vtkTreeAMRContourFilter.h"
#include "vtkTreeAMRIsosurfaceActor.h"
#include "vtkUnsignedCharArray.h"

#include <cmath>
#include <fstream>
#include <sstream>

using namespace treeamr::test;

namespace
{

class ExportTest : public PlaneSurfaceTest
{
protected:
  ExportTest()
  {
    mapper->SetInputData(grid);
    mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "plane");
    mapper->SetNumberOfContours(2);
    mapper->SetValue(0, -0.1);
    mapper->SetValue(1, 0.2);
    mapper->ScalarVisibilityOff();
    actor->SetMapper(mapper);
    actor->SetPosition(0.5, 0., -0.25);
    actor->SetScale(1., 2., 1.);
    scene.renderer->AddActor(actor);
    scene.setCamera();
  }
  vtkActor* exported() { return scene.renderer->GetActors()->GetLastActor(); }
  vtkPolyData* triangles()
  {
    vtkMapper* polygons = exported()->GetMapper();
    polygons->Update();
    return vtkPolyData::SafeDownCast(polygons->GetInputDataObject(0, 0));
  }
  vtkPolyData* contour()
  {
    filter->SetInputDataObject(grid);
    filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "plane");
    filter->SetNumberOfContours(2);
    filter->SetValue(0, -0.1);
    filter->SetValue(1, 0.2);
    filter->Update();
    return filter->GetOutput();
  }
  void colorBy(const char* array, vtkScalarsToColors* table)
  {
    mapper->ScalarVisibilityOn();
    mapper->SetScalarModeToUseCellFieldData();
    mapper->SelectColorArray(array);
    mapper->SetLookupTable(table);
    mapper->UseLookupTableScalarRangeOn();
  }
  /// The colour of each point against that of a value of the table.
  template <class ValueAt>
  void expectColors(vtkScalarsToColors* table, const ValueAt& valueAt, double tolerance)
  {
    vtkPolyData* polygons = triangles();
    auto colors = vtkUnsignedCharArray::SafeDownCast(polygons->GetPointData()->GetScalars());
    ASSERT_TRUE(colors);
    ASSERT_EQ(4, colors->GetNumberOfComponents());
    for (vtkIdType i = 0; i < polygons->GetNumberOfPoints(); ++i)
    {
      Point p;
      polygons->GetPoint(i, p.data());
      if (!isInside(p))
      {
        continue;
      }
      const unsigned char* const expected = table->MapValue(valueAt(p));
      for (int c = 0; c < 4; ++c)
      {
        ASSERT_NEAR(colors->GetTypedComponent(i, c), expected[c], tolerance) << "of point " << i;
      }
    }
  }

  vtkSmartPointer<vtkHyperTreeGrid> grid = planeGrid();
  Scene scene;
  vtkNew<vtkTreeAMRIsosurfaceMapper> mapper;
  vtkNew<vtkTreeAMRIsosurfaceActor> actor;
  vtkNew<vtkTreeAMRContourFilter> filter;
};

TEST_F(ExportTest, WritesTheContoursTriangles)
{
  vtkPolyData* expected = contour();
  const std::string name = TREEAMR_TEST_OUTPUT_DIR "/ExportTest";
  vtkNew<vtkOBJExporter> exporter;
  exporter->SetRenderWindow(scene.window);
  exporter->SetFilePrefix(name.c_str());
  actor->GetProperty()->SetOpacity(0.25);
  scene.render();
  exporter->Write();
  std::ifstream file(name + ".obj");
  vtkIdType points = 0;
  vtkIdType faces = 0;
  for (std::string line; std::getline(file, line);)
  {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "v")
    {
      ASSERT_LT(points, expected->GetNumberOfPoints());
      Point p;
      Point q;
      words >> p[0] >> p[1] >> p[2];
      expected->GetPoint(points++, q.data());
      const Point offset{ 0.5, 0., -0.25 };
      for (int a = 0; a < 3; ++a)
      {
        ASSERT_NEAR(p[a], (a == 1 ? 2. : 1.) * q[a] + offset[a], 1e-6);
      }
    }
    faces += key == "f";
  }
  EXPECT_EQ(expected->GetNumberOfPoints(), points);
  EXPECT_EQ(expected->GetNumberOfPolys(), faces);
  EXPECT_GT(faces, 100);
  std::stringstream material;
  material << std::ifstream(name + ".mtl").rdbuf();
  EXPECT_NE(std::string::npos, material.str().find("Tr 0.25"));
}

TEST_F(ExportTest, HasTheColorsThatAreShown)
{
  vtkNew<vtkLookupTable> table;
  table->SetTableRange(-1., 1.);
  table->SetAlphaRange(0.2, 0.9);
  table->Build();
  EXPECT_TRUE(triangles()->GetPointData()->GetArray("plane"));
  EXPECT_FALSE(triangles()->GetPointData()->GetScalars()); // which would hide the solid colour
  colorBy("x", table);
  expectColors(
    table, [](const Point& p) { return p[0]; }, 3.);
  colorBy("plane", table);
  expectColors(
    table,
    [](const Point& p) {
      double f = 0.;
      for (int a = 0; a < 3; ++a)
      {
        f += (p[a] - center[a]) * normal[a];
      }
      return f < 0.05 ? -0.1 : 0.2;
    },
    0.);
}

TEST_F(ExportTest, ComponentsAreThoseOfTheMapper)
{
  vtkNew<vtkDoubleArray> vectors;
  vtkDataArray* plane = grid->GetCellData()->GetArray("plane");
  vectors->SetName("vectors");
  vectors->SetNumberOfComponents(3);
  vectors->SetNumberOfTuples(plane->GetNumberOfTuples());
  for (vtkIdType i = 0; i < plane->GetNumberOfTuples(); ++i)
  {
    vectors->SetTuple3(i, 9., plane->GetTuple1(i), 9.);
  }
  grid->GetCellData()->AddArray(vectors);
  const vtkIdType expected = contour()->GetNumberOfPolys();
  mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "vectors");
  mapper->SetIsosurfaceComponent(1);
  EXPECT_EQ(expected, triangles()->GetNumberOfPolys());
}

TEST_F(ExportTest, OnlyExportersContour)
{
  int contours = 0;
  struct Counter : vtkCommand
  {
    int* count = nullptr;
    void Execute(vtkObject*, unsigned long, void*) override { ++*this->count; }
  };
  vtkNew<vtkLookupTable> table;
  colorBy("x", table);
  scene.render();
  vtkSmartPointer<Counter> counter = vtkSmartPointer<Counter>::Take(new Counter);
  counter->count = &contours;
  exported()->GetMapper()->GetInputAlgorithm()->AddObserver(vtkCommand::StartEvent, counter);

  const auto drawn = scene.render();
  const double* const bounds = actor->GetBounds();
  EXPECT_NEAR(2., bounds[3], 1e-6);
  scene.renderer->ResetCameraClippingRange();
  vtkNew<vtkPropPicker> picker;
  ASSERT_TRUE(picker->Pick(0.5 * scene.width(), 0.5 * scene.height(), 0., scene.renderer));
  EXPECT_EQ(actor.Get(), picker->GetActor());
  vtkNew<vtkCellPicker> cells;
  cells->Pick(0.5 * scene.width(), 0.5 * scene.height(), 0., scene.renderer);
  vtkNew<vtkHardwareSelector> selector;
  selector->SetRenderer(scene.renderer);
  selector->SetArea(
    0, 0, static_cast<unsigned>(scene.width()) - 1, static_cast<unsigned>(scene.height()) - 1);
  selector->SetFieldAssociation(vtkDataObject::FIELD_ASSOCIATION_CELLS);
  const auto selection = vtkSmartPointer<vtkSelection>::Take(selector->Select());
  EXPECT_GT(selection->GetNumberOfNodes(), 0u);
  scene.renderer->GetActors();
  EXPECT_EQ(0, contours);

  EXPECT_GT(triangles()->GetNumberOfPolys(), 100);
  const int once = contours;
  EXPECT_GE(once, 1);
  EXPECT_GT(triangles()->GetNumberOfPolys(), 100);
  EXPECT_EQ(once, contours);
  vtkPolyData* kept = triangles();
  EXPECT_EQ(drawn, scene.render());
  EXPECT_EQ(0, kept->GetNumberOfPolys()); // freed by the next picture
  EXPECT_EQ(once, contours);
  EXPECT_GT(triangles()->GetNumberOfPolys(), 100);

  actor->VisibilityOff();
  EXPECT_FALSE(exported()->GetVisibility());
}

TEST_F(ExportTest, OthersTrianglesTakeThePlaceOfItsOwn)
{
  vtkNew<vtkSphereSource> others;
  others->Update();
  const vtkIdType count = others->GetOutput()->GetNumberOfPolys();
  const auto drawn = scene.render();
  actor->SetExportedTriangles(others);
  EXPECT_EQ(count, triangles()->GetNumberOfPolys());
  EXPECT_EQ(contour()->GetNumberOfPolys(), actor->GetTriangles()->GetNumberOfPolys());
  EXPECT_EQ(drawn, scene.render());
  EXPECT_EQ(0, others->GetOutput()->GetNumberOfPolys()); // freed by the next picture
  EXPECT_EQ(count, triangles()->GetNumberOfPolys());

  // Of a process without trees, which has no picture and nothing to complain of.
  GridOptions none;
  none.trees = false;
  mapper->SetInputData(makeGrid(none, {}));
  EXPECT_FALSE(actor->GetTriangles());
  scene.renderer->GetCullers()->RemoveAllItems();
  EXPECT_NE(drawn, scene.render());
  EXPECT_EQ(count, triangles()->GetNumberOfPolys());
  mapper->SetInputData(grid);
  actor->SetExportedTriangles(nullptr);
  EXPECT_EQ(contour()->GetNumberOfPolys(), triangles()->GetNumberOfPolys());
}

TEST_F(ExportTest, WithoutInputThereIsNothing)
{
  vtkNew<vtkTreeAMRIsosurfaceMapper> none;
  actor->SetMapper(none);
  EXPECT_EQ(0, triangles()->GetNumberOfPolys());
  actor->SetMapper(nullptr);
  EXPECT_EQ(actor.Get(), exported());
}

} // namespace

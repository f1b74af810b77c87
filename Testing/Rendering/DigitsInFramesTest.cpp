// Frames of values that lie close together beside their size, against those of the same values less that size, with
// colours, opacities and isovalues moved along.
#include "PlaneSurface.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkContourValues.h"
#include "vtkDoubleArray.h"
#include "vtkLookupTable.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkTreeAMRIsosurfaceActor.h"
#include "vtkTypeInt64Array.h"

#include <cmath>

using namespace treeamr::test;

namespace
{

/// An array's values: constant + scale * those of the plain one.
struct Shift
{
  double constant;
  double scale;
  double operator()(double plain) const { return constant + scale * plain; }
};
constexpr Shift plain{ 0., 1. };
const Shift shifts[]{ { 101325., 0.001 }, { 0x1p52, 0x1p22 } };

using Frame = std::vector<std::array<float, 4>>; // a picture's pixels

class DigitsInFramesTest : public PlaneSurfaceTest
{
protected:
  /// "plane" and "x", and "large plane" and "large x": of whole numbers where the shift has such.
  static vtkSmartPointer<vtkHyperTreeGrid> gridWith(const Shift& shift)
  {
    auto grid = planeGrid();
    for (const std::string name : { "plane", "x" })
    {
      vtkDataArray* from = grid->GetCellData()->GetArray(name.c_str());
      vtkSmartPointer<vtkDataArray> to = vtkSmartPointer<vtkDoubleArray>::New();
      if (shift.constant == 0x1p52)
      {
        to = vtkSmartPointer<vtkTypeInt64Array>::New();
      }
      to->SetName(("large " + name).c_str());
      to->SetNumberOfTuples(from->GetNumberOfTuples());
      for (vtkIdType i = 0; i < from->GetNumberOfTuples(); ++i)
      {
        // What the array holds of it, for both.
        to->SetTuple1(i, shift(from->GetTuple1(i)));
        from->SetTuple1(i, (to->GetTuple1(i) - shift.constant) / shift.scale);
      }
      grid->GetCellData()->AddArray(to);
    }
    return grid;
  }

  static void expectSame(const Frame& frame, const Frame& expected, double tolerance, const char* what)
  {
    ASSERT_EQ(frame.size(), expected.size());
    int seen = 0;
    for (std::size_t i = 0; i < frame.size(); ++i)
    {
      seen += std::abs(expected[i][0] - expected[0][0]) > 0.05f;
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(frame[i][c], expected[i][c], tolerance) << what << ", pixel " << i;
      }
    }
    EXPECT_GT(seen, 60) << what;
  }
};

Frame volumeFrame(vtkHyperTreeGrid* grid, const char* array, const Shift& shift, bool surfaces)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = scene.addVolume(grid, array, {}, 0.);
  vtkVolumeProperty* property = volume->GetProperty();
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(shift(-0.9), 0.1, 0.2, 0.9);
  colors->AddRGBPoint(shift(0.1), 0.9, 0.9, 0.8, 0.3, 0.2);
  colors->AddRGBPoint(shift(1.1), 0.8, 0.1, 0.1);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(shift(-1.), 0.);
  opacity->AddPoint(shift(0.), 0.2);
  opacity->AddPoint(shift(1.), 0.9);
  property->SetColor(colors);
  property->SetScalarOpacity(opacity);
  if (surfaces)
  {
    property->GetIsoSurfaceValues()->SetValue(0, shift(-0.3));
    property->GetIsoSurfaceValues()->SetValue(1, shift(0.2));
    Scene::mapperOf(volume)->ShowIsosurfacesOn();
  }
  scene.setCamera();
  const MessageCounter messages(Scene::mapperOf(volume));
  Frame frame = scene.render();
  EXPECT_TRUE(messages.warnings.empty()) << messages.warnings[0];
  return frame;
}

} // namespace

TEST_F(DigitsInFramesTest, volumesAndTheirIsosurfaces)
{
  for (const Shift& shift : shifts)
  {
    const auto grid = gridWith(shift);
    for (const bool surfaces : { false, true })
    {
      expectSame(volumeFrame(grid, "large plane", shift, surfaces),
        volumeFrame(grid, "plane", plain, surfaces), 2e-3,
        (std::to_string(shift.constant) + (surfaces ? " with surfaces" : "")).c_str());
    }
  }
}

TEST_F(DigitsInFramesTest, isosurfacesByAnotherArrayAndTheirTriangles)
{
  for (const Shift& shift : shifts)
  {
    const auto grid = gridWith(shift);
    vtkSmartPointer<vtkPolyData> triangles[2];
    const auto surfaceFrame = [&](bool large, const char* colorArray) {
      const Shift& own = large ? shift : plain;
      Scene scene;
      scene.useFloatTarget();
      vtkNew<vtkTreeAMRIsosurfaceMapper> mapper;
      mapper->SetInputData(grid);
      mapper->SetInputArrayToProcess(
        0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, large ? "large plane" : "plane");
      mapper->SetNumberOfContours(2);
      mapper->SetValue(0, own(-0.1));
      mapper->SetValue(1, own(0.2));
      vtkNew<vtkLookupTable> table;
      table->SetHueRange(0.05, 0.6);
      table->SetNumberOfTableValues(4096);
      table->SetTableRange(own(-0.8), own(0.9));
      table->Build();
      mapper->ScalarVisibilityOn();
      mapper->SetScalarModeToUseCellFieldData();
      mapper->SelectColorArray(colorArray);
      mapper->SetLookupTable(table);
      mapper->UseLookupTableScalarRangeOn();
      vtkNew<vtkTreeAMRIsosurfaceActor> actor;
      actor->SetMapper(mapper);
      actor->GetProperty()->LightingOff();
      scene.renderer->AddActor(actor);
      scene.setCamera();
      const MessageCounter messages(mapper);
      Frame frame = scene.render();
      EXPECT_TRUE(messages.warnings.empty()) << messages.warnings[0];
      triangles[large] = vtkSmartPointer<vtkPolyData>::New();
      triangles[large]->DeepCopy(actor->GetTriangles());
      return frame;
    };
    const std::string what = std::to_string(shift.constant);
    for (const std::string array : { "x", "plane" })
    {
      expectSame(surfaceFrame(true, ("large " + array).c_str()), surfaceFrame(false, array.c_str()), 5e-3,
        (what + " by " + array).c_str());
      vtkDataArray* colors = triangles[1]->GetPointData()->GetScalars();
      vtkDataArray* expected = triangles[0]->GetPointData()->GetScalars();
      ASSERT_TRUE(colors && expected);
      ASSERT_EQ(colors->GetNumberOfTuples(), expected->GetNumberOfTuples());
      for (vtkIdType i = 0; i < colors->GetNumberOfTuples(); ++i)
      {
        for (int c = 0; c < 4; ++c)
        {
          ASSERT_NEAR(colors->GetComponent(i, c), expected->GetComponent(i, c), 2.)
            << what << " by " << array;
        }
      }
    }
  }
}

TEST_F(DigitsInFramesTest, colorsThatAreTheValues)
{
  const auto grid = planeGrid();
  vtkNew<vtkDoubleArray> rgb;
  rgb->SetName("rgb");
  rgb->SetNumberOfComponents(3);
  rgb->SetNumberOfTuples(grid->GetCellData()->GetArray("x")->GetNumberOfTuples());
  const Color color{ 0.2, 0.7, 0.4 }; // each one value, which float has not
  for (int c = 0; c < 3; ++c)
  {
    rgb->FillComponent(c, color[c]);
  }
  grid->GetCellData()->AddArray(rgb);
  Scene scene;
  scene.useFloatTarget();
  vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
  actor->GetProperty()->LightingOff();
  vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
  mapper->ScalarVisibilityOn();
  mapper->SetScalarModeToUseCellFieldData();
  mapper->SelectColorArray("rgb");
  mapper->SetColorModeToDirectScalars();
  scene.setCamera();
  const Frame frame = scene.render();
  const auto& pixel = frame[static_cast<std::size_t>(scene.height() / 2) * scene.width() + scene.width() / 2];
  for (int c = 0; c < 3; ++c)
  {
    EXPECT_NEAR(pixel[c], color[c], 1. / 255.);
  }
}

TEST_F(DigitsInFramesTest, aRangeBelowWhatDoublesHoldIsSaidOnce)
{
  const auto grid = gridWith({ 0x1p52, 100. });
  Scene scene;
  vtkVolume* volume = scene.addVolume(grid, "large plane", { 1., 1., 1. }, 0.5);
  scene.setCamera();
  const MessageCounter messages(Scene::mapperOf(volume));
  scene.render();
  scene.render();
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("'large plane' differ by"), std::string::npos) << messages.warnings[0];
}

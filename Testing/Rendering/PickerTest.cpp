// VTK's pickers and vtkTreeAMRPicker on volumes and isosurfaces of hyper tree grids, beside polygons and VTK's own volumes.
#include "RenderingScene.h"

#include "vtkAreaPicker.h"
#include "vtkCellData.h"
#include "vtkCellPicker.h"
#include "vtkColorTransferFunction.h"
#include "vtkDataArray.h"
#include "vtkGPUVolumeRayCastMapper.h"
#include "vtkHyperTreeGrid.h"
#include "vtkImageData.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPlane.h"
#include "vtkPointData.h"
#include "vtkPointPicker.h"
#include "vtkProp3DCollection.h"
#include "vtkPropPicker.h"
#include "vtkRenderedAreaPicker.h"
#include "vtkTreeAMRPicker.h"
#include "vtkVolumePicker.h"
#include "vtkWorldPointPicker.h"

#include <algorithm>
#include <cmath>

namespace
{

using namespace treeamr::test;

constexpr Color white{ 1., 1., 1. };

class PickerTest : public RenderingTest
{
protected:
  PickerTest()
    : grid(makeTestGrid())
    , scene(120, 88)
  {
  }
  vtkActor* addSurface(double isovalue = 0.1)
  {
    vtkActor* actor = scene.addIsosurface(grid, "x", isovalue);
    scene.setCamera();
    return actor;
  }
  /// Less opaque along x, towards the eye: an opacity o is reached where x is 1 - 2 o.
  vtkSmartPointer<vtkVolume> addRamp()
  {
    vtkSmartPointer<vtkVolume> volume = scene.addVolume(grid, "x", white, 1.);
    makeRamp(volume->GetProperty());
    scene.setCamera();
    return volume;
  }
  static void makeRamp(vtkVolumeProperty* property)
  {
    vtkNew<vtkPiecewiseFunction> ramp;
    ramp->AddPoint(-1., 1.);
    ramp->AddPoint(1., 0.);
    property->SetScalarOpacity(ramp);
  }
  /// The same as an image of vertices in VTK's own mapper.
  vtkSmartPointer<vtkVolume> addImage()
  {
    constexpr int n = 9;
    vtkNew<vtkImageData> image;
    image->SetDimensions(n, n, n);
    image->SetOrigin(-1., -1., -1.);
    image->SetSpacing(2. / (n - 1), 2. / (n - 1), 2. / (n - 1));
    image->AllocateScalars(VTK_DOUBLE, 1);
    for (vtkIdType i = 0; i < image->GetNumberOfPoints(); ++i)
    {
      image->GetPointData()->GetScalars()->SetTuple1(i, image->GetPoint(i)[0]);
    }
    vtkNew<vtkGPUVolumeRayCastMapper> mapper;
    mapper->SetInputData(image);
    auto volume = vtkSmartPointer<vtkVolume>::New();
    volume->SetMapper(mapper);
    makeRamp(volume->GetProperty());
    scene.renderer->AddVolume(volume);
    scene.setCamera();
    return volume;
  }
  /// The cell's box holds the point.
  void expectCell(vtkIdType cell, const double* p)
  {
    ASSERT_GE(cell, 0);
    for (const auto& [name, a] : { std::pair{ "x", 0 }, std::pair{ "y", 1 }, std::pair{ "z", 2 } })
    {
      const double center = grid->GetCellData()->GetArray(name)->GetTuple1(cell);
      EXPECT_LE(std::abs(p[a] - center), 0.25 + 1e-6) << name; // cells are 0.5 wide at most
    }
  }
  int pick(vtkPicker* picker, double x = 0.5, double y = 0.5)
  {
    return picker->Pick(x * scene.width(), y * scene.height(), 0., scene.renderer);
  }

  vtkSmartPointer<vtkHyperTreeGrid> grid;
  Scene scene;
};

TEST_F(PickerTest, surfacesExactly)
{
  vtkActor* actor = this->addSurface();
  actor->SetPosition(0.2, -0.1, 0.3);
  actor->SetOrientation(20., 30., 40.);
  actor->SetScale(1., 1.5, 0.7);
  scene.render();
  vtkNew<vtkTreeAMRPicker> picker;
  int picked = 0;
  for (int y = 2; y < scene.height(); y += 3)
  {
    for (int x = 2; x < scene.width(); x += 3)
    {
      const int isPicked = picker->Pick(x, y, 0., scene.renderer);
      const PixelRay ray = Scene::inDataOf(actor, scene.ray(x - 0.5, y - 0.5));
      const double s = (0.1 - ray.near[0]) / (ray.far[0] - ray.near[0]);
      const Point p = ray.at(s);
      const bool isInside = std::abs(p[1]) < 0.5 && std::abs(p[2]) < 0.5; // where the field is x
      const bool isOutside = std::max(std::abs(p[1]), std::abs(p[2])) > 1.001;
      if (isOutside)
      {
        EXPECT_EQ(isPicked, 0);
        EXPECT_EQ(picker->GetPickedGrid(), nullptr);
        EXPECT_TRUE(std::isnan(picker->GetPickedValue()));
      }
      if (!isInside)
      {
        continue;
      }
      ++picked;
      ASSERT_EQ(isPicked, 1);
      EXPECT_EQ(picker->GetActor(), actor);
      EXPECT_EQ(picker->GetMapper(), actor->GetMapper());
      EXPECT_EQ(picker->GetPickedGrid(), grid);
      EXPECT_EQ(picker->GetPickedValue(), 0.1);
      double position[3];
      picker->GetMapperPosition(position);
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_NEAR(position[a], p[a], 1e-5);
        EXPECT_NEAR(picker->GetMapperNormal()[a], a == 0 ? -1. : 0., 1e-5);
      }
      this->expectCell(picker->GetCellId(), position);
      const Point world = scene.ray(x - 0.5, y - 0.5).at(s);
      for (int a = 0; a < 3; ++a)
      {
        EXPECT_NEAR(picker->GetPickPosition()[a], world[a], 1e-5);
      }
    }
  }
  EXPECT_GT(picked, 10);
}

TEST_F(PickerTest, volumesWhereTheyAreOpaqueEnough)
{
  vtkVolume* volume = this->addRamp();
  scene.render();
  vtkNew<vtkTreeAMRPicker> picker;
  for (const double opacity : { 0.4, 0.5, 0.6 })
  {
    picker->SetVolumeOpacityIsovalue(opacity);
    ASSERT_EQ(this->pick(picker), 1);
    EXPECT_EQ(picker->GetVolume(), volume);
    EXPECT_EQ(picker->GetPickedGrid(), grid);
    EXPECT_NEAR(picker->GetPickedValue(), 1. - 2. * opacity, 1e-6);
    EXPECT_NEAR(picker->GetPickPosition()[0], 1. - 2. * opacity, 1e-6);
    EXPECT_NEAR(picker->GetPickNormal()[0], -1., 1e-6);
    this->expectCell(picker->GetCellId(), picker->GetPickPosition());
  }
}

TEST_F(PickerTest, asVTKPicksImages)
{
  vtkSmartPointer<vtkVolume> image = this->addImage();
  scene.render();
  vtkVolume* own = nullptr;
  for (const double opacity : { 0.05, 0.3, 0.4, 0.5, 0.6 }) // at faces and inside
  {
    std::array<Point, 2> positions;
    std::array<Point, 2> normals;
    for (const bool isOwn : { false, true })
    {
      if (isOwn && !own)
      {
        own = this->addRamp();
      }
      image->SetVisibility(!isOwn);
      if (own)
      {
        own->SetVisibility(isOwn);
      }
      vtkNew<vtkTreeAMRPicker> picker;
      picker->SetVolumeOpacityIsovalue(opacity);
      ASSERT_EQ(picker->Pick(62., 46., 0., scene.renderer), 1);
      std::copy_n(picker->GetPickPosition(), 3, positions[isOwn].begin());
      std::copy_n(picker->GetPickNormal(), 3, normals[isOwn].begin());
    }
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_NEAR(positions[0][a], positions[1][a], 1e-3) << opacity;
      EXPECT_NEAR(normals[0][a], normals[1][a], 1e-3) << opacity;
    }
  }
}

TEST_F(PickerTest, croppingAndClippingPlanes)
{
  vtkVolume* volume = this->addRamp();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->CroppingOn();
  mapper->SetCroppingRegionPlanes(-1., 1., -1., 1., -1., 0.25);
  scene.render();
  vtkNew<vtkTreeAMRPicker> picker;
  ASSERT_EQ(this->pick(picker), 1);
  EXPECT_LE(picker->GetPickPosition()[2], 0.25 + 1e-9);
  mapper->CroppingOff();
  vtkNew<vtkPlane> plane;
  plane->SetOrigin(0., 0., 0.1);
  plane->SetNormal(0., 0., -1.);
  mapper->AddClippingPlane(plane);
  ASSERT_EQ(this->pick(picker), 1);
  EXPECT_LE(picker->GetPickPosition()[2], 0.1 + 1e-9);
}

TEST_F(PickerTest, theNearestOfAll)
{
  vtkActor* surface = this->addSurface();
  vtkVolume* volume = this->addRamp();
  vtkActor* rectangle = scene.addRectangle({ 0., 0., 3. }, { 5., 0., 0. }, { 0., 5., 0. }, white);
  scene.setCamera();
  scene.render();
  vtkNew<vtkTreeAMRPicker> picker;
  ASSERT_EQ(this->pick(picker), 1);
  EXPECT_EQ(picker->GetActor(), rectangle);
  EXPECT_EQ(picker->GetPickedGrid(), nullptr);
  EXPECT_GE(picker->GetCellId(), 0);
  rectangle->VisibilityOff();
  scene.setCamera();
  ASSERT_EQ(this->pick(picker), 1);
  EXPECT_EQ(picker->GetVolume(), volume);
  volume->PickableOff();
  ASSERT_EQ(this->pick(picker), 1);
  EXPECT_EQ(picker->GetActor(), surface);
}

// They know data sets alone: no point, no message.
TEST_F(PickerTest, vtksOwnPickersOfDataSetsPickNothing)
{
  this->addSurface();
  this->addRamp();
  scene.render();
  vtkNew<vtkCellPicker> cells;
  vtkNew<vtkVolumePicker> volumes;
  vtkNew<vtkPointPicker> points;
  EXPECT_EQ(this->pick(cells), 0);
  EXPECT_EQ(this->pick(volumes), 0);
  EXPECT_EQ(this->pick(points), 0);
}

TEST_F(PickerTest, propsOfVolumesAsVTK)
{
  for (const bool isOwn : { true, false })
  {
    vtkSmartPointer<vtkVolume> volume = isOwn ? this->addRamp() : this->addImage();
    scene.render();
    vtkNew<vtkPropPicker> picker;
    EXPECT_EQ(picker->Pick(60., 44., 0., scene.renderer), 1);
    EXPECT_EQ(picker->GetVolume(), volume);
    EXPECT_EQ(picker->Pick(1., 1., 0., scene.renderer), 0);
    vtkNew<vtkRenderedAreaPicker> area;
    EXPECT_EQ(area->AreaPick(50., 40., 70., 50., scene.renderer), 1);
    EXPECT_TRUE(area->GetProp3Ds()->IsItemPresent(volume));
    vtkNew<vtkAreaPicker> frustum;
    EXPECT_EQ(frustum->AreaPick(50., 40., 70., 50., scene.renderer), 1);
    EXPECT_EQ(frustum->AreaPick(0., 0., 2., 2., scene.renderer), 0);
    scene.renderer->RemoveVolume(volume);
  }
}

TEST_F(PickerTest, aPropPickChangesNoFrameAndNoFigures)
{
  vtkVolume* volume = this->addRamp();
  const auto before = scene.render();
  const double rays = Scene::statistic(volume, "Rays");
  vtkNew<vtkPropPicker> picker;
  EXPECT_EQ(picker->Pick(60., 44., 0., scene.renderer), 1);
  EXPECT_EQ(Scene::statistic(volume, "Rays"), rays);
  EXPECT_EQ(scene.render(), before);
}

TEST_F(PickerTest, opaqueThingsInFrontAreThePickedProps)
{
  this->addRamp();
  vtkActor* rectangle = scene.addRectangle({ 0., 0., 3. }, { 5., 0., 0. }, { 0., 5., 0. }, white);
  scene.setCamera();
  scene.render();
  vtkNew<vtkPropPicker> picker;
  EXPECT_EQ(picker->Pick(60., 44., 0., scene.renderer), 1);
  EXPECT_EQ(picker->GetActor(), rectangle);
}

TEST_F(PickerTest, propsOfSurfacesAndTheirPoints)
{
  vtkActor* actor = this->addSurface();
  scene.render();
  vtkNew<vtkPropPicker> props;
  ASSERT_EQ(props->Pick(60., 44., 0., scene.renderer), 1);
  EXPECT_EQ(props->GetActor(), actor);
  EXPECT_NEAR(props->GetPickPosition()[0], 0.1, 0.02); // within a pixel
  vtkNew<vtkWorldPointPicker> points;
  points->Pick(60.5, 44.5, 0., scene.renderer);
  EXPECT_NEAR(points->GetPickPosition()[0], 0.1, 1e-3);
  vtkNew<vtkRenderedAreaPicker> area;
  ASSERT_EQ(area->AreaPick(50., 40., 70., 50., scene.renderer), 1);
  EXPECT_TRUE(area->GetProp3Ds()->IsItemPresent(actor));
}

} // namespace

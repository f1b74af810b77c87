// Pictures of the example data against baselines in Testing/Data/Baseline. The analytic tests come first;
// these tell when a picture as a whole changes. A missing baseline fails and leaves the picture in
// Testing/Temporary of the build: look at it before copying it.
#include "RenderingScene.h"

#include "vtkColorTransferFunction.h"
#include "vtkImageData.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPolyDataMapper.h"
#include "vtkSphereSource.h"
#include "vtkTesting.h"
#include "vtkTreeAMRExampleSource.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

using namespace treeamr::test;

namespace
{

/// VTK's own for regression images.
constexpr double vtkThreshold = 0.15;

class RegressionImageTest : public RenderingTest
{
protected:
  RegressionImageTest()
    : scene_(200, 200)
  {
    scene_.renderer->SetBackground(0.32, 0.34, 0.43);
    source_->SetDatasetToMandelbulb();
    source_->SetMinimumLevel(3);
    source_->SetMaximumLevel(6);
    source_->Update();
  }

  vtkHyperTreeGrid* mandelbulb() { return source_->GetHyperTreeGridOutput(); }

  vtkVolume* addVolume()
  {
    vtkVolume* volume = scene_.addVolume(mandelbulb(), "mandelbulb", { 0., 0., 0. }, 0.);
    vtkNew<vtkColorTransferFunction> colors;
    colors->AddRGBPoint(0.3, 0.1, 0.2, 0.6);
    colors->AddRGBPoint(0.6, 0.9, 0.8, 0.4);
    colors->AddRGBPoint(1., 0.7, 0.1, 0.1);
    vtkNew<vtkPiecewiseFunction> opacity;
    opacity->AddPoint(0.25, 0.);
    opacity->AddPoint(0.5, 0.25);
    opacity->AddPoint(1., 0.35);
    volume->GetProperty()->SetColor(colors);
    volume->GetProperty()->SetScalarOpacity(opacity);
    volume->GetProperty()->SetScalarOpacityUnitDistance(0.05);
    return volume;
  }

  void addSurface(double isovalue)
  {
    vtkActor* actor = scene_.addIsosurface(mandelbulb(), "mandelbulb", isovalue);
    actor->GetProperty()->SetColor(0.85, 0.75, 0.6);
    actor->GetProperty()->SetSpecular(0.3);
    actor->GetProperty()->SetSpecularPower(20.);
  }

  void addSphere(double opacity)
  {
    vtkNew<vtkSphereSource> sphere;
    sphere->SetCenter(0.7, 0.575, 0.72);
    sphere->SetRadius(0.17);
    sphere->SetThetaResolution(48);
    sphere->SetPhiResolution(48);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(sphere->GetOutputPort());
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(0.3, 0.7, 0.4);
    actor->GetProperty()->SetOpacity(opacity);
    scene_.renderer->AddActor(actor);
  }

  void expectBaseline(const std::string& name)
  {
    vtkCamera* camera = scene_.renderer->GetActiveCamera();
    camera->SetFocalPoint(0.5, 0.5, 0.5);
    camera->SetPosition(0.5, 0.5, 2.3);
    camera->Azimuth(35.);
    camera->Elevation(25.);
    camera->SetViewAngle(35.);
    scene_.renderer->ResetCameraClippingRange();
    scene_.window->Render();
    vtkNew<vtkTesting> testing;
    testing->AddArgument("-T");
    testing->AddArgument(TREEAMR_TEST_OUTPUT_DIR);
    testing->AddArgument("-V");
    testing->AddArgument((std::string(TREEAMR_BASELINE_DIR) + "/" + name + ".png").c_str());
    testing->SetRenderWindow(scene_.window);
    EXPECT_EQ(testing->RegressionTest(vtkThreshold), vtkTesting::PASSED);
  }

  Scene scene_;
  vtkNew<vtkTreeAMRExampleSource> source_;
};

} // namespace

TEST_F(RegressionImageTest, volume)
{
  addVolume();
  expectBaseline("MandelbulbVolume");
}

// The shell that is steep, by its gradients.
TEST_F(RegressionImageTest, volumeOfTwoValues)
{
  vtkVolumeProperty* property = addVolume()->GetProperty();
  vtkNew<vtkImageData> table;
  table->SetDimensions(64, 32, 1);
  table->AllocateScalars(VTK_FLOAT, 4);
  for (int y = 0; y < 32; ++y)
  {
    for (int x = 0; x < 64; ++x)
    {
      auto* pixel = static_cast<float*>(table->GetScalarPointer(x, y, 0));
      const bool isSeen = x > 16;
      const float steepness = static_cast<float>(y) / 31.f;
      pixel[0] = steepness;
      pixel[1] = static_cast<float>(x) / 63.f;
      pixel[2] = 1.f - steepness;
      pixel[3] = isSeen ? 0.7f * steepness : 0.f;
    }
  }
  property->SetTransferFunction2D(table);
  property->SetTransferFunctionMode(vtkVolumeProperty::TF_2D);
  property->SetInterpolationTypeToLinear();
  property->ShadeOn();
  expectBaseline("MandelbulbTransfer2D");
}

TEST_F(RegressionImageTest, isosurface)
{
  addSurface(0.6);
  expectBaseline("MandelbulbIsosurface");
}

TEST_F(RegressionImageTest, volumeIsosurfaceAndSphere)
{
  addVolume();
  addSurface(0.6);
  addSphere(1.);
  expectBaseline("MandelbulbVolumeIsosurfaceSphere");
}

TEST_F(RegressionImageTest, volumeAndTranslucentSphere)
{
  addVolume();
  addSphere(0.5);
  scene_.renderer->SetUseDepthPeeling(true);
  scene_.renderer->SetUseDepthPeelingForVolumes(true);
  scene_.renderer->SetMaximumNumberOfPeels(4);
  expectBaseline("MandelbulbVolumeTranslucentSphere");
}

TEST_F(RegressionImageTest, isosurfaceOfTheSyntheticGrid)
{
  source_->SetDatasetToSynthetic();
  source_->Update();
  vtkActor* actor = scene_.addIsosurface(source_->GetHyperTreeGridOutput(), "xyz", 6.5);
  actor->SetScale(0.2);
  actor->SetPosition(0.05, 0.12, 0.05);
  expectBaseline("SyntheticIsosurface");
}

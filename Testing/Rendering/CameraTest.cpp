// What vtkCamera and the window do to the picture besides placing the eye: both mappers draw where polygons do.
#include "RenderingScene.h"

#include "vtkContourValues.h"
#include "vtkCubeSource.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkMatrix4x4.h"
#include "vtkPerspectiveTransform.h"
#include "vtkPointData.h"
#include "vtkPolyDataMapper.h"
#include "vtkTransform.h"
#include "vtkWindowToImageFilter.h"

#include <cmath>

using namespace treeamr::test;

namespace
{

constexpr double isovalue = 0.15;
constexpr Color orange{ 1., 0.6, 0.2 };

/// A plane, a box and another plane beside each other: polygons, or an isosurface, a volume and an isosurface of a volume.
class CameraTest : public RenderingTest
{
protected:
  using Picture = std::vector<std::array<float, 4>>;
  using Setup = std::function<void(Scene&)>;

  static Picture picture(const Setup& add, const Setup& setup)
  {
    Scene scene(120, 88);
    add(scene);
    scene.setCamera();
    scene.renderer->GetActiveCamera()->SetPosition(3.5, 1.1, 1.9);
    scene.renderer->ResetCamera();
    setup(scene);
    return scene.render();
  }

  static int differences(const Picture& a, const Picture& b)
  {
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
    {
      double difference = 0.;
      for (int c = 0; c < 3; ++c)
      {
        difference = std::max<double>(difference, std::abs(a[i][c] - b[i][c]));
      }
      count += difference > 0.02;
    }
    return count;
  }

  static void place(vtkProp3D* prop, double y)
  {
    prop->SetPosition(0., y, 0.);
    prop->SetScale(0.45);
  }

  static void addPolygons(Scene& scene)
  {
    for (const double y : { 0., -1. })
    {
      place(scene.addRectangle({ isovalue, 0., 0. }, { 0., 1., 0. }, { 0., 0., 1. }, orange), y);
    }
    vtkNew<vtkCubeSource> cube;
    cube->SetBounds(-1., 1., -1., 1., -1., 1.);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(cube->GetOutputPort());
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->LightingOff();
    actor->GetProperty()->SetColor(orange[0], orange[1], orange[2]);
    scene.renderer->AddActor(actor);
    place(actor, 1.);
  }

  static void addTrees(Scene& scene, double opacity)
  {
    GridOptions options;
    options.roots = { 4, 4, 4 };
    const auto grid = makeGrid(options, { { "x", [](const Point& p) { return p[0]; } } });
    vtkActor* actor = scene.addIsosurface(grid, "x", isovalue);
    vtkProperty* property = actor->GetProperty();
    property->LightingOff();
    property->SetColor(orange[0], orange[1], orange[2]);
    property->SetOpacity(opacity);
    place(actor, 0.);
    constexpr double opaque = 1e4;
    place(scene.addVolume(grid, "x", orange, opaque), 1.);
    vtkVolume* volume = scene.addVolume(grid, "x", orange, opaque);
    volume->GetProperty()->GetIsoSurfaceValues()->SetValue(0, isovalue);
    Scene::mapperOf(volume)->SetBlendModeToIsoSurface();
    place(volume, -1.);
  }

  /// The mappers' picture against that of polygons, which `setup` has changed from a plain one.
  static void expectSameAsPolygons(const Setup& setup)
  {
    constexpr int edges = 12; // pixels whose centres lie on an edge, but for rounding
    const Picture polygons = picture(addPolygons, setup);
    static const Picture plain = picture(addPolygons, [](Scene&) {});
    EXPECT_GT(differences(polygons, plain), 5 * edges);
    EXPECT_LE(differences(polygons, picture([](Scene& scene) { addTrees(scene, 1.); }, setup)), edges);
    EXPECT_LE(differences(polygons,
                picture([](Scene& scene) { addTrees(scene, 0.999); },
                  [&](Scene& scene) {
                    scene.renderer->UseDepthPeelingOn();
                    scene.renderer->UseDepthPeelingForVolumesOn();
                    setup(scene);
                  })),
      edges)
      << "depth peeling";
  }

  static Setup withCamera(const std::function<void(vtkCamera*)>& change)
  {
    return [change](Scene& scene) {
      change(scene.renderer->GetActiveCamera());
      scene.renderer->ResetCameraClippingRange();
    };
  }
};

class StereoTest
  : public CameraTest
  , public ::testing::WithParamInterface<int>
{
};

} // namespace

TEST_P(StereoTest, sameAsPolygons)
{
  expectSameAsPolygons([](Scene& scene) {
    scene.renderer->GetActiveCamera()->SetEyeAngle(25.);
    scene.window->SetStereoType(GetParam());
    scene.window->StereoRenderOn();
  });
}

INSTANTIATE_TEST_SUITE_P(types, StereoTest,
  ::testing::Values(VTK_STEREO_LEFT, VTK_STEREO_RIGHT, VTK_STEREO_RED_BLUE, VTK_STEREO_INTERLACED,
    VTK_STEREO_ANAGLYPH, VTK_STEREO_SPLITVIEWPORT_HORIZONTAL));

TEST_F(CameraTest, modelTransformMatrix)
{
  expectSameAsPolygons(withCamera([](vtkCamera* camera) {
    vtkNew<vtkTransform> model;
    model->Translate(0.2, -0.3, 0.1);
    model->RotateWXYZ(30., 1., 2., 3.);
    model->Scale(0.8, 1.2, 0.6);
    camera->SetModelTransformMatrix(model->GetMatrix());
  }));
}

// What has been drawn before does not stay.
TEST_F(CameraTest, changesBetweenFrames)
{
  expectSameAsPolygons([](Scene& scene) {
    scene.render();
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    vtkNew<vtkTransform> model;
    model->RotateX(30.);
    camera->SetModelTransformMatrix(model->GetMatrix());
    scene.renderer->ResetCameraClippingRange();
    scene.render();
    scene.window->SetStereoTypeToRight();
    scene.window->StereoRenderOn();
    camera->SetEyeAngle(25.);
    scene.render();
    model->Translate(0., 0.5, 0.);
    camera->SetModelTransformMatrix(model->GetMatrix());
  });
}

TEST_F(CameraTest, offAxisProjection)
{
  for (const bool left : { true, false })
  {
    expectSameAsPolygons([left](Scene& scene) {
      vtkCamera* camera = scene.renderer->GetActiveCamera();
      camera->UseOffAxisProjectionOn();
      double corners[3][3] = { { -1.2, -0.9, -1.5 }, { 1.2, -0.9, -1.5 }, { 1.2, 0.9, -1.5 } };
      camera->SetScreenBottomLeft(corners[0]);
      camera->SetScreenBottomRight(corners[1]);
      camera->SetScreenTopRight(corners[2]);
      camera->SetEyeSeparation(3.);
      camera->SetLeftEye(left);
    });
  }
}

TEST_F(CameraTest, shearAndWindowCenter)
{
  expectSameAsPolygons(withCamera([](vtkCamera* camera) {
    camera->SetViewShear(0.3, -0.2, 0.4);
    camera->SetWindowCenter(0.2, -0.1);
  }));
  expectSameAsPolygons(withCamera([](vtkCamera* camera) {
    camera->ParallelProjectionOn();
    camera->SetWindowCenter(0.2, -0.1);
  }));
}

TEST_F(CameraTest, userTransforms)
{
  expectSameAsPolygons(withCamera([](vtkCamera* camera) {
    vtkNew<vtkPerspectiveTransform> ofProjection;
    ofProjection->Translate(0.1, -0.2, 0.);
    ofProjection->Scale(0.7, 1.1, 1.);
    camera->SetUserTransform(ofProjection);
    vtkNew<vtkTransform> ofView;
    ofView->RotateZ(20.);
    camera->SetUserViewTransform(ofView);
  }));
}

TEST_F(CameraTest, aspectAndAngle)
{
  expectSameAsPolygons(withCamera([](vtkCamera* camera) {
    camera->SetExplicitAspectRatio(0.7);
    camera->UseExplicitAspectRatioOn();
    camera->UseHorizontalViewAngleOn();
    camera->SetViewAngle(40.);
  }));
}

TEST_F(CameraTest, explicitProjection)
{
  expectSameAsPolygons([](Scene& scene) {
    vtkCamera* camera = scene.renderer->GetActiveCamera();
    vtkNew<vtkMatrix4x4> projection;
    projection->DeepCopy(camera->GetProjectionTransformMatrix(1.9, -1., 1.));
    projection->SetElement(0, 2, 0.2);
    camera->SetExplicitProjectionTransformMatrix(projection);
    camera->UseExplicitProjectionTransformMatrixOn();
  });
}

// As large screenshots are made: piece by piece, each in the whole window.
TEST_F(CameraTest, tiles)
{
  const auto large = [](const Setup& add) {
    Scene scene(120, 88);
    add(scene);
    scene.setCamera();
    vtkNew<vtkWindowToImageFilter> filter;
    filter->SetInput(scene.window);
    filter->SetScale(3, 2);
    filter->FixBoundaryOff();
    filter->Update();
    vtkSmartPointer<vtkImageData> image = filter->GetOutput();
    return image;
  };
  const auto polygons = large(addPolygons);
  const auto trees = large([](Scene& scene) { addTrees(scene, 1.); });
  vtkDataArray* expected = polygons->GetPointData()->GetScalars();
  vtkDataArray* found = trees->GetPointData()->GetScalars();
  ASSERT_EQ(expected->GetNumberOfTuples(), 3 * 120 * 2 * 88);
  ASSERT_EQ(found->GetNumberOfTuples(), expected->GetNumberOfTuples());
  int covered = 0;
  int different = 0;
  for (vtkIdType i = 0; i < expected->GetNumberOfTuples(); ++i)
  {
    covered += expected->GetComponent(i, 0) > 0.;
    different += std::abs(expected->GetComponent(i, 0) - found->GetComponent(i, 0)) > 2.;
  }
  EXPECT_GT(covered, 5000);
  EXPECT_LE(different, 40);
}

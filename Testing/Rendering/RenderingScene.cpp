#include "RenderingScene.h"

#include "vtkCallbackCommand.h"
#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkDoubleArray.h"
#include "vtkFramebufferPass.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGridNonOrientedGeometryCursor.h"
#include "vtkMatrix4x4.h"
#include "vtkObjectFactory.h"
#include "vtkOutputWindow.h"
#include "vtkPiecewiseFunction.h"
#include "vtkPixelBufferObject.h"
#include "vtkPlaneSource.h"
#include "vtkPolyDataMapper.h"
#include "vtkRenderStepsPass.h"
#include "vtkTable.h"
#include "vtkTextureObject.h"
#include "vtkVariant.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr::test
{

namespace
{

/// Keeps what VTK says instead of printing it.
class KeepingOutputWindow : public vtkOutputWindow
{
public:
  static KeepingOutputWindow* New();
  vtkTypeMacro(KeepingOutputWindow, vtkOutputWindow);
  void DisplayText(const char* text) override { this->Text += text; }
  std::string Text;
};
vtkStandardNewMacro(KeepingOutputWindow);

KeepingOutputWindow* output()
{
  static vtkSmartPointer<KeepingOutputWindow> instance;
  if (!instance)
  {
    instance = vtkSmartPointer<KeepingOutputWindow>::New();
    vtkOutputWindow::SetInstance(instance);
  }
  return instance;
}

void fillTree(vtkHyperTreeGridNonOrientedGeometryCursor* cursor, const GridOptions& options,
  const std::vector<std::pair<std::string, ScalarField>>& arrays, vtkCellData* cells)
{
  double bounds[6];
  cursor->GetBounds(bounds);
  const Point center{ 0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[2] + bounds[3]),
    0.5 * (bounds[4] + bounds[5]) };
  const vtkIdType id = cursor->GetGlobalNodeIndex();
  for (std::size_t i = 0; i < arrays.size(); ++i)
  {
    cells->GetArray(static_cast<int>(i))->InsertTuple1(id, arrays[i].second(center));
  }
  if (!options.refine(center, static_cast<int>(cursor->GetLevel())))
  {
    return;
  }
  cursor->SubdivideLeaf();
  for (int child = 0; child < cursor->GetNumberOfChildren(); ++child)
  {
    cursor->ToChild(static_cast<unsigned char>(child));
    fillTree(cursor, options, arrays, cells);
    cursor->ToParent();
  }
}

void transform(vtkMatrix4x4* matrix, const Point& p, Point& q)
{
  const double in[4] = { p[0], p[1], p[2], 1. };
  double out[4];
  matrix->MultiplyPoint(in, out);
  q = { out[0] / out[3], out[1] / out[3], out[2] / out[3] };
}

double dot(const Point& a, const Point& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

} // namespace

vtkSmartPointer<vtkHyperTreeGrid> makeGrid(
  const GridOptions& options, const std::vector<std::pair<std::string, ScalarField>>& arrays)
{
  auto grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
  grid->SetDimensions(options.roots[0] + 1, options.roots[1] + 1, options.roots[2] + 1);
  grid->SetBranchFactor(options.branchFactor);
  for (int a = 0; a < 3; ++a)
  {
    vtkNew<vtkDoubleArray> coordinates;
    for (int i = 0; i <= options.roots[a]; ++i)
    {
      coordinates->InsertNextValue(options.min[a] + (options.max[a] - options.min[a]) * i / options.roots[a]);
    }
    a == 0     ? grid->SetXCoordinates(coordinates)
      : a == 1 ? grid->SetYCoordinates(coordinates)
               : grid->SetZCoordinates(coordinates);
  }
  for (const auto& array : arrays)
  {
    vtkNew<vtkDoubleArray> values;
    values->SetName(array.first.c_str());
    grid->GetCellData()->AddArray(values);
  }
  vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
  vtkIdType next = 0;
  for (vtkIdType tree = 0; options.trees && tree < grid->GetMaxNumberOfTrees(); ++tree)
  {
    grid->InitializeNonOrientedGeometryCursor(cursor, tree, true);
    cursor->SetGlobalIndexStart(next);
    fillTree(cursor, options, arrays, grid->GetCellData());
    next += cursor->GetTree()->GetNumberOfVertices();
  }
  return grid;
}

vtkSmartPointer<vtkHyperTreeGrid> makeTestGrid()
{
  GridOptions options;
  options.roots = { 4, 4, 4 };
  options.refine = [](const Point& c, int level) {
    return level < 2 && c[0] > 0. && c[1] > 0. && c[2] > -0.5;
  };
  return makeGrid(options,
    { { "one", [](const Point&) { return 1.; } }, { "x", [](const Point& p) { return p[0]; } },
      { "y", [](const Point& p) { return p[1]; } }, { "z", [](const Point& p) { return p[2]; } } });
}

Point PixelRay::at(double s) const
{
  return { near[0] + s * (far[0] - near[0]), near[1] + s * (far[1] - near[1]),
    near[2] + s * (far[2] - near[2]) };
}

double PixelRay::length() const
{
  const Point d{ far[0] - near[0], far[1] - near[1], far[2] - near[2] };
  return std::sqrt(dot(d, d));
}

Scene::Scene(int width, int height, int multiSamples)
{
  this->window->SetOffScreenRendering(true);
  this->window->SetMultiSamples(multiSamples);
  this->window->SetSize(width, height);
  this->window->AddRenderer(this->renderer);
}

Scene::~Scene()
{
  // The pass insists on being told before it dies.
  if (floatTarget_)
  {
    floatTarget_->ReleaseGraphicsResources(this->window);
    this->renderer->SetPass(nullptr);
  }
}

vtkVolume* Scene::addVolume(vtkHyperTreeGrid* grid, const char* array, const Color& color, double extinction)
{
  vtkNew<vtkTreeAMRVolumeMapper> mapper;
  mapper->SetInputData(grid);
  mapper->SetScalarModeToUseCellFieldData();
  mapper->SelectScalarArray(array);
  vtkNew<vtkVolume> volume;
  volume->SetMapper(mapper);
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0., color[0], color[1], color[2]);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(0., -std::expm1(-extinction));
  volume->GetProperty()->SetColor(colors);
  volume->GetProperty()->SetScalarOpacity(opacity);
  volume->GetProperty()->SetScalarOpacityUnitDistance(1.);
  volume->GetProperty()->SetInterpolationTypeToLinear();
  this->renderer->AddVolume(volume);
  return volume;
}

vtkActor* Scene::addIsosurface(vtkHyperTreeGrid* grid, const char* array, double isovalue)
{
  vtkNew<vtkTreeAMRIsosurfaceMapper> mapper;
  mapper->SetInputData(grid);
  mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, array);
  mapper->SetValue(0, isovalue);
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  this->renderer->AddActor(actor);
  return actor;
}

vtkActor* Scene::addRectangle(
  const Point& center, const Point& halfU, const Point& halfV, const Color& color, double opacity)
{
  Point corners[3];
  for (int a = 0; a < 3; ++a)
  {
    corners[0][a] = center[a] - halfU[a] - halfV[a];
    corners[1][a] = center[a] + halfU[a] - halfV[a];
    corners[2][a] = center[a] - halfU[a] + halfV[a];
  }
  vtkNew<vtkPlaneSource> plane;
  plane->SetOrigin(corners[0].data());
  plane->SetPoint1(corners[1].data());
  plane->SetPoint2(corners[2].data());
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(plane->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(color[0], color[1], color[2]);
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetOpacity(opacity);
  this->renderer->AddActor(actor);
  return actor;
}

vtkTreeAMRVolumeMapper* Scene::mapperOf(vtkVolume* volume)
{
  return vtkTreeAMRVolumeMapper::SafeDownCast(volume->GetMapper());
}

vtkTreeAMRIsosurfaceMapper* Scene::mapperOf(vtkActor* actor)
{
  return vtkTreeAMRIsosurfaceMapper::SafeDownCast(actor->GetMapper());
}

double Scene::statistic(vtkVolume* volume, const char* name)
{
  vtkTable* table = mapperOf(volume)->GetStatistics();
  EXPECT_EQ(table->GetNumberOfRows(), 1);
  EXPECT_NE(table->GetColumnByName(name), nullptr) << name;
  return table->GetValueByName(0, name).ToDouble();
}

void Scene::setCamera(bool parallel)
{
  vtkCamera* camera = this->renderer->GetActiveCamera();
  camera->SetParallelProjection(parallel);
  camera->SetFocalPoint(0., 0., 0.);
  camera->SetPosition(3.1, 2.2, 4.3);
  camera->SetViewUp(0., 1., 0.1);
  this->renderer->ResetCamera();
}

void Scene::setCameraAlongZ()
{
  vtkCamera* camera = this->renderer->GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(0., 0., 0.);
  camera->SetPosition(0., 0., 5.);
  camera->SetViewUp(0., 1., 0.);
  // Half of the height; the longer side of the window is the width.
  camera->SetParallelScale(0.9 * this->height() / this->width());
  camera->SetClippingRange(2., 8.);
}

void Scene::useFloatTarget()
{
  floatTarget_ = vtkSmartPointer<vtkFramebufferPass>::New();
  floatTarget_->SetColorFormat(vtkTextureObject::Float32);
  floatTarget_->SetDepthFormat(vtkTextureObject::Float32);
  vtkNew<vtkRenderStepsPass> steps;
  floatTarget_->SetDelegatePass(steps);
  this->renderer->SetPass(floatTarget_);
}

int Scene::width() const
{
  return this->renderer->GetSize()[0];
}

int Scene::height() const
{
  return this->renderer->GetSize()[1];
}

std::vector<std::array<float, 4>> Scene::render()
{
  this->window->Render();
  const int w = this->width();
  const int h = this->height();
  std::vector<std::array<float, 4>> pixels(static_cast<std::size_t>(w) * h);
  if (floatTarget_)
  {
    vtkSmartPointer<vtkPixelBufferObject> buffer;
    buffer.TakeReference(floatTarget_->GetColorTexture()->Download());
    unsigned int size[2] = { static_cast<unsigned int>(w), static_cast<unsigned int>(h) };
    vtkIdType increments[2] = { 0, 0 };
    buffer->Download2D(VTK_FLOAT, pixels.data(), size, 4, increments);
    return pixels;
  }
  const int* origin = this->renderer->GetOrigin();
  float* values =
    this->window->GetRGBAPixelData(origin[0], origin[1], origin[0] + w - 1, origin[1] + h - 1, 0);
  std::copy(values, values + 4 * pixels.size(), pixels.front().data());
  delete[] values;
  return pixels;
}

std::vector<float> Scene::depths()
{
  const int w = this->width();
  const int h = this->height();
  std::vector<float> values(static_cast<std::size_t>(w) * h);
  const int* origin = this->renderer->GetOrigin();
  this->window->GetZbufferData(origin[0], origin[1], origin[0] + w - 1, origin[1] + h - 1, values.data());
  return values;
}

PixelRay Scene::ray(double x, double y) const
{
  vtkNew<vtkMatrix4x4> worldFromClip;
  vtkMatrix4x4::Invert(this->renderer->GetActiveCamera()->GetCompositeProjectionTransformMatrix(
                         this->renderer->GetTiledAspectRatio(), -1., 1.),
    worldFromClip);
  const double xClip = 2. * (x + 0.5) / this->width() - 1.;
  const double yClip = 2. * (y + 0.5) / this->height() - 1.;
  PixelRay ray;
  transform(worldFromClip, { xClip, yClip, -1. }, ray.near);
  transform(worldFromClip, { xClip, yClip, 1. }, ray.far);
  return ray;
}

PixelRay Scene::inDataOf(vtkProp3D* prop, const PixelRay& ray)
{
  vtkNew<vtkMatrix4x4> dataFromWorld;
  prop->GetMatrix(dataFromWorld);
  dataFromWorld->Invert();
  PixelRay data;
  transform(dataFromWorld, ray.near, data.near);
  transform(dataFromWorld, ray.far, data.far);
  return data;
}

bool Scene::chord(const PixelRay& ray, vtkProp3D* prop, const Box& box, double& entry, double& exit)
{
  const PixelRay data = inDataOf(prop, ray);
  const Point& from = data.near;
  const Point& to = data.far;
  entry = 0.;
  exit = 1.;
  for (int a = 0; a < 3; ++a)
  {
    const double d = to[a] - from[a];
    if (d == 0.)
    {
      exit = from[a] < box.min[a] || from[a] > box.max[a] ? -1. : exit;
      continue;
    }
    const double s0 = (box.min[a] - from[a]) / d;
    const double s1 = (box.max[a] - from[a]) / d;
    entry = std::max(entry, std::min(s0, s1));
    exit = std::min(exit, std::max(s0, s1));
  }
  return entry < exit;
}

double Scene::meet(const PixelRay& ray, const Point& center, const Point& normal)
{
  const Point d{ ray.far[0] - ray.near[0], ray.far[1] - ray.near[1], ray.far[2] - ray.near[2] };
  const Point o{ center[0] - ray.near[0], center[1] - ray.near[1], center[2] - ray.near[2] };
  const double along = dot(d, normal);
  return along == 0. ? std::numeric_limits<double>::infinity() : dot(o, normal) / along;
}

Color composite(const std::vector<Layer>& layers, const Color& background)
{
  Color sum{};
  double passes = 1.;
  for (const Layer& layer : layers)
  {
    for (int c = 0; c < 3; ++c)
    {
      sum[c] += passes * layer.alpha * layer.color[c];
    }
    passes *= 1. - layer.alpha;
  }
  for (int c = 0; c < 3; ++c)
  {
    sum[c] += passes * background[c];
  }
  return sum;
}

void RenderingTest::SetUp()
{
  output()->Text.clear();
}

void RenderingTest::TearDown()
{
  EXPECT_EQ(output()->Text, "");
}

MessageCounter::MessageCounter(vtkObject* object)
  : object_(object)
{
  command_->SetClientData(this);
  command_->SetCallback([](vtkObject*, unsigned long event, void* clientData, void* callData) {
    auto* self = static_cast<MessageCounter*>(clientData);
    (event == vtkCommand::ErrorEvent ? self->errors : self->warnings)
      .emplace_back(static_cast<const char*>(callData));
  });
  object->AddObserver(vtkCommand::ErrorEvent, command_);
  object->AddObserver(vtkCommand::WarningEvent, command_);
}

MessageCounter::~MessageCounter()
{
  if (object_)
  {
    object_->RemoveObserver(command_);
  }
}

} // namespace treeamr::test

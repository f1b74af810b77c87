// Small scenes rendered offscreen, and what their pixels must be: rays and chords from VTK's matrices alone.
#pragma once

#include "vtkActor.h"
#include "vtkCallbackCommand.h"
#include "vtkCamera.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkProperty.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkSmartPointer.h"
#include "vtkTreeAMRIsosurfaceMapper.h"
#include "vtkTreeAMRVolumeMapper.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"
#include "vtkWeakPointer.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

class vtkFramebufferPass;

namespace treeamr::test
{

using Point = std::array<double, 3>;
using Color = std::array<double, 3>;
using ScalarField = std::function<double(const Point&)>;

struct GridOptions
{
  std::array<int, 3> roots{ 2, 2, 2 };
  Point min{ -1., -1., -1. };
  Point max{ 1., 1., 1. };
  int branchFactor = 2;
  bool trees = true;
  /// Whether to refine a cell by its centre and level.
  std::function<bool(const Point&, int)> refine = [](const Point&, int) { return false; };
};

/// Cell arrays with the fields' values at the centres, of coarse cells as well.
vtkSmartPointer<vtkHyperTreeGrid> makeGrid(
  const GridOptions& options, const std::vector<std::pair<std::string, ScalarField>>& arrays);

/// Two levels of refinement in one corner of [-1, 1]^3: arrays "one" (1 everywhere), "x", "y" and "z".
vtkSmartPointer<vtkHyperTreeGrid> makeTestGrid();

/// The part of a pixel's line of sight between the near and the far plane.
struct PixelRay
{
  Point near;
  Point far;
  Point at(double s) const;
  double length() const;
};

/// An axis-aligned box in data coordinates of a prop.
struct Box
{
  Point min{ -1., -1., -1. };
  Point max{ 1., 1., 1. };
};

class Scene
{
public:
  explicit Scene(int width = 60, int height = 44, int multiSamples = 0);
  ~Scene();

  /// A volume that draws `array` with one colour and one extinction per world length, for every value.
  vtkVolume* addVolume(vtkHyperTreeGrid* grid, const char* array, const Color& color, double extinction);
  vtkActor* addIsosurface(vtkHyperTreeGrid* grid, const char* array, double isovalue);
  /// An unlit rectangle through `center`.
  vtkActor* addRectangle(
    const Point& center, const Point& halfU, const Point& halfV, const Color& color, double opacity = 1.);
  static vtkTreeAMRVolumeMapper* mapperOf(vtkVolume* volume);
  static vtkTreeAMRIsosurfaceMapper* mapperOf(vtkActor* actor);
  /// A column of vtkTreeAMRVolumeMapper::GetStatistics().
  static double statistic(vtkVolume* volume, const char* name);

  /// From an oblique direction, everything in view.
  void setCamera(bool parallel = false);
  /// Parallel along z, nothing but the square [-0.9, 0.9]^2 in view.
  void setCameraAlongZ();
  /// 32-bit float colours, for exact comparisons. Before the first render.
  void useFloatTarget();

  /// Renders; RGBA of the renderer's pixels, lower left first.
  std::vector<std::array<float, 4>> render();
  /// Window depths of the last render.
  std::vector<float> depths();
  int width() const;
  int height() const;

  /// Through the centre of pixel (x, y); fractions reach the rest of it.
  PixelRay ray(double x, double y) const;
  static PixelRay inDataOf(vtkProp3D* prop, const PixelRay& ray);
  /// s of the entry into a prop's box and of the exit along the ray, within [0, 1]; false: no chord.
  static bool chord(const PixelRay& ray, vtkProp3D* prop, const Box& box, double& entry, double& exit);
  /// s where the ray meets a plane; infinite when it does not.
  static double meet(const PixelRay& ray, const Point& center, const Point& normal);

  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkRenderWindow> window;

private:
  vtkSmartPointer<vtkFramebufferPass> floatTarget_;
};

/// One layer of what is seen along a ray.
struct Layer
{
  Color color;
  double alpha;
};
/// Layers from the eye on, over a background.
Color composite(const std::vector<Layer>& layers, const Color& background);

/// A test after which VTK must have had nothing to say: no error, and no complaint about OpenGL's state.
class RenderingTest : public ::testing::Test
{
protected:
  void SetUp() override;
  void TearDown() override;
};

/// Collects the errors and warnings of an object while it lives; they are not printed.
class MessageCounter
{
public:
  explicit MessageCounter(vtkObject* object);
  ~MessageCounter();
  MessageCounter(const MessageCounter&) = delete;
  MessageCounter& operator=(const MessageCounter&) = delete;
  std::vector<std::string> errors;
  std::vector<std::string> warnings;

private:
  vtkWeakPointer<vtkObject> object_;
  vtkNew<vtkCallbackCommand> command_;
};

} // namespace treeamr::test

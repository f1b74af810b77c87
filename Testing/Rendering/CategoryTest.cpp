// Volumes and isosurfaces coloured by categories (IndexedLookup), against the cells along each pixel's line of sight.
#include "PlaneSurface.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkLookupTable.h"
#include "vtkPiecewiseFunction.h"
#include "vtkStringArray.h"
#include "vtkTypeInt64Array.h"
#include "vtkVariant.h"

#include <algorithm>
#include <cmath>

using namespace treeamr::test;

namespace
{

constexpr Color background{ 0.1, 0.2, 0.3 };
constexpr Color nothing{ 0.2, 0.8, 0.4 };
/// Colours that eight bits have, so that they may be compared exactly.
const std::vector<Color> palette{ { 1., 0., 0.2 }, { 0., 0.6, 1. }, { 0.8, 0.4, 0. } };
/// More than there are colours: the fourth has the first one's again. 1 and 4 are not listed.
const std::vector<int> listed{ 2, 5, 0, 3 };
constexpr int ids = 6;

bool isRefined(const Point& c, int level)
{
  return level < 2 && c[0] + c[2] > 0.1;
}

/// Of a cell, by its centre; neighbours differ.
int idOf(const Point& c)
{
  int sum = 0;
  for (int a = 0; a < 3; ++a)
  {
    sum += (2 * a + 3) * static_cast<int>(std::lround(16. * (c[a] + 1.)));
  }
  return sum % ids;
}

/// Between the planes of the finest cells.
constexpr double finest = 0.125;

/// The centre of the cell around a point in [-1, 1]^3.
Point centreOfCell(const Point& p)
{
  double width = 0.5;
  for (int level = 0;; ++level, width *= 0.5)
  {
    Point c;
    for (int a = 0; a < 3; ++a)
    {
      c[a] = (std::floor(p[a] / width) + 0.5) * width;
    }
    if (!isRefined(c, level))
    {
      return c;
    }
  }
}

/// Whether a rounding may move the point to the next cell.
bool isAtAPlane(const Point& p)
{
  return std::any_of(
    p.begin(), p.end(), [](double x) { return std::abs(x - finest * std::round(x / finest)) < 1e-4; });
}

Color colorOf(int id)
{
  const auto at = std::find(listed.begin(), listed.end(), id);
  return at == listed.end() ? nothing
                            : palette[static_cast<std::size_t>(at - listed.begin()) % palette.size()];
}

class CategoryTest : public RenderingTest
{
protected:
  static vtkSmartPointer<vtkHyperTreeGrid> grid()
  {
    GridOptions options;
    options.roots = { 4, 4, 4 };
    options.refine = isRefined;
    return makeGrid(options,
      { { "id", [](const Point& p) { return idOf(p); } }, { "z", [](const Point& p) { return p[2]; } } });
  }

  static void list(vtkScalarsToColors* table)
  {
    table->IndexedLookupOn();
    for (const int id : listed)
    {
      table->SetAnnotation(vtkVariant(id), std::to_string(id));
    }
  }

  static vtkSmartPointer<vtkColorTransferFunction> makeColors()
  {
    auto colors = vtkSmartPointer<vtkColorTransferFunction>::New();
    for (std::size_t i = 0; i < palette.size(); ++i)
    {
      colors->AddRGBPoint(10. * static_cast<double>(i), palette[i][0], palette[i][1], palette[i][2]);
    }
    colors->SetNanColor(nothing[0], nothing[1], nothing[2]);
    return colors;
  }

  static double opacityOf(double id) { return 0.1 + 0.1 * id; }

  static vtkVolume* addCategories(Scene& scene, vtkHyperTreeGrid* grid)
  {
    vtkVolume* volume = scene.addVolume(grid, "id", { 1., 1., 1. }, 1.);
    const auto colors = makeColors();
    list(colors);
    volume->GetProperty()->SetColor(colors);
    vtkNew<vtkPiecewiseFunction> opacity;
    opacity->AddPoint(0., opacityOf(0.));
    opacity->AddPoint(ids - 1., opacityOf(ids - 1.));
    volume->GetProperty()->SetScalarOpacity(opacity);
    volume->GetProperty()->SetScalarOpacityUnitDistance(0.7);
    scene.renderer->SetBackground(background.data());
    scene.setCamera();
    return volume;
  }

  using Pixels = std::vector<std::array<float, 4>>;
  static void expectPixel(
    const Scene& scene, const Pixels& pixels, int x, int y, const Color& expected, double tolerance)
  {
    for (int c = 0; c < 3; ++c)
    {
      ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], expected[c], tolerance)
        << "channel " << c << " of pixel " << x << ", " << y;
    }
  }

  /// From cell to cell, cut at all planes where one may end.
  static Color expectedVolume(const PixelRay& ray, double unitDistance)
  {
    std::vector<double> cuts{ 0., 1. };
    for (int a = 0; a < 3; ++a)
    {
      for (int i = -8; i <= 8; ++i)
      {
        const double s = (finest * i - ray.near[a]) / (ray.far[a] - ray.near[a]);
        if (s > 0. && s < 1.)
        {
          cuts.push_back(s);
        }
      }
    }
    std::sort(cuts.begin(), cuts.end());
    std::vector<Layer> layers;
    for (std::size_t i = 1; i < cuts.size(); ++i)
    {
      const Point middle = ray.at(0.5 * (cuts[i - 1] + cuts[i]));
      if (std::all_of(middle.begin(), middle.end(), [](double x) { return std::abs(x) < 1.; }))
      {
        const int id = idOf(centreOfCell(middle));
        const double length = (cuts[i] - cuts[i - 1]) * ray.length();
        layers.push_back({ colorOf(id), 1. - std::pow(1. - opacityOf(id), length / unitDistance) });
      }
    }
    return composite(layers, background);
  }

  static vtkTreeAMRIsosurfaceMapper* addSurface(Scene& scene, const char* array, double isovalue)
  {
    vtkActor* actor = scene.addIsosurface(grid(), array, isovalue);
    actor->GetProperty()->LightingOff();
    actor->GetProperty()->SetAmbient(0.);
    vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
    mapper->ScalarVisibilityOn();
    mapper->SetScalarModeToUseCellFieldData();
    mapper->UseLookupTableScalarRangeOn();
    scene.setCamera();
    return mapper;
  }

  /// The pixels where the plane z = height is seen well inside the grid, against expected(the point).
  template <class Expected>
  static void expectPlane(Scene& scene, double height, const Expected& expected)
  {
    const auto pixels = scene.render();
    int compared = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const Point p = ray.at(Scene::meet(ray, { 0., 0., height }, { 0., 0., 1. }));
        if (!isInside(p) || isAtAPlane(p))
        {
          continue;
        }
        ++compared;
        expectPixel(scene, pixels, x, y, expected(p), 1e-6);
      }
    }
    EXPECT_GT(compared, 150);
  }
};

/// Not one of the finest planes.
constexpr double height = 0.3;

} // namespace

TEST_F(CategoryTest, volumeByTheCellsOnEachRay)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addCategories(scene, grid());
  for (const bool parallel : { false, true })
  {
    scene.setCamera(parallel);
    const auto pixels = scene.render();
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        expectPixel(scene, pixels, x, y,
          expectedVolume(scene.ray(x, y), volume->GetProperty()->GetScalarOpacityUnitDistance()), 2e-5);
      }
    }
  }
  // No reconstruction, and nothing kept of any.
  EXPECT_EQ(Scene::statistic(volume, "ReconstructedCells"), 0.);
  EXPECT_EQ(Scene::statistic(volume, "KeptBytes"), 0.);
}

TEST_F(CategoryTest, interactiveFramesHaveNoMeans)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addCategories(scene, grid());
  const auto still = scene.render();
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->SetLevelOfDetail(1000.);
  mapper->SetMaximumImageSampleDistance(1.);
  scene.window->SetDesiredUpdateRate(10.);
  EXPECT_EQ(scene.render(), still);
  EXPECT_EQ(Scene::statistic(volume, "LevelOfDetail"), 0.);
  scene.window->SetDesiredUpdateRate(1e-4);
  mapper->EstimateErrorOn();
  EXPECT_EQ(scene.render(), still);
  EXPECT_EQ(Scene::statistic(volume, "EstimatedError"), 0.);
}

TEST_F(CategoryTest, switchedOnAndOff)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addCategories(scene, grid());
  const auto categories = scene.render();
  vtkColorTransferFunction* colors = volume->GetProperty()->GetRGBTransferFunction(0);
  colors->IndexedLookupOff();
  const auto interpolated = scene.render();
  EXPECT_NE(interpolated, categories);
  EXPECT_GT(Scene::statistic(volume, "ReconstructedCells"), 0.);
  colors->IndexedLookupOn();
  EXPECT_EQ(scene.render(), categories);
  // And other colours of the same.
  colors->SetNanColor(1., 1., 1.);
  const auto otherColors = scene.render();
  EXPECT_NE(otherColors, categories);
  colors->SetNanColor(nothing[0], nothing[1], nothing[2]);
  EXPECT_EQ(scene.render(), categories);
}

TEST_F(CategoryTest, idsBeyondFloatAndNamesOfNumbers)
{
  const auto data = grid();
  vtkDataArray* id = data->GetCellData()->GetArray("id");
  vtkNew<vtkTypeInt64Array> large;
  large->SetName("large");
  constexpr vtkTypeInt64 first = 16777216;
  for (vtkIdType i = 0; i < id->GetNumberOfTuples(); ++i)
  {
    large->InsertNextValue(first + static_cast<vtkTypeInt64>(id->GetTuple1(i)));
  }
  data->GetCellData()->AddArray(large);
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addCategories(scene, data);
  const auto small = scene.render();
  Scene::mapperOf(volume)->SelectScalarArray("large");
  vtkPiecewiseFunction* opacity = volume->GetProperty()->GetScalarOpacity(0);
  opacity->RemoveAllPoints();
  opacity->AddPoint(static_cast<double>(first), opacityOf(0.));
  opacity->AddPoint(static_cast<double>(first + ids - 1), opacityOf(ids - 1.));
  vtkColorTransferFunction* colors = volume->GetProperty()->GetRGBTransferFunction(0);
  colors->ResetAnnotations();
  for (const int number : listed)
  {
    colors->SetAnnotation(vtkVariant(first + number), "large");
  }
  EXPECT_EQ(scene.render(), small);
  // As texts.
  vtkNew<vtkStringArray> values;
  vtkNew<vtkStringArray> names;
  for (const int number : listed)
  {
    values->InsertNextValue(std::to_string(first + number));
    names->InsertNextValue("text");
  }
  colors->SetAnnotations(values, names);
  EXPECT_EQ(scene.render(), small);
}

TEST_F(CategoryTest, nothingIsListed)
{
  Scene scene;
  vtkVolume* volume = addCategories(scene, grid());
  vtkColorTransferFunction* colors = volume->GetProperty()->GetRGBTransferFunction(0);
  colors->ResetAnnotations();
  vtkPiecewiseFunction* opacity = volume->GetProperty()->GetScalarOpacity(0);
  opacity->RemoveAllPoints();
  opacity->AddPoint(0., 1.);
  expectPlane(scene, height, [](const Point&) { return nothing; });
  colors->RemoveAllPoints();
  expectPlane(scene, height, [](const Point&) { return nothing; });
}

TEST_F(CategoryTest, isosurfaceOfAnotherArray)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addSurface(scene, "z", height);
  mapper->SelectColorArray("id");
  const auto byCell = [](const Point& p) { return colorOf(idOf(centreOfCell(p))); };
  const auto colors = makeColors();
  list(colors);
  mapper->SetLookupTable(colors);
  expectPlane(scene, height, byCell);

  // VTK's other table.
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(static_cast<vtkIdType>(palette.size()));
  for (std::size_t i = 0; i < palette.size(); ++i)
  {
    table->SetTableValue(static_cast<vtkIdType>(i), palette[i][0], palette[i][1], palette[i][2]);
  }
  table->SetNanColor(nothing[0], nothing[1], nothing[2], 1.);
  list(table);
  mapper->SetLookupTable(table);
  expectPlane(scene, height, byCell);
}

TEST_F(CategoryTest, isosurfaceInCellsWithoutACategory)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addSurface(scene, "z", height);
  auto* const id = vtkDoubleArray::SafeDownCast(mapper->GetHyperTreeGrid()->GetCellData()->GetArray("id"));
  for (vtkIdType i = 0; i < id->GetNumberOfTuples(); ++i)
  {
    id->SetValue(i, id->GetValue(i) == 2. ? std::nan("") : id->GetValue(i));
  }
  mapper->SelectColorArray("id");
  const auto colors = makeColors();
  list(colors);
  mapper->SetLookupTable(colors);
  expectPlane(scene, height, [](const Point& p) {
    const int number = idOf(centreOfCell(p));
    return number == 2 ? nothing : colorOf(number);
  });
}

// A surface between two categories has the colours of the cells that it is seen in.
TEST_F(CategoryTest, isosurfaceOfItsOwnArray)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addSurface(scene, "z", height);
  mapper->SelectColorArray("z");
  const auto colors = makeColors();
  colors->IndexedLookupOn();
  colors->SetAnnotation(vtkVariant(0.25), "coarse"); // palette[0]
  colors->SetAnnotation(vtkVariant(0.3125), "fine"); // palette[1]
  mapper->SetLookupTable(colors);
  expectPlane(scene, height, [](const Point& p) {
    const double own = centreOfCell(p)[2];
    return own == 0.25 ? palette[0] : own == 0.3125 ? palette[1] : nothing;
  });
  colors->SetAnnotation(vtkVariant(height), "the surface"); // palette[2]
  expectPlane(scene, height, [](const Point&) { return palette[2]; });
}

// Of the interpolated values, in the colour of the isovalue.
TEST_F(CategoryTest, isosurfacesOfAVolume)
{
  Scene scene;
  scene.useFloatTarget();
  vtkVolume* volume = addCategories(scene, grid());
  vtkTreeAMRVolumeMapper* mapper = Scene::mapperOf(volume);
  mapper->SelectScalarArray("z");
  volume->GetProperty()->GetIsoSurfaceValues()->SetValue(0, height);
  vtkColorTransferFunction* colors = volume->GetProperty()->GetRGBTransferFunction(0);
  colors->ResetAnnotations();
  colors->SetAnnotation(vtkVariant(1.), "another");
  colors->SetAnnotation(vtkVariant(height), "the surface");
  // Opaque at the surface, which no cell has the value of.
  vtkPiecewiseFunction* opacity = volume->GetProperty()->GetScalarOpacity(0);
  opacity->RemoveAllPoints();
  opacity->AddPoint(height - 0.01, 0.);
  opacity->AddPoint(height, 1.);
  opacity->AddPoint(height + 0.01, 0.);
  const auto ofSurface = [](const Point&) { return palette[1]; };
  mapper->ShowIsosurfacesOn();
  expectPlane(scene, height, ofSurface);
  mapper->SetBlendModeToIsoSurface();
  expectPlane(scene, height, ofSurface);
  mapper->SetBlendModeToComposite();
  mapper->ShowIsosurfacesOff();
  expectPlane(scene, height, [](const Point&) { return background; });
}

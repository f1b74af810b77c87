// Colours of isosurfaces by arrays.
#include "PlaneSurface.h"

#include "vtkActorCollection.h"
#include "vtkCellData.h"
#include "vtkDiscretizableColorTransferFunction.h"
#include "vtkDoubleArray.h"
#include "vtkLookupTable.h"
#include "vtkMath.h"
#include "vtkPiecewiseFunction.h"
#include "vtkStringArray.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVariant.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace treeamr::test;

namespace
{

constexpr double eightBits = 1. / 255.;

class IsosurfaceColorTest : public PlaneSurfaceTest
{
protected:
  /// The surface coloured by `array`, unlit, and its pixels against colorOf(the point).
  template <class ColorOf>
  static void expectColors(Scene& scene, const ColorOf& colorOf, int atLeast = 150)
  {
    const auto pixels = scene.render();
    int compared = 0;
    for (int y = 0; y < scene.height(); ++y)
    {
      for (int x = 0; x < scene.width(); ++x)
      {
        const PixelRay ray = scene.ray(x, y);
        const Point p = ray.at(Scene::meet(ray, center, normal));
        Color expected;
        if (!isInside(p) || !colorOf(p, expected))
        {
          continue;
        }
        ++compared;
        for (int c = 0; c < 3; ++c)
        {
          // One entry of the table beside the expected one.
          ASSERT_NEAR(pixels[static_cast<std::size_t>(y) * scene.width() + x][c], expected[c], 3. * eightBits)
            << "channel " << c << " of pixel " << x << ", " << y;
        }
      }
    }
    EXPECT_GT(compared, atLeast);
  }

  static vtkSmartPointer<vtkLookupTable> makeTable(double min, double max)
  {
    auto table = vtkSmartPointer<vtkLookupTable>::New();
    table->SetHueRange(0.05, 0.6);
    table->SetTableRange(min, max);
    table->SetNanColor(0.2, 0.1, 0.7, 1.);
    table->Build();
    return table;
  }

  static vtkTreeAMRIsosurfaceMapper* addColored(Scene& scene, vtkHyperTreeGrid* grid, const char* array)
  {
    vtkActor* actor = scene.addIsosurface(grid, "plane", 0.);
    actor->GetProperty()->LightingOff();
    actor->GetProperty()->SetAmbient(0.);
    vtkTreeAMRIsosurfaceMapper* mapper = Scene::mapperOf(actor);
    mapper->ScalarVisibilityOn();
    mapper->SetScalarModeToUseCellFieldData();
    mapper->SelectColorArray(array);
    scene.setCamera();
    return mapper;
  }
};

} // namespace

TEST_F(IsosurfaceColorTest, anotherArray)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  const auto byTable = [&](const Point& p, Color& color) {
    table->GetColor(p[0], color.data());
    return true;
  };
  expectColors(scene, byTable);
  const vtkMTimeType built = mapper->GetSurfaceBuildTime();

  mapper->SelectColorArray(1);
  expectColors(scene, byTable);

  // The mapper's own range.
  mapper->UseLookupTableScalarRangeOff();
  mapper->SetScalarRange(-0.4, 0.3);
  expectColors(scene, byTable);
  EXPECT_EQ(table->GetRange()[0], -0.4);
  EXPECT_EQ(mapper->GetSurfaceBuildTime(), built);
}

TEST_F(IsosurfaceColorTest, withoutLights)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  vtkProperty* property = scene.renderer->GetActors()->GetLastActor()->GetProperty();
  property->LightingOn();
  property->SetAmbient(0.3);
  property->SetDiffuse(0.7);
  scene.renderer->SetAutomaticLightCreation(false);
  expectColors(scene, [&](const Point& p, Color& color) {
    table->GetColor(p[0], color.data());
    return true;
  });
}

TEST_F(IsosurfaceColorTest, activeScalars)
{
  Scene scene;
  const auto grid = planeGrid();
  grid->GetCellData()->SetActiveScalars("y");
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  mapper->SetScalarModeToUseCellData();
  const auto byTable = [&](const Point& p, Color& color) {
    table->GetColor(p[1], color.data());
    return true;
  };
  expectColors(scene, byTable);
  mapper->SetScalarModeToDefault();
  expectColors(scene, byTable);
}

TEST_F(IsosurfaceColorTest, theContouredArray)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "plane");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  expectColors(scene, [&](const Point&, Color& color) {
    table->GetColor(0., color.data());
    return true;
  });
}

TEST_F(IsosurfaceColorTest, theContouredArrayWithSeveralIsovalues)
{
  Scene scene;
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "plane");
  mapper->SetValue(0, -0.2);
  mapper->SetValue(1, 0.);
  mapper->SetValue(2, -0.5);
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  const auto color = [&](double value) {
    return [&table, value](const Point&, Color& expected) {
      table->GetColor(value, expected.data());
      return true;
    };
  };
  expectColors(scene, color(0.)); // the nearest
  mapper->SetValue(1, -0.6);
  mapper->SetValue(0, -0.7);
  mapper->SetValue(2, 0.);
  expectColors(scene, color(0.));
}

TEST_F(IsosurfaceColorTest, cellsWithoutAValue)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkDataArray* values = grid->GetCellData()->GetArray("x");
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
  {
    if (values->GetTuple1(i) > 0.25)
    {
      values->SetTuple1(i, std::numeric_limits<double>::quiet_NaN());
    }
  }
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
  const auto table = makeTable(-0.8, 0.9);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  int without = 0;
  expectColors(
    scene,
    [&](const Point& p, Color& color) {
      if (p[0] > 0.5)
      {
        ++without;
        std::copy(table->GetNanColor(), table->GetNanColor() + 3, color.begin());
        return true;
      }
      table->GetColor(p[0], color.data());
      return p[0] < -0.01;
    },
    100);
  EXPECT_GT(without, 20);
}

// Nowhere a value: the table's colour of NaN, as for a part of the cells.
TEST_F(IsosurfaceColorTest, noFiniteValue)
{
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<std::pair<double, std::string>> values{ { nan, "" },
    { 1e60, "within single precision, -3.40282e+38 to 3.40282e+38" },
    { -infinity, "no cell has a finite value" } };
  for (const auto& [value, warning] : values)
  {
    for (const bool categories : { false, true })
    {
      Scene scene;
      const auto grid = planeGrid();
      grid->GetCellData()->GetArray("x")->Fill(value);
      vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
      const auto table = makeTable(-0.8, 0.9);
      table->SetIndexedLookup(categories);
      mapper->SetLookupTable(table);
      mapper->UseLookupTableScalarRangeOn();
      MessageCounter messages(mapper);
      for (int frame = 0; frame < 2; ++frame)
      {
        expectColors(scene, [&](const Point&, Color& color) {
          std::copy(table->GetNanColor(), table->GetNanColor() + 3, color.begin());
          return true;
        });
      }
      EXPECT_TRUE(messages.errors.empty());
      ASSERT_EQ(messages.warnings.size(), warning.empty() ? 0u : 1u) << value;
      EXPECT_TRUE(warning.empty() || messages.warnings[0].find(warning) != std::string::npos)
        << messages.warnings[0];

      // Of what has no value there is no surface.
      mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "x");
      scene.render();
      ASSERT_EQ(messages.errors.size(), 1u);
      EXPECT_NE(
        messages.errors[0].find(warning.empty() ? "no cell has a finite value" : warning), std::string::npos)
        << messages.errors[0];
    }
  }
}

// As for one that does not exist.
TEST_F(IsosurfaceColorTest, unfitArrays)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkNew<vtkDoubleArray> tooShort;
  tooShort->SetName("short");
  tooShort->InsertNextValue(1.);
  vtkNew<vtkStringArray> strings;
  strings->SetName("strings");
  strings->SetNumberOfValues(grid->GetCellData()->GetArray("x")->GetNumberOfTuples());
  grid->GetCellData()->AddArray(tooShort);
  grid->GetCellData()->AddArray(strings);
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
  scene.renderer->GetActors()->GetLastActor()->GetProperty()->SetColor(0.2, 0.7, 0.4);
  for (const char* name : { "short", "strings", "missing" })
  {
    MessageCounter messages(mapper);
    mapper->SelectColorArray(name);
    for (int frame = 0; frame < 2; ++frame)
    {
      expectColors(scene, [&](const Point&, Color& color) {
        color = { 0.2, 0.7, 0.4 };
        return true;
      });
    }
    EXPECT_TRUE(messages.errors.empty()) << name;
    ASSERT_EQ(messages.warnings.size(), 1u) << name;
    EXPECT_NE(messages.warnings[0].find(std::string("'") + name + "'"), std::string::npos)
      << messages.warnings[0];
  }
}

// A translucent colour of NaN is one of the table's colours. Transfer functions have it where they use it: discretized.
TEST_F(IsosurfaceColorTest, opacityOfNaN)
{
  constexpr double background = 0.5;
  const Color ofNaN{ 0.2, 0.1, 0.7 };
  const auto grid = planeGrid();
  vtkDataArray* values = grid->GetCellData()->GetArray("x");
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
  {
    values->SetTuple1(i, values->GetTuple1(i) > 0.25 ? vtkMath::Nan() : 0.);
  }
  const auto expected = [&](double alpha) {
    return [&ofNaN, alpha](const Point& p, Color& color) {
      color = { 1., 0.6, 0.2 };
      for (int c = 0; c < 3 && p[0] > 0.5; ++c)
      {
        color[c] = alpha * ofNaN[c] + (1. - alpha) * background;
      }
      return p[0] > 0.5 || p[0] < -0.01;
    };
  };
  for (const bool peeling : { false, true })
  {
    Scene scene;
    scene.renderer->SetBackground(background, background, background);
    scene.renderer->SetUseDepthPeeling(peeling);
    vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
    vtkActor* actor = scene.renderer->GetActors()->GetLastActor();
    vtkNew<vtkDiscretizableColorTransferFunction> functions;
    functions->AddRGBPoint(-1., 1., 0.6, 0.2);
    functions->AddRGBPoint(1., 1., 0.6, 0.2);
    functions->SetNanColor(ofNaN.data());
    functions->DiscretizeOn();
    mapper->SetLookupTable(functions);
    mapper->UseLookupTableScalarRangeOn();
    EXPECT_TRUE(actor->HasOpaqueGeometry());
    expectColors(scene, expected(1.), 100);
    for (const double opacity : { 0.3, 0. })
    {
      functions->SetNanOpacity(opacity);
      EXPECT_TRUE(actor->HasTranslucentPolygonalGeometry());
      expectColors(scene, expected(opacity), 100);
    }
    functions->DiscretizeOff(); // VTK's colours of NaN are opaque then
    EXPECT_TRUE(actor->HasOpaqueGeometry());
    expectColors(scene, expected(1.), 100);

    vtkNew<vtkLookupTable> table;
    table->SetNumberOfTableValues(1);
    table->SetTableValue(0, 1., 0.6, 0.2);
    table->SetNanColor(ofNaN[0], ofNaN[1], ofNaN[2], 0.3);
    mapper->SetLookupTable(table);
    EXPECT_TRUE(actor->HasTranslucentPolygonalGeometry());
    expectColors(scene, expected(0.3), 100);

    // Of categories that it does not list, too.
    functions->DiscretizeOn();
    functions->IndexedLookupOn();
    functions->SetAnnotation(vtkVariant(0.), "zero");
    functions->SetNumberOfIndexedColors(1);
    functions->SetIndexedColor(0, 1., 0.6, 0.2);
    functions->SetNanOpacity(0.3);
    mapper->SetLookupTable(functions);
    EXPECT_TRUE(actor->HasTranslucentPolygonalGeometry());
    expectColors(scene, expected(0.3), 100);
    // Colours are none of the table's.
    mapper->SetColorModeToDirectScalars();
    EXPECT_TRUE(actor->HasOpaqueGeometry());
  }
}

TEST_F(IsosurfaceColorTest, componentsOfVectors)
{
  Scene scene;
  const auto grid = planeGrid();
  vtkCellData* cells = grid->GetCellData();
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("v");
  vectors->SetNumberOfComponents(3);
  for (vtkIdType i = 0; i < cells->GetArray("x")->GetNumberOfTuples(); ++i)
  {
    vectors->InsertNextTuple3(cells->GetArray("x")->GetTuple1(i), cells->GetArray("y")->GetTuple1(i), 0.);
  }
  cells->AddArray(vectors);
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "v");
  const auto table = makeTable(-0.8, 0.9);
  table->SetVectorModeToComponent();
  table->SetVectorComponent(1);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  const auto byY = [&](const Point& p, Color& color) {
    table->GetColor(p[1], color.data());
    return true;
  };
  expectColors(scene, byY);
  table->SetVectorModeToMagnitude();
  mapper->ColorByArrayComponent("v", 1);
  expectColors(scene, byY);
}

// As VTK decides for polygons: in the translucent pass, once any entry of the table is translucent.
TEST_F(IsosurfaceColorTest, opacitiesOfTheLookupTable)
{
  constexpr double background = 0.5;
  const auto over = [](Color& color, double alpha) {
    for (double& channel : color)
    {
      channel = alpha * channel + (1. - alpha) * background;
    }
  };
  for (const bool peeling : { false, true })
  {
    Scene scene;
    scene.renderer->SetBackground(background, background, background);
    scene.renderer->SetUseDepthPeeling(peeling);
    vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, planeGrid(), "x");
    vtkActor* actor = scene.renderer->GetActors()->GetLastActor();
    const auto table = makeTable(-0.8, 0.9);
    mapper->SetLookupTable(table);
    mapper->UseLookupTableScalarRangeOn();
    EXPECT_TRUE(actor->HasOpaqueGeometry());
    table->SetAlphaRange(0.1, 0.9);
    table->ForceBuild();
    EXPECT_FALSE(actor->HasOpaqueGeometry());
    EXPECT_TRUE(actor->HasTranslucentPolygonalGeometry());
    expectColors(scene, [&](const Point& p, Color& color) {
      table->GetColor(p[0], color.data());
      over(color, table->GetOpacity(p[0]));
      return true;
    });
    actor->GetProperty()->SetOpacity(0.5);
    expectColors(scene, [&](const Point& p, Color& color) {
      table->GetColor(p[0], color.data());
      over(color, 0.5 * table->GetOpacity(p[0]));
      return true;
    });
    actor->GetProperty()->SetOpacity(1.);

    // ParaView's tables: opacity mapping off, then on; by another array, then by that of the surfaces.
    vtkNew<vtkDiscretizableColorTransferFunction> functions;
    functions->AddRGBPoint(-1., 1., 0., 0.2);
    functions->AddRGBPoint(1., 0.2, 1., 0.4);
    vtkNew<vtkPiecewiseFunction> opacity;
    opacity->AddPoint(-1., 0.);
    opacity->AddPoint(1., 0.8);
    functions->SetScalarOpacityFunction(opacity);
    functions->DiscretizeOff();
    functions->Build();
    mapper->SetLookupTable(functions);
    EXPECT_TRUE(actor->HasOpaqueGeometry());
    expectColors(scene, [&](const Point& p, Color& color) {
      functions->GetColor(p[0], color.data());
      return true;
    });
    functions->EnableOpacityMappingOn();
    EXPECT_FALSE(actor->HasOpaqueGeometry());
    expectColors(scene, [&](const Point& p, Color& color) {
      functions->GetColor(p[0], color.data());
      over(color, opacity->GetValue(p[0]));
      return true;
    });
    mapper->SelectColorArray("plane");
    expectColors(scene, [&](const Point&, Color& color) {
      functions->GetColor(0., color.data());
      over(color, opacity->GetValue(0.));
      return true;
    });
    mapper->ScalarVisibilityOff();
    EXPECT_TRUE(actor->HasOpaqueGeometry());
  }
}

// Arrays that are colours themselves, with an opacity or without.
TEST_F(IsosurfaceColorTest, directColors)
{
  const auto channel = [](const Point& p, int c) {
    return std::array<double, 4>{ 0.5 + 0.4 * p[0], 0.5 - 0.3 * p[1], 0.3, 0.6 + 0.2 * p[0] }[c];
  };
  for (const bool real : { false, true })
  {
    for (const int components : { 1, 2, 3, 4 })
    {
      const auto grid = planeGrid();
      vtkCellData* cells = grid->GetCellData();
      vtkSmartPointer<vtkDataArray> colors;
      if (real)
      {
        colors = vtkSmartPointer<vtkDoubleArray>::New();
      }
      else
      {
        colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
      }
      colors->SetName("colors");
      colors->SetNumberOfComponents(components);
      const auto ofComponent = [&](int c) { return components == 2 && c == 1 ? 3 : c; };
      const vtkIdType count = cells->GetArray("x")->GetNumberOfTuples();
      colors->SetNumberOfTuples(count);
      for (vtkIdType i = 0; i < count; ++i)
      {
        const Point p{ cells->GetArray("x")->GetTuple1(i), cells->GetArray("y")->GetTuple1(i), 0. };
        for (int c = 0; c < components; ++c)
        {
          const double value = channel(p, ofComponent(c));
          colors->SetComponent(i, c, real ? value : std::round(255. * value));
        }
      }
      cells->AddArray(colors);
      Scene scene;
      vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "colors");
      vtkActor* actor = scene.renderer->GetActors()->GetLastActor();
      const auto direct = [&](const Point& p, Color& color) {
        for (int c = 0; c < 3; ++c)
        {
          const double alpha = components % 2 == 0 ? channel(p, 3) : 1.;
          color[c] = alpha * channel(p, components < 3 ? 0 : c);
        }
        return true;
      };
      if (real)
      {
        mapper->SetColorModeToDirectScalars();
      }
      EXPECT_EQ(actor->HasTranslucentPolygonalGeometry() != 0, components % 2 == 0);
      expectColors(scene, direct);

      // By the table, whatever they are.
      vtkNew<vtkLookupTable> table; // gray: a value of integers is one step
      table->SetSaturationRange(0., 0.);
      table->SetValueRange(0., 1.);
      table->SetTableRange(0., real ? 1. : 255.);
      table->Build();
      table->SetVectorModeToComponent();
      table->SetVectorComponent(0);
      mapper->SetLookupTable(table);
      mapper->UseLookupTableScalarRangeOn();
      mapper->SetColorModeToMapScalars();
      EXPECT_TRUE(actor->HasOpaqueGeometry());
      expectColors(scene, [&](const Point& p, Color& color) {
        table->GetColor((real ? 1. : 255.) * channel(p, 0), color.data());
        return true;
      });
    }
  }
}

// An array may bring its own table.
TEST_F(IsosurfaceColorTest, tableOfTheArray)
{
  Scene scene;
  const auto grid = planeGrid();
  const auto table = makeTable(-0.8, 0.9);
  grid->GetCellData()->GetArray("x")->SetLookupTable(table);
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "x");
  mapper->UseLookupTableScalarRangeOn();
  expectColors(scene, [&](const Point& p, Color& color) {
    table->GetColor(p[0], color.data());
    return true;
  });
  EXPECT_EQ(mapper->GetLookupTable(), table);
}

// A table whose entries meet at the isovalue or beside it: all points of the surface have the one colour that the table
// has there, in double.
TEST_F(IsosurfaceColorTest, fewTableValuesOfTheContouredArray)
{
  constexpr double isovalue = -0.3; // as float it lies below
  Scene scene;
  const auto grid = planeGrid();
  vtkCellData* cells = grid->GetCellData();
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetName("v");
  vectors->SetNumberOfComponents(2);
  for (vtkIdType i = 0; i < cells->GetArray("plane")->GetNumberOfTuples(); ++i)
  {
    vectors->InsertNextTuple2(0., cells->GetArray("plane")->GetTuple1(i));
  }
  cells->AddArray(vectors);
  cells->SetActiveScalars("plane");
  vtkTreeAMRIsosurfaceMapper* mapper = addColored(scene, grid, "plane");
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(2);
  table->SetTableRange(isovalue - 1., isovalue + 1.);
  table->SetTableValue(0, 1., 0., 0.);
  table->SetTableValue(1, 0., 0., 1.);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  const auto expectOneColor = [&](double value) {
    mapper->SetValue(0, value);
    Color expected;
    table->GetColor(value, expected.data());
    int compared = 0;
    for (const auto& pixel : scene.render())
    {
      if (pixel[0] + pixel[2] > 0.01) // the background is black
      {
        ++compared;
        ASSERT_NEAR(pixel[0], expected[0], eightBits / 2.);
        ASSERT_NEAR(pixel[2], expected[2], eightBits / 2.);
      }
    }
    EXPECT_GT(compared, 150);
  };
  ASSERT_NE(table->GetIndex(isovalue), table->GetIndex(static_cast<float>(isovalue)));
  const auto expectIt = [&] {
    expectOneColor(isovalue);
    expectOneColor(std::nextafter(isovalue, -1.));
  };
  expectIt();
  for (const int component : { -1, 0, 1 }) // of one there is
  {
    mapper->ColorByArrayComponent("plane", component);
    expectIt();
    mapper->ColorByArrayComponent(0, component);
    expectIt();
    mapper->SetIsosurfaceComponent(component > 0 ? 0 : component);
    expectIt();
  }
  mapper->SetIsosurfaceComponent(-1);
  mapper->SetScalarModeToUseCellData(); // the active scalars
  expectIt();
  table->SetVectorModeToComponent();
  expectIt();

  // Components and magnitudes of vectors; the magnitude of (0, f) is |f|.
  mapper->SetScalarModeToUseCellFieldData();
  mapper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "v");
  mapper->SetIsosurfaceComponent(1);
  mapper->ColorByArrayComponent("v", 1);
  expectIt();
  mapper->ColorByArrayComponent("v", -1);
  table->SetVectorComponent(1);
  expectIt();
  mapper->SetIsosurfaceComponent(-1);
  table->SetVectorModeToMagnitude();
  table->SetTableRange(-isovalue - 1., -isovalue + 1.);
  expectOneColor(-isovalue);
  mapper->SetIsosurfaceComponent(-2);
  expectOneColor(std::nextafter(-isovalue, 0.));
}

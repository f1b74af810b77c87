// The scene that ConventionImageTest changes: two hills of a field, finer where it is larger.
#pragma once

#include "RenderingScene.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkDoubleArray.h"
#include "vtkImageData.h"
#include "vtkLight.h"
#include "vtkPiecewiseFunction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace treeamr::test
{

class ConventionStage
{
public:
  static constexpr double unitDistance = 0.25;

  ConventionStage()
    : volume(addVolume())
  {
    scene.renderer->SetBackground(0.32, 0.34, 0.43);
    scene.setCamera();
    scene.renderer->GetActiveCamera()->Zoom(1.3);
    scene.window->Render(); // which makes the headlight
  }

  vtkTreeAMRVolumeMapper* mapper() { return Scene::mapperOf(volume); }
  vtkVolumeProperty* property() { return volume->GetProperty(); }

  vtkVolume* addVolume()
  {
    vtkVolume* added = scene.addVolume(grid(), "hills", { 1., 1., 1. }, 1.);
    vtkNew<vtkColorTransferFunction> colors;
    colors->AddRGBPoint(0., 0.1, 0.3, 0.9);
    colors->AddRGBPoint(0.5, 0.9, 0.9, 0.7);
    colors->AddRGBPoint(1., 0.8, 0.2, 0.1);
    vtkNew<vtkPiecewiseFunction> opacities;
    opacities->AddPoint(0.15, 0.);
    opacities->AddPoint(0.5, 0.2);
    opacities->AddPoint(1., 0.6);
    added->GetProperty()->SetColor(colors);
    added->GetProperty()->SetScalarOpacity(opacities);
    added->GetProperty()->SetScalarOpacityUnitDistance(unitDistance);
    return added;
  }

  static void colorGreen(vtkVolume* volume)
  {
    vtkNew<vtkColorTransferFunction> colors;
    colors->AddRGBPoint(0., 0.1, 0.6, 0.2);
    colors->AddRGBPoint(1., 0.8, 1., 0.2);
    volume->GetProperty()->SetColor(colors);
  }

  /// In place of the headlight.
  vtkLight* addLight(const Point& position, const Color& color)
  {
    if (lights.empty())
    {
      scene.renderer->RemoveAllLights();
    }
    vtkNew<vtkLight> light;
    light->SetLightTypeToSceneLight();
    light->SetPosition(position[0], position[1], position[2]);
    light->SetColor(color[0], color[1], color[2]);
    scene.renderer->AddLight(light);
    lights.push_back(light);
    return light;
  }

  /// A transfer function of two values, opaque in stripes.
  static vtkSmartPointer<vtkImageData> makeTable(int stripes)
  {
    constexpr int size = 128;
    auto table = vtkSmartPointer<vtkImageData>::New();
    table->SetDimensions(size, size, 1);
    table->AllocateScalars(VTK_FLOAT, 4);
    auto* pixels = static_cast<float*>(table->GetScalarPointer());
    for (int row = 0; row < size; ++row)
    {
      for (int column = 0; column < size; ++column)
      {
        const float u = static_cast<float>(column) / (size - 1);
        const float v = static_cast<float>(row) / (size - 1);
        *pixels++ = u;
        *pixels++ = v;
        *pixels++ = 1.f - u;
        *pixels++ = u * (0.3f + 0.3f * std::cos(6.f * static_cast<float>(stripes) * (u - 0.7f * v - 0.5f)));
      }
    }
    return table;
  }

  Scene scene{ 90, 90 };
  std::vector<vtkLight*> lights;
  vtkVolume* volume;

private:
  static double hills(const Point& p)
  {
    const auto hill = [&](const Point& top, double slope) {
      double squared = 0.;
      for (int a = 0; a < 3; ++a)
      {
        squared += (p[a] - top[a]) * (p[a] - top[a]);
      }
      return std::exp(-slope * squared);
    };
    return std::min(1., hill({ 0.35, 0.2, 0.1 }, 2.5) + 0.7 * hill({ -0.5, -0.4, 0.4 }, 7.));
  }
  static double waves(const Point& p)
  {
    return 0.5 + 0.5 * std::sin(3. * p[0] - 2. * p[2]) * std::cos(2. * p[1]);
  }

  static vtkHyperTreeGrid* grid()
  {
    static const vtkSmartPointer<vtkHyperTreeGrid> made = makeGrid();
    return made;
  }
  static vtkSmartPointer<vtkHyperTreeGrid> makeGrid()
  {
    GridOptions options;
    options.refine = [](const Point& p, int level) { return level < 2 || (level < 4 && hills(p) > 0.3); };
    auto grid = treeamr::test::makeGrid(options,
      { { "hills", hills }, { "waves", waves },
        { "class", [](const Point& p) { return std::floor(2.99 * waves(p)); } } });
    vtkCellData* cells = grid->GetCellData();
    const auto addArray = [&](const char* name, int count) {
      vtkNew<vtkDoubleArray> array;
      array->SetName(name);
      array->SetNumberOfComponents(count);
      for (vtkIdType i = 0; i < cells->GetArray("hills")->GetNumberOfTuples(); ++i)
      {
        const double hill = cells->GetArray("hills")->GetTuple1(i);
        const double wave = cells->GetArray("waves")->GetTuple1(i);
        std::array<double, 4> values{ wave, 1. - wave * hill, std::sqrt(hill), hill };
        values[count - 1] = hill;
        array->InsertNextTuple(values.data());
      }
      cells->AddArray(array);
    };
    addArray("pair", 2);
    addArray("triple", 3);
    addArray("rgba", 4);
    return grid;
  }
};

} // namespace treeamr::test

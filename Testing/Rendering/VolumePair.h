// The same uniform grid as a volume of ours and of VTK's GPU mapper.
#pragma once

#include "RenderingScene.h"

#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkDoubleArray.h"
#include "vtkGPUVolumeRayCastMapper.h"
#include "vtkImageData.h"
#include "vtkPiecewiseFunction.h"
#include "vtkTransform.h"
#include "vtkVersionMacros.h"
#include "vtkVolumeMapper.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace treeamr::test
{

/// Of VTK 9.1's volume mapper the highlights are powers of the normal's cosine to the view, or to halves between light and a
/// view from a mirrored point, of the last light alone; and a headlight lights the other side than the same light of the scene.
/// What ours are, VolumeEffectsTest has: slicesOfLinearFieldsAreLitByPhongsModel.
constexpr bool vtkHasPhongsHighlights = VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0);

/// Waves that a smooth opacity function shows.
inline double wave(const Point& p)
{
  return 0.5 + 0.5 * std::sin(4. * p[0] + 1.) * std::cos(3. * p[1] - p[2]) * std::cos(2.5 * p[2]);
}

/// In [0, 1], too.
inline double otherWave(const Point& p)
{
  return 0.5 + 0.5 * std::sin(2. * p[0] - 3. * p[2]) * std::cos(p[1]);
}

inline void setWaveColors(vtkVolumeProperty* property)
{
  vtkNew<vtkColorTransferFunction> colors;
  colors->AddRGBPoint(0., 0.1, 0.3, 0.9);
  colors->AddRGBPoint(0.5, 0.9, 0.9, 0.7);
  colors->AddRGBPoint(1., 0.8, 0.2, 0.1);
  vtkNew<vtkPiecewiseFunction> opacities;
  opacities->AddPoint(0., 0.);
  opacities->AddPoint(0.4, 0.02);
  opacities->AddPoint(1., 0.6);
  property->SetColor(colors);
  property->SetScalarOpacity(opacities);
  property->SetScalarOpacityUnitDistance(0.2);
  property->SetInterpolationTypeToLinear();
}

/// The same volume by both mappers.
class VolumePair
{
public:
  VolumePair()
  {
    constexpr int cells = 64;
    GridOptions options;
    options.roots = { 1, 1, 1 };
    options.refine = [](const Point&, int level) { return level < 6; };
    grid_ = makeGrid(options, { { "wave", wave }, { "other", otherWave } });
    ours_ = scene.addVolume(grid_, "wave", { 1., 1., 1. }, 1.);
    setWaveColors(ours_->GetProperty());
    Scene::mapperOf(ours_)->SetSamplesPerCell(4.);
    vtkImageData* image = image_;
    image->SetDimensions(cells + 1, cells + 1, cells + 1);
    image->SetOrigin(-1., -1., -1.);
    image->SetSpacing(2. / cells, 2. / cells, 2. / cells);
    vtkNew<vtkDoubleArray> values;
    values->SetName("wave");
    vtkNew<vtkDoubleArray> others;
    others->SetName("other");
    for (int i = 0; i < cells * cells * cells; ++i)
    {
      const std::array<int, 3> at{ i % cells, i / cells % cells, i / cells / cells };
      Point p;
      for (int a = 0; a < 3; ++a)
      {
        p[a] = -1. + 2. * (at[a] + 0.5) / cells;
      }
      values->InsertNextValue(wave(p));
      others->InsertNextValue(otherWave(p));
    }
    image->GetCellData()->SetScalars(values);
    image->GetCellData()->AddArray(others);
    theirMapper_->SetInputData(image);
    theirMapper_->AutoAdjustSampleDistancesOff();
    theirMapper_->SetSampleDistance(0.005f);
    theirs_->SetMapper(theirMapper_);
    theirs_->SetProperty(ours_->GetProperty());
    scene.renderer->AddVolume(theirs_);
    scene.setCamera();
  }

  /// Draws an array of two dependent components: the other waves, which colour, and the waves.
  void usePairs()
  {
    useComponents("pair", 2);
    property()->IndependentComponentsOff();
  }
  /// Draws an array of two to four: the other waves first, and last the waves.
  void useComponents(const char* name, int count)
  {
    for (vtkCellData* cells : { grid_->GetCellData(), image_->GetCellData() })
    {
      vtkNew<vtkDoubleArray> array;
      array->SetName(name);
      array->SetNumberOfComponents(count);
      for (vtkIdType i = 0; i < cells->GetArray("wave")->GetNumberOfTuples(); ++i)
      {
        const double wave = cells->GetArray("wave")->GetTuple1(i);
        const double other = cells->GetArray("other")->GetTuple1(i);
        std::array<double, 4> values{ other, 1. - wave * other, std::sqrt(other), wave };
        values[count - 1] = wave;
        array->InsertNextTuple(values.data());
      }
      cells->SetScalars(array);
    }
    mapper()->SelectScalarArray(name);
  }

  void move(vtkTransform* transform)
  {
    ours_->SetUserTransform(transform);
    theirs_->SetUserTransform(transform);
  }

  /// Mean over the pixels that one of the two draws, of 255. set: is called with each of the two mappers.
  template <class Set>
  double difference(const Set& set)
  {
    std::array<std::vector<std::array<float, 4>>, 2> pictures;
    for (int i = 0; i < 2; ++i)
    {
      ours_->SetVisibility(i == 0);
      theirs_->SetVisibility(i == 1);
      if (VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 2, 0))
      {
        theirMapper_->Modified(); // else VTK 9.1 draws other lights by the shader that it made for those before
      }
      set(vtkVolumeMapper::SafeDownCast((i == 0 ? ours_ : theirs_.Get())->GetMapper()));
      pictures[i] = scene.render();
    }
    double sum = 0.;
    int drawn = 0;
    for (std::size_t p = 0; p < pictures[0].size(); ++p)
    {
      if (pictures[0][p][3] > 0.f || pictures[1][p][3] > 0.f)
      {
        ++drawn;
        for (int c = 0; c < 3; ++c)
        {
          sum += std::abs(pictures[0][p][c] - pictures[1][p][c]) / 3.;
        }
      }
    }
    EXPECT_GT(drawn, 100);
    return 255. * sum / std::max(1, drawn);
  }

  double difference()
  {
    return difference([](vtkVolumeMapper* /*mapper*/) {});
  }

  void showOurs()
  {
    ours_->VisibilityOn();
    theirs_->VisibilityOff();
  }
  vtkVolumeProperty* property() { return ours_->GetProperty(); }
  vtkTreeAMRVolumeMapper* mapper() { return Scene::mapperOf(ours_); }

  Scene scene{ 120, 100 };

private:
  vtkSmartPointer<vtkHyperTreeGrid> grid_;
  vtkNew<vtkImageData> image_;
  vtkVolume* ours_;
  vtkNew<vtkVolume> theirs_;
  vtkNew<vtkGPUVolumeRayCastMapper> theirMapper_;
};

} // namespace treeamr::test

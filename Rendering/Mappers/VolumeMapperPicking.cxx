// What pickers and selections find of a volume.
#include "LinePick.h"
#include "SceneConversion.h"
#include "SurfaceSelection.h"
#include "VolumeMapperInternals.h"
#include "vtkTreeAMRDepthReader.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkHardwareSelector.h"
#include "vtkHyperTreeGrid.h"
#include "vtkPiecewiseFunction.h"
#include "vtkRenderer.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include <cmath>
#include <exception>
#include <memory>
#include <utility>

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRVolumeMapper::IntersectWithLine(vtkVolume* volume, const double p1[3], const double p2[3],
  double t1, double t2, double opacity, double& t, double normal[3], double& value)
{
  using Method = treeamr::InterpolationMethod;
  Internals& internals = *this->Private;
  try
  {
    this->UpdateField(volume);
    if (internals.ReadsTable)
    {
      this->UpdateVolume(volume);
    }
    const bool isByNumber = internals.Categories != nullptr;
    const bool isNearest =
      isByNumber || volume->GetProperty()->GetInterpolationType() == VTK_NEAREST_INTERPOLATION;
    const Method method = isNearest ? Method::Nearest : Method::GTI;
    const std::shared_ptr<const treeamr::Field>& opaque =
      internals.OpacityField ? internals.OpacityField : internals.Field;
    const auto valueOf = [&](double found) {
      return isByNumber ? internals.Categories->values->GetTuple1(static_cast<vtkIdType>(found)) : found;
    };
    const auto opacityOf = [&](double found) {
      return internals.ReadsTable
        ? -std::expm1(-volume->GetProperty()->GetScalarOpacityUnitDistance() *
            internals.Volume->transferFunction().at(static_cast<float>(found - opaque->offset())).extinction)
        : volume->GetProperty()->GetScalarOpacity()->GetValue(valueOf(found));
    };
    treeamr::DataCut cut;
    cut.cropping = treeamr::convertCropping(this);
    const treeamr::PickLine line = treeamr::pickLine(p1, p2, t1, t2);
    const auto sampler = treeamr::Sampler::create(method, opaque);
    auto pick = treeamr::pickVolume(*sampler, opaque->octree(), line, cut, opacityOf, opacity);
    if (!pick)
    {
      return -1;
    }
    if (treeamr::FieldSample drawn; internals.OpacityField &&
        treeamr::Sampler::create(method, internals.Field)->sample(treeamr::pointAt(line.ray, pick->t), drawn))
    {
      pick->value = drawn.value;
    }
    pick->value = valueOf(pick->value);
    return treeamr::tell(*pick, this->GetHyperTreeGrid(), t, normal, value);
  }
  catch (const std::exception& error)
  {
    internals.Messages.error(error);
    return -1;
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeMapper::SelectProp(vtkRenderer* renderer, vtkVolume* volume)
{
  Internals& internals = *this->Private;
  const treeamr::VolumeFrame last = internals.CurrentFrame; // which a selection is none of
  try
  {
    treeamr::DataCut cut = treeamr::cutOf(this, volume);
    cut.cropping = treeamr::convertCropping(this);
    Picture picture{ renderer, volume, vtkTreeAMRTarget::GetViewport(renderer), false, false,
      this->PrepareVolume(renderer, volume), std::move(cut),
      { renderer, {}, treeamr::SurfaceLayers::All, nullptr }, nullptr, nullptr, {} };
    if (!picture.HasVolume)
    {
      return;
    }
    this->StartFrame(picture);
    vtkTreeAMRRaySegments segments;
    vtkTreeAMRDepthReader::Read(renderer, picture.Viewport, segments.End);
    vtkTreeAMRRayImage image = this->Trace(picture, segments);
    vtkHardwareSelector* selector = renderer->GetSelector();
    const treeamr::SelectedProp selected(selector);
    float color[3];
    selector->GetPropColorValue(color);
    constexpr float seen = 0.5f / 255.f;
    for (std::size_t i = 0; i < image.Image.rgba.size(); i += 4)
    {
      const float alpha = image.Image.rgba[i + 3] >= seen ? 1.f : 0.f;
      for (int c = 0; c < 3; ++c)
      {
        image.Image.rgba[i + c] = alpha * color[c];
      }
      image.Image.rgba[i + 3] = alpha;
    }
    internals.Painter.DrawOver(renderer, image);
  }
  catch (const std::exception& error)
  {
    internals.Messages.error(error);
  }
  internals.CurrentFrame = last;
}

#include "vtkTreeAMRIsosurfaceMapper.h"

#include "MapperInput.h"
#include "SceneConversion.h"
#include "SurfaceShading.h"
#include "vtkTreeAMRFramebuffer.h"

#include "Error.h"
#include "RayTracing/Isosurface.h"

#include "vtkActor.h"
#include "vtkCamera.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkHardwareSelector.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPlaneCollection.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkScalarsToColors.h"
#include "vtkSmartPointer.h"
#include "vtkTimerLog.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <array>
#include <optional>

vtkStandardNewMacro(vtkTreeAMRIsosurfaceMapper);

//------------------------------------------------------------------------------
struct vtkTreeAMRIsosurfaceMapper::Internals
{
  vtkTreeAMRFramebuffer Framebuffer;
  treeamr::FieldSlot ContourSlot;
  treeamr::FieldSlot ColorSlot;
  treeamr::BoundsSlot BoundsSlot;
  treeamr::OnceReporter Errors;
  treeamr::OnceReporter Warnings;

  std::shared_ptr<const treeamr::Field> Field;
  std::unique_ptr<treeamr::Isosurface> Surface; // of this field
  treeamr::ArraySelection Contoured;
  vtkTimeStamp SurfaceTime;

  // Passes of one frame (depth peeling, selection) and changes of colour draw the same hits again.
  std::optional<treeamr::Camera> Camera;
  treeamr::Matrix4 ClipFromData{};
  treeamr::Matrix4 WorldFromData{};
  vtkTreeAMRViewport Viewport;
  vtkMTimeType SurfaceTimeOfHits = 0;
  treeamr::HitImage Hits;
  vtkTreeAMRSurfaceImage Image;

  /// RGBA of each hit; null: the solid colour.
  vtkSmartPointer<vtkUnsignedCharArray> MapColors(vtkTreeAMRIsosurfaceMapper* self, vtkHyperTreeGrid* grid);
  void PlaceForAmbientOcclusion(vtkRenderer* renderer, vtkActor* actor);
};

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceMapper::vtkTreeAMRIsosurfaceMapper()
  : Private(std::make_unique<Internals>())
{
}

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceMapper::~vtkTreeAMRIsosurfaceMapper() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Isovalue: " << this->Isovalue << endl;
  os << indent << "IsosurfaceComponent: " << this->IsosurfaceComponent << endl;
  os << indent << "CompositeIndex: " << this->CompositeIndex << endl;
  os << indent << "NumberOfPrimitives: " << this->GetNumberOfPrimitives() << endl;
}

//------------------------------------------------------------------------------
int vtkTreeAMRIsosurfaceMapper::FillInputPortInformation(int vtkNotUsed(port), vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkHyperTreeGrid");
  return 1;
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetInputData(vtkHyperTreeGrid* grid)
{
  this->SetInputDataInternal(0, grid);
}

//------------------------------------------------------------------------------
vtkHyperTreeGrid* vtkTreeAMRIsosurfaceMapper::GetHyperTreeGrid()
{
  return this->GetNumberOfInputConnections(0) < 1
    ? nullptr
    : vtkHyperTreeGrid::SafeDownCast(this->GetExecutive()->GetInputData(0, 0));
}

//------------------------------------------------------------------------------
vtkHyperTreeGrid* vtkTreeAMRIsosurfaceMapper::UpdateInput()
{
  if (this->GetNumberOfInputConnections(0) > 0 && !this->Static)
  {
    this->Update();
  }
  return this->GetHyperTreeGrid();
}

//------------------------------------------------------------------------------
double* vtkTreeAMRIsosurfaceMapper::GetBounds()
{
  this->Private->BoundsSlot.get(this->UpdateInput(), this->Bounds);
  return this->Bounds;
}

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRIsosurfaceMapper::GetNumberOfPrimitives()
{
  return this->Private->Surface ? static_cast<vtkIdType>(this->Private->Surface->statistics().octants) : 0;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRIsosurfaceMapper::GetSurfaceBuildTime()
{
  return this->Private->SurfaceTime.GetMTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Warn(const std::string& message)
{
  if (this->Private->Warnings.isNews(message, this->GetMTime()))
  {
    vtkWarningMacro(<< message);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::UpdateSurface(vtkHyperTreeGrid* grid)
{
  if (!grid)
  {
    throw treeamr::Error("isosurface mapper: no input, needed is a vtkHyperTreeGrid");
  }
  treeamr::ArraySelection contoured;
  vtkInformation* array = this->GetInputArrayInformation(0);
  const char* name = array->Get(vtkDataObject::FIELD_NAME());
  contoured.name = name && *name ? name : treeamr::defaultCellArrayName(grid);
  contoured.component = this->IsosurfaceComponent;

  Internals& internals = *this->Private;
  const std::shared_ptr<const treeamr::Field>& field = internals.ContourSlot.acquire(grid, contoured, true);
  if (!internals.Surface || internals.Field != field ||
    internals.Surface->isovalues().front() != this->Isovalue)
  {
    internals.Surface = std::make_unique<treeamr::Isosurface>(field, std::vector<double>{ this->Isovalue });
    internals.Field = field;
    internals.SurfaceTime.Modified();
  }
  internals.Contoured = contoured;
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::UpdateHits(vtkRenderer* renderer, vtkActor* actor)
{
  Internals& internals = *this->Private;
  internals.Viewport = vtkTreeAMRFramebuffer::GetViewport(renderer);
  const treeamr::Matrix4 clipFromData = treeamr::clipFromData(renderer, actor);
  const treeamr::Matrix4 worldFromData = treeamr::worldFromData(actor);
  if (internals.Camera && internals.Camera->width() == internals.Viewport.Width &&
    internals.Camera->height() == internals.Viewport.Height && internals.ClipFromData == clipFromData &&
    internals.WorldFromData == worldFromData &&
    internals.SurfaceTimeOfHits == internals.SurfaceTime.GetMTime())
  {
    return;
  }
  internals.Camera.reset();
  internals.ClipFromData = clipFromData;
  internals.WorldFromData = worldFromData;
  const treeamr::Camera camera(
    clipFromData, worldFromData, internals.Viewport.Width, internals.Viewport.Height);
  internals.Surface->startFrame();
  internals.Surface->render(camera, treeamr::SurfaceLayers::Nearest, internals.Hits);
  internals.SurfaceTimeOfHits = internals.SurfaceTime.GetMTime();
  internals.Camera = camera;
}

//------------------------------------------------------------------------------
vtkSmartPointer<vtkUnsignedCharArray> vtkTreeAMRIsosurfaceMapper::Internals::MapColors(
  vtkTreeAMRIsosurfaceMapper* self, vtkHyperTreeGrid* grid)
{
  if (!self->ScalarVisibility)
  {
    return nullptr;
  }
  treeamr::ArraySelection selection;
  try
  {
    vtkDataArray* active = grid->GetCellData()->GetScalars();
    selection.name = treeamr::selectedCellArrayName(grid, self->ScalarMode, self->ArrayAccessMode,
      self->ArrayId, self->ArrayName, active && active->GetName() ? active->GetName() : "");
  }
  catch (const treeamr::Error& error)
  {
    self->Warn(error.what());
  }
  vtkDataArray* array =
    selection.name.empty() ? nullptr : grid->GetCellData()->GetArray(selection.name.c_str());
  if (!array)
  {
    return nullptr;
  }

  vtkScalarsToColors* table = self->GetLookupTable();
  if (self->ArrayComponent >= 0)
  {
    selection.component = self->ArrayComponent;
  }
  else if (table->GetVectorMode() == vtkScalarsToColors::COMPONENT)
  {
    selection.component = table->GetVectorComponent();
  }
  // As vtkMapper does for components that the array has not.
  if (selection.component >= array->GetNumberOfComponents())
  {
    selection.component = 0;
  }
  if (array->GetNumberOfComponents() == 1)
  {
    selection.component = -1;
  }

  std::vector<float> values;
  if (selection.name == this->Contoured.name && selection.component == this->Contoured.component)
  {
    for (const treeamr::SurfaceHit& hit : this->Hits.hits)
    {
      values.push_back(static_cast<float>(this->Surface->isovalues()[hit.surface]));
    }
  }
  else
  {
    values =
      treeamr::valuesAtHits(this->ColorSlot.acquire(grid, selection, false), *this->Camera, this->Hits);
  }
  vtkNew<vtkFloatArray> scalars;
  scalars->SetArray(values.data(), static_cast<vtkIdType>(values.size()), 1); // 1: stays ours

  if (!self->UseLookupTableScalarRange)
  {
    table->SetRange(self->ScalarRange);
  }
  table->Build();
  return vtkSmartPointer<vtkUnsignedCharArray>::Take(
    table->MapScalars(scalars, VTK_COLOR_MODE_MAP_SCALARS, 0, VTK_RGBA));
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Internals::PlaceForAmbientOcclusion(vtkRenderer* renderer, vtkActor* actor)
{
  if (vtkTreeAMRFramebuffer::WantsGeometry(actor))
  {
    vtkNew<vtkMatrix4x4> matrix;
    actor->GetMatrix(matrix);
    vtkMatrix4x4::Multiply4x4(renderer->GetActiveCamera()->GetViewTransformMatrix(), matrix, matrix);
    treeamr::placeHits(this->Hits, *this->Camera, treeamr::convertMatrix(matrix), this->Image);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::RenderSurface(vtkRenderer* renderer, vtkActor* actor)
{
  Internals& internals = *this->Private;
  vtkPlaneCollection* planes = this->GetClippingPlanes();
  if (planes && planes->GetNumberOfItems() > 0)
  {
    this->Warn("Clipping planes are not implemented and have no effect.");
  }
  vtkHyperTreeGrid* grid = this->UpdateInput();
  this->UpdateSurface(grid);
  this->UpdateHits(renderer, actor);
  if (renderer->GetSelector())
  {
    this->Select(renderer, actor);
    return;
  }

  vtkProperty* property = actor->GetProperty();
  treeamr::SurfaceAppearance appearance;
  appearance.material = treeamr::convertMaterial(property);
  appearance.lights = treeamr::convertLights(renderer);
  appearance.opacity =
    actor->IsRenderingTranslucentPolygonalGeometry() ? static_cast<float>(property->GetOpacity()) : 1.f;
  appearance.ambientOfColors = static_cast<float>(
    property->GetLighting() ? property->GetAmbient() : property->GetAmbient() + property->GetDiffuse());
  appearance.diffuseOfColors = static_cast<float>(property->GetLighting() ? property->GetDiffuse() : 0.);

  const vtkSmartPointer<vtkUnsignedCharArray> colors = internals.MapColors(this, grid);
  treeamr::shadeHits(internals.Hits, *internals.Camera, internals.WorldFromData, appearance,
    colors ? colors->GetPointer(0) : nullptr, internals.Image);
  internals.PlaceForAmbientOcclusion(renderer, actor);
  internals.Framebuffer.DrawSurface(renderer, actor, this, internals.Viewport, internals.Image);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Select(vtkRenderer* renderer, vtkActor* actor)
{
  Internals& internals = *this->Private;
  vtkHardwareSelector* selector = renderer->GetSelector();
  if (selector->GetFieldAssociation() == vtkDataObject::FIELD_ASSOCIATION_POINTS)
  {
    return; // there are none; those behind are hidden by the depths that the selector draws first
  }
  struct PropRender
  {
    vtkHardwareSelector* Selector;
    explicit PropRender(vtkHardwareSelector* s)
      : Selector(s)
    {
      this->Selector->BeginRenderProp();
    }
    ~PropRender() { this->Selector->EndRenderProp(); }
  };
  const PropRender propRender(selector);
  // Decides whether there is a pass of the high bits; global indices may have gaps.
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  vtkDataArray* array = grid->GetCellData()->GetArray(internals.Contoured.name.c_str());
  selector->UpdateMaximumCellId(array->GetNumberOfTuples() - 1);

  // Black in the passes of point ids.
  std::array<float, 3> ofProp{};
  const int pass = selector->GetCurrentPass();
  switch (pass)
  {
    case vtkHardwareSelector::COMPOSITE_INDEX_PASS:
      selector->RenderCompositeIndex(this->CompositeIndex);
      [[fallthrough]];
    case vtkHardwareSelector::ACTOR_PASS:
    case vtkHardwareSelector::PROCESS_PASS:
      selector->GetPropColorValue(ofProp.data());
      break;
    default:
      break;
  }
  const bool low = pass == vtkHardwareSelector::CELL_ID_LOW24;
  const bool high = pass == vtkHardwareSelector::CELL_ID_HIGH24;
  const auto color = [&](const treeamr::SurfaceHit& hit) {
    if (!low && !high)
    {
      return ofProp;
    }
    const vtkIdType id = treeamr::globalIndex(*grid, internals.Surface->cell(hit));
    std::array<float, 3> rgb;
    vtkHardwareSelector::Convert(low ? id : id >> 24, rgb.data());
    return rgb;
  };
  treeamr::fillHits(internals.Hits, *internals.Camera, color, internals.Image);
  internals.Framebuffer.DrawSurface(renderer, actor, this, internals.Viewport, internals.Image);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Render(vtkRenderer* renderer, vtkActor* actor)
{
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  try
  {
    this->RenderSurface(renderer, actor);
    this->Private->Errors.clear();
  }
  catch (const std::exception& error)
  {
    vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
    const vtkMTimeType stamp =
      std::max(this->GetMTime(), grid ? treeamr::gridModificationTime(grid) : vtkMTimeType(0));
    if (this->Private->Errors.isNews(error.what(), stamp))
    {
      vtkErrorMacro(<< error.what());
    }
  }
  timer->StopTimer();
  this->TimeToDraw = timer->GetElapsedTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Private->Framebuffer.ReleaseGraphicsResources(window);
}

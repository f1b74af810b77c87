#include "vtkTreeAMRIsosurfaceMapper.h"

#include "ImageReduction.h"
#include "MapperInput.h"
#include "OnceReporter.h"
#include "SceneConversion.h"
#include "SurfaceColors.h"
#include "SurfaceLevels.h"
#include "SurfaceShading.h"
#include "UnsupportedSettings.h"
#include "vtkTreeAMRDepthPeeling.h"
#include "vtkTreeAMRFramebuffer.h"

#include "Error.h"
#include "Surface/OcclusionFilter.h"
#include "Surface/SecondaryRays.h"
#include "Surface/SurfaceFrame.h"

#include "vtkActor.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkHardwareSelector.h"
#include "vtkHyperTreeGrid.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPropCollection.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkTimerLog.h"
#include "vtkVolume.h"
#include "vtkWeakPointer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

vtkStandardNewMacro(vtkTreeAMRIsosurfaceMapper);

namespace
{

constexpr std::size_t allLayers = std::numeric_limits<std::size_t>::max();

/// How many layers of an opacity let light through that 8 bits could show.
std::size_t layersBeforeOpaque(double opacity)
{
  if (!(opacity > 0.))
  {
    return allLayers;
  }
  constexpr double nothing = 1. / 512.;
  return opacity >= 1. ? 1 : static_cast<std::size_t>(std::ceil(std::log(nothing) / std::log1p(-opacity)));
}

/// Whether depth peeling sorts nothing but this actor, among the renderer's own props.
bool isAloneInPeeling(vtkRenderer* renderer, vtkActor* actor)
{
  bool found = false;
  vtkPropCollection* props = renderer->GetViewProps();
  vtkCollectionSimpleIterator at;
  props->InitTraversal(at);
  while (vtkProp* prop = props->GetNextProp(at))
  {
    if (prop == actor)
    {
      found = true;
    }
    else if (prop->GetVisibility() &&
      (prop->HasTranslucentPolygonalGeometry() ||
        (renderer->GetUseDepthPeelingForVolumes() && vtkVolume::SafeDownCast(prop))))
    {
      return false;
    }
  }
  return found;
}

} // anonymous namespace

//------------------------------------------------------------------------------
// One actor in one renderer, as one eye sees it. Its picture serves all passes of a frame (depth peeling), its hits all frames
// until something moves.
struct vtkTreeAMRIsosurfaceMapper::View
{
  vtkWeakPointer<vtkRenderer> Renderer;
  vtkWeakPointer<vtkActor> Actor;
  int Eye;
  unsigned long FrameObserver = 0;

  // What the hits are of.
  std::shared_ptr<const treeamr::Isosurface> Surface;
  treeamr::SurfaceLayers Layers = treeamr::SurfaceLayers::Nearest;
  std::optional<treeamr::Camera> Camera;
  treeamr::Matrix4 ClipFromData{};
  treeamr::Matrix4 ViewFromData{};
  vtkTreeAMRViewport Viewport;
  std::size_t MostHits = 0; // of a pixel
  treeamr::ImageReduction Reduction{ 1, 1, 1. };
  double SampleDistance = 0.;
  treeamr::HitImage Hits;

  // What it took to trace and shade them, for the drafts to come.
  treeamr::SampleDistanceControl SampleDistances;
  double Seconds = 0.; // negative: known
  bool IsInteractive = false;

  // What is known of the hits besides.
  std::vector<std::shared_ptr<const treeamr::Field>> ColorFields;
  std::vector<float> ColorValues; // of each hit one of each field
  treeamr::SurfaceVisibility Visibility;
  std::vector<std::uint16_t> OpenRays; // of the AmbientOcclusionRays of each hit
  int AmbientOcclusionRays = 0;
  double AmbientOcclusionRadius = 0.; // in the view
  std::vector<treeamr::Light> ShadowLights;

  vtkTreeAMRSurfaceTextures Picture;
  bool PictureIsOfThisFrame = false;

  View(vtkRenderer* renderer, vtkActor* actor, int eye)
    : Renderer(renderer)
    , Actor(actor)
    , Eye(eye)
    , FrameObserver(renderer->AddObserver(vtkCommand::StartEvent, this, &View::StartFrame))
  {
  }
  ~View()
  {
    if (this->Renderer)
    {
      this->Renderer->RemoveObserver(this->FrameObserver);
    }
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  void StartFrame() { this->PictureIsOfThisFrame = false; }
  /// Length in the view of the longest diagonal of the grid's bounds.
  double DiagonalOf(const treeamr::RootGrid& grid) const;
};

//------------------------------------------------------------------------------
struct vtkTreeAMRIsosurfaceMapper::Internals
{
  vtkTreeAMRFramebuffer Framebuffer;
  vtkTreeAMRDepthPeeling DepthPeeling;
  treeamr::FieldSlot ContourSlot;
  std::array<treeamr::FieldSlot, 4> ColorSlots; // of the components of a colour
  treeamr::CategorySlot CategorySlot;
  treeamr::BoundsSlot BoundsSlot;
  treeamr::OnceReporter Errors;   // of a call of Render()
  treeamr::OnceReporter Warnings; // of a call of Shade(): a frame has one, however often it is rendered
  treeamr::SettingWarnings SettingWarnings;

  std::shared_ptr<const treeamr::Field> Field;
  treeamr::SurfaceLevels Surfaces; // of the field
  treeamr::ArraySelection Contoured;
  vtkTimeStamp SurfaceTime;

  std::vector<std::unique_ptr<View>> Views;
  double LastSampleDistance = 0.;
  vtkTreeAMRSurfaceImage Image; // on its way to the graphics card

  View& ViewOf(vtkMapper* self, vtkRenderer* renderer, vtkActor* actor);
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
  this->ContourValues->PrintSelf(os, indent);
  os << indent << "IsosurfaceComponent: " << this->IsosurfaceComponent << endl;
  os << indent << "CompositeIndex: " << this->CompositeIndex << endl;
  os << indent << "AmbientOcclusionSamples: " << this->AmbientOcclusionSamples << endl;
  os << indent << "AmbientOcclusionRadius: " << this->AmbientOcclusionRadius << endl;
  os << indent << "Shadows: " << this->Shadows << endl;
  os << indent << "AutoAdjustSampleDistances: " << this->AutoAdjustSampleDistances << endl;
  os << indent << "ImageSampleDistance: " << this->ImageSampleDistance << endl;
  os << indent << "MinimumImageSampleDistance: " << this->MinimumImageSampleDistance << endl;
  os << indent << "MaximumImageSampleDistance: " << this->MaximumImageSampleDistance << endl;
  os << indent << "InteractiveRenderTime: " << this->InteractiveRenderTime << endl;
  os << indent << "LevelOfDetail: " << this->LevelOfDetail << endl;
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
void vtkTreeAMRIsosurfaceMapper::ShallowCopy(vtkAbstractMapper* mapper)
{
  this->Superclass::ShallowCopy(mapper);
  if (vtkTreeAMRIsosurfaceMapper* other = vtkTreeAMRIsosurfaceMapper::SafeDownCast(mapper))
  {
    this->SetInputConnection(
      other->GetNumberOfInputConnections(0) > 0 ? other->GetInputConnection(0, 0) : nullptr);
    this->SetInputArrayToProcess(0, other->GetInputArrayInformation(0));
    this->ContourValues->DeepCopy(other->ContourValues);
    this->SetIsosurfaceComponent(other->IsosurfaceComponent);
    this->SetCompositeIndex(other->CompositeIndex);
    this->SetAmbientOcclusionSamples(other->AmbientOcclusionSamples);
    this->SetAmbientOcclusionRadius(other->AmbientOcclusionRadius);
    this->SetShadows(other->Shadows);
    this->SetAutoAdjustSampleDistances(other->AutoAdjustSampleDistances);
    this->SetImageSampleDistance(other->ImageSampleDistance);
    this->SetMinimumImageSampleDistance(other->MinimumImageSampleDistance);
    this->SetMaximumImageSampleDistance(other->MaximumImageSampleDistance);
    this->SetInteractiveRenderTime(other->InteractiveRenderTime);
    this->SetLevelOfDetail(other->LevelOfDetail);
  }
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetValue(int i, double value)
{
  this->ContourValues->SetValue(i, value);
}

//------------------------------------------------------------------------------
double vtkTreeAMRIsosurfaceMapper::GetValue(int i)
{
  return this->ContourValues->GetValue(i);
}

//------------------------------------------------------------------------------
double* vtkTreeAMRIsosurfaceMapper::GetValues()
{
  return this->ContourValues->GetValues();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::GetValues(double* values)
{
  this->ContourValues->GetValues(values);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::SetNumberOfContours(int number)
{
  this->ContourValues->SetNumberOfContours(number);
}

//------------------------------------------------------------------------------
vtkIdType vtkTreeAMRIsosurfaceMapper::GetNumberOfContours()
{
  return this->ContourValues->GetNumberOfContours();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::GenerateValues(int number, double range[2])
{
  this->ContourValues->GenerateValues(number, range);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::GenerateValues(int number, double rangeStart, double rangeEnd)
{
  this->ContourValues->GenerateValues(number, rangeStart, rangeEnd);
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRIsosurfaceMapper::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->ContourValues->GetMTime());
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
  const std::shared_ptr<const treeamr::Isosurface>& surface = this->Private->Surfaces.madeInFull();
  return surface ? static_cast<vtkIdType>(surface->octantCount()) : 0;
}

//------------------------------------------------------------------------------
double vtkTreeAMRIsosurfaceMapper::GetLastImageSampleDistance()
{
  return this->Private->LastSampleDistance;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkTreeAMRIsosurfaceMapper::GetSurfaceBuildTime()
{
  return this->Private->SurfaceTime.GetMTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Warn(const treeamr::Remark& remark)
{
  if (!remark.text.empty() && this->Private->Warnings.isNews(remark.about))
  {
    vtkWarningMacro(<< remark.text);
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
  contoured.name = treeamr::processedArrayName(this, grid);
  contoured.component = this->IsosurfaceComponent;
  Internals& internals = *this->Private;
  const std::shared_ptr<const treeamr::Field>& field = internals.ContourSlot.acquire(grid, contoured, true);
  std::vector<double> isovalues(this->GetNumberOfContours());
  this->GetValues(isovalues.data());
  if (internals.Surfaces.set(field, isovalues))
  {
    // Before there are others.
    for (const std::unique_ptr<View>& view : internals.Views)
    {
      view->Camera.reset();
      view->Surface.reset();
    }
    if (!isovalues.empty())
    {
      internals.SurfaceTime.Modified();
    }
    internals.Field = field;
  }
  internals.Contoured = contoured;
}

//------------------------------------------------------------------------------
vtkTreeAMRIsosurfaceMapper::View& vtkTreeAMRIsosurfaceMapper::Internals::ViewOf(
  vtkMapper* self, vtkRenderer* renderer, vtkActor* actor)
{
  std::erase_if(this->Views, [self](const std::unique_ptr<View>& view) {
    return !view->Renderer || !view->Actor || view->Actor->GetMapper() != self;
  });
  const int eye = treeamr::eyeOf(renderer);
  for (const std::unique_ptr<View>& view : this->Views)
  {
    if (view->Renderer == renderer && view->Actor == actor && view->Eye == eye)
    {
      return *view;
    }
  }
  this->Views.push_back(std::make_unique<View>(renderer, actor, eye));
  return *this->Views.back();
}

//------------------------------------------------------------------------------
double vtkTreeAMRIsosurfaceMapper::ChooseSampleDistance(View& view)
{
  if (view.Renderer->GetSelector())
  {
    return 1.;
  }
  if (!this->AutoAdjustSampleDistances)
  {
    return this->ImageSampleDistance;
  }
  if (!view.IsInteractive)
  {
    return this->MinimumImageSampleDistance;
  }
  const double seconds =
    this->InteractiveRenderTime > 0. ? this->InteractiveRenderTime : view.Actor->GetAllocatedRenderTime();
  const double pixels = static_cast<double>(view.Viewport.Width) * view.Viewport.Height;
  return view.SampleDistances.choose(
    seconds / pixels, this->MinimumImageSampleDistance, this->MaximumImageSampleDistance);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::UpdateHits(View& view)
{
  view.Viewport = vtkTreeAMRFramebuffer::GetViewport(view.Renderer);
  view.IsInteractive = treeamr::isInteractive(view.Renderer);
  const treeamr::Matrix4 clipFromData = treeamr::clipFromData(view.Renderer, view.Actor);
  const treeamr::Matrix4 viewFromData = treeamr::viewFromData(view.Renderer, view.Actor);
  const treeamr::SurfaceLayers layers = view.Actor->IsRenderingTranslucentPolygonalGeometry()
    ? treeamr::SurfaceLayers::All
    : treeamr::SurfaceLayers::Nearest;
  // Translucent colours may let light through anywhere.
  const std::size_t mostHits = this->HasTranslucentPolygonalGeometry()
    ? allLayers
    : layersBeforeOpaque(view.Actor->GetProperty()->GetOpacity());
  if (view.Layers != layers)
  {
    view.SampleDistances = {};
  }
  const bool isNew = !view.Camera || view.Reduction.fullWidth() != view.Viewport.Width ||
    view.Reduction.fullHeight() != view.Viewport.Height || view.ClipFromData != clipFromData ||
    view.ViewFromData != viewFromData || view.Layers != layers ||
    (layers == treeamr::SurfaceLayers::All && view.MostHits != mostHits);
  const bool isDraft = view.IsInteractive && this->AutoAdjustSampleDistances && !view.Renderer->GetSelector();
  if (!isNew && isDraft)
  {
    return; // draft or not: a still camera loses nothing, and takes no time while something else moves
  }
  const double distance = this->ChooseSampleDistance(view);
  if (!isNew && distance == view.SampleDistance && view.Surface == this->Private->Surfaces.madeInFull())
  {
    return;
  }
  view.Camera.reset();
  view.PictureIsOfThisFrame = false;
  view.ColorFields.clear();
  view.Visibility = {};
  view.OpenRays.clear();
  view.AmbientOcclusionRays = 0;
  view.ShadowLights.clear();
  view.ClipFromData = clipFromData;
  view.ViewFromData = viewFromData;
  view.Layers = layers;
  view.MostHits = mostHits;
  view.Reduction = treeamr::ImageReduction(view.Viewport.Width, view.Viewport.Height, distance);
  view.SampleDistance = distance;
  const treeamr::Camera camera(clipFromData, viewFromData, view.Reduction.width(), view.Reduction.height());
  view.Surface = isDraft && this->LevelOfDetail > 0.
    ? this->Private->Surfaces.ofDetail(camera, this->LevelOfDetail)
    : this->Private->Surfaces.inFull();
  const double start = vtkTimerLog::GetUniversalTime();
  view.Surface->startFrame();
  view.Surface->render(camera, layers, view.Hits, mostHits);
  view.Camera = camera;
  view.Seconds = vtkTimerLog::GetUniversalTime() - start;
}

//------------------------------------------------------------------------------
double vtkTreeAMRIsosurfaceMapper::View::DiagonalOf(const treeamr::RootGrid& grid) const
{
  const treeamr::SurfaceFrame frame(this->ViewFromData);
  const treeamr::Bounds bounds = grid.bounds();
  double longest = 0.;
  for (int corner = 0; corner < 4; ++corner)
  {
    treeamr::Vec3 diagonal;
    for (int a = 0; a < 3; ++a)
    {
      diagonal[a] = (corner >> a & 1 ? -1. : 1.) * (bounds.max[a] - bounds.min[a]);
    }
    const treeamr::Vec3 inView = frame.worldVector(diagonal);
    longest = std::max(longest, std::sqrt(treeamr::dot(inView, inView)));
  }
  return longest;
}

//------------------------------------------------------------------------------
template <class Made>
std::shared_ptr<const Made> vtkTreeAMRIsosurfaceMapper::AcquireColors(
  treeamr::InputSlot<Made>& slot, vtkHyperTreeGrid* grid, const treeamr::ArraySelection& selection)
{
  try
  {
    const std::shared_ptr<const Made>& made = slot.acquire(grid, selection, false);
    this->Warn(slot.remark());
    return made;
  }
  catch (const treeamr::NoFiniteValue& error)
  {
    if (!error.isNaN)
    {
      this->Warn({ error.what(), error.what() });
    }
    return nullptr;
  }
}

//------------------------------------------------------------------------------
treeamr::HitColors vtkTreeAMRIsosurfaceMapper::MapColors(View& view, vtkHyperTreeGrid* grid)
{
  Internals& internals = *this->Private;
  const treeamr::ColorSource source = treeamr::selectColors(this, grid);
  if (!source.array)
  {
    return {};
  }
  const std::size_t count = source.components.size();
  const bool ofItself = count == 1 && treeamr::isSameArray(grid, source.components[0], internals.Contoured);
  if (treeamr::hasCategories(this, source))
  {
    const std::shared_ptr<const treeamr::Categories> categories =
      this->AcquireColors(internals.CategorySlot, grid, source.components[0]);
    internals.ColorSlots = {};
    if (!categories)
    {
      view.ColorFields.clear();
      view.ColorValues.assign(view.Hits.hits.size(), std::numeric_limits<float>::quiet_NaN());
      return treeamr::mapValues(this, source, view.ColorValues);
    }
    const std::vector<std::shared_ptr<const treeamr::Field>> numbers{ { categories, &categories->numbers } };
    if (view.ColorFields != numbers)
    {
      view.ColorValues = treeamr::categoriesAtHits(*categories, *view.Surface, view.Hits.hits);
      view.ColorFields = numbers;
    }
    return treeamr::mapCategories(
      this, *categories, view.ColorValues, view.Hits.hits, ofItself ? &view.Surface->isovalues() : nullptr);
  }
  internals.CategorySlot.release();
  if (ofItself)
  {
    return treeamr::mapIsovalues(this, source, view.Surface->isovalues());
  }
  std::vector<std::shared_ptr<const treeamr::Field>> fields;
  for (std::size_t c = 0; c < count; ++c)
  {
    fields.push_back(this->AcquireColors(internals.ColorSlots[c], grid, source.components[c]));
  }
  if (view.ColorFields != fields)
  {
    view.ColorFields.clear();
    view.ColorValues.assign(count * view.Hits.hits.size(), std::numeric_limits<float>::quiet_NaN());
    for (std::size_t c = 0; c < count; ++c)
    {
      if (fields[c])
      {
        treeamr::valuesAtHits(fields[c], *view.Camera, view.Hits, count, &view.ColorValues[c]);
      }
    }
    view.ColorFields = fields;
  }
  return treeamr::mapValues(this, source, view.ColorValues);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::HasTranslucentPolygonalGeometry()
{
  vtkHyperTreeGrid* grid = this->GetHyperTreeGrid();
  try
  {
    vtkDataArray* array = grid ? treeamr::selectColors(this, grid).array : nullptr;
    return array && this->HasTranslucentColors(array);
  }
  catch (const treeamr::Error&)
  {
    return false; // Render() says why there are no colours
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::HasTranslucentColors(vtkDataArray* array)
{
  return treeamr::isTranslucent(this, array);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::TraceVisibility(View& view, const std::vector<treeamr::Light>& lights)
{
  treeamr::SurfaceVisibility& visibility = view.Visibility;
  const double radius = this->AmbientOcclusionRadius * view.DiagonalOf(this->Private->Field->octree().grid());
  if (radius != view.AmbientOcclusionRadius || view.AmbientOcclusionRays > this->AmbientOcclusionSamples)
  {
    visibility.open.clear();
    view.OpenRays.clear();
    view.AmbientOcclusionRays = 0;
  }
  view.AmbientOcclusionRadius = radius;
  const int end = treeamr::isInteractive(view.Renderer)
    ? std::min(view.AmbientOcclusionRays + InteractiveSamples, this->AmbientOcclusionSamples)
    : this->AmbientOcclusionSamples;
  if (end > view.AmbientOcclusionRays)
  {
    // None until all are there: what throws has added some.
    const int begin = std::exchange(view.AmbientOcclusionRays, 0);
    visibility.open.clear();
    if (begin == 0)
    {
      view.OpenRays.assign(view.Hits.hits.size(), 0);
    }
    treeamr::traceAmbientOcclusion(*view.Surface, *view.Camera, view.Hits, radius, begin, end, view.OpenRays);
    visibility.open = treeamr::filterAmbientOcclusion(*view.Camera, view.Hits, view.OpenRays, end);
    view.AmbientOcclusionRays = end;
  }

  if (!this->Shadows)
  {
    visibility.lit.clear();
    view.ShadowLights.clear();
  }
  else if (view.ShadowLights != lights)
  {
    view.ShadowLights.clear();
    treeamr::traceShadows(*view.Surface, *view.Camera, view.Hits, lights, visibility.lit);
    view.ShadowLights = lights;
  }
}

//------------------------------------------------------------------------------
bool vtkTreeAMRIsosurfaceMapper::ReadDepthToFlatten(const View& view, std::vector<float>& depth)
{
  Internals& internals = *this->Private;
  if (!vtkTreeAMRFramebuffer::IsDepthPeeling(view.Actor))
  {
    // VTK's order independent pass would average layers.
    internals.Framebuffer.ReadDepth(view.Renderer, view.Viewport, depth);
    return true;
  }
  // Each peel draws all layers: where nothing can lie between them, one is the same.
  return isAloneInPeeling(view.Renderer, view.Actor) &&
    internals.DepthPeeling.ReadOpaqueDepth(
      view.Renderer, this, view.Actor, view.Viewport.Width, view.Viewport.Height, depth);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Shade(View& view, vtkHyperTreeGrid* grid)
{
  Internals& internals = *this->Private;
  vtkProperty* property = view.Actor->GetProperty();
  treeamr::SurfaceAppearance appearance;
  appearance.lights = treeamr::convertLights(view.Renderer);
  const bool lit = treeamr::isLit(property, appearance.lights);
  appearance.material = treeamr::convertMaterial(property, lit);
  appearance.opaque = view.Layers == treeamr::SurfaceLayers::Nearest;
  appearance.opacity = appearance.opaque ? 1.f : static_cast<float>(property->GetOpacity());
  appearance.flat = property->GetInterpolation() == VTK_FLAT;
  appearance.ambientOfColors =
    static_cast<float>(lit ? property->GetAmbient() : property->GetAmbient() + property->GetDiffuse());
  appearance.diffuseOfColors = static_cast<float>(lit ? property->GetDiffuse() : 0.);
  if (property->GetLighting())
  {
    this->TraceVisibility(view, appearance.lights);
  }

  treeamr::HitColors colors;
  this->Warn(internals.ContourSlot.remark());
  try
  {
    colors = this->MapColors(view, grid);
  }
  catch (const treeamr::Error& error)
  {
    this->Warn({ error.what(), error.what() });
  }
  internals.Warnings.endRound();
  treeamr::shadeHits(view.Hits, *view.Camera, appearance,
    property->GetLighting() ? view.Visibility : treeamr::SurfaceVisibility(), colors, internals.Image);
  std::vector<float> depth;
  if (view.Layers == treeamr::SurfaceLayers::All && this->ReadDepthToFlatten(view, depth))
  {
    treeamr::flattenLayers(view.Hits, *view.Camera,
      view.Reduction.isFull() ? depth : view.Reduction.sample(depth), internals.Image);
  }
  if (!view.Reduction.isFull())
  {
    treeamr::slopeHits(view.Hits, *view.Camera, internals.Image);
  }
  const bool geometry = vtkTreeAMRFramebuffer::WantsGeometry(view.Actor);
  if (geometry)
  {
    treeamr::placeHits(view.Hits, *view.Camera, internals.Image);
  }
  view.Picture.Upload(
    vtkTreeAMRFramebuffer::GetWindow(view.Renderer), view.Reduction, internals.Image, geometry);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::RenderSurface(vtkRenderer* renderer, vtkActor* actor)
{
  Internals& internals = *this->Private;
  internals.SettingWarnings.add(treeamr::unsupportedSettings(actor, this),
    [this](const std::string& message) { vtkWarningMacro(<< message); });
  vtkHyperTreeGrid* grid = this->UpdateInput();
  this->UpdateSurface(grid);
  if (internals.Surfaces.isEmpty())
  {
    return;
  }
  View& view = internals.ViewOf(this, renderer, actor);
  this->UpdateHits(view);
  if (renderer->GetSelector())
  {
    this->Select(view);
    return;
  }
  if (!view.PictureIsOfThisFrame || view.Picture.HasGeometry() != vtkTreeAMRFramebuffer::WantsGeometry(actor))
  {
    const double start = vtkTimerLog::GetUniversalTime();
    this->Shade(view, grid);
    view.PictureIsOfThisFrame = true;
    if (view.Seconds >= 0.)
    {
      const double seconds = view.Seconds + vtkTimerLog::GetUniversalTime() - start;
      const double pixels = static_cast<double>(view.Viewport.Width) * view.Viewport.Height;
      view.SampleDistances.record(view.SampleDistance, seconds / pixels, view.IsInteractive);
      view.Seconds = -1.;
    }
    internals.LastSampleDistance = view.SampleDistance;
  }
  internals.Framebuffer.DrawSurface(renderer, actor, this, view.Picture);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Select(View& view)
{
  Internals& internals = *this->Private;
  vtkHardwareSelector* selector = view.Renderer->GetSelector();
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
    const vtkIdType id = treeamr::globalIndex(*grid, view.Surface->cell(hit));
    std::array<float, 3> rgb;
    vtkHardwareSelector::Convert(low ? id : id >> 24, rgb.data());
    return rgb;
  };
  treeamr::fillHits(view.Hits, *view.Camera, color, internals.Image);
  view.PictureIsOfThisFrame = false;
  view.Picture.Upload(
    vtkTreeAMRFramebuffer::GetWindow(view.Renderer), view.Reduction, internals.Image, false);
  internals.Framebuffer.DrawSurface(view.Renderer, view.Actor, this, view.Picture);
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::Render(vtkRenderer* renderer, vtkActor* actor)
{
  vtkNew<vtkTimerLog> timer;
  timer->StartTimer();
  try
  {
    this->RenderSurface(renderer, actor);
  }
  catch (const std::exception& error)
  {
    const char* const message = treeamr::describe(error);
    if (this->Private->Errors.isNews(message))
    {
      vtkErrorMacro(<< message);
    }
  }
  this->Private->Errors.endRound();
  timer->StopTimer();
  this->TimeToDraw = timer->GetElapsedTime();
}

//------------------------------------------------------------------------------
void vtkTreeAMRIsosurfaceMapper::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Private->Framebuffer.ReleaseGraphicsResources(window);
  this->Private->DepthPeeling.ReleaseGraphicsResources(window);
  for (const std::unique_ptr<View>& view : this->Private->Views)
  {
    view->Picture.ReleaseGraphicsResources(window);
    view->PictureIsOfThisFrame = false;
  }
}

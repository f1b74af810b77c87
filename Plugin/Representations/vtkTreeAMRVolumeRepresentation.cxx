#include "vtkTreeAMRVolumeRepresentation.h"

#include "RankPeers.h"

#include "vtkAlgorithmOutput.h"
#include "vtkCellData.h"
#include "vtkColorTransferFunction.h"
#include "vtkCommunicator.h"
#include "vtkContourValues.h"
#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkHyperTreeGrid.h"
#include "vtkMath.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPVTransferFunction2D.h"
#include "vtkPiecewiseFunction.h"
#include "vtkRemotingCoreConfiguration.h"
#include "vtkTable.h"
#include "vtkTreeAMRVolumeMapper.h"
#include "vtkVariant.h"
#include "vtkVolume.h"
#include "vtkVolumeProperty.h"

#include "HyperTreeGridConverter.h"

#include <algorithm>
#include <limits>

vtkStandardNewMacro(vtkTreeAMRVolumeRepresentation);

//------------------------------------------------------------------------------
vtkTreeAMRVolumeRepresentation::vtkTreeAMRVolumeRepresentation()
{
  this->Volume->SetProperty(this->Property);
  this->Volume->SetMapper(this->Mapper);
  this->Mapper->SetScalarModeToUseCellFieldData();
  this->Property->SetInterpolationTypeToLinear();
  this->Property->GetIsoSurfaceValues()->SetNumberOfContours(0); // VTK's default is the value 0
  this->DefaultColor->SetColorSpaceToDiverging();
  this->FollowProgress(this->Mapper);
}

//------------------------------------------------------------------------------
vtkTreeAMRVolumeRepresentation::~vtkTreeAMRVolumeRepresentation() = default;

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Mapper: " << endl;
  this->Mapper->PrintSelf(os, indent.GetNextIndent());
}

//------------------------------------------------------------------------------
vtkProp3D* vtkTreeAMRVolumeRepresentation::GetProp()
{
  return this->Volume;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::UpdateFromAllRanks()
{
  this->DefaultArrayName.clear();
  // Of values and of the bounds along each axis the least and the negative of the greatest: one reduction over the
  // ranks serves all.
  constexpr double none = std::numeric_limits<double>::infinity();
  double local[8] = { none, none, none, none, none, none, none, none };
  double bounds[6];
  treeamr::computeLocalBounds(this->Grid, bounds);
  for (int i = 0; i < 6 && vtkMath::AreBoundsInitialized(bounds); ++i)
  {
    local[2 + i] = i % 2 == 0 ? bounds[i] : -bounds[i];
  }
  vtkCellData* cells = this->Grid->GetCellData();
  for (int i = 0; i < cells->GetNumberOfArrays() && this->DefaultArrayName.empty(); ++i)
  {
    vtkDataArray* array = cells->GetArray(i);
    if (array && array->GetName() && std::string(array->GetName()) != vtkDataSetAttributes::GhostArrayName())
    {
      this->DefaultArrayName = array->GetName();
      double range[2];
      array->GetFiniteRange(range, array->GetNumberOfComponents() == 1 ? 0 : -1);
      if (range[0] <= range[1])
      {
        local[0] = range[0];
        local[1] = -range[1];
      }
    }
  }
  double global[8];
  std::copy_n(local, 8, global);
  if (auto controller = vtkMultiProcessController::GetGlobalController())
  {
    controller->AllReduce(local, global, 8, vtkCommunicator::MIN_OP);
  }
  for (int i = 0; i < 6; ++i)
  {
    const double bound = global[2 + i] != none ? global[2 + i] : 0.;
    this->DataBounds[i] = i % 2 == 0 ? bound : -bound;
  }
  const double low = global[0] != none ? global[0] : 0.;
  const double high = global[0] != none ? -global[1] : 1.;
  if (this->DefaultColor->GetSize() > 0 && this->DefaultRange[0] == low && this->DefaultRange[1] == high)
  {
    return;
  }
  this->DefaultRange[0] = low;
  this->DefaultRange[1] = high;
  // The ends of ParaView's own default, "Cool to Warm".
  this->DefaultColor->RemoveAllPoints();
  this->DefaultColor->AddRGBPoint(low, 0.231373, 0.298039, 0.752941);
  this->DefaultColor->AddRGBPoint(high, 0.705882, 0.0156863, 0.14902);
  this->DefaultScalarOpacity->RemoveAllPoints();
  this->DefaultScalarOpacity->AddPoint(low, 0.);
  this->DefaultScalarOpacity->AddPoint(high, 1.);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::FindPeers(vtkMultiProcessController* controller, bool draws)
{
  const vtkRemotingCoreConfiguration* const displays = vtkRemotingCoreConfiguration::GetInstance();
  if (!this->Peers)
  {
    this->Peers = RankPeers::make(controller);
  }
  if (this->Peers)
  {
    this->Peers->agreeOnDrawing(draws);
  }
  // Of several windows each rank draws those alone that it has something in.
  this->Mapper->SetPeers(displays->GetIsInTileDisplay() || displays->GetIsInCave() ? nullptr : this->Peers);
}

//------------------------------------------------------------------------------
std::set<std::string> vtkTreeAMRVolumeRepresentation::GetShownArrays()
{
  std::set<std::string> names = this->Superclass::GetShownArrays();
  if (this->UsesOpacityArray && !this->OpacityArray.empty())
  {
    names.insert(this->OpacityArray);
  }
  if (this->UsesTransfer2D && !this->UsesGradient && !this->SecondArray.empty())
  {
    names.insert(this->SecondArray);
  }
  return names;
}

//------------------------------------------------------------------------------
std::vector<double> vtkTreeAMRVolumeRepresentation::GetDraftedIsovalues()
{
  if (!this->Mapper->GetAutoAdjustSampleDistances() || !this->HasSurfaces())
  {
    return {};
  }
  vtkContourValues* values = this->Property->GetIsoSurfaceValues();
  return { values->GetValues(), values->GetValues() + values->GetNumberOfContours() };
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::UpdateMapper(vtkAlgorithmOutput* grid)
{
  this->Mapper->SetInputConnection(grid);
  const std::string name = this->GetColorArrayName();
  // ParaView sets the functions along with the array, and takes them away with it: what was seen stays.
  if (!name.empty() && this->Color && this->ScalarOpacity)
  {
    this->Chosen = { name, this->Color, this->ScalarOpacity };
  }
  const std::string& last = this->Chosen.Array;
  const bool isDrawn =
    !last.empty() && (name == last || (name.empty() && this->Grid->GetCellData()->HasArray(last.c_str())));
  this->Mapper->SelectScalarArray(isDrawn ? last.c_str() : this->DefaultArrayName.c_str());
  vtkColorTransferFunction* colors = isDrawn ? this->Chosen.Color : this->DefaultColor;
  this->Property->SetColor(colors);
  this->Property->SetScalarOpacity(isDrawn ? this->Chosen.ScalarOpacity : this->DefaultScalarOpacity);
  const bool component = isDrawn && colors->GetVectorMode() == vtkScalarsToColors::COMPONENT;
  this->Mapper->SetVectorMode(
    component ? vtkTreeAMRVolumeMapper::COMPONENT : vtkTreeAMRVolumeMapper::MAGNITUDE);
  this->Mapper->SetVectorComponent(component ? colors->GetVectorComponent() : 0);
  vtkDataArray* array = this->Grid->GetCellData()->GetArray(this->Mapper->GetArrayName());
  const int components = array ? array->GetNumberOfComponents() : 1;
  const bool areAsked = this->MapsComponents || !this->MapsScalars;
  const bool areDependent = areAsked && (components == 2 || components == 4);
  this->Property->SetIndependentComponents(!areDependent);
  // MultiComponentsMapping may stay on for the next array of several.
  const bool isInVain = array && areAsked && !areDependent && (components > 1 || !this->MapsScalars);
  const std::string inVain = isInVain ? this->Mapper->GetArrayName() : "";
  if (!inVain.empty() && inVain != this->MappedInVain)
  {
    vtkWarningMacro(<< (this->MapsScalars ? "MultiComponentsMapping on" : "MapScalars off")
                    << " is without effect on " << inVain << " of " << components
                    << (components == 1 ? " component" : " components")
                    << "; needed are 2 (colour, opacity) or 4 (red, green, blue, opacity).");
  }
  this->MappedInVain = inVain;
  this->Mapper->SetOpacityArrayName(
    this->UsesOpacityArray && !this->UsesTransfer2D ? this->OpacityArray.c_str() : "");
  this->Property->SetTransferFunctionMode(
    this->UsesTransfer2D ? vtkVolumeProperty::TF_2D : vtkVolumeProperty::TF_1D);
  this->Mapper->SetTransfer2DYAxisArray(
    this->UsesTransfer2D && !this->UsesGradient ? this->SecondArray.c_str() : "");
  double distance = this->UnitDistance;
  if (distance <= 0.)
  {
    const double* const b = this->DataBounds;
    const double longest = std::max({ b[1] - b[0], b[3] - b[2], b[5] - b[4] });
    distance = longest > 0. ? 0.1 * longest : 1.;
  }
  for (int component = 0; component < VTK_MAX_VRCOMP; ++component)
  {
    this->Property->SetScalarOpacityUnitDistance(component, distance);
  }
  double planes[6];
  for (int i = 0; i < 6; ++i)
  {
    planes[i] = this->CroppingOrigin[i / 2] + this->DataBounds[i] * this->CroppingScale[i / 2];
  }
  this->Mapper->SetCroppingRegionPlanes(planes);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetInterpolationType(int type)
{
  if (type != VTK_NEAREST_INTERPOLATION && type != VTK_LINEAR_INTERPOLATION)
  {
    vtkWarningMacro("InterpolationType "
      << type << ", allowed are 0 (Nearest) and 1 (Linear), the nearest of which is taken.");
    type = type < VTK_NEAREST_INTERPOLATION ? VTK_NEAREST_INTERPOLATION : VTK_LINEAR_INTERPOLATION;
  }
  this->Property->SetInterpolationType(type);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetColor(vtkColorTransferFunction* colors)
{
  this->Color = colors;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetScalarOpacity(vtkPiecewiseFunction* opacities)
{
  this->ScalarOpacity = opacities;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SelectOpacityArray(
  int vtkNotUsed(index), int vtkNotUsed(port), int vtkNotUsed(connection), int association, const char* name)
{
  this->OpacityArray = this->TakeCellArray("OpacityArrayName", association, name);
}

//------------------------------------------------------------------------------
std::string vtkTreeAMRVolumeRepresentation::TakeCellArray(
  const char* property, int association, const char* name)
{
  if (name && *name && association != vtkDataObject::CELL)
  {
    vtkWarningMacro(<< property << ": '" << name
                    << "' is taken of the cells, as all of a hyper tree grid's.");
  }
  return name ? name : "";
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetTransferFunction2D(vtkPVTransferFunction2D* function)
{
  this->Property->SetTransferFunction2D(function ? function->GetFunction() : nullptr);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SelectColorArray2(
  int vtkNotUsed(index), int vtkNotUsed(port), int vtkNotUsed(connection), int association, const char* name)
{
  this->SecondArray = this->TakeCellArray("ColorArray2Name", association, name);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetNumberOfIsosurfaces(int number)
{
  this->Property->GetIsoSurfaceValues()->SetNumberOfContours(number);
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetIsosurfaceValue(int index, double value)
{
  this->Property->GetIsoSurfaceValues()->SetValue(index, value);
}

//------------------------------------------------------------------------------
bool vtkTreeAMRVolumeRepresentation::HasSurfaces()
{
  return this->Mapper->GetBlendMode() == vtkVolumeMapper::ISOSURFACE_BLEND ||
    ((this->Mapper->GetBlendMode() == vtkVolumeMapper::COMPOSITE_BLEND ||
       this->Mapper->GetBlendMode() == vtkVolumeMapper::SLICE_BLEND) &&
      this->Mapper->GetShowIsosurfaces());
}

//------------------------------------------------------------------------------
double vtkTreeAMRVolumeRepresentation::GetStatistic(const char* name)
{
  return this->Mapper->GetStatistics()->GetValueByName(0, name).ToDouble();
}

//------------------------------------------------------------------------------
double vtkTreeAMRVolumeRepresentation::GetEstimatedError()
{
  return this->GetStatistic("EstimatedError");
}

//------------------------------------------------------------------------------
int vtkTreeAMRVolumeRepresentation::GetDrawnLevels()
{
  return this->GetStatistic("Cells") > 0. ? static_cast<int>(this->Grid->GetNumberOfLevels()) : 0;
}

//------------------------------------------------------------------------------
double vtkTreeAMRVolumeRepresentation::GetMemory()
{
  constexpr double mib = 1 << 20;
  vtkTable* statistics = this->Mapper->GetStatistics();
  double bytes = 0.;
  for (const char* part : { "OctreeBytes", "KeptBytes", "SurfaceBytes" })
  {
    bytes += statistics->GetValueByName(0, part).ToDouble();
  }
  return bytes / mib;
}

//------------------------------------------------------------------------------
double vtkTreeAMRVolumeRepresentation::GetFrameSeconds()
{
  vtkTable* statistics = this->Mapper->GetStatistics();
  double seconds = 0.;
  for (const char* part : { "RayCastingSeconds", "ErrorSeconds", "CompositingSeconds" })
  {
    seconds += statistics->GetValueByName(0, part).ToDouble();
  }
  return seconds;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetCropping(bool crop)
{
  this->Mapper->SetCropping(crop); // to VTK's default regions: what is between the planes
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetCroppingOrigin(double x, double y, double z)
{
  this->CroppingOrigin[0] = x;
  this->CroppingOrigin[1] = y;
  this->CroppingOrigin[2] = z;
}

//------------------------------------------------------------------------------
void vtkTreeAMRVolumeRepresentation::SetCroppingScale(double x, double y, double z)
{
  this->CroppingScale[0] = x;
  this->CroppingScale[1] = y;
  this->CroppingScale[2] = z;
}

#include "vtkSMTreeAMRVolumeRepresentationProxy.h"

#include "vtkCommand.h"
#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkPVGeneralSettings.h"
#include "vtkPVSession.h"
#include "vtkSMArrayListDomain.h"
#include "vtkSMArrayRangeDomain.h"
#include "vtkSMDoubleVectorProperty.h"
#include "vtkSMPVRepresentationProxy.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"
#include "vtkTreeAMRFrameInformation.h"
#include "vtkVolumeMapper.h"

#include <string>

vtkStandardNewMacro(vtkSMTreeAMRVolumeRepresentationProxy);

namespace
{

/// The active scalars of the cells, else the first array that may be coloured by; empty: none.
std::string arrayToColorBy(vtkSMProxy* panel)
{
  vtkSMPropertyHelper input(panel, "Input");
  if (auto source = vtkSMSourceProxy::SafeDownCast(input.GetAsProxy()))
  {
    vtkPVArrayInformation* scalars = source->GetDataInformation(input.GetOutputPort())
                                       ->GetCellDataInformation()
                                       ->GetAttributeInformation(vtkDataSetAttributes::SCALARS);
    if (scalars)
    {
      return scalars->GetName();
    }
  }
  auto arrays = panel->GetProperty("ColorArrayName")->FindDomain<vtkSMArrayListDomain>();
  for (unsigned int i = 0; arrays && i < arrays->GetNumberOfStrings(); ++i)
  {
    const std::string name = arrays->GetString(i);
    if (arrays->GetFieldAssociation(i) == vtkDataObject::CELL &&
      name != vtkDataSetAttributes::GhostArrayName())
    {
      return name;
    }
  }
  return {};
}

} // anonymous namespace

//------------------------------------------------------------------------------
vtkSMTreeAMRVolumeRepresentationProxy::vtkSMTreeAMRVolumeRepresentationProxy() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRVolumeRepresentationProxy::~vtkSMTreeAMRVolumeRepresentationProxy()
{
  this->Observe(nullptr);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "View: " << this->View.Get() << endl;
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ObjectsHaveBeenCreated()
{
  this->Superclass::ObjectsHaveBeenCreated();
  this->GetTrueParentProxy()->AddObserver(
    vtkCommand::PropertyModifiedEvent, this, &vtkSMTreeAMRVolumeRepresentationProxy::PanelModified);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::PanelModified(
  vtkObject* vtkNotUsed(panel), unsigned long vtkNotUsed(event), void* name)
{
  if (name && std::string(static_cast<const char*>(name)) == "Representation")
  {
    this->ChooseArray();
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ChooseArray()
{
  auto panel = vtkSMPVRepresentationProxy::SafeDownCast(this->GetTrueParentProxy());
  if (!panel ||
    std::string(vtkSMPropertyHelper(panel, "Representation").GetAsString()) != "Tree AMR Volume" ||
    panel->GetUsingScalarColoring())
  {
    return;
  }
  const std::string array = arrayToColorBy(panel);
  if (array.empty() || !panel->SetScalarColoring(array.c_str(), vtkDataObject::CELL))
  {
    return;
  }
  // A range that was given to the array's colours before, as by scripts that restore a state, stays.
  vtkSMProxy* colors = vtkSMPropertyHelper(panel, "LookupTable").GetAsProxy();
  if (colors && vtkSMPropertyHelper(colors, "ScalarRangeInitialized").GetAsInt() == 0)
  {
    panel->RescaleTransferFunctionToDataRange(/*extend*/ true);
  }
  auto view = vtkSMRenderViewProxy::SafeDownCast(this->View);
  const bool isInGui = view && view->GetInteractor();
  if (isInGui && vtkSMPropertyHelper(panel, "Visibility").GetAsInt() == 1 &&
    vtkPVGeneralSettings::GetInstance()->GetScalarBarMode() ==
      vtkPVGeneralSettings::AUTOMATICALLY_SHOW_AND_HIDE_SCALAR_BARS)
  {
    panel->SetScalarBarVisibility(view, true);
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::SetPropertyModifiedFlag(const char* name, int flag)
{
  if (flag && this->ObjectsCreated && !this->IsReviewing)
  {
    // The isovalues' domain learns of changes after this proxy: it is asked in UpdateVTKObjects().
    const std::string property = name;
    this->ArrayModified |= property == "ColorArrayName";
    this->IsosurfacesSwitched |= property == "ShowIsosurfaces" || property == "BlendMode";
    this->IsosurfacesGiven |= property == "IsosurfaceValues";
  }
  this->Superclass::SetPropertyModifiedFlag(name, flag);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::UpdateVTKObjects()
{
  this->ReviewIsosurfaces();
  this->Superclass::UpdateVTKObjects();
}

//------------------------------------------------------------------------------
bool vtkSMTreeAMRVolumeRepresentationProxy::ShowsIsosurfaces()
{
  return vtkSMPropertyHelper(this, "ShowIsosurfaces").GetAsInt() != 0 ||
    vtkSMPropertyHelper(this, "BlendMode").GetAsInt() == vtkVolumeMapper::ISOSURFACE_BLEND;
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ReviewIsosurfaces()
{
  vtkSMProperty* isovalues = this->GetProperty("IsosurfaceValues");
  const bool isEmpty = vtkSMPropertyHelper(isovalues).GetNumberOfElements() == 0;
  const bool isShown = this->ShowsIsosurfaces();
  // None at all, or such as the array has not, are what they are when that was asked for.
  if ((this->IsosurfacesSwitched && isShown && !this->IsosurfacesGiven) || (this->ArrayModified && !isEmpty))
  {
    auto range = vtkSMArrayRangeDomain::SafeDownCast(isovalues->GetDomain("range"));
    vtkSMProxy* colors =
      vtkSMPropertyHelper(this->GetTrueParentProxy(), "LookupTable", /*quiet*/ true).GetAsProxy();
    const unsigned int entries = range ? range->GetNumberOfEntries() : 0;
    // Behind the components, which are more than one, is the magnitude.
    unsigned int entry = entries > 1 ? entries - 1 : 0;
    if (entry > 0 && colors && vtkSMPropertyHelper(colors, "VectorMode").GetAsInt() == 1)
    {
      entry = vtkSMPropertyHelper(colors, "VectorComponent").GetAsInt();
    }
    this->IsReviewing = true;
    MoveIntoRange(isovalues, entry);
    this->IsReviewing = false;
  }
  this->IsosurfacesSwitched = false;
  this->ArrayModified = false;
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ViewUpdated(vtkSMProxy* view)
{
  this->Superclass::ViewUpdated(view);
  if (this->View != view)
  {
    this->Observe(view);
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::Observe(vtkSMProxy* view)
{
  if (this->View)
  {
    this->View->RemoveObserver(this->Observer);
  }
  this->View = view;
  if (view)
  {
    this->Observer =
      view->AddObserver(vtkCommand::EndEvent, this, &vtkSMTreeAMRVolumeRepresentationProxy::ViewRendered);
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::UpdatePropertyInformationInternal(vtkSMProperty* property)
{
  const auto isOf = [&](const char* name) { return property == this->GetProperty(name); };
  const bool isOther = !isOf("EstimatedError") && !isOf("FrameSeconds") && !isOf("DrawnCells") &&
    !isOf("DrawnLevels") && !isOf("Memory") && !isOf("FrameSamples"); // null: all
  if (isOther)
  {
    this->Superclass::UpdatePropertyInformationInternal(property);
  }
  if ((isOther && property) || !this->ObjectsCreated || this->Location == 0) // prototypes have none
  {
    return;
  }
  vtkNew<vtkTreeAMRFrameInformation> frame;
  this->GetSession()->GatherInformation(vtkPVSession::RENDER_SERVER, frame, this->GetGlobalID());
  const auto set = [&](const char* name, double value) {
    vtkSMDoubleVectorProperty::SafeDownCast(this->GetProperty(name))->SetElement(0, value);
  };
  set("EstimatedError", frame->GetEstimatedError());
  set("FrameSeconds", frame->GetSeconds());
  set("DrawnCells", frame->GetCells());
  set("DrawnLevels", frame->GetLevels());
  set("Memory", frame->GetMemory());
  set("FrameSamples", frame->GetSamples());
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ViewRendered(
  vtkObject* vtkNotUsed(view), unsigned long vtkNotUsed(event), void* interactive)
{
  if (interactive && *static_cast<int*>(interactive) == 0)
  {
    this->UpdatePropertyInformation(this->GetProperty("EstimatedError")); // and of all others of the frame
  }
}

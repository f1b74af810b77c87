#include "vtkSMTreeAMRVolumeRepresentationProxy.h"

#include "vtkCommand.h"
#include "vtkObjectFactory.h"
#include "vtkPVSession.h"
#include "vtkSMDoubleVectorProperty.h"
#include "vtkSMSession.h"
#include "vtkTreeAMRFrameInformation.h"

vtkStandardNewMacro(vtkSMTreeAMRVolumeRepresentationProxy);

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
  auto* error = vtkSMDoubleVectorProperty::SafeDownCast(this->GetProperty("EstimatedError"));
  auto* seconds = vtkSMDoubleVectorProperty::SafeDownCast(this->GetProperty("FrameSeconds"));
  const bool isOther = property != error && property != seconds; // null: all
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
  error->SetElement(0, frame->GetEstimatedError());
  seconds->SetElement(0, frame->GetSeconds());
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ViewRendered(
  vtkObject* vtkNotUsed(view), unsigned long vtkNotUsed(event), void* interactive)
{
  if (interactive && *static_cast<int*>(interactive) == 0)
  {
    this->UpdatePropertyInformation(this->GetProperty("EstimatedError")); // and of FrameSeconds
  }
}

#include "vtkSMTreeAMRVolumeRepresentationProxy.h"

#include "vtkCommand.h"
#include "vtkObjectFactory.h"
#include "vtkPVSession.h"

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
  const vtkTypeUInt32 everywhere = this->Location;
  this->Location &= vtkPVSession::RENDER_SERVER; // 0 for prototypes, which have none
  this->Superclass::UpdatePropertyInformationInternal(property);
  this->Location = everywhere;
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRVolumeRepresentationProxy::ViewRendered(
  vtkObject* vtkNotUsed(view), unsigned long vtkNotUsed(event), void* interactive)
{
  if (interactive && *static_cast<int*>(interactive) == 0)
  {
    this->UpdatePropertyInformation(this->GetProperty("EstimatedError"));
    this->UpdatePropertyInformation(this->GetProperty("FrameSeconds"));
  }
}

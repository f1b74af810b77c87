#include "vtkSMTreeAMRContourFilterProxy.h"

#include "FirstElementLink.h"

#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkSMTreeAMRContourFilterProxy);

//------------------------------------------------------------------------------
vtkSMTreeAMRContourFilterProxy::vtkSMTreeAMRContourFilterProxy() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRContourFilterProxy::~vtkSMTreeAMRContourFilterProxy() = default;

//------------------------------------------------------------------------------
void vtkSMTreeAMRContourFilterProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRContourFilterProxy::CreateVTKObjects()
{
  this->Superclass::CreateVTKObjects();
  if (this->ObjectsCreated && !this->Slider)
  {
    this->Slider = std::make_unique<FirstElementLink>();
    this->Slider->Connect(this->GetProperty("ContourValues"), this->GetProperty("FirstContourValue"));
  }
}

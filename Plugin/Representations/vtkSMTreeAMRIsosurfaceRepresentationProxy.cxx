#include "vtkSMTreeAMRIsosurfaceRepresentationProxy.h"

#include "GatheredTriangles.h"

#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkSMPropertyHelper.h"
#include "vtkTreeAMRIsosurfaceRepresentation.h"

#include <string>

vtkStandardNewMacro(vtkSMTreeAMRIsosurfaceRepresentationProxy);

//------------------------------------------------------------------------------
vtkSMTreeAMRIsosurfaceRepresentationProxy::vtkSMTreeAMRIsosurfaceRepresentationProxy() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRIsosurfaceRepresentationProxy::~vtkSMTreeAMRIsosurfaceRepresentationProxy() = default;

//------------------------------------------------------------------------------
void vtkSMTreeAMRIsosurfaceRepresentationProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ContouredArrayModified: " << this->ContouredArrayModified << endl;
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRIsosurfaceRepresentationProxy::ObjectsHaveBeenCreated()
{
  this->Superclass::ObjectsHaveBeenCreated();
  auto representation = vtkTreeAMRIsosurfaceRepresentation::SafeDownCast(this->GetClientSideObject());
  if (representation && !this->DrawsAlone())
  {
    vtkNew<GatheredTriangles> triangles;
    triangles->SetProxy(this);
    representation->SetExportedTriangles(triangles);
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRIsosurfaceRepresentationProxy::SetPropertyModifiedFlag(const char* name, int flag)
{
  const std::string property = name;
  if (flag && (property == "IsosurfaceArray" || property == "IsosurfaceComponent"))
  {
    // The isovalues' domain learns of the change after this proxy: it is asked in UpdateVTKObjects().
    this->ContouredArrayModified = true;
  }
  this->Superclass::SetPropertyModifiedFlag(name, flag);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRIsosurfaceRepresentationProxy::UpdateVTKObjects()
{
  if (this->ContouredArrayModified)
  {
    this->ContouredArrayModified = false;
    vtkSMProperty* isovalues = this->GetProperty("Isovalues");
    if (vtkSMPropertyHelper(isovalues).GetNumberOfElements() > 0)
    {
      MoveIntoRange(isovalues, 0); // of the component that is contoured
    }
  }
  this->Superclass::UpdateVTKObjects();
}

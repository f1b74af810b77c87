#include "vtkSMTreeAMRFilterProxy.h"

#include "vtkObjectFactory.h"
#include "vtkSMPropertyHelper.h"

#include <string>

vtkStandardNewMacro(vtkSMTreeAMRFilterProxy);

//------------------------------------------------------------------------------
vtkSMTreeAMRFilterProxy::vtkSMTreeAMRFilterProxy() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRFilterProxy::~vtkSMTreeAMRFilterProxy() = default;

//------------------------------------------------------------------------------
void vtkSMTreeAMRFilterProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRFilterProxy::SetPropertyModifiedFlag(const char* name, int flag)
{
  // Defaults come before the objects are created.
  const std::string property = name;
  if (flag && this->ObjectsCreated && (property == "CellDataArrays" || property == "PointDataArrays"))
  {
    vtkSMPropertyHelper(this, (property + "Chosen").c_str()).Set(1);
  }
  this->Superclass::SetPropertyModifiedFlag(name, flag);
}

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
  if (flag && this->ObjectsCreated && std::string(name) == "CellDataArrays")
  {
    vtkSMPropertyHelper(this, "CellDataArraysChosen").Set(1);
  }
  this->Superclass::SetPropertyModifiedFlag(name, flag);
}

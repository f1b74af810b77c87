#include "vtkSMTreeAMRIsosurfaceRepresentationProxy.h"

#include "vtkObjectFactory.h"
#include "vtkSMArrayRangeDomain.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"

#include <algorithm>
#include <string>
#include <vector>

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
    auto range = vtkSMArrayRangeDomain::SafeDownCast(isovalues->GetDomain("range"));
    const std::vector<double> values = vtkSMPropertyHelper(isovalues).GetDoubleArray();
    // IsInDomains() cannot be asked: in ParaView 5.11 it denies values inside a range and affirms others.
    if (range && range->GetMinimumExists(0) && range->GetMaximumExists(0) && !values.empty() &&
      std::none_of(values.begin(), values.end(),
        [&](double value) { return range->GetMinimum(0) <= value && value <= range->GetMaximum(0); }))
    {
      isovalues->ResetToDomainDefaults();
    }
  }
  this->Superclass::UpdateVTKObjects();
}

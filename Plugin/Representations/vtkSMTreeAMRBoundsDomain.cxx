#include "vtkSMTreeAMRBoundsDomain.h"

#include "vtkMath.h"
#include "vtkObjectFactory.h"
#include "vtkPVDataInformation.h"
#include "vtkSMPropertyHelper.h"

vtkStandardNewMacro(vtkSMTreeAMRBoundsDomain);

//------------------------------------------------------------------------------
vtkSMTreeAMRBoundsDomain::vtkSMTreeAMRBoundsDomain() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRBoundsDomain::~vtkSMTreeAMRBoundsDomain() = default;

//------------------------------------------------------------------------------
void vtkSMTreeAMRBoundsDomain::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

//------------------------------------------------------------------------------
int vtkSMTreeAMRBoundsDomain::SetDefaultValues(vtkSMProperty* property, bool useUnchecked)
{
  double bounds[6];
  vtkMath::UninitializeBounds(bounds);
  if (vtkPVDataInformation* const input = this->GetInputDataInformation("Input"))
  {
    input->GetBounds(bounds);
  }
  if (vtkMath::AreBoundsInitialized(bounds))
  {
    return this->Superclass::SetDefaultValues(property, useUnchecked);
  }
  vtkSMPropertyHelper helper(property);
  helper.SetUseUnchecked(useUnchecked);
  helper.Set(0, 0.);
  return 1;
}

#include "vtkSMTreeAMRRangeDomain.h"

#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <cmath>
#include <vector>

vtkStandardNewMacro(vtkSMTreeAMRRangeDomain);

//------------------------------------------------------------------------------
vtkSMTreeAMRRangeDomain::vtkSMTreeAMRRangeDomain() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRRangeDomain::~vtkSMTreeAMRRangeDomain() = default;

//------------------------------------------------------------------------------
void vtkSMTreeAMRRangeDomain::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRangeDomain::Update(vtkSMProperty* property)
{
  this->Superclass::Update(property);
  bool isFinite = true;
  const auto count = static_cast<int>(this->GetNumberOfEntries());
  for (int i = 0; i < count; ++i)
  {
    isFinite = isFinite && std::isfinite(this->GetMinimum(i)) && std::isfinite(this->GetMaximum(i));
  }
  if (isFinite)
  {
    return;
  }

  const vtkSMUncheckedPropertyHelper input(this->GetRequiredProperty("Input"));
  const vtkSMUncheckedPropertyHelper array(this->GetRequiredProperty("ArraySelection"));
  vtkSMProperty* selection = this->GetRequiredProperty("ComponentSelection");
  auto producer = vtkSMSourceProxy::SafeDownCast(input.GetAsProxy());
  const vtkPVArrayInformation* information = producer
    ? producer->GetDataInformation(input.GetOutputPort())
        ->GetArrayInformation(array.GetAsString(4), array.GetAsInt(3))
    : nullptr;
  if (!information)
  {
    return;
  }
  std::vector<vtkEntry> entries(count);
  for (int i = 0; i < count; ++i)
  {
    // One entry for a chosen component, else one each; behind them is the magnitude.
    const int component = selection ? vtkSMUncheckedPropertyHelper(selection).GetAsInt() : i;
    const double* range =
      information->GetComponentFiniteRange(component < information->GetNumberOfComponents() ? component : -1);
    if (range[0] <= range[1])
    {
      entries[i].Valid[0] = entries[i].Valid[1] = true;
      entries[i].Value = vtkTuple<double, 2>(range);
    }
  }
  this->SetEntries(entries);
}

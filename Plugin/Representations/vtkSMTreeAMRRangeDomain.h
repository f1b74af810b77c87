// As ParaView's ArrayRangeDomain, of the finite values alone: an isovalue in the middle of a range up to infinity
// would be no number.

#ifndef vtkSMTreeAMRRangeDomain_h
#define vtkSMTreeAMRRangeDomain_h

#include "vtkSMArrayRangeDomain.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRRangeDomain : public vtkSMArrayRangeDomain
{
public:
  static vtkSMTreeAMRRangeDomain* New();
  vtkTypeMacro(vtkSMTreeAMRRangeDomain, vtkSMArrayRangeDomain);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void Update(vtkSMProperty* property) override;

protected:
  vtkSMTreeAMRRangeDomain();
  ~vtkSMTreeAMRRangeDomain() override;

private:
  vtkSMTreeAMRRangeDomain(const vtkSMTreeAMRRangeDomain&) = delete;
  void operator=(const vtkSMTreeAMRRangeDomain&) = delete;
};

#endif

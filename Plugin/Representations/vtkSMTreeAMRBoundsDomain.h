// As ParaView's BoundsDomain, but of bounds that it does not know, as of mirrored hyper tree grids of VTK 9.3 and 9.6, the
// default is 0: the representation, which knows them, is to choose. BoundsDomain has a negative length, or that of a unit cube.

#ifndef vtkSMTreeAMRBoundsDomain_h
#define vtkSMTreeAMRBoundsDomain_h

#include "vtkSMBoundsDomain.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRBoundsDomain : public vtkSMBoundsDomain
{
public:
  static vtkSMTreeAMRBoundsDomain* New();
  vtkTypeMacro(vtkSMTreeAMRBoundsDomain, vtkSMBoundsDomain);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  int SetDefaultValues(vtkSMProperty* property, bool useUnchecked) override;

protected:
  vtkSMTreeAMRBoundsDomain();
  ~vtkSMTreeAMRBoundsDomain() override;

private:
  vtkSMTreeAMRBoundsDomain(const vtkSMTreeAMRBoundsDomain&) = delete;
  void operator=(const vtkSMTreeAMRBoundsDomain&) = delete;
};

#endif

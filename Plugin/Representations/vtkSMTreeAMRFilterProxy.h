// What the filters that offer arrays of their input share: an empty list of arrays that somebody has chosen means none,
// in saved states, too. Before that it means all: the input may not have told of its arrays yet.

#ifndef vtkSMTreeAMRFilterProxy_h
#define vtkSMTreeAMRFilterProxy_h

#include "vtkSMSourceProxy.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRFilterProxy : public vtkSMSourceProxy
{
public:
  static vtkSMTreeAMRFilterProxy* New();
  vtkTypeMacro(vtkSMTreeAMRFilterProxy, vtkSMSourceProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkSMTreeAMRFilterProxy();
  ~vtkSMTreeAMRFilterProxy() override;

  void SetPropertyModifiedFlag(const char* name, int flag) override;

private:
  vtkSMTreeAMRFilterProxy(const vtkSMTreeAMRFilterProxy&) = delete;
  void operator=(const vtkSMTreeAMRFilterProxy&) = delete;
};

#endif

// The slider for the first isovalue of the filter Tree AMR Contour.

#ifndef vtkSMTreeAMRContourFilterProxy_h
#define vtkSMTreeAMRContourFilterProxy_h

#include "vtkSMTreeAMRFilterProxy.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

#include <memory> // for std::unique_ptr

class FirstElementLink;

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRContourFilterProxy : public vtkSMTreeAMRFilterProxy
{
public:
  static vtkSMTreeAMRContourFilterProxy* New();
  vtkTypeMacro(vtkSMTreeAMRContourFilterProxy, vtkSMTreeAMRFilterProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkSMTreeAMRContourFilterProxy();
  ~vtkSMTreeAMRContourFilterProxy() override;

  void CreateVTKObjects() override;

private:
  vtkSMTreeAMRContourFilterProxy(const vtkSMTreeAMRContourFilterProxy&) = delete;
  void operator=(const vtkSMTreeAMRContourFilterProxy&) = delete;

  std::unique_ptr<FirstElementLink> Slider;
};

#endif

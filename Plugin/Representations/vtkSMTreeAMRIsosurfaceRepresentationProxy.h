// Keeps isovalues inside the range of the contoured array: when another array or component is chosen and none of
// them lies inside its range, they become the one in the middle that they start with. Else nothing would be shown.
//
// Exporters, which run on the client, get the triangles of all processes that render when these are others than itself.

#ifndef vtkSMTreeAMRIsosurfaceRepresentationProxy_h
#define vtkSMTreeAMRIsosurfaceRepresentationProxy_h

#include "vtkSMTreeAMRRepresentationProxy.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRIsosurfaceRepresentationProxy
  : public vtkSMTreeAMRRepresentationProxy
{
public:
  static vtkSMTreeAMRIsosurfaceRepresentationProxy* New();
  vtkTypeMacro(vtkSMTreeAMRIsosurfaceRepresentationProxy, vtkSMTreeAMRRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void UpdateVTKObjects() override;

protected:
  vtkSMTreeAMRIsosurfaceRepresentationProxy();
  ~vtkSMTreeAMRIsosurfaceRepresentationProxy() override;

  void ObjectsHaveBeenCreated() override;
  void SetPropertyModifiedFlag(const char* name, int flag) override;

private:
  vtkSMTreeAMRIsosurfaceRepresentationProxy(const vtkSMTreeAMRIsosurfaceRepresentationProxy&) = delete;
  void operator=(const vtkSMTreeAMRIsosurfaceRepresentationProxy&) = delete;

  bool ContouredArrayModified = false;
};

#endif

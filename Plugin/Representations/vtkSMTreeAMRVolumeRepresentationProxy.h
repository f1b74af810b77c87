// Fetches what the last still frame's error and time were as soon as the view has rendered it, so that the panel and
// Python show them: else ParaView asks for information properties only when told to. All processes that render are
// asked: ParaView would ask the client's representation, which draws nothing where there is a server.

#ifndef vtkSMTreeAMRVolumeRepresentationProxy_h
#define vtkSMTreeAMRVolumeRepresentationProxy_h

#include "vtkSMRepresentationProxy.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro
#include "vtkWeakPointer.h"                  // for View

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRVolumeRepresentationProxy : public vtkSMRepresentationProxy
{
public:
  static vtkSMTreeAMRVolumeRepresentationProxy* New();
  vtkTypeMacro(vtkSMTreeAMRVolumeRepresentationProxy, vtkSMRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void ViewUpdated(vtkSMProxy* view) override;

protected:
  vtkSMTreeAMRVolumeRepresentationProxy();
  ~vtkSMTreeAMRVolumeRepresentationProxy() override;

  void UpdatePropertyInformationInternal(vtkSMProperty* property) override;

private:
  vtkSMTreeAMRVolumeRepresentationProxy(const vtkSMTreeAMRVolumeRepresentationProxy&) = delete;
  void operator=(const vtkSMTreeAMRVolumeRepresentationProxy&) = delete;

  void Observe(vtkSMProxy* view);
  void ViewRendered(vtkObject* view, unsigned long event, void* interactive);

  vtkWeakPointer<vtkSMProxy> View;
  unsigned long Observer = 0;
};

#endif

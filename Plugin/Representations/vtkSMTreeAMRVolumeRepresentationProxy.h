// Fetches what the last still frame's error and time were as soon as the view has rendered it, so that the panel and
// Python show them: else ParaView asks for information properties only when told to. All processes that render are
// asked: ParaView would ask the client's representation, which draws nothing where there is a server.
//
// A volume without an array to colour by gets one when it is chosen as the representation, as ParaView's own type Volume
// does, of which ParaView knows by name alone; in a GUI the legend is shown. Isosurfaces that are switched on start at the
// middle of that array's range.

#ifndef vtkSMTreeAMRVolumeRepresentationProxy_h
#define vtkSMTreeAMRVolumeRepresentationProxy_h

#include "vtkSMTreeAMRRepresentationProxy.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro
#include "vtkWeakPointer.h"                  // for View

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRVolumeRepresentationProxy
  : public vtkSMTreeAMRRepresentationProxy
{
public:
  static vtkSMTreeAMRVolumeRepresentationProxy* New();
  vtkTypeMacro(vtkSMTreeAMRVolumeRepresentationProxy, vtkSMTreeAMRRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void UpdateVTKObjects() override;
  void ViewUpdated(vtkSMProxy* view) override;

protected:
  vtkSMTreeAMRVolumeRepresentationProxy();
  ~vtkSMTreeAMRVolumeRepresentationProxy() override;

  void ObjectsHaveBeenCreated() override;
  bool ShowsIsosurfaces() override;
  void SetPropertyModifiedFlag(const char* name, int flag) override;
  void UpdatePropertyInformationInternal(vtkSMProperty* property) override;

private:
  vtkSMTreeAMRVolumeRepresentationProxy(const vtkSMTreeAMRVolumeRepresentationProxy&) = delete;
  void operator=(const vtkSMTreeAMRVolumeRepresentationProxy&) = delete;

  void PanelModified(vtkObject* panel, unsigned long event, void* name);
  void ChooseArray();
  void ReviewIsosurfaces();
  void Observe(vtkSMProxy* view);
  void ViewRendered(vtkObject* view, unsigned long event, void* interactive);

  bool ArrayModified = false;
  bool IsosurfacesSwitched = false;
  bool IsosurfacesGiven = false; // by whomever but this object
  bool IsReviewing = false;

  vtkWeakPointer<vtkSMProxy> View;
  unsigned long Observer = 0;
};

#endif

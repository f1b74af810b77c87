// What the proxies of the volume and the isosurface representation share: the panel of the representation that they
// belong to, and isovalues that are inside the range of their array.
//
// A single isovalue, which has a slider in the panel, is the first of the list. While the mouse drags it the view shows
// drafts, where this process draws alone:
//
//     <IsovalueSlider list="Isovalues" first="FirstIsovalue" representation="Tree AMR Isosurface"
//                     other="IsosurfaceValues"/>
//
// The two have lists of their own, as they may show different arrays. Who gives values to the list of the one while
// the other shows isosurfaces of the values it had is told so once: the names are easily mistaken.
//
// The panel's properties are mostly ParaView's own, of all ways to show a grid together. The elements PanelDecorator
// among a proxy's hints say when which of them is of no use:
//
//     <PanelDecorator properties="PointSize LineWidth">
//       <PropertyWidgetDecorator type="GenericDecorator" mode="visibility" .../>
//     </PanelDecorator>

#ifndef vtkSMTreeAMRRepresentationProxy_h
#define vtkSMTreeAMRRepresentationProxy_h

#include "vtkSMRepresentationProxy.h"
#include "vtkTreeAMRRepresentationsModule.h" // for the export macro

#include <memory> // for std::unique_ptr
#include <string>

class FirstElementLink;
class SliderPreview;
class vtkSMViewProxy;
class vtkPVXMLElement;

class VTKTREEAMRREPRESENTATIONS_EXPORT vtkSMTreeAMRRepresentationProxy : public vtkSMRepresentationProxy
{
public:
  static vtkSMTreeAMRRepresentationProxy* New();
  vtkTypeMacro(vtkSMTreeAMRRepresentationProxy, vtkSMRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void ViewUpdated(vtkSMProxy* view) override;

protected:
  vtkSMTreeAMRRepresentationProxy();
  ~vtkSMTreeAMRRepresentationProxy() override;

  void CreateVTKObjects() override;
  /// Once, when the objects are there; not of a prototype.
  virtual void ObjectsHaveBeenCreated();
  void SetPropertyModifiedFlag(const char* name, int flag) override;
  /// Whether this process draws, and no other.
  bool DrawsAlone();
  /// Whether the list of isovalues counts when the representation is this one.
  virtual bool ShowsIsosurfaces() { return true; }

  /// Makes a list of isovalues the single one in the middle of their domain "range" when none of them lies inside.
  /// entry: of the domain, a component of the array, or behind these its magnitude.
  void MoveIntoRange(vtkSMProperty* isovalues, unsigned int entry);

private:
  vtkSMTreeAMRRepresentationProxy(const vtkSMTreeAMRRepresentationProxy&) = delete;
  void operator=(const vtkSMTreeAMRRepresentationProxy&) = delete;

  void DecoratePanel(vtkPVXMLElement* decorator);
  void ReviewIsovalues();
  vtkSMViewProxy* GetDrawnView();

  std::unique_ptr<FirstElementLink> Slider;
  std::unique_ptr<SliderPreview> Preview;
  std::string Representation;  // what the panel calls this one
  std::string List;            // of its isovalues: the property's name
  std::string OtherList;       // that of the other representation
  bool IsovaluesGiven = false; // since the last update of the view, by whomever but this object
  bool IsMoving = false;
  bool HasWarned = false;
};

#endif

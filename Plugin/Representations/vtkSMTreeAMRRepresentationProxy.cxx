#include "vtkSMTreeAMRRepresentationProxy.h"

#include "FirstElementLink.h"
#include "SliderPreview.h"

#include "vtkClientServerStream.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVSession.h"
#include "vtkPVXMLElement.h"
#include "vtkSMArrayRangeDomain.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSession.h"
#include "vtkSMViewProxy.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

vtkStandardNewMacro(vtkSMTreeAMRRepresentationProxy);

namespace
{

/// Adds the elements in `decorator` to the hints of a property; its own are those of all properties of its kind.
void decorate(vtkSMProperty* property, vtkPVXMLElement* decorator)
{
  vtkNew<vtkPVXMLElement> hints;
  hints->SetName("Hints");
  for (vtkPVXMLElement* element : { property->GetHints(), decorator })
  {
    for (unsigned int i = 0; element && i < element->GetNumberOfNestedElements(); ++i)
    {
      hints->AddNestedElement(element->GetNestedElement(i), /*setParent*/ 0);
    }
  }
  property->SetHints(hints);
}

} // anonymous namespace

//------------------------------------------------------------------------------
vtkSMTreeAMRRepresentationProxy::vtkSMTreeAMRRepresentationProxy() = default;

//------------------------------------------------------------------------------
vtkSMTreeAMRRepresentationProxy::~vtkSMTreeAMRRepresentationProxy() = default;

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::CreateVTKObjects()
{
  const bool were = this->ObjectsCreated;
  this->Superclass::CreateVTKObjects();
  if (!were && this->ObjectsCreated && this->Location != 0)
  {
    this->ObjectsHaveBeenCreated();
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::ObjectsHaveBeenCreated()
{
  vtkPVXMLElement* hints = this->GetHints();
  for (unsigned int i = 0; hints && i < hints->GetNumberOfNestedElements(); ++i)
  {
    vtkPVXMLElement* hint = hints->GetNestedElement(i);
    if (std::string(hint->GetName()) == "PanelDecorator")
    {
      this->DecoratePanel(hint);
    }
    else if (std::string(hint->GetName()) == "IsovalueSlider")
    {
      this->Slider = std::make_unique<FirstElementLink>();
      this->Slider->Connect(
        this->GetProperty(hint->GetAttribute("list")), this->GetProperty(hint->GetAttribute("first")));
      this->List = hint->GetAttribute("list");
      this->Preview = std::make_unique<SliderPreview>();
      this->Preview->Connect(
        this->GetProperty(hint->GetAttribute("first")), [this] { return this->GetDrawnView(); },
        [this](double value) {
          vtkClientServerStream stream;
          stream << vtkClientServerStream::Invoke << VTKOBJECT(this)
                 << this->GetProperty(this->List.c_str())->GetCommand() << 0 << value
                 << vtkClientServerStream::End;
          this->ExecuteStream(stream);
        });
      this->Representation = hint->GetAttribute("representation");
      this->OtherList = hint->GetAttribute("other");
    }
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::SetPropertyModifiedFlag(const char* name, int flag)
{
  this->IsovaluesGiven |= flag && !this->IsMoving && name == this->List;
  this->Superclass::SetPropertyModifiedFlag(name, flag);
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::ViewUpdated(vtkSMProxy* view)
{
  this->Superclass::ViewUpdated(view);
  this->ReviewIsovalues();
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::ReviewIsovalues()
{
  vtkSMProxy* panel = this->GetTrueParentProxy();
  vtkSMProperty* otherList = panel->GetProperty(this->OtherList.c_str());
  auto other = vtkSMTreeAMRRepresentationProxy::SafeDownCast(otherList ? otherList->GetParent() : nullptr);
  const std::string shown = vtkSMPropertyHelper(panel, "Representation").GetAsString();
  if (!other || shown == this->Representation)
  {
    return; // the other one looks at both
  }
  // Domains give both lists the same values.
  const bool areOther = vtkSMPropertyHelper(this, this->List.c_str()).GetDoubleArray() !=
    vtkSMPropertyHelper(otherList).GetDoubleArray();
  if (this->IsovaluesGiven && !other->IsovaluesGiven && areOther && shown == other->Representation &&
    other->ShowsIsosurfaces() && !this->HasWarned)
  {
    vtkWarningMacro("" << this->List << " are the isosurfaces of the representation " << this->Representation
                       << ", those of " << shown << " are " << other->List << ".");
    this->HasWarned = true;
  }
  this->IsovaluesGiven = false;
  other->IsovaluesGiven = false;
}

//------------------------------------------------------------------------------
bool vtkSMTreeAMRRepresentationProxy::DrawsAlone()
{
  vtkSMSession* session = this->GetSession();
  return (session->GetProcessRoles() & vtkPVSession::RENDER_SERVER) != 0 &&
    session->GetNumberOfProcesses(vtkPVSession::RENDER_SERVER) == 1;
}

//------------------------------------------------------------------------------
vtkSMViewProxy* vtkSMTreeAMRRepresentationProxy::GetDrawnView()
{
  vtkSMProxy* panel = this->GetTrueParentProxy();
  const bool isDrawn = this->DrawsAlone() && this->ShowsIsosurfaces() &&
    vtkSMPropertyHelper(panel, "Representation").GetAsString() == this->Representation;
  return isDrawn ? vtkSMViewProxy::FindView(panel) : nullptr;
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::DecoratePanel(vtkPVXMLElement* decorator)
{
  vtkSMProxy* panel = this->GetTrueParentProxy();
  std::istringstream names(decorator->GetAttributeOrEmpty("properties"));
  for (std::string name; names >> name;)
  {
    // Other releases of ParaView may have fewer.
    if (vtkSMProperty* property = panel->GetProperty(name.c_str()))
    {
      decorate(property, decorator);
    }
  }
}

//------------------------------------------------------------------------------
void vtkSMTreeAMRRepresentationProxy::MoveIntoRange(vtkSMProperty* isovalues, unsigned int entry)
{
  auto range = vtkSMArrayRangeDomain::SafeDownCast(isovalues->GetDomain("range"));
  // IsInDomains() cannot be asked: in ParaView 5.11 it denies values inside a range and affirms others.
  if (range && range->GetMinimumExists(entry) && range->GetMaximumExists(entry))
  {
    const double low = range->GetMinimum(entry), high = range->GetMaximum(entry);
    const std::vector<double> values = vtkSMPropertyHelper(isovalues).GetDoubleArray();
    if (std::none_of(
          values.begin(), values.end(), [&](double value) { return low <= value && value <= high; }))
    {
      this->IsMoving = true;
      vtkSMPropertyHelper helper(isovalues);
      helper.SetNumberOfElements(1);
      helper.Set(low + 0.5 * (high - low));
      this->IsMoving = false;
    }
  }
}

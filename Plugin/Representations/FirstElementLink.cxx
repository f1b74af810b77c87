#include "FirstElementLink.h"

#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"

//------------------------------------------------------------------------------
FirstElementLink::~FirstElementLink()
{
  if (this->List)
  {
    this->List->RemoveObserver(this->ListObserver);
  }
  if (this->First)
  {
    this->First->RemoveObserver(this->FirstObserver);
  }
}

//------------------------------------------------------------------------------
void FirstElementLink::Connect(vtkSMProperty* list, vtkSMProperty* first)
{
  this->List = list;
  this->First = first;
  this->ListObserver = list->AddObserver(vtkCommand::ModifiedEvent, this, &FirstElementLink::ListModified);
  this->FirstObserver = first->AddObserver(vtkCommand::ModifiedEvent, this, &FirstElementLink::FirstModified);
  this->ListModified();
}

//------------------------------------------------------------------------------
template <class Set>
void FirstElementLink::Change(const Set& set)
{
  // Each change would call the other for ever: a NaN never is the value that a property has already.
  if (!this->IsChanging)
  {
    this->IsChanging = true;
    set();
    this->IsChanging = false;
  }
}

//------------------------------------------------------------------------------
void FirstElementLink::ListModified()
{
  vtkSMPropertyHelper list(this->List);
  if (list.GetNumberOfElements() > 0)
  {
    this->Change([&] { vtkSMPropertyHelper(this->First).Set(list.GetAsDouble(0)); });
  }
}

//------------------------------------------------------------------------------
void FirstElementLink::FirstModified()
{
  this->Change(
    [&] { vtkSMPropertyHelper(this->List).Set(0, vtkSMPropertyHelper(this->First).GetAsDouble()); });
}

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
void FirstElementLink::ListModified()
{
  // A property that has the value already is not modified: the two do not call each other for ever.
  vtkSMPropertyHelper list(this->List);
  if (list.GetNumberOfElements() > 0)
  {
    vtkSMPropertyHelper(this->First).Set(list.GetAsDouble(0));
  }
}

//------------------------------------------------------------------------------
void FirstElementLink::FirstModified()
{
  vtkSMPropertyHelper(this->List).Set(0, vtkSMPropertyHelper(this->First).GetAsDouble());
}

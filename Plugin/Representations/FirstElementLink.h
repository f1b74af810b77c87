// A property of one value that is the first of another property's list: ParaView's panels have a slider for single
// values only.
#pragma once

#include "vtkWeakPointer.h"

class vtkSMProperty;

class FirstElementLink
{
public:
  FirstElementLink() = default;
  ~FirstElementLink();
  FirstElementLink(const FirstElementLink&) = delete;
  FirstElementLink& operator=(const FirstElementLink&) = delete;

  /// From now on whichever is changed changes the other, once. An empty list gets its first element.
  void Connect(vtkSMProperty* list, vtkSMProperty* first);

private:
  template <class Set>
  void Change(const Set& set);
  void ListModified();
  void FirstModified();

  vtkWeakPointer<vtkSMProperty> List;
  vtkWeakPointer<vtkSMProperty> First;
  unsigned long ListObserver = 0;
  unsigned long FirstObserver = 0;
  bool IsChanging = false;
};

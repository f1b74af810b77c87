// Memory for VTK's arrays on large pages (LargeArray.h). Private to the module.
#pragma once

#include "LargeArray.h"

#include "vtkAOSDataArrayTemplate.h"

namespace treeamr
{

/// As SetNumberOfTuples() of an array without values, which are undefined then. Throws std::bad_alloc.
template <class T>
void allocateTuples(vtkAOSDataArrayTemplate<T>* array, vtkIdType tuples)
{
  const auto count = static_cast<std::size_t>(tuples) * array->GetNumberOfComponents();
  if (count * sizeof(T) < largeArrayBytes)
  {
    array->SetNumberOfTuples(tuples);
    return;
  }
  array->SetArray(LargeAllocator<T>().allocate(count), static_cast<vtkIdType>(count), 0,
    vtkAbstractArray::VTK_DATA_ARRAY_USER_DEFINED);
  // VTK does not tell how many bytes they are: none go back to the system before their time.
  array->SetArrayFreeFunction([](void* memory) { releaseLarge(memory, 0); });
}

} // namespace treeamr

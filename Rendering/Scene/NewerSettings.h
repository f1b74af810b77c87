// Settings of volumes that VTK has from 9.2 on; in 9.1 they are as if they were not given.
#pragma once

#include "vtkVersionMacros.h"
#include "vtkVolumeMapper.h"
#include "vtkVolumeProperty.h"

namespace treeamr
{

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0)

inline bool computesNormalFromOpacity(vtkVolumeMapper& mapper)
{
  return mapper.GetComputeNormalFromOpacity();
}

inline void computeNormalFromOpacity(vtkVolumeMapper& mapper, bool does)
{
  mapper.SetComputeNormalFromOpacity(does);
}

inline float scatteringAnisotropy(vtkVolumeProperty& property)
{
  return property.GetScatteringAnisotropy();
}

#else

inline bool computesNormalFromOpacity(vtkVolumeMapper&)
{
  return false;
}

inline void computeNormalFromOpacity(vtkVolumeMapper&, bool) {}

inline float scatteringAnisotropy(vtkVolumeProperty&)
{
  return 0.f;
}

#endif

} // namespace treeamr

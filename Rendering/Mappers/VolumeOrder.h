// In which order several volumes of one renderer lie before the eye. Private to the module.
#pragma once

#include <vector>

class vtkRenderer;
class vtkVolume;

namespace treeamr
{

/// Those of vtkTreeAMRVolumeMapper that the renderer has itself, visible, not culled, and with an input.
struct VolumeOrder
{
  std::vector<vtkVolume*> volumes; // nearest first
  vtkVolume* first = nullptr;      // that VTK asks to draw
  vtkVolume* overlapping =
    nullptr; // whose box no plane along a face of its own or of another's parts from all others
};

VolumeOrder orderVolumes(vtkRenderer* renderer);

} // namespace treeamr

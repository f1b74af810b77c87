// In which order several volumes of one renderer lie before the eye. Private to the module.
#pragma once

#include <utility>
#include <vector>

class vtkRenderer;
class vtkVolume;

namespace treeamr
{

/// Those of vtkTreeAMRVolumeMapper that the renderer has itself, visible, not culled, and with an input.
struct VolumeOrder
{
  std::vector<vtkVolume*> volumes; // nearest first
  /// Of each volume, from where to where it is along the direction of projection, from the eye's plane on.
  std::vector<std::pair<double, double>> extents;
  vtkVolume* first = nullptr; // that VTK asks to draw
  /// Along the same direction, what holds all that boxes have in common that no plane along a face of either parts;
  /// empty: there is nothing.
  std::pair<double, double> overlap{ 0., 0. };
  bool isLayered = true; // none of these volumes blends values

  bool overlaps() const noexcept { return overlap.first < overlap.second; }
};

VolumeOrder orderVolumes(vtkRenderer* renderer);

} // namespace treeamr

// VTK's distance between the samples of a ray in terms of cells. Private to the module.
#pragma once

class vtkProp3D;

namespace treeamr
{

class Octree;

/// Samples along a cell's width that leave no two of a ray further apart than `distance` (above 0, in the world) anywhere
/// in a volume: the widest cells decide.
double samplesPerCellFor(double distance, const Octree& octree, vtkProp3D* volume);

} // namespace treeamr

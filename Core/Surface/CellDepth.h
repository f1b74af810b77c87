// Level of detail: how deep the cells of an octree are that a camera can tell apart.
#pragma once

#include "Geometry/Camera.h"
#include "Octree/Octree.h"

namespace treeamr
{

/// The least depth of cells that are at most so many pixels wide wherever the camera sees them (a root's is 0), up
/// to that of the deepest leaves: from inside the domain nothing is small.
int cellDepthFor(const Octree& octree, const Camera& camera, double pixels);

} // namespace treeamr

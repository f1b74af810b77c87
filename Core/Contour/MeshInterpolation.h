// What fields are at the points of a contour. Values at them are in Contour.h, which is public.
#pragma once

#include "Contour/Contour.h"

namespace treeamr
{

/// Interpolates between the vertex gradients (BlockGradients.h) at the points of a mesh on the field's octree.
std::vector<std::array<double, 3>> interpolateGradients(const Field& field, const ContourMesh& mesh);

} // namespace treeamr

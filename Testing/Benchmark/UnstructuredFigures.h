// Speed and memory of making a vtkHyperTreeGrid from hexahedra.
#pragma once

#include "Report.h"
#include "Scene.h"

#include <vector>

namespace treeamr::bench
{

/// Of hexahedra with eight points each in double, one array of double: in the forest's order, as real writers leave them,
/// in none, and shrunk as by p8est_vtk. Memory is what is resident beyond input and output at most. Throws Error for a grid of other cells.
std::vector<Figure> unstructuredFigures(const Forest& forest);

} // namespace treeamr::bench

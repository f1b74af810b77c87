// The cells that a process has of a forest in memory as a hyper tree grid, with one field.
#pragma once

#include "vtkSmartPointer.h"

#include <p8est.h>

#include <cstddef>

class vtkHyperTreeGrid;

namespace treeamr::test
{

/// forest: a brick of boxes along the axes. name: of the cell array. offset: of the field's double in what a quadrant carries. Where
/// other processes have the quadrants the grid is masked; its copy of the field is all that it takes of the forest.
vtkSmartPointer<vtkHyperTreeGrid> gridOfForest(const p8est_t& forest, const char* name, std::size_t offset);

} // namespace treeamr::test

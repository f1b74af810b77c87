// The range of an array over all processes, kept with each one's part of it: what floats are rounded by has to be the same
// everywhere for fields to agree where they meet. Private to the module.
#pragma once

#include "vtkSmartPointer.h"

#include <array>
#include <optional>
#include <string>

class vtkHyperTreeGrid;

namespace treeamr
{

class ProcessGroup;

/// Of all cell arrays of numbers that the grid has. Every process calls it; those without the array, or a grid, have no part in
/// it. Returns a copy of the grid that has them as field data, or itself when it may change; null for null.
vtkSmartPointer<vtkHyperTreeGrid> withWholeRanges(
  const ProcessGroup& group, vtkHyperTreeGrid* grid, bool mayChange);

/// Of a component of an array or, below 0, the magnitude. None where nobody has agreed on one.
std::optional<std::array<double, 2>> wholeRange(
  vtkHyperTreeGrid& grid, const std::string& array, int component);

} // namespace treeamr

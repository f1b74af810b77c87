// Which cell arrays of a grid the filters take. Private to the module.
#pragma once

#include <string>
#include <vector>

class vtkDataArraySelection;
class vtkHyperTreeGrid;

namespace treeamr
{

/// Names of the arrays that are enabled, or of all arrays as long as the selection knows none and is not
/// `final`, in the grid's order.
/// Without ghost marks, arrays that are not of numbers and those without a name; with the enabled ones that the
/// grid has not: acquireField() says so.
std::vector<std::string> takenArrays(vtkHyperTreeGrid& grid, vtkDataArraySelection& selection, bool final);

} // namespace treeamr

// Which cell arrays of a grid the filters take, and what they have to say of them. Private to the module.
#pragma once

#include <string>
#include <vector>

class vtkDataArray;
class vtkDataArraySelection;
class vtkHyperTreeGrid;

namespace treeamr
{

/// Names of the arrays that are enabled, or of all arrays as long as the selection knows none, in the grid's order.
/// Without ghost marks, arrays that are not of numbers and those without a name; with the enabled ones that the grid has
/// not: acquireField() says so.
std::vector<std::string> takenArrays(vtkHyperTreeGrid& grid, vtkDataArraySelection& selection);

/// What to tell the user of whole numbers beyond those that are all exact in single precision; empty for others.
std::string roundedIntegers(vtkDataArray& array);

} // namespace treeamr

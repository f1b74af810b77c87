// One vtkHyperTreeGrid of several: the pieces of one simulation, the halves of a mirrored domain.
#pragma once

#include "vtkTreeAMRReaderModule.h" // for the export macro

#include <string>
#include <vector>

class vtkDataObject;
class vtkHyperTreeGrid;

namespace treeamr
{

/// name: for messages. flatIndex: of its block in a composite data set, else 1.
struct NamedGrid
{
  vtkHyperTreeGrid* grid;
  std::string name;
  unsigned int flatIndex = 1;
};

/// Those of a vtkHyperTreeGrid or of a composite data set that have trees.
VTKTREEAMRREADER_EXPORT std::vector<NamedGrid> gridsWithTrees(vtkDataObject* input);

/// What else there is in a composite data set, for messages.
VTKTREEAMRREADER_EXPORT std::vector<std::string> blocksOfOtherKinds(vtkDataObject* input);

/// grids: one or more. Each of their roots must lie between neighbouring planes of the lattice that the planes of all form;
/// of cells at one place the first grid's counts, and none that are masked, hidden or ghosts. Cell arrays are those that all
/// grids have alike; the depth limit is that of the grid with the deepest. Returns what is wrong with others, for messages. merged: an empty grid; it gets the first grid's arrays
/// and trees themselves when there is but one. Throws Error for grids that are on no lattice and cells that overlap, naming
/// them.
VTKTREEAMRREADER_EXPORT std::vector<std::string> mergeGrids(
  const std::vector<NamedGrid>& grids, vtkHyperTreeGrid* merged);

} // namespace treeamr

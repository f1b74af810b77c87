// Which box of the domain a process draws of a grid that it shares with others: what a vtkHyperTreeGrid has to hold so that
// the field in its box is that of all cells together, and who has the others.
//
// It goes with the grid through filters, as field data. The cells beyond the box are marked DUPLICATECELL like all that
// another process counts, also those that only reach into it.
#pragma once

#include "vtkTreeAMRReaderModule.h" // for the export macro

#include "Geometry/RayStops.h"
#include "Partition/LatticeBox.h"

#include <optional>
#include <vector>

class vtkHyperTreeGrid;

namespace treeamr
{

struct GridPartition
{
  std::vector<LatticeBox> boxes; // by process, disjoint, all of the domain
  int own = 0;

  const LatticeBox& box() const noexcept { return boxes[static_cast<std::size_t>(own)]; }
  bool operator==(const GridPartition&) const = default;
};

/// grid: with its lattice; boxes count along its own axes.
VTKTREEAMRREADER_EXPORT void setPartition(vtkHyperTreeGrid& grid, const GridPartition& partition);

/// None when the grid has not got one, or one that is not for its lattice (of a filter that cuts out a part). Boxes are on the
/// lattice of the grid's octree: that of increasing coordinates.
VTKTREEAMRREADER_EXPORT std::optional<GridPartition> partitionOf(vtkHyperTreeGrid& grid);

/// What keeps a picture in the grid's box, in data coordinates: its faces inside the domain. None for grids without one.
VTKTREEAMRREADER_EXPORT std::vector<HalfSpace> partitionFaces(vtkHyperTreeGrid& grid);

} // namespace treeamr

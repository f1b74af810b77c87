// Where the trees of a p4est connectivity sit on one lattice.
//
// Each tree must be an axis-aligned box in identity orientation (its axes point along x, y and z) between
// neighbouring planes of the lattice that the boxes of all trees form. Unit cube and brick connectivities are
// such, periodic or not, scaled or stretched along an axis, with trees left out; rotated, twisted and curved
// ones are not.
#pragma once

#include "Forest/P4estForestFile.h"
#include "Forest/TreeLattice.h"

namespace treeamr
{

/// Throws Error naming the file, the tree that does not fit, what was found and what is allowed.
TreeLattice p4estTreeLattice(const P4estForestFile& file);

} // namespace treeamr

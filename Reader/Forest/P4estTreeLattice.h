// Where the trees of a p4est connectivity sit on one lattice.
//
// Each tree must be an axis-aligned box, turned or reflected in any way, between neighbouring planes of the lattice that
// the boxes of all trees form. Bricks are such, periodic or not, scaled or stretched along an axis, with trees left out;
// sheared and curved ones are not. In a connectivity that is topology alone (deal.II's) the trees are laid out from face
// to face as equal boxes. The trees of two dimensions must be rectangles across z, all at one.
#pragma once

#include "Forest/P4estForestFile.h"
#include "Forest/TreeLattice.h"

#include <array>

namespace treeamr
{

/// Where the first tree begins and how wide trees are that have no vertices.
struct UnitBoxes
{
  std::array<double, 3> origin{ 0., 0., 0. };
  std::array<double, 3> spacing{ 1., 1., 1. };
};

/// boxes: used only without vertices. Throws Error naming the file, the tree that does not fit, what was found and what is
/// allowed, and for a spacing that is not positive or planes that no double tells apart.
TreeLattice p4estTreeLattice(const P4estForestFile& file, const UnitBoxes& boxes = {});

} // namespace treeamr

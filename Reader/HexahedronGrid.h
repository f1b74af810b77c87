// A vtkHyperTreeGrid from hexahedra that are the leaves of octrees. Private to the module.
#pragma once

#include "HexahedronBlocks.h"

#include <vector>

class vtkHyperTreeGrid;

namespace treeamr
{

/// blocks: with cells, in any order; where several are at one place, the first is taken. grid: an empty one, which stays
/// so when all cells are left out. Beside input and output it takes 32 bytes a
/// cell, 64 when cells lie more than 21 levels below the padded root. Throws Error that names the first cell that is no
/// axis-aligned box or fits not the lattice of the largest ones, and cells that overlap.
void makeGrid(const std::vector<HexahedronBlock>& blocks, const BlockArrays& arrays, vtkHyperTreeGrid* grid);

} // namespace treeamr

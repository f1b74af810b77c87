// A vtkHyperTreeGrid from the blocks of block-structured AMR. Private to the module.
#pragma once

#include "AMRBlocks.h"

#include <vector>

class vtkHyperTreeGrid;

namespace treeamr
{

/// blocks: one or more. grid: an empty one, which stays so when all cells are left out. Beside input and output it takes
/// 32 bytes a leaf, 64 when cells lie more than 21 levels below the padded root. Returns the first block some cell of
/// which finer blocks cover in part, so that it is divided. Throws Error for a block that fits not the lattice of the
/// coarsest ones.
const AMRBlock* makeGrid(
  const std::vector<AMRBlock>& blocks, const BlockArrays& arrays, vtkHyperTreeGrid* grid);

} // namespace treeamr

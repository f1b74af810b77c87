// What the field in a box depends on beyond it: which other processes' cells one has to hold so that its values and
// vertex gradients are, bit for bit, those of all cells together.
//
// For every leaf that lies in the box, all of it or a part, or touches a lower face (where contours reach into it):
// - Its vertices take values from the cells around it: the leaves that touch it, and of larger refined ones the children
//   that do, each with all leaves below it (a mean).
// - Where a leaf, or a node around it, touches a larger leaf, vertices hang on that one's lattice. They are interpolated
//   between corners of that node, and these take values from the nodes of its size around it.
// - Beside a leaf that has a part in the box, other leaves of its parent that has a part beyond: a block is drawn as a whole.
// - Gradients are differences of the field one width away along each axis: the same holds for the leaves there, and, as
//   these may be missing, for those around that point.
#pragma once

#include "Octree/Octree.h"
#include "Partition/CellSet.h"
#include "Partition/LatticeBox.h"

#include <vector>

namespace treeamr
{

struct FieldSupport
{
  /// Outside the box: all leaves in these and around them are to be held.
  CellSet needed;
  /// Of these those of which it is not known whether there are leaves.
  CellSet unknown;
};

/// octree: of the leaves that meet the box and of those in and around the cells of `known`, so far. Ask again with the
/// unknown ones added to both until there are none; that takes two or three rounds, more where coarse leaves follow each
/// other.
FieldSupport findFieldSupport(const Octree& octree, const LatticeBox& box, const CellSet& known);

} // namespace treeamr

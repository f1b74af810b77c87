// Trees of a connectivity without vertices, laid out from face to face. Private to p4estTreeLattice().
//
// The first tree has its axes along those of the lattice. What is beyond a face of a tree that is placed is placed there,
// turned as the faces are joined, which the corners that both have tell before the file's word on the face. Faces in the
// direction of rising axes come first, those of trees that were placed first before others: so the first tree of a brick
// that is periodic stays at its origin.
#pragma once

#include "Forest/P4estForestFile.h"
#include "Forest/TreeLattice.h"

#include <array>
#include <vector>

namespace treeamr
{

struct TreeLayout
{
  std::array<int, 3> size; // of the lattice, in trees
  std::vector<std::array<int, 3>> places;
  std::vector<TreeOrientation> orientations;
};

/// Trees that are joined in another place than beside each other, but not turned, are so by a periodic boundary. Throws
/// Error naming the file and the first tree and face of trees that are joined turned in a ring, as in balls and shells,
/// and a tree that no face joins with the first.
TreeLayout layOutTrees(const P4estForestFile& file);

} // namespace treeamr

#include "Octree/Octree.h"

namespace treeamr
{

std::size_t Octree::byteSize() const noexcept
{
  return table_.byteSize() +
    (firstInner_.capacity() + ghosts_.capacity() + ghostsBelow_.capacity()) * sizeof(std::uint64_t);
}

} // namespace treeamr

#include "Octree/Octree.h"

namespace treeamr
{

std::size_t Octree::byteSize() const noexcept
{
  return nodes_.capacity() * sizeof(InnerNode) + bases_.capacity() * sizeof(Base) +
    firstInner_.capacity() * sizeof(std::uint64_t) + ghost_.capacity() / 8;
}

} // namespace treeamr

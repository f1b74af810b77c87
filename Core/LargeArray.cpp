#include "LargeArray.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace treeamr
{

void* allocateLarge(std::size_t bytes)
{
  void* const memory = ::operator new(bytes, std::align_val_t(largePage));
#ifdef __linux__
  // An advice: where it is refused, nothing is lost.
  madvise(memory, bytes / largePage * largePage, MADV_HUGEPAGE);
#endif
  return memory;
}

void releaseLarge(void* memory, std::size_t bytes) noexcept
{
#ifdef __linux__
  madvise(memory, bytes / largePage * largePage, MADV_DONTNEED);
#endif
  static_cast<void>(bytes);
  ::operator delete(memory, std::align_val_t(largePage));
}

} // namespace treeamr

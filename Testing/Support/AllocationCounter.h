// Counts the bytes that a test program allocates with new, from all threads. To be included by one source of
// the program: it replaces the global operators.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace treeamr::test
{

inline std::atomic<std::size_t> allocatedBytes{ 0 };
inline std::atomic<std::size_t> mostAllocatedBytes{ 0 };

/// The most that `work` holds at any time beyond what was there before.
template <class Work>
std::size_t peakBytes(const Work& work)
{
  const std::size_t before = allocatedBytes;
  mostAllocatedBytes = before;
  work();
  return mostAllocatedBytes - before;
}

} // namespace treeamr::test

// In front of each block, as many bytes as keep its alignment: the block's size.

void* operator new(std::size_t size)
{
  using namespace treeamr::test;
  auto* const header = static_cast<std::max_align_t*>(std::malloc(sizeof(std::max_align_t) + size));
  if (!header)
  {
    throw std::bad_alloc();
  }
  ::new (header) std::size_t(size);
  const std::size_t now = allocatedBytes += size;
  for (std::size_t most = mostAllocatedBytes;
       most < now && !mostAllocatedBytes.compare_exchange_weak(most, now);)
  {
  }
  return header + 1;
}

void operator delete(void* pointer) noexcept
{
  if (pointer)
  {
    auto* const header = static_cast<std::max_align_t*>(pointer) - 1;
    treeamr::test::allocatedBytes -= *reinterpret_cast<std::size_t*>(header);
    std::free(header);
  }
}

void operator delete(void* pointer, std::size_t /*size*/) noexcept
{
  operator delete(pointer);
}

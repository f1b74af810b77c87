// Counts the bytes that a test program allocates with new, from all threads. To be included by one source of
// the program: it replaces the global operators.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace treeamr::test
{

inline std::atomic<std::size_t> allocatedBytes{ 0 };
inline std::atomic<std::size_t> mostAllocatedBytes{ 0 };
/// The greatest block so far that does not begin on a page of 2 MiB.
inline std::atomic<std::size_t> greatestOnSmallPages{ 0 };

inline void raise(std::atomic<std::size_t>& most, std::size_t value)
{
  for (std::size_t known = most; known < value && !most.compare_exchange_weak(known, value);)
  {
  }
}

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

// In front of each block, as many bytes as keep its alignment; the last of them hold the block's size.

void* operator new(std::size_t size, std::align_val_t alignment)
{
  using namespace treeamr::test;
  const std::size_t front = std::max(static_cast<std::size_t>(alignment), alignof(std::max_align_t));
  // A multiple of the alignment, as the C standard asks.
  // Sanitizers end a program that asks for more than there can be.
  constexpr std::size_t tooMuch = std::size_t(1) << 39;
  auto* const block = size < tooMuch
    ? static_cast<std::byte*>(std::aligned_alloc(front, (size + 2 * front - 1) / front * front))
    : nullptr;
  if (!block)
  {
    throw std::bad_alloc();
  }
  ::new (block + front - sizeof(std::size_t)) std::size_t(size);
  raise(mostAllocatedBytes, allocatedBytes += size);
  if (static_cast<std::size_t>(alignment) < std::size_t(1) << 21)
  {
    raise(greatestOnSmallPages, size);
  }
  return block + front;
}

void* operator new(std::size_t size)
{
  return operator new(size, std::align_val_t(alignof(std::max_align_t)));
}

/// Sanitizers have one of their own, which does not call the others.
void* operator new(std::size_t size, const std::nothrow_t& /*unused*/) noexcept
{
  try
  {
    return operator new(size);
  }
  catch (const std::bad_alloc&)
  {
    return nullptr;
  }
}

// Inlined, it would look to the compiler as if it read in front of the caller's block.
[[gnu::noinline]] void operator delete(void* pointer, std::align_val_t alignment) noexcept
{
  if (pointer)
  {
    const std::size_t front = std::max(static_cast<std::size_t>(alignment), alignof(std::max_align_t));
    auto* const bytes = static_cast<std::byte*>(pointer);
    treeamr::test::allocatedBytes -= *reinterpret_cast<std::size_t*>(bytes - sizeof(std::size_t));
    std::free(bytes - front);
  }
}

void operator delete(void* pointer) noexcept
{
  operator delete(pointer, std::align_val_t(alignof(std::max_align_t)));
}

void operator delete(void* pointer, std::size_t /*size*/) noexcept
{
  operator delete(pointer);
}

void operator delete(void* pointer, std::size_t /*size*/, std::align_val_t alignment) noexcept
{
  operator delete(pointer, alignment);
}

// Arrays of megabytes on large pages: one page fault for 2 MiB in place of 512 of them, which took from a third to
// half of the time of reading and building large octrees.
//
// Only whole large pages are asked for, so nothing takes more memory than it fills, and small arrays are those of
// operator new. The system may say no (transparent huge pages "never"): pages are small then.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <vector>

namespace treeamr
{

/// Bytes of a large page, and of the least array that is worth some.
constexpr std::size_t largePage = std::size_t(1) << 21;
constexpr std::size_t largeArrayBytes = 2 * largePage;

/// From operator new, on large pages; bytes: largeArrayBytes or more. Throws std::bad_alloc.
void* allocateLarge(std::size_t bytes);
/// The pages of so many bytes go back to the system, wherever operator new has found them: C's library keeps those between
/// others' blocks. 0 where nobody knows how many they are.
void releaseLarge(void* memory, std::size_t bytes) noexcept;

/// As std::allocator, for arrays that may be large.
template <class T>
struct LargeAllocator
{
  static_assert(alignof(T) <= largePage);
  using value_type = T;

  LargeAllocator() noexcept = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&) noexcept
  {
  }
  T* allocate(std::size_t count)
  {
    return isLarge(count) ? static_cast<T*>(allocateLarge(count * sizeof(T)))
                          : std::allocator<T>().allocate(count);
  }
  void deallocate(T* memory, std::size_t count) noexcept
  {
    isLarge(count) ? releaseLarge(memory, count * sizeof(T)) : std::allocator<T>().deallocate(memory, count);
  }
  bool operator==(const LargeAllocator&) const noexcept { return true; }

private:
  /// More than memory can address is for std::allocator to refuse.
  static constexpr bool isLarge(std::size_t count) noexcept
  {
    return count >= (largeArrayBytes + sizeof(T) - 1) / sizeof(T) &&
      count <= std::numeric_limits<std::ptrdiff_t>::max() / sizeof(T);
  }
};

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

template <class T>
struct LargeArrayDelete
{
  std::size_t count = 0;
  void operator()(T* memory) const noexcept { LargeAllocator<T>().deallocate(memory, count); }
};
/// As long as it was made, for records that need no construction.
template <class T>
using LargeArray = std::unique_ptr<T[], LargeArrayDelete<T>>;

/// Its values are undefined.
template <class T>
LargeArray<T> makeLargeArray(std::size_t count)
{
  static_assert(std::is_trivially_default_constructible_v<T> && std::is_trivially_destructible_v<T>);
  T* const memory = LargeAllocator<T>().allocate(count);
  std::uninitialized_default_construct_n(memory, count);
  return LargeArray<T>(memory, { count });
}

} // namespace treeamr

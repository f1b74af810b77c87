// A hint to the processor.
#pragma once

namespace treeamr
{

/// Announces that the memory at an address will be read.
inline void prefetch(const void* address) noexcept
{
#if defined(__GNUC__)
  __builtin_prefetch(address);
#else
  static_cast<void>(address);
#endif
}

} // namespace treeamr

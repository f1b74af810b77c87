#include "FuzzInput.h"

#include "Support/ForestBytes.h"

#include "vtkObject.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>

// sanitizer/allocator_interface.h: there is none without a sanitizer.
extern "C" [[gnu::weak]] int __sanitizer_install_malloc_and_free_hooks(
  void (*mallocHook)(const volatile void*, std::size_t), void (*freeHook)(const volatile void*));
extern "C" [[gnu::weak]] std::size_t __sanitizer_get_allocated_size(const volatile void* block);

// Bad input is told in messages, thousands a second.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/)
{
  vtkObject::GlobalWarningDisplayOff();
  return 0;
}

namespace treeamr::fuzz
{

namespace
{

std::atomic<bool> isWatching = false;
std::atomic<std::size_t> mostBytes = 0; // of a block
std::atomic<std::int64_t> mostInAll = 0;
std::atomic<std::int64_t> inAll = 0; // since the watch began

void addBlock(const volatile void* /*block*/, std::size_t bytes)
{
  if (!isWatching)
  {
    return;
  }
  const std::int64_t now = inAll += static_cast<std::int64_t>(bytes);
  if (bytes > mostBytes || now > mostInAll)
  {
    isWatching = false; // what reports it may ask for more
    std::fprintf(stderr, "a block of %zu bytes, %lld in all\n", bytes, static_cast<long long>(now));
    std::abort();
  }
}

void removeBlock(const volatile void* block)
{
  if (isWatching && block)
  {
    inAll -= static_cast<std::int64_t>(__sanitizer_get_allocated_size(block));
  }
}

} // namespace

std::string writeFiles(std::initializer_list<std::pair<std::string, Bytes>> files)
{
  static const test::TemporaryFolder folder;
  for (const auto& [name, bytes] : files)
  {
    std::ofstream(folder.file(name), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data), static_cast<std::streamsize>(bytes.size));
  }
  return folder.file("");
}

HeapWatch::HeapWatch(std::size_t inputBytes, std::size_t meant)
{
  static const bool isInstalled = __sanitizer_install_malloc_and_free_hooks &&
    __sanitizer_install_malloc_and_free_hooks(addBlock, removeBlock) != 0;
  (void)isInstalled;
  mostBytes = 4 * inputBytes + ofAnyInput + meant;
  mostInAll = static_cast<std::int64_t>(ofEachByte * inputBytes + ofAnyInputInAll + 4 * meant);
  inAll = 0;
  isWatching = true;
}

HeapWatch::~HeapWatch()
{
  isWatching = false;
}

void require(bool holds, const char* what)
{
  if (!holds)
  {
    std::fprintf(stderr, "not so: %s\n", what);
    std::abort();
  }
}

} // namespace treeamr::fuzz

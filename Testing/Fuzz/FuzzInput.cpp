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

std::atomic<std::size_t> mostBytes = SIZE_MAX; // of a block

void checkBlock(const volatile void* /*block*/, std::size_t bytes)
{
  if (bytes > mostBytes)
  {
    mostBytes = SIZE_MAX; // what reports it may ask for more
    std::fprintf(stderr, "a block of %zu bytes\n", bytes);
    std::abort();
  }
}

void ignoreBlock(const volatile void* /*block*/) {}

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

HeapWatch::HeapWatch(std::size_t inputBytes)
{
  static const bool isInstalled = __sanitizer_install_malloc_and_free_hooks &&
    __sanitizer_install_malloc_and_free_hooks(checkBlock, ignoreBlock) != 0;
  (void)isInstalled;
  mostBytes = 4 * inputBytes + ofAnyInput;
}

HeapWatch::~HeapWatch()
{
  mostBytes = SIZE_MAX;
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

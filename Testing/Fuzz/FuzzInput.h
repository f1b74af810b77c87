// What the fuzz targets share: inputs as files, and a watch on what is asked of the heap.
//
// A target is one source that defines LLVMFuzzerTestOneInput (LLVM, libFuzzer). Linked with libFuzzer it searches for
// inputs; with other compilers Replay.cpp plays a corpus and inputs made from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

namespace treeamr::fuzz
{

struct Bytes
{
  const std::uint8_t* data;
  std::size_t size;

  /// The first of them, fewer where there are not as many; the rest is left.
  Bytes take(std::size_t count)
  {
    const Bytes taken{ data, count < size ? count : size };
    data += taken.size;
    size -= taken.size;
    return taken;
  }
  /// 0 at the end.
  std::uint8_t takeByte() { return size > 0 ? *take(1).data : std::uint8_t(0); }
};

/// A folder of this process with files of these names and contents, instead of those of the call before; its path.
std::string writeFiles(std::initializer_list<std::pair<std::string, Bytes>> files);

/// Under a sanitizer: ends the process when during its life a block of more than four times the input and `ofAnyInput` is asked
/// for, or all there are together take more than `ofEachByte` times the input and `ofAnyInputInAll`.
class HeapWatch
{
public:
  /// meant: bytes that the input stands for beside its own, such as planes between roots that it puts far apart.
  explicit HeapWatch(std::size_t inputBytes, std::size_t meant = 0);
  ~HeapWatch();
  HeapWatch(const HeapWatch&) = delete;
  HeapWatch& operator=(const HeapWatch&) = delete;

  /// Buffers of streams, of what is counted for parts of a loop.
  static constexpr std::size_t ofAnyInput = std::size_t(1) << 18;
  static constexpr std::size_t ofAnyInputInAll = std::size_t(1) << 20;
  static constexpr std::size_t ofEachByte = 16;
};

/// Ends the process, naming what does not hold.
void require(bool holds, const char* what);

} // namespace treeamr::fuzz

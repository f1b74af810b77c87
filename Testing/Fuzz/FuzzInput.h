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

/// Under a sanitizer: ends the process when during its life a single block larger than four times the input, and than
/// what readers allocate for any input, is asked for.
class HeapWatch
{
public:
  explicit HeapWatch(std::size_t inputBytes);
  ~HeapWatch();
  HeapWatch(const HeapWatch&) = delete;
  HeapWatch& operator=(const HeapWatch&) = delete;

  /// A lattice's planes, of up to 2^20 roots along an axis and twice that while it grows.
  static constexpr std::size_t ofAnyInput = std::size_t(1) << 25;
};

/// Ends the process, naming what does not hold.
void require(bool holds, const char* what);

} // namespace treeamr::fuzz

// Bytes in a file beside a forest, equally many for each quadrant in the forest's order.
#pragma once

#include "Error.h"
#include "Forest/P4estInputFile.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace treeamr
{

class QuadrantRecords
{
public:
  /// begin: in the file, bytes. recordBytes: not 0.
  QuadrantRecords(std::string path, std::uint64_t begin, std::size_t recordBytes)
    : path_(std::move(path))
    , begin_(begin)
    , recordBytes_(recordBytes)
  {
  }

  std::size_t recordBytes() const noexcept { return recordBytes_; }
  /// Those of quadrants from `first` on, one after the other, on any number of threads at once. Throws Error where the
  /// file ends before.
  void read(std::uint64_t first, std::uint64_t count, std::byte* bytes) const
  {
    std::ifstream stream(path_, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(begin_ + first * recordBytes_));
    if (!stream.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(count * recordBytes_)))
    {
      throw Error(
        path_ + ": values of quadrant " + std::to_string(first) + " and those after it cannot be read");
    }
  }
  /// Calls visit(bytes) for each of them, reading by blocks.
  template <class Visit>
  void visit(std::uint64_t first, std::uint64_t count, const Visit& visit) const
  {
    const std::uint64_t most = std::max<std::uint64_t>(1, P4estInputFile::blockBytes / recordBytes_);
    std::vector<std::byte> block;
    for (const std::uint64_t end = first + count; first < end; first += std::min(most, end - first))
    {
      block.resize(std::min(most, end - first) * recordBytes_);
      read(first, block.size() / recordBytes_, block.data());
      for (const std::byte* record = block.data(); record != block.data() + block.size();
           record += recordBytes_)
      {
        visit(record);
      }
    }
  }

private:
  std::string path_;
  std::uint64_t begin_;
  std::size_t recordBytes_;
};

} // namespace treeamr

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
  QuadrantRecords(std::string path, std::uint64_t begin, std::size_t recordBytes, std::uint64_t quadrants)
    : path_(std::move(path))
    , begin_(begin)
    , recordBytes_(recordBytes)
    , quadrants_(quadrants)
    , stream_(path_, std::ios::binary)
  {
  }

  /// The bytes of a quadrant, until the next call. Quickest in the order of numbers. Throws Error where the file ends
  /// before.
  const std::byte* at(std::uint64_t quadrant)
  {
    if (quadrant < blockBegin_ || quadrant >= blockEnd_)
    {
      readBlock(quadrant);
    }
    return block_.data() + (quadrant - blockBegin_) * recordBytes_;
  }

private:
  void readBlock(std::uint64_t quadrant)
  {
    const std::uint64_t count = std::min<std::uint64_t>(
      quadrants_ - quadrant, std::max<std::uint64_t>(1, P4estInputFile::blockBytes / recordBytes_));
    block_.resize(count * recordBytes_);
    blockBegin_ = quadrant;
    blockEnd_ = quadrant + count;
    stream_.seekg(static_cast<std::streamoff>(begin_ + quadrant * recordBytes_));
    if (!stream_.read(reinterpret_cast<char*>(block_.data()), static_cast<std::streamsize>(block_.size())))
    {
      throw Error(
        path_ + ": values of quadrant " + std::to_string(quadrant) + " and those after it cannot be read");
    }
  }

  std::string path_;
  std::uint64_t begin_;
  std::size_t recordBytes_;
  std::uint64_t quadrants_;
  std::ifstream stream_;
  std::vector<std::byte> block_;
  std::uint64_t blockBegin_ = 0; // quadrants
  std::uint64_t blockEnd_ = 0;
};

} // namespace treeamr

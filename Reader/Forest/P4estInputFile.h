// Sequential reading of a file of a forest, with errors that name it. Private to Reader/Forest.
#pragma once

#include "Error.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace treeamr
{

class P4estInputFile
{
public:
  static constexpr std::size_t blockBytes = std::size_t(1) << 20;

  /// allowed: what it should be, for messages.
  explicit P4estInputFile(const std::string& path, std::string_view allowed = "a forest saved by p8est_save")
    : path_(path)
  {
    std::error_code code;
    const auto status = std::filesystem::status(path, code);
    if (!std::filesystem::exists(status))
    {
      fail("no such file");
    }
    if (!std::filesystem::is_regular_file(status))
    {
      fail(
        std::filesystem::is_directory(status) ? "a directory" : "not a regular file", ", allowed ", allowed);
    }
    size_ = std::filesystem::file_size(path, code);
    stream_.rdbuf()->pubsetbuf(nullptr, 0); // or a quadrant here and there costs 8 KiB each
    stream_.open(path, std::ios::binary);
    if (code || !stream_)
    {
      fail("cannot be opened for reading");
    }
  }

  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }

  template <class... Parts>
  [[noreturn]] void fail(const Parts&... parts) const
  {
    std::ostringstream message;
    message << path_ << ": ";
    (message << ... << parts);
    throw Error(message.str());
  }

  void seek(std::uint64_t position)
  {
    stream_.seekg(static_cast<std::streamoff>(position));
    position_ = position;
  }

  void read(void* to, std::size_t bytes, std::string_view section)
  {
    if (!stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)))
    {
      fail(section, ": ", bytes, " bytes cannot be read at offset ", position_, " of ", size_);
    }
    position_ += bytes;
  }

  /// Reads `count` numbers by blocks and hands over each with its place in the table.
  template <class T, class Visit>
  void readEach(std::uint64_t count, std::string_view section, Visit&& visit)
  {
    std::vector<T> block(std::min<std::uint64_t>(count, blockBytes / sizeof(T)));
    for (std::uint64_t first = 0; first < count; first += block.size())
    {
      const std::size_t n = std::min<std::uint64_t>(block.size(), count - first);
      read(block.data(), n * sizeof(T), section);
      for (std::size_t i = 0; i < n; ++i)
      {
        visit(first + i, block[i]);
      }
    }
  }

  /// Visits all records of a table at an offset or, when these are more than `count`, about as many in blocks spread over it.
  template <class Visit>
  void sampleRecords(std::uint64_t offset, std::size_t recordBytes, std::uint64_t records,
    std::uint64_t count, std::string_view section, const Visit& visit)
  {
    const bool all = records <= count;
    const std::uint64_t blocks = all ? 1 : 64;
    const std::uint64_t blockRecords = all ? records : count / blocks;
    std::vector<std::byte> block(blockRecords * recordBytes);
    for (std::uint64_t b = 0; b < blocks; ++b)
    {
      seek(offset + b * ((records - blockRecords) / blocks) * recordBytes);
      read(block.data(), block.size(), section);
      for (std::uint64_t i = 0; i < blockRecords; ++i)
      {
        visit(block.data() + i * recordBytes);
      }
    }
  }

  /// Reads a table of indices and checks that each lies in [min, end).
  template <class T, class Keep>
  void checkTable(
    std::uint64_t count, std::int64_t min, std::int64_t end, std::string_view section, const Keep& keep)
  {
    readEach<T>(count, section, [&](std::uint64_t i, T value) {
      if (value < min || value >= end)
      {
        fail("connectivity, ", section, ", entry ", i, ": ", std::int64_t(value), ", allowed ", min, "..",
          end - 1);
      }
      keep(i, value);
    });
  }
  template <class T>
  void checkTable(std::uint64_t count, std::int64_t min, std::int64_t end, std::string_view section)
  {
    checkTable<T>(count, min, end, section, [](std::uint64_t, T) {});
  }

  /// Reads the offsets of `items` into a table of `entries`: from 0 up to `entries`, never down.
  void checkOffsets(std::uint64_t items, std::int64_t entries, std::string_view section)
  {
    std::int64_t previous = 0;
    readEach<std::int32_t>(items + 1, section, [&](std::uint64_t i, std::int32_t value) {
      const std::int64_t min = i == items ? entries : previous;
      const std::int64_t max = i == 0 ? 0 : entries;
      if (value < min || value > max)
      {
        fail("connectivity, ", section, ", entry ", i, ": ", value, ", allowed ", min, "..", max);
      }
      previous = value;
    });
  }

private:
  std::string path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

} // namespace treeamr

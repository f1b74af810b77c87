// Saved forests as bytes, to spoil or to compose: an own reading of the layout, so that the parser is not
// tested against itself. 3-D files, in the byte order of this machine.
#pragma once

#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace treeamr::test
{

using Bytes = std::vector<std::byte>;

/// A folder of its own that goes with its owner.
class TemporaryFolder
{
public:
  TemporaryFolder()
  {
    std::string name = (std::filesystem::temp_directory_path() / "treeamr-XXXXXX").string();
    if (!mkdtemp(name.data()))
    {
      throw std::runtime_error("no temporary folder " + name);
    }
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

private:
  std::filesystem::path path_;
};

inline Bytes readBytes(const std::string& path)
{
  Bytes bytes(std::filesystem::file_size(path));
  std::ifstream(path, std::ios::binary)
    .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

inline void writeBytes(const std::string& path, const Bytes& bytes)
{
  std::ofstream(path, std::ios::binary)
    .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

template <class T>
T getAt(const Bytes& bytes, std::size_t offset)
{
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <class T>
void putAt(Bytes& bytes, std::size_t offset, const T& value)
{
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

template <class T>
void append(Bytes& bytes, const T& value)
{
  bytes.resize(bytes.size() + sizeof(T));
  putAt(bytes, bytes.size() - sizeof(T), value);
}

inline void padTo32(Bytes& bytes)
{
  bytes.resize((bytes.size() + 31) / 32 * 32);
}

/// Offsets of the sections.
struct ForestSections
{
  static constexpr std::size_t connectivityCounts = 32; // ten uint64
  static constexpr std::size_t connectivityBody = 112;
  std::size_t connectivityEnd = 0;
  std::size_t forestHeader = 0; // six uint64
  std::size_t partition = 0;
  std::size_t treeEnds = 0;
  std::size_t treeEndsEnd = 0;
  std::size_t quadrants = 0;
  std::size_t end = 0;
  std::size_t recordBytes = 0;
};

inline ForestSections findSections(const Bytes& bytes)
{
  std::array<std::uint64_t, 10> n;
  std::memcpy(n.data(), bytes.data() + ForestSections::connectivityCounts, sizeof(n));
  const std::size_t vertices = n[2], trees = n[3], edges = n[4], ett = n[5], corners = n[6], ctt = n[7],
                    attr = n[8];
  ForestSections s;
  s.connectivityEnd = s.connectivityBody + vertices * 24 + (edges ? trees * 48 : 0) +
    (vertices ? trees * 32 : 0) + (corners ? trees * 32 : 0) + trees * 24 + trees * 6 + trees * attr +
    (edges + 1) * 4 + ett * 5 + (corners + 1) * 4 + ctt * 5;
  s.forestHeader = (s.connectivityEnd + 31) / 32 * 32;
  s.partition = s.forestHeader + 48;
  s.treeEnds = s.partition + 8 * getAt<std::uint64_t>(bytes, s.forestHeader + 40);
  s.treeEndsEnd = s.treeEnds + 8 * trees;
  s.quadrants = (s.treeEndsEnd + 31) / 32 * 32;
  s.recordBytes = 16 + getAt<std::uint64_t>(bytes, s.forestHeader + 24);
  s.end = s.quadrants + getAt<std::uint64_t>(bytes, s.treeEndsEnd - 8) * s.recordBytes;
  return s;
}

/// x, y, z, level as they are stored.
using RawQuadrant = std::array<std::int32_t, 4>;

/// The file with another partition, other quadrants in its trees and no payload.
inline Bytes withQuadrants(const Bytes& bytes, const std::vector<std::uint64_t>& rankEnds,
  const std::vector<std::uint64_t>& treeEnds, const std::vector<RawQuadrant>& quadrants)
{
  const ForestSections s = findSections(bytes);
  Bytes result(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(s.partition));
  putAt<std::uint64_t>(result, s.forestHeader + 24, 0);
  putAt<std::uint64_t>(result, s.forestHeader + 32, 0);
  putAt<std::uint64_t>(result, s.forestHeader + 40, rankEnds.size());
  for (const std::uint64_t end : rankEnds)
  {
    append(result, end);
  }
  for (const std::uint64_t end : treeEnds)
  {
    append(result, end);
  }
  padTo32(result);
  for (const RawQuadrant& quadrant : quadrants)
  {
    append(result, quadrant);
  }
  return result;
}

} // namespace treeamr::test

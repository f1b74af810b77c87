// What deal.II's parallel::distributed::Triangulation::save writes beside a forest (versions 4 and 5 of the format: deal.II
// 9.2 to 9.8), in the byte order of the machine that wrote it:
//   NAME                a forest without data (P4estForestFile.h), whose trees are the coarse cells
//   NAME.info           text: a line of names, then the version, the number of ranks, how many blocks of fixed and of variable
//                       size are attached to each cell, and the number of coarse cells
//   NAME_fixed.data     where anything is attached: uint32 ends of a cell's status and of each block of fixed size, the last
//                       of which, when there are blocks of variable size, has the ends of those; then the bytes of each
//                       cell, in the forest's order
//   NAME_variable.data  is not read
// What the blocks are only the program knew (DealIIBlocks.h).
#pragma once

#include "Forest/P4estForestFile.h"
#include "Forest/QuadrantRecords.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace treeamr
{

/// NAME.info.
struct DealIIInfo
{
  std::string path;
  std::string base; // NAME
  std::uint32_t fixedBlocks = 0;
  std::uint32_t variableBlocks = 0;
  std::uint32_t coarseCells = 0;

  /// Whether a file begins as one.
  static bool isOne(const std::string& path) noexcept;
  /// Of a checkpoint that is named by NAME.info or by NAME; nothing when there is none.
  static std::optional<std::string> pathOf(const std::string& path);

  /// Throws Error naming the file, what was found and what is allowed, also when NAME is not there.
  static DealIIInfo read(const std::string& path);
  /// That of pathOf().
  static std::optional<DealIIInfo> find(const std::string& path);

  static constexpr std::uint32_t maxBlocks = 1u << 16;
};

/// NAME_fixed.data.
class DealIICellData
{
public:
  struct Block
  {
    std::size_t offset; // bytes from a cell's begin
    std::size_t size;
  };

  /// Reads and checks all but the cells, and that these fill the file. Throws Error naming the file, the section, what was
  /// found and what is allowed, also when info and forest do not belong together.
  DealIICellData(const DealIIInfo& info, const P4estForestFile& forest);

  const std::string& path() const noexcept { return path_; }
  /// Those of fixed size; may be none.
  const std::vector<Block>& blocks() const noexcept { return blocks_; }

  /// Visits the bytes of all cells or, when these are more than `count` or than a few MiB, of fewer in parts spread over
  /// the file.
  void sample(std::uint64_t count, const std::function<void(const std::byte*)>& visit) const;
  /// All cells' bytes.
  QuadrantRecords records() const { return { path_, cellsOffset_, cellBytes_ }; }
  /// Throws Error for a cell that deal.II did not save as it is.
  void checkStatus(std::uint64_t cell, const std::byte* bytes) const;

private:
  std::string path_;
  std::vector<Block> blocks_;
  std::uint64_t cellCount_ = 0;
  std::size_t cellBytes_ = 0; // 0 when there is no file
  std::uint64_t cellsOffset_ = 0;
};

} // namespace treeamr

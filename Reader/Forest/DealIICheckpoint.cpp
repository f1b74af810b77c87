#include "Forest/DealIICheckpoint.h"

#include "Forest/P4estInputFile.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>

namespace treeamr
{
namespace
{

constexpr std::string_view infoStart = "version nproc n_attached_fixed_size_objs";
constexpr std::string_view infoExtension = ".info";
constexpr std::size_t statusBytes = sizeof(std::uint32_t);

/// Of any section; the bytes of a cell are not asked for before the file is known to fill them.
using Number = std::uint32_t;

std::string shortened(const std::string& text)
{
  constexpr std::size_t most = 60;
  return text.size() > most ? text.substr(0, most) + "..." : text;
}

/// The start of a small file.
std::string readText(const P4estInputFile& file, const std::string& path)
{
  constexpr std::size_t most = 4096;
  std::string text(std::min<std::uint64_t>(file.size(), most), '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

} // namespace

bool DealIIInfo::isOne(const std::string& path) noexcept
{
  try
  {
    std::array<char, infoStart.size()> start{};
    std::ifstream stream(path, std::ios::binary);
    return stream.read(start.data(), start.size()) &&
      std::string_view(start.data(), start.size()) == infoStart;
  }
  catch (const std::exception&)
  {
    return false;
  }
}

std::optional<std::string> DealIIInfo::pathOf(const std::string& path)
{
  for (const std::string& candidate : { path, path + std::string(infoExtension) })
  {
    if (isOne(candidate))
    {
      return candidate;
    }
  }
  return {};
}

DealIIInfo DealIIInfo::read(const std::string& path)
{
  const P4estInputFile file(path, "NAME.info of deal.II");
  DealIIInfo info;
  info.path = path;
  if (!path.ends_with(infoExtension))
  {
    file.fail("deal.II's NAME.info by another name, allowed NAME.info with the forest NAME beside it");
  }
  info.base = path.substr(0, path.size() - infoExtension.size());

  std::istringstream text(readText(file, path));
  std::string names;
  std::getline(text, names);
  if (!names.starts_with(infoStart))
  {
    file.fail("begins with \"", shortened(names), "\", allowed \"", infoStart, " ...\"");
  }
  while (!names.empty() && (names.back() == ' ' || names.back() == '\r'))
  {
    names.pop_back();
  }
  if (!names.ends_with(" n_coarse_cells"))
  {
    file.fail("its first line ends in \"", shortened(names.substr(names.rfind(' ') + 1)),
      "\", allowed n_coarse_cells, of a parallel::distributed::Triangulation: other kinds have no forest");
  }
  std::array<Number, 5> numbers{};
  constexpr std::array<const char*, numbers.size()> meanings = { "the version", "the number of ranks",
    "the number of blocks of fixed size", "the number of blocks of variable size",
    "the number of coarse cells" };
  for (std::size_t i = 0; i < numbers.size(); ++i)
  {
    std::string word;
    text >> word;
    std::istringstream digits(word);
    if (word.empty() || word.find_first_not_of("0123456789") != word.npos || !(digits >> numbers[i]))
    {
      file.fail(meanings[i], ": \"", shortened(word), "\", allowed a number below 2^32");
    }
  }
  if (numbers[0] < 4 || numbers[0] > 5)
  {
    file.fail("version ", numbers[0], ", allowed 4 and 5");
  }
  for (const std::size_t i : { 2, 3 })
  {
    if (numbers[i] > maxBlocks)
    {
      file.fail(meanings[i], ": ", numbers[i], ", allowed at most ", maxBlocks);
    }
  }
  info.fixedBlocks = numbers[2];
  info.variableBlocks = numbers[3];
  info.coarseCells = numbers[4];
  std::error_code ignored;
  if (!std::filesystem::exists(info.base, ignored))
  {
    file.fail("the forest ", info.base, " is not beside it");
  }
  return info;
}

std::optional<DealIIInfo> DealIIInfo::find(const std::string& path)
{
  const std::optional<std::string> found = pathOf(path);
  return found ? std::optional(read(*found)) : std::nullopt;
}

DealIICellData::DealIICellData(const DealIIInfo& info, const P4estForestFile& forest)
  : path_(info.base + "_fixed.data")
  , cellCount_(forest.quadrantCount())
{
  const P4estInputFile infoFile(info.path);
  if (info.coarseCells != static_cast<std::uint32_t>(forest.treeCount()))
  {
    infoFile.fail(info.coarseCells, " coarse cells, allowed ", forest.treeCount(),
      ", the trees of the forest beside it: they are not of one checkpoint");
  }
  if (info.fixedBlocks == 0 && info.variableBlocks == 0)
  {
    return;
  }
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored))
  {
    infoFile.fail(
      info.fixedBlocks, " blocks are attached to each cell, but ", path_, " is not beside it to hold them");
  }
  P4estInputFile file(path_, "NAME_fixed.data of deal.II");
  const std::uint64_t ends = std::uint64_t(1) + info.fixedBlocks + (info.variableBlocks > 0 ? 1 : 0);
  cellsOffset_ = ends * sizeof(Number);
  if (cellsOffset_ > file.size())
  {
    file.fail("header: ", file.size(), " bytes, allowed at least ", cellsOffset_, ", for ", ends,
      " sizes as its .info says");
  }
  std::uint64_t previous = 0;
  file.readEach<Number>(ends, "header", [&](std::uint64_t i, Number end) {
    if (i == 0 && end != statusBytes)
    {
      file.fail("header: ", end, " bytes for a cell's status, allowed ", statusBytes,
        ": no data of deal.II, or of a machine of another byte order");
    }
    if (end < previous)
    {
      file.fail("header: block ", i, " of a cell ends at ", end, ", allowed at least ", previous,
        ", where the one before does");
    }
    if (i > 0 && i <= info.fixedBlocks)
    {
      blocks_.push_back({ previous, end - previous });
    }
    else if (i > 0 && end - previous != sizeof(Number) * info.variableBlocks)
    {
      file.fail("header: ", end - previous, " bytes of a cell for the ends of ", info.variableBlocks,
        " blocks of variable size, allowed ", sizeof(Number) * info.variableBlocks);
    }
    previous = end;
  });
  cellBytes_ = previous;
  if (cellCount_ > (file.size() - cellsOffset_) / cellBytes_ ||
    cellsOffset_ + cellCount_ * cellBytes_ != file.size())
  {
    file.fail("cells: ", file.size() - cellsOffset_, " bytes behind the header, allowed ", cellBytes_,
      " for each of the forest's ", cellCount_, " cells");
  }
}

void DealIICellData::sample(std::uint64_t count, const std::function<void(const std::byte*)>& visit) const
{
  constexpr std::uint64_t mostBytes = std::uint64_t(8) << 20;
  constexpr std::uint64_t fewest = 64;
  P4estInputFile(path_).sampleRecords(cellsOffset_, cellBytes_, cellCount_,
    std::clamp(mostBytes / cellBytes_, fewest, std::max(fewest, count)), "cells", visit);
}

void DealIICellData::checkStatus(std::uint64_t cell, const std::byte* bytes) const
{
  std::uint32_t status;
  static_assert(sizeof(status) == statusBytes);
  std::memcpy(&status, bytes, sizeof(status));
  if (status != 0)
  {
    P4estInputFile(path_).fail(
      "cell ", cell, ": status ", status, ", allowed 0, of cells that stay as they are");
  }
}

} // namespace treeamr

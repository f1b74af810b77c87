// A forest and what there is for each of its quadrants: payloads in its own file, or what deal.II attached to cells, beside it.
#pragma once

#include "Forest/DealIICheckpoint.h"
#include "Forest/P4estForestFile.h"
#include "Forest/PayloadLayout.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace treeamr
{

/// What a quadrant's bytes are read as, and what the user should know of it.
struct PayloadReading
{
  std::vector<PayloadField> fields;
  std::string remark;
};

class ForestInput
{
public:
  /// path: of a saved forest, or of deal.II's NAME.info beside one. Throws Error for bad files.
  explicit ForestInput(const std::string& path);

  /// Whether the file starts as one of these.
  static bool canRead(const std::string& path) noexcept;
  /// Those of a text, which need not be right for the file. Throws Error for a text that is wrong by itself.
  static std::vector<PayloadField> fieldsOf(const std::string& path, const std::string& text);

  const P4estForestFile& forest() const noexcept { return forest_; }
  /// text: what the bytes are (PayloadLayout.h, or DealIIBlocks.h for deal.II's), or empty: what looks like doubles is read.
  /// Throws Error for one that is wrong, or not of as many bytes as the file has.
  PayloadReading readPayload(const std::string& text) const;
  /// As P4estForestFile. withPayload: whether leaves have theirs, which takes time where it is in a file of its own.
  void readQuadrants(bool withPayload, std::span<const LeafRange> ranges, LeafBlock& block) const;
  std::uint64_t blockQuadrants() const noexcept;

private:
  explicit ForestInput(const std::string& path, std::optional<DealIIInfo> info);
  PayloadReading readBlocks(const std::string& text) const;
  PayloadReading guessBlocks() const;

  std::optional<DealIIInfo> info_;
  P4estForestFile forest_;
  std::optional<DealIICellData> cells_;
};

} // namespace treeamr
